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

/// Returns the radical inverse in base 3, in [0, 1), within 1e-7; the index counts modulo 3²⁰.
#[inline]
pub fn radical_inverse_3(index: u32) -> f32 {
    radical_inverse::<3, 20>(index, 1.0 / 3_486_784_401.0)
}

/// Returns the radical inverse in base 5, in [0, 1), within 1e-7; the index counts modulo 5¹³.
#[inline]
pub fn radical_inverse_5(index: u32) -> f32 {
    radical_inverse::<5, 13>(index, 1.0 / 1_220_703_125.0)
}

/// Returns the radical inverse in base 7, in [0, 1), within 1e-7; the index counts modulo 7¹¹.
#[inline]
pub fn radical_inverse_7(index: u32) -> f32 {
    radical_inverse::<7, 11>(index, 1.0 / 1_977_326_743.0)
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

/// Reversed digits as one integer and one multiplication: a running product of 1/BASE reaches 1.
#[inline]
fn radical_inverse<const BASE: u32, const DIGITS: u32>(index: u32, scale: f32) -> f32 {
    let mut rest = index;
    let mut numerator = 0u32;
    for _ in 0..DIGITS {
        let quotient = rest / BASE;
        numerator = numerator * BASE + (rest - quotient * BASE);
        rest = quotient;
    }
    let x = numerator as f32 * scale;
    if x < BELOW_ONE { x } else { BELOW_ONE }
}
