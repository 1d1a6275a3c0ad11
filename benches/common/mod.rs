//! What do the benchmarks of passes share?

use criterion::BenchmarkGroup;
use criterion::measurement::WallTime;
use std::time::{Duration, Instant};
use twinlight::backend::{Arithmetic, Backend, BackendError, Gpu, GpuOptions};

/// A GPU in each of the two modes of arithmetic that it has.
pub type Gpus = Vec<(&'static str, Gpu)>;

/// Opens the GPU in both modes; says which were skipped and why.
pub fn open_gpus() -> Gpus {
    let modes = [("gpu-strict", Arithmetic::Strict), ("gpu-fast", Arithmetic::Fast)];
    let open = |(name, arithmetic)| match Gpu::new(&GpuOptions { arithmetic, ..Default::default() }) {
        Ok(gpu) => {
            eprintln!("{name}: {}", twinlight_gpu::describe(gpu.adapter()));
            Some((name, gpu))
        }
        Err(error) => {
            eprintln!("skipped: {name}: {error}");
            None
        }
    };
    modes.into_iter().filter_map(open).collect()
}

/// Times the passes that `launch` runs: by the backend's own timings, or by wall time where it has none.
pub fn time<B: Backend>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    machine: &str,
    backend: &mut B,
    mut launch: impl FnMut(&mut B) -> Result<(), BackendError>,
) {
    group.bench_function(machine, |b| {
        b.iter_custom(|iterations| {
            let start = Instant::now();
            for _ in 0..iterations {
                launch(backend).expect("the pass runs");
            }
            // Waits for the device.
            let timings = backend.take_timings().expect("the passes end");
            let wall = start.elapsed();
            let nanoseconds: f64 = timings.iter().map(|t| t.nanoseconds).sum();
            // Timestamps may be too coarse for a small pass, but criterion takes no time for a fault.
            let own = Duration::from_secs_f64(nanoseconds.max(1.0) * 1e-9);
            if nanoseconds.is_nan() { wall } else { own }
        });
    });
}
