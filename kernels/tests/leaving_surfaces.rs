//! Do rays leave the surface that they start from, far from the origin and along it too?

// Planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/random.rs"]
mod random;

use glam::Vec3;
use random::Random;
use twinlight_kernels::geometry::disc::ray_disc;
use twinlight_kernels::geometry::triangle::{TriangleRay, ray_triangle};
use twinlight_kernels::math::max_abs;
use twinlight_kernels::passes::scene::Triangle;
use twinlight_kernels::passes::surface::ray_origin;

const FAR: f32 = 1e30;

/// A direction on a side of a plane, no flatter than this cosine.
fn leaving(random: &mut Random, normal: Vec3, least: f32) -> Vec3 {
    loop {
        let d = random.direction();
        let cosine = d.dot(normal);
        if cosine.abs() >= least {
            return d;
        }
    }
}

/// How many of 20,000 rays from the middle of a triangle of size 1, `far` away, meet it again, as `start` and `t_min` have it.
fn triangles_met(
    far: f32,
    start: impl Fn(Vec3, &Triangle, Vec3) -> Vec3,
    t_min: impl Fn(Vec3) -> f32,
) -> u32 {
    let mut random = Random::new(5);
    let mut met = 0;
    for _ in 0..20_000 {
        let centre = random.direction() * far;
        let [a, b, c] = [(); 3].map(|()| centre + random.point(1.0));
        let normal = (b - a).cross(c - a);
        if normal.length() < 0.1 {
            continue;
        }
        let (u, v) = (random.range(0.05, 0.45), random.range(0.05, 0.45));
        let position = a + (b - a) * u + (c - a) * v;
        let direction = leaving(&mut random, normal.normalize(), 1e-3);
        let t = Triangle {
            p0: a.extend(0.0),
            p1: b.extend(0.0),
            p2: c.extend(0.0),
            ..bytemuck::Zeroable::zeroed()
        };
        let origin = start(position, &t, direction);
        let hit = ray_triangle(a, b, c, &TriangleRay::new(origin, direction), t_min(origin), FAR);
        met += u32::from(hit.hit);
    }
    met
}

#[test]
fn rays_do_not_meet_the_triangle_that_they_leave() {
    let here = |p: Vec3, _: &Triangle, _: Vec3| p;
    for far in [0.0, 1.0, 30.0, 1e3, 3e4] {
        let moved = triangles_met(far, ray_origin, |_| 0.0);
        let plain = triangles_met(far, here, |_| 0.0);
        let fixed = triangles_met(far, here, |_| 1e-4);
        let scaled = triangles_met(far, here, |o| 4.0 * 2f32.powi(-24) * max_abs(o));
        println!(
            "{far} away: {moved} meet their own triangle, {plain} from the surface, {fixed} beyond 10⁻⁴, {scaled} beyond 4 ε of the place"
        );
        assert_eq!(moved, 0, "{far} away");
        assert!(plain > 1_000, "planted fault: rays from the surface itself, {far} away, {plain}");
        assert!(far < 1e3 || fixed > 1_000, "planted fault: a fixed distance, {far} away, {fixed}");
        assert!(scaled > 0, "along the surface no distance of a few ulp is enough");
    }
}

/// The same for discs of radius 1, from points of theirs.
fn discs_met(far: f32, least: f32, t_min: impl Fn(Vec3) -> f32) -> u32 {
    let mut random = Random::new(6);
    let mut met = 0;
    for _ in 0..20_000 {
        let (centre, normal) = (random.direction() * far, random.direction());
        let across = normal.any_orthonormal_vector() * random.range(-0.9, 0.9);
        let origin = centre + across;
        let direction = leaving(&mut random, normal, least);
        met += u32::from(ray_disc(origin, direction, centre, normal, 1.0, t_min(origin), FAR).hit);
    }
    met
}

#[test]
fn rays_do_not_meet_the_disc_that_they_leave() {
    for far in [10.0, 1e3, 3e4] {
        // A rounded start lies off the disc by up to √3/2 ulp of its largest coordinate: that over the cosine away.
        let scaled = discs_met(far, 0.5, |o| 4.0 * 2f32.powi(-24) * max_abs(o));
        let (plain, fixed) = (discs_met(far, 0.5, |_| 0.0), discs_met(far, 0.5, |_| 1e-4));
        println!("{far} away: {scaled} beyond 4 ε of the place, {plain} from the disc, {fixed} beyond 10⁻⁴");
        assert_eq!(scaled, 0, "{far} away");
        assert!(plain > 1_000, "planted fault: from the disc itself {plain}");
        assert!(far < 3e4 || fixed > 1_000, "planted fault: a fixed distance, {fixed}");
    }
}
