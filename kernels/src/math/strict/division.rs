//! How are division and exact products made from add and multiply alone?

use super::{abs, exp2_integer, is_nan};

const LOW_BITS: u32 = 0xFFFF_F000;

/// The line closest to 1/m over [1, 2): error at most 1/17. Constants, so that no division is left to run time.
const GUESS: f32 = 24.0 / 17.0;
const GUESS_SLOPE: f32 = 8.0 / 17.0;

/// Returns (p, e) with p = fl(a·b) and p + e = a·b exactly, without a fused multiply-add.
///
/// Splits each factor at 12 bits (Dekker); exact while nothing under- or overflows.
#[inline]
pub fn two_product(a: f32, b: f32) -> (f32, f32) {
    let ah = f32::from_bits(a.to_bits() & LOW_BITS);
    let al = a - ah;
    let bh = f32::from_bits(b.to_bits() & LOW_BITS);
    let bl = b - bh;
    let p = a * b;
    let e = (((ah * bh - p) + ah * bl) + al * bh) + al * bl;
    (p, e)
}

/// Returns (s, e) with s = fl(a + b) and s + e = a + b exactly (Knuth).
#[inline]
pub fn two_sum(a: f32, b: f32) -> (f32, f32) {
    let s = a + b;
    let bb = s - a;
    (s, (a - (s - bb)) + (b - bb))
}

/// Returns a/b correctly rounded, as the CPU's `/`; results and operands below 2⁻¹²⁶ count as 0.
///
/// Newton's reciprocal of the mantissa, two exact residual corrections, and a last one-ULP decision.
#[inline]
pub fn div_software(a: f32, b: f32) -> f32 {
    let sign = (a.to_bits() ^ b.to_bits()) & 0x8000_0000;
    let ua = a.to_bits() & 0x7FFF_FFFF;
    let ub = b.to_bits() & 0x7FFF_FFFF;
    let inf = f32::from_bits(sign | 0x7F80_0000);
    let zero = f32::from_bits(sign);
    let nan = f32::from_bits(0x7FC0_0000);
    if is_nan(a) || is_nan(b) {
        return nan;
    }
    let a_zero = ua < 0x0080_0000;
    let b_zero = ub < 0x0080_0000;
    let a_inf = ua == 0x7F80_0000;
    let b_inf = ub == 0x7F80_0000;
    if (a_zero && b_zero) || (a_inf && b_inf) {
        return nan;
    }
    if a_zero || b_inf {
        return zero;
    }
    if a_inf || b_zero {
        return inf;
    }
    let exponent = (ua >> 23) as i32 - (ub >> 23) as i32;
    let ma = f32::from_bits((ua & 0x007F_FFFF) | 0x3F80_0000);
    let mb = f32::from_bits((ub & 0x007F_FFFF) | 0x3F80_0000);
    let q = mantissa_quotient(ma, mb);
    // Two factors: one power of two alone could overflow or underflow although the result does not.
    let half = exponent >> 1;
    let scaled = (q * exp2_integer(half)) * exp2_integer(exponent - half);
    if scaled < f32::MIN_POSITIVE {
        return zero;
    }
    f32::from_bits(scaled.to_bits() | sign)
}

/// ma/mb for mantissas in [1, 2), correctly rounded; the quotient is in (1/2, 2).
#[inline]
fn mantissa_quotient(ma: f32, mb: f32) -> f32 {
    let mut y = GUESS - GUESS_SLOPE * mb;
    y *= 2.0 - mb * y;
    y *= 2.0 - mb * y;
    y *= 2.0 - mb * y;
    let mut q = ma * y;
    q += residual(ma, mb, q) * y;
    q += residual(ma, mb, q) * y;
    let r = residual(ma, mb, q);
    let ulp = f32::from_bits((q.to_bits() & 0x7F80_0000) - (23 << 23));
    if 2.0 * abs(r) > ulp * mb {
        q = if r > 0.0 { f32::from_bits(q.to_bits() + 1) } else { f32::from_bits(q.to_bits() - 1) };
    }
    q
}

/// ma − q·mb, exact to rounding of the last step.
#[inline]
fn residual(ma: f32, mb: f32, q: f32) -> f32 {
    let (p, e) = two_product(q, mb);
    (ma - p) - e
}
