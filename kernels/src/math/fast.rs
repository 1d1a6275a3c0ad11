//! What does the driver's own elementary function give?
//!
//! On SPIR-V these are the GLSL.std.450 instructions, with the errors that Vulkan allows (log2 2⁻²¹ absolute
//! near 1, acos and atan2 4096 ULP, sin and cos 2⁻¹¹ absolute). On a CPU they are the strict functions, which
//! are already faster than a call into a mathematics library. Functions without an instruction are strict too.

use super::strict;

pub use strict::{erf, exp_minus_one, ln_one_plus};

#[cfg(target_arch = "spirv")]
mod native {
    use spirv_std::num_traits::Float;

    macro_rules! unary {
        ($($(#[$doc:meta])* $name:ident = $method:ident;)*) => {$(
            $(#[$doc])*
            #[inline]
            pub fn $name(x: f32) -> f32 { Float::$method(x) }
        )*};
    }
    unary! {
        /// Returns 2^x by the driver.
        exp2 = exp2;
        /// Returns e^x by the driver.
        exp = exp;
        /// Returns log₂ x by the driver.
        log2_raw = log2;
        /// Returns ln x by the driver.
        ln_raw = ln;
    }

    /// Returns log₂ x by the driver, saturating like the strict one.
    #[inline]
    pub fn log2(x: f32) -> f32 {
        log2_raw(super::strict::max(x, f32::MIN_POSITIVE))
    }

    /// Returns ln x by the driver, saturating like the strict one.
    #[inline]
    pub fn ln(x: f32) -> f32 {
        ln_raw(super::strict::max(x, f32::MIN_POSITIVE))
    }

    /// Returns (sin x, cos x) by the driver.
    #[inline]
    pub fn sin_cos(x: f32) -> (f32, f32) {
        (Float::sin(x), Float::cos(x))
    }

    /// Returns (sin 2πt, cos 2πt) by the driver, reduced to one turn first.
    #[inline]
    pub fn sin_cos_turn(t: f32) -> (f32, f32) {
        let t = super::strict::clamp(t, -4_194_304.0, 4_194_304.0);
        sin_cos((t - super::strict::floor(t + 0.5)) * 6.283_185_5)
    }

    /// Returns the arc cosine by the driver; |x| > 1 counts as ±1.
    #[inline]
    pub fn acos(x: f32) -> f32 {
        Float::acos(super::strict::clamp(x, -1.0, 1.0))
    }

    /// Returns the angle of (x, y) by the driver; 0 for the origin.
    #[inline]
    pub fn atan2(y: f32, x: f32) -> f32 {
        if x == 0.0 && y == 0.0 { 0.0 } else { Float::atan2(y, x) }
    }

    /// Returns x^y by the driver, x saturating at 2⁻¹²⁶.
    #[inline]
    pub fn pow_fast(x: f32, y: f32) -> f32 {
        Float::powf(super::strict::max(x, f32::MIN_POSITIVE), y)
    }

    /// Returns x^y by the driver, 0 for x < 2⁻¹²⁶ and y > 0.
    #[inline]
    pub fn pow(x: f32, y: f32) -> f32 {
        if x < f32::MIN_POSITIVE && y > 0.0 { 0.0 } else { pow_fast(x, y) }
    }

    /// Returns 1/√x by the driver, x saturating at 2⁻¹²⁶.
    #[inline]
    pub fn rsqrt(x: f32) -> f32 {
        1.0 / Float::sqrt(super::strict::max(x, f32::MIN_POSITIVE))
    }
}

#[cfg(target_arch = "spirv")]
pub use native::{acos, atan2, exp, exp2, ln, log2, pow, pow_fast, rsqrt, sin_cos, sin_cos_turn};
#[cfg(not(target_arch = "spirv"))]
pub use strict::{acos, atan2, exp, exp2, ln, log2, pow, pow_fast, rsqrt, sin_cos, sin_cos_turn};
