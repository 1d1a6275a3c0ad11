//! How is the square root rounded correctly without a square-root instruction?

use super::{exp2_integer, is_nan, two_product};

/// Returns √x, correctly rounded; NaN for x < 0.
///
/// The CPU's instruction with the feature `std`, else [`sqrt_software`]: the same bits for normal x.
#[inline]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(all(not(target_arch = "spirv"), feature = "std"))]
    {
        x.sqrt()
    }
    #[cfg(all(target_arch = "spirv", feature = "gpu-native-division"))]
    {
        spirv_std::num_traits::Float::sqrt(x)
    }
    #[cfg(not(any(
        all(not(target_arch = "spirv"), feature = "std"),
        all(target_arch = "spirv", feature = "gpu-native-division")
    )))]
    {
        sqrt_software(x)
    }
}

/// Returns √x, correctly rounded for normal x; 0 below 2⁻¹²⁶, NaN for x < 0.
///
/// Newton's reciprocal root of the mantissa in [1, 4), then two corrections by the exact residual.
#[inline]
pub fn sqrt_software(x: f32) -> f32 {
    let bits = x.to_bits();
    if (bits & 0x7FFF_FFFF) < 0x0080_0000 {
        return f32::from_bits(bits & 0x8000_0000);
    }
    if is_nan(x) || (bits & 0x8000_0000) != 0 {
        return f32::from_bits(0x7FC0_0000);
    }
    if bits == 0x7F80_0000 {
        return x;
    }
    let exponent = (bits >> 23) as i32 - 127;
    let half = exponent >> 1;
    let m = f32::from_bits((bits & 0x007F_FFFF) | (((exponent - 2 * half + 127) as u32) << 23));
    let mut y = f32::from_bits(0x5F37_59DF - (m.to_bits() >> 1));
    let h = 0.5 * m;
    y *= 1.5 - h * (y * y);
    y *= 1.5 - h * (y * y);
    y *= 1.5 - h * (y * y);
    let mut s = m * y;
    s += (0.5 * y) * residual(m, s);
    s += (0.5 * y) * residual(m, s);
    s * exp2_integer(half)
}

/// m − s², exact to rounding of the last step.
#[inline]
fn residual(m: f32, s: f32) -> f32 {
    let (p, e) = two_product(s, s);
    (m - p) - e
}

/// Returns 1/√x: 1.49 ULP; x < 2⁻¹²⁶ and NaN count as 2⁻¹²⁶ so that the result stays finite.
#[inline]
pub fn rsqrt(x: f32) -> f32 {
    let x = if x >= f32::MIN_POSITIVE { x } else { f32::MIN_POSITIVE };
    let s = sqrt(x);
    crate::math::recip(s)
}
