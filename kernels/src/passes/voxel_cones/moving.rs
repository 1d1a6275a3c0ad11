//! How do moving meshes join the voxels of what stands still? VCT §4.2.2.
//!
//! The standing part's pyramid is read, never written: each frame's pyramid has its points and those of the moving
//! triangles, takes its sums over, and filters anew only voxels above moving ones. The result is that of voxelising all at once.

use super::build::{LEAF_WORDS, PyramidParams, filtered_depths};
use crate::geometry::lattice::{BLOCK_WORDS, NO_VOXEL, block_of, point_bit, unpack_point, voxel_at};

/// Returns word `index` of the marks of all levels, two for each block: the standing part's `blocks` and the moving `marks`.
#[inline]
pub fn merge_marks(index: u32, params: &PyramidParams, blocks: &[u32], marks: &[u32]) -> u32 {
    let _ = params;
    blocks[(BLOCK_WORDS * (index / 2) + (index & 1)) as usize] | marks[index as usize]
}

/// Returns word `index` of the leaves' sums as far as the standing part has them; `params.child_first` is its first leaf.
#[inline]
pub fn carry_leaves(index: u32, params: &PyramidParams, points: &[u32], blocks: &[u32], sums: &[u32]) -> u32 {
    let leaf = index / LEAF_WORDS;
    let k = index - LEAF_WORDS * leaf;
    let voxel = voxel_at(blocks, params.depth, 0, unpack_point(points[leaf as usize]));
    if voxel == NO_VOXEL { 0 } else { sums[(LEAF_WORDS * (voxel - params.child_first) + k) as usize] }
}

/// Returns the optical depths of voxel `index` of a level above the leaves: filtered where a moving voxel lies below
/// it, the standing part's elsewhere.
#[inline]
pub fn update_depths(
    index: u32,
    params: &PyramidParams,
    points: &[u32],
    blocks: &[u32],
    children: &[u32],
    standing_blocks: &[u32],
    standing_depths: &[u32],
    marks: &[u32],
) -> u32 {
    let point = unpack_point(points[index as usize]);
    let bit = point_bit(point);
    let at = 2 * block_of(params.depth, params.level, point) + bit / 32;
    let standing = voxel_at(standing_blocks, params.depth, params.level, point);
    if (marks[at as usize] >> (bit & 31)) & 1 == 0 && standing != NO_VOXEL {
        standing_depths[standing as usize]
    } else {
        filtered_depths(params, point, blocks, children)
    }
}
