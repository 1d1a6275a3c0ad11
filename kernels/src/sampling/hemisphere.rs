//! Which directions and points stand for a hemisphere, a sphere or a triangle?
//!
//! Directions are in a frame whose z axis is the normal; [`to_world`] turns them.

use crate::math::{
    div, exp, exp_minus_one, ln_one_plus, max, orthonormal_frame, saturate, sin_cos_turn, sqrt,
};
use glam::{Vec2, Vec3};

/// Returns a unit direction with density cos θ/π over the hemisphere around z, for u in [0, 1]².
///
/// Polar mapping: sin²θ = u.x, azimuth u.y turns. Length within 3·2⁻²⁴ of 1; u is clamped, NaN counts as 0.
#[inline]
pub fn cosine_hemisphere(u: Vec2) -> Vec3 {
    let sin_squared = saturate(u.x);
    let (s, c) = sin_cos_turn(saturate(u.y));
    let r = sqrt(sin_squared);
    Vec3::new(r * c, r * s, sqrt(1.0 - sin_squared))
}

/// Returns a unit direction with density (n + 1)/2π·cosⁿ θ over the hemisphere around z, for u in [0, 1]².
///
/// cos θ = (1 − u.x)^(1/(n + 1)), and sin² θ as −expm1 of its logarithm: 2e-7 relative, no cancellation in narrow lobes. A
/// negative exponent and NaN count as 0; u as in [`cosine_hemisphere`].
#[inline]
pub fn phong_lobe_direction(u: Vec2, exponent: f32) -> Vec3 {
    let log_cosine = div(ln_one_plus(-saturate(u.x)), max(exponent, 0.0) + 1.0);
    let (s, c) = sin_cos_turn(saturate(u.y));
    let r = sqrt(-exp_minus_one(2.0 * log_cosine));
    Vec3::new(r * c, r * s, exp(log_cosine))
}

/// Returns a unit direction of uniform density 1/(4π) over the sphere, for u in [0, 1]²; NaN counts as 0.
#[inline]
pub fn uniform_sphere(u: Vec2) -> Vec3 {
    let x = saturate(u.x);
    let (s, c) = sin_cos_turn(saturate(u.y));
    // √(1 − z²) without its cancellation near the poles.
    let r = 2.0 * sqrt(x * (1.0 - x));
    Vec3::new(r * c, r * s, 1.0 - 2.0 * x)
}

/// Returns a direction of the normal's frame in world space; the frame is [`orthonormal_frame`]'s.
#[inline]
pub fn to_world(local: Vec3, normal: Vec3) -> Vec3 {
    let (tangent, bitangent) = orthonormal_frame(normal);
    (tangent * local.x + bitangent * local.y) + normal * local.z
}

/// Returns weights (w, u, v) of a triangle's corners from a point of the unit square, folded at its diagonal.
///
/// Uniform in the triangle for uniform u; each in [0, 1], their sum 1 within 2·2⁻²⁴. NaN counts as 0.
#[inline]
pub fn fold_barycentrics(u: Vec2) -> Vec3 {
    let a = saturate(u.x);
    let b = saturate(u.y);
    let outside = a + b > 1.0;
    let a = if outside { 1.0 - a } else { a };
    let b = if outside { 1.0 - b } else { b };
    Vec3::new(max(0.0, (1.0 - a) - b), a, b)
}

/// Returns the point of the triangle with these weights of its corners.
#[inline]
pub fn triangle_point(a: Vec3, b: Vec3, c: Vec3, weights: Vec3) -> Vec3 {
    (a * weights.x + b * weights.y) + c * weights.z
}

/// One cone of a set that covers the hemisphere around z.
#[derive(Clone, Copy)]
pub struct Cone {
    /// The axis, a unit vector.
    pub direction: Vec3,
    /// Share of the cosine-weighted hemisphere; the shares of a set sum to 1.
    pub weight: f32,
    /// Tangent of the half angle.
    pub tangent: f32,
}

/// 6·(1 − cos 30°): the solid angle of every set is that of six cones of 60°, in units of 2π.
const SET_SOLID_ANGLE: f32 = 0.803_847_6;
/// The fraction of a turn between neighbours of a spiral set: 1 − 1/golden ratio.
const GOLDEN_TURN: f32 = 0.381_966_02;

/// Returns cone `index` of the set of `count` cones over the hemisphere, turned by `turn` turns about z.
///
/// - 1: along z. 2–4: a ring at 45°, the median of the cosine distribution, equal weights.
/// - 5–8: one along z with the weight sin²a of its half angle a, the others midway between a and 90°.
///   Six are the classic set: half angle 30°, ring at 60°, weights 1/4 and 3/20.
/// - From 9 on: a cosine-distributed spiral of equal weights.
///
/// Half angles keep the solid angle of the set. `index` ≥ `count` gives z with weight 0.
#[inline]
pub fn cone(count: u32, index: u32, turn: f32) -> Cone {
    if index >= count {
        return Cone { direction: Vec3::Z, weight: 0.0, tangent: 0.0 };
    }
    let n = count as f32;
    let share = div(1.0, n);
    let cos_half = 1.0 - SET_SOLID_ANGLE * share;
    let sin_half_squared = 1.0 - cos_half * cos_half;
    let sin_half = sqrt(sin_half_squared);
    let tangent = div(sin_half, cos_half);
    let has_ring_and_centre = count > 4 && count < 9;
    if count == 1 || (has_ring_and_centre && index == 0) {
        let weight = if count == 1 { 1.0 } else { sin_half_squared };
        return Cone { direction: Vec3::Z, weight, tangent };
    }
    let i = index as f32;
    // sin² of the tilt, place on the ring in turns, weight.
    let (tilt, place, weight) = if count <= 4 {
        (0.5, i * share, share)
    } else if has_ring_and_centre {
        // sin²(45° + a/2)
        let of_ring = div(1.0, n - 1.0);
        (0.5 + 0.5 * sin_half, (i - 1.0) * of_ring, (1.0 - sin_half_squared) * of_ring)
    } else {
        ((i + 0.5) * share, i * GOLDEN_TURN, share)
    };
    let (s, c) = sin_cos_turn(place + turn);
    let r = sqrt(tilt);
    Cone { direction: Vec3::new(r * c, r * s, sqrt(max(0.0, 1.0 - tilt))), weight, tangent }
}
