//! Where do the two backends differ, pass by pass?

use super::{
    Allocation, Backend, BackendError, BufferElement, BufferLength, Cpu, CpuBuffer, Gpu, GpuBuffer, listed,
};
use crate::report::agreement::{Agreement, compare_elements};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::{PassTiming, info};

/// Runs every pass on both backends with the CPU's inputs, and compares the outputs.
///
/// After each pass the GPU's buffer takes the CPU's values, so that a difference shows in its own pass only.
pub struct PairBackend {
    cpu: Cpu,
    gpu: Gpu,
    agreements: Vec<Agreement>,
}

/// The same array on both backends.
pub struct PairBuffer<T> {
    cpu: CpuBuffer<T>,
    gpu: GpuBuffer<T>,
}

impl<T: BufferElement> BufferLength for PairBuffer<T> {
    fn element_count(&self) -> usize {
        self.cpu.len()
    }
}

impl PairBackend {
    /// Compares these two.
    pub fn new(cpu: Cpu, gpu: Gpu) -> Self {
        Self { cpu, gpu, agreements: Vec::new() }
    }

    /// The comparison of each pass run so far, in order.
    pub fn take_agreements(&mut self) -> Vec<Agreement> {
        std::mem::take(&mut self.agreements)
    }

    /// The GPU.
    pub fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    fn compare<T: BufferElement>(
        &mut self,
        pass: &'static twinlight_kernels::passes::PassInfo,
        output: &mut PairBuffer<T>,
        items: u32,
    ) -> Result<(), BackendError> {
        let got = self.gpu.download(&output.gpu)?;
        let count = match pass.shape {
            twinlight_kernels::passes::Shape::Map => items as usize,
            twinlight_kernels::passes::Shape::Scatter => got.len(),
        };
        let expected = output.cpu.as_slice();
        self.agreements.push(compare_elements(pass, &expected[..count], &got[..count]));
        self.gpu.write(&mut output.gpu, expected)?;
        Ok(())
    }
}

macro_rules! implement {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        impl Backend for PairBackend {
            type Buffer<T: BufferElement> = PairBuffer<T>;

            fn upload<T: BufferElement>(&mut self, label: &str, data: &[T]) -> Result<PairBuffer<T>, BackendError> {
                Ok(PairBuffer { cpu: self.cpu.upload(label, data)?, gpu: self.gpu.upload(label, data)? })
            }
            fn alloc<T: BufferElement>(&mut self, label: &str, len: usize) -> Result<PairBuffer<T>, BackendError> {
                Ok(PairBuffer { cpu: self.cpu.alloc(label, len)?, gpu: self.gpu.alloc(label, len)? })
            }
            fn write<T: BufferElement>(&mut self, buffer: &mut PairBuffer<T>, data: &[T]) -> Result<(), BackendError> {
                self.cpu.write(&mut buffer.cpu, data);
                Ok(self.gpu.write(&mut buffer.gpu, data)?)
            }
            fn clear<T: BufferElement>(&mut self, buffer: &mut PairBuffer<T>) -> Result<(), BackendError> {
                self.cpu.clear(&mut buffer.cpu);
                Ok(self.gpu.clear(&mut buffer.gpu)?)
            }
            fn download<T: BufferElement>(&mut self, buffer: &PairBuffer<T>) -> Result<Vec<T>, BackendError> {
                Ok(self.cpu.download(&buffer.cpu))
            }
            fn log_allocations(&mut self, on: bool) {
                self.cpu.log_allocations(on);
            }
            fn take_allocations(&mut self) -> Vec<Allocation> {
                listed(self.cpu.take_allocations())
            }
            fn set_stage(&mut self, stage: &'static str) {
                self.cpu.set_stage(stage);
                self.gpu.set_stage(stage);
            }
            fn take_timings(&mut self) -> Result<Vec<PassTiming>, BackendError> {
                self.gpu.take_timings()?;
                Ok(self.cpu.take_timings())
            }

            $(
                fn $name(
                    &mut self,
                    params: &$params,
                    $($input: &PairBuffer<$element>,)*
                    $output: &mut PairBuffer<$out>,
                    items: u32,
                ) -> Result<(), BackendError> {
                    self.cpu.$name(params, $(&$input.cpu,)* &mut $output.cpu, items)?;
                    self.gpu.$name(params, $(&$input.gpu,)* &mut $output.gpu, items)?;
                    self.compare(&info::$name, $output, items)
                }
            )*
        }
    };
}

twinlight_kernels::for_each_pass!(implement);
