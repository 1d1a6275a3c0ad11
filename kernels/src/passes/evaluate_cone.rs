//! Do cone steps and compositing give the same bits on this device?

use super::evaluate::EvaluateParams;
use crate::cone::{
    ConeSum, accumulate, aperture_tangent, composite, corrected_opacity, corrected_sample, diameter,
    distance_falloff, faded_opacity, mip_level, premultiplied_scale, step_count_bound, step_length,
};
use glam::Vec4;

/// Selects the function that [`evaluate_cone`] evaluates.
pub mod function {
    #![allow(missing_docs)]
    /// Opacity a.x over a.y voxels, and the scale of its colour.
    pub const OPACITY: u32 = 0;
    /// The sample a over b.x voxels.
    pub const SAMPLE: u32 = 1;
    /// Half angle a.x, distance a.y, coarsest level a.z: tangent, diameter, level, step.
    pub const STEP: u32 = 2;
    /// Falloff with distance a.x and λ a.y; bound of the number of steps.
    pub const FALLOFF: u32 = 3;
    /// a over b.
    pub const COMPOSITE: u32 = 4;
    /// a over the colour b with opacity b.w.
    pub const ACCUMULATE: u32 = 5;
    /// The mean of a and b with weights b.w and a.w.
    pub const MEAN: u32 = 6;
    /// Number of functions.
    pub const COUNT: u32 = 7;
}

/// Returns the selected function of a\[index\] and b\[index\]; 0 for an unknown selection.
#[inline]
pub fn evaluate_cone(index: u32, params: &EvaluateParams, a: &[Vec4], b: &[Vec4]) -> Vec4 {
    let (a, b) = (a[index as usize], b[index as usize]);
    match params.function {
        function::OPACITY => Vec4::new(corrected_opacity(a.x, a.y), premultiplied_scale(a.x, a.y), 0.0, 0.0),
        function::SAMPLE => corrected_sample(a, b.x),
        function::STEP => {
            let tangent = aperture_tangent(a.x);
            let width = diameter(a.y, tangent);
            Vec4::new(tangent, width, mip_level(width, a.z), step_length(width, a.w, b.x))
        }
        function::FALLOFF => Vec4::new(
            distance_falloff(a.x, a.y),
            faded_opacity(a.z, a.x, a.y),
            step_count_bound(b.x, b.y, b.z) as f32,
            0.0,
        ),
        function::COMPOSITE => composite(a, b),
        function::ACCUMULATE => accumulate(a, b.truncate(), b.w),
        function::MEAN => ConeSum::EMPTY.with(a, b.w).with(b, a.w).mean(a),
        _ => Vec4::ZERO,
    }
}
