//! Are both backends right, and not only alike? Kernels with a simple formula against it in float64.
//!
//! The bounds are those that the kernels' documentation states.

mod common;
#[path = "../kernels/tests/oracle/mod.rs"]
mod oracle;
#[path = "../kernels/tests/oracle/sh.rs"]
mod sh_oracle;

use common::draw::Draw;
use common::gpu::shared;
use glam::Vec4;
use std::f64::consts::{PI, TAU};
use twinlight::backend::{Backend, BufferElement, Cpu};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::{elementary, evaluate_cone, evaluate_gaussian, evaluate_sh};

const ITEMS: usize = 2000;

/// Runs the body on the CPU and on the GPU with each strict variant.
macro_rules! on_every_backend {
    ($($name:ident = $body:ident;)*) => {$(
        #[test]
        fn $name() {
            $body(&mut Cpu::new(Some(2)).unwrap(), &mut Draw::new(stringify!($name)));
            let Some(mut shared) = shared() else { return };
            for variant in shared.strict_variants() {
                shared.gpu.set_variant(variant);
                $body(&mut shared.gpu, &mut Draw::new(stringify!($name)));
            }
        }
    )*};
}

on_every_backend! {
    elementary_functions_are_within_their_ulps = elementary_functions;
    corrected_opacity_is_within_3e_7 = corrected_opacity;
    the_specular_weight_is_within_its_bound = specular_weight;
    depth_coverage_is_within_its_bound = depth_coverage;
    basis_functions_are_within_3e_7 = basis;
    products_are_within_2e_6_of_the_norms = products;
}

/// Whether a result is within `allowed` of the truth; never for NaN.
fn within(got: f32, truth: f64, allowed: f64) -> bool {
    (f64::from(got) - truth).abs() <= allowed
}

/// Every result is within its bound, and a result beyond it would be caught.
fn verify(what: &str, results: &[(f32, f64, f64)]) {
    assert!(!results.is_empty());
    for (i, &(got, truth, allowed)) in results.iter().enumerate() {
        assert!(
            within(got, truth, allowed),
            "{what}, item {i}: {got:e}, in truth {truth:e}, off by {:.2} of what is allowed",
            (f64::from(got) - truth).abs() / allowed
        );
    }
    // Planted fault: off by a little more than is allowed, to the other side.
    let ulp = |x: f64| x.abs().max(f64::from(f32::MIN_POSITIVE)) * 2f64.powi(-22);
    let bad = results
        .iter()
        .filter(|&&(_, truth, allowed)| within((truth + 1.1 * allowed + ulp(truth)) as f32, truth, allowed));
    assert_eq!(bad.count(), 0, "{what}: results beyond the bound pass");
}

/// `count` units in the last place of a number.
fn ulps(count: f64, truth: f64) -> f64 {
    let magnitude = truth.abs().max(f64::from(f32::MIN_POSITIVE));
    count * 2f64.powi(magnitude.log2().floor() as i32 - 23)
}

type Function = fn(f64, f64) -> f64;
type Number = fn(&mut Draw) -> f32;

fn elementary_functions<B: Backend>(backend: &mut B, draw: &mut Draw) {
    use elementary::function::*;
    let any: Number = |d| d.positive(1e-30, 1e30);
    let moderate: Number = |d| non_zero(d.number(1e-15, 1e15));
    // (name, function, truth, units in the last place, x, y).
    let all: [(&str, u32, Function, f64, Number, Number); 16] = [
        ("exp2", EXP2, |x, _| x.exp2(), 1.23, |d| d.number(1e-9, 125.0), any),
        ("exp", EXP, |x, _| x.exp(), 0.95, |d| d.number(1e-9, 87.0), any),
        ("exp - 1", EXP_MINUS_ONE, |x, _| x.exp_m1(), 1.42, |d| d.number(1e-30, 88.0), any),
        ("log2", LOG2, |x, _| x.log2(), 1.5, |d| non_zero(d.positive(1e-37, 1e38)), any),
        ("ln", LN, |x, _| x.ln(), 0.85, |d| non_zero(d.positive(1e-37, 1e38)), any),
        ("ln near 1", LN, |x, _| x.ln(), 0.85, |d| d.uniform(0.9, 1.1), any),
        ("ln(1 + x)", LN_ONE_PLUS, |x, _| x.ln_1p(), 0.79, |d| d.number(1e-30, 0.999), any),
        (
            "sin of turns",
            SIN_TURN,
            |x, _| ((x - x.round()) * TAU).sin(),
            1.96,
            |d| d.uniform(-0.49, 0.49),
            any,
        ),
        ("acos", ACOS, |x, _| x.acos(), 1.15, |d| d.uniform(-1.0, 1.0), any),
        ("atan2", ATAN2, |y, x| y.atan2(x), 1.54, moderate, moderate),
        ("erf", ERF, |x, _| oracle::erf(x), 1.3, |d| d.number(1e-30, 5.0), any),
        ("pow", POW, |x, y| x.powf(y), 1.5, |d| non_zero(d.positive(1e-2, 1e2)), |d| d.number(1e-3, 10.0)),
        ("1/sqrt", RSQRT, |x, _| 1.0 / x.sqrt(), 1.49, |d| non_zero(d.positive(1e-37, 1e38)), any),
        ("sqrt", SQRT, |x, _| x.sqrt(), 0.5, |d| d.positive(1e-37, 1e38), any),
        ("quotient", DIV, |x, y| x / y, 0.5, moderate, moderate),
        ("floor", FLOOR, |x, _| x.floor(), 0.0, |d| d.number(1e-30, 1e30), any),
    ];
    for (name, function, truth, allowed, x, y) in all {
        let xs: Vec<f32> = (0..ITEMS).map(|_| x(draw)).collect();
        let ys: Vec<f32> = (0..ITEMS).map(|_| y(draw)).collect();
        let params = ElementaryParams { function, ..Default::default() };
        let (bx, by) = (backend.upload("x", &xs).unwrap(), backend.upload("y", &ys).unwrap());
        let mut values = backend.alloc("values", ITEMS).unwrap();
        backend.evaluate_elementary(&params, &bx, &by, &mut values, ITEMS as u32).unwrap();
        let got = backend.download(&values).unwrap();
        let results: Vec<(f32, f64, f64)> = got
            .iter()
            .zip(xs.iter().zip(&ys))
            .map(|(&got, (&x, &y))| {
                let truth = truth(f64::from(x), f64::from(y));
                // The truth itself is rounded, to float64.
                (got, truth, ulps(allowed, truth) * (1.0 + 1e-6))
            })
            .collect();
        verify(name, &results);
    }
}

fn non_zero(x: f32) -> f32 {
    if x == 0.0 { 1.0 } else { x }
}

/// Runs a pass that takes vectors.
fn evaluated<B: Backend, T: BufferElement>(
    backend: &mut B,
    inputs: &[Vec<Vec4>],
    run: impl FnOnce(&mut B, &[B::Buffer<Vec4>], &mut B::Buffer<T>),
) -> Vec<T> {
    let buffers: Vec<_> = inputs.iter().map(|i| backend.upload("input", i).unwrap()).collect();
    let mut output = backend.alloc("output", inputs[0].len()).unwrap();
    run(backend, &buffers, &mut output);
    backend.download(&output).unwrap()
}

fn corrected_opacity<B: Backend>(backend: &mut B, draw: &mut Draw) {
    let params = EvaluateParams { function: evaluate_cone::function::OPACITY, ..Default::default() };
    let a: Vec<Vec4> = (0..ITEMS)
        .map(|_| {
            let alpha = if draw.rarely(2) { draw.unit() } else { draw.positive(1e-20, 1.0) };
            Vec4::new(alpha, draw.positive(1e-6, 1e3), 0.0, 0.0)
        })
        .collect();
    let got: Vec<Vec4> = evaluated(backend, &[a.clone(), vec![Vec4::ZERO; ITEMS]], |backend, i, out| {
        backend.evaluate_cone(&params, &i[0], &i[1], out, ITEMS as u32).unwrap();
    });
    let results: Vec<_> = got
        .iter()
        .zip(&a)
        .map(|(got, a)| {
            let (alpha, ratio) = (f64::from(a.x), f64::from(a.y));
            let truth = if ratio == 0.0 { 0.0 } else { -(ratio * (-alpha).ln_1p()).exp_m1() };
            (got.x, truth, 3e-7 * truth + 1e-44)
        })
        .collect();
    verify("corrected opacity", &results);
}

fn specular_weight<B: Backend>(backend: &mut B, draw: &mut Draw) {
    let params = EvaluateParams { function: evaluate_gaussian::function::SPECULAR, ..Default::default() };
    let (mut a, mut b, mut c) = (Vec::new(), Vec::new(), Vec::new());
    for _ in 0..ITEMS {
        let axis = draw.direction();
        let off = draw.direction() * draw.positive(1e-4, 2.0);
        a.push(axis.extend(0.0));
        b.push((axis + off).try_normalize().unwrap_or(axis).extend(0.0));
        c.push(Vec4::new(draw.positive(1e-2, 1e3), draw.positive(0.08, 2.0), 0.0, 0.0));
    }
    let got: Vec<Vec4> = evaluated(backend, &[a, b, c.clone()], |backend, i, out| {
        backend.evaluate_gaussian(&params, &i[0], &i[1], &i[2], out, ITEMS as u32).unwrap();
    });
    let results: Vec<_> = got
        .iter()
        .zip(&c)
        .map(|(got, c)| {
            let gap = f64::from(got.x).min(1.0);
            let (exponent, deviation) = (f64::from(c.x), f64::from(c.y).max(1e-3));
            let x = if exponent == 0.0 { 0.0 } else { -(exponent * (-gap).ln_1p()).exp_m1() };
            let exponent = (0.5 * (x / deviation).powi(2)).min(87.0);
            let truth = (-exponent).exp() / (deviation * TAU.sqrt());
            (got.w, truth, (1e-6 + 4e-7 * exponent) * truth)
        })
        .collect();
    verify("specular weight", &results);
}

fn depth_coverage<B: Backend>(backend: &mut B, draw: &mut Draw) {
    let params = EvaluateParams { function: evaluate_gaussian::function::COVERAGE, ..Default::default() };
    let a: Vec<Vec4> = (0..ITEMS)
        .map(|_| {
            let of = |d: &mut Draw| d.uniform(-1.0, 1.0);
            Vec4::new(of(draw), draw.uniform(1e-3, 1.0), of(draw), draw.uniform(1e-3, 1.0))
        })
        .collect();
    let zero = vec![Vec4::ZERO; ITEMS];
    let got: Vec<Vec4> = evaluated(backend, &[a.clone(), zero.clone(), zero], |backend, i, out| {
        backend.evaluate_gaussian(&params, &i[0], &i[1], &i[2], out, ITEMS as u32).unwrap();
    });
    let results: Vec<_> = got
        .iter()
        .zip(&a)
        .map(|(got, a)| {
            let [mean, sigma, centre, radius] = a.to_array().map(f64::from);
            let at = |z: f64| oracle::erf(z / (sigma * 2f64.sqrt()));
            let truth = 0.5 * (at(centre - mean + radius) - at(centre - mean - radius));
            let reach = centre.abs() + mean.abs() + radius;
            // Below 0.05 σ the series is good to 1e-5.
            let series = if radius < 0.05 * sigma { 1e-5 * truth } else { 0.0 };
            (got.x, truth, 1.3e-7 + 0.4 * 2f64.powi(-24) * reach / sigma + series)
        })
        .collect();
    verify("depth coverage", &results);
}

/// The first 16 coefficients.
fn coefficients(v: &ShVector) -> [f32; 16] {
    let all: &[f32] = bytemuck::cast_slice(std::slice::from_ref(v));
    all[..16].try_into().unwrap()
}

fn order_4<B: Backend>(
    backend: &mut B,
    function: u32,
    a: &[ShVector],
    b: &[ShVector],
    arguments: &[Vec4],
) -> Vec<[f32; 16]> {
    let params = EvaluateParams { function, ..Default::default() };
    let (a, b) = (backend.upload("a", a).unwrap(), backend.upload("b", b).unwrap());
    let items = arguments.len();
    let arguments = backend.upload("arguments", arguments).unwrap();
    let mut output = backend.alloc("vectors", items).unwrap();
    backend.evaluate_sh4(&params, &a, &b, &arguments, &mut output, items as u32).unwrap();
    backend.download(&output).unwrap().iter().map(coefficients).collect()
}

fn basis<B: Backend>(backend: &mut B, draw: &mut Draw) {
    let arguments: Vec<Vec4> = (0..500).map(|_| draw.direction().extend(0.0)).collect();
    let none = vec![ShVector::default(); arguments.len()];
    let got = order_4(backend, evaluate_sh::function::BASIS, &none, &none, &arguments);
    let mut results = Vec::new();
    for (got, d) in got.iter().zip(&arguments) {
        let d = d.truncate().as_dvec3().normalize().to_array();
        let truth = sh_oracle::basis(4, d);
        // Per band, the rounding of the direction included.
        for (i, (&got, truth)) in got.iter().zip(truth).enumerate() {
            let band = (i as f64).sqrt() as usize;
            results.push((got, truth, [1.5e-8, 5.1e-8, 1.6e-7, 2.8e-7][band] + 1e-8));
        }
    }
    verify("basis", &results);
    // The oracle itself: band 0 and the function along z.
    assert!((sh_oracle::basis(4, [0.0, 0.0, 1.0])[2] - (3.0 / (4.0 * PI)).sqrt()).abs() < 1e-15);
}

fn products<B: Backend>(backend: &mut B, draw: &mut Draw) {
    let vector = |draw: &mut Draw| {
        let mut v = ShVector::default();
        let all: &mut [f32] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut v));
        all[..16].fill_with(|| draw.number(1e-3, 2.0));
        v
    };
    let a: Vec<ShVector> = (0..200).map(|_| vector(draw)).collect();
    let b: Vec<ShVector> = (0..200).map(|_| vector(draw)).collect();
    let got = order_4(backend, evaluate_sh::function::PRODUCT, &a, &b, &vec![Vec4::ZERO; 200]);
    let algebra = sh_oracle::Algebra::new(4);
    let mut results = Vec::new();
    for (got, (a, b)) in got.iter().zip(a.iter().zip(&b)) {
        let (a, b) = (coefficients(a).map(f64::from), coefficients(b).map(f64::from));
        let allowed = 2e-6 * sh_oracle::norm(&a) * sh_oracle::norm(&b);
        let truth = algebra.product(&a, &b);
        results.extend(got.iter().zip(truth).map(|(&got, truth)| (got, truth, allowed)));
    }
    verify("product", &results);
}
