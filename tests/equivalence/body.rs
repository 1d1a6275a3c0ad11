//! How is one pass compared between the backends?

use crate::common::draw::Draw;
use crate::common::gpu::{announce, shared};
use crate::totality::Floats;
use bytemuck::Zeroable;
use twinlight::backend::{Backend, BackendError, BufferElement, Cpu};
use twinlight::report::agreement::{Agreement, compare_elements, ulp_distance};
use twinlight_gpu::Variant;
use twinlight_kernels::layout::WordKind;
use twinlight_kernels::passes::{PassInfo, Shape, Tolerance};

/// What no kernel computes: a NaN with a payload, a huge integer.
const POISON: u32 = 0x7FC0_DEAD;
/// Elements after the output that must stay as they are.
const GUARD: usize = 7;

/// How a pass is launched once.
pub struct Launch {
    /// What is particular about the inputs.
    pub label: String,
    /// Elements of the output: of a map, not all need be written; of a scatter, those that it may reach.
    pub length: usize,
    pub items: u32,
    /// Not compared in fast mode, where the driver may do as it likes.
    pub strict_only: bool,
}

impl Launch {
    pub fn new(label: impl Into<String>, length: usize, items: u32) -> Self {
        Self { label: label.into(), length, items, strict_only: false }
    }

    pub fn strict_only(self) -> Self {
        Self { strict_only: true, ..self }
    }
}

/// One run of a pass.
pub trait Case {
    type Output: BufferElement;

    fn launch(&self) -> &Launch;
    /// Puts any floats into the inputs; returns how many.
    fn spoil(&mut self, floats: Floats, draw: &mut Draw) -> usize;
    fn run<B: Backend>(
        &self,
        backend: &mut B,
        start: &[Self::Output],
    ) -> Result<Vec<Self::Output>, BackendError>;
}

/// Compares a pass on all backends over all its cases.
pub fn check<C: Case>(pass: &'static PassInfo, cases: &[C], draw: &mut Draw) {
    assert!(!cases.is_empty(), "{} has no inputs", pass.name);
    let mut one = Cpu::new(Some(1)).expect("one thread");
    let mut two = Cpu::new(Some(2)).expect("two threads");
    let mut expected = Vec::new();
    for case in cases {
        let output = outputs(pass, case, &mut one);
        let again = outputs(pass, case, &mut two);
        assert!(
            bytes(&output) == bytes(&again),
            "{}, {}: two threads give other bits than one",
            pass.name,
            case.launch().label
        );
        expected.push(output);
    }
    plant_faults(pass, &expected.concat(), draw);
    let elements: usize = expected.iter().map(Vec::len).sum();
    let Some(mut shared) = shared() else { return };
    let variants = shared.strict_variants();
    for &variant in &variants {
        shared.gpu.set_variant(variant);
        let start = std::time::Instant::now();
        for (case, expected) in cases.iter().zip(&expected) {
            let got = outputs(pass, case, &mut shared.gpu);
            let agreement = compare_elements(pass, expected, &got);
            assert!(
                agreement.is_exact(),
                "{} ({variant:?}), {}: {} of {} elements differ from the CPU: {}",
                pass.name,
                case.launch().label,
                agreement.different,
                agreement.elements,
                agreement.first.unwrap_or_default()
            );
        }
        println!("{} ({variant:?}): {:.1} s", pass.name, start.elapsed().as_secs_f64());
    }
    shared.gpu.set_variant(Variant::Fast);
    let start = std::time::Instant::now();
    let (mut fast_expected, mut fast_got) = (Vec::new(), Vec::new());
    for (case, expected) in cases.iter().zip(&expected) {
        let got = outputs(pass, case, &mut shared.gpu);
        let agreement = compare_elements(pass, expected, &got);
        println!("{} fast, {}: {}", pass.name, case.launch().label, line(&agreement));
        if !case.launch().strict_only {
            fast_expected.extend_from_slice(expected);
            fast_got.extend(got);
        }
    }
    println!("{} (Fast): {:.1} s", pass.name, start.elapsed().as_secs_f64());
    let fast = compare_elements(pass, &fast_expected, &fast_got);
    let strict = if variants.is_empty() { "not compared" } else { "bits equal" };
    announce(&format!(
        "{:<26} {elements:>7} elements  strict: {strict}  fast: {}, {:.2} of the tolerance",
        pass.name,
        line(&fast),
        used(pass, &fast_expected, &fast_got)
    ));
    assert!(
        fast.is_tolerable(),
        "{} (Fast): {} of {} elements beyond {:?}; {}; first difference: {}",
        pass.name,
        fast.beyond,
        fast.elements,
        pass.tolerance,
        line(&fast),
        fast.first.unwrap_or_default()
    );
}

fn line(a: &Agreement) -> String {
    format!(
        "max {:.0} ULP, rel {:.1e}, abs {:.1e}, beyond {:.4}",
        a.max_ulp,
        a.max_relative,
        a.max_absolute,
        a.beyond as f64 / a.elements.max(1) as f64
    )
}

/// The largest share of its tolerance that a float within the tolerance takes.
fn used<T: BufferElement>(pass: &PassInfo, expected: &[T], got: &[T]) -> f64 {
    let Tolerance::Relative { relative, absolute, .. } = pass.tolerance else { return 0.0 };
    let words = size_of::<T>() / 4;
    let (expected, got): (&[f32], &[f32]) = (bytemuck::cast_slice(expected), bytemuck::cast_slice(got));
    let pairs = expected.iter().zip(got).enumerate();
    pairs
        .filter(|(i, _)| kind::<T>(i % words) == WordKind::Float)
        .map(|(_, (&e, &g))| {
            let allowed = f64::from(relative) * f64::from(e).abs() + f64::from(absolute);
            if ulp_distance(e, g) == 0.0 { 0.0 } else { (f64::from(e) - f64::from(g)).abs() / allowed }
        })
        .filter(|&share| share <= 1.0)
        .fold(0.0, f64::max)
}

fn bytes<T: BufferElement>(values: &[T]) -> &[u8] {
    bytemuck::cast_slice(values)
}

fn poison<T: BufferElement>() -> T {
    let mut value = T::zeroed();
    bytemuck::cast_slice_mut(std::slice::from_mut(&mut value)).fill(POISON);
    value
}

/// Elements of which some word is still poison.
fn poisoned<T: BufferElement>(values: &[T]) -> usize {
    values
        .iter()
        .filter(|v| bytemuck::cast_slice::<T, u32>(std::slice::from_ref(v)).contains(&POISON))
        .count()
}

/// Runs a case over poison; checks what was written and what was not.
pub fn outputs<C: Case, B: Backend>(pass: &PassInfo, case: &C, backend: &mut B) -> Vec<C::Output> {
    let mut start = vec![poison::<C::Output>(); case.launch().length + GUARD];
    let written = match pass.shape {
        Shape::Map => case.launch().items as usize,
        Shape::Scatter => {
            start[..case.launch().length].fill(C::Output::zeroed());
            case.launch().length
        }
    };
    let mut all =
        case.run(backend, &start).unwrap_or_else(|e| panic!("{}, {}: {e}", pass.name, case.launch().label));
    assert_eq!(all.len(), start.len(), "{}, {}", pass.name, case.launch().label);
    let left = poisoned(&all[..written]);
    assert_eq!(left, 0, "{}, {}: {left} elements were not written", pass.name, case.launch().label);
    assert!(
        bytes(&all[written..]) == bytes(&start[written..]),
        "{}, {}: wrote beyond its output",
        pass.name,
        case.launch().label
    );
    all.truncate(written);
    all
}

/// The comparison must object to a flipped bit, a lost element, a NaN, and an element that nothing wrote.
fn plant_faults<T: BufferElement>(pass: &PassInfo, good: &[T], draw: &mut Draw) {
    assert!(compare_elements(pass, good, good).is_exact(), "{}: differs from itself", pass.name);
    let words = size_of::<T>() / 4;
    for _ in 0..4 {
        let mut bad = good.to_vec();
        let flat: &mut [u32] = bytemuck::cast_slice_mut(&mut bad);
        loop {
            let at = draw.integer(0, flat.len() as u32) as usize;
            let flipped = flat[at] ^ (1 << draw.integer(0, 32));
            // −0 is 0, denormals count as 0, NaN payloads do not count.
            let counts = kind::<T>(at % words) == WordKind::Unsigned
                || ulp_distance(f32::from_bits(flat[at]), f32::from_bits(flipped)) != 0.0;
            if counts {
                flat[at] = flipped;
                break;
            }
        }
        assert!(!compare_elements(pass, good, &bad).is_exact(), "{}: a flipped bit passes", pass.name);
    }
    assert!(!compare_elements(pass, good, &good[1..]).is_exact(), "{}: a lost element passes", pass.name);
    let mut bad = good.to_vec();
    let last = bad.len() - 1;
    bad[last] = poison();
    assert_eq!(poisoned(&bad), 1, "{}: an element that nothing wrote passes", pass.name);
    let beyond = compare_elements(pass, good, &bad).beyond;
    assert_eq!(beyond, 1, "{}: NaN or a huge integer is within the tolerance", pass.name);
}

fn kind<T: BufferElement>(word: usize) -> WordKind {
    let field = T::FIELDS.iter().find(|f| (f.offset / 4..f.offset / 4 + f.words).contains(&(word as u32)));
    field.map_or(WordKind::Unsigned, |f| f.kind)
}
