//! Where does a ray meet a disc?

use crate::math::{MIN_POSITIVE, div, dot, exp2_integer, is_finite, max_abs};
use glam::Vec3;

/// 2⁻⁴⁰: directions within about 1e-6 rad of the disc's plane are parallel to it.
const PARALLEL_SQUARED: f32 = 9.094_947e-13;

/// A ray's meeting with a disc.
#[derive(Clone, Copy)]
pub struct DiscHit {
    /// Whether the ray meets the disc; t is 0 if it does not.
    pub hit: bool,
    /// The ray's parameter, in lengths of its direction.
    pub t: f32,
}

/// Returns where the ray meets the closed disc, from either side, with t in [t_min, t_max] (both included).
///
/// `direction` and `normal` may have any length from 1e-18 to 1e18 (the direction any normal f32). Misses: a
/// direction within 1e-6 rad of the plane, a zero or denormal direction, a zero normal, radius ≤ 0, and NaN
/// anywhere or ±∞ in a vector or the radius. t has a relative error of 3e-7 where centre − origin does not
/// cancel. The rim is decided on (o − c)·den + d·num without a division: right when it is farther from the
/// hit than 16·2⁻²⁴ of |o − c| over the cosine between direction and normal.
#[inline]
pub fn ray_disc(
    origin: Vec3,
    direction: Vec3,
    center: Vec3,
    normal: Vec3,
    radius: f32,
    t_min: f32,
    t_max: f32,
) -> DiscHit {
    const MISS: DiscHit = DiscHit { hit: false, t: 0.0 };
    let largest = max_abs(direction);
    let finite = is_finite(direction.x) && is_finite(direction.y) && is_finite(direction.z);
    if !finite || largest < MIN_POSITIVE || !(radius > 0.0) {
        return MISS;
    }
    // A power of two brings the largest component to [1, 2): neither 1e-38 nor 1e38 leaves the range of f32.
    let exponent = ((largest.to_bits() >> 23) as i32) - 127;
    let half = (-exponent) >> 1;
    let (scale_a, scale_b) = (exp2_integer(half), exp2_integer(-exponent - half));
    let d = (direction * scale_a) * scale_b;
    let to_center = center - origin;
    let den = dot(d, normal);
    let num = dot(to_center, normal);
    if !is_finite(den) || !is_finite(num) || !is_finite(radius) {
        return MISS;
    }
    if !(den * den > PARALLEL_SQUARED * dot(d, d) * dot(normal, normal)) {
        return MISS;
    }
    let t = (div(num, den) * scale_a) * scale_b;
    if !is_finite(t) || !(t >= t_min) || !(t <= t_max) {
        return MISS;
    }
    let from_center = d * num - to_center * den;
    let rim = radius * den;
    if dot(from_center, from_center) <= rim * rim { DiscHit { hit: true, t } } else { MISS }
}
