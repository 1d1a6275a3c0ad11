//! How do few directions a pixel stand for many? Each of 4 × 4 neighbours turns them another way, and the mean of such a
//! neighbourhood has all of them (interleaved sampling with a discontinuity buffer).

use super::surface::Surface;
use super::upsample::without_faint;
use crate::gaussian::normal_similarity;
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{div, dot, max, saturate};
use glam::{Vec3, Vec4};

gpu_struct! {
    /// Parameters of [`filter_interleaved`].
    pub struct InterleavedParams {
        /// Pixels in a row.
        pub columns: u32,
        /// Rows.
        pub rows: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }
}

/// How fast a neighbour off the pixel's tangent plane stops to count: none does from asin ¼ on, 14°.
const OFF_PLANE: f32 = 16.0;
/// Neighbours that weigh less do not count.
const LEAST_WEIGHT: f32 = 1.0e-4;

/// Returns the part of a turn, of sixteenths, by which pixel `index` turns its directions; 0 for all if `columns` is 0.
///
/// The order is Bayer's: neighbours are far from each other.
#[inline]
pub fn interleaved_turn(index: u32, columns: u32) -> f32 {
    if columns == 0 {
        return 0.0;
    }
    let (x, y) = (index % columns, index / columns);
    let z = x ^ y;
    let order = ((z & 1) << 3) | ((y & 1) << 2) | (z & 2) | ((y & 2) >> 1);
    order as f32 * 0.0625
}

/// Returns the mean of `values` around pixel `index`, over neighbours of about the same plane: 5 × 5 with half weights at the border,
/// in which each of the 16 turns counts alike.
#[inline]
pub fn filter_interleaved(
    index: u32,
    params: &InterleavedParams,
    surfaces: &[Surface],
    values: &[Vec4],
) -> Vec4 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return Vec4::ZERO;
    }
    let (x, y) = (index % params.columns, index / params.columns);
    let mut sum = Vec4::ZERO;
    let mut whole = 0.0;
    for k in 0..25 {
        // Counted from two before the pixel, so that nothing is below 0.
        let (i, j) = (x + k % 5, y + k / 5);
        if i >= 2 && j >= 2 && i - 2 < params.columns && j - 2 < params.rows {
            let at = ((j - 2) * params.columns + (i - 2)) as usize;
            let other = &surfaces[at];
            if other.triangle != NO_TRIANGLE {
                let weight = border(k % 5) * border(k / 5) * alike(s, other);
                if weight > LEAST_WEIGHT {
                    sum += values[at] * weight;
                    whole += weight;
                }
            }
        }
    }
    // The pixel itself counts 1.
    without_faint(sum * div(1.0, max(whole, 1.0)))
}

/// The weight of a column or row of five.
#[inline]
fn border(k: u32) -> f32 {
    if k == 0 || k == 4 { 0.5 } else { 1.0 }
}

/// How much of one plane two surfaces are, in [0, 1].
#[inline]
fn alike(s: &Surface, other: &Surface) -> f32 {
    let normal = s.normal.truncate();
    let apart: Vec3 = other.position.truncate() - s.position.truncate();
    let off = dot(apart, normal);
    let share = div(OFF_PLANE * (off * off), max(dot(apart, apart), 1.0e-30));
    saturate(1.0 - share) * normal_similarity(normal, other.normal.truncate())
}
