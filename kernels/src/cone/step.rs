//! How far does a cone step, at which level does it sample, and how much of a sample does a step count?

use crate::math::{
    clamp, div, exp_minus_one, exp2, floor, ln_one_plus, log2, max, min, saturate, sin_cos, to_u32,
};
use glam::Vec4;

/// The widest half angle of a cone, 85°: the tangent is 11.43 there and diverges at 90°.
pub const MAX_HALF_ANGLE: f32 = 85.0 * (core::f32::consts::PI / 180.0);

/// The largest ratio of step length to voxel size; larger ratios count as this one.
pub const MAX_STEP_RATIO: f32 = 1_048_576.0;

/// Opacities below 2⁻⁶⁴ count as 0 in [`premultiplied_scale`]: the limit is then exact to rounding.
const NEGLIGIBLE_OPACITY: f32 = 5.421_011e-20;

/// Returns the opacity of a step of `ratio` voxels through voxels of opacity `alpha`: 1 − (1 − α)^ratio.
///
/// `alpha` in [0, 1], `ratio` = step length / voxel size at the sampled level; α = 0 or ratio = 0 gives 0, α = 1
/// gives 1, both exactly; values outside are clamped, NaN counts as 0. Evaluated without cancellation as
/// −expm1(ratio·log1p(−α)): 3e-7 relative (the naive form has lost everything at α = 1e-7). VCT §5.
#[inline]
pub fn corrected_opacity(alpha: f32, ratio: f32) -> f32 {
    let alpha = saturate(alpha);
    let ratio = clamp(ratio, 0.0, MAX_STEP_RATIO);
    if ratio <= 0.0 {
        return 0.0;
    }
    // The saturating logarithm would give less than 1 for small ratios.
    if alpha >= 1.0 {
        return 1.0;
    }
    -exp_minus_one(ratio * ln_one_plus(-alpha))
}

/// Returns the factor α_s/α that a premultiplied colour takes when [`corrected_opacity`] corrects its opacity.
///
/// Tends to `ratio` as α → 0, where emission is proportional to path length; 4e-7 relative. Same ranges as there.
#[inline]
pub fn premultiplied_scale(alpha: f32, ratio: f32) -> f32 {
    let alpha = saturate(alpha);
    let ratio = clamp(ratio, 0.0, MAX_STEP_RATIO);
    if alpha < NEGLIGIBLE_OPACITY {
        return ratio;
    }
    div(corrected_opacity(alpha, ratio), alpha)
}

/// Returns a premultiplied sample (colour, opacity) as a step of `ratio` voxels counts it.
///
/// Two half steps composite to one whole step within 1e-6. VCT §5, with the colour scaled as the opacity.
#[inline]
pub fn corrected_sample(sample: Vec4, ratio: f32) -> Vec4 {
    let scale = premultiplied_scale(sample.w, ratio);
    (sample.truncate() * scale).extend(corrected_opacity(sample.w, ratio))
}

/// Returns tan of a cone's half angle in radians, clamped to [0, 85°]; 0 for NaN.
#[inline]
pub fn aperture_tangent(half_angle: f32) -> f32 {
    let (sine, cosine) = sin_cos(clamp(half_angle, 0.0, MAX_HALF_ANGLE));
    div(sine, cosine)
}

/// Returns the diameter of a cone at `distance` from its apex: 2 t tan ψ, in the unit of `distance`.
#[inline]
pub fn diameter(distance: f32, aperture_tangent: f32) -> f32 {
    2.0 * (distance * aperture_tangent)
}

/// Returns the mip level whose voxels are as wide as the cone: log₂ of the diameter in voxels of level 0.
///
/// In [0, `max_level`], `max_level` ≤ 32; exactly 0 for diameters up to 1 (also 0, negative and NaN), exactly k at
/// 2^k. The fraction is the weight of the next level.
#[inline]
pub fn mip_level(diameter_in_voxels: f32, max_level: f32) -> f32 {
    let max_level = clamp(max_level, 0.0, 32.0);
    let diameter = clamp(diameter_in_voxels, 1.0, exp2(max_level));
    min(log2(diameter), max_level)
}

/// Returns the length of the next step: `factor` times the larger of cone diameter and voxel size.
///
/// `factor` is clamped to [1/64, 64], so a step is never 0 for a positive `voxel`, whatever the aperture.
#[inline]
pub fn step_length(diameter: f32, voxel: f32, factor: f32) -> f32 {
    max(diameter, voxel) * clamp(factor, 0.015_625, 64.0)
}

/// Returns a number of steps of [`step_length`] after which a march over `range` has ended: the loop bound.
///
/// That of the narrowest cone, which steps by whole voxels; at least 1 (also for NaN), at most 65 536.
#[inline]
pub fn step_count_bound(range: f32, voxel: f32, factor: f32) -> u32 {
    let shortest = clamp(step_length(0.0, voxel, factor), 1e-18, 1e18);
    to_u32(min(floor(div(clamp(range, 0.0, 1e18), shortest)), 65_535.0)) + 1
}
