//! How do passes run on a GPU? Through wgpu, from committed SPIR-V, on a device of their own or the host's.
//!
//! [`Gpu::new`] opens a device; [`Gpu::from_device`] adopts a renderer's `wgpu::Device` and `Queue`, and
//! [`GpuBuffer::from_wgpu`] its buffers. Each pass of the list is a method. Commands are recorded into one encoder
//! and submitted by [`Gpu::submit`] or by a download; pipelines are created when a pass is first used.

mod buffer;
mod device;
mod dispatch;
mod error;
mod float_controls;
mod modules;
mod passes;
mod probe;
mod timing;

pub use buffer::GpuBuffer;
pub use device::{Gpu, GpuOptions, adapters, describe};
pub use error::GpuError;
pub use modules::{Variant, module};
pub use probe::{HalfRounding, Probe};
pub use wgpu;

/// Which arithmetic the shaders use.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Arithmetic {
    /// The same bits as the CPU; needs a device that loads SPIR-V unchanged.
    Strict,
    /// The driver's own functions, contraction allowed; within each pass's declared tolerance.
    #[default]
    Fast,
}
