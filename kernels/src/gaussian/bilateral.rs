//! Which neighbouring pixels see the same surface, and how much does each count?

use crate::math::{MIN_POSITIVE, abs, clamp, div, dot, exp, is_nan, max, min, powi, recip, saturate};
use glam::Vec3;

/// Smallest standard deviation of a Gaussian weight.
const MIN_DEVIATION: f32 = 1e-6;

/// Sums of relative weights below this mean that no sample matches.
const NO_MATCH: f32 = 1e-12;

/// Weights below this share of the largest are left out.
const NEGLIGIBLE: f32 = 1e-4;

/// The thresholds of [`shares_visibility`] stop short of 1 by this much, so that a pixel always accepts itself.
const UNIT_TOLERANCE: f32 = 1.0 / 1_048_576.0;

/// The 2×2 coarse samples around a pixel. A normal of 0 says that there is no surface.
#[derive(Clone, Copy, Debug)]
pub struct CoarseSamples {
    /// Bilinear weights of the pixel's position, at least 0, summing to 1.
    pub bilinear: [f32; 4],
    /// View depths.
    pub depth: [f32; 4],
    /// Unit normals.
    pub normal: [Vec3; 4],
}

/// Returns the weight of a depth difference: 1/(ε + |Δz|), ε = 1e-3·|z| + 1e-18, at most 1e18. SGI eq. 11.
///
/// `depth` is that of the pixel; ε is relative to it, so the weight means the same at any scale.
#[inline]
pub fn depth_similarity(depth: f32, sample_depth: f32) -> f32 {
    recip(depth_gap(depth, sample_depth))
}

/// ε + |Δz| of SGI eq. 11.
#[inline]
fn depth_gap(depth: f32, sample_depth: f32) -> f32 {
    let depth = clamp(depth, -1e18, 1e18);
    let sample_depth = clamp(sample_depth, -1e18, 1e18);
    (1e-3 * abs(depth) + 1e-18) + abs(depth - sample_depth)
}

/// Returns the weight of a pair of unit normals: (N·N′)³² with N·N′ clamped to [0, 1]. SGI eq. 11.
///
/// Without the clamp opposite normals would weigh 1. 1.3e-7 of the power itself, and 32 times what is off in the cosine: 6e-6 relative.
#[inline]
pub fn normal_similarity(a: Vec3, b: Vec3) -> f32 {
    powi(saturate(dot(a, b)), 32)
}

/// How fast a neighbour off the tangent plane stops to count.
const OFF_PLANE: f32 = 16.0;

/// Returns how much a point belongs to the tangent plane of another: 1 − 16 sin² of the angle under which it stands over the plane, 0
/// from 14.5° on; 1 for the point itself.
///
/// `apart` leads from one to the other, in any unit of which its square is between 1e-30 and 1e30; the normal is a unit vector.
#[inline]
pub fn plane_similarity(apart: Vec3, normal: Vec3) -> f32 {
    let off = dot(apart, normal);
    saturate(1.0 - div(OFF_PLANE * (off * off), max(dot(apart, apart), 1.0e-30)))
}

/// Returns the four weights with which coarse samples make up a pixel: bilinear × depth × normal, summing to 1.
///
/// Where nothing matches, the sample of nearest depth (of lowest index among equals) gets weight 1 and the others 0;
/// all four are 0 when no sample has a surface. SGI eq. 11, guarded.
#[inline]
pub fn upsampling_weights(samples: &CoarseSamples, depth: f32, normal: Vec3) -> [f32; 4] {
    let mut nearest = 4usize;
    let mut nearest_gap = f32::MAX;
    for i in 0..4 {
        let exists = dot(samples.normal[i], samples.normal[i]) > 0.0;
        let gap = depth_gap(depth, samples.depth[i]);
        if exists && gap < nearest_gap {
            nearest = i;
            nearest_gap = gap;
        }
    }
    let mut weights = [0.0; 4];
    if nearest == 4 {
        return weights;
    }
    let mut sum = 0.0;
    for i in 0..4 {
        // Relative to the nearest depth, so that the sum says how well they match at any scale.
        let relative = saturate(div(nearest_gap, depth_gap(depth, samples.depth[i])));
        let similarity = relative * normal_similarity(normal, samples.normal[i]);
        let weight = saturate(samples.bilinear[i]) * similarity;
        // Below, devices may flush the power to 0, and the division by a small sum would make that visible.
        weights[i] = if weight < MIN_POSITIVE { 0.0 } else { weight };
        sum += weights[i];
    }
    if sum < NO_MATCH {
        weights = [0.0; 4];
        weights[nearest] = 1.0;
        return weights;
    }
    for i in 0..4 {
        weights[i] = div(weights[i], sum);
    }
    weights
}

/// Returns the four weights with which coarse samples make up a pixel by their places alone: bilinear among those that have a surface, or all of
/// the one of largest weight (of lowest index among equals). They sum to 1, or are 0 when no sample has a surface.
#[inline]
pub fn place_weights(samples: &CoarseSamples, nearest: bool) -> [f32; 4] {
    let mut weights = [0.0; 4];
    let mut sum = 0.0;
    let mut best = 4usize;
    let mut largest = -1.0;
    for i in 0..4 {
        if dot(samples.normal[i], samples.normal[i]) > 0.0 {
            weights[i] = saturate(samples.bilinear[i]);
            sum += weights[i];
            if weights[i] > largest {
                best = i;
                largest = weights[i];
            }
        }
    }
    if best == 4 {
        return weights;
    }
    if nearest || sum < NO_MATCH {
        weights = [0.0; 4];
        weights[best] = 1.0;
        return weights;
    }
    for i in 0..4 {
        weights[i] = div(weights[i], sum);
    }
    weights
}

/// Returns exp(−x²/(2σ²)), in (0, 1]; σ below 1e-6 and NaN count as 1e-6, the exponent is at least −87.
#[inline]
pub fn gaussian_falloff(x: f32, deviation: f32) -> f32 {
    let q = div(clamp(abs(x), 0.0, 1e12), clamp(deviation, MIN_DEVIATION, 1e18));
    exp(max(-0.5 * (q * q), -87.0))
}

/// Returns the joint bilateral weight of two pixels: Gaussian in depth difference and in 1 − N·N′. VF eq. 5, w_G.
#[inline]
pub fn geometric_weight(
    depth_difference: f32,
    normal_cosine: f32,
    depth_deviation: f32,
    normal_deviation: f32,
) -> f32 {
    gaussian_falloff(depth_difference, depth_deviation)
        * gaussian_falloff(1.0 - saturate(normal_cosine), normal_deviation)
}

/// Returns the weights of four coarse pixels around a pixel, w_G·w_l over their sum. VF eq. 5.
///
/// `distance` is that of each from the pixel's tangent plane, `normal` its unit normal, 0 where there is no surface. Where
/// nothing matches, the one nearest to the plane gets weight 1; all are 0 when none has a surface. Weights below 1e-4 of
/// the largest are 0: their lists need not be read.
#[inline]
pub fn gathering_weights(
    bilinear: &[f32; 4],
    distance: &[f32; 4],
    normal: &[Vec3; 4],
    own_normal: Vec3,
    depth_deviation: f32,
    normal_deviation: f32,
) -> [f32; 4] {
    let mut weights = [0.0; 4];
    let mut nearest = 4usize;
    let mut nearest_distance = f32::MAX;
    let mut largest = 0.0;
    for i in 0..4 {
        if dot(normal[i], normal[i]) > 0.0 {
            let gap = abs(clamp(distance[i], -1e18, 1e18));
            if gap < nearest_distance {
                nearest = i;
                nearest_distance = gap;
            }
            let cosine = dot(normal[i], own_normal);
            let similarity = geometric_weight(gap, cosine, depth_deviation, normal_deviation);
            weights[i] = saturate(bilinear[i]) * similarity;
            largest = max(largest, weights[i]);
        }
    }
    if nearest == 4 {
        return [0.0; 4];
    }
    if largest < NO_MATCH {
        weights = [0.0; 4];
        weights[nearest] = 1.0;
        return weights;
    }
    let mut sum = 0.0;
    for i in 0..4 {
        if weights[i] < NEGLIGIBLE * largest {
            weights[i] = 0.0;
        }
        sum += weights[i];
    }
    for i in 0..4 {
        weights[i] = div(weights[i], sum);
    }
    weights
}

/// Returns `sum`/`count`, component by component, or 0 where the effective count N_c is 0. VF eq. 5.
#[inline]
pub fn mean_or_zero(sum: Vec3, count: f32) -> Vec3 {
    if is_nan(count) || count < f32::MIN_POSITIVE {
        return Vec3::ZERO;
    }
    Vec3::new(div(sum.x, count), div(sum.y, count), div(sum.z, count))
}

/// Returns whether two pixels exchange their lists of visible voxels: |Δz| ≤ limit and N·N′ ≥ limit. VF eq. 4.
///
/// Symmetric in the two pixels, and every pixel with a surface accepts itself: limits are moved into [0, …] and
/// […, 1 − 2⁻²⁰]. False for NaN.
#[inline]
pub fn shares_visibility(
    depth_difference: f32,
    normal_cosine: f32,
    max_depth_difference: f32,
    min_normal_cosine: f32,
) -> bool {
    if is_nan(depth_difference) || is_nan(normal_cosine) {
        return false;
    }
    abs(depth_difference) <= max(max_depth_difference, 0.0)
        && normal_cosine >= min(min_normal_cosine, 1.0 - UNIT_TOLERANCE)
}
