//! How does the CPU crate serve as a backend?

use super::{Allocation, Backend, BackendError, BufferElement, BufferLength, Cpu, CpuBuffer, listed};
use bytemuck::Pod;
use twinlight_kernels::passes::PassTiming;
use twinlight_kernels::passes::elements::*;

impl<T: Pod> BufferLength for CpuBuffer<T> {
    fn element_count(&self) -> usize {
        self.len()
    }
}

macro_rules! implement {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        impl Backend for Cpu {
            type Buffer<T: BufferElement> = CpuBuffer<T>;

            fn upload<T: BufferElement>(&mut self, label: &str, data: &[T]) -> Result<CpuBuffer<T>, BackendError> {
                Ok(Cpu::upload(self, label, data)?)
            }
            fn alloc<T: BufferElement>(&mut self, label: &str, len: usize) -> Result<CpuBuffer<T>, BackendError> {
                Ok(Cpu::alloc(self, label, len)?)
            }
            fn write<T: BufferElement>(&mut self, buffer: &mut CpuBuffer<T>, data: &[T]) -> Result<(), BackendError> {
                Cpu::write(self, buffer, data);
                Ok(())
            }
            fn clear<T: BufferElement>(&mut self, buffer: &mut CpuBuffer<T>) -> Result<(), BackendError> {
                Cpu::clear(self, buffer);
                Ok(())
            }
            fn download<T: BufferElement>(&mut self, buffer: &CpuBuffer<T>) -> Result<Vec<T>, BackendError> {
                Ok(Cpu::download(self, buffer))
            }
            fn log_allocations(&mut self, on: bool) {
                Cpu::log_allocations(self, on);
            }
            fn take_allocations(&mut self) -> Vec<Allocation> {
                listed(Cpu::take_allocations(self))
            }
            fn set_stage(&mut self, stage: &'static str) {
                Cpu::set_stage(self, stage);
            }
            fn take_timings(&mut self) -> Result<Vec<PassTiming>, BackendError> {
                Ok(Cpu::take_timings(self))
            }

            $(
                fn $name(
                    &mut self,
                    params: &$params,
                    $($input: &CpuBuffer<$element>,)*
                    $output: &mut CpuBuffer<$out>,
                    items: u32,
                ) -> Result<(), BackendError> {
                    Ok(Cpu::$name(self, params, $($input,)* $output, items)?)
                }
            )*
        }
    };
}

twinlight_kernels::for_each_pass!(implement);
