//! Which low-discrepancy point comes next?

use glam::Vec2;

/// The largest f32 below 1.
const BELOW_ONE: f32 = 0.999_999_94;

/// Returns the radical inverse in base 2, truncated to 24 bits: exact for index < 2²⁴, always below 1.
#[inline]
pub fn radical_inverse_2(index: u32) -> f32 {
    // 2⁻²⁴
    (index.reverse_bits() >> 8) as f32 * 5.960_464_5e-8
}

/// Returns the radical inverse in base 3, in [0, 1), within 6e-8; the index counts modulo 3²⁰.
#[inline]
pub fn radical_inverse_3(index: u32) -> f32 {
    radical_inverse::<3, 20>(index, f32::from_bits(0x339DAB1E), f32::from_bits(0x2611E2DD))
}

/// Returns the radical inverse in base 5, in [0, 1), within 6e-8; the index counts modulo 5¹³.
#[inline]
pub fn radical_inverse_5(index: u32) -> f32 {
    radical_inverse::<5, 13>(index, f32::from_bits(0x34612E13), f32::from_bits(0x27849768))
}

/// Returns the radical inverse in base 7, in [0, 1), within 6e-8; the index counts modulo 7¹¹.
#[inline]
pub fn radical_inverse_7(index: u32) -> f32 {
    radical_inverse::<7, 11>(index, f32::from_bits(0x340B03D1), f32::from_bits(0x27CBACF9))
}

/// Returns point `index` of the two-dimensional Halton sequence (bases 2 and 3) in [0, 1)².
#[inline]
pub fn halton(index: u32) -> Vec2 {
    Vec2::new(radical_inverse_2(index), radical_inverse_3(index))
}

/// Returns x + shift modulo 1, in [0, 1), for x in [0, 1) and shift in [0, 1]: one sequence per pixel.
#[inline]
pub fn rotated(x: f32, shift: f32) -> f32 {
    let sum = x + shift;
    let sum = if sum >= 1.0 { sum - 1.0 } else { sum };
    if sum < BELOW_ONE { sum } else { BELOW_ONE }
}

/// Reversed digits as one integer, scaled once: a running product of 1/BASE reaches 1.
///
/// `scale` + `scale_low` is 256/BASE^DIGITS. The integer's upper 24 bits convert exactly, however rounded;
/// without the low parts the error would be 1.3e-7.
#[inline]
fn radical_inverse<const BASE: u32, const DIGITS: u32>(index: u32, scale: f32, scale_low: f32) -> f32 {
    let mut rest = index;
    let mut numerator = 0u32;
    for _ in 0..DIGITS {
        let quotient = rest / BASE;
        numerator = numerator * BASE + (rest - quotient * BASE);
        rest = quotient;
    }
    let high = (numerator >> 8) as f32;
    // 1/256
    let low = (numerator & 255) as f32 * 0.003_906_25;
    let x = high * scale + (high * scale_low + low * scale);
    if x < BELOW_ONE { x } else { BELOW_ONE }
}
