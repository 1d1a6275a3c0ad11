//! How much of a small light arrives: form factors and laws of distance.

use super::Settings;
use super::case::{Case, Head, Measure, NAIVE, NATIVE, Unit, number};
use super::device::{Work, split};
use super::draw::list;
use super::truth;
use glam::{UVec4, Vec3, Vec4};
use std::f64::consts::PI;
use twinlight_kernels::math::normalize_or;
use twinlight_kernels::passes::evaluate_sampling::function;
use twinlight_kernels::sampling::attenuation as kernels;

type Pair = [Vec4; 2];

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    vec![
        disc(settings),
        light(settings),
        bounded(settings),
        clamped(settings),
        window(settings),
        radius(settings),
    ]
}

fn pass(function: u32) -> impl Fn(&[Pair]) -> Work {
    move |all| Work::Sampling(function, vec![UVec4::ZERO; all.len()], split(all))
}

/// Two cosines, distance squared, area.
fn disc(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("discs' light", settings.numbers, |r| {
        let cosines = [r.range(0.01, 1.0), r.range(0.01, 1.0)];
        [Vec4::new(cosines[0], cosines[1], r.positive(1e-6, 1e4), r.positive(1e-4, 1e2)), Vec4::Y]
    });
    Case::new(
        Head::strict("form factor of a disc", "distances 1e-3 to 100", Unit::Relative),
        inputs,
        |[x, _]| [kernels::disc_form_factor(x.x, x.y, x.z, x.w)],
        |[x, _], got| {
            let x = x.as_dvec4();
            truth::relative(got[0], x.w * x.x * x.y / (PI * x.z + x.w))
        },
    )
    .way(NATIVE, |[x, _]| [x.w * x.x * x.y / (std::f32::consts::PI * x.z + x.w)])
    .on(pass(function::FORM_FACTOR), number::<0>)
    .boxed()
}

/// Receiver and area; emitter, whose last two numbers and another make the receiver's normal, as the pass takes them.
fn normals(y: &Vec4) -> (Vec3, Vec3) {
    let n = normalize_or(Vec3::new(y.y, y.z, y.w), Vec3::Y);
    (n, Vec3::new(-n.y, n.z, -n.x))
}

/// Over what both cosines multiply: where one is near 0 it is a difference.
fn light(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("lights", settings.numbers, |r| {
        [r.point(1.0).extend(r.positive(1e-4, 1.0)), r.point(1.0).extend(r.range(-1.0, 1.0))]
    });
    Case::new(
        Head::strict("form factor of a light", "points within 1, areas 1e-4 to 1", Unit::OfScale),
        inputs,
        |[x, y]| {
            let (receiver, emitter) = normals(y);
            [kernels::vpl_form_factor(x.truncate(), receiver, y.truncate(), emitter, x.w)]
        },
        |[x, y], got: &[f32; 1]| {
            let (receiver, emitter) = normals(y);
            let d = y.truncate().as_dvec3() - x.truncate().as_dvec3();
            let cosine = |n: Vec3, sign: f64| (n.as_dvec3().dot(d.normalize()) * sign).clamp(0.0, 1.0);
            let whole = f64::from(x.w) / (PI * d.length_squared() + f64::from(x.w));
            (f64::from(got[0]) / whole - cosine(receiver, 1.0) * cosine(emitter, -1.0)).abs()
        },
    )
    .way(NAIVE, |[x, y]| {
        let ((receiver, emitter), d) = (normals(y), y.truncate() - x.truncate());
        let (cosines, squared) = (receiver.dot(d).max(0.0) * (-emitter.dot(d)).max(0.0), d.length_squared());
        [x.w * cosines / (std::f32::consts::PI * squared * squared)]
    })
    .on(pass(function::FORM_FACTOR), number::<1>)
    .boxed()
}

/// Distance squared and radius or range.
fn distances(settings: &Settings) -> Vec<Pair> {
    list("attenuation", settings.numbers, |r| {
        [Vec4::new(r.positive(1e-6, 1e4), r.positive(1e-3, 1e2), 0.0, 0.0), Vec4::ZERO]
    })
}

const DISTANCES: &str = "distances and radii 1e-3 to 100";

fn bounded(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("bounded inverse square", DISTANCES, Unit::Relative),
        distances(settings),
        |[x, _]| [kernels::bounded_inverse_square(x.x, x.y)],
        |[x, _], got| truth::relative(got[0], 1.0 / (f64::from(x.x) + f64::from(x.y).powi(2))),
    )
    .way(NATIVE, |[x, _]| [1.0 / (x.x + x.y * x.y)])
    .on(pass(function::ATTENUATION), number::<0>)
    .boxed()
}

fn clamped(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("clamped inverse square", DISTANCES, Unit::Relative),
        distances(settings),
        |[x, _]| [kernels::clamped_inverse_square(x.x, x.y)],
        |[x, _], got| truth::relative(got[0], 1.0 / f64::from(x.x).max(f64::from(x.y).powi(2))),
    )
    .way(NATIVE, |[x, _]| [1.0 / x.x.max(x.y * x.y)])
    .on(pass(function::ATTENUATION), number::<1>)
    .boxed()
}

fn window(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("end of a light's range", DISTANCES, Unit::Absolute),
        distances(settings),
        |[x, _]| [kernels::range_window(x.x, x.y)],
        |[x, _], got: &[f32; 1]| {
            let share = f64::from(x.x) / f64::from(x.y).powi(2);
            (f64::from(got[0]) - (1.0 - share * share).max(0.0)).abs()
        },
    )
    .way(NATIVE, |[x, _]| [(1.0 - (x.x / (x.y * x.y)).powi(2)).max(0.0)])
    .on(pass(function::ATTENUATION), number::<2>)
    .boxed()
}

fn radius(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("radius of a disc", "areas 1e-6 to 1e4", Unit::Relative),
        distances(settings),
        |[x, _]| [kernels::disc_radius(x.x)],
        |[x, _], got| truth::relative(got[0], (f64::from(x.x) / PI).sqrt()),
    )
    .way(NATIVE, |[x, _]| [(x.x / std::f32::consts::PI).sqrt()])
    .on(pass(function::ATTENUATION), number::<3>)
    .boxed()
}
