//! How do few directions a pixel stand for many? Each of 4 × 4 neighbours turns them another way, and the mean of such a
//! neighbourhood has all of them (interleaved sampling with a discontinuity buffer).

use super::surface::Surface;
use crate::gaussian::{normal_similarity, plane_similarity};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{div, max, without_faint};
use glam::Vec4;

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

/// Neighbours that weigh less do not count.
const LEAST_WEIGHT: f32 = 1.0e-4;

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
    let columns = if params.columns == 0 { 1 } else { params.columns };
    let (x, y) = (index % columns, index / columns);
    let mut sum = Vec4::ZERO;
    let mut whole = 0.0;
    for k in 0..25 {
        // Counted from two before the pixel, so that nothing is below 0.
        let (i, j) = (x + k % 5, y + k / 5);
        if i >= 2 && j >= 2 && i - 2 < columns && j - 2 < params.rows {
            let at = ((j - 2) * columns + (i - 2)) as usize;
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
    let (normal, apart) = (s.normal.truncate(), other.position.truncate() - s.position.truncate());
    plane_similarity(apart, normal) * normal_similarity(normal, other.normal.truncate())
}
