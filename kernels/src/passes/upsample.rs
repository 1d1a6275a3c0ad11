//! How does a picture of few pixels become one of many, without bleeding over edges? VF §3.3, SGI eq. 11.

use super::surface::Surface;
use crate::gaussian::{CoarseSamples, place_weights, upsampling_weights};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{floor, min_u32, saturate, to_u32, without_faint};
use glam::{Vec3, Vec4};

/// By place, depth and normal.
pub const BILATERAL: u32 = 0;
/// By place: light bleeds over edges.
pub const BILINEAR: u32 = 1;
/// From the pixel that is nearest.
pub const NEAREST: u32 = 2;

gpu_struct! {
    /// Parameters of [`upsample`].
    pub struct UpsampleParams {
        /// Pixels in a row of the fine picture.
        pub width: u32,
        /// Row-major number of the first fine pixel of the band.
        pub first_pixel: u32,
        /// Pixels in a row of the coarse picture.
        pub coarse_width: u32,
        /// Rows of the coarse picture.
        pub coarse_height: u32,
        /// Coarse pixels per fine pixel, across.
        pub scale_x: f32,
        /// Coarse pixels per fine pixel, down.
        pub scale_y: f32,
        /// [`BILATERAL`], [`BILINEAR`] or [`NEAREST`].
        pub filter: u32,
        /// Padding.
        pub pad0: u32,
    }
}

/// The four coarse pixels around a fine one.
#[derive(Clone, Copy)]
pub struct Footprint {
    /// Row-major numbers; at the picture's border one may stand twice.
    pub pixels: [u32; 4],
    /// Bilinear weights, summing to 1.
    pub bilinear: [f32; 4],
}

/// Returns the coarse pixels around the centre of fine pixel (x, y); scales are coarse pixels per fine pixel.
#[inline]
pub fn footprint(x: u32, y: u32, scale_x: f32, scale_y: f32, width: u32, height: u32) -> Footprint {
    let (x0, x1, fx) = neighbours(x, scale_x, width);
    let (y0, y1, fy) = neighbours(y, scale_y, height);
    Footprint {
        pixels: [y0 * width + x0, y0 * width + x1, y1 * width + x0, y1 * width + x1],
        bilinear: [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy],
    }
}

/// The coarse cells beside the centre of fine cell `x`, and the share of the second.
#[inline]
fn neighbours(x: u32, scale: f32, count: u32) -> (u32, u32, f32) {
    let place = (x as f32 + 0.5) * scale - 0.5;
    let cell = floor(place);
    let fraction = saturate(place - cell);
    let first = if cell < 0.0 { 0 } else { min_u32(to_u32(cell), count - 1) };
    let second = if cell < 0.0 { 0 } else { min_u32(first + 1, count - 1) };
    (first, second, fraction)
}

/// Returns the value of fine pixel `index`: the four coarse values around it, weighted by depth and normal if the filter says so.
#[inline]
pub fn upsample(
    index: u32,
    params: &UpsampleParams,
    surfaces: &[Surface],
    coarse_surfaces: &[Surface],
    values: &[Vec4],
) -> Vec4 {
    let s = surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return Vec4::ZERO;
    }
    let pixel = params.first_pixel + index;
    let cells = footprint(
        pixel % params.width,
        pixel / params.width,
        params.scale_x,
        params.scale_y,
        params.coarse_width,
        params.coarse_height,
    );
    let mut samples = CoarseSamples { bilinear: cells.bilinear, depth: [0.0; 4], normal: [Vec3::ZERO; 4] };
    for k in 0..4 {
        let coarse = &coarse_surfaces[cells.pixels[k] as usize];
        if coarse.triangle != NO_TRIANGLE {
            samples.depth[k] = coarse.position.w;
            samples.normal[k] = coarse.normal.truncate();
        }
    }
    let weights = if params.filter == BILATERAL {
        upsampling_weights(&samples, s.position.w, s.normal.truncate())
    } else {
        place_weights(&samples, params.filter == NEAREST)
    };
    let mut sum = Vec4::ZERO;
    for k in 0..4 {
        sum += values[cells.pixels[k] as usize] * weights[k];
    }
    without_faint(sum)
}
