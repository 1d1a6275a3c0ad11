//! What are the values of the basis functions in a direction, and how are vectors of coefficients added?

use crate::math;
use glam::Vec3;

/// √(4π): the constant function 1 is (`UNIT`, 0, 0, …).
pub const UNIT: f32 = 3.544_907_8;

const C0: f32 = 0.282_094_8;
const C1: f32 = 0.488_602_5;
const C2: f32 = 1.092_548_5;
const C20_SQUARE: f32 = 0.946_174_7;
const C20: f32 = 0.315_391_57;
const C22: f32 = 0.546_274_2;
const C30: f32 = 0.373_176_34;
const C31: f32 = 0.457_045_8;
const C32: f32 = 2.890_611_4;
const C33: f32 = 0.590_043_6;
const C40: f32 = 0.105_785_55;
const C41: f32 = 0.669_046_5;
const C42: f32 = 0.946_174_7;
const C43: f32 = 1.770_130_8;
const C44: f32 = 2.503_343;

/// Returns the N = n² basis functions at a unit direction, orders 2 to 5.
///
/// Absolute error of bands 0 to 4: 1.5e-8, 5.1e-8, 1.6e-7, 2.8e-7, 5.4e-7, that of a direction rounded to f32 included.
#[inline]
pub fn basis<const N: usize>(d: Vec3) -> [f32; N] {
    const { assert!(N == 4 || N == 9 || N == 16 || N == 25) };
    let (x, y, z) = (d.x, d.y, d.z);
    let mut out = [0.0; N];
    out[0] = C0;
    out[1] = -(C1 * y);
    out[2] = C1 * z;
    out[3] = -(C1 * x);
    if const { N < 9 } {
        return out;
    }
    let (z2, xy) = (z * z, x * y);
    let x2_minus_y2 = (x - y) * (x + y);
    out[4] = C2 * xy;
    out[5] = -(C2 * (y * z));
    out[6] = C20_SQUARE * z2 - C20;
    out[7] = -(C2 * (x * z));
    out[8] = C22 * x2_minus_y2;
    if const { N < 16 } {
        return out;
    }
    // y(3x² − y²) and x(x² − 3y²): r³ sin 3φ and r³ cos 3φ.
    let (x2, y2) = (x * x, y * y);
    let sine3 = y * (3.0 * x2 - y2);
    let cosine3 = x * (x2 - 3.0 * y2);
    let five = 5.0 * z2 - 1.0;
    out[9] = -(C33 * sine3);
    out[10] = C32 * (xy * z);
    out[11] = -(C31 * (y * five));
    out[12] = C30 * (z * (5.0 * z2 - 3.0));
    out[13] = -(C31 * (x * five));
    out[14] = (0.5 * C32) * (z * x2_minus_y2);
    out[15] = -(C33 * cosine3);
    if const { N < 25 } {
        return out;
    }
    let seven = 7.0 * z2 - 1.0;
    let z_seven = z * (7.0 * z2 - 3.0);
    out[16] = C44 * (xy * x2_minus_y2);
    out[17] = -(C43 * (z * sine3));
    out[18] = C42 * (xy * seven);
    out[19] = -(C41 * (y * z_seven));
    out[20] = C40 * (z2 * (35.0 * z2 - 30.0) + 3.0);
    out[21] = -(C41 * (x * z_seven));
    out[22] = (0.5 * C42) * (x2_minus_y2 * seven);
    out[23] = -(C43 * (z * cosine3));
    out[24] = (0.25 * C44) * (x * cosine3 - y * sine3);
    out
}

/// Returns the four basis functions of order 2 (bands 0 and 1) at a unit direction; see [`basis`].
#[inline]
pub fn basis_order2(d: Vec3) -> [f32; 4] {
    basis::<4>(d)
}

/// Returns the nine basis functions of order 3 at a unit direction; see [`basis`].
#[inline]
pub fn basis_order3(d: Vec3) -> [f32; 9] {
    basis::<9>(d)
}

/// Returns the 16 basis functions of order 4 at a unit direction; see [`basis`].
#[inline]
pub fn basis_order4(d: Vec3) -> [f32; 16] {
    basis::<16>(d)
}

/// Returns the 25 basis functions of order 5 at a unit direction; see [`basis`].
#[inline]
pub fn basis_order5(d: Vec3) -> [f32; 25] {
    basis::<25>(d)
}

/// Returns Σ a_i b_i, added in index order: the integral of the product of two functions.
#[inline]
pub fn dot<const N: usize>(a: &[f32; N], b: &[f32; N]) -> f32 {
    let mut sum = 0.0;
    for i in 0..N {
        sum += a[i] * b[i];
    }
    sum
}

/// Returns sum + scale·v, coefficient by coefficient.
#[inline]
pub fn add_scaled<const N: usize>(sum: &[f32; N], v: &[f32; N], scale: f32) -> [f32; N] {
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = sum[i] + scale * v[i];
    }
    out
}

/// Returns the projection `sum` with one sample more: sum + value·y(d).
///
/// For a Monte Carlo projection, `value` is the sample times its share of solid angle.
#[inline]
pub fn project<const N: usize>(sum: &[f32; N], d: Vec3, value: f32) -> [f32; N] {
    add_scaled(sum, &basis::<N>(d), value)
}

/// Returns the value of the function with these coefficients in a unit direction; it may ring below 0.
#[inline]
pub fn evaluate<const N: usize>(coefficients: &[f32; N], d: Vec3) -> f32 {
    dot(coefficients, &basis::<N>(d))
}

/// Returns whether no coefficient is NaN or infinite.
#[inline]
pub fn is_finite<const N: usize>(v: &[f32; N]) -> bool {
    let mut finite = true;
    for i in 0..N {
        finite = finite && math::is_finite(v[i]);
    }
    finite
}
