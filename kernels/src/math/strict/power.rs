//! What is x^y: for small whole y, roughly and fast, or to 1.7 ULP?

use super::{abs, clamp, exp2_integer, f, floor, is_nan, log2, to_i32, two_product, two_sum};

/// Returns x^n for whole n ≥ 0 by square and multiply: relative error about (n − 1)·2⁻²⁴; x⁰ = 1.
#[inline]
pub fn powi(x: f32, n: u32) -> f32 {
    let mut result = 1.0;
    let mut square = x;
    let mut left = n;
    while left != 0 {
        if left & 1 != 0 {
            result *= square;
        }
        left >>= 1;
        if left != 0 {
            square *= square;
        }
    }
    result
}

/// Returns x^y as exp2(y·log₂ x): relative error up to |y log₂ x|·1.1e-7 + 1.6e-7, 45 flops.
///
/// x below 2⁻¹²⁶ (and negative x) counts as 2⁻¹²⁶; NaN for NaN.
#[inline]
pub fn pow_fast(x: f32, y: f32) -> f32 {
    super::exp2(y * log2(x))
}

/// 1/c as a multiple of 1/256, and −log₂ of it as a multiple of 2⁻¹² plus the rest, per 1/16 octave.
const OCTAVE: [(f32, f32, f32); 16] = [
    (1.0, 0.0, 0.0),
    (234.0 / 256.0, 0.129638671875, f(0xB663_98D0)),
    (221.0 / 256.0, 0.212158203125, f(0xB87E_DB41)),
    (210.0 / 256.0, 0.28564453125, f(0x38E6_958A)),
    (200.0 / 256.0, 0.356201171875, f(0xB870_979A)),
    (191.0 / 256.0, 0.422607421875, f(0xB818_0B0C)),
    (182.0 / 256.0, 0.4921875, f(0x3795_D1A2)),
    (174.0 / 256.0, 0.55712890625, f(0xB897_D695)),
    (167.0 / 256.0, 0.6162109375, f(0x38B1_C690)),
    (161.0 / 256.0, 0.669189453125, f(0xB8DE_FE26)),
    (155.0 / 256.0, 0.723876953125, f(0xB5B6_523E)),
    (149.0 / 256.0, 0.78076171875, f(0x3892_4C8A)),
    (144.0 / 256.0, 0.830078125, f(0xB651_CFDF)),
    (139.0 / 256.0, 0.881103515625, f(0xB83B_0460)),
    (134.0 / 256.0, 0.933837890625, f(0x3898_EC0C)),
    (130.0 / 256.0, 0.9775390625, f(0x38C3_4BD2)),
];

const LOG2_E_HIGH: f32 = 1.442_871_093_75;
const LOG2_E_LOW: f32 = -1.760_528_539e-4;
const HIGH_BITS: u32 = 0xFFFF_F000;

/// log₂ x as an unevaluated sum (high, low), relative error about 2⁻³⁹, for normal x > 0.
#[inline]
fn log2_double(x: f32) -> (f32, f32) {
    let bits = x.to_bits();
    let e = (bits >> 23) as i32 - 127;
    let m = f((bits & 0x007F_FFFF) | 0x3F80_0000);
    let (inverse, table_high, table_low) = OCTAVE[((bits >> 19) & 15) as usize];
    let mh = f(m.to_bits() & HIGH_BITS);
    let ml = m - mh;
    let r1 = mh * inverse - 1.0;
    let r2 = ml * inverse;
    let rh = r1 + r2;
    let rl = (r1 - rh) + r2;
    let head = f(rh.to_bits() & HIGH_BITS);
    let p = head * LOG2_E_HIGH;
    let q = (rh - head) * LOG2_E_HIGH + rh * LOG2_E_LOW + rl * LOG2_E_HIGH;
    let c = 0.288_539_01 - 0.240_449_17 * rh;
    let c = -0.360_673_76 + rh * c;
    let c = 0.480_898_35 + rh * c;
    let c = -0.721_347_52 + rh * c;
    let c = (rh * rh) * c;
    let (h, l) = two_sum(e as f32 + table_high, p);
    let l = l + (table_low + (q + c));
    let high = h + l;
    (high, (h - high) + l)
}

/// Returns x^y for x > 0: 1.7 ULP (measured for y to ±128, x from 2⁻⁶ to 4; 1.5 on the golden inputs).
///
/// x < 2⁻¹²⁶ counts as 0: 0 for y > 0, 1 for y = 0, +∞ for y < 0. NaN for NaN; x = +∞ as the limit.
#[inline]
pub fn pow(x: f32, y: f32) -> f32 {
    if is_nan(x) || is_nan(y) {
        return f(0x7FC0_0000);
    }
    if y == 0.0 {
        return 1.0;
    }
    if x < f32::MIN_POSITIVE {
        return if y > 0.0 { 0.0 } else { f(0x7F80_0000) };
    }
    if x == f(0x7F80_0000) {
        return if y > 0.0 { x } else { 0.0 };
    }
    let (h, l) = log2_double(x);
    // Beyond these the result is 0 or +∞; clamping first keeps the exact product from overflowing.
    let y = clamp(y, -1.0e30, 1.0e30);
    if abs(y * h) > 200.0 {
        return if y * h > 0.0 { f(0x7F80_0000) } else { 0.0 };
    }
    let (p, e) = two_product(y, h);
    exp2_pair(p, e + y * l)
}

/// 2^(high + low) for |low| much smaller than 1.
#[inline]
fn exp2_pair(high: f32, low: f32) -> f32 {
    if high < -126.0 {
        return 0.0;
    }
    if high >= 128.0 {
        return f(0x7F80_0000);
    }
    let n = floor(high + 0.5);
    let r = (high - n) + low;
    let q = f(0x3AAF_9F29) + r * f(0x3920_FDBD);
    let q = f(0x3C1D_96A7) + r * q;
    let q = f(0x3D63_5774) + r * q;
    let q = f(0x3E75_FDEE) + r * q;
    let q = f(0x3F31_7218) + r * q;
    let n = to_i32(n);
    let half = n >> 1;
    ((1.0 + r * q) * exp2_integer(half)) * exp2_integer(n - half)
}
