//! What are the coefficients of a function around an axis, and how do they turn and convolve?

use super::basis::{UNIT, basis};
use crate::math::{PI, div, saturate, sqrt};
use glam::Vec3;

/// √(4π/(2l + 1)), the factor of rotation and convolution.
const BAND_FACTOR: [f32; 5] = [UNIT, 2.046_653_4, 1.585_331, 1.339_849_2, 1.181_635_9];

/// The zonal coefficients of max(0, cos θ), l = 0 to 8: √π/2, √(π/3), √(5π)/8, 0, −√π/16, …
pub const CLAMPED_COSINE: [f32; 9] =
    [0.886_226_95, 1.023_326_7, 0.495_415_9, 0.0, -0.110_778_37, 0.0, 0.049_927_134, 0.0, -0.028_546_931];

/// √π, √(3π)/2, √(5π)/2, √(7π)/8, 3√π/8.
const CAP_FACTOR: [f32; 5] = [1.772_453_9, 1.534_990_1, 1.981_663_6, 0.586_184, 0.664_670_2];

/// Returns the band of coefficient i: the largest l with l² ≤ i.
#[inline]
fn band(i: usize) -> usize {
    let mut l = 0;
    for k in 1..5 {
        if i >= k * k {
            l = k;
        }
    }
    l
}

/// Returns the zonal coefficients of a spherical cap (1 inside, 0 outside) around +z, B ≤ 5 bands.
///
/// `alpha` = sin θ of the half angle θ ≤ 90°, for a sphere radius/distance; clamped to [0, 1], NaN counts as 0.
/// Factored forms without cancellation: 3e-7 relative at any alpha, V_l → α²√(π(2l + 1))/2 as α → 0.
#[inline]
pub fn cap<const B: usize>(alpha: f32) -> [f32; B] {
    const { assert!(B >= 1 && B <= 5) };
    let alpha = saturate(alpha);
    let s2 = alpha * alpha;
    let c = sqrt((1.0 - alpha) * (1.0 + alpha));
    let mut v = [0.0; B];
    v[0] = CAP_FACTOR[0] * div(s2, 1.0 + c);
    if const { B > 1 } {
        v[1] = CAP_FACTOR[1] * s2;
    }
    if const { B > 2 } {
        v[2] = CAP_FACTOR[2] * (s2 * c);
    }
    // 5c² − 1 and 7c² − 3 in terms of s² = 1 − c², which does not lose the digits of c².
    if const { B > 3 } {
        v[3] = CAP_FACTOR[3] * (s2 * (4.0 - 5.0 * s2));
    }
    if const { B > 4 } {
        v[4] = CAP_FACTOR[4] * ((s2 * c) * (4.0 - 7.0 * s2));
    }
    v
}

/// Returns the solid angle of a cap: 2π(1 − cos θ) = 2π α²/(1 + cos θ), from 0 to 2π. Range as [`cap`].
#[inline]
pub fn cap_solid_angle(alpha: f32) -> f32 {
    let alpha = saturate(alpha);
    let c = sqrt((1.0 - alpha) * (1.0 + alpha));
    (2.0 * PI) * div(alpha * alpha, 1.0 + c)
}

/// Returns the zonal coefficients of the visibility beside a cap: 1 − [`cap`]. SGI eqs. 3 and 4.
#[inline]
pub fn visibility<const B: usize>(alpha: f32) -> [f32; B] {
    let mut v = cap::<B>(alpha);
    for l in 0..B {
        v[l] = -v[l];
    }
    v[0] += UNIT;
    v
}

/// Returns a zonal vector turned from +z to the unit direction d: √(4π/(2l + 1)) g_l y_lm(d). SGI eq. 8.
///
/// N = B². Within 2e-6 of the norm.
#[inline]
pub fn rotate_zonal<const B: usize, const N: usize>(zonal: &[f32; B], d: Vec3) -> [f32; N] {
    const { assert!(N == B * B) };
    let y = basis::<N>(d);
    convolve(&y, zonal)
}

/// Returns the convolution of a function with a zonal one: √(4π/(2l + 1)) f_lm g_l. SGI eq. 7.
///
/// N = B². The factor of band l applies to its 2l + 1 coefficients (the paper says l).
#[inline]
pub fn convolve<const B: usize, const N: usize>(f: &[f32; N], zonal: &[f32; B]) -> [f32; N] {
    const { assert!(N == B * B) };
    let mut factor = [0.0; B];
    for l in 0..B {
        factor[l] = BAND_FACTOR[l] * zonal[l];
    }
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = factor[band(i)] * f[i];
    }
    out
}

/// Returns the irradiance of a light for every normal: its convolution with max(0, cos θ). SGI eq. 13.
///
/// Evaluated at a normal and multiplied by albedo/π it is reflected radiance. A light of radiance 1 gives π.
#[inline]
// Copies between slices do not compile to SPIR-V.
#[allow(clippy::manual_memcpy)]
pub fn irradiance<const B: usize, const N: usize>(light: &[f32; N]) -> [f32; N] {
    let mut cosine = [0.0; B];
    for l in 0..B {
        cosine[l] = CLAMPED_COSINE[l];
    }
    convolve(light, &cosine)
}
