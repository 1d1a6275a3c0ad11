//! How bright are many small Lambert emitters together, seen from one direction?

use super::zonal::CLAMPED_COSINE;
use crate::math::{dot, max, min, sqrt};
use glam::{Vec3, Vec4};

/// Returns the intensity of Lambert emitters toward a unit direction, from their sum in spherical harmonics l ≤ 1.
///
/// An emitter of intensity a·max(0, n·ω) has the zonal coefficients √π/2·a and √(π/3)·a about n. Band 0 gives Σa, band 1
/// the vector Σa·n. They are read as one emitter of that vector's length along it, and what is left as light the
/// same in all directions: exact for a flat voxel and for one with normals all around, never negative, and 0 where
/// band 0 is not positive. The series
/// itself, ¼ + ½ cos θ, is 25 % too dark in front of a flat voxel and shines behind it. VF eqs. 2 and 3.
#[inline]
pub fn lambert_intensity(coefficients: Vec4, direction: Vec3) -> f32 {
    // 1/(√π/2) and 1/√(π/3)
    const ZERO: f32 = 1.0 / CLAMPED_COSINE[0];
    const ONE: f32 = 1.0 / CLAMPED_COSINE[1];
    let c = coefficients;
    if !(c.x > 0.0) {
        return 0.0;
    }
    let vector = Vec3::new(-(c.w * ONE), -(c.y * ONE), c.z * ONE);
    let total = c.x * ZERO;
    let length = min(sqrt(dot(vector, vector)), total);
    max(dot(vector, direction), 0.0) + 0.25 * (total - length)
}
