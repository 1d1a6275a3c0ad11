//! Spherical harmonics by order: basis, products, rotation, caps.

use super::Settings;
use super::case::{Case, Head, Measure, OnDevice, Unit, each, numbers};
use super::coefficients;
use super::device::Work;
use super::draw::{Random, list};
use super::truth::{self, Algebra};
use glam::{Mat3, Vec3, Vec4};
use std::rc::Rc;
use twinlight_kernels::math::orthonormal_frame;
use twinlight_kernels::passes::elements::ShVector;
use twinlight_kernels::passes::evaluate_sh::function;
use twinlight_kernels::sh;

/// Coefficients as the passes take them.
pub(super) fn vector(c: &[f32]) -> ShVector {
    let at = |i: usize| c.get(i).copied().unwrap_or(0.0);
    let four = |i: usize| Vec4::new(at(i), at(i + 1), at(i + 2), at(i + 3));
    ShVector {
        c0: four(0),
        c4: four(4),
        c8: four(8),
        c12: four(12),
        c16: four(16),
        c20: four(20),
        c24: Vec4::new(at(24), 0.0, 0.0, 0.0),
    }
}

/// A vector of normal size.
pub(super) fn random<const N: usize>(r: &mut Random) -> [f32; N] {
    std::array::from_fn(|_| r.range(-1.0, 1.0))
}

fn wide(d: Vec3) -> [f64; 3] {
    d.as_dvec3().to_array()
}

/// Every order.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let mut all = order::<2, 4>(settings);
    all.extend(order::<3, 9>(settings));
    all.extend(order::<4, 16>(settings));
    all.extend(order::<5, 25>(settings));
    all.sort_by_key(|case| case.head().kernel);
    all
}

fn order<const B: usize, const N: usize>(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let algebra = Rc::new(Algebra::new(B));
    let mut all = vec![
        basis::<B, N>(settings),
        cap::<B>(settings),
        product::<B, N>(settings, algebra.clone()),
        square::<B, N>(settings, algebra),
        rotation::<B, N>(settings),
    ];
    all.extend(coefficients::order::<B, N>(settings));
    all
}

/// How the pass of an order runs; order 2 has none.
pub(super) fn device<const B: usize, I: Copy, const N: usize>(
    number: u32,
    inputs: impl Fn(&I) -> (ShVector, ShVector, Vec4) + 'static,
) -> Option<OnDevice<I, [f32; N]>> {
    (B > 2).then(|| OnDevice {
        work: Box::new(move |all: &[I]| {
            let (mut a, mut b, mut arguments) = (Vec::new(), Vec::new(), Vec::new());
            for (x, y, z) in all.iter().map(&inputs) {
                a.push(x);
                b.push(y);
                arguments.push(z);
            }
            Work::Harmonics(B as u32, number, [a, b], arguments)
        }),
        read: numbers::<N>,
        software: false,
    })
}

fn head(kernel: &'static str, order: usize, domain: &'static str, unit: Unit, stated: f64) -> Head {
    Head::new(kernel, &format!("order {order}"), domain, unit).stated(stated)
}

fn basis<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    let stated = [0.0, 0.0, 5.1e-8, 1.6e-7, 2.8e-7, 5.4e-7][B];
    Box::new(Case {
        head: head("SH basis", B, "unit directions", Unit::Absolute, stated),
        inputs: list("basis", settings.vectors, Random::direction),
        strict: each(|d: &Vec3| sh::basis::<N>(*d)),
        others: Vec::new(),
        error: Box::new(|_, d, y: &[f32; N]| truth::largest(y, &truth::basis(B, wide(*d)))),
        device: device::<B, Vec3, N>(function::BASIS, |d| {
            (ShVector::default(), ShVector::default(), d.extend(0.0))
        }),
    })
}

fn cap<const B: usize>(settings: &Settings) -> Box<dyn Measure> {
    Box::new(Case {
        head: head("SH cap", B, "sin 0.02 to 1", Unit::OfNorm, 3e-7),
        inputs: list("cap", settings.vectors, |r| r.positive(0.02, 1.0)),
        strict: each(|alpha: &f32| sh::cap::<B>(*alpha)),
        others: Vec::new(),
        error: Box::new(|_, alpha, got: &[f32; B]| {
            let truth: Vec<f64> = (0..B).map(|l| truth::cap(l, f64::from(*alpha))).collect();
            truth::distance(got, &truth) / truth::norm(&truth)
        }),
        device: device::<B, f32, B>(function::CAP, |alpha| {
            (ShVector::default(), ShVector::default(), Vec4::new(0.0, 0.0, 1.0, *alpha))
        }),
    })
}

fn product<const B: usize, const N: usize>(settings: &Settings, algebra: Rc<Algebra>) -> Box<dyn Measure> {
    Box::new(Case {
        head: head("SH product", B, "coefficients -1 to 1", Unit::OfNorm, 2e-6),
        inputs: list("product", settings.vectors, |r| (random::<N>(r), random::<N>(r))),
        strict: each(|(a, b): &([f32; N], [f32; N])| sh::product(a, b)),
        others: Vec::new(),
        error: Box::new(move |_, (a, b), got: &[f32; N]| {
            let (a, b) = (truth::wide(a), truth::wide(b));
            truth::distance(got, &algebra.product(&a, &b)) / (truth::norm(&a) * truth::norm(&b))
        }),
        device: device::<B, _, N>(function::PRODUCT, |(a, b): &([f32; N], [f32; N])| {
            (vector(a), vector(b), Vec4::Z)
        }),
    })
}

fn square<const B: usize, const N: usize>(settings: &Settings, algebra: Rc<Algebra>) -> Box<dyn Measure> {
    Box::new(Case {
        head: head("SH square", B, "coefficients -1 to 1", Unit::OfNorm, 2e-6),
        inputs: list("square", settings.vectors, random::<N>),
        strict: each(sh::square::<N>),
        others: Vec::new(),
        error: Box::new(move |_, a, got: &[f32; N]| {
            let a = truth::wide(a);
            truth::distance(got, &algebra.product(&a, &a)) / truth::norm(&a).powi(2)
        }),
        device: device::<B, _, N>(function::SQUARE, |a: &[f32; N]| (vector(a), ShVector::default(), Vec4::Z)),
    })
}

/// A direction, the frame about it that the pass makes of it, and a vector.
type Turned<const N: usize> = (Vec3, Mat3, [f32; N]);

fn rotation<const B: usize, const N: usize>(settings: &Settings) -> Box<dyn Measure> {
    let inputs: Vec<Turned<N>> = list("rotation", settings.vectors, |r| {
        let d = r.direction();
        let (t, b) = orthonormal_frame(d);
        (d, Mat3::from_cols(t, b, d), random(r))
    });
    let points: Vec<_> = truth::sphere(B + 1).into_iter().map(|(d, w)| (d, w, truth::basis(B, d))).collect();
    Box::new(Case {
        head: head("SH rotation", B, "frames of directions", Unit::OfNorm, 2e-6),
        inputs,
        strict: each(|(_, m, f): &Turned<N>| sh::rotate(m, f)),
        others: Vec::new(),
        error: Box::new(move |_, (_, m, f), got: &[f32; N]| {
            let (f, back) = (truth::wide(f), m.as_dmat3().transpose());
            let mut turned = vec![0.0; N];
            for (d, w, y) in &points {
                let there = truth::basis(B, (back * glam::DVec3::from_array(*d)).to_array());
                let value: f64 = there.iter().zip(&f).map(|(y, c)| y * c).sum();
                turned.iter_mut().zip(y).for_each(|(t, y)| *t += w * value * y);
            }
            truth::distance(got, &turned) / truth::norm(&f)
        }),
        device: device::<B, _, N>(function::ROTATE, |(d, _, f): &Turned<N>| {
            (vector(f), ShVector::default(), d.extend(0.0))
        }),
    })
}
