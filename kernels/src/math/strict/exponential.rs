//! What are 2^x, e^x and e^x − 1?

use super::{clamp, exp2_integer, f, floor, is_nan, to_i32};

/// y·2^n in two factors, so that neither overflows while the product does not.
#[inline]
fn scale(y: f32, n: i32) -> f32 {
    let half = n >> 1;
    (y * exp2_integer(half)) * exp2_integer(n - half)
}

/// +∞ from an x of at least 88: computed, because naga refuses modules with an infinite constant.
#[inline]
fn overflow(x: f32) -> f32 {
    x * f32::MAX
}

/// Returns 2^x: 1.23 ULP; exactly 0 below −126, +∞ from 128 on, NaN for NaN; integers are exact.
#[inline]
pub fn exp2(x: f32) -> f32 {
    if is_nan(x) {
        return x;
    }
    if x < -126.0 {
        return 0.0;
    }
    if x >= 128.0 {
        return overflow(x);
    }
    let xc = clamp(x, -126.0, f(0x42FF_FFFF));
    let n = floor(xc + 0.5);
    let r = xc - n;
    let q = f(0x3AAF_9F29) + r * f(0x3920_FDBD);
    let q = f(0x3C1D_96A7) + r * q;
    let q = f(0x3D63_5774) + r * q;
    let q = f(0x3E75_FDEE) + r * q;
    let q = f(0x3F31_7218) + r * q;
    scale(1.0 + r * q, to_i32(n))
}

/// e^x's reduction: (n, r) with x = n ln 2 + r, |r| ≤ ln 2 / 2.
#[inline]
fn reduce(x: f32) -> (f32, f32) {
    let n = floor(x * 1.442_695_02 + 0.5);
    (n, (x - n * 0.693_359_375) - n * (-2.121_944_4e-4))
}

/// Returns e^x: 0.95 ULP; exactly 0 below −87.336544, +∞ above 88.72283, NaN for NaN.
#[inline]
pub fn exp(x: f32) -> f32 {
    if is_nan(x) {
        return x;
    }
    if x < -87.336_544 {
        return 0.0;
    }
    if x > 88.722_83 {
        return overflow(x);
    }
    let (n, r) = reduce(x);
    let p = f(0x3AB5_11F3);
    let p = f(0x3C09_1D10) + r * p;
    let p = f(0x3D2A_AC79) + r * p;
    let p = f(0x3E2A_AA49) + r * p;
    let p = f(0x3EFF_FFFE) + r * p;
    scale(1.0 + (r + (r * r) * p), to_i32(n))
}

/// Returns e^x − 1: 1.42 ULP, relative accuracy kept at 0; −1 below −17.5, +∞ above 88.72283, NaN for NaN.
#[inline]
pub fn exp_minus_one(x: f32) -> f32 {
    if is_nan(x) {
        return x;
    }
    if x < -17.5 {
        return -1.0;
    }
    if x > 88.722_83 {
        return overflow(x);
    }
    let (n, r) = reduce(x);
    let p = f(0x394F_842E);
    let p = f(0x3AB6_C6A9) + r * p;
    let p = f(0x3C08_8939) + r * p;
    let p = f(0x3D2A_AA47) + r * p;
    let p = f(0x3E2A_AAAA) + r * p;
    let p = f(0x3F00_0000) + r * p;
    let q = r + (r * r) * p;
    let n = to_i32(n);
    if n == 0 {
        q
    } else if n < 25 {
        let power = exp2_integer(n);
        (power - 1.0) + power * q
    } else {
        scale(1.0 + q, n)
    }
}
