//! What is the error function, the integral of a Gaussian?

use super::{abs, copy_sign, exp, f, is_nan, min};

/// Returns erf x: 1.30 ULP, odd, exactly ±1 from |x| = 3.92 on, NaN for NaN.
#[inline]
pub fn erf(x: f32) -> f32 {
    if is_nan(x) {
        return x;
    }
    let a = abs(x);
    if a < 0.9375 {
        let u = a * a;
        let p = f(0x38AB_D605);
        let p = f(0xBA54_555B) + u * p;
        let p = f(0x3BAA_4CE5) + u * p;
        let p = f(0xBCDC_04DF) + u * p;
        let p = f(0x3DE7_16E8) + u * p;
        let p = f(0xBEC0_93A1) + u * p;
        let p = f(0x3E03_75D4) + u * p;
        return copy_sign(a + a * p, x);
    }
    if a >= 3.92 {
        return copy_sign(1.0, x);
    }
    let c = min(a, 3.95);
    let n = f(0xB7B0_F534);
    let n = f(0x39E3_C88A) + c * n;
    let n = f(0xBB88_AD66) + c * n;
    let n = f(0x3CCD_C740) + c * n;
    let n = f(0xBDDD_C1F3) + c * n;
    let n = f(0xBF22_2306) + c * n;
    let n = f(0xBF90_93F2) + c * n;
    let n = f(0x3937_2B69) + c * n;
    copy_sign(1.0 - exp(n), x)
}
