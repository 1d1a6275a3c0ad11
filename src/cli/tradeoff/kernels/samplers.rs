//! Directions, points and cones that stand for a hemisphere or a triangle, and decisions by chance.

use super::Settings;
use super::case::{Case, Head, Measure, NAIVE, NATIVE, Unit, number, numbers};
use super::device::{Work, split};
use super::draw::{Random, list};
use super::truth;
use glam::{DVec3, UVec4, Vec2, Vec3, Vec4};
use std::f32::consts::TAU;
use twinlight_kernels::math::normalize_or;
use twinlight_kernels::passes::evaluate_sampling::function;
use twinlight_kernels::sampling::halton::{halton, rotated};
use twinlight_kernels::sampling::hash::unit_float;
use twinlight_kernels::sampling::{hemisphere, roulette};

/// Integers and two vectors, as the pass takes them.
type Sample = (UVec4, [Vec4; 2]);

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let mut all = vec![cosine(settings)];
    all.extend([1.0, 10.0, 100.0, 1000.0].map(|exponent| phong(settings, exponent)));
    all.extend([1.0, 10.0, 100.0, 1000.0].map(|exponent| phong_sine(settings, exponent)));
    all.extend([
        to_world(settings),
        barycentrics(settings),
        point(settings),
        cone(settings),
        tangent(settings),
        share(settings),
        rotation(settings),
        acceptance(settings),
        count(settings),
    ]);
    all
}

fn pass(function: u32) -> impl Fn(&[Sample]) -> Work {
    move |all| {
        let vectors: Vec<_> = all.iter().map(|s| s.1).collect();
        Work::Sampling(function, all.iter().map(|s| s.0).collect(), split(&vectors))
    }
}

fn square(r: &mut Random) -> Vec2 {
    Vec2::new(r.range(0.0, 1.0), r.range(0.0, 1.0))
}

/// The direction of a sine, a cosine and an azimuth in turns.
fn turned(sine: f64, cosine: f64, turn: f64) -> DVec3 {
    let (s, c) = truth::sin_cos_turn(turn);
    DVec3::new(sine * c, sine * s, cosine)
}

fn true_cosine(u: Vec2) -> DVec3 {
    let u = u.as_dvec2();
    turned(u.x.sqrt(), (1.0 - u.x).sqrt(), u.y)
}

fn cosine(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("cosine hemisphere", "unit square", Unit::Absolute),
        list("cosine", settings.numbers, square),
        |u| hemisphere::cosine_hemisphere(*u).to_array(),
        |u, got: &[f32; 3]| truth::distance(got, &true_cosine(*u).to_array()),
    )
    .way(NATIVE, |u| {
        let ((s, c), r) = ((u.y * TAU).sin_cos(), u.x.sqrt());
        [r * c, r * s, (1.0 - u.x).sqrt()]
    })
    .boxed()
}

/// Sine and cosine of the tilt.
fn true_phong(u: Vec2, exponent: f32) -> (f64, f64) {
    let log = (-f64::from(u.x)).ln_1p() / (f64::from(exponent) + 1.0);
    ((-(2.0 * log).exp_m1()).sqrt(), log.exp())
}

/// As one writes it.
fn naive_phong(u: Vec2, exponent: f32) -> [f32; 3] {
    let cosine = (1.0 - u.x).powf(1.0 / (exponent + 1.0));
    let ((s, c), r) = ((u.y * TAU).sin_cos(), (1.0 - cosine * cosine).max(0.0).sqrt());
    [r * c, r * s, cosine]
}

fn phong(settings: &Settings, exponent: f32) -> Box<dyn Measure> {
    Case::new(
        Head::new("Phong lobe", &format!("exponent {exponent}"), "unit square", Unit::Absolute),
        list("Phong", settings.numbers, square),
        move |u| hemisphere::phong_lobe_direction(*u, exponent).to_array(),
        move |u, got: &[f32; 3]| {
            let (sine, cosine) = true_phong(*u, exponent);
            truth::distance(got, &turned(sine, cosine, f64::from(u.y)).to_array())
        },
    )
    .way(NAIVE, move |u| naive_phong(*u, exponent))
    .boxed()
}

/// What narrow lobes lose: the sine of the tilt.
fn phong_sine(settings: &Settings, exponent: f32) -> Box<dyn Measure> {
    Case::new(
        Head::new("Phong lobe, sine", &format!("exponent {exponent}"), "u to 1e-6", Unit::Relative),
        list("Phong sine", settings.numbers, |r| Vec2::new(r.positive(1e-6, 0.99), r.range(0.0, 1.0))),
        move |u| hemisphere::phong_lobe_direction(*u, exponent).to_array(),
        move |u, got: &[f32; 3]| {
            let sine = f64::from(got[0]).hypot(f64::from(got[1]));
            let truth = true_phong(*u, exponent).0;
            (sine - truth).abs() / truth
        },
    )
    .way(NAIVE, move |u| naive_phong(*u, exponent))
    .boxed()
}

fn samples(settings: &Settings) -> Vec<Sample> {
    list("samples", settings.numbers, |r| {
        let (u, rest) = (square(r), square(r));
        (UVec4::ZERO, [Vec4::new(u.x, u.y, rest.x, rest.y), r.direction().extend(r.range(-1.0, 1.0))])
    })
}

/// A cosine-distributed direction about any normal, which the pass makes a unit vector first.
fn to_world(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("direction in space", "unit square, any normal", Unit::Absolute),
        samples(settings),
        |(_, [u, n])| {
            let local = hemisphere::cosine_hemisphere(Vec2::new(u.x, u.y));
            hemisphere::to_world(local, normalize_or(n.truncate(), Vec3::Y)).to_array()
        },
        |(_, [u, n]), got: &[f32; 3]| {
            let (t, b, n) = truth::frame(n.truncate().as_dvec3());
            let d = true_cosine(Vec2::new(u.x, u.y));
            truth::distance(got, &(t * d.x + b * d.y + n * d.z).to_array())
        },
    )
    .on(pass(function::COSINE_HEMISPHERE), numbers)
    .boxed()
}

fn folded(u: Vec4) -> DVec3 {
    let u = u.as_dvec4();
    let (a, b) = if u.x + u.y > 1.0 { (1.0 - u.x, 1.0 - u.y) } else { (u.x, u.y) };
    DVec3::new(1.0 - a - b, a, b)
}

fn barycentrics(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("folded weights", "unit square", Unit::Absolute),
        samples(settings),
        |(_, [u, _])| hemisphere::fold_barycentrics(Vec2::new(u.x, u.y)).to_array(),
        |(_, [u, _]), got: &[f32; 3]| truth::largest(got, &folded(*u).to_array()),
    )
    .on(pass(function::BARYCENTRICS), numbers)
    .boxed()
}

/// The corners that the pass makes of its vectors.
fn corners([x, y]: &[Vec4; 2]) -> [Vec3; 3] {
    [y.truncate(), Vec3::new(y.y, y.z, y.w), Vec3::new(x.z, x.w, y.x)]
}

fn point(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("point of a triangle", "corners within 1", Unit::Absolute),
        samples(settings),
        |(_, x)| {
            let ([a, b, c], u) = (corners(x), Vec2::new(x[0].x, x[0].y));
            hemisphere::triangle_point(a, b, c, hemisphere::fold_barycentrics(u)).to_array()
        },
        |(_, x), got: &[f32; 3]| {
            let ([a, b, c], w) = (corners(x).map(|p| p.as_dvec3()), folded(x[0]));
            truth::distance(got, &(a * w.x + b * w.y + c * w.z).to_array())
        },
    )
    .on(pass(function::TRIANGLE_POINT), numbers)
    .boxed()
}

/// Count, index and turn.
fn sets(settings: &Settings) -> Vec<Sample> {
    list("cones", settings.numbers, |r| {
        let count = 1 + r.bits() % 32;
        (UVec4::new(count, r.bits() % count, 0, 0), [Vec4::splat(r.range(0.0, 1.0)), Vec4::ZERO])
    })
}

/// Direction, weight, tangent, as the kernel's documentation describes its sets, with angles.
fn true_cone(count: u32, index: u32, turn: f64) -> (DVec3, f64, f64) {
    let (n, i) = (f64::from(count), f64::from(index));
    let half = (1.0 - 6.0 * (1.0 - 30f64.to_radians().cos()) / n).acos();
    let right = 90f64.to_radians();
    let (tilt, place, weight) = match count {
        1 => (0.0, 0.0, 1.0),
        2..=4 => (0.5 * right, i / n, 1.0 / n),
        5..=8 if index == 0 => (0.0, 0.0, half.sin().powi(2)),
        5..=8 => (0.5 * (half + right), (i - 1.0) / (n - 1.0), half.cos().powi(2) / (n - 1.0)),
        _ => (((i + 0.5) / n).sqrt().asin(), i * (1.0 - 2.0 / (1.0 + 5f64.sqrt())), 1.0 / n),
    };
    (turned(tilt.sin(), tilt.cos(), place + turn), weight, half.tan())
}

fn cone(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new("cone of a set", "axis and weight", "sets of 1 to 32", Unit::Absolute),
        sets(settings),
        |(w, [x, _])| {
            let cone = hemisphere::cone(w.x, w.y, x.x);
            cone.direction.extend(cone.weight).to_array()
        },
        |(w, [x, _]), got: &[f32; 4]| {
            let (d, weight, _) = true_cone(w.x, w.y, f64::from(x.x));
            truth::distance(got, &d.extend(weight).to_array())
        },
    )
    .on(pass(function::CONE), numbers)
    .boxed()
}

fn tangent(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new("cone of a set", "tangent", "sets of 1 to 32", Unit::Relative),
        sets(settings),
        |(w, [x, _])| [hemisphere::cone(w.x, w.y, x.x).tangent],
        |(w, _), got| truth::relative(got[0], true_cone(w.x, w.y, 0.0).2),
    )
    .on(pass(function::CONE_TANGENT), number::<0>)
    .boxed()
}

fn share(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("number of a hash", "32-bit integers", Unit::Absolute).stated(0.0),
        list("unit floats", settings.numbers, |r| (UVec4::new(r.bits(), 0, 0, 0), [Vec4::ZERO; 2])),
        |(w, _)| [unit_float(w.x)],
        |(w, _), got: &[f32; 1]| (f64::from(got[0]) - (f64::from(w.x) / 256.0).floor() / 16_777_216.0).abs(),
    )
    .on(pass(function::HASH), number::<0>)
    .boxed()
}

/// Differences count around the circle.
fn rotation(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("rotated point", "Halton points, any shift", Unit::Absolute),
        list("rotation", settings.numbers, |r| (UVec4::new(r.bits() >> 8, r.bits(), 0, 0), [Vec4::ZERO; 2])),
        |(w, _)| [rotated(halton(w.x).x, unit_float(w.y))],
        |(w, _), got| {
            let inverse = f64::from(w.x.reverse_bits()) / 4_294_967_296.0;
            let shift = (f64::from(w.y) / 256.0).floor() / 16_777_216.0;
            let apart = (f64::from(got[0]) - (inverse + shift).fract()).abs();
            apart.min(1.0 - apart)
        },
    )
    .on(pass(function::HALTON), number::<2>)
    .boxed()
}

/// Hashes, an expected number and a probability.
fn chances(settings: &Settings) -> Vec<Sample> {
    list("chances", settings.numbers, |r| {
        let x = Vec4::new(r.positive(1e-3, 1e3), r.range(0.0, 1.0), 0.0, 0.0);
        (UVec4::new(r.bits(), r.bits(), 0, 0), [x, Vec4::ZERO])
    })
}

/// Whether a number of 24 random bits is below p.
fn below(hash: u32, p: f64) -> bool {
    (f64::from(hash) / 256.0).floor() / 16_777_216.0 < p
}

fn acceptance(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("acceptance", "probabilities 0 to 1", Unit::Wrong),
        chances(settings),
        |(w, [x, _])| u32::from(roulette::accept(w.y, x.y)),
        |(w, [x, _]), got| truth::wrong(&(*got == 1), &below(w.y, f64::from(x.y))),
    )
    .on(pass(function::ROULETTE), |words| words[5])
    .boxed()
}

fn count(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("sample count", "1e-3 to 1e3 expected", Unit::Wrong),
        chances(settings),
        |(w, [x, _])| roulette::sample_count(x.x, w.x),
        |(w, [x, _]), got| {
            let expected = f64::from(x.x);
            truth::wrong(got, &(expected.floor() as u32 + u32::from(below(w.x, expected.fract()))))
        },
    )
    .on(pass(function::ROULETTE), |words| words[4])
    .boxed()
}
