//! Weights of neighbouring pixels, and which coarse pixels a fine one takes.

use super::Settings;
use super::case::{Case, Head, Measure, NATIVE, Unit, number, numbers};
use super::device::{Work, split};
use super::draw::{Random, list};
use super::truth;
use glam::{DVec3, Vec3, Vec4};
use twinlight_kernels::gaussian::{self, CoarseSamples};
use twinlight_kernels::math::normalize_or;
use twinlight_kernels::passes::evaluate_gaussian::function;
use twinlight_kernels::passes::upsample::footprint;

type Triple = [Vec4; 3];

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    vec![
        depth(settings),
        normal(settings),
        plane(settings),
        falloff(settings),
        geometric(settings),
        upsampling(settings),
        place::<false>(settings),
        place::<true>(settings),
        gathering(settings),
        mean(settings),
        shares(settings),
        cells(settings),
    ]
}

fn pass(function: u32) -> impl Fn(&[Triple]) -> Work {
    move |all| Work::Gaussian(function, split(all))
}

/// 1/(ε + |Δz|), ε a thousandth of the depth.
fn of_depths(depth: f64, other: f64) -> f64 {
    1.0 / (1e-3 * depth.abs() + (depth - other).abs())
}

/// (N·N′)³², 0 behind.
fn of_normals(a: Vec3, b: Vec3) -> f64 {
    a.as_dvec3().dot(b.as_dvec3()).clamp(0.0, 1.0).powi(32)
}

fn of_difference(x: f64, deviation: f64) -> f64 {
    (-0.5 * (x / deviation).powi(2)).exp()
}

fn depth(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("depths", settings.numbers, |r| {
        let z = r.positive(0.1, 100.0);
        [Vec4::splat(z), Vec4::splat(z + z * r.signed(1e-5, 0.5)), Vec4::ONE]
    });
    Case::new(
        Head::strict("depth similarity", "depths 0.1 to 100, a half apart", Unit::Relative),
        inputs,
        |[a, b, _]| [gaussian::depth_similarity(a.x, b.x)],
        |[a, b, _], got| truth::relative(got[0], of_depths(f64::from(a.x), f64::from(b.x))),
    )
    .way(NATIVE, |[a, b, _]| [1.0 / (1e-3 * a.x.abs() + (a.x - b.x).abs())])
    .on(pass(function::SIMILARITY), number::<0>)
    .boxed()
}

/// A direction beside another, the angle's tangent at most this.
fn beside(r: &mut Random, n: Vec3, most: f64) -> Vec3 {
    normalize_or(n + r.direction() * r.range(0.0, most), n)
}

fn normal(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("normals", settings.numbers, |r| {
        let n = r.direction();
        [n.extend(0.0), beside(r, n, 0.9).extend(0.0), Vec4::ONE]
    });
    Case::new(
        Head::strict("normal similarity", "normals within 64°", Unit::Relative),
        inputs,
        |[a, b, _]| [gaussian::normal_similarity(a.truncate(), b.truncate())],
        |[a, b, _], got| truth::relative(got[0], of_normals(a.truncate(), b.truncate())),
    )
    .way(NATIVE, |[a, b, _]| [a.truncate().dot(b.truncate()).clamp(0.0, 1.0).powi(32)])
    .on(pass(function::SIMILARITY), number::<1>)
    .boxed()
}

/// Apart by what stands to 30° over the plane.
fn plane(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("planes", settings.numbers, |r| {
        let n = r.direction();
        let along = r.direction().cross(n).normalize_or(n);
        ((along + n * r.range(-0.6, 0.6)) * r.positive(1e-3, 1e3), n)
    });
    Case::new(
        Head::strict("plane similarity", "within 31° of the plane", Unit::Absolute),
        inputs,
        |(apart, n)| [gaussian::plane_similarity(*apart, *n)],
        |(apart, n), got: &[f32; 1]| {
            let sine = apart.as_dvec3().normalize().dot(n.as_dvec3());
            (f64::from(got[0]) - (1.0 - 16.0 * sine * sine).max(0.0)).abs()
        },
    )
    .boxed()
}

/// Differences up to four deviations.
fn differences(settings: &Settings) -> Vec<Triple> {
    list("differences", settings.numbers, |r| {
        let c = Vec4::new(r.positive(1e-3, 1.0), r.positive(0.05, 1.0), 0.0, 0.0);
        let a = Vec4::new(c.x * r.range(-4.0, 4.0), 0.0, 0.0, 0.0);
        [a, Vec4::new(0.0, 1.0 - r.range(0.0, 3.0).min(1.0 / c.y) * c.y, 0.0, 0.0), c]
    })
}

fn falloff(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("Gaussian falloff", "to 4 deviations", Unit::Relative),
        differences(settings),
        |[a, _, c]| [gaussian::gaussian_falloff(a.x, c.x)],
        |[a, _, c], got| truth::relative(got[0], of_difference(f64::from(a.x), f64::from(c.x))),
    )
    .way(NATIVE, |[a, _, c]| [(-0.5 * (a.x / c.x).powi(2)).exp()])
    .on(pass(function::SIMILARITY), number::<2>)
    .boxed()
}

fn geometric(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("geometric weight", "to 4 and 3 deviations", Unit::Relative),
        differences(settings),
        |[a, b, c]| [gaussian::geometric_weight(a.x, b.y, c.x, c.y)],
        |[a, b, c], got| {
            let (x, cosine, c) = (f64::from(a.x), f64::from(b.y), c.as_dvec4());
            truth::relative(got[0], of_difference(x, c.x) * of_difference(1.0 - cosine, c.y))
        },
    )
    .way(NATIVE, |[a, b, c]| [(-0.5 * ((a.x / c.x).powi(2) + ((1.0 - b.y) / c.y).powi(2))).exp()])
    .on(pass(function::SIMILARITY), number::<3>)
    .boxed()
}

/// Bilinear weights of a place.
fn bilinear(r: &mut Random) -> [f32; 4] {
    let (x, y) = (r.range(0.0, 1.0), r.range(0.0, 1.0));
    [(1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y]
}

/// The samples that the pass makes: normals are permutations of one, the last may be missing.
fn samples([a, b, c]: &Triple) -> CoarseSamples {
    let n = c.truncate();
    let last = if b.w > 0.125 { n } else { Vec3::ZERO };
    let normal = [n, Vec3::new(c.y, c.z, c.x), Vec3::new(c.x, c.z, c.y), last];
    CoarseSamples { bilinear: b.to_array(), depth: a.to_array(), normal }
}

/// Four depths, bilinear weights, normal and own depth; one in four near the middle of a corner, where permutations are similar.
fn coarse(settings: &Settings) -> Vec<Triple> {
    list("coarse", settings.numbers, |r| {
        let n = if r.bits() & 3 == 0 { r.direction() } else { beside(r, Vec3::splat(0.577), 0.5) };
        let z = r.positive(0.1, 100.0);
        let depths = [0; 4].map(|_| z * (1.0 + r.signed(1e-4, 0.3)));
        [Vec4::from_array(depths), Vec4::from_array(bilinear(r)), n.extend(z)]
    })
}

/// What weights are over their sum; all of the sample that is best where the sum is below 1e-12 of what it could be.
fn shares_of(weights: [f64; 4], best: Option<usize>) -> [f64; 4] {
    let sum: f64 = weights.iter().sum();
    match best {
        None => [0.0; 4],
        Some(best) if sum < 1e-12 => std::array::from_fn(|i| f64::from(u8::from(i == best))),
        Some(_) => weights.map(|w| w / sum),
    }
}

/// The largest, and the first of equals, of those that exist.
fn best(keys: [Option<f64>; 4]) -> Option<usize> {
    let rank = |i: usize| keys[i].unwrap_or(f64::NEG_INFINITY);
    (0..4).rev().filter(|i| keys[*i].is_some()).max_by(|i, j| rank(*i).total_cmp(&rank(*j)))
}

fn upsampling(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("upsampling weights", "depths a third apart", Unit::Absolute),
        coarse(settings),
        |x| gaussian::upsampling_weights(&samples(x), x[2].w, x[2].truncate()),
        |x, got| {
            let (s, own) = (samples(x), f64::from(x[2].w));
            let like = s.depth.map(|z| of_depths(own, f64::from(z)));
            let nearest = best(std::array::from_fn(|i| (s.normal[i] != Vec3::ZERO).then_some(like[i])));
            let most = nearest.map_or(1.0, |i| like[i]);
            let weights = std::array::from_fn(|i| {
                f64::from(s.bilinear[i])
                    * (like[i] / most).min(1.0)
                    * of_normals(x[2].truncate(), s.normal[i])
            });
            truth::largest(got, &shares_of(weights, nearest))
        },
    )
    .on(pass(function::UPSAMPLING), numbers)
    .boxed()
}

fn place<const NEAREST: bool>(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new(
            "weights by place",
            if NEAREST { "nearest" } else { "bilinear" },
            "one of four may be missing",
            Unit::Absolute,
        ),
        coarse(settings),
        |x| gaussian::place_weights(&samples(x), NEAREST),
        |x, got| {
            let s = samples(x);
            let there: [_; 4] =
                std::array::from_fn(|i| (s.normal[i] != Vec3::ZERO).then_some(f64::from(s.bilinear[i])));
            let weights = if NEAREST { [0.0; 4] } else { there.map(|w| w.unwrap_or(0.0)) };
            truth::largest(got, &shares_of(weights, best(there)))
        },
    )
    .boxed()
}

/// Bilinear weights, distances from the plane, normals and the pixel's own.
type Around = ([f32; 4], [f32; 4], [Vec3; 4], Vec3);

const DEVIATIONS: (f32, f32) = (0.1, 0.2);

fn gathering(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("gathering", settings.numbers, |r| -> Around {
        let (weights, n) = (bilinear(r), r.direction());
        let distance = [0; 4].map(|_| r.signed(1e-3, 0.4));
        let normal = [0; 4].map(|_| if r.bits() & 7 == 0 { Vec3::ZERO } else { beside(r, n, 0.9) });
        (weights, distance, normal, n)
    });
    Case::new(
        Head::strict("gathering weights", "distances to 0.4, deviations 0.1 and 0.2", Unit::Absolute),
        inputs,
        |(b, d, n, own)| gaussian::gathering_weights(b, d, n, *own, DEVIATIONS.0, DEVIATIONS.1),
        |(b, d, n, own), got| {
            let (own, n): (DVec3, _) = (own.as_dvec3(), n.map(|n| n.as_dvec3()));
            let there = n.map(|n| n != DVec3::ZERO);
            let mut weights: [f64; 4] = std::array::from_fn(|i| {
                let apart = 1.0 - n[i].dot(own).clamp(0.0, 1.0);
                let like = of_difference(f64::from(d[i]), f64::from(DEVIATIONS.0))
                    * of_difference(apart, f64::from(DEVIATIONS.1));
                if there[i] { f64::from(b[i]) * like } else { 0.0 }
            });
            let most = weights.into_iter().fold(0.0, f64::max);
            weights = weights.map(|w| if w < 1e-4 * most { 0.0 } else { w });
            let nearest = best(std::array::from_fn(|i| there[i].then_some(-f64::from(d[i]).abs())));
            truth::largest(got, &shares_of(weights, nearest))
        },
    )
    .boxed()
}

/// Sums, counts; differences and limits of sharing.
fn sums(settings: &Settings) -> Vec<Triple> {
    list("sums", settings.numbers, |r| {
        let limits = Vec4::new(r.positive(1e-3, 1e3), r.positive(1e-2, 1.0), r.range(0.0, 1.0), 0.0);
        let difference = limits.y * r.range(-2.0, 2.0);
        [Vec4::new(difference, r.range(-0.2, 1.0), r.range(-1.0, 1.0), 0.0), limits, Vec4::ZERO]
    })
}

fn mean(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("mean or 0", "counts 1e-3 to 1e3", Unit::Relative),
        sums(settings),
        |[a, b, _]| gaussian::mean_or_zero(a.truncate(), b.x).to_array(),
        |[a, b, _], got: &[f32; 3]| {
            truth::largest_relative(got, &(a.truncate().as_dvec3() / f64::from(b.x)).to_array())
        },
    )
    .way(NATIVE, |[a, b, _]| (a.truncate() / b.x).to_array())
    .on(pass(function::MEAN), numbers)
    .boxed()
}

fn shares(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("shared visibility", "depths to twice the limit, cosines -0.2 to 1", Unit::Wrong),
        sums(settings),
        |[a, b, _]| [f32::from(u8::from(gaussian::shares_visibility(a.x, a.y, b.y, b.z)))],
        |[a, b, _], got| {
            let (a, b) = (a.as_dvec4(), b.as_dvec4());
            truth::wrong(&(got[0] == 1.0), &(a.x.abs() <= b.y && a.y >= b.z))
        },
    )
    .on(pass(function::MEAN), number::<3>)
    .boxed()
}

/// Weights spread over a row of coarse pixels and a column: what a picture linear in the place would become.
fn cells(settings: &Settings) -> Box<dyn Measure> {
    const SIZE: (u32, u32) = (1920, 1080);
    const COARSE: (u32, u32) = (640, 405);
    let scales = (COARSE.0 as f32 / SIZE.0 as f32, COARSE.1 as f32 / SIZE.1 as f32);
    let at = |x: u32, fine: u32, coarse: u32| {
        let place = (f64::from(x) + 0.5) * f64::from(coarse) / f64::from(fine) - 0.5;
        place.clamp(0.0, f64::from(coarse - 1))
    };
    Case::new(
        Head::strict("upsampling footprint", "1920 × 1080 of 640 × 405", Unit::Absolute),
        list("footprint", settings.numbers, |r| (r.bits() % SIZE.0, r.bits() % SIZE.1)),
        move |(x, y)| {
            let f = footprint(*x, *y, scales.0, scales.1, COARSE.0, COARSE.1);
            let [a, b, c, _] = f.pixels;
            let (first, next) = (Vec4::from_array(f.bilinear), b - a);
            let (right, below) = (first.y + first.w, first.z + first.w);
            [
                (a % COARSE.0) as f32,
                next as f32 * right,
                (a / COARSE.0) as f32,
                ((c - a) / COARSE.0) as f32 * below,
            ]
        },
        move |(x, y), got: &[f32; 4]| {
            let sums = [f64::from(got[0]) + f64::from(got[1]), f64::from(got[2]) + f64::from(got[3])];
            (sums[0] - at(*x, SIZE.0, COARSE.0)).abs().max((sums[1] - at(*y, SIZE.1, COARSE.1)).abs())
        },
    )
    .boxed()
}
