//! Do operations on spherical harmonics give the same bits on this device?
//!
//! One pass per order for what is linear or a product, one for the exponentials: compilers take long over them.
// Copies between slices do not compile to SPIR-V.
#![allow(clippy::manual_memcpy)]

use super::evaluate::EvaluateParams;
use crate::math::{orthonormal_frame, to_u32};
use crate::sh;
use glam::{Mat3, Vec3, Vec4};

gpu_struct! {
    /// A vector of up to 25 coefficients (order 5); the others are 0.
    pub struct ShVector {
        /// Coefficients 0 to 3.
        pub c0: Vec4,
        /// Coefficients 4 to 7.
        pub c4: Vec4,
        /// Coefficients 8 to 11.
        pub c8: Vec4,
        /// Coefficients 12 to 15.
        pub c12: Vec4,
        /// Coefficients 16 to 19.
        pub c16: Vec4,
        /// Coefficients 20 to 23.
        pub c20: Vec4,
        /// Coefficient 24.
        pub c24: Vec4,
    }
}

/// Selects the function that [`evaluate_sh4`] and its siblings evaluate.
///
/// The argument is a unit direction and, in w, a number.
pub mod function {
    #![allow(missing_docs)]
    /// Basis functions in the direction.
    pub const BASIS: u32 = 0;
    /// Value of a in the direction.
    pub const VALUE: u32 = 1;
    /// a turned so that z becomes the direction.
    pub const ROTATE: u32 = 2;
    pub const PRODUCT: u32 = 3;
    pub const SQUARE: u32 = 4;
    /// Zonal coefficients of the cap of sine w, and its solid angle.
    pub const CAP: u32 = 5;
    /// Visibility beside the cap of sine w around the direction.
    pub const ZONAL: u32 = 6;
    /// Irradiance of the light a.
    pub const IRRADIANCE: u32 = 7;
    /// The nearest feasible visibility.
    pub const CLAMP: u32 = 8;
    /// Number of functions.
    pub const COUNT: u32 = 9;
}

/// Selects the function that [`evaluate_sh4_exponential`] and its siblings evaluate.
///
/// w of the argument is τ.
pub mod exponential {
    #![allow(missing_docs)]
    pub const HYBRID: u32 = 0;
    /// Hybrid with a and b from the table.
    pub const HYBRID_WITH_TABLE: u32 = 1;
    pub const OPTIMAL_LINEAR: u32 = 2;
    pub const TAYLOR: u32 = 3;
    /// Product series of x terms.
    pub const SERIES: u32 = 4;
    /// What the hybrid covers, and the norm without DC.
    pub const OCCLUDED: u32 = 5;
    /// Logarithm of a blocker's visibility from the table, key, weight by distance.
    pub const LOGARITHM: u32 = 6;
    /// Number of functions.
    pub const COUNT: u32 = 7;
}

/// The first N coefficients.
#[inline]
pub(super) fn load<const N: usize>(v: &ShVector) -> [f32; N] {
    let all = [
        v.c0.x, v.c0.y, v.c0.z, v.c0.w, v.c4.x, v.c4.y, v.c4.z, v.c4.w, v.c8.x, v.c8.y, v.c8.z, v.c8.w,
        v.c12.x, v.c12.y, v.c12.z, v.c12.w, v.c16.x, v.c16.y, v.c16.z, v.c16.w, v.c20.x, v.c20.y, v.c20.z,
        v.c20.w, v.c24.x,
    ];
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = all[i];
    }
    out
}

/// A vector of these coefficients, the others 0.
#[inline]
pub(super) fn store<const N: usize>(v: &[f32; N]) -> ShVector {
    let mut a = [0.0; 28];
    for i in 0..N {
        a[i] = v[i];
    }
    ShVector {
        c0: Vec4::new(a[0], a[1], a[2], a[3]),
        c4: Vec4::new(a[4], a[5], a[6], a[7]),
        c8: Vec4::new(a[8], a[9], a[10], a[11]),
        c12: Vec4::new(a[12], a[13], a[14], a[15]),
        c16: Vec4::new(a[16], a[17], a[18], a[19]),
        c20: Vec4::new(a[20], a[21], a[22], a[23]),
        c24: Vec4::new(a[24], a[25], a[26], a[27]),
    }
}

#[inline]
fn linear<const N: usize, const B: usize>(
    index: u32,
    params: &EvaluateParams,
    a: &[ShVector],
    b: &[ShVector],
    arguments: &[Vec4],
) -> ShVector {
    let f = load::<N>(&a[index as usize]);
    let g = load::<N>(&b[index as usize]);
    let argument = arguments[index as usize];
    let direction = argument.truncate();
    let result = match params.function {
        function::BASIS => sh::basis::<N>(direction),
        function::VALUE => only(sh::evaluate(&f, direction)),
        function::ROTATE => sh::rotate(&frame(direction), &f),
        function::PRODUCT => sh::product(&f, &g),
        function::SQUARE => sh::square(&f),
        function::CAP => {
            let cap = sh::cap::<B>(argument.w);
            let mut out = [0.0; N];
            for l in 0..B {
                out[l] = cap[l];
            }
            out[N - 1] = sh::cap_solid_angle(argument.w);
            out
        }
        function::ZONAL => sh::rotate_zonal::<B, N>(&sh::visibility(argument.w), direction),
        function::IRRADIANCE => sh::irradiance::<B, N>(&f),
        function::CLAMP => sh::clamp_to_feasible(&f),
        _ => [0.0; N],
    };
    store(&result)
}

#[inline]
fn exponentials<const N: usize, const B: usize>(
    index: u32,
    params: &EvaluateParams,
    a: &[ShVector],
    arguments: &[Vec4],
    table: &[f32],
) -> ShVector {
    let f = load::<N>(&a[index as usize]);
    let argument = arguments[index as usize];
    let tau = argument.w;
    let result = match params.function {
        exponential::HYBRID => sh::hybrid(&f, tau),
        exponential::HYBRID_WITH_TABLE => sh::hybrid_with_table(&f, tau, table, params.count),
        exponential::OPTIMAL_LINEAR => sh::optimal_linear(&f, table, params.count),
        exponential::TAYLOR => sh::taylor(&f, tau),
        exponential::SERIES => sh::product_series(&f, to_u32(argument.x)),
        exponential::OCCLUDED => {
            let mut out = only(sh::occluded_dc(&f, &sh::hybrid(&f, tau), tau));
            out[1] = sh::norm_without_dc(&f);
            out
        }
        exponential::LOGARITHM => {
            let key = sh::occlusion_key(argument.x);
            let log = sh::log_occlusion::<B>(table, params.count, key);
            let mut out = [0.0; N];
            for l in 0..B {
                out[l] = log[l];
            }
            out[N - 2] = key;
            out[N - 1] = sh::influence_weight(key, sh::influence_key(argument.y), argument.z);
            out
        }
        _ => [0.0; N],
    };
    store(&result)
}

#[inline]
fn only<const N: usize>(value: f32) -> [f32; N] {
    let mut out = [0.0; N];
    out[0] = value;
    out
}

#[inline]
fn frame(direction: Vec3) -> Mat3 {
    let (t, b) = orthonormal_frame(direction);
    Mat3::from_cols(t, b, direction)
}

macro_rules! orders {
    ($($order:literal: $linear:ident, $exponential:ident, $n:literal, $b:literal;)*) => {$(
        #[doc = concat!("Returns the selected [`function`] of order ", $order, "; 0 for an unknown selection.")]
        #[inline]
        pub fn $linear(
            index: u32,
            params: &EvaluateParams,
            a: &[ShVector],
            b: &[ShVector],
            arguments: &[Vec4],
        ) -> ShVector {
            linear::<$n, $b>(index, params, a, b, arguments)
        }

        #[doc = concat!("Returns the selected [`exponential`] of order ", $order, "; 0 for an unknown selection.")]
        #[inline]
        pub fn $exponential(
            index: u32,
            params: &EvaluateParams,
            a: &[ShVector],
            arguments: &[Vec4],
            table: &[f32],
        ) -> ShVector {
            exponentials::<$n, $b>(index, params, a, arguments, table)
        }
    )*};
}

orders! {
    3: evaluate_sh3, evaluate_sh3_exponential, 9, 3;
    4: evaluate_sh4, evaluate_sh4_exponential, 16, 4;
}

/// Returns the selected [`function`] of order 5; 0 for an unknown selection.
///
/// Its exponentials have no pass: compilers take minutes over the 1158 terms of each of their products.
#[inline]
pub fn evaluate_sh5(
    index: u32,
    params: &EvaluateParams,
    a: &[ShVector],
    b: &[ShVector],
    arguments: &[Vec4],
) -> ShVector {
    linear::<25, 5>(index, params, a, b, arguments)
}
