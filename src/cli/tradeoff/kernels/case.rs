//! How are one kernel's errors and times measured?

use super::Settings;
use super::device::{Devices, Work};
use crate::backend::GpuError;
use std::fmt::Debug;
use std::hint::black_box;
use std::time::Instant;

/// In what errors are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    /// Units in the last place of the true value.
    Ulp,
    /// Shares of the true value.
    Relative,
    /// Differences.
    Absolute,
    /// Shares of the norms of what goes in.
    OfNorm,
    /// Shares of the farthest distance that the inputs could give.
    OfScale,
    /// Root mean square over the sphere.
    Sphere,
    /// 1 for a wrong result, 0 for a right one: the mean is the share of wrong ones.
    Wrong,
}

impl Unit {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Ulp => "ULP",
            Self::Relative => "relative",
            Self::Absolute => "absolute",
            Self::OfNorm => "of norm",
            Self::OfScale => "of scale",
            Self::Sphere => "RMS on sphere",
            Self::Wrong => "wrong results",
        }
    }
}

/// What a kernel is called and what is said about it.
#[derive(Clone)]
pub(super) struct Head {
    pub kernel: &'static str,
    pub variant: String,
    pub domain: &'static str,
    pub unit: Unit,
    /// The largest error that the documentation allows.
    pub stated: Option<f64>,
}

impl Head {
    pub(super) fn new(kernel: &'static str, variant: &str, domain: &'static str, unit: Unit) -> Self {
        Self { kernel, variant: variant.into(), domain, unit, stated: None }
    }

    /// The kernel as it is, of which there is one.
    pub(super) fn strict(kernel: &'static str, domain: &'static str, unit: Unit) -> Self {
        Self::new(kernel, "strict", domain, unit)
    }

    pub(super) fn stated(mut self, bound: f64) -> Self {
        self.stated = Some(bound);
        self
    }
}

/// What a kernel gives.
pub(super) trait Output: Copy + Debug {
    const ZERO: Self;
    /// The same bits; ±0 and all NaN are equal, values below 2⁻¹²⁶ count as 0.
    fn same(&self, other: &Self) -> bool;
}

impl<const K: usize> Output for [f32; K] {
    const ZERO: Self = [0.0; K];
    fn same(&self, other: &Self) -> bool {
        let flushed = |x: f32| if x.abs() < f32::MIN_POSITIVE { 0.0 } else { x };
        self.iter().zip(other).all(|(a, b)| flushed(*a) == flushed(*b) || (a.is_nan() && b.is_nan()))
    }
}

impl Output for u32 {
    const ZERO: Self = 0;
    fn same(&self, other: &Self) -> bool {
        self == other
    }
}

impl<const K: usize> Output for [u32; K] {
    const ZERO: Self = [0; K];
    fn same(&self, other: &Self) -> bool {
        self == other
    }
}

/// The word of an item that holds the only number.
pub(super) fn number<const AT: usize>(words: &[u32]) -> [f32; 1] {
    [f32::from_bits(words[AT])]
}

/// The first numbers of an item.
pub(super) fn numbers<const K: usize>(words: &[u32]) -> [f32; K] {
    std::array::from_fn(|i| f32::from_bits(words[i]))
}

/// A kernel over arrays; its loop is compiled with it, so that the compiler may use SIMD as it may in a pass.
pub(super) type Each<I, O> = Box<dyn Fn(&[I], &mut [O])>;

/// The loop over a kernel.
pub(super) fn each<I, O>(kernel: impl Fn(&I) -> O + 'static) -> Each<I, O> {
    Box::new(move |inputs, out| {
        for (o, i) in out.iter_mut().zip(inputs) {
            *o = kernel(i);
        }
    })
}

/// What a pass does with inputs.
pub(super) type Pass<I> = Box<dyn Fn(&[I]) -> Work>;

/// The error of the result of input number i against float64.
pub(super) type Against<I, O> = Box<dyn Fn(usize, &I, &O) -> f64>;

/// What is read from the words of an item.
pub(super) type Read<O> = fn(&[u32]) -> O;

/// How a GPU runs the kernel.
pub(super) struct OnDevice<I, O> {
    /// The pass that evaluates these inputs.
    pub work: Pass<I>,
    /// The kernel's result in the words of an item.
    pub read: Read<O>,
    /// With division and square root in software, whatever the device can do.
    pub software: bool,
}

/// A kernel with its inputs and its truth.
pub(super) struct Case<I, O> {
    pub head: Head,
    pub inputs: Vec<I>,
    pub strict: Each<I, O>,
    /// Other ways on the CPU; what is called native is what strictness is compared with.
    pub others: Vec<(&'static str, Each<I, O>)>,
    pub error: Against<I, O>,
    pub device: Option<OnDevice<I, O>>,
}

impl<I: Copy + Debug + 'static, O: Output + 'static> Case<I, O> {
    /// A kernel that no pass gives alone.
    pub(super) fn new(
        head: Head,
        inputs: Vec<I>,
        kernel: impl Fn(&I) -> O + 'static,
        error: impl Fn(&I, &O) -> f64 + 'static,
    ) -> Self {
        let error: Against<I, O> = Box::new(move |_, input, got| error(input, got));
        Self { head, inputs, strict: each(kernel), others: Vec::new(), error, device: None }
    }

    /// Adds another way on the CPU.
    pub(super) fn way(mut self, name: &'static str, way: impl Fn(&I) -> O + 'static) -> Self {
        self.others.push((name, each(way)));
        self
    }

    /// Adds the pass that gives it.
    pub(super) fn on(mut self, work: impl Fn(&[I]) -> Work + 'static, read: Read<O>) -> Self {
        self.device = Some(OnDevice { work: Box::new(work), read, software: false });
        self
    }

    pub(super) fn boxed(self) -> Box<dyn Measure> {
        Box::new(self)
    }
}

/// The name of the ordinary way on a CPU.
pub(super) const NATIVE: &str = "native";

/// The name of the formula as one would write it.
pub(super) const NAIVE: &str = "naive";

/// What a GPU takes in place of its own division and square root.
pub(super) const SOFTWARE: &str = "software";

/// Largest and mean error.
#[derive(Clone, Copy, Debug)]
pub(super) struct Errors {
    pub max: f64,
    pub mean: f64,
}

/// What a GPU took, and how wrong it was.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct DeviceRow {
    pub strict_ns: Option<f64>,
    pub fast_ns: Option<f64>,
    pub fast: Option<Errors>,
    /// Whether strict results were compared with the CPU's.
    pub compared: bool,
    /// Items of the timed runs.
    pub items: u32,
}

/// A line of the report.
pub(super) struct Row {
    pub head: Head,
    pub errors: Errors,
    pub cpu_ns: f64,
    /// Time over that of the native way.
    pub cost: Option<f64>,
    pub device: Option<DeviceRow>,
    /// Where the strict GPU result is not the CPU's.
    pub mismatch: Option<String>,
}

impl Row {
    /// False if an error is above what is stated.
    pub(super) fn within(&self) -> bool {
        self.head.stated.is_none_or(|bound| self.errors.max <= bound)
    }
}

/// Something that gives lines of the report.
pub(super) trait Measure {
    fn head(&self) -> &Head;
    fn measure(&self, settings: &Settings, devices: &mut Devices) -> Result<Vec<Row>, GpuError>;
}

impl<I: Copy + Debug, O: Output> Measure for Case<I, O> {
    fn head(&self) -> &Head {
        &self.head
    }

    fn measure(&self, settings: &Settings, devices: &mut Devices) -> Result<Vec<Row>, GpuError> {
        let (mut first, results) = self.row(self.head.clone(), &self.strict, settings);
        let mut rows = Vec::new();
        for (name, other) in &self.others {
            let mut head = Head { stated: None, ..self.head.clone() };
            head.variant =
                if head.variant == "strict" { (*name).into() } else { format!("{name}, {}", head.variant) };
            let (row, _) = self.row(head, other, settings);
            if *name == NATIVE {
                first.cost = Some(first.cpu_ns / row.cpu_ns);
            }
            // What software stands for has a line of its own.
            if first.head.variant != SOFTWARE {
                rows.push(row);
            }
        }
        if let Some(device) = &self.device {
            (first.device, first.mismatch) = self.on_device(device, &results, settings, devices)?;
        }
        rows.insert(0, first);
        Ok(rows)
    }
}

impl<I: Copy + Debug, O: Output> Case<I, O> {
    fn row(&self, head: Head, kernel: &Each<I, O>, settings: &Settings) -> (Row, Vec<O>) {
        let mut results = vec![O::ZERO; self.inputs.len()];
        kernel(&self.inputs, &mut results);
        let errors = self.errors(&results);
        let cpu_ns = nanoseconds(kernel, &self.inputs, settings);
        (Row { head, errors, cpu_ns, cost: None, device: None, mismatch: None }, results)
    }

    fn errors(&self, results: &[O]) -> Errors {
        let (mut max, mut sum) = (0.0f64, 0.0f64);
        for (i, (input, result)) in self.inputs.iter().zip(results).enumerate() {
            let error = (self.error)(i, input, result);
            let error = if error.is_nan() { f64::INFINITY } else { error };
            max = max.max(error);
            sum += error;
        }
        Errors { max, mean: sum / self.inputs.len().max(1) as f64 }
    }

    fn on_device(
        &self,
        device: &OnDevice<I, O>,
        results: &[O],
        settings: &Settings,
        devices: &mut Devices,
    ) -> Result<(Option<DeviceRow>, Option<String>), GpuError> {
        let work = (device.work)(&self.inputs);
        let mut row = DeviceRow::default();
        let mut mismatch = None;
        if let Some(gpu) = devices.strict(device.software) {
            let got = work.answers(gpu)?;
            row.compared = true;
            let wrong = (0..results.len()).find(|&i| !(device.read)(got.item(i)).same(&results[i]));
            mismatch = wrong.map(|i| {
                let (gpu, cpu) = ((device.read)(got.item(i)), results[i]);
                format!("{:?}: the CPU gives {cpu:?}, the GPU {gpu:?}", self.inputs[i])
            });
            (row.strict_ns, row.items) = work.nanoseconds(gpu, settings)?;
        }
        if let Some(gpu) = devices.fast() {
            let got = work.answers(gpu)?;
            let results: Vec<O> = (0..results.len()).map(|i| (device.read)(got.item(i))).collect();
            row.fast = Some(self.errors(&results));
            (row.fast_ns, row.items) = work.nanoseconds(gpu, settings)?;
        }
        Ok(((row.items > 0).then_some(row), mismatch))
    }
}

/// Nanoseconds per call on one thread: the median over batches of loops over as many inputs as stay in the cache.
fn nanoseconds<I: Copy, O: Output>(kernel: &Each<I, O>, inputs: &[I], settings: &Settings) -> f64 {
    let bytes = size_of::<I>() + size_of::<O>();
    let inputs = &inputs[..inputs.len().min((65_536 / bytes).clamp(64, 4096))];
    let mut out = vec![O::ZERO; inputs.len()];
    let mut batch = |loops: u32| {
        let start = Instant::now();
        for _ in 0..loops {
            kernel(black_box(inputs), black_box(&mut out));
        }
        start.elapsed().as_nanos() as f64 / (f64::from(loops) * inputs.len() as f64)
    };
    batch(1);
    let once = batch(1).max(0.01) * inputs.len() as f64;
    let loops = (settings.batch_ns / once).clamp(1.0, 1e6) as u32;
    median((0..settings.batches).map(|_| batch(loops)).collect())
}

/// The value in the middle.
pub(super) fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
