//! Do Gaussian lobes, weights and depth windows give the same bits on this device?

use super::evaluate::EvaluateParams;
use crate::gaussian::{
    CoarseSamples, cone_deviation, convolve_lengths, depth_coverage, depth_similarity, gaussian_falloff,
    geometric_weight, layer_coordinate, layer_decay, length_to_variance, lobe_of_mean, lobe_offset,
    mean_or_zero, minimum_deviation, normal_similarity, one_minus_cosine, shares_visibility, smooth_step,
    specular_falloff, specular_weight, spread_to_variance, upsampling_weights, variance_from_moments,
    variance_to_length, von_mises_fisher_concentration, weighted_moments,
};
use glam::{Vec3, Vec4};

/// Selects the function that [`evaluate_gaussian`] evaluates.
pub mod function {
    #![allow(missing_docs)]
    /// Axis and variance of the lobe of mean a.
    pub const LOBE: u32 = 0;
    /// Variance and length of lobes a.x and a.y.
    pub const LENGTHS: u32 = 1;
    /// Deviation of a cone, concentration of von Mises and Fisher.
    pub const CONE_DEVIATION: u32 = 2;
    /// Directions a and b, exponent c.x, deviation c.y: 1 − cosine, offset, falloff, weight.
    pub const SPECULAR: u32 = 3;
    /// Depths a, bilinear weights b, normals that are permutations of c, own depth c.w.
    pub const UPSAMPLING: u32 = 4;
    /// Weights of depth and normal differences.
    pub const SIMILARITY: u32 = 5;
    /// Mean a.x, deviation a.y, centre a.z, radius a.w.
    pub const COVERAGE: u32 = 6;
    /// Variances of depth.
    pub const MOMENTS: u32 = 7;
    /// Coordinate and weight of a depth layer.
    pub const LAYERS: u32 = 8;
    /// Mean of a over b.x, and whether two pixels share visibility.
    pub const MEAN: u32 = 9;
    /// Number of functions.
    pub const COUNT: u32 = 10;
}

/// Returns the selected function of a\[index\], b\[index\] and c\[index\]; 0 for an unknown selection.
#[inline]
pub fn evaluate_gaussian(index: u32, params: &EvaluateParams, a: &[Vec4], b: &[Vec4], c: &[Vec4]) -> Vec4 {
    let (a, b, c) = (a[index as usize], b[index as usize], c[index as usize]);
    let (p, q) = (a.truncate(), b.truncate());
    match params.function {
        function::LOBE => {
            let lobe = lobe_of_mean(p, Vec3::Y);
            lobe.axis.extend(lobe.variance)
        }
        function::LENGTHS => Vec4::new(
            length_to_variance(a.x),
            variance_to_length(a.y),
            spread_to_variance(a.z, a.x),
            convolve_lengths(a.x, a.w),
        ),
        function::CONE_DEVIATION => {
            Vec4::new(cone_deviation(a.x), von_mises_fisher_concentration(a.y), 0.0, 0.0)
        }
        function::SPECULAR => {
            let gap = one_minus_cosine(p, q);
            Vec4::new(
                gap,
                lobe_offset(gap, c.x),
                specular_falloff(gap, c.x, c.y),
                specular_weight(gap, c.x, c.y),
            )
        }
        function::UPSAMPLING => {
            let normal = c.truncate();
            let samples = CoarseSamples {
                bilinear: b.to_array(),
                depth: a.to_array(),
                normal: [
                    normal,
                    Vec3::new(c.y, c.z, c.x),
                    Vec3::new(c.x, c.z, c.y),
                    if b.w > 0.125 { normal } else { Vec3::ZERO },
                ],
            };
            Vec4::from_array(upsampling_weights(&samples, c.w, normal))
        }
        function::SIMILARITY => Vec4::new(
            depth_similarity(a.x, b.x),
            normal_similarity(p, q),
            gaussian_falloff(a.x, c.x),
            geometric_weight(a.x, b.y, c.x, c.y),
        ),
        function::COVERAGE => Vec4::new(depth_coverage(a.x, a.y, a.z, a.w), 0.0, 0.0, 0.0),
        function::MOMENTS => {
            let (mean, variance) = weighted_moments(b.x, a.x, a.y, c.x);
            Vec4::new(variance_from_moments(a.x, a.y, c.x), mean, variance, minimum_deviation(a.z, a.w))
        }
        function::LAYERS => Vec4::new(
            layer_coordinate(a.x, a.y, a.z),
            layer_decay(a.x, a.y, a.z, a.w, false, false),
            layer_decay(a.x, a.y, a.z, a.w, true, false),
            smooth_step(b.x),
        ),
        function::MEAN => {
            let shared = if shares_visibility(a.x, a.y, b.y, b.z) { 1.0 } else { 0.0 };
            mean_or_zero(p, b.x).extend(shared)
        }
        _ => Vec4::ZERO,
    }
}
