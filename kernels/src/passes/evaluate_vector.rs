//! Does vector algebra give the same bits on this device?

use super::evaluate::EvaluateParams;
use crate::math::{
    copy_sign, cross, dot, dot4, exp2_integer, floor, length, max_abs, normalize_or, orthonormal_frame, powi,
    saturate, to_u32, transform_point,
};
use glam::{Mat4, Vec3, Vec4};

/// Selects the function that [`evaluate_vector`] evaluates.
pub mod function {
    #![allow(missing_docs)]
    pub const NORMALIZE: u32 = 0;
    pub const CROSS: u32 = 1;
    /// a·b, a·b over four components, |a|, largest component.
    pub const PRODUCTS: u32 = 2;
    /// Tangent of the frame of the direction a.
    pub const TANGENT: u32 = 3;
    /// Bitangent of the frame of the direction a.
    pub const BITANGENT: u32 = 4;
    /// The point b by a matrix made from a.
    pub const TRANSFORM: u32 = 5;
    /// floor, sign of b on a, fifth power, [0, 1].
    pub const SCALARS: u32 = 6;
    /// Powers of two and conversion to integers.
    pub const EXPONENTS: u32 = 7;
    /// Number of functions.
    pub const COUNT: u32 = 8;
}

/// Returns the selected function of a\[index\] and b\[index\]; 0 for an unknown selection.
#[inline]
pub fn evaluate_vector(index: u32, params: &EvaluateParams, a: &[Vec4], b: &[Vec4]) -> Vec4 {
    let a = a[index as usize];
    let b = b[index as usize];
    let (p, q) = (a.truncate(), b.truncate());
    match params.function {
        function::NORMALIZE => normalize_or(p, Vec3::Y).extend(0.0),
        function::CROSS => cross(p, q).extend(0.0),
        function::PRODUCTS => Vec4::new(dot(p, q), dot4(a, b), length(p), max_abs(p)),
        function::TANGENT => orthonormal_frame(p).0.extend(0.0),
        function::BITANGENT => orthonormal_frame(p).1.extend(0.0),
        function::TRANSFORM => {
            let m = Mat4::from_cols(a, Vec4::new(a.y, a.z, a.w, a.x), Vec4::new(a.z, a.w, a.x, a.y), b);
            transform_point(&m, q).extend(0.0)
        }
        function::SCALARS => Vec4::new(floor(a.x), copy_sign(a.x, b.x), powi(a.y, 5), saturate(a.z)),
        function::EXPONENTS => {
            // Exponents from −100 to 100.
            let exponent = (to_u32(saturate(a.x) * 200.0) as i32) - 100;
            Vec4::new(exp2_integer(exponent), to_u32(a.y) as f32, to_u32(floor(a.z)) as f32, 0.0)
        }
        _ => Vec4::ZERO,
    }
}
