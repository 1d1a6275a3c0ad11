//! Vector algebra, exact sums and products, conversions to integers.

use super::Settings;
use super::case::{Case, Head, Measure, NATIVE, Unit, number, numbers};
use super::device::{Work, split};
use super::draw::{Random, list};
use super::truth;
use glam::{Mat4, Vec4};
use twinlight_kernels::math::{self, strict};
use twinlight_kernels::passes::evaluate_vector::function;

type Pair = [Vec4; 2];

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    vec![
        dot(settings),
        dot4(settings),
        cross(settings),
        length(settings),
        frame::<false>(settings),
        frame::<true>(settings),
        transform(settings),
        two_sum(settings),
        two_product(settings),
        to_u32(settings),
        to_i32(settings),
    ]
}

fn pass(function: u32) -> impl Fn(&[Pair]) -> Work {
    move |all| Work::Vector(function, split(all))
}

/// Two vectors of components from −1 to 1.
fn pairs(settings: &Settings) -> Vec<Pair> {
    let one = |r: &mut Random| r.point(1.0).extend(r.range(-1.0, 1.0));
    list("pairs", settings.numbers, |r| [one(r), one(r)])
}

const COMPONENTS: &str = "components -1 to 1";

fn dot(settings: &Settings) -> Box<dyn Measure> {
    let error = |[a, b]: &Pair, got: &[f32; 1]| {
        let (a, b) = (a.truncate().as_dvec3(), b.truncate().as_dvec3());
        (f64::from(got[0]) - a.dot(b)).abs() / (a.length() * b.length())
    };
    Case::new(
        Head::strict("dot product", COMPONENTS, Unit::OfNorm),
        pairs(settings),
        |[a, b]| [math::dot(a.truncate(), b.truncate())],
        error,
    )
    .way(NATIVE, |[a, b]| [a.truncate().dot(b.truncate())])
    .on(pass(function::PRODUCTS), number::<0>)
    .boxed()
}

fn dot4(settings: &Settings) -> Box<dyn Measure> {
    let error = |[a, b]: &Pair, got: &[f32; 1]| {
        let (a, b) = (a.as_dvec4(), b.as_dvec4());
        (f64::from(got[0]) - a.dot(b)).abs() / (a.length() * b.length())
    };
    Case::new(
        Head::strict("dot product of four", COMPONENTS, Unit::OfNorm),
        pairs(settings),
        |[a, b]| [math::dot4(*a, *b)],
        error,
    )
    .way(NATIVE, |[a, b]| [a.dot(*b)])
    .on(pass(function::PRODUCTS), number::<1>)
    .boxed()
}

fn cross(settings: &Settings) -> Box<dyn Measure> {
    let error = |[a, b]: &Pair, got: &[f32; 3]| {
        let (a, b) = (a.truncate().as_dvec3(), b.truncate().as_dvec3());
        truth::distance(got, &a.cross(b).to_array()) / (a.length() * b.length())
    };
    Case::new(
        Head::strict("cross product", COMPONENTS, Unit::OfNorm),
        pairs(settings),
        |[a, b]| math::cross(a.truncate(), b.truncate()).to_array(),
        error,
    )
    .way(NATIVE, |[a, b]| a.truncate().cross(b.truncate()).to_array())
    .on(pass(function::CROSS), numbers)
    .boxed()
}

fn length(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("length", settings.numbers, |r| {
        [(r.direction() * r.positive(1e-3, 1e3)).extend(0.0), Vec4::ZERO]
    });
    Case::new(
        Head::strict("length", "1e-3 to 1e3", Unit::Relative),
        inputs,
        |[v, _]| [math::length(v.truncate())],
        |[v, _], got: &[f32; 1]| truth::relative(got[0], v.truncate().as_dvec3().length()),
    )
    .way(NATIVE, |[v, _]| [v.truncate().length()])
    .on(pass(function::PRODUCTS), number::<2>)
    .boxed()
}

fn frame<const BITANGENT: bool>(settings: &Settings) -> Box<dyn Measure> {
    let (variant, function) =
        if BITANGENT { ("bitangent", function::BITANGENT) } else { ("tangent", function::TANGENT) };
    Case::new(
        Head::new("frame of a direction", variant, "unit directions", Unit::Absolute),
        list("frame", settings.numbers, |r| [r.direction().extend(0.0), Vec4::ZERO]),
        |[n, _]| {
            let (t, b) = math::orthonormal_frame(n.truncate());
            (if BITANGENT { b } else { t }).to_array()
        },
        |[n, _], got: &[f32; 3]| {
            let (t, b, _) = truth::frame(n.truncate().as_dvec3());
            truth::distance(got, &(if BITANGENT { b } else { t }).to_array())
        },
    )
    .on(pass(function), numbers)
    .boxed()
}

/// The matrix that the pass makes of two vectors; the point is the second.
fn matrix([a, b]: &Pair) -> Mat4 {
    Mat4::from_cols(*a, Vec4::new(a.y, a.z, a.w, a.x), Vec4::new(a.z, a.w, a.x, a.y), *b)
}

fn transform(settings: &Settings) -> Box<dyn Measure> {
    let error = |x: &Pair, got: &[f32; 3]| {
        let (m, p) = (matrix(x).as_dmat4(), x[1].truncate().as_dvec3());
        let columns = m.x_axis.length() + m.y_axis.length() + m.z_axis.length();
        let scale = columns * p.length() + m.w_axis.length();
        truth::distance(got, &m.transform_point3(p).to_array()) / scale
    };
    Case::new(
        Head::strict("transformed point", COMPONENTS, Unit::OfNorm),
        pairs(settings),
        |x| math::transform_point(&matrix(x), x[1].truncate()).to_array(),
        error,
    )
    .way(NATIVE, |x| matrix(x).transform_point3(x[1].truncate()).to_array())
    .on(pass(function::TRANSFORM), numbers)
    .boxed()
}

fn numbers_of_two(settings: &Settings) -> Vec<(f32, f32)> {
    // Sums and products of these are exact in float64.
    list("two", settings.numbers, |r| (r.signed(1e-3, 1e3), r.signed(1e-3, 1e3)))
}

/// The sum of both results against the exact one.
fn exact(got: &[f32; 2], truth: f64) -> f64 {
    let difference = f64::from(got[0]) + f64::from(got[1]) - truth;
    if difference == 0.0 { 0.0 } else { difference.abs() / truth.abs() }
}

fn two_sum(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("exact sum", "1e-3 to 1e3", Unit::Relative).stated(0.0),
        numbers_of_two(settings),
        |(a, b)| strict::two_sum(*a, *b).into(),
        |(a, b), got| exact(got, f64::from(*a) + f64::from(*b)),
    )
    .boxed()
}

fn two_product(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("exact product", "1e-3 to 1e3", Unit::Relative).stated(0.0),
        numbers_of_two(settings),
        |(a, b)| strict::two_product(*a, *b).into(),
        |(a, b), got| exact(got, f64::from(*a) * f64::from(*b)),
    )
    .way("fused multiply-add", |(a, b)| [a * b, a.mul_add(*b, -(a * b))])
    .boxed()
}

/// Results are below 2²⁴ or multiples of a power of two: f32 holds them.
fn to_u32(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("to_u32", "1e-3 to 1e10, either sign", Unit::Wrong).stated(0.0),
        list("to_u32", settings.numbers, |r| [Vec4::new(0.0, r.signed(1e-3, 1e10), 0.0, 0.0), Vec4::ZERO]),
        |[x, _]| [math::to_u32(x.y) as f32],
        |[x, _], got| truth::wrong(&f64::from(got[0]), &f64::from(x.y).trunc().clamp(0.0, 4_294_967_040.0)),
    )
    .way(NATIVE, |[x, _]| [(x.y as u32).min(4_294_967_040) as f32])
    .on(pass(function::EXPONENTS), number::<1>)
    .boxed()
}

fn to_i32(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("to_i32", "1e-3 to 1e10, either sign", Unit::Wrong).stated(0.0),
        list("to_i32", settings.numbers, |r| r.signed(1e-3, 1e10)),
        |x| math::to_i32(*x) as u32,
        |x, got| {
            let whole = f64::from(*x).trunc().clamp(-2_147_483_520.0, 2_147_483_520.0);
            truth::wrong(&f64::from(*got as i32), &whole)
        },
    )
    .way(NATIVE, |x| (*x as i32).clamp(-2_147_483_520, 2_147_483_520) as u32)
    .boxed()
}
