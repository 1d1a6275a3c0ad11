//! How wide is the distribution of directions behind an average of unit vectors?
//!
//! A lobe is stored as the mean D of its unit directions; the shorter D, the wider the lobe (Toksvig; VCT §4.3).

use crate::math::{clamp, div, length, normalize_or, recip, saturate, sin_cos};
use glam::Vec3;

/// The shortest mean that still counts as a direction; shorter ones have the variance of this one, 9999.
pub const MIN_LENGTH: f32 = 1e-4;

/// A Gaussian lobe: its axis and the variance σ² of the directions about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lobe {
    /// Unit axis.
    pub axis: Vec3,
    /// σ², from 0 (one direction) to 9999 (as good as uniform).
    pub variance: f32,
}

/// Returns the lobe behind a mean of unit vectors; `fallback` is the axis when the mean is 0 (opposite directions).
#[inline]
pub fn lobe_of_mean(mean: Vec3, fallback: Vec3) -> Lobe {
    Lobe { axis: normalize_or(mean, fallback), variance: length_to_variance(length(mean)) }
}

/// Returns σ² = (1 − |D|)/|D|, |D| clamped to [1e-4, 1]; 9999 for NaN. VCT §4.3 (garbled in print).
///
/// Exact to 1.2e-7 relative for the given length. A length *computed* from averaged unit normals carries 2⁻²⁴,
/// which is 5 % of σ² for a spread of 1e-3: see [`spread_to_variance`].
#[inline]
pub fn length_to_variance(length: f32) -> f32 {
    let length = clamp(length, MIN_LENGTH, 1.0);
    div(1.0 - length, length)
}

/// Returns |D| = 1/(1 + σ²), in (0, 1]; negative variances and NaN count as 0.
#[inline]
pub fn variance_to_length(variance: f32) -> f32 {
    recip(1.0 + clamp(variance, 0.0, 1e18))
}

/// Returns σ² from the mean squared deviation v = mean |n − mean n|² of unit vectors and their mean length.
///
/// v/(|D|(1 + |D|)): keeps seven digits for tight lobes, where 1 − |D| has lost them.
#[inline]
pub fn spread_to_variance(mean_squared_deviation: f32, length: f32) -> f32 {
    let length = clamp(length, MIN_LENGTH, 1.0);
    div(clamp(mean_squared_deviation, 0.0, 1.0), length * (1.0 + length))
}

/// Returns the length of the convolution of two lobes: σ² adds, hence |D| = ab/(a + b − ab). VCT §7.
///
/// Commutative bit for bit; a lobe of length 1 is neutral within 2⁻²³. Lengths are clamped to [1e-4, 1].
#[inline]
pub fn convolve_lengths(a: f32, b: f32) -> f32 {
    let a = clamp(a, MIN_LENGTH, 1.0);
    let b = clamp(b, MIN_LENGTH, 1.0);
    saturate(div(a * b, (a + b) - a * b))
}

/// Returns σ of a uniform cone of directions of half angle ψ in radians: tan(ψ/2), from 0 to 1 at 90°.
///
/// The lobe with the cone's mean length (1 + cos ψ)/2. (VCT prints σ = cos ψ, which would give a needle the widest
/// lobe.) ψ is clamped to [0, π/2]; 0 for NaN.
#[inline]
pub fn cone_deviation(half_angle: f32) -> f32 {
    let (sine, cosine) = sin_cos(clamp(half_angle, 0.0, core::f32::consts::FRAC_PI_2));
    div(sine, 1.0 + cosine)
}

/// Returns κ of the von Mises–Fisher distribution of this mean length: |D|(3 − |D|²)/(1 − |D|²), up to 1e8.
///
/// Banerjee's approximation: within 5 % of the true κ over [0, 1).
#[inline]
pub fn von_mises_fisher_concentration(length: f32) -> f32 {
    let length = saturate(length);
    let rest = (1.0 - length) * (1.0 + length);
    clamp(div(length * (3.0 - length * length), clamp(rest, 1e-8, 1.0)), 0.0, 1e8)
}
