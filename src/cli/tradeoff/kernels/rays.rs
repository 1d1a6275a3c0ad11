//! Rays against boxes, four boxes and triangles at once, and a tree.

use super::Settings;
use super::case::{Case, Head, Measure, Unit, numbers};
use super::device::{Work, split};
use super::draw::{Random, list};
use super::geometry::meet;
use super::truth;
use crate::scene::bvh::Bvh;
use glam::{DVec3, Vec3, Vec4};
use std::rc::Rc;
use twinlight_kernels::geometry::box_::{BoxRay, box_interval, four_boxes, pad_bounds};
use twinlight_kernels::geometry::bvh::{AcceptAll, NO_TRIANGLE, Ray, any_hit, nearest_hit};
use twinlight_kernels::geometry::triangle::{TriangleRay, four_triangles, ray_triangle};
use twinlight_kernels::passes::evaluate_geometry::function;
use twinlight_kernels::passes::scene::Triangle;

/// Origin and start, direction and end, three points.
type Scene = [Vec4; 5];

/// All of them; none only if the tree of triangles that are finite is refused.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let mut all = vec![
        box_of(settings, Asked::Hits),
        box_of(settings, Asked::LostHits),
        box_of(settings, Asked::Interval),
        boxes(settings),
        weights(settings),
        triangles(settings, false),
        triangles(settings, true),
    ];
    all.extend(trees(settings));
    all
}

fn pass(function: u32) -> impl Fn(&[Scene]) -> Work {
    move |all| Work::Geometry(function, 0, split(all))
}

/// What is compared.
#[derive(Clone, Copy, PartialEq)]
enum Asked {
    Hits,
    LostHits,
    Interval,
}

/// Boxes of half sizes 0.1 to 1; two in three of the rays' targets lie inside along an axis.
fn box_scenes(settings: &Settings) -> Vec<Scene> {
    list("boxes", settings.numbers, |r| {
        let (origin, centre) = (r.point(4.0), r.point(2.0));
        let half = Vec3::new(r.positive(0.1, 1.0), r.positive(0.1, 1.0), r.positive(0.1, 1.0));
        let target = centre + half * r.point(1.5);
        [
            origin.extend(0.0),
            (target - origin).extend(1e30),
            (centre - half).extend(0.0),
            (centre + half).extend(0.0),
            Vec4::ZERO,
        ]
    })
}

/// Parameters where the ray is between two planes of every axis, and how far the farthest of them is.
fn slabs(o: DVec3, d: DVec3, low: DVec3, high: DVec3) -> (f64, f64, f64) {
    let (mut near, mut far, mut scale) = (0.0f64, 1e30f64, 0.0f64);
    // Planes move out by a share of the largest coordinate.
    let largest = [o, low, high].map(|v| v.abs().max_element()).into_iter().fold(0.0, f64::max);
    for k in 0..3 {
        let (a, b) = ((low[k] - o[k]) / d[k], (high[k] - o[k]) / d[k]);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
        scale = scale.max(a.abs().max(b.abs()).max(largest / d[k].abs()));
    }
    (near, far, scale)
}

fn box_of(settings: &Settings, asked: Asked) -> Box<dyn Measure> {
    let (variant, unit) = match asked {
        Asked::Hits => ("hit or miss", Unit::Wrong),
        Asked::LostHits => ("hits lost", Unit::Wrong),
        Asked::Interval => ("interval", Unit::OfScale),
    };
    let head = Head::new("ray-box", variant, "origins within 4, half sizes 0.1 to 1", unit);
    Case::new(
        if asked == Asked::LostHits { head.stated(0.0) } else { head },
        box_scenes(settings),
        |[a, b, low, high, _]| {
            let (low, high) = pad_bounds(low.truncate(), high.truncate());
            let (near, far) = box_interval(low, high, &BoxRay::new(a.truncate(), b.truncate()), a.w, b.w);
            [near, far, f32::from(u8::from(near <= far))]
        },
        move |x, got: &[f32; 3]| {
            let [o, d, low, high, _] = x.map(|v| v.truncate().as_dvec3());
            let (near, far, scale) = slabs(o, d, low, high);
            let (hit, truth) = (got[2] == 1.0, near <= far);
            match asked {
                Asked::Hits => truth::wrong(&hit, &truth),
                Asked::LostHits => f64::from(u8::from(truth && !hit)),
                Asked::Interval if hit && truth => truth::largest(&got[..2], &[near, far]) / scale,
                Asked::Interval => 0.0,
            }
        },
    )
    .on(pass(function::BOX), |w| [f32::from_bits(w[0]), f32::from_bits(w[1]), w[4] as f32])
    .boxed()
}

/// The box, its two halves along x, and the box turned inside out, as the pass takes them.
fn lanes(low: Vec4, high: Vec4) -> (Vec4, Vec4) {
    let middle = 0.5 * (low.x + high.x);
    (Vec4::new(low.x, low.x, middle, high.x), Vec4::new(high.x, middle, high.x, low.x))
}

fn boxes(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new("ray-four boxes", "hit or miss", "origins within 4, half sizes 0.1 to 1", Unit::Wrong),
        box_scenes(settings),
        |[a, b, low, high, _]| {
            let ((left, right), ray) = (lanes(*low, *high), BoxRay::new(a.truncate(), b.truncate()));
            let [low_y, high_y, low_z, high_z] = [low.y, high.y, low.z, high.z].map(Vec4::splat);
            four_boxes(left, right, low_y, high_y, low_z, high_z, &ray, a.w, b.w).1
        },
        |x, got: &u32| {
            let [o, d, low, high, _] = x.map(|v| v.truncate().as_dvec3());
            let (left, right) = lanes(x[2], x[3]);
            let mask = (0..3).fold(0, |mask, k| {
                let (low, high) = (low.with_x(f64::from(left[k])), high.with_x(f64::from(right[k])));
                let (near, far, _) = slabs(o, d, low, high);
                mask | u32::from(near <= far) << k
            });
            truth::wrong(got, &mask)
        },
    )
    .on(pass(function::FOUR_BOXES), |w| w[4])
    .boxed()
}

/// Rays near triangles, about half of them hits.
fn triangle(r: &mut Random, size: f64) -> [Vec3; 5] {
    let (origin, [a, b, c]) = (r.point(4.0), [0; 3].map(|_| r.point(size)));
    let (u, v) = (r.range(-0.1, 0.8), r.range(-0.1, 0.8));
    let target = a + (b - a) * u + (c - a) * v;
    [origin, target - origin, a, b, c]
}

fn triangle_scenes(settings: &Settings) -> Vec<Scene> {
    list("four triangles", settings.numbers, |r| {
        let [o, d, a, b, c] = triangle(r, 2.0);
        [o.extend(0.0), d.extend(1e30), a.extend(0.0), b.extend(0.0), c.extend(0.0)]
    })
}

/// The triangle's farthest corner over the ray's slant: the scale of errors of distances.
fn farthest(o: DVec3, d: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let far = [a, b, c].map(|p| (p - o).length()).into_iter().fold(0.0, f64::max);
    far / (d.length() * (b - a).cross(c - a).normalize().dot(d.normalize()).abs())
}

/// Of the second and third corner: areas over the triangle's.
fn weights(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new("ray-triangle", "weights", "origins within 4, targets within 2, half hit", Unit::OfScale),
        triangle_scenes(settings),
        |[o, d, a, b, c]| {
            let ray = TriangleRay::new(o.truncate(), d.truncate());
            let hit = ray_triangle(a.truncate(), b.truncate(), c.truncate(), &ray, o.w, d.w);
            [hit.t, hit.u, hit.v]
        },
        |x, got: &[f32; 3]| {
            let [o, d, a, b, c] = x.map(|v| v.truncate().as_dvec3());
            let (normal, p) = ((b - a).cross(c - a), o + d * meet(o, d, [a, b, c]).unwrap_or(f64::NAN));
            if got[0] == 0.0 || p.is_nan() {
                return 0.0;
            }
            let of = |q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal) / normal.length_squared();
            let longest = [b - a, c - b, a - c].map(DVec3::length).into_iter().fold(0.0, f64::max);
            let scale = farthest(o, d, [a, b, c]) * d.length() * longest / normal.length();
            truth::largest(&got[1..], &[of(c, a), of(a, b)]) / scale
        },
    )
    .on(pass(function::TRIANGLE), numbers)
    .boxed()
}

/// The triangle with its corners in four orders, one per lane, as the pass takes it.
fn triangles(settings: &Settings, distances: bool) -> Box<dyn Measure> {
    let (variant, unit) = if distances { ("distance", Unit::OfScale) } else { ("hit or miss", Unit::Wrong) };
    Case::new(
        Head::new("ray-four triangles", variant, "origins within 4, targets within 2, half hit", unit),
        triangle_scenes(settings),
        |[o, d, p, q, r]| {
            let ray = TriangleRay::new(o.truncate(), d.truncate());
            let orders = [[p, q, r, p], [q, r, p, r], [r, p, q, q]];
            let [x, y, z] = [0, 1, 2].map(|k| orders.map(|of| Vec4::from_array(of.map(|v| v[k]))));
            let four = four_triangles(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2], &ray, o.w, d.w);
            let at = |k: usize| if four.mask >> k & 1 == 1 { four.t[k] } else { 0.0 };
            [at(0), at(1), at(2), at(3), four.mask as f32]
        },
        move |x, got: &[f32; 5]| {
            let [o, d, a, b, c] = x.map(|v| v.truncate().as_dvec3());
            let hit = meet(o, d, [a, b, c]);
            match hit {
                _ if !distances => truth::wrong(&got[4], &if hit.is_some() { 15.0 } else { 0.0 }),
                Some(t) if got[4] == 15.0 => truth::largest(&got[..4], &[t; 4]) / farthest(o, d, [a, b, c]),
                _ => 0.0,
            }
        },
    )
    .on(pass(function::FOUR_TRIANGLES), |w| {
        [0, 1, 2, 3, 4].map(|k| if k == 4 { w[4] as f32 } else { f32::from_bits(w[k]) })
    })
    .boxed()
}

/// Triangles in the tree.
const TRIANGLES: usize = 256;

/// Rays through a tree of triangles, against all of them one by one.
fn trees(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let corners: Vec<[Vec3; 3]> = list("tree", TRIANGLES, |r| {
        let a = r.point(2.0);
        [a, a + r.point(0.4), a + r.point(0.4)]
    });
    let of = |[a, b, c]: &[Vec3; 3]| Triangle {
        p0: a.extend(0.0),
        p1: b.extend(0.0),
        p2: c.extend(0.0),
        ..Triangle::default()
    };
    let Ok(tree) = Bvh::build(&corners.iter().map(of).collect::<Vec<_>>(), &[]) else { return Vec::new() };
    let inputs = list("rays", settings.vectors, |r| {
        let origin = r.point(4.0);
        (origin, r.point(2.0) - origin)
    });
    let met = move |o: Vec3, d: Vec3| {
        let (o, d) = (o.as_dvec3(), d.as_dvec3());
        let all = corners.iter().enumerate();
        let hits = all.filter_map(|(i, c)| Some((meet(o, d, c.map(|p| p.as_dvec3()))?, i as u32)));
        hits.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let truths: Vec<Option<(f64, u32)>> = inputs.iter().map(|(o, d)| met(*o, *d)).collect();
    let (tree, truths) = (Rc::new(tree), Rc::new(truths));
    let ray = |o: Vec3, d: Vec3| Ray { origin: o, direction: d, t_min: 0.0, t_max: 1e30 };
    let head = |kernel, variant, unit| Head::new(kernel, variant, "256 triangles, origins within 4", unit);
    let all = |at: usize, truths: &[Option<(f64, u32)>]| truths[at].map_or(NO_TRIANGLE, |(_, i)| i);
    let (of_tree, of_truth) = (tree.clone(), truths.clone());
    let mut nearest = Case::new(
        head("nearest hit", "which triangle", Unit::Wrong),
        inputs.clone(),
        move |(o, d)| nearest_hit(&of_tree.nodes, &of_tree.blocks, &ray(*o, *d), &AcceptAll).triangle,
        |_, _| 0.0,
    );
    nearest.error = Box::new(move |i, _, got: &u32| truth::wrong(got, &all(i, &of_truth)));
    let mut any = Case::new(
        head("any hit", "hit or miss", Unit::Wrong),
        inputs,
        move |(o, d)| u32::from(any_hit(&tree.nodes, &tree.blocks, &ray(*o, *d), &AcceptAll)),
        |_, _| 0.0,
    );
    any.error = Box::new(move |i, _, got: &u32| truth::wrong(&(*got == 1), &truths[i].is_some()));
    vec![nearest.boxed(), any.boxed()]
}
