//! What else is done with spherical harmonics: values, sums, zonal functions, what many blockers cover.

use super::Settings;
use super::case::{Case, Head, Measure, NAIVE, OnDevice, Unit, numbers};
use super::device::Work;
use super::draw::{Random, list};
use super::harmonics::{device, random, vector};
use super::truth::{self, Algebra};
use crate::technique::soft_gi::{ENTRIES, log_occlusion_table};
use glam::{Vec3, Vec4};
use std::rc::Rc;
use twinlight_kernels::passes::elements::ShVector;
use twinlight_kernels::passes::evaluate_sh::{exponential, function};
use twinlight_kernels::sh;

/// Those of an order.
pub(super) fn order<const B: usize, const N: usize>(settings: &Settings) -> Vec<Box<dyn Measure>> {
    vec![
        value::<B, N>(settings),
        dot::<B, N>(settings),
        projection::<B, N>(settings),
        solid_angle::<B>(settings),
        visibility::<B, N>(settings),
        convolution::<B, N>(settings),
        irradiance::<B, N>(settings),
        norm::<B, N>(settings),
        feasible::<B, N>(settings),
        occluded::<B, N>(settings),
    ]
}

fn head(kernel: &'static str, order: usize, domain: &'static str, unit: Unit) -> Head {
    Head::new(kernel, &format!("order {order}"), domain, unit)
}

const COEFFICIENTS: &str = "coefficients -1 to 1";

/// A vector and a direction.
type Seen<const N: usize> = ([f32; N], Vec3);

fn seen<const N: usize>(r: &mut Random) -> Seen<N> {
    (random(r), r.direction())
}

fn sum(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn basis(order: usize, d: &Vec3) -> Vec<f64> {
    truth::basis(order, d.as_dvec3().to_array())
}

/// Coefficients of band l times the band's factor.
fn by_bands(f: &[f64], factor: impl Fn(usize) -> f64) -> Vec<f64> {
    f.iter().enumerate().map(|(i, c)| c * factor(i.isqrt())).collect()
}

/// √(4π/(2l + 1)) of convolution.
fn band(l: usize) -> f64 {
    truth::unit() / ((2 * l + 1) as f64).sqrt()
}

fn value<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    let mut case = Case::new(
        head("SH value", B, COEFFICIENTS, Unit::OfNorm),
        list("values", settings.vectors, seen::<N>),
        |(f, d)| [sh::evaluate(f, *d)],
        |(f, d), got: &[f32; 1]| {
            let f = truth::wide(f);
            (f64::from(got[0]) - sum(&f, &basis(B, d))).abs() / truth::norm(&f)
        },
    );
    case.device =
        device::<B, Seen<N>, 1>(function::VALUE, |(f, d)| (vector(f), ShVector::default(), d.extend(0.0)));
    case.boxed()
}

fn dot<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        head("SH dot product", B, COEFFICIENTS, Unit::OfNorm),
        list("dots", settings.vectors, |r| (random::<N>(r), random::<N>(r))),
        |(a, b)| [sh::dot(a, b)],
        |(a, b), got: &[f32; 1]| {
            let (a, b) = (truth::wide(a), truth::wide(b));
            (f64::from(got[0]) - sum(&a, &b)).abs() / (truth::norm(&a) * truth::norm(&b))
        },
    )
    .boxed()
}

/// A sum with one sample more.
fn projection<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        head("SH projection", B, "coefficients and samples -1 to 1", Unit::OfNorm),
        list("projections", settings.vectors, |r| (seen::<N>(r), r.range(-1.0, 1.0))),
        |((f, d), sample)| sh::project(f, *d, *sample),
        |((f, d), sample), got: &[f32; N]| {
            let (f, y) = (truth::wide(f), basis(B, d));
            let truth: Vec<f64> = f.iter().zip(&y).map(|(f, y)| f + f64::from(*sample) * y).collect();
            truth::distance(got, &truth) / (truth::norm(&f) + truth::norm(&y))
        },
    )
    .boxed()
}

fn sines(settings: &Settings) -> Vec<(f32, Vec3)> {
    list("sines", settings.vectors, |r| (r.positive(0.02, 1.0), r.direction()))
}

/// A cap about a direction, as the pass takes it.
fn capped(x: &(f32, Vec3)) -> (ShVector, ShVector, Vec4) {
    (ShVector::default(), ShVector::default(), x.1.extend(x.0))
}

/// The pass gives it as the last number.
fn solid_angle<const B: usize>(settings: &Settings) -> Box<dyn Measure> {
    let mut case = Case::new(
        head("SH cap's solid angle", B, "sin 0.02 to 1", Unit::Relative),
        sines(settings),
        |(alpha, _)| [sh::cap_solid_angle(*alpha)],
        |(alpha, _), got| {
            let (alpha, turn) = (f64::from(*alpha), 2.0 * std::f64::consts::PI);
            truth::relative(got[0], turn * (2.0 * (0.5 * alpha.asin()).sin().powi(2)))
        },
    )
    .way(NAIVE, |(alpha, _)| [std::f32::consts::TAU * (1.0 - (1.0 - alpha * alpha).sqrt())]);
    case.device = device::<B, _, 1>(function::CAP, capped);
    if let Some(device) = &mut case.device {
        device.read = |words| [f32::from_bits(words[B * B - 1])];
    }
    case.boxed()
}

fn visibility<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    let mut case = Case::new(
        head("SH visibility", B, "sin 0.02 to 1, any direction", Unit::OfNorm).stated(2e-6),
        sines(settings),
        |(alpha, d)| sh::rotate_zonal::<B, N>(&sh::visibility::<B>(*alpha), *d),
        |(alpha, d), got: &[f32; N]| {
            let whole = |l: usize| if l == 0 { truth::unit() } else { 0.0 };
            let zonal = |l: usize| whole(l) - truth::cap(l, f64::from(*alpha));
            let truth = by_bands(&basis(B, d), |l| band(l) * zonal(l));
            truth::distance(got, &truth) / truth::norm(&truth)
        },
    );
    case.device = device::<B, _, N>(function::ZONAL, capped);
    case.boxed()
}

fn convolution<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        head("SH convolution", B, COEFFICIENTS, Unit::OfNorm),
        list("convolutions", settings.vectors, |r| (random::<N>(r), random::<B>(r))),
        |(f, g)| sh::convolve::<B, N>(f, g),
        |(f, g), got: &[f32; N]| {
            let truth = by_bands(&truth::wide(f), |l| band(l) * f64::from(g[l]));
            truth::distance(got, &truth) / truth::norm(&truth)
        },
    )
    .boxed()
}

fn irradiance<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    let cosine: Vec<f64> = (0..B).map(truth::clamped_cosine).collect();
    let mut case = Case::new(
        head("SH irradiance", B, COEFFICIENTS, Unit::OfNorm),
        list("irradiance", settings.vectors, random::<N>),
        sh::irradiance::<B, N>,
        move |f, got: &[f32; N]| {
            let truth = by_bands(&truth::wide(f), |l| band(l) * cosine[l]);
            truth::distance(got, &truth) / truth::norm(&truth)
        },
    );
    case.device =
        device::<B, [f32; N], N>(function::IRRADIANCE, |f| (vector(f), ShVector::default(), Vec4::Z));
    case.boxed()
}

/// The pass of exponentials with τ = ½ and no table; orders 3 and 4 have one.
fn covered<const B: usize, const N: usize>(
    number: fn(&[u32]) -> [f32; 1],
) -> Option<OnDevice<[f32; N], [f32; 1]>> {
    (B == 3 || B == 4).then(|| OnDevice {
        work: Box::new(|all: &[[f32; N]]| {
            let (vectors, arguments) =
                (all.iter().map(|f| vector(f)).collect(), vec![Vec4::splat(0.5); all.len()]);
            Work::Exponential(B as u32, exponential::OCCLUDED, vectors, arguments, vec![0.0], 1)
        }),
        read: number,
        software: false,
    })
}

fn norm<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    let mut case = Case::new(
        head("SH norm without DC", B, COEFFICIENTS, Unit::Relative),
        list("norms", settings.vectors, random::<N>),
        |f| [sh::norm_without_dc(f)],
        |f, got| truth::relative(got[0], truth::norm(&truth::wide(&f[1..]))),
    );
    case.device = covered::<B, N>(|words| [f32::from_bits(words[1])]);
    case.boxed()
}

/// Shares of √4π: the ball's size.
fn feasible<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("feasible", settings.vectors, |r| -> [f32; N] {
        let size = r.range(0.1, 2.0);
        let mut g = random::<N>(r).map(|c| c * size);
        g[0] = r.range(-0.2, 4.0);
        g
    });
    let mut case = Case::new(
        head("SH clamp", B, "coefficients to 2, the first -0.2 to 4", Unit::Sphere),
        inputs,
        sh::clamp_to_feasible,
        |g, got: &[f32; N]| {
            let mut truth = truth::wide(g);
            truth[0] = truth[0].clamp(0.0, truth::unit());
            let (norm, most) = (truth::norm(&truth[1..]), (truth[0] * (truth::unit() - truth[0])).sqrt());
            let scale = if norm > most { most / norm } else { 1.0 };
            truth[1..].iter_mut().for_each(|c| *c *= scale);
            truth::distance(got, &truth) / truth::unit()
        },
    );
    case.device = device::<B, [f32; N], N>(function::CLAMP, |g| (vector(g), ShVector::default(), Vec4::Z));
    case.boxed()
}

/// One blocker at τ = ½, against the exponential of the same logarithm.
fn occluded<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    let (table, algebra) = (log_occlusion_table(B, ENTRIES as usize), Algebra::new(B));
    let inputs = list("occluded", settings.sets, |r| -> [f32; N] {
        let zonal = sh::log_occlusion::<B>(&table, ENTRIES, sh::occlusion_key(r.positive(0.005, 0.2)));
        sh::rotate_zonal(&zonal, r.direction())
    });
    let truths = inputs.iter().map(|f| truth::unit() - algebra.exponential(&truth::wide(f))[0]);
    let truths: Rc<Vec<f64>> = Rc::new(truths.collect());
    let mut case = Case::new(
        head("SH coverage", B, "one blocker, sin 0.005 to 0.2", Unit::Relative).stated(1e-5),
        inputs,
        |f| [sh::occluded_dc(f, &sh::hybrid(f, 0.5), 0.5)],
        |_, _| 0.0,
    )
    .way(NAIVE, |f| [sh::UNIT - sh::hybrid(f, 0.5)[0]]);
    case.error = Box::new(move |i, _, got| truth::relative(got[0], truths[i]));
    case.device = covered::<B, N>(numbers::<1>);
    case.boxed()
}
