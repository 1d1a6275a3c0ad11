//! Lobes behind means of directions, what weighs gloss, and depths in layers.

use super::Settings;
use super::case::{Case, Head, Measure, NAIVE, NATIVE, Read, Unit, number, numbers};
use super::device::{Work, split};
use super::draw::{Random, list};
use super::truth;
use glam::{Vec3, Vec4};
use twinlight_kernels::passes::evaluate_gaussian::function;
use twinlight_kernels::{gaussian, math};

type Triple = [Vec4; 3];

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    vec![
        axis(settings),
        lobe_variance(settings),
        length(settings),
        spread(settings),
        concentration(settings, false),
        concentration(settings, true),
        cosine_gap(settings),
        falloff(settings),
        variance(settings),
        moments(settings),
        least_deviation(settings),
        layer_coordinate(settings),
        layer_weight::<false>(settings),
        layer_weight::<true>(settings),
        smooth(settings),
    ]
}

fn pass(function: u32) -> impl Fn(&[Triple]) -> Work {
    move |all| Work::Gaussian(function, split(all))
}

fn first(a: Vec4) -> Triple {
    [a, Vec4::ZERO, Vec4::ZERO]
}

fn means(settings: &Settings) -> Vec<Triple> {
    list("means", settings.numbers, |r| first((r.direction() * r.range(0.05, 1.0)).extend(0.0)))
}

fn axis(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new("lobe of a mean", "axis", "lengths 0.05 to 1", Unit::Absolute),
        means(settings),
        |[a, ..]| gaussian::lobe_of_mean(a.truncate(), Vec3::Y).axis.to_array(),
        |[a, ..], got: &[f32; 3]| truth::distance(got, &a.truncate().as_dvec3().normalize().to_array()),
    )
    .on(pass(function::LOBE), numbers)
    .boxed()
}

fn lobe_variance(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new("lobe of a mean", "variance", "lengths 0.05 to 1", Unit::Absolute),
        means(settings),
        |[a, ..]| [gaussian::lobe_of_mean(a.truncate(), Vec3::Y).variance],
        |[a, ..], got: &[f32; 1]| {
            let length = a.truncate().as_dvec3().length().min(1.0);
            (f64::from(got[0]) - (1.0 - length) / length).abs()
        },
    )
    .on(pass(function::LOBE), number::<3>)
    .boxed()
}

fn length(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("lobe length", "variances 1e-6 to 1e4", Unit::Relative),
        list("lobe length", settings.numbers, |r| first(Vec4::new(1.0, r.positive(1e-6, 1e4), 0.0, 1.0))),
        |[a, ..]| [gaussian::variance_to_length(a.y)],
        |[a, ..], got| truth::relative(got[0], 1.0 / (1.0 + f64::from(a.y))),
    )
    .way(NATIVE, |[a, ..]| [1.0 / (1.0 + a.y)])
    .on(pass(function::LENGTHS), number::<1>)
    .boxed()
}

/// Of a deviation v and the length that goes with it, √(1 − v); the naive way has the length alone.
fn spread(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("spread", settings.numbers, |r| {
        let v = r.positive(1e-6, 0.9);
        first(Vec4::new((1.0 - v).sqrt(), 0.0, v, 1.0))
    });
    Case::new(
        Head::strict("lobe variance of a spread", "deviations squared 1e-6 to 0.9", Unit::Relative),
        inputs,
        |[a, ..]| [gaussian::spread_to_variance(a.z, a.x)],
        |[a, ..], got| {
            let length = (1.0 - f64::from(a.z)).sqrt();
            truth::relative(got[0], (1.0 - length) / length)
        },
    )
    .way(NAIVE, |[a, ..]| [(1.0 - a.x) / a.x])
    .on(pass(function::LENGTHS), number::<2>)
    .boxed()
}

/// Of a distribution whose concentration this is the length is coth κ − 1/κ.
fn true_concentration(length: f64) -> f64 {
    let of = |k: f64| if k < 1e-2 { k / 3.0 - k.powi(3) / 45.0 } else { 1.0 / k.tanh() - 1.0 / k };
    let (mut low, mut high) = (0.0, 1e6);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if of(middle) < length { low = middle } else { high = middle }
    }
    low
}

fn concentration(settings: &Settings, of_distribution: bool) -> Box<dyn Measure> {
    let variant = if of_distribution { "against the distribution" } else { "against the formula" };
    let head = Head::new("concentration", variant, "lengths 0.01 to 0.999", Unit::Relative);
    Case::new(
        if of_distribution { head.stated(0.05) } else { head },
        list("concentration", settings.numbers, |r| first(Vec4::new(0.0, r.range(0.01, 0.999), 0.0, 0.0))),
        |[a, ..]| [gaussian::von_mises_fisher_concentration(a.y)],
        move |[a, ..], got| {
            let length = f64::from(a.y);
            let formula = length * (3.0 - length * length) / (1.0 - length * length);
            truth::relative(got[0], if of_distribution { true_concentration(length) } else { formula })
        },
    )
    .on(pass(function::CONE_DEVIATION), number::<1>)
    .boxed()
}

/// Two directions, exponent and deviation.
fn gloss(settings: &Settings) -> Vec<Triple> {
    list("gloss", settings.numbers, |r| {
        let a = r.direction();
        let aside = r.direction().cross(a).normalize_or(Vec3::ZERO);
        let b = math::normalize_or(a + aside * r.positive(1e-3, 100.0), a);
        [a.extend(0.0), b.extend(0.0), Vec4::new(r.positive(1.0, 256.0), r.positive(0.15, 1.0), 0.0, 0.0)]
    })
}

/// 1 − cos of the angle of two directions, whatever their lengths.
fn gap(a: Vec4, b: Vec4) -> f64 {
    let (a, b) = (a.truncate().as_dvec3().normalize(), b.truncate().as_dvec3().normalize());
    (a - b).length_squared() / 2.0
}

fn cosine_gap(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("1 - cos", "angles 1e-3 to π/2", Unit::Relative),
        gloss(settings),
        |[a, b, _]| [gaussian::one_minus_cosine(a.truncate(), b.truncate())],
        |[a, b, _], got| truth::relative(got[0], gap(*a, *b)),
    )
    .way(NAIVE, |[a, b, _]| [1.0 - a.truncate().dot(b.truncate())])
    .on(pass(function::SPECULAR), number::<0>)
    .boxed()
}

fn falloff(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("specular falloff", "1 to 256, deviation 0.15 to 1, to π/2", Unit::Relative)
            .stated(1e-5),
        gloss(settings),
        |[a, b, c]| {
            let gap = gaussian::one_minus_cosine(a.truncate(), b.truncate());
            [gaussian::specular_falloff(gap, c.x, c.y)]
        },
        |[a, b, c], got| {
            let (gap, c) = ((*a - *b).as_dvec4().length_squared() / 2.0, c.as_dvec4());
            let x = if gap < 1.0 { 1.0 - (1.0 - gap).powf(c.x) } else { 1.0 };
            truth::relative(got[0], (-0.5 * (x / c.y).powi(2)).exp())
        },
    )
    .on(pass(function::SPECULAR), number::<2>)
    .boxed()
}

/// Opacity, mean, deviation and least deviation as the pass takes them: moments times the opacity.
fn depths(r: &mut Random, opacity: f32) -> Triple {
    let (mean, deviation) = (r.range(-1.0, 1.0), r.positive(0.01, 0.5));
    let (m1, m2) = (mean * opacity, (mean * mean + deviation * deviation) * opacity);
    let rest = [r.positive(1e-3, 10.0), r.signed(1e-3, 1.0)];
    [
        Vec4::new(m1, m2, rest[0], rest[1]),
        Vec4::new(opacity, 0.0, 0.0, 0.0),
        Vec4::new(r.positive(1e-3, 0.05), 0.0, 0.0, 0.0),
    ]
}

fn variance(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("variance of moments", "means -1 to 1, deviations 0.01 to 0.5", Unit::Absolute),
        list("variance of moments", settings.numbers, |r| depths(r, 1.0)),
        |[a, _, c]| [gaussian::variance_from_moments(a.x, a.y, c.x)],
        |[a, _, c], got| {
            let (a, least) = (a.as_dvec4(), f64::from(c.x));
            (f64::from(got[0]) - (a.y - a.x * a.x).max(least * least)).abs()
        },
    )
    .on(pass(function::MOMENTS), number::<0>)
    .boxed()
}

fn moments(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("moments over opacity", "opacities 0.05 to 1, means -1 to 1", Unit::Absolute),
        list("moments over opacity", settings.numbers, |r| {
            let opacity = r.range(0.05, 1.0);
            depths(r, opacity)
        }),
        |[a, b, c]| gaussian::weighted_moments(b.x, a.x, a.y, c.x).into(),
        |[a, b, c], got: &[f32; 2]| {
            let (a, opacity, least) = (a.as_dvec4(), f64::from(b.x), f64::from(c.x));
            let (m1, m2) = (a.x / opacity, a.y / opacity);
            truth::largest(got, &[m1, (m2 - m1 * m1).max(least * least)])
        },
    )
    .on(pass(function::MOMENTS), |words| [1, 2].map(|i| f32::from_bits(words[i])))
    .boxed()
}

fn least_deviation(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("least deviation", "ranges to 10, slopes to 1", Unit::Relative),
        list("least deviation", settings.numbers, |r| depths(r, 1.0)),
        |[a, ..]| [gaussian::minimum_deviation(a.z, a.w)],
        |[a, ..], got| {
            truth::relative(got[0], (0.005 * f64::from(a.z).abs()).max(0.5 * f64::from(a.w).abs()))
        },
    )
    .on(pass(function::MOMENTS), number::<3>)
    .boxed()
}

/// Depth, ends and overlap; a part of a step.
fn layers(settings: &Settings) -> Vec<Triple> {
    list("layers", settings.numbers, |r| {
        let (low, thick) = (r.range(0.0, 1.0), r.range(0.2, 1.0));
        let z = low + thick * r.range(-0.1, 1.1);
        [
            Vec4::new(z, low, low + thick, r.range(0.05, 0.3)),
            Vec4::new(r.range(-0.1, 1.1), 0.0, 0.0, 0.0),
            Vec4::ZERO,
        ]
    })
}

const LAYERS: &str = "layers of 0.2 to 1 from 0 to 1 on";

fn layer_coordinate(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("layer coordinate", LAYERS, Unit::Absolute),
        layers(settings),
        |[a, ..]| [gaussian::layer_coordinate(a.x, a.y, a.z)],
        |[a, ..], got| {
            let a = a.as_dvec4();
            (f64::from(got[0]) - (2.0 * (a.x - a.y) / (a.z - a.y) - 1.0)).abs()
        },
    )
    .on(pass(function::LAYERS), number::<0>)
    .boxed()
}

/// t²(3 − 2t) of the part of the overlap that is passed.
fn step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    3.0 * t.powi(2) - 2.0 * t.powi(3)
}

fn layer_weight<const FIRST: bool>(settings: &Settings) -> Box<dyn Measure> {
    let (variant, read): (_, Read<[f32; 1]>) =
        if FIRST { ("first", number::<2>) } else { ("between others", number::<1>) };
    Case::new(
        Head::new("layer weight", variant, LAYERS, Unit::Absolute),
        layers(settings),
        |[a, ..]| [gaussian::layer_decay(a.x, a.y, a.z, a.w, FIRST, false)],
        |[a, ..], got| {
            let a = a.as_dvec4();
            let near = if FIRST { 1.0 } else { step((a.x - a.y) / a.w) };
            (f64::from(got[0]) - near * step((a.z - a.x) / a.w)).abs()
        },
    )
    .on(pass(function::LAYERS), read)
    .boxed()
}

fn smooth(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("smooth step", "-0.1 to 1.1", Unit::Absolute),
        layers(settings),
        |[_, b, _]| [gaussian::smooth_step(b.x)],
        |[_, b, _], got| (f64::from(got[0]) - step(f64::from(b.x))).abs(),
    )
    .on(pass(function::LAYERS), number::<3>)
    .boxed()
}
