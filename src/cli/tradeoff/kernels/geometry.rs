//! Rays against discs and triangles, hashes, sequences and directions.

use super::Settings;
use super::case::{Case, Head, Measure, NATIVE, OnDevice, Unit, each, number};
use super::device::Work;
use super::draw::{Random, list};
use super::truth;
use glam::{DVec3, UVec4, Vec2, Vec3, Vec4};
use twinlight_kernels::geometry::disc::ray_disc;
use twinlight_kernels::geometry::triangle::{TriangleRay, ray_triangle};
use twinlight_kernels::passes::{evaluate_geometry, evaluate_sampling};
use twinlight_kernels::sampling::{halton, hash, hemisphere};

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let mut all = Vec::new();
    for decisions in [false, true] {
        all.push(discs(settings, decisions));
        all.push(triangles(settings, decisions));
    }
    all.sort_by_key(|case| case.head().kernel);
    all.push(hashes(settings));
    all.push(radical_inverse::<2>(settings, halton::radical_inverse_2));
    all.push(radical_inverse::<3>(settings, halton::radical_inverse_3));
    all.push(radical_inverse::<5>(settings, halton::radical_inverse_5));
    all.push(radical_inverse::<7>(settings, halton::radical_inverse_7));
    all.push(sphere_directions(settings));
    all
}

/// Whether there is a hit (1 or 0), and where.
type Met = [f32; 2];

fn met(hit: bool, t: f32) -> Met {
    [f32::from(u8::from(hit)), t]
}

fn read_met(words: &[u32]) -> Met {
    [words[4] as f32, f32::from_bits(words[0])]
}

/// Rays with four more vectors, as the pass takes them.
fn geometry_pass<const K: usize>(function: u32) -> Option<OnDevice<[Vec3; K], Met>> {
    Some(OnDevice {
        work: Box::new(move |all: &[[Vec3; K]]| {
            let end = [0.0, 1e30, RADIUS, 0.0, 0.0];
            let argument =
                |k: usize| all.iter().map(|x| x.get(k).map_or(Vec4::ZERO, |v| v.extend(end[k]))).collect();
            Work::Geometry(function, 0, std::array::from_fn(argument))
        }),
        read: read_met,
        software: false,
    })
}

fn head(kernel: &'static str, decisions: bool) -> Head {
    let (variant, unit) = if decisions { ("hit or miss", Unit::Wrong) } else { ("distance", Unit::OfScale) };
    Head::new(kernel, variant, "origins within 4, targets within 2, half hit", unit)
}

/// Wrong decisions, or how far off distances are where both agree on a hit: over the farthest that a hit could be.
fn met_error(decisions: bool, got: &Met, truth: Option<f64>, scale: f64) -> f64 {
    match (got[0] == 1.0, truth) {
        (hit, truth) if decisions => f64::from(u8::from(hit != truth.is_some())),
        (true, Some(t)) => (f64::from(got[1]) - t).abs() / scale,
        _ => 0.0,
    }
}

/// The discs' radius.
const RADIUS: f32 = 0.5;

/// Origin, direction, centre, normal.
fn discs(settings: &Settings, decisions: bool) -> Box<dyn Measure> {
    let inputs: Vec<[Vec3; 4]> = list("discs", settings.numbers, |r| {
        let (origin, centre, normal) = (r.point(4.0), r.point(2.0), r.direction());
        let aside = r.direction().cross(normal).normalize_or(normal) * r.range(0.0, 1.0);
        [origin, centre + aside - origin, centre, normal]
    });
    let error = move |_: usize, x: &[Vec3; 4], got: &Met| {
        let [o, d, c, n] = x.map(|v| v.as_dvec3());
        let t = (c - o).dot(n) / d.dot(n);
        let hit = (t >= 0.0 && (o + d * t - c).length() <= f64::from(RADIUS)).then_some(t);
        // The numerator's rounding is a share of |c − o|.
        met_error(decisions, got, hit, (c - o).length() / d.dot(n).abs())
    };
    Box::new(Case {
        head: head("ray-disc", decisions),
        inputs,
        strict: each(|[o, d, c, n]: &[Vec3; 4]| {
            let hit = ray_disc(*o, *d, *c, *n, RADIUS, 0.0, 1e30);
            met(hit.hit, hit.t)
        }),
        others: Vec::new(),
        error: Box::new(error),
        device: geometry_pass(evaluate_geometry::function::DISC),
    })
}

/// Origin, direction, corners.
fn triangles(settings: &Settings, decisions: bool) -> Box<dyn Measure> {
    let inputs: Vec<[Vec3; 5]> = list("triangles", settings.numbers, |r| {
        let (origin, [a, b, c]) = (r.point(4.0), [0; 3].map(|_| r.point(2.0)));
        let (u, v) = (r.range(-0.1, 0.8), r.range(-0.1, 0.8));
        let target = a + (b - a) * u + (c - a) * v;
        [origin, target - origin, a, b, c]
    });
    Box::new(Case {
        head: head("ray-triangle", decisions),
        inputs,
        strict: each(|[o, d, a, b, c]: &[Vec3; 5]| {
            let hit = ray_triangle(*a, *b, *c, &TriangleRay::new(*o, *d), 0.0, 1e30);
            met(hit.hit, hit.t)
        }),
        others: Vec::new(),
        error: Box::new(move |_, x: &[Vec3; 5], got: &Met| {
            let [o, d, a, b, c] = x.map(|v| v.as_dvec3());
            let farthest = [a, b, c].map(|p| (p - o).length()).into_iter().fold(0.0, f64::max);
            let slant = (b - a).cross(c - a).normalize().dot(d.normalize()).abs();
            met_error(decisions, got, meet(o, d, [a, b, c]), farthest / (d.length() * slant))
        }),
        device: geometry_pass(evaluate_geometry::function::TRIANGLE),
    })
}

/// Möller and Trumbore's test.
pub(super) fn meet(o: DVec3, d: DVec3, [a, b, c]: [DVec3; 3]) -> Option<f64> {
    let (e, f, s) = (b - a, c - a, o - a);
    let (p, q) = (d.cross(f), s.cross(e));
    let determinant = e.dot(p);
    let (u, v, t) = (s.dot(p) / determinant, d.dot(q) / determinant, f.dot(q) / determinant);
    (u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t >= 0.0).then_some(t)
}

/// The pass of samples, with these words.
fn sampling_pass<I: Copy + 'static, O>(
    function: u32,
    words: fn(&I) -> (UVec4, Vec4),
    read: fn(&[u32]) -> O,
) -> Option<OnDevice<I, O>> {
    Some(OnDevice {
        work: Box::new(move |all: &[I]| {
            let (words, numbers): (_, Vec<Vec4>) = all.iter().map(words).unzip();
            Work::Sampling(function, words, [numbers.clone(), numbers])
        }),
        read,
        software: false,
    })
}

fn hashes(settings: &Settings) -> Box<dyn Measure> {
    /// PCG's output function in 64-bit integers.
    fn truth(x: u32) -> u32 {
        let state = (u64::from(x) * 747_796_405 + 2_891_336_453) % (1 << 32);
        let word = (((state >> ((state >> 28) + 4)) ^ state) * 277_803_737) % (1 << 32);
        ((word >> 22) ^ word) as u32
    }
    Box::new(Case {
        head: Head::strict("hash", "32-bit integers", Unit::Wrong).stated(0.0),
        inputs: list("hash", settings.numbers, Random::bits),
        strict: each(|x: &u32| hash::hash(*x)),
        others: Vec::new(),
        error: Box::new(|_, x, got| f64::from(u8::from(*got != truth(*x)))),
        device: sampling_pass(
            evaluate_sampling::function::HASH,
            |x| (UVec4::splat(*x), Vec4::ZERO),
            |words| words[4],
        ),
    })
}

fn radical_inverse<const BASE: u32>(
    settings: &Settings,
    kernel: impl Fn(u32) -> f32 + 'static,
) -> Box<dyn Measure> {
    fn truth(base: u32, mut index: u32) -> f64 {
        let (mut x, mut digit) = (0.0, 1.0);
        while index > 0 {
            digit /= f64::from(base);
            x += digit * f64::from(index % base);
            index /= base;
        }
        x
    }
    let read = match BASE {
        2 => number::<0>,
        3 => number::<1>,
        5 => number::<2>,
        _ => number::<3>,
    };
    Box::new(Case {
        head: Head::new("radical inverse", &format!("base {BASE}"), "indices to 2^30", Unit::Absolute)
            .stated(6e-8),
        inputs: list("radical inverse", settings.numbers, |r| r.bits() >> 2),
        strict: each(move |i: &u32| [kernel(*i)]),
        others: Vec::new(),
        error: Box::new(|_, i, got| (f64::from(got[0]) - truth(BASE, *i)).abs()),
        device: sampling_pass(
            evaluate_sampling::function::RADICAL_INVERSE,
            |i: &u32| (UVec4::splat(*i), Vec4::ZERO),
            read,
        ),
    })
}

fn sphere_directions(settings: &Settings) -> Box<dyn Measure> {
    fn native(u: Vec2) -> Vec3 {
        let (s, c) = (u.y * std::f32::consts::TAU).sin_cos();
        let r = 2.0 * (u.x * (1.0 - u.x)).sqrt();
        Vec3::new(r * c, r * s, 1.0 - 2.0 * u.x)
    }
    Box::new(Case {
        head: Head::strict("uniform sphere", "unit square", Unit::Absolute),
        inputs: list("sphere", settings.numbers, |r| Vec2::new(r.range(0.0, 1.0), r.range(0.0, 1.0))),
        strict: each(|u: &Vec2| hemisphere::uniform_sphere(*u).to_array()),
        others: vec![(NATIVE, each(|u: &Vec2| native(*u).to_array()))],
        error: Box::new(|_, u, got| {
            let u = u.as_dvec2();
            let (s, c) = truth::sin_cos_turn(u.y);
            let r = 2.0 * (u.x * (1.0 - u.x)).sqrt();
            truth::distance(got, &[r * c, r * s, 1.0 - 2.0 * u.x])
        }),
        device: sampling_pass(
            evaluate_sampling::function::UNIFORM_SPHERE,
            |u: &Vec2| (UVec4::ZERO, Vec4::new(u.x, u.y, 0.0, 0.0)),
            |words| [0, 1, 2].map(|i| f32::from_bits(words[i])),
        ),
    })
}
