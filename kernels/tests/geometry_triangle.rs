//! Does a ray hit what it must, never slip through a closed surface, and is its box never passed over?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/random.rs"]
mod random;
#[path = "oracle/vector64.rs"]
mod vector64;

use glam::{Vec3, Vec4};
use random::{Random, SPECIAL};
use std::collections::HashMap;
use twinlight_kernels::geometry::box_::{BoxRay, box_interval, four_boxes, pad_bounds};
use twinlight_kernels::geometry::triangle::{FourHits, TriangleRay, four_triangles, ray_triangle};
use vector64::exact as d;

const FAR: f32 = 1e30;
type Triangle = [Vec3; 3];

/// t, u, v and the smallest barycentric coordinate of the line's meeting with the plane, in float64.
fn oracle(t: &Triangle, origin: Vec3, direction: Vec3) -> Option<(f64, f64, f64, f64)> {
    let (a, b, c) = (d(t[0]) - d(origin), d(t[1]) - d(origin), d(t[2]) - d(origin));
    let dir = d(direction);
    let of_a = c.cross(b).dot(dir);
    let of_b = a.cross(c).dot(dir);
    let of_c = b.cross(a).dot(dir);
    let sum = of_a + of_b + of_c;
    let normal = (b - a).cross(c - a);
    let facing = normal.dot(dir);
    if facing.abs() < 1e-9 * normal.length() * dir.length() || sum == 0.0 {
        return None;
    }
    let (w, u, v) = (of_a / sum, of_b / sum, of_c / sum);
    Some((normal.dot(a) / facing, u, v, w.min(u).min(v)))
}

/// Strict Plücker edge tests: the planted fault of the watertightness test.
fn pluecker_hits(t: &Triangle, origin: Vec3, direction: Vec3) -> bool {
    let dot = twinlight_kernels::math::dot;
    let cross = twinlight_kernels::math::cross;
    let (a, b, c) = (t[0] - origin, t[1] - origin, t[2] - origin);
    let u = dot(cross(c - a, c + a), direction);
    let v = dot(cross(a - b, a + b), direction);
    let w = dot(cross(b - c, b + c), direction);
    let normal = cross(b - a, c - a);
    let ahead = dot(normal, a) * dot(normal, direction) > 0.0;
    ahead && ((u >= 0.0 && v >= 0.0 && w >= 0.0) || (u <= 0.0 && v <= 0.0 && w <= 0.0))
}

/// A closed star-shaped surface around 0: an octahedron, `levels` times subdivided, corners pushed in and
/// out.
fn closed_surface(random: &mut Random, levels: u32, roughness: f32) -> Vec<Triangle> {
    let mut corners: Vec<Vec3> = vec![Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let mut faces: Vec<[usize; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles: HashMap<(usize, usize), usize> = HashMap::new();
        let mut finer = Vec::new();
        for f in faces {
            let mut middle = |i: usize, j: usize| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    let m = corners[i] + corners[j];
                    corners.push(m / m.length());
                    corners.len() - 1
                })
            };
            let (p, q, r) = (middle(f[0], f[1]), middle(f[1], f[2]), middle(f[2], f[0]));
            finer.extend([[f[0], p, r], [p, f[1], q], [r, q, f[2]], [p, q, r]]);
        }
        faces = finer;
    }
    for corner in &mut corners {
        *corner *= 1.0 + random.range(-roughness, roughness);
    }
    faces.iter().map(|f| f.map(|i| corners[i])).collect()
}

fn four(triangles: &[Triangle], ray: &TriangleRay, t_min: f32, t_max: f32) -> FourHits {
    let lane = |corner: usize, axis: usize| {
        let value = |i: usize| triangles.get(i).map_or(0.0, |t| t[corner].to_array()[axis]);
        Vec4::new(value(0), value(1), value(2), value(3))
    };
    four_triangles(
        lane(0, 0),
        lane(0, 1),
        lane(0, 2),
        lane(1, 0),
        lane(1, 1),
        lane(1, 2),
        lane(2, 0),
        lane(2, 1),
        lane(2, 2),
        ray,
        t_min,
        t_max,
    )
}

/// A ray from near the middle through a corner, an edge point or an inner point of a random triangle.
fn aimed_ray(random: &mut Random, triangles: &[Triangle], origin: Vec3) -> Vec3 {
    let t = triangles[random.below(triangles.len() as u32) as usize];
    let target = match random.below(4) {
        0 => t[0],
        1 => t[1] + (t[2] - t[1]) * random.unit(),
        2 => (t[0] + t[1]) * 0.5,
        _ => (t[0] + t[1] + t[2]) / 3.0,
    };
    let direction = target - origin;
    if random.bits() & 1 == 0 { direction } else { direction * random.log_uniform(1e-9, 1e9) }
}

#[test]
fn no_ray_leaves_a_closed_surface_without_a_hit() {
    let mut random = Random::new(1);
    let (mut rays, mut slipped, mut slipped_pluecker) = (0, 0, 0);
    for mesh in 0..120 {
        let scale = if mesh % 3 == 0 { 1.0 } else { random.log_uniform(1e-6, 1e6).abs() };
        let shift = match mesh % 4 {
            0 => Vec3::ZERO,
            1 => Vec3::new(1.0, -2.0, 0.5) * scale,
            _ => random.point(100.0) * scale,
        };
        let mut triangles = closed_surface(&mut random, mesh % 4, 0.2);
        for t in &mut triangles {
            *t = t.map(|v| v * scale + shift);
        }
        for i in 0..150 {
            let origin = if i % 4 == 0 { shift } else { shift + random.point(0.2) * scale };
            let direction = aimed_ray(&mut random, &triangles, origin);
            let ray = TriangleRay::new(origin, direction);
            rays += 1;
            if !triangles.iter().any(|t| ray_triangle(t[0], t[1], t[2], &ray, 0.0, FAR).hit) {
                slipped += 1;
                println!("slipped: {origin:?} {direction:?}");
            }
            slipped_pluecker += u32::from(!triangles.iter().any(|t| pluecker_hits(t, origin, direction)));
        }
    }
    println!("{rays} rays, {slipped} slipped, {slipped_pluecker} through Plücker edges");
    assert_eq!(slipped, 0);
    assert!(slipped_pluecker > 0, "the planted fault was not seen");
}

#[test]
fn hits_agree_with_float64_away_from_the_edges() {
    let mut random = Random::new(2);
    let (mut worst_t, mut worst_u, mut hits) = (0.0f64, 0.0f64, 0);
    for _ in 0..200_000 {
        let scale = random.log_uniform(1e-8, 1e8).abs();
        let t = [random.point(scale), random.point(scale), random.point(scale)];
        let origin = random.point(scale);
        let direction = random.direction() * random.log_uniform(1e-6, 1e6).abs();
        let ray = TriangleRay::new(origin, direction);
        let got = ray_triangle(t[0], t[1], t[2], &ray, -FAR, FAR);
        let Some((t_true, u, v, inside)) = oracle(&t, origin, direction) else { continue };
        let normal = (d(t[1]) - d(t[0])).cross(d(t[2]) - d(t[0]));
        let slant = (normal.dot(d(direction)) / (normal.length() * d(direction).length())).abs();
        let shape = normal.length() / f64::from(scale * scale);
        if slant < 0.05 || shape < 0.05 {
            continue;
        }
        let margin = 1e-4;
        if inside.abs() > margin {
            assert_eq!(got.hit, inside > 0.0, "{t:?} {origin:?} {direction:?} inside {inside}");
        }
        if got.hit {
            hits += 1;
            let unit = f64::from(scale) / d(direction).length();
            worst_t = worst_t.max((f64::from(got.t) - t_true).abs() / unit * slant);
            worst_u =
                worst_u.max((f64::from(got.u) - u).abs().max((f64::from(got.v) - v).abs()) * shape * slant);
            assert!(got.u >= 0.0 && got.v >= 0.0 && got.u + got.v <= 1.000_001);
        }
    }
    println!("{hits} hits, t error {worst_t:e} of the scene, barycentric error {worst_u:e}");
    assert!(hits > 5000);
    assert!(worst_t < 1e-6 && worst_u < 3e-6);
}

#[test]
fn four_lanes_give_the_bits_of_one() {
    let mut random = Random::new(3);
    let mut hits = 0;
    for round in 0..50_000 {
        let mut triangles: Vec<Triangle> =
            (0..4).map(|_| [random.point(1.0), random.point(1.0), random.point(1.0)]).collect();
        let mut origin = random.point(1.0);
        let mut direction = random.direction();
        if round % 8 == 0 {
            let special = SPECIAL[random.below(SPECIAL.len() as u32) as usize];
            match random.below(3) {
                0 => triangles[1][2].y = special,
                1 => origin.z = special,
                _ => direction.x = special,
            }
        }
        let (t_min, t_max) = if round % 2 == 0 { (0.0, FAR) } else { (0.3, 1.1) };
        let ray = TriangleRay::new(origin, direction);
        let lanes = four(&triangles, &ray, t_min, t_max);
        for (i, t) in triangles.iter().enumerate() {
            let one = ray_triangle(t[0], t[1], t[2], &ray, t_min, t_max);
            assert_eq!(one.hit, lanes.mask >> i & 1 == 1, "{t:?} {origin:?} {direction:?}");
            assert!(one.t.is_finite() && one.u.is_finite() && one.v.is_finite());
            if one.hit {
                hits += 1;
                let lane = [lanes.t, lanes.u, lanes.v].map(|v| v.to_array()[i].to_bits());
                assert_eq!([one.t, one.u, one.v].map(f32::to_bits), lane);
            }
        }
        assert_eq!(lanes.mask & !15, 0);
    }
    assert!(hits > 3000, "{hits}");
}

#[test]
fn degenerate_triangles_and_rays_miss() {
    let (a, b, c) = (Vec3::new(0.1, 0.2, 1.0), Vec3::new(1.0, 0.0, 1.5), Vec3::new(0.0, 1.0, 2.0));
    let hit = |t: Triangle, o: Vec3, dir: Vec3| {
        ray_triangle(t[0], t[1], t[2], &TriangleRay::new(o, dir), 0.0, FAR).hit
    };
    let centre = (a + b + c) / 3.0;
    assert!(hit([a, b, c], Vec3::ZERO, centre), "the control hits");
    assert!(!hit([a, b, b], Vec3::ZERO, (a + b) * 0.5), "two equal corners");
    assert!(!hit([a, a, a], Vec3::ZERO, a), "three equal corners");
    let line = [Vec3::new(-1.0, -1.0, 4.0), Vec3::new(0.0, 0.0, 4.0), Vec3::new(2.0, 2.0, 4.0)];
    assert!(!hit(line, Vec3::ZERO, Vec3::Z), "collinear corners through the ray");
    let wall = [Vec3::new(-1.0, 0.0, 1.0), Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, 0.0, 3.0)];
    assert!(!hit(wall, Vec3::ZERO, Vec3::Z), "ray in the plane");
    assert!(!hit(wall, Vec3::new(0.0, 0.5, 0.0), Vec3::Z), "ray beside the plane");
    for direction in
        [Vec3::ZERO, -Vec3::ZERO, Vec3::splat(1e-42), Vec3::new(f32::NAN, 0.0, 1.0), Vec3::INFINITY]
    {
        assert!(!hit([a, b, c], Vec3::ZERO, direction), "{direction:?}");
        assert!(!hit([a - centre, b - centre, c - centre], Vec3::ZERO, direction), "{direction:?}");
    }
    assert!(!hit([a, b, c], Vec3::new(0.0, f32::NAN, 0.0), centre));
}

#[test]
fn ends_of_the_interval_are_included() {
    let t = [Vec3::new(-1.0, -1.0, 4.0), Vec3::new(3.0, -1.0, 4.0), Vec3::new(-1.0, 3.0, 4.0)];
    let ray = TriangleRay::new(Vec3::ZERO, Vec3::new(0.0, 0.0, 2.0));
    let hit = |t_min, t_max| ray_triangle(t[0], t[1], t[2], &ray, t_min, t_max);
    assert_eq!(hit(2.0, 2.0).t, 2.0);
    assert!(!hit(2.000_000_3, 9.0).hit && !hit(0.0, 1.999_999_8).hit);
    let h = hit(0.0, 9.0);
    let p = t[0] * (1.0 - h.u - h.v) + t[1] * h.u + t[2] * h.v;
    assert!((p - Vec3::new(0.0, 0.0, 4.0)).length() < 1e-6);
}

/// The slab test without either guard: the planted fault of the next test.
fn naive_box(lower: Vec3, upper: Vec3, origin: Vec3, direction: Vec3) -> bool {
    let (mut near, mut far) = (0.0f32, FAR);
    for axis in 0..3 {
        let inverse = 1.0 / direction[axis];
        let t0 = (lower[axis] - origin[axis]) * inverse;
        let t1 = (upper[axis] - origin[axis]) * inverse;
        near = near.max(t0.min(t1));
        far = far.min(t0.max(t1));
    }
    near <= far
}

#[test]
fn a_hit_triangle_is_never_in_a_missed_box() {
    let mut random = Random::new(4);
    let (mut hits, mut unpadded_misses, mut naive_misses) = (0, 0, 0);
    for round in 0..300_000 {
        let scale = if round % 2 == 0 { 1.0 } else { random.log_uniform(1e-4, 1e4).abs() };
        let shift = random.point(50.0) * scale * (round % 3) as f32;
        let mut t = [random.point(scale), random.point(scale), random.point(scale)];
        // Boxes as thin as their triangles, and edges along the box's faces.
        let flat = random.below(3) as usize;
        if round % 4 != 0 {
            t[1][flat] = t[0][flat];
        }
        if round % 8 == 1 {
            t[2][flat] = t[0][flat];
        }
        let mut t = t.map(|v| v + shift);
        let mut origin = shift + random.point(20.0 * scale);
        if round % 16 == 5 {
            origin[flat] = t[0][flat];
        }
        if round % 4 == 3 {
            origin = random.point(1e-6);
            let grazing = random.log_uniform(1e-6, 1e-1) * scale;
            t[0][flat] = grazing;
            t[1][flat] = grazing;
        }
        let k = random.unit();
        let target = match round % 5 {
            0 => t[0],
            1 => t[2],
            _ => t[0] * (1.0 - k) + t[1] * k,
        };
        let direction = (target - origin) * random.log_uniform(1e-3, 1e3).abs();
        let h = ray_triangle(t[0], t[1], t[2], &TriangleRay::new(origin, direction), 0.0, FAR);
        if !h.hit {
            continue;
        }
        hits += 1;
        let (lower, upper) = (t[0].min(t[1]).min(t[2]), t[0].max(t[1]).max(t[2]));
        let ray = BoxRay::new(origin, direction);
        // The interval ends at the hit itself, as it does once a walk has found it.
        let meets = |(near, far): (f32, f32)| near <= far;
        let (low, high) = pad_bounds(lower, upper);
        assert!(meets(box_interval(low, high, &ray, 0.0, h.t)), "{t:?} {origin:?} {direction:?}");
        unpadded_misses += u32::from(!meets(box_interval(lower, upper, &ray, 0.0, h.t)));
        naive_misses += u32::from(!naive_box(lower, upper, origin, direction));
    }
    println!("{hits} hits; boxes missed: naive {naive_misses}, without pad_bounds {unpadded_misses}");
    assert!(hits > 50_000);
    assert!(naive_misses > 100 && unpadded_misses > 0, "the planted faults were not seen");
}

#[test]
fn four_boxes_give_the_bits_of_one() {
    let mut random = Random::new(5);
    let mut met = 0;
    for round in 0..50_000 {
        let boxes: Vec<(Vec3, Vec3)> = (0..4)
            .map(|i| {
                let (p, q) = (random.point(1.0), random.point(1.0));
                if i == 3 && round % 4 == 0 { (p.max(q), p.min(q)) } else { (p.min(q), p.max(q)) }
            })
            .collect();
        let ray = BoxRay::new(random.point(2.0), random.direction());
        let t_max = if round % 2 == 0 { FAR } else { 1.0 };
        let lane = |f: &dyn Fn(&(Vec3, Vec3)) -> f32| Vec4::from_array([0, 1, 2, 3].map(|i| f(&boxes[i])));
        let (near, mask) = four_boxes(
            lane(&|b| b.0.x),
            lane(&|b| b.1.x),
            lane(&|b| b.0.y),
            lane(&|b| b.1.y),
            lane(&|b| b.0.z),
            lane(&|b| b.1.z),
            &ray,
            0.0,
            t_max,
        );
        for (i, b) in boxes.iter().enumerate() {
            let (n, f) = box_interval(b.0, b.1, &ray, 0.0, t_max);
            assert_eq!(n <= f, mask >> i & 1 == 1, "{b:?}");
            if n <= f {
                met += 1;
                assert_eq!(n.to_bits(), near.to_array()[i].to_bits());
            }
            assert!(b.0.x <= b.1.x || n > f, "an empty box was met");
        }
    }
    assert!(met > 2_000, "{met}");
}

#[test]
fn rays_inside_a_face_of_a_box_meet_it() {
    let (lower, upper) = (Vec3::ZERO, Vec3::ONE);
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            for sign in [0.0f32, -0.0] {
                let mut origin = Vec3::splat(0.5);
                origin[(axis + 1) % 3] = -3.0;
                origin[axis] = side;
                let mut direction = Vec3::splat(sign);
                direction[(axis + 1) % 3] = 1.0;
                let (near, far) = box_interval(lower, upper, &BoxRay::new(origin, direction), 0.1, FAR);
                assert!(near <= far && (near - 3.0).abs() < 1e-4 && (far - 4.0).abs() < 1e-4);
            }
        }
    }
    let outside = BoxRay::new(Vec3::new(2.0, 0.5, 0.5), Vec3::Y);
    let (near, far) = box_interval(lower, upper, &outside, 0.0, FAR);
    assert!(near > far);
}
