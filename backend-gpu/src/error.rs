//! What can go wrong on a GPU, and what should one do then?

/// An error of the GPU backend.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// No adapter, or none of that name.
    #[error("no GPU adapter{}: {available}; install a Vulkan driver (Debian: mesa-vulkan-drivers) or use the CPU backend",
        .wanted.as_ref().map(|n| format!(" named '{n}'")).unwrap_or_default())]
    NoAdapter {
        /// The name asked for.
        wanted: Option<String>,
        /// What there is.
        available: String,
    },
    /// The adapter would not open.
    #[error("adapter '{adapter}' does not open: {reason}")]
    NoDevice {
        /// The adapter.
        adapter: String,
        /// The driver's words.
        reason: String,
    },
    /// The device cannot give the CPU's bits.
    #[error(
        "adapter '{adapter}' cannot run strict arithmetic: {reason}; use --arithmetic fast or the CPU backend"
    )]
    NotStrict {
        /// The adapter.
        adapter: String,
        /// What failed.
        reason: String,
    },
    /// A limit of the device is too small.
    #[error("{what} needs {needed}, but the device allows {allowed}; use a smaller size or the CPU backend")]
    LimitTooSmall {
        /// What needs it.
        what: String,
        /// How much.
        needed: u64,
        /// The device's limit.
        allowed: u64,
    },
    /// Device memory is used up.
    #[error("out of device memory at {what}; use a smaller size or the CPU backend")]
    OutOfMemory {
        /// What was being allocated or run.
        what: String,
    },
    /// The device went away.
    #[error("the GPU device was lost at {what} ({reason}); start again, or use the CPU backend")]
    DeviceLost {
        /// What was running.
        what: String,
        /// The driver's words.
        reason: String,
    },
    /// A launch asks for more items than its output holds.
    #[error("pass {pass}: {items} items, but the output holds {capacity}")]
    TooManyItems {
        /// The pass.
        pass: &'static str,
        /// Items asked for.
        items: u32,
        /// Elements of the output.
        capacity: usize,
    },
    /// wgpu refused a call: a fault in this crate or in buffers handed in.
    #[error("the GPU refused {what}: {reason}")]
    Refused {
        /// The call.
        what: String,
        /// wgpu's words.
        reason: String,
    },
}
