//! How much does an occluder at a distance count, and what do several cones see together?

use crate::math::{clamp, div, is_nan, recip};
use glam::Vec4;

/// Returns the weight of an occluder at `distance`: f(r) = 1/(1 + λr), in (0, 1], 1 at r = 0.
///
/// Negative and NaN arguments count as 0, those above 1e18 as 1e18. VCT §6.
#[inline]
pub fn distance_falloff(distance: f32, lambda: f32) -> f32 {
    recip(1.0 + clamp(distance, 0.0, 1e18) * clamp(lambda, 0.0, 1e18))
}

/// Returns the opacity that a sample at `distance` keeps for ambient occlusion: f(r)·α. VCT §6.
#[inline]
pub fn faded_opacity(alpha: f32, distance: f32, lambda: f32) -> f32 {
    distance_falloff(distance, lambda) * alpha
}

/// The weighted sum of what several cones see, and of their weights.
///
/// Divided by the sum of weights, not by a constant: an empty scene gives visibility 1 exactly, a closed one 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConeSum {
    /// Σ weight·value.
    pub weighted: Vec4,
    /// Σ weight.
    pub weight: f32,
}

impl ConeSum {
    /// No cone yet.
    pub const EMPTY: Self = Self { weighted: Vec4::ZERO, weight: 0.0 };

    /// Returns the sum with one cone more; its weight is solid angle times cosine, at least 0.
    #[inline]
    pub fn with(self, value: Vec4, weight: f32) -> Self {
        Self { weighted: self.weighted + value * weight, weight: self.weight + weight }
    }

    /// Returns the mean, or `fallback` when no cone had a weight above 2⁻¹⁰⁰.
    #[inline]
    pub fn mean(self, fallback: Vec4) -> Vec4 {
        if is_nan(self.weight) || self.weight <= 7.888_609e-31 {
            return fallback;
        }
        Vec4::new(
            div(self.weighted.x, self.weight),
            div(self.weighted.y, self.weight),
            div(self.weighted.z, self.weight),
            div(self.weighted.w, self.weight),
        )
    }
}
