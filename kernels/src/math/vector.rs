//! In which order are the sums of vector algebra taken?
//!
//! glam's SIMD types add up dot products in another order on the CPU than on SPIR-V, so kernels use these.

use super::{abs, div, exp2_integer, max, rsqrt, sqrt};
use glam::{Mat4, Vec3, Vec4};

/// Returns a·b as (x x′ + y y′) + z z′.
#[inline]
pub fn dot(a: Vec3, b: Vec3) -> f32 {
    (a.x * b.x + a.y * b.y) + a.z * b.z
}

/// Weighted sums of light below this count as none: their terms may be below 2⁻¹²⁶, and devices flush those or do not.
const FAINT: f32 = 1.0e-28;

/// Returns `v` with 0 for components below 1e-28: what is left of a weighted sum is the same whether its terms below 2⁻¹²⁶ were
/// flushed or not, but for a tie once in thousands near the limit.
#[inline]
pub fn without_faint(v: Vec4) -> Vec4 {
    let kept = |x: f32| if abs(x) < FAINT { 0.0 } else { x };
    Vec4::new(kept(v.x), kept(v.y), kept(v.z), kept(v.w))
}

/// Returns a × b, each component one difference of two products: exactly antisymmetric.
#[inline]
pub fn cross(a: Vec3, b: Vec3) -> Vec3 {
    Vec3::new(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x)
}

/// Returns a·b over four components as ((x x′ + y y′) + z z′) + w w′.
#[inline]
pub fn dot4(a: Vec4, b: Vec4) -> f32 {
    ((a.x * b.x + a.y * b.y) + a.z * b.z) + a.w * b.w
}

/// Returns |v|; overflows beyond 1e19 and loses digits below 1e-19: see [`normalize_or`] for those.
#[inline]
pub fn length(v: Vec3) -> f32 {
    sqrt(dot(v, v))
}

/// Returns the component of largest magnitude.
#[inline]
pub fn max_abs(v: Vec3) -> f32 {
    max(max(abs(v.x), abs(v.y)), abs(v.z))
}

/// Returns v/|v|, within 3·2⁻²⁴ of unit length for every non-zero finite v; `fallback` for 0, NaN and ±∞.
///
/// Scales by a power of two first, so neither 1e-38 nor 1e38 over- or underflows.
#[inline]
pub fn normalize_or(v: Vec3, fallback: Vec3) -> Vec3 {
    let largest = max_abs(v);
    let finite = super::is_finite(v.x) && super::is_finite(v.y) && super::is_finite(v.z);
    if !finite || largest < super::MIN_POSITIVE {
        return fallback;
    }
    let exponent = ((largest.to_bits() >> 23) as i32) - 127;
    // 2^−exponent in two factors: 2^127 has no normal reciprocal.
    let half = (-exponent) >> 1;
    let s = (v * exp2_integer(half)) * exp2_integer(-exponent - half);
    s * rsqrt(dot(s, s))
}

/// Returns two unit vectors that make a right-handed frame (t, b, n) with the unit vector n, without branches.
///
/// Duff et al. 2017; the division is by at least 1.
#[inline]
pub fn orthonormal_frame(n: Vec3) -> (Vec3, Vec3) {
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let a = div(-1.0, sign + n.z);
    let b = n.x * n.y * a;
    (Vec3::new(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), Vec3::new(b, sign + n.y * n.y * a, -n.y))
}

/// Returns M·(p, 1) without the division by w, columns added in order.
#[inline]
pub fn transform_point(m: &Mat4, p: Vec3) -> Vec3 {
    ((m.x_axis * p.x + m.y_axis * p.y) + m.z_axis * p.z + m.w_axis).truncate()
}
