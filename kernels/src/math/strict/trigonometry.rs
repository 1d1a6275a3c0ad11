//! What are sine, cosine and their inverses?

use super::{abs, copy_sign, f, floor, max, min, sqrt, to_i32};
use crate::math::div;

const HALF_PI_HIGH: f32 = f(0x3FC9_0FDB);
const HALF_PI_LOW: f32 = f(0xB33B_BD2E);

/// (sin r, cos r) for |r| ≤ π/4, turned by k quarter turns.
#[inline]
fn quadrant(r: f32, k: i32) -> (f32, f32) {
    let u = r * r;
    let s = f(0x3C08_8398) + u * f(0xB94C_A030);
    let s = f(0xBE2A_AAA3) + u * s;
    let sin = r + (r * u) * s;
    let c = f(0xBAB6_0614) + u * f(0x37CC_F435);
    let c = f(0x3D2A_AAA5) + u * c;
    let cos = (1.0 - 0.5 * u) + (u * u) * c;
    let (a, b) = if k & 1 == 0 { (sin, cos) } else { (cos, sin) };
    let a = if k & 2 == 0 { a } else { -a };
    let b = if (k + 1) & 2 == 0 { b } else { -b };
    (a, b)
}

/// Returns (sin 2πt, cos 2πt): 1.96 ULP, absolute 1.1e-7; multiples of 1/4 are exact.
///
/// |t| is meaningful up to 2²¹; beyond, and for NaN, some finite pair comes back.
#[inline]
pub fn sin_cos_turn(t: f32) -> (f32, f32) {
    let t = super::clamp(t, -4_194_304.0, 4_194_304.0);
    let k = floor(4.0 * t + 0.5);
    let d = t - 0.25 * k;
    quadrant(d * f(0x40C9_0FDB), to_i32(k))
}

/// Returns (sin x, cos x): 1.55 ULP for |x| ≤ 1000 away from zeros, absolute 9.3e-8 for |x| ≤ 8192.
///
/// |x| beyond 1e5 and NaN give some finite pair.
#[inline]
pub fn sin_cos(x: f32) -> (f32, f32) {
    let x = super::clamp(x, -1.0e6, 1.0e6);
    let k = floor(x * 0.636_619_747 + 0.5);
    let r = ((x - k * 1.570_312_5) - k * 4.837_512_97e-4) - k * 7.549_790_13e-8;
    quadrant(r, to_i32(k))
}

/// Returns the arc cosine in [0, π]: 1.15 ULP; |x| > 1 counts as ±1, NaN as 1.
#[inline]
pub fn acos(x: f32) -> f32 {
    let a = min(abs(x), 1.0);
    let large = a > 0.5;
    let z = if large { 0.5 * (1.0 - a) } else { a * a };
    let s = if large { sqrt(z) } else { a };
    let q = f(0x3D2C_C304);
    let q = f(0x3CC6_0672) + z * q;
    let q = f(0x3D3A_406D) + z * q;
    let q = f(0x3D99_80E6) + z * q;
    let q = f(0x3E2A_AAE4) + z * q;
    let p = s + (s * z) * q;
    if large {
        if x > 0.0 { 2.0 * p } else { 2.0 * (HALF_PI_HIGH - (p - HALF_PI_LOW)) }
    } else {
        let p = copy_sign(p, x);
        HALF_PI_HIGH - (p - HALF_PI_LOW)
    }
}

/// Returns the angle of the point (x, y) in [−π, π]: 1.54 ULP; 0 for the origin, x = −0 counts as +0.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    let ax = abs(x);
    let ay = abs(y);
    let large = max(ax, ay);
    let small = min(ax, ay);
    let t = if !(large > 0.0) {
        0.0
    } else if small == large {
        1.0
    } else {
        div(small, large)
    };
    let u = t * t;
    let q = f(0x3A91_FC30);
    let q = f(0xBBEF_CB00) + u * q;
    let q = f(0x3CB8_A545) + u * q;
    let q = f(0xBD37_0CA4) + u * q;
    let q = f(0x3D8A_1153) + u * q;
    let q = f(0xBDB4_7377) + u * q;
    let q = f(0x3DE2_78EE) + u * q;
    let q = f(0xBE12_39BA) + u * q;
    let q = f(0x3E4C_CBF0) + u * q;
    let q = f(0xBEAA_AAA9) + u * q;
    let mut r = t + (t * u) * q;
    if ay > ax {
        r = HALF_PI_HIGH - (r - HALF_PI_LOW);
    }
    if x < 0.0 {
        r = 2.0 * HALF_PI_HIGH - (r - 2.0 * HALF_PI_LOW);
    }
    copy_sign(r, y)
}
