//! Which GPUs do the tests of a process share, and what do they do without one?
#![allow(dead_code)]

use std::io::Write;
use std::sync::{Mutex, MutexGuard, OnceLock, TryLockError};
use twinlight_gpu::{Gpu, GpuOptions, Probe, Variant};

/// A GPU that tests of a process share: devices are costly.
pub struct SharedGpu {
    /// The device; set the variant before use.
    pub gpu: Gpu,
    /// What it does with floats.
    pub probe: Probe,
}

impl SharedGpu {
    /// The variants that must give the CPU's bits: the one that the probe chose, and software division everywhere.
    ///
    /// None where SPIR-V does not reach the driver unchanged; says so.
    pub fn strict_variants(&self) -> Vec<Variant> {
        match self.probe.strict_variant() {
            Ok(Variant::Strict) => vec![Variant::Strict],
            Ok(chosen) => vec![chosen, Variant::Strict],
            Err(reason) => {
                if self.probe.passthrough && gpu_required() {
                    panic!("strict arithmetic does not work on {}: {reason}", self.gpu.adapter().name);
                }
                announce(&format!("SKIPPED: strict comparison on {}: {reason}", self.gpu.adapter().name));
                Vec::new()
            }
        }
    }
}

/// True when a missing GPU is a failure.
pub fn gpu_required() -> bool {
    std::env::var("TWINLIGHT_REQUIRE_GPU").is_ok_and(|v| v == "1")
}

/// Writes a line that is seen even when the test passes.
pub fn announce(line: &str) {
    let _ = writeln!(std::io::stderr(), "{line}");
}

/// A GPU that is free, or none after a visible line (a failure with `TWINLIGHT_REQUIRE_GPU=1`).
///
/// As many devices as tests run at once: drivers compile modules on one core.
pub fn shared() -> Option<MutexGuard<'static, SharedGpu>> {
    static DEVICES: [OnceLock<Result<Mutex<SharedGpu>, String>>; 4] = [const { OnceLock::new() }; 4];
    let count = std::thread::available_parallelism().map_or(1, |n| n.get()).min(DEVICES.len());
    let mut busy = None;
    for device in &DEVICES[..count] {
        let device = match device.get_or_init(open) {
            Ok(device) => device,
            Err(reason) => {
                skip(reason);
                return None;
            }
        };
        match device.try_lock() {
            Ok(free) => return Some(free),
            // A test that failed while it held the GPU must not fail the others.
            Err(TryLockError::Poisoned(free)) => return Some(free.into_inner()),
            Err(TryLockError::WouldBlock) => busy = Some(device),
        }
    }
    busy.map(|device| device.lock().unwrap_or_else(|e| e.into_inner()))
}

fn open() -> Result<Mutex<SharedGpu>, String> {
    let mut gpu = Gpu::new(&GpuOptions::default()).map_err(|e| e.to_string())?;
    let probe = gpu.run_probe().map_err(|e| e.to_string())?;
    announce(&format!("GPU: {}\nprobe: {probe:?}", twinlight_gpu::describe(gpu.adapter())));
    Ok(Mutex::new(SharedGpu { gpu, probe }))
}

/// Says that the GPU part of a test is skipped and how to get a GPU; fails with `TWINLIGHT_REQUIRE_GPU=1`.
pub fn skip(reason: &str) {
    if gpu_required() {
        panic!("TWINLIGHT_REQUIRE_GPU=1, but {reason}");
    }
    announce(&format!(
        "SKIPPED: GPU part of a test: {reason}. Without a GPU, Mesa's lavapipe will do: `cargo xtask test` gets it \
         (Debian: apt-get install mesa-vulkan-drivers libvulkan1)"
    ));
}
