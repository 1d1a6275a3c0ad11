//! What do comparison, rounding and conversion mean when NaN or a huge value comes in?

/// The smallest normal f32, 2⁻¹²⁶; results below it count as 0 because devices may flush them.
pub const MIN_POSITIVE: f32 = f32::MIN_POSITIVE;

/// Returns true for any NaN, decided on the bits: drivers may fold float comparisons as if NaN did not exist.
#[inline]
pub fn is_nan(x: f32) -> bool {
    (x.to_bits() & 0x7FFF_FFFF) > 0x7F80_0000
}

/// Returns true for anything but NaN and ±∞, decided on the bits.
#[inline]
pub fn is_finite(x: f32) -> bool {
    (x.to_bits() & 0x7F80_0000) != 0x7F80_0000
}

/// Returns the smaller; `b` when either is NaN.
#[inline]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// Returns the larger; `b` when either is NaN.
#[inline]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Returns the smaller of two integers.
#[inline]
pub fn min_u32(a: u32, b: u32) -> u32 {
    if a < b { a } else { b }
}

/// Returns x moved into [low, high]; `low` for NaN.
#[inline]
pub fn clamp(x: f32, low: f32, high: f32) -> f32 {
    if is_nan(x) {
        return low;
    }
    min(max(x, low), high)
}

/// Returns x moved into [0, 1]; 0 for NaN.
#[inline]
pub fn saturate(x: f32) -> f32 {
    clamp(x, 0.0, 1.0)
}

/// Returns |x|, on the bits.
#[inline]
pub fn abs(x: f32) -> f32 {
    f32::from_bits(x.to_bits() & 0x7FFF_FFFF)
}

/// Returns |magnitude| with the sign bit of `sign`.
#[inline]
pub fn copy_sign(magnitude: f32, sign: f32) -> f32 {
    f32::from_bits((magnitude.to_bits() & 0x7FFF_FFFF) | (sign.to_bits() & 0x8000_0000))
}

/// Returns the largest integer not above x; x itself from 2²³ on and for NaN.
#[inline]
pub fn floor(x: f32) -> f32 {
    #[cfg(target_arch = "spirv")]
    {
        spirv_std::num_traits::Float::floor(x)
    }
    #[cfg(not(target_arch = "spirv"))]
    {
        if !(abs(x) < 8_388_608.0) {
            return x;
        }
        let truncated = x as i32 as f32;
        if truncated > x { truncated - 1.0 } else { truncated }
    }
}

/// Returns x truncated toward 0 as an integer, saturating at ±2 147 483 520; 0 for NaN.
#[inline]
pub fn to_i32(x: f32) -> i32 {
    if is_nan(x) {
        return 0;
    }
    min(max(x, -2_147_483_520.0), 2_147_483_520.0) as i32
}

/// Returns x truncated toward 0 as an integer, saturating at 0 and 4 294 967 040; 0 for NaN.
#[inline]
pub fn to_u32(x: f32) -> u32 {
    if is_nan(x) {
        return 0;
    }
    min(max(x, 0.0), 4_294_967_040.0) as u32
}

/// Returns 2^n for n in [−126, 127] from the exponent bits; other n are clamped.
#[inline]
pub fn exp2_integer(n: i32) -> f32 {
    let n = if n < -126 { -126 } else { n };
    let n = if n > 127 { 127 } else { n };
    f32::from_bits(((n + 127) as u32) << 23)
}
