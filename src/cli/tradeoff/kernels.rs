//! `twinlight tradeoff --kernels`: how wrong is each kernel, how long does it take, and what does strictness cost?

mod attenuation;
mod bilateral;
mod blockers;
mod case;
mod coefficients;
mod device;
mod draw;
mod elementary;
mod exponentials;
mod geometry;
mod harmonics;
#[cfg(test)]
mod listed;
mod lobes;
mod marching;
mod rays;
mod report;
mod samplers;
mod shading;
#[cfg(test)]
mod tests;
mod truth;
mod vectors;
mod voxels;

use crate::cli::options::BackendOptions;
use crate::cli::{Failure, print_out};
use case::{Measure, Row};
use device::Devices;
use report::Machine;
use std::path::Path;

/// How much is measured.
struct Settings {
    /// Inputs of kernels of numbers.
    numbers: usize,
    /// Inputs of kernels of vectors.
    vectors: usize,
    /// Sets of blockers.
    sets: usize,
    /// Timed batches on the CPU, and how long each is.
    batches: u32,
    batch_ns: f64,
    /// Items of a timed pass at most, how long a run may be expected to take, and how many runs.
    gpu_items: u32,
    gpu_run_ns: f64,
    gpu_runs: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            numbers: 1 << 17,
            vectors: 4096,
            sets: 1024,
            batches: 11,
            batch_ns: 1e6,
            gpu_items: 1 << 20,
            gpu_run_ns: 1e8,
            gpu_runs: 5,
        }
    }
}

/// Measures all kernels, prints the table or one JSON object, and writes files into `output`.
pub(crate) fn run(
    backend: &BackendOptions,
    output: Option<&Path>,
    json: bool,
    quiet: bool,
) -> Result<(), Failure> {
    if backend.arithmetic.is_some() || backend.threads.is_some() {
        return Err(Failure::Request(
            "--kernels measures both kinds of arithmetic and one thread; leave --arithmetic and --threads out".into(),
        ));
    }
    // Minutes of measurements shall not be lost for a folder.
    output.map_or(Ok(()), report::prepare)?;
    let mut devices = Devices::open(backend.adapter.as_deref())?;
    let rows = measure(&cases(&Settings::default()), &Settings::default(), &mut devices, quiet)?;
    let machine = Machine {
        processor: crate::report::machine::processor(),
        adapter: devices.adapter(),
        probe: devices.probe()?,
        notes: devices.notes,
    };
    if let Some(folder) = output {
        report::write(folder, &machine, &rows)?;
    }
    print_out(&if json {
        format!("{}\n", report::object(&machine, &rows))
    } else {
        report::text(&machine, &rows)
    })?;
    check(&rows)
}

/// Every kernel with its inputs.
fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let mut all: Vec<_> = elementary::functions().into_iter().map(|f| f.case(settings)).collect();
    all.extend(elementary::whole_powers(settings));
    all.extend(vectors::cases(settings));
    all.extend(shading::cases(settings));
    all.extend(lobes::cases(settings));
    all.extend(bilateral::cases(settings));
    all.extend(marching::cases(settings));
    all.extend(geometry::cases(settings));
    all.extend(rays::cases(settings));
    all.extend(voxels::cases(settings));
    all.extend(samplers::cases(settings));
    all.extend(attenuation::cases(settings));
    all.extend(harmonics::cases(settings));
    all.extend(blockers::cases(settings));
    all.extend(exponentials::cases(settings));
    all
}

fn measure(
    cases: &[Box<dyn Measure>],
    settings: &Settings,
    devices: &mut Devices,
    quiet: bool,
) -> Result<Vec<Row>, Failure> {
    // Hidden too where standard error is no terminal.
    let bar = if quiet {
        indicatif::ProgressBar::hidden()
    } else {
        indicatif::ProgressBar::new(cases.len() as u64)
    };
    if let Ok(style) = indicatif::ProgressStyle::with_template("{bar:40} {pos}/{len} kernels, {msg}") {
        bar.set_style(style);
    }
    let mut rows = Vec::new();
    for case in cases {
        bar.set_message(format!("{} {}", case.head().kernel, case.head().variant));
        rows.extend(case.measure(settings, devices)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(rows)
}

/// Fails where a strict GPU has other bits than the CPU, or an error is above what the documentation states.
fn check(rows: &[Row]) -> Result<(), Failure> {
    let name = |row: &Row| format!("{} ({}, {})", row.head.kernel, row.head.variant, row.head.domain);
    if let Some((row, place)) = rows.iter().find_map(|r| Some((r, r.mismatch.as_ref()?))) {
        return Err(Failure::Work(format!("{}: strict results differ at {place}", name(row))));
    }
    match rows.iter().find(|r| !r.within()) {
        Some(row) => Err(Failure::Work(format!(
            "{}: {:.3e} {}, stated {:.3e}",
            name(row),
            row.errors.max,
            row.head.unit.name(),
            row.head.stated.unwrap_or_default()
        ))),
        None => Ok(()),
    }
}
