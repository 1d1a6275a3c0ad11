//! How are optical depths and radiances stored in words?

use crate::math::{clamp, div, exp2, floor, log2, max, min, sqrt, to_u32};
use glam::Vec3;

/// The largest optical depth of a voxel: 3e-4 of the light gets through.
pub const MAX_OPTICAL_DEPTH: f32 = 8.0;

/// Returns optical depths along x, y and z as one word, ten bits each of their roots: steps of 0.006 at 1, 8e-6 at 0.
///
/// 0 and [`MAX_OPTICAL_DEPTH`] are exact; what is outside is clamped, NaN counts as 0.
#[inline]
pub fn pack_depths(depths: Vec3) -> u32 {
    ten_bits(depths.x) | (ten_bits(depths.y) << 10) | (ten_bits(depths.z) << 20)
}

#[inline]
fn ten_bits(depth: f32) -> u32 {
    to_u32(floor(sqrt(clamp(depth, 0.0, MAX_OPTICAL_DEPTH) * 0.125) * 1023.0 + 0.5))
}

/// Returns the depths that [`pack_depths`] packed.
#[inline]
pub fn unpack_depths(word: u32) -> Vec3 {
    // 8/1023²
    const SCALE: f32 = 7.644_318e-6;
    let x = (word & 1023) as f32;
    let y = ((word >> 10) & 1023) as f32;
    let z = ((word >> 20) & 1023) as f32;
    Vec3::new(x * x * SCALE, y * y * SCALE, z * z * SCALE)
}

/// The largest radiance that a word holds.
pub const MAX_RADIANCE: f32 = 65_408.0;

/// Returns a radiance as one word: nine bits for each colour, five for a common exponent (RGB9E5); 0.2 % of the largest.
///
/// Clamped to [0, 65408]; NaN counts as 0.
#[inline]
pub fn pack_radiance(radiance: Vec3) -> u32 {
    let r = clamp(radiance.x, 0.0, MAX_RADIANCE);
    let g = clamp(radiance.y, 0.0, MAX_RADIANCE);
    let b = clamp(radiance.z, 0.0, MAX_RADIANCE);
    let largest = max(max(r, g), b);
    // The smallest step is 2⁻²⁴: nothing is left below half of it.
    if !(largest > 1.0e-9) {
        return 0;
    }
    let mut exponent = floor(clamp(log2(largest), -16.0, 15.0)) + 1.0;
    let mut scale = exp2(9.0 - exponent);
    // Rounding up to 512 needs the next exponent.
    if floor(largest * scale + 0.5) >= 512.0 {
        exponent += 1.0;
        scale *= 0.5;
    }
    let part = |x: f32| to_u32(min(floor(x * scale + 0.5), 511.0));
    part(r) | (part(g) << 9) | (part(b) << 18) | (to_u32(exponent + 15.0) << 27)
}

/// Returns the radiance that [`pack_radiance`] packed.
#[inline]
pub fn unpack_radiance(word: u32) -> Vec3 {
    // 2^(exponent − 15 − 9), by the bits of the exponent.
    let scale = f32::from_bits(((word >> 27) + 127 - 24) << 23);
    Vec3::new(
        (word & 511) as f32 * scale,
        ((word >> 9) & 511) as f32 * scale,
        ((word >> 18) & 511) as f32 * scale,
    )
}

/// Returns a / b, 0 where b is not above 2⁻⁶⁰.
#[inline]
pub(super) fn ratio(a: Vec3, b: f32) -> Vec3 {
    if b > 8.673_617e-19 { Vec3::new(div(a.x, b), div(a.y, b), div(a.z, b)) } else { Vec3::ZERO }
}
