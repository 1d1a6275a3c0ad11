//! Which elementary functions give the same bits on every machine?
//!
//! `math::exp(x)` and its siblings are what kernels call. On the CPU, and in the strict SPIR-V modules,
//! they are the functions of [`strict`]: built from correctly rounded add, subtract and multiply, integer
//! operations and [`div`]/[`sqrt`]. In the fast SPIR-V modules they are the driver's (see [`fast`]).
//!
//! Errors are stated per function in units in the last place (ULP) against a float64 oracle.

pub mod fast;
pub mod strict;
mod vector;

pub use strict::{
    MIN_POSITIVE, abs, clamp, copy_sign, exp2_integer, floor, is_finite, is_nan, max, min, min_u32, powi,
    saturate, to_i32, to_u32,
};
pub use vector::*;

/// π rounded to f32.
pub const PI: f32 = core::f32::consts::PI;
/// 1/π rounded to f32.
pub const FRAC_1_PI: f32 = core::f32::consts::FRAC_1_PI;

macro_rules! select_mode {
    ($($(#[$doc:meta])* $name:ident($($x:ident),+) -> $out:ty;)*) => {$(
        $(#[$doc])*
        #[inline]
        pub fn $name($($x: f32),+) -> $out {
            #[cfg(all(target_arch = "spirv", feature = "gpu-fast"))]
            { fast::$name($($x),+) }
            #[cfg(not(all(target_arch = "spirv", feature = "gpu-fast")))]
            { strict::$name($($x),+) }
        }
    )*};
}

select_mode! {
    /// Returns 2^x: 1.23 ULP; below −126 exactly 0, from 128 on +∞, NaN for NaN.
    exp2(x) -> f32;
    /// Returns e^x: 0.95 ULP; flushes to 0 below −87.33, +∞ above 88.72, NaN for NaN.
    exp(x) -> f32;
    /// Returns e^x − 1 without cancellation near 0: 1.42 ULP; −1 below −17.5.
    exp_minus_one(x) -> f32;
    /// Returns log₂ x: 1.50 ULP, relative accuracy kept near 1; x ≤ 2⁻¹²⁶ saturates at −126.
    log2(x) -> f32;
    /// Returns the natural logarithm: 0.85 ULP; x ≤ 2⁻¹²⁶ saturates at ln 2⁻¹²⁶.
    ln(x) -> f32;
    /// Returns ln(1 + x) without cancellation near 0: 0.79 ULP; x ≤ −1 saturates.
    ln_one_plus(x) -> f32;
    /// Returns (sin 2πt, cos 2πt): 1.96 ULP, exact at multiples of 1/4.
    sin_cos_turn(t) -> (f32, f32);
    /// Returns (sin x, cos x): absolute 9.3e-8 for |x| ≤ 8192, meaningless beyond 1e5.
    sin_cos(x) -> (f32, f32);
    /// Returns the arc cosine in [0, π]: 1.15 ULP; |x| > 1 counts as ±1.
    acos(x) -> f32;
    /// Returns the angle of (x, y) in [−π, π]: 1.54 ULP; 0 for the origin, x = −0 counts as +0.
    atan2(y, x) -> f32;
    /// Returns the error function: 1.30 ULP, odd, ±1 from |x| = 3.92 on.
    erf(x) -> f32;
    /// Returns x^y as exp2(y·log2 x): relative error up to |y log₂ x|·1.1e-7 + 1.6e-7; x below 2⁻¹²⁶ saturates.
    pow_fast(x, y) -> f32;
    /// Returns x^y for x > 0: 1.7 ULP; x < 2⁻¹²⁶ gives 0 for y > 0, 1 for y = 0, +∞ for y < 0.
    pow(x, y) -> f32;
    /// Returns 1/√x: 1.49 ULP; 0 for +∞, a huge finite value for x < 2⁻¹²⁶.
    rsqrt(x) -> f32;
}

/// Returns a/b, correctly rounded (0.5 ULP) in strict modules; results below 2⁻¹²⁶ may flush to 0.
#[inline]
pub fn div(a: f32, b: f32) -> f32 {
    #[cfg(any(not(target_arch = "spirv"), feature = "gpu-native-division"))]
    {
        a / b
    }
    #[cfg(not(any(not(target_arch = "spirv"), feature = "gpu-native-division")))]
    {
        strict::div_software(a, b)
    }
}

/// Returns 1/x, rounded as [`div`].
#[inline]
pub fn recip(x: f32) -> f32 {
    div(1.0, x)
}

/// Returns √x, correctly rounded (0.5 ULP) in strict modules; NaN for x < 0, 0 for x < 2⁻¹²⁶ on GPUs.
#[inline]
pub fn sqrt(x: f32) -> f32 {
    strict::sqrt(x)
}
