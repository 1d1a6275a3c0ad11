//! What are log₂ x, ln x and ln(1 + x)?

use super::{abs, f, is_nan, max};

const LN2_HIGH: f32 = 0.693_359_375;
const LN2_LOW: f32 = -2.121_944_4e-4;

/// (e, t) with x = 2^e (1 + t), t in [−0.293, 0.4142], for x ≥ 2⁻¹²⁶.
#[inline]
fn decompose(x: f32) -> (i32, f32) {
    let shifted = x.to_bits().wrapping_sub(0x3F35_04F3) as i32;
    let m = f32::from_bits(((shifted as u32) & 0x007F_FFFF) + 0x3F35_04F3);
    (shifted >> 23, m - 1.0)
}

/// t³ Q(t), the part of ln(1 + t) beyond t − t²/2.
#[inline]
fn tail(t: f32, t2: f32) -> f32 {
    let q = f(0x3D8A_2BED);
    let q = f(0xBDEF_1E17) + t * q;
    let q = f(0x3DF3_7831) + t * q;
    let q = f(0xBDFE_1101) + t * q;
    let q = f(0x3E11_9BB4) + t * q;
    let q = f(0xBE2A_AE27) + t * q;
    let q = f(0x3E4C_D25B) + t * q;
    let q = f(0xBE80_0003) + t * q;
    let q = f(0x3EAA_AAA4) + t * q;
    (t2 * t) * q
}

/// Returns log₂ x: 1.50 ULP; powers of two are exact; x ≤ 2⁻¹²⁶ gives −126, +∞ gives 128, NaN for NaN.
#[inline]
pub fn log2(x: f32) -> f32 {
    if is_nan(x) {
        return x;
    }
    let (e, t) = decompose(max(x, f32::MIN_POSITIVE));
    let t2 = t * t;
    let y = tail(t, t2) - 0.5 * t2;
    let mut z = y * 0.442_695_051;
    z += t * 0.442_695_051;
    z += y;
    z += t;
    z + e as f32
}

/// Returns ln x: 0.85 ULP; x ≤ 2⁻¹²⁶ gives ln 2⁻¹²⁶ = −87.34, +∞ gives 88.72, NaN for NaN.
#[inline]
pub fn ln(x: f32) -> f32 {
    if is_nan(x) {
        return x;
    }
    let (e, t) = decompose(max(x, f32::MIN_POSITIVE));
    assemble(e as f32, t, 0.0)
}

#[inline]
fn assemble(e: f32, t: f32, correction: f32) -> f32 {
    let t2 = t * t;
    let mut y = tail(t, t2);
    y += e * LN2_LOW + correction;
    y -= 0.5 * t2;
    (t + y) + e * LN2_HIGH
}

/// Returns ln(1 + x): 0.79 ULP, relative accuracy kept at 0; x ≤ −1 gives ln 2⁻¹²⁶, NaN for NaN.
#[inline]
pub fn ln_one_plus(x: f32) -> f32 {
    if is_nan(x) {
        return x;
    }
    let u = max(1.0 + x, f32::MIN_POSITIVE);
    let (e, t) = decompose(u);
    if e == 0 {
        return assemble(0.0, x, 0.0);
    }
    // What rounding 1 + x lost; dropped where 1 + x saturated or x alone decides.
    let lost = x - (u - 1.0);
    let correction = if abs(lost) < abs(u) { super::super::div(lost, u) } else { 0.0 };
    assemble(e as f32, t, correction)
}
