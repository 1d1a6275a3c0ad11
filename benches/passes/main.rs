//! How long does each pass of the list take on each backend?
//!
//! `cargo bench --bench passes` measures all, `cargo bench --bench passes -- trace_primary` one. The CPU's time is the
//! wall time of the pass on all cores. A GPU's is the device's by its timestamps, without submission; where it has
//! none it is wall time. Passes over pixels see a 256 × 256 picture of the built-in `spheres`, 51 202 triangles.
//!
//! Every pass has a function of its name in [`cases`]: without one this does not compile.

// A case is typed by its pass: that is what makes a missing input fail to compile.
#![allow(clippy::type_complexity)]

#[path = "../common/mod.rs"]
mod common;

mod cases;

use cases::{Case, Samples};
use common::{open_gpus, time};
use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use std::time::Duration;
use twinlight::backend::{Backend, BackendError, Cpu};
use twinlight_kernels::passes::elements::*;

macro_rules! benchmarks {
    ($($(#[$doc:meta])* $shape:ident $name:ident($params:ty; $($binding:tt $input:ident: $element:ty),*)
        -> $out_binding:tt $output:ident: $out:ty, $tolerance:expr;)*) => {
        /// Uploads the inputs of a pass and times it on one machine.
        mod timed {
            use super::*;
            use criterion::BenchmarkGroup;
            use criterion::measurement::WallTime;

            $(
                pub fn $name<B: Backend>(
                    group: &mut BenchmarkGroup<'_, WallTime>,
                    machine: &str,
                    backend: &mut B,
                    case: &Case<$params, ($(Vec<$element>,)*)>,
                ) -> Result<(), BackendError> {
                    let ($($input,)*) = &case.inputs;
                    $(let $input = backend.upload(stringify!($input), $input)?;)*
                    let mut output = backend.alloc::<$out>("output", case.outputs as usize)?;
                    time(group, machine, backend, |backend| {
                        backend.$name(&case.params, $(&$input,)* &mut output, case.items)
                    });
                    Ok(())
                }
            )*
        }

        fn every_pass(c: &mut Criterion) {
            let mut cpu = Cpu::new(None).expect("threads start");
            let mut gpus = open_gpus();
            let samples = Samples::new(&mut cpu).expect("a built-in scene is drawn");
            $(
                let case = cases::$name(&samples);
                let mut group = c.benchmark_group(concat!("passes/", stringify!($name)));
                group.throughput(Throughput::Elements(u64::from(case.items)));
                timed::$name(&mut group, "cpu", &mut cpu, &case).expect("the CPU runs the pass");
                for (machine, gpu) in &mut gpus {
                    if let Err(error) = timed::$name(&mut group, machine, gpu, &case) {
                        eprintln!("skipped: {} on {machine}: {error}", stringify!($name));
                    }
                }
                group.finish();
            )*
        }
    };
}

twinlight_kernels::for_each_pass!(benchmarks);

criterion_group! {
    name = passes;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(200))
        .measurement_time(Duration::from_secs(1))
        .sample_size(20);
    targets = every_pass
}
criterion_main!(passes);
