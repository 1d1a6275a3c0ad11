//! What does a spherical proxy cover, as a surface sees it, and what does it send back? SGI §3 and §5.

use super::logarithm::occlusion_key;
use crate::math::{div, dot, floor, length, max, min, normalize_or, saturate, sqrt, to_u32};
use glam::Vec3;

/// Over what share of its radius beyond a sphere's surface a receiver outside it gets the sphere's whole effect.
pub const FADE: f32 = 0.5;
/// The smallest such share: narrower ones would jump.
const LEAST_FADE: f32 = 1.0e-3;

/// A sphere as seen from a point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blocker {
    /// Unit direction toward its centre.
    pub direction: Vec3,
    /// Sine of its half angle, in [0, 1].
    pub alpha: f32,
    /// How much of it counts, in [0, 1]; 0 for one that is below the horizon or holds the point from below.
    pub weight: f32,
}

/// t²(3 − 2t), t clamped to [0, 1].
#[inline]
fn smoothstep(t: f32) -> f32 {
    let t = saturate(t);
    (t * t) * (3.0 - 2.0 * t)
}

/// Returns what of a sphere counts for a point of a surface with unit normal `n`.
///
/// A sphere that reaches below the surface's plane is replaced by the one between the plane and its topmost point, so that
/// a surface does not shadow itself; one that holds the point from below fades out, from `fade` of its radii outside of it on ([`FADE`] is
/// usual; at least a thousandth). Continuous in all arguments; never inside: α ≤ 1. In place of SGI's rules (§3), which jump.
#[inline]
pub fn blocker(centre: Vec3, radius: f32, p: Vec3, n: Vec3, fade: f32) -> Blocker {
    let to_centre = centre - p;
    let height = dot(to_centre, n);
    if !(radius > 0.0) || !(height > -radius) {
        return Blocker { direction: n, alpha: 0.0, weight: 0.0 };
    }
    let (mut offset, mut size, mut weight) = (to_centre, radius, 1.0);
    if height < radius {
        offset = to_centre + n * (0.5 * (radius - height));
        size = 0.5 * (radius + height);
        let below = smoothstep(div(radius - height, radius));
        let outside = smoothstep(div(div(length(to_centre), radius) - 1.0, max(fade, LEAST_FADE)));
        weight = 1.0 - below * (1.0 - outside);
    }
    let distance = length(offset);
    let alpha = if distance > 0.0 { min(div(size, distance), 1.0) } else { 1.0 };
    Blocker { direction: normalize_or(offset, n), alpha, weight }
}

/// Returns the zonal operator that averages a function over the side of a sphere that is seen, around +z toward its centre.
///
/// Order 3; `alpha` = sin θ, clamped to [0, 1]. SGI eq. 14 without cancellation: 5e-7 relative (as printed it has lost
/// all digits at α = 0.01).
#[inline]
pub fn averaged_operator(alpha: f32) -> [f32; 3] {
    let a = saturate(alpha);
    let c = sqrt((1.0 - a) * (1.0 + a));
    let o = 1.0 + c;
    // √(3/π)/6 and √(5/π)/20.
    let d1 = -0.162_867_5 * (div(a, o) * (2.0 + c) + o);
    let d2 = 0.063_078_31 * ((3.0 * div(2.0 + c, o) - c * o) + 4.0 * (a * o));
    [0.282_094_8, d1, d2]
}

/// Returns the same by SGI's polynomials: 0.0027 and 0.0054 off at most.
#[inline]
pub fn averaged_operator_fit(alpha: f32) -> [f32; 3] {
    let a = saturate(alpha);
    [0.28209, (0.08432 * a - 0.25073) * a - 0.32494, ((0.22502 - 0.22230 * a) * a + 0.47398) * a + 0.15950]
}

/// Numbers of a row of the exact operator's table.
pub const EXACT_OPERATOR_WORDS: usize = 14;

/// Returns SGI's exact operator M(θ) of order 3, applied to a function in the frame whose +z points to the sphere's centre: the
/// radiance that a point receives of a sphere whose surface has radiance f. SGI eq. 16.
///
/// `table` holds `entries` ≥ 2 rows of [`EXACT_OPERATOR_WORDS`] numbers, M/u at √u = e/(entries − 1), u = 1 − cos θ: nine for
/// m = 0 by rows, four for |m| = 1, one for |m| = 2. Keyed by √u, in which M/u is smooth at both ends. Too short a table
/// gives 0.
#[inline]
pub fn exact_operator(table: &[f32], entries: u32, alpha: f32, f: &[f32; 9]) -> [f32; 9] {
    let mut out = [0.0; 9];
    if entries < 2 || (table.len() as u32) < entries * (EXACT_OPERATOR_WORDS as u32) {
        return out;
    }
    let u = occlusion_key(alpha);
    let position = sqrt(u) * ((entries - 1) as f32);
    let nearest = to_u32(floor(position));
    let entry = if nearest < entries - 2 { nearest } else { entries - 2 };
    let fraction = saturate(position - entry as f32);
    let start = entry as usize * EXACT_OPERATOR_WORDS;
    let mut m = [0.0; EXACT_OPERATOR_WORDS];
    for k in 0..EXACT_OPERATOR_WORDS {
        let low = table[start + k];
        let high = table[start + EXACT_OPERATOR_WORDS + k];
        m[k] = u * (low + fraction * (high - low));
    }
    // m = 0 are coefficients 0, 2, 6; m = ∓1 are 1, 5 and 3, 7; |m| = 2 are 4 and 8.
    out[0] = (m[0] * f[0] + m[1] * f[2]) + m[2] * f[6];
    out[2] = (m[3] * f[0] + m[4] * f[2]) + m[5] * f[6];
    out[6] = (m[6] * f[0] + m[7] * f[2]) + m[8] * f[6];
    out[1] = m[9] * f[1] + m[10] * f[5];
    out[5] = m[11] * f[1] + m[12] * f[5];
    out[3] = m[9] * f[3] + m[10] * f[7];
    out[7] = m[11] * f[3] + m[12] * f[7];
    out[4] = m[13] * f[4];
    out[8] = m[13] * f[8];
    out
}
