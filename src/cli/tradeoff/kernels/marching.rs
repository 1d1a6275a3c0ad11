//! What else a cone takes from step to step: distances, samples, sums.

use super::Settings;
use super::case::{Case, Head, Measure, NAIVE, NATIVE, Unit, number, numbers};
use super::device::{Work, split};
use super::draw::{Random, list};
use super::truth;
use glam::{DVec3, DVec4, Vec4};
use twinlight_kernels::cone::{self, ConeSum};
use twinlight_kernels::passes::evaluate_cone::function;

type Pair = [Vec4; 2];

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    vec![
        diameter(settings),
        step_length(settings),
        step_count(settings),
        falloff(settings),
        faded(settings),
        sample(settings),
        accumulation(settings),
        mean(settings),
    ]
}

fn pass(function: u32) -> impl Fn(&[Pair]) -> Work {
    move |all| Work::Cone(function, split(all))
}

/// Half angle, distance, coarsest level and voxel; factor.
fn steps(settings: &Settings) -> Vec<Pair> {
    list("cone steps", settings.numbers, |r| {
        [
            Vec4::new(r.range(0.01, 1.48), r.positive(1e-2, 1e2), 8.0, r.positive(1e-2, 1.0)),
            Vec4::new(r.range(0.25, 2.0), 0.0, 0.0, 0.0),
        ]
    })
}

const STEPS: &str = "half angles 0.01 to 1.48, distances 0.01 to 100";

fn diameter(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("cone diameter", STEPS, Unit::Relative),
        steps(settings),
        |[a, _]| [cone::diameter(a.y, cone::aperture_tangent(a.x))],
        |[a, _], got| truth::relative(got[0], 2.0 * f64::from(a.y) * f64::from(a.x).tan()),
    )
    .way(NATIVE, |[a, _]| [2.0 * a.y * a.x.tan()])
    .on(pass(function::STEP), number::<1>)
    .boxed()
}

fn step_length(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("step length", STEPS, Unit::Relative),
        steps(settings),
        |[a, b]| [cone::step_length(cone::diameter(a.y, cone::aperture_tangent(a.x)), a.w, b.x)],
        |[a, b], got| {
            let a = a.as_dvec4();
            truth::relative(got[0], (2.0 * a.y * a.x.tan()).max(a.w) * f64::from(b.x))
        },
    )
    .way(NATIVE, |[a, b]| [(2.0 * a.y * a.x.tan()).max(a.w) * b.x])
    .on(pass(function::STEP), number::<3>)
    .boxed()
}

/// Distance, λ and opacity; range, voxel and factor.
fn ways(settings: &Settings) -> Vec<Pair> {
    list("falloff", settings.numbers, |r| {
        [
            Vec4::new(r.positive(1e-9, 1e9), r.positive(1e-9, 1e9), r.range(0.0, 1.0), 0.0),
            Vec4::new(r.positive(1.0, 100.0), r.positive(1e-2, 1.0), r.range(0.25, 2.0), 0.0),
        ]
    })
}

fn step_count(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("bound of steps", "ranges 1 to 100, voxels 0.01 to 1", Unit::Wrong),
        ways(settings),
        |[_, b]| [cone::step_count_bound(b.x, b.y, b.z) as f32],
        |[_, b], got| {
            let b = b.as_dvec4();
            truth::wrong(&f64::from(got[0]), &((b.x / (b.y * b.z)).floor() + 1.0))
        },
    )
    .way(NATIVE, |[_, b]| [(b.x / (b.y * b.z)).floor() + 1.0])
    .on(pass(function::FALLOFF), number::<2>)
    .boxed()
}

const WAYS: &str = "distances and λ 1e-9 to 1e9";

fn falloff(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("falloff with distance", WAYS, Unit::Relative).stated(2e-7),
        ways(settings),
        |[a, _]| [cone::distance_falloff(a.x, a.y)],
        |[a, _], got| truth::relative(got[0], 1.0 / (1.0 + f64::from(a.x) * f64::from(a.y))),
    )
    .way(NATIVE, |[a, _]| [1.0 / (1.0 + a.x * a.y)])
    .on(pass(function::FALLOFF), number::<0>)
    .boxed()
}

fn faded(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("faded opacity", WAYS, Unit::Relative),
        ways(settings),
        |[a, _]| [cone::faded_opacity(a.z, a.x, a.y)],
        |[a, _], got| truth::relative(got[0], f64::from(a.z) / (1.0 + f64::from(a.x) * f64::from(a.y))),
    )
    .way(NATIVE, |[a, _]| [a.z / (1.0 + a.x * a.y)])
    .on(pass(function::FALLOFF), number::<1>)
    .boxed()
}

/// A colour of components up to 1, times an opacity.
fn premultiplied(r: &mut Random, opacity: f32) -> Vec4 {
    Vec4::new(r.range(0.0, 1.0), r.range(0.0, 1.0), r.range(0.0, 1.0), 1.0) * opacity
}

fn sample(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("samples", settings.numbers, |r| {
        let opacity = r.positive(1e-7, 0.99);
        [premultiplied(r, opacity), Vec4::splat(r.positive(1.0 / 16.0, 4.0))]
    });
    Case::new(
        Head::strict("corrected sample", "opacity 1e-7 to 0.99, ratio 1/16 to 4", Unit::Relative),
        inputs,
        |[s, ratio]| cone::corrected_sample(*s, ratio.x).to_array(),
        |[s, ratio], got: &[f32; 4]| {
            let s = s.as_dvec4();
            let opacity = -(f64::from(ratio.x) * (-s.w).ln_1p()).exp_m1();
            truth::largest_relative(got, &(s * (opacity / s.w)).to_array())
        },
    )
    .way(NATIVE, |[s, ratio]| (*s * (-(ratio.x * (-s.w).ln_1p()).exp_m1() / s.w)).to_array())
    .way(NAIVE, |[s, ratio]| (*s * ((1.0 - (1.0 - s.w).powf(ratio.x)) / s.w)).to_array())
    .on(pass(function::SAMPLE), numbers)
    .boxed()
}

fn accumulation(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("accumulation", settings.numbers, |r| {
        let (front, opacity) = (r.range(0.0, 1.0), r.range(0.0, 1.0));
        [premultiplied(r, front), premultiplied(r, 1.0).truncate().extend(opacity)]
    });
    Case::new(
        Head::strict("accumulation", "a premultiplied and a plain colour, 0 to 1", Unit::Absolute),
        inputs,
        |[a, b]| cone::accumulate(*a, b.truncate(), b.w).to_array(),
        |[a, b], got: &[f32; 4]| {
            let (a, b) = (a.as_dvec4(), b.as_dvec4());
            let (colour, w): (DVec3, f64) = (b.truncate() * b.w, b.w);
            truth::largest(got, &(a + colour.extend(w) * (1.0 - a.w)).to_array())
        },
    )
    .on(pass(function::ACCUMULATE), numbers)
    .boxed()
}

fn mean(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("means of cones", settings.numbers, |r| {
        let one = |r: &mut Random| premultiplied(r, 1.0).truncate().extend(r.range(0.05, 1.0));
        [one(r), one(r)]
    });
    Case::new(
        Head::strict("mean of cones", "two of 0 to 1, weights 0.05 to 1", Unit::Absolute),
        inputs,
        |[a, b]| ConeSum::EMPTY.with(*a, b.w).with(*b, a.w).mean(*a).to_array(),
        |[a, b], got: &[f32; 4]| {
            let (a, b): (DVec4, DVec4) = (a.as_dvec4(), b.as_dvec4());
            truth::largest(got, &((a * b.w + b * a.w) / (a.w + b.w)).to_array())
        },
    )
    .way(NATIVE, |[a, b]| ((*a * b.w + *b * a.w) / (a.w + b.w)).to_array())
    .on(pass(function::MEAN), numbers)
    .boxed()
}
