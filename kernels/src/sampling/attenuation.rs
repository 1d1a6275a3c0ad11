//! How much of a small light's power arrives, without blowing up near the light?

use crate::math::{FRAC_1_PI, MIN_POSITIVE, PI, div, dot, max, recip, rsqrt, saturate};
use glam::Vec3;

/// Returns A cos cos′/(πd² + A), the form factor of a disc of area A as seen from a point, in [0, 1].
///
/// Exact for a parallel coaxial disc; the 1/d² law within 1 % from ten disc radii on; never above 1 nearer.
/// π × radiance × this is the irradiance. Cosines are clamped to [0, 1]; A ≤ 0 and NaN give 0. Times the
/// cosines at d = 0, where no direction exists: see [`vpl_form_factor`].
#[inline]
pub fn disc_form_factor(cos_receiver: f32, cos_emitter: f32, distance_squared: f32, area: f32) -> f32 {
    let whole = PI * max(distance_squared, 0.0) + area;
    if !(area > 0.0) || !(whole >= MIN_POSITIVE) {
        return 0.0;
    }
    saturate(div(area, whole)) * (saturate(cos_receiver) * saturate(cos_emitter))
}

/// Returns the form factor of a disc-shaped emitter at a receiver, 0 where the two are the same point.
///
/// Normals are unit vectors, area = π radius². "Same" is a squared distance below 2⁻⁶⁰ of the area:
/// there the direction, and so the cosines, are rounding.
#[inline]
pub fn vpl_form_factor(
    receiver: Vec3,
    receiver_normal: Vec3,
    emitter: Vec3,
    emitter_normal: Vec3,
    area: f32,
) -> f32 {
    let to_emitter = emitter - receiver;
    let squared = dot(to_emitter, to_emitter);
    // 2⁻⁶⁰
    if !(squared > area * 8.673_617e-19) || squared < MIN_POSITIVE {
        return 0.0;
    }
    let direction = to_emitter * rsqrt(squared);
    disc_form_factor(dot(receiver_normal, direction), -dot(emitter_normal, direction), squared, area)
}

/// Returns 1/(d² + r²): the law of a point light that is a sphere or disc of radius r, at most 1/r².
///
/// Within 1 % of 1/d² from 10 r on. r = 0 is the bare law, finite down to d² = 2⁻¹²⁶; NaN gives 0.
#[inline]
pub fn bounded_inverse_square(distance_squared: f32, radius: f32) -> f32 {
    let whole = distance_squared + radius * radius;
    if whole >= 0.0 { recip(max(whole, MIN_POSITIVE)) } else { 0.0 }
}

/// Returns 1/max(d², r²): the bare law outside the radius r, constant inside; continuous, with a kink.
#[inline]
pub fn clamped_inverse_square(distance_squared: f32, radius: f32) -> f32 {
    recip(max(max(distance_squared, radius * radius), MIN_POSITIVE))
}

/// Returns saturate(1 − (d/range)⁴), glTF's smooth end of a light's range; 1 without one, range ≤ 0.
#[inline]
pub fn range_window(distance_squared: f32, range: f32) -> f32 {
    let squared = range * range;
    if !(range > 0.0) || !(squared >= MIN_POSITIVE) {
        return 1.0;
    }
    let ratio = max(div(distance_squared, squared), 0.0);
    saturate(1.0 - ratio * ratio)
}

/// Returns the radius of a disc of this area; 0 for areas ≤ 0 and NaN.
#[inline]
pub fn disc_radius(area: f32) -> f32 {
    crate::math::sqrt(max(area * FRAC_1_PI, 0.0))
}
