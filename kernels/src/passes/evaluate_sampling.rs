//! Do hashes, sequences, sample counts and direction sets give the same bits on this device?

use super::evaluate::{EvaluateParams, Evaluation, bit, of_numbers, of_words};
use crate::math::normalize_or;
use crate::sampling::attenuation::{
    bounded_inverse_square, clamped_inverse_square, disc_form_factor, disc_radius, range_window,
    vpl_form_factor,
};
use crate::sampling::halton::{
    halton, radical_inverse_2, radical_inverse_3, radical_inverse_5, radical_inverse_7, rotated,
};
use crate::sampling::hash::{combine, hash, position_hash, unit_float};
use crate::sampling::hemisphere::{
    cone, cosine_hemisphere, fold_barycentrics, to_world, triangle_point, uniform_sphere,
};
use crate::sampling::roulette::{accept, sample_count};
use crate::sampling::voxel_hash::{decode, encode, voxel_of};
use glam::{UVec4, Vec2, Vec3, Vec4};

/// Selects the function that [`evaluate_sampling`] evaluates.
pub mod function {
    #![allow(missing_docs)]
    pub const HASH: u32 = 0;
    /// Radical inverses in bases 2, 3, 5 and 7.
    pub const RADICAL_INVERSE: u32 = 1;
    /// A Halton point, rotated.
    pub const HALTON: u32 = 2;
    /// Sample count and acceptance.
    pub const ROULETTE: u32 = 3;
    pub const POSITION_HASH: u32 = 4;
    /// A voxel number decoded, and encoded again.
    pub const VOXEL_NUMBER: u32 = 5;
    pub const VOXEL_OF: u32 = 6;
    pub const COSINE_HEMISPHERE: u32 = 7;
    pub const UNIFORM_SPHERE: u32 = 8;
    /// Folded weights of a triangle's corners.
    pub const BARYCENTRICS: u32 = 9;
    /// A point of a triangle.
    pub const TRIANGLE_POINT: u32 = 10;
    /// Axis and weight of a cone of a set.
    pub const CONE: u32 = 11;
    /// Tangent of a cone's half angle.
    pub const CONE_TANGENT: u32 = 12;
    /// Form factors of a disc and of a virtual light.
    pub const FORM_FACTOR: u32 = 13;
    /// Bounded laws of distance.
    pub const ATTENUATION: u32 = 14;
    /// Number of functions.
    pub const COUNT: u32 = 15;
}

/// Returns the selected function of words\[index\], x\[index\] and y\[index\]; 0 for an unknown selection.
#[inline]
pub fn evaluate_sampling(
    index: u32,
    params: &EvaluateParams,
    words: &[UVec4],
    x: &[Vec4],
    y: &[Vec4],
) -> Evaluation {
    let w = words[index as usize];
    let x = x[index as usize];
    let y = y[index as usize];
    let square = Vec2::new(x.x, x.y);
    match params.function {
        function::HASH => Evaluation {
            numbers: Vec4::new(unit_float(w.x), unit_float(hash(w.x)), 0.0, 0.0),
            words: UVec4::new(hash(w.x), combine(w.x, w.y), combine(combine(w.x, w.y), w.z), 0),
        },
        function::RADICAL_INVERSE => of_numbers(Vec4::new(
            radical_inverse_2(w.x),
            radical_inverse_3(w.x),
            radical_inverse_5(w.x),
            radical_inverse_7(w.x),
        )),
        function::HALTON => {
            let point = halton(w.x);
            let (r, s) = (rotated(point.x, unit_float(w.y)), rotated(point.y, unit_float(w.z)));
            of_numbers(Vec4::new(point.x, point.y, r, s))
        }
        function::ROULETTE => {
            of_words(UVec4::new(sample_count(x.x, w.x), bit(accept(w.y, x.y)), sample_count(x.z, w.z), 0))
        }
        function::POSITION_HASH => of_words(UVec4::new(position_hash(x.truncate(), y.x), 0, 0, 0)),
        function::VOXEL_NUMBER => {
            let dims = w.truncate();
            let voxel = decode(w.w, dims);
            of_words(UVec4::new(voxel.x, voxel.y, voxel.z, encode(voxel, dims)))
        }
        function::VOXEL_OF => {
            let voxel = voxel_of(x.truncate(), y.truncate(), Vec3::splat(y.w), w.truncate());
            of_words(voxel.extend(encode(voxel, w.truncate())))
        }
        function::COSINE_HEMISPHERE => {
            let local = cosine_hemisphere(square);
            of_numbers(to_world(local, normalize_or(y.truncate(), Vec3::Y)).extend(local.z))
        }
        function::UNIFORM_SPHERE => of_numbers(uniform_sphere(square).extend(0.0)),
        function::BARYCENTRICS => of_numbers(fold_barycentrics(square).extend(0.0)),
        function::TRIANGLE_POINT => {
            let (a, b) = (y.truncate(), Vec3::new(y.y, y.z, y.w));
            of_numbers(triangle_point(a, b, Vec3::new(x.z, x.w, y.x), fold_barycentrics(square)).extend(0.0))
        }
        function::CONE => {
            let c = cone(w.x, w.y, x.x);
            of_numbers(c.direction.extend(c.weight))
        }
        function::CONE_TANGENT => of_numbers(Vec4::new(cone(w.x, w.y, x.x).tangent, 0.0, 0.0, 0.0)),
        function::FORM_FACTOR => {
            let normal = normalize_or(Vec3::new(y.y, y.z, y.w), Vec3::Y);
            let emitter_normal = Vec3::new(-normal.y, normal.z, -normal.x);
            let seen = vpl_form_factor(x.truncate(), normal, y.truncate(), emitter_normal, x.w);
            of_numbers(Vec4::new(disc_form_factor(x.x, x.y, x.z, x.w), seen, 0.0, 0.0))
        }
        function::ATTENUATION => of_numbers(Vec4::new(
            bounded_inverse_square(x.x, x.y),
            clamped_inverse_square(x.x, x.y),
            range_window(x.x, x.y),
            disc_radius(x.x),
        )),
        _ => of_words(UVec4::ZERO),
    }
}
