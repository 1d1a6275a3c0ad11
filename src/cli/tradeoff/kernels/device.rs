//! Which passes evaluate kernels on a GPU, and how long do they take?

use super::Settings;
use super::case::median;
use crate::backend::{Arithmetic, Gpu, GpuBuffer, GpuError, GpuOptions};
use crate::cli::devices::probe_json;
use bytemuck::Pod;
use glam::{UVec4, Vec4};
use serde_json::Value;
use twinlight_gpu::wgpu::DeviceType;
use twinlight_gpu::{Variant, describe};
use twinlight_kernels::passes::elements::{ElementaryParams, EvaluateParams, Evaluation, ShVector};

/// Every lane of the processor's SIMD waits for all branches of the pass.
const SOFTWARE_ADAPTER: &str = "The adapter is a processor: it takes about the same time for all functions of one pass, \
so that its times say little about kernels.";

/// The adapter, opened for both kinds of arithmetic.
#[derive(Default)]
pub(super) struct Devices {
    strict: Option<Gpu>,
    fast: Option<Gpu>,
    /// The strict modules that the probe chose.
    chosen: Option<Variant>,
    /// Why something is missing.
    pub notes: Vec<String>,
}

impl Devices {
    /// Opens what there is; an adapter that was asked for must be there.
    pub(super) fn open(adapter: Option<&str>) -> Result<Self, GpuError> {
        let open = |arithmetic| Gpu::new(&GpuOptions { adapter: adapter.map(Into::into), arithmetic });
        let fast = match open(Arithmetic::Fast) {
            Ok(gpu) => gpu,
            Err(e) if adapter.is_some() => return Err(e),
            Err(e) => return Ok(Self { notes: vec![format!("no GPU columns: {e}")], ..Self::default() }),
        };
        let software = fast.adapter().device_type == DeviceType::Cpu;
        let mut devices = Self { fast: Some(fast), ..Self::default() };
        if software {
            devices.notes.push(SOFTWARE_ADAPTER.into());
        }
        match open(Arithmetic::Strict) {
            Ok(gpu) => {
                devices.chosen = Some(gpu.variant());
                devices.strict = Some(gpu);
            }
            Err(e) => devices.notes.push(format!("no strict GPU columns: {e}")),
        }
        Ok(devices)
    }

    /// The adapter in words.
    pub(super) fn adapter(&self) -> Option<String> {
        let gpu = self.fast.as_ref()?;
        let strict = self.chosen.map(|v| format!(", {v:?} modules")).unwrap_or_default();
        Some(format!("{}{strict}", describe(gpu.adapter())))
    }

    /// What the probe finds out of it.
    pub(super) fn probe(&mut self) -> Result<Option<Value>, GpuError> {
        self.fast.as_mut().map(|gpu| Ok(probe_json(&gpu.run_probe()?))).transpose()
    }

    /// The strict device, with division in software if asked for, else with what the probe chose.
    pub(super) fn strict(&mut self, software: bool) -> Option<&mut Gpu> {
        let (gpu, chosen) = (self.strict.as_mut()?, self.chosen?);
        gpu.set_variant(if software { Variant::Strict } else { chosen });
        Some(gpu)
    }

    pub(super) fn fast(&mut self) -> Option<&mut Gpu> {
        self.fast.as_mut()
    }
}

/// A pass that evaluates kernels, with its inputs; numbers select functions of the pass.
pub(super) enum Work {
    Elementary(u32, [Vec<f32>; 2]),
    Vector(u32, [Vec<Vec4>; 2]),
    Cone(u32, [Vec<Vec4>; 2]),
    Gaussian(u32, [Vec<Vec4>; 3]),
    /// Function, count, arguments.
    Geometry(u32, u32, [Vec<Vec4>; 5]),
    Sampling(u32, Vec<UVec4>, [Vec<Vec4>; 2]),
    /// Order, function, vectors, arguments.
    Harmonics(u32, u32, [Vec<ShVector>; 2], Vec<Vec4>),
    /// Order, function, vectors, arguments, table, its entries.
    Exponential(u32, u32, Vec<ShVector>, Vec<Vec4>, Vec<f32>, u32),
}

/// The vectors of each input in arrays of their own.
pub(super) fn split<const K: usize>(all: &[[Vec4; K]]) -> [Vec<Vec4>; K] {
    std::array::from_fn(|k| all.iter().map(|x| x[k]).collect())
}

/// Results in 32-bit words.
pub(super) struct Answers {
    words: Vec<u32>,
    stride: usize,
}

impl Answers {
    /// The words of one item.
    pub(super) fn item(&self, index: usize) -> &[u32] {
        &self.words[index * self.stride..(index + 1) * self.stride]
    }
}

/// How often over how many items.
struct Launch {
    items: u32,
    runs: u32,
}

impl Work {
    fn inputs(&self) -> usize {
        match self {
            Self::Elementary(_, [x, _]) => x.len(),
            Self::Vector(_, [a, _]) | Self::Cone(_, [a, _]) => a.len(),
            Self::Gaussian(_, [a, ..]) => a.len(),
            Self::Geometry(_, _, [a, ..]) => a.len(),
            Self::Sampling(_, words, _) => words.len(),
            Self::Harmonics(_, _, [a, _], _) | Self::Exponential(_, _, a, ..) => a.len(),
        }
    }

    /// Bytes of the largest element.
    fn stride(&self) -> u64 {
        match self {
            Self::Elementary(..) => 4,
            Self::Harmonics(..) | Self::Exponential(..) => size_of::<ShVector>() as u64,
            _ => size_of::<Evaluation>() as u64,
        }
    }

    /// The results of all inputs.
    pub(super) fn answers(&self, gpu: &mut Gpu) -> Result<Answers, GpuError> {
        let answers = self.launch(gpu, &Launch { items: self.inputs() as u32, runs: 1 })?;
        gpu.take_timings()?;
        Ok(answers)
    }

    /// Nanoseconds per item, and over how many items: fewer where a device would take long. None without timestamps.
    pub(super) fn nanoseconds(&self, gpu: &mut Gpu, s: &Settings) -> Result<(Option<f64>, u32), GpuError> {
        let limits = gpu.device().limits();
        let room = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size) / self.stride();
        let largest = u64::from(s.gpu_items).min(room);
        let trial = s.gpu_items.min(1 << 13);
        let once = self.time(gpu, &Launch { items: trial, runs: 2 })?;
        let affordable = (s.gpu_run_ns / once).max(f64::from(trial)) as u64;
        // The largest power of two.
        let items = 1u32 << affordable.min(largest).max(1).ilog2();
        let nanoseconds = self.time(gpu, &Launch { items, runs: s.gpu_runs })?;
        Ok((nanoseconds.is_finite().then_some(nanoseconds), items))
    }

    /// Median nanoseconds per item.
    fn time(&self, gpu: &mut Gpu, launch: &Launch) -> Result<f64, GpuError> {
        self.launch(gpu, launch)?;
        let runs = gpu.take_timings()?;
        Ok(median(runs.iter().map(|t| t.nanoseconds).collect()) / f64::from(launch.items))
    }

    fn launch(&self, gpu: &mut Gpu, launch: &Launch) -> Result<Answers, GpuError> {
        let n = launch.items;
        let params = |function| EvaluateParams { function, ..Default::default() };
        match self {
            Self::Elementary(function, inputs) => {
                let [x, y] = upload_all(gpu, inputs, n)?;
                let params = ElementaryParams { function: *function, ..Default::default() };
                repeat::<f32>(gpu, launch, |gpu, out| gpu.evaluate_elementary(&params, &x, &y, out, n))
            }
            Self::Vector(function, inputs) => {
                let [a, b] = upload_all(gpu, inputs, n)?;
                repeat::<Vec4>(gpu, launch, |gpu, out| {
                    gpu.evaluate_vector(&params(*function), &a, &b, out, n)
                })
            }
            Self::Cone(function, inputs) => {
                let [a, b] = upload_all(gpu, inputs, n)?;
                repeat::<Vec4>(gpu, launch, |gpu, out| gpu.evaluate_cone(&params(*function), &a, &b, out, n))
            }
            Self::Gaussian(function, inputs) => {
                let [a, b, c] = upload_all(gpu, inputs, n)?;
                repeat::<Vec4>(gpu, launch, |gpu, out| {
                    gpu.evaluate_gaussian(&params(*function), &a, &b, &c, out, n)
                })
            }
            Self::Geometry(function, count, inputs) => {
                let [a, b, c, d, e] = upload_all(gpu, inputs, n)?;
                let params = EvaluateParams { count: *count, ..params(*function) };
                repeat::<Evaluation>(gpu, launch, |gpu, out| {
                    gpu.evaluate_geometry(&params, &a, &b, &c, &d, &e, out, n)
                })
            }
            Self::Sampling(function, words, numbers) => {
                let (words, [x, y]) = (upload(gpu, words, n)?, upload_all(gpu, numbers, n)?);
                repeat::<Evaluation>(gpu, launch, |gpu, out| {
                    gpu.evaluate_sampling(&params(*function), &words, &x, &y, out, n)
                })
            }
            Self::Harmonics(order, function, vectors, arguments) => {
                let pass = match order {
                    3 => Gpu::evaluate_sh3,
                    4 => Gpu::evaluate_sh4,
                    _ => Gpu::evaluate_sh5,
                };
                let ([a, b], arguments) = (upload_all(gpu, vectors, n)?, upload(gpu, arguments, n)?);
                repeat::<ShVector>(gpu, launch, |gpu, out| {
                    pass(gpu, &params(*function), &a, &b, &arguments, out, n)
                })
            }
            Self::Exponential(order, function, vectors, arguments, table, entries) => {
                let pass =
                    if *order == 3 { Gpu::evaluate_sh3_exponential } else { Gpu::evaluate_sh4_exponential };
                let (a, arguments) = (upload(gpu, vectors, n)?, upload(gpu, arguments, n)?);
                let table = gpu.upload("table", table)?;
                let params = EvaluateParams { count: *entries, ..params(*function) };
                repeat::<ShVector>(gpu, launch, |gpu, out| pass(gpu, &params, &a, &arguments, &table, out, n))
            }
        }
    }
}

/// A buffer of `items` values that repeat the inputs.
fn upload<T: Pod>(gpu: &mut Gpu, values: &[T], items: u32) -> Result<GpuBuffer<T>, GpuError> {
    let values: Vec<T> = values.iter().copied().cycle().take(items as usize).collect();
    gpu.upload("inputs", &values)
}

fn upload_all<T: Pod, const K: usize>(
    gpu: &mut Gpu,
    inputs: &[Vec<T>; K],
    items: u32,
) -> Result<[GpuBuffer<T>; K], GpuError> {
    let mut buffers = Vec::with_capacity(K);
    for values in inputs {
        buffers.push(upload(gpu, values, items)?);
    }
    match buffers.try_into() {
        Ok(buffers) => Ok(buffers),
        Err(_) => unreachable!("one buffer was made for each input"),
    }
}

/// Runs a pass, and copies its results where it ran once.
fn repeat<T: Pod>(
    gpu: &mut Gpu,
    launch: &Launch,
    pass: impl Fn(&mut Gpu, &mut GpuBuffer<T>) -> Result<(), GpuError>,
) -> Result<Answers, GpuError> {
    let mut out = gpu.alloc("results", launch.items as usize)?;
    for _ in 0..launch.runs {
        pass(gpu, &mut out)?;
        gpu.finish()?;
    }
    let words =
        if launch.runs == 1 { bytemuck::pod_collect_to_vec(&gpu.download(&out)?) } else { Vec::new() };
    Ok(Answers { words, stride: size_of::<T>() / 4 })
}
