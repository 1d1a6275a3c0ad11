//! Which triangles meet which voxels? VCT §4.2, without locks.
//!
//! Pairs (cell, triangle) are refined level by level: each tests its cell's eight children, a scan tells where the
//! children's pairs go. Work is even however large triangles are, and the order is the same on every machine.

use crate::geometry::lattice::{
    bit_count, block_of, level_offset, nth_bit, pack_point, point_bit, unpack_point,
};
use crate::geometry::overlap::{overlaps_conservative, overlaps_thin};
use crate::passes::Accumulate;
use crate::passes::scan::owner;
use crate::passes::scene::Triangle;
use glam::{UVec3, Vec3, Vec4};

gpu_struct! {
    /// Parameters of the passes that refine pairs of cells and triangles.
    pub struct VoxeliseParams {
        /// Lower corner of cell (0, 0, 0) in metres; w is 1/(edge of the cells tested), 1/m.
        pub lower: Vec4,
        /// Number of pairs.
        pub pairs: u32,
        /// 1 to keep a cell only where the triangle meets its axis cross, 0 wherever it touches.
        pub thin: u32,
        /// Depth of the pyramid.
        pub depth: u32,
        /// The first triangle of [`root_pairs`].
        pub first: u32,
    }

    /// Parameters of the passes that move words.
    pub struct WordParams {
        /// Where the words begin in the output.
        pub offset: u32,
        /// Number of words.
        pub count: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }
}

/// Returns word `index` of the first pairs: triangles from `params.first` on, in the cell that is the whole.
#[inline]
pub fn root_pairs(index: u32, params: &VoxeliseParams) -> u32 {
    if index & 1 == 1 { params.first + index / 2 } else { 0 }
}

/// The triangle in units of the cells tested.
#[inline]
pub(super) fn in_cells(lower: Vec4, t: &Triangle) -> (Vec3, Vec3, Vec3) {
    let (origin, scale) = (lower.truncate(), lower.w);
    (
        (t.p0.truncate() - origin) * scale,
        (t.p1.truncate() - origin) * scale,
        (t.p2.truncate() - origin) * scale,
    )
}

/// Child `number` (0 to 7) of a cell.
#[inline]
fn child(cell: UVec3, number: u32) -> UVec3 {
    UVec3::new(2 * cell.x + (number & 1), 2 * cell.y + ((number >> 1) & 1), 2 * cell.z + (number >> 2))
}

/// Returns which of the eight children of pair `index`'s cell its triangle meets, a bit for each.
#[inline]
pub fn child_masks(index: u32, params: &VoxeliseParams, pairs: &[u32], triangles: &[Triangle]) -> u32 {
    let cell = unpack_point(pairs[(2 * index) as usize]);
    let (a, b, c) = in_cells(params.lower, &triangles[pairs[(2 * index + 1) as usize] as usize]);
    let mut mask = 0u32;
    let mut number = 0;
    while number < 8 {
        let voxel = child(cell, number);
        let met = if params.thin != 0 {
            overlaps_thin(a, b, c, voxel)
        } else {
            overlaps_conservative(a, b, c, voxel)
        };
        if met {
            mask |= 1 << number;
        }
        number += 1;
    }
    mask
}

/// Returns the number of bits of mask `index`.
#[inline]
pub fn mask_counts(index: u32, params: &VoxeliseParams, masks: &[u32]) -> u32 {
    let _ = params;
    bit_count(masks[index as usize])
}

/// Returns word `index` of the children's pairs; `starts` scans the masks' counts.
#[inline]
pub fn child_pairs(index: u32, params: &VoxeliseParams, starts: &[u32], masks: &[u32], pairs: &[u32]) -> u32 {
    let item = index / 2;
    let parent = owner(starts, params.pairs, item);
    if index & 1 == 1 {
        return pairs[(2 * parent + 1) as usize];
    }
    let number = nth_bit(masks[parent as usize], item - starts[parent as usize]);
    pack_point(child(unpack_point(pairs[(2 * parent) as usize]), number))
}

/// Sets the bit of pair `index`'s voxel among the points of level 0, two words for each block of the level.
#[inline]
pub fn mark_voxels(index: u32, params: &VoxeliseParams, pairs: &[u32], output: &mut impl Accumulate) {
    let point = unpack_point(pairs[(2 * index) as usize]);
    let first = level_offset(params.depth, 0);
    let block = block_of(params.depth, 0, point) - first;
    let bit = point_bit(point);
    output.or(2 * block + bit / 32, 1 << (bit & 31));
}

/// Puts word `index` in its place in a larger buffer, which starts cleared.
#[inline]
pub fn place_words(index: u32, params: &WordParams, words: &[u32], output: &mut impl Accumulate) {
    if index < params.count {
        output.or(params.offset + index, words[index as usize]);
    }
}
