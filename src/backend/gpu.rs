//! How does the GPU crate serve as a backend?

use super::{Allocation, Backend, BackendError, BufferElement, BufferLength, Gpu, GpuBuffer, listed};
use bytemuck::Pod;
use twinlight_kernels::passes::PassTiming;
use twinlight_kernels::passes::elements::*;

impl<T: Pod> BufferLength for GpuBuffer<T> {
    fn element_count(&self) -> usize {
        self.len()
    }
}

macro_rules! implement {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        impl Backend for Gpu {
            type Buffer<T: BufferElement> = GpuBuffer<T>;

            fn upload<T: BufferElement>(&mut self, label: &str, data: &[T]) -> Result<GpuBuffer<T>, BackendError> {
                Ok(Gpu::upload(self, label, data)?)
            }
            fn alloc<T: BufferElement>(&mut self, label: &str, len: usize) -> Result<GpuBuffer<T>, BackendError> {
                Ok(Gpu::alloc(self, label, len)?)
            }
            fn write<T: BufferElement>(&mut self, buffer: &mut GpuBuffer<T>, data: &[T]) -> Result<(), BackendError> {
                Ok(Gpu::write(self, buffer, data)?)
            }
            fn clear<T: BufferElement>(&mut self, buffer: &mut GpuBuffer<T>) -> Result<(), BackendError> {
                Ok(Gpu::clear(self, buffer)?)
            }
            fn download<T: BufferElement>(&mut self, buffer: &GpuBuffer<T>) -> Result<Vec<T>, BackendError> {
                Ok(Gpu::download(self, buffer)?)
            }
            fn log_allocations(&mut self, on: bool) {
                Gpu::log_allocations(self, on);
            }
            fn take_allocations(&mut self) -> Vec<Allocation> {
                listed(Gpu::take_allocations(self))
            }
            fn set_stage(&mut self, stage: &'static str) {
                Gpu::set_stage(self, stage);
            }
            fn take_timings(&mut self) -> Result<Vec<PassTiming>, BackendError> {
                Ok(Gpu::take_timings(self)?)
            }

            $(
                fn $name(
                    &mut self,
                    params: &$params,
                    $($input: &GpuBuffer<$element>,)*
                    $output: &mut GpuBuffer<$out>,
                    items: u32,
                ) -> Result<(), BackendError> {
                    Ok(Gpu::$name(self, params, $($input,)* $output, items)?)
                }
            )*
        }
    };
}

twinlight_kernels::for_each_pass!(implement);
