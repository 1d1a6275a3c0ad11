//! Which voxels does a pixel see, by its own rays and by its neighbours'? VF §3.2, eq. 4.
//!
//! A list is an array of words of fixed size: the number of hemisphere rays that its counts are out of, the number of
//! its voxels, the number of voxels that found no room, how many of the rays met anything, then pairs (voxel + 1, how many of those rays met it) in order of voxels. A voxel + 1
//! of 0 ends the list.

use super::march::{NO_LOBE, NO_VOXEL};
use crate::gaussian::shares_visibility;
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{abs, dot, max, min_u32};
use crate::passes::Accumulate;
use crate::passes::surface::Surface;
use crate::sampling::hash::{combine, hash};
use glam::Vec4;

/// Words of a list before its pairs.
pub const LIST_HEADER: u32 = 4;
/// The largest half width of the filter.
pub const MAX_HALF_WIDTH: u32 = 4;
/// Rows and columns of the largest window.
const MAX_ROWS: usize = 9;
/// Its pixels.
const MAX_WINDOW: usize = MAX_ROWS * MAX_ROWS;

gpu_struct! {
    /// Parameters of the passes over lists of visible voxels.
    pub struct ListParams {
        /// Coarse pixels in a row.
        pub width: u32,
        /// Rows of coarse pixels.
        pub height: u32,
        /// Rays of a pixel over the hemisphere.
        pub diffuse_rays: u32,
        /// Rays of a pixel in the specular lobe.
        pub lobe_rays: u32,
        /// Pixels that the filter reaches to either side (n), at most [`MAX_HALF_WIDTH`].
        pub half_width: u32,
        /// Pixels that it reaches up and down (m), at most [`MAX_HALF_WIDTH`].
        pub half_height: u32,
        /// Voxels that a list has room for.
        pub capacity: u32,
        /// Largest distance of a pixel from the other's tangent plane, as a share of its distance from the eye.
        pub max_depth_difference: f32,
        /// Smallest cosine between the normals of pixels that share visibility.
        pub min_normal_cosine: f32,
        /// Voxels that can be met at all.
        pub occupied: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }

    /// What a finer pixel has to know of a coarse one, beside its list.
    pub struct ListHeader {
        /// Position in metres; w is the distance from the eye, −1 where the pixel sees nothing.
        pub position: Vec4,
        /// Unit normal; w is the mean coverage of the window's lobes, [`NO_LOBE`] without any.
        pub normal: Vec4,
    }
}

/// Words of one list.
#[inline]
pub fn list_stride(capacity: u32) -> u32 {
    LIST_HEADER + 2 * capacity
}

/// Puts ray `index` to its place among its pixel's rays in order of voxels; the output starts cleared.
///
/// Writes 2 (voxel + 1), plus 1 for a ray of the specular lobe; rays without a voxel leave zeros at the end.
/// The place is counted, not searched: as many comparisons as the pixel has rays, fewer than its discs.
#[inline]
pub fn sort_rays(index: u32, params: &ListParams, voxels: &[u32], output: &mut impl Accumulate) {
    let rays = params.diffuse_rays + params.lobe_rays;
    let pixel = index / rays;
    let first = pixel * rays;
    let own = voxels[index as usize];
    if own == NO_VOXEL {
        return;
    }
    let mut place = 0;
    for i in first..index {
        if voxels[i as usize] <= own {
            place += 1;
        }
    }
    for i in index + 1..first + rays {
        if voxels[i as usize] < own {
            place += 1;
        }
    }
    let lobe = if index - first >= params.diffuse_rays { 1 } else { 0 };
    output.or(first + place, ((own + 1) << 1) | lobe);
}

/// Writes which voxels the rays of pixel `index` met, each once, and how many of the hemisphere's rays did.
///
/// Words `voxel << 12 | count` in order of voxels, behind the last [`NOTHING`]: one word more than the pixel has rays. `sorted` is
/// that of [`sort_rays`]; the output starts cleared.
#[inline]
pub fn count_rays(index: u32, params: &ListParams, sorted: &[u32], output: &mut impl Accumulate) {
    let rays = params.diffuse_rays + params.lobe_rays;
    let (first, out) = (index * rays, index * (rays + 1));
    let (mut voxel, mut count, mut written) = (0, 0, 0);
    for i in first..first + rays {
        let word = sorted[i as usize];
        if word >> 1 != voxel {
            if voxel != 0 {
                output.or(out + written, met(voxel - 1, count));
                written += 1;
            }
            (voxel, count) = (word >> 1, 0);
        }
        count += 1 - (word & 1);
    }
    if voxel != 0 {
        output.or(out + written, met(voxel - 1, count));
        written += 1;
    }
    for i in written..rays + 1 {
        output.or(out + i, NOTHING);
    }
}

/// Bits of a count in a word of [`count_rays`].
const COUNT_BITS: u32 = 12;
/// The largest count: at most this many rays of a pixel go over its hemisphere.
pub const MAX_COUNT: u32 = (1 << COUNT_BITS) - 1;
/// Voxels must have numbers below this.
pub const MAX_VOXEL: u32 = (1 << (32 - COUNT_BITS)) - 1;
/// The word behind the last voxel.
pub const NOTHING: u32 = 0xFFFF_FFFF;

/// A voxel and how many rays met it, in one word that sorts by voxel.
#[inline]
fn met(voxel: u32, count: u32) -> u32 {
    (voxel << COUNT_BITS) | count
}

/// Whether two pixels exchange their lists: each lies near the other's tangent plane, and their normals agree.
///
/// VF's depth difference would tell apart the pixels of one floor seen at a grazing angle; planes do not.
#[inline]
fn exchange(params: &ListParams, a: &Surface, b: &Surface) -> bool {
    if a.triangle == NO_TRIANGLE || b.triangle == NO_TRIANGLE {
        return false;
    }
    let between = b.position.truncate() - a.position.truncate();
    let (na, nb) = (a.normal.truncate(), b.normal.truncate());
    let difference = max(abs(dot(between, na)), abs(dot(between, nb)));
    let limit = params.max_depth_difference * max(a.position.w, b.position.w);
    shares_visibility(difference, dot(na, nb), limit, params.min_normal_cosine)
}

/// The rays of the pixels of a window, merged.
struct Window {
    /// The next word of each pixel's rays, [`NOTHING`] behind the last and for pixels that share nothing.
    next: [u32; MAX_WINDOW],
    /// Where it stands.
    at: [u32; MAX_WINDOW],
    /// The lowest next word of each row: most rows need not be looked at for a voxel.
    row: [u32; MAX_ROWS],
    /// Pixels that share their rays.
    pixels: u32,
}

/// A voxel of the union, and how many hemisphere rays met it.
struct Member {
    /// [`NOTHING`] when none is left.
    voxel: u32,
    count: u32,
}

impl Window {
    #[inline]
    fn new(pixel: u32, params: &ListParams, surfaces: &[Surface], counted: &[u32]) -> Self {
        let stride = params.diffuse_rays + params.lobe_rays + 1;
        let mut window = Self {
            next: [NOTHING; MAX_WINDOW],
            // Words that are read although they are not wanted: any will do.
            at: [0; MAX_WINDOW],
            row: [NOTHING; MAX_ROWS],
            pixels: 0,
        };
        let own = surfaces[pixel as usize];
        let range = Range::around(pixel, params);
        for y in range.top..range.bottom + 1 {
            let row = (y - range.top) as usize;
            for x in range.left..range.right + 1 {
                let other = y * params.width + x;
                if exchange(params, &own, &surfaces[other as usize]) {
                    let slot = row * MAX_ROWS + (x - range.left) as usize;
                    window.at[slot] = other * stride;
                    window.next[slot] = counted[(other * stride) as usize];
                    window.row[row] = min_u32(window.row[row], window.next[slot]);
                    window.pixels += 1;
                }
            }
        }
        window
    }

    /// Takes the lowest voxel that is left out of all rays.
    #[inline]
    fn take(&mut self, counted: &[u32]) -> Member {
        let mut lowest = NOTHING;
        for row in 0..MAX_ROWS {
            lowest = min_u32(lowest, self.row[row]);
        }
        let voxel = lowest >> COUNT_BITS;
        let mut count = 0;
        for row in 0..MAX_ROWS {
            // No voxel has the number of NOTHING.
            if lowest != NOTHING && self.row[row] >> COUNT_BITS == voxel {
                let mut least = NOTHING;
                for column in 0..MAX_ROWS {
                    let slot = row * MAX_ROWS + column;
                    let next = self.next[slot];
                    // Without a branch: which pixels met a voxel cannot be predicted.
                    let here = next >> COUNT_BITS == voxel;
                    count += if here { next & MAX_COUNT } else { 0 };
                    self.at[slot] += if here { 1 } else { 0 };
                    let after = counted[self.at[slot] as usize];
                    let next = if here { after } else { next };
                    self.next[slot] = next;
                    least = min_u32(least, next);
                }
                self.row[row] = least;
            }
        }
        Member { voxel: if lowest == NOTHING { NOTHING } else { voxel }, count }
    }
}

/// The pixels of a window, cut off at the borders of the picture.
struct Range {
    left: u32,
    right: u32,
    top: u32,
    bottom: u32,
}

impl Range {
    #[inline]
    fn around(pixel: u32, params: &ListParams) -> Self {
        let (x, y) = (pixel % params.width, pixel / params.width);
        let (n, m) =
            (min_u32(params.half_width, MAX_HALF_WIDTH), min_u32(params.half_height, MAX_HALF_WIDTH));
        Self {
            left: x - min_u32(x, n),
            right: min_u32(x + n, params.width - 1),
            top: y - min_u32(y, m),
            bottom: min_u32(y + m, params.height - 1),
        }
    }
}

/// Hashes below this keep their voxel in the list of pixel `index`: all where the union fits.
#[inline]
fn thinning(index: u32, params: &ListParams, surfaces: &[Surface], counted: &[u32]) -> u32 {
    let mut threshold = 0xFFFF_FFFF;
    if params.occupied > params.capacity {
        let mut window = Window::new(index, params, surfaces, counted);
        let mut size = 0;
        loop {
            let member = window.take(counted);
            if member.voxel == NOTHING {
                break;
            }
            size += 1;
        }
        if size > params.capacity {
            // Aims below the capacity: the number that the hash keeps varies by its root.
            let slack = params.capacity / 16 + min_u32(params.capacity / 4, 16);
            threshold = (0xFFFF_FFFF / size) * (params.capacity - slack);
        }
    }
    threshold
}

/// Writes the list of pixel `index`: the union of its neighbours' voxels, VF eq. 4. The output starts cleared.
///
/// `counted` is that of [`count_rays`]. Merges sorted lists: each word is taken once, and for each voxel of the union only
/// the rows that have it are looked at. A union larger than the capacity is thinned by a hash of voxel and pixel, so that no part of the scene is
/// preferred, and how many voxels are left out is counted.
#[inline]
pub fn filter_lists(
    index: u32,
    params: &ListParams,
    surfaces: &[Surface],
    counted: &[u32],
    output: &mut impl Accumulate,
) {
    let threshold = thinning(index, params, surfaces, counted);
    let mut window = Window::new(index, params, surfaces, counted);
    let total = window.pixels * params.diffuse_rays;
    let first = index * list_stride(params.capacity);
    let (mut kept, mut dropped, mut met) = (0, 0, 0);
    loop {
        let member = window.take(counted);
        if member.voxel == NOTHING {
            break;
        }
        met += member.count;
        let chosen = threshold == 0xFFFF_FFFF || hash(combine(index, member.voxel)) < threshold;
        if chosen && kept < params.capacity {
            output.or(first + LIST_HEADER + 2 * kept, member.voxel + 1);
            output.or(first + LIST_HEADER + 2 * kept + 1, member.count);
            kept += 1;
        } else {
            dropped += 1;
        }
    }
    output.or(first, total);
    output.or(first + 1, kept);
    output.or(first + 2, dropped);
    output.or(first + 3, met);
}

/// Returns the position and normal of pixel `index`, and the mean coverage of those pixels of its window that have lobes.
///
/// `coverage` is that of [`super::march::lobe_coverage`]; not read without rays in lobes.
#[inline]
pub fn list_headers(index: u32, params: &ListParams, surfaces: &[Surface], coverage: &[f32]) -> ListHeader {
    let own = surfaces[index as usize];
    let mut mean = NO_LOBE;
    if params.lobe_rays > 0 {
        let range = Range::around(index, params);
        let (mut sum, mut count) = (0.0, 0.0);
        for y in range.top..range.bottom + 1 {
            for x in range.left..range.right + 1 {
                let other = y * params.width + x;
                let covered = coverage[other as usize];
                if covered >= 0.0 && exchange(params, &own, &surfaces[other as usize]) {
                    sum += covered;
                    count += 1.0;
                }
            }
        }
        mean = if count > 0.0 { crate::math::div(sum, count) } else { NO_LOBE };
    }
    ListHeader { position: own.position, normal: own.normal.truncate().extend(mean) }
}
