//! What are the coefficients of a rotated function?

use super::basis::basis;
use super::rotation_tables::{
    LOBE_DIRECTIONS, LOBE_WEIGHTS_1, LOBE_WEIGHTS_2, LOBE_WEIGHTS_3, LOBE_WEIGHTS_4,
};
use glam::{Mat3, Vec3};

/// Returns the coefficients of s ↦ f(R⁻¹ s): the function carried along by the rotation R. Orders 2 to 5.
///
/// Each band is written as 2l + 1 zonal lobes along fixed directions (constant weights), whose axes are turned:
/// no trigonometry, no division. R is a rotation matrix acting on columns; other matrices give no meaningful
/// result. Within 1e-6 of the norm.
#[inline]
pub fn rotate<const N: usize>(rotation: &Mat3, f: &[f32; N]) -> [f32; N] {
    const { assert!(N == 4 || N == 9 || N == 16 || N == 25) };
    let mut out = [0.0; N];
    out[0] = f[0];
    for j in 0..9 {
        if (j + 1) * (j + 1) < 4 * N {
            let d = LOBE_DIRECTIONS[j];
            let y = basis::<N>(turn(rotation, Vec3::new(d[0], d[1], d[2])));
            add_lobe::<N, 3>(&mut out, f, &y, LOBE_WEIGHTS_1, j, 1);
            if const { N > 4 } {
                add_lobe::<N, 5>(&mut out, f, &y, LOBE_WEIGHTS_2, j, 4);
            }
            if const { N > 9 } {
                add_lobe::<N, 7>(&mut out, f, &y, LOBE_WEIGHTS_3, j, 9);
            }
            if const { N > 16 } {
                add_lobe::<N, 9>(&mut out, f, &y, LOBE_WEIGHTS_4, j, 16);
            }
        }
    }
    out
}

/// R d, columns added in order.
#[inline]
fn turn(rotation: &Mat3, d: Vec3) -> Vec3 {
    (rotation.x_axis * d.x + rotation.y_axis * d.y) + rotation.z_axis * d.z
}

/// Adds lobe j of the band of W coefficients that begins at `start`, if the band has that many.
#[inline(always)]
fn add_lobe<const N: usize, const W: usize>(
    out: &mut [f32; N],
    f: &[f32; N],
    y: &[f32; N],
    weights: [[f32; W]; W],
    j: usize,
    start: usize,
) {
    if j < W {
        let mut strength = 0.0;
        for m in 0..W {
            strength += weights[j][m] * f[start + m];
        }
        for m in 0..W {
            out[start + m] += strength * y[start + m];
        }
    }
}
