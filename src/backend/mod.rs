//! On which machine do the passes run?
//!
//! Techniques are written once against [`Backend`]; its pass methods follow from the pass list.

mod cpu;
mod gpu;
mod pair;
mod recorder;

pub use pair::{PairBackend, PairBuffer};
pub use recorder::{Recorder, RecorderBuffer};
pub use twinlight_cpu::{Cpu, CpuBuffer, CpuError, bears_refusal};
pub use twinlight_gpu::{Arithmetic, Gpu, GpuBuffer, GpuError, GpuOptions};

use bytemuck::Pod;
use twinlight_kernels::layout::Element;
use twinlight_kernels::passes::PassTiming;
use twinlight_kernels::passes::elements::*;

/// A type that fills buffers on every backend.
pub trait BufferElement: Pod + Element + Send + Sync {}
impl<T: Pod + Element + Send + Sync> BufferElement for T {}

/// What can go wrong on a backend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BackendError {
    /// On the CPU.
    #[error(transparent)]
    Cpu(#[from] CpuError),
    /// On the GPU.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// A scene cannot be used.
    #[error(transparent)]
    Scene(#[from] crate::error::SceneError),
    /// A technique's knob is out of range.
    #[error(transparent)]
    Settings(#[from] crate::error::SettingsError),
}

/// A buffer that was made.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Allocation {
    /// The part of a technique that it was made for.
    pub stage: &'static str,
    /// Its name.
    pub label: String,
    /// Its size.
    pub bytes: u64,
}

/// What a backend lists as what this crate shows.
fn listed(list: Vec<(&'static str, String, u64)>) -> Vec<Allocation> {
    list.into_iter().map(|(stage, label, bytes)| Allocation { stage, label, bytes }).collect()
}

/// The number of elements of a buffer.
pub trait BufferLength {
    /// Number of elements.
    fn element_count(&self) -> usize;
}

macro_rules! backend_trait {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        /// Typed buffers and one method per pass; errors, never panics.
        ///
        /// Passes run in the order of the calls. A map pass writes one value per item, a scatter pass accumulates into
        /// an output that was cleared.
        pub trait Backend {
            /// An array in the backend's memory.
            type Buffer<T: BufferElement>: BufferLength;

            /// A buffer that holds a copy of `data`.
            fn upload<T: BufferElement>(&mut self, label: &str, data: &[T]) -> Result<Self::Buffer<T>, BackendError>;
            /// A buffer of `len` zeros.
            fn alloc<T: BufferElement>(&mut self, label: &str, len: usize) -> Result<Self::Buffer<T>, BackendError>;
            /// Overwrites the first `data.len()` elements.
            fn write<T: BufferElement>(&mut self, buffer: &mut Self::Buffer<T>, data: &[T]) -> Result<(), BackendError>;
            /// Sets every element to zero.
            fn clear<T: BufferElement>(&mut self, buffer: &mut Self::Buffer<T>) -> Result<(), BackendError>;
            /// A copy of the elements after all passes so far.
            fn download<T: BufferElement>(&mut self, buffer: &Self::Buffer<T>) -> Result<Vec<T>, BackendError>;
            /// A copy of elements on which nothing that follows depends: a picture's, or counts for the reader. A backend that
            /// only plans has no need to know them.
            fn read_result<T: BufferElement>(&mut self, buffer: &Self::Buffer<T>) -> Result<Vec<T>, BackendError> {
                self.download(buffer)
            }
            /// Begins to list every buffer that is made, or ends it and forgets them.
            fn log_allocations(&mut self, on: bool);
            /// The buffers made since the last call, while they are listed, in order.
            fn take_allocations(&mut self) -> Vec<Allocation>;
            /// Names the part of a technique that the passes from here on belong to, for their timings.
            fn set_stage(&mut self, stage: &'static str);
            /// The timings since the last call, in order, after all passes so far have run.
            fn take_timings(&mut self) -> Result<Vec<PassTiming>, BackendError>;

            $(
                $(#[$doc])*
                fn $name(
                    &mut self,
                    params: &$params,
                    $($input: &Self::Buffer<$element>,)*
                    $output: &mut Self::Buffer<$out>,
                    items: u32,
                ) -> Result<(), BackendError>;
            )*
        }
    };
}

twinlight_kernels::for_each_pass!(backend_trait);
