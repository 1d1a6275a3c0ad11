//! What would run, and in which buffers? Found by running a technique on a backend that only notes what is asked of it.
//!
//! Some sizes are known only once passes have run: how many voxels a scene has, say. When a technique reads such a number back,
//! the passes that it follows from, and no others, are run on the CPU.

use super::{Allocation, Backend, BackendError, BufferElement, BufferLength, Cpu, CpuBuffer};
use std::cell::RefCell;
use std::collections::HashSet;
use std::rc::Rc;
use twinlight_kernels::passes::PassTiming;
use twinlight_kernels::passes::elements::*;

type Work = Box<dyn FnOnce(&mut Cpu) -> Result<(), BackendError>>;

/// Something to do, unless nobody asks for what it gives.
struct Step {
    reads: Vec<u64>,
    writes: u64,
    work: Work,
}

/// Notes passes and buffers; computes only what sizes follow from.
pub struct Recorder {
    cpu: Cpu,
    stage: &'static str,
    passes: Vec<PassTiming>,
    allocations: Option<Vec<Allocation>>,
    steps: Vec<Step>,
    next: u64,
    computed: Vec<&'static str>,
}

/// An array whose elements may never be computed.
pub struct RecorderBuffer<T> {
    id: u64,
    len: usize,
    values: Rc<RefCell<Option<CpuBuffer<T>>>>,
}

impl<T: BufferElement> BufferLength for RecorderBuffer<T> {
    fn element_count(&self) -> usize {
        self.len
    }
}

impl<T: BufferElement> RecorderBuffer<T> {
    fn bytes(&self) -> u64 {
        self.len as u64 * size_of::<T>() as u64
    }
}

/// The values of a buffer, zeros at first.
fn with<T: BufferElement, R>(
    cpu: &mut Cpu,
    values: &RefCell<Option<CpuBuffer<T>>>,
    len: usize,
    work: impl FnOnce(&mut Cpu, &mut CpuBuffer<T>) -> Result<R, BackendError>,
) -> Result<R, BackendError> {
    let taken = values.borrow_mut().take();
    let mut buffer = match taken {
        Some(buffer) => buffer,
        None => Cpu::alloc(cpu, "planned", len)?,
    };
    let result = work(cpu, &mut buffer);
    *values.borrow_mut() = Some(buffer);
    result
}

impl Recorder {
    /// Notes what is asked of it; computes with these threads where it must.
    pub fn new(cpu: Cpu) -> Self {
        let (passes, steps, computed) = (Vec::new(), Vec::new(), Vec::new());
        Self { cpu, stage: "", passes, allocations: None, steps, next: 0, computed }
    }

    /// The passes that had to be computed, for what sizes follow from them.
    pub fn computed(&self) -> &[&'static str] {
        &self.computed
    }

    fn buffer<T: BufferElement>(&mut self, label: &str, len: usize) -> RecorderBuffer<T> {
        self.next += 1;
        let buffer = RecorderBuffer { id: self.next, len, values: Rc::new(RefCell::new(None)) };
        let (stage, bytes) = (self.stage, buffer.bytes());
        if let Some(list) = &mut self.allocations {
            list.push(Allocation { stage, label: label.to_owned(), bytes });
        }
        buffer
    }

    /// Runs the steps that the elements of a buffer follow from, and those that would find other elements after them.
    fn compute(&mut self, id: u64) -> Result<(), BackendError> {
        let (mut read, mut written) = (HashSet::from([id]), HashSet::new());
        let mut needed = vec![false; self.steps.len()];
        // From the last to the first: what later needed steps read must be written, and what they overwrite must have been read.
        for (i, step) in self.steps.iter().enumerate().rev() {
            let overwritten = step.reads.iter().any(|r| written.contains(r));
            if read.contains(&step.writes) || written.contains(&step.writes) || overwritten {
                needed[i] = true;
                read.extend(&step.reads);
                written.insert(step.writes);
            }
        }
        let steps = std::mem::take(&mut self.steps);
        for (step, needed) in steps.into_iter().zip(needed) {
            if needed {
                (step.work)(&mut self.cpu)?;
            } else {
                self.steps.push(step);
            }
        }
        self.computed.extend(self.cpu.take_timings().iter().map(|t| t.pass));
        Ok(())
    }
}

macro_rules! implement {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        impl Backend for Recorder {
            type Buffer<T: BufferElement> = RecorderBuffer<T>;

            fn upload<T: BufferElement>(
                &mut self,
                label: &str,
                data: &[T],
            ) -> Result<RecorderBuffer<T>, BackendError> {
                let buffer = self.buffer(label, data.len());
                *buffer.values.borrow_mut() = Some(Cpu::upload(&self.cpu, label, data)?);
                Ok(buffer)
            }
            fn alloc<T: BufferElement>(
                &mut self,
                label: &str,
                len: usize,
            ) -> Result<RecorderBuffer<T>, BackendError> {
                Ok(self.buffer(label, len))
            }
            fn write<T: BufferElement>(
                &mut self,
                buffer: &mut RecorderBuffer<T>,
                data: &[T],
            ) -> Result<(), BackendError> {
                let (values, len, data) = (buffer.values.clone(), buffer.len, data.to_vec());
                let work: Work = Box::new(move |cpu| {
                    with(cpu, &values, len, |cpu, buffer| {
                        Cpu::write(cpu, buffer, &data);
                        Ok(())
                    })
                });
                self.steps.push(Step { reads: Vec::new(), writes: buffer.id, work });
                Ok(())
            }
            fn clear<T: BufferElement>(&mut self, buffer: &mut RecorderBuffer<T>) -> Result<(), BackendError> {
                let (values, len) = (buffer.values.clone(), buffer.len);
                let work: Work = Box::new(move |cpu| {
                    with(cpu, &values, len, |cpu, buffer| {
                        Cpu::clear(cpu, buffer);
                        Ok(())
                    })
                });
                self.steps.push(Step { reads: Vec::new(), writes: buffer.id, work });
                Ok(())
            }
            fn download<T: BufferElement>(&mut self, buffer: &RecorderBuffer<T>) -> Result<Vec<T>, BackendError> {
                self.compute(buffer.id)?;
                with(&mut self.cpu, &buffer.values, buffer.len, |cpu, values| Ok(Cpu::download(cpu, values)))
            }
            fn read_result<T: BufferElement>(&mut self, buffer: &RecorderBuffer<T>) -> Result<Vec<T>, BackendError> {
                Ok(vec![T::zeroed(); buffer.len])
            }
            fn log_allocations(&mut self, on: bool) {
                self.allocations = on.then(Vec::new);
            }
            fn take_allocations(&mut self) -> Vec<Allocation> {
                self.allocations.as_mut().map(std::mem::take).unwrap_or_default()
            }
            fn set_stage(&mut self, stage: &'static str) {
                self.stage = stage;
            }
            fn take_timings(&mut self) -> Result<Vec<PassTiming>, BackendError> {
                Ok(std::mem::take(&mut self.passes))
            }

            $(
                fn $name(
                    &mut self,
                    params: &$params,
                    $($input: &RecorderBuffer<$element>,)*
                    $output: &mut RecorderBuffer<$out>,
                    items: u32,
                ) -> Result<(), BackendError> {
                    let bytes = $output.bytes() $(+ $input.bytes())*;
                    let (pass, stage) = (stringify!($name), self.stage);
                    self.passes.push(PassTiming { pass, stage, items, bytes, nanoseconds: 0.0 });
                    let params = *params;
                    let (reads, writes) = (vec![$($input.id),*], $output.id);
                    $(let $input = ($input.values.clone(), $input.len);)*
                    let $output = ($output.values.clone(), $output.len);
                    let work: Work = Box::new(move |cpu| {
                        $(with(cpu, &$input.0, $input.1, |_, _| Ok(()))?;)*
                        $(let $input = $input.0.borrow();)*
                        $(let Some($input) = $input.as_ref() else { return Ok(()) };)*
                        with(cpu, &$output.0, $output.1, |cpu, out| Ok(cpu.$name(&params, $($input,)* out, items)?))
                    });
                    self.steps.push(Step { reads, writes, work });
                    Ok(())
                }
            )*
        }
    };
}

twinlight_kernels::for_each_pass!(implement);
