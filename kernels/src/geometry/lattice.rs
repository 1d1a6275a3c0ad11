//! Where is the voxel of a sparse pyramid, by its place on the lattice?
//!
//! A pyramid of depth D has levels 0 (2^D voxel edges along each axis) to D (one). Voxels are centred on lattice points:
//! point i of level l lies at i·2^l edges of level 0, 0 ≤ i ≤ 2^(D−l). A level is cut into blocks of 4³ points; three
//! words of each block are stored densely: 64 bits that say which points are voxels, and the number of its first
//! voxel. A voxel is found with three loads from any place: no descent, neighbours cost the same. Coarse levels stand
//! first.

use glam::UVec3;

/// The number of a lattice point that is no voxel.
pub const NO_VOXEL: u32 = 0xFFFF_FFFF;
/// The largest depth: 512 edges.
pub const MAX_DEPTH: u32 = 9;
/// Words per block: points 0 to 31, points 32 to 63, number of the first voxel.
pub const BLOCK_WORDS: u32 = 3;

/// Returns the number of blocks along an axis of a level, for level ≤ depth.
#[inline]
pub fn blocks_along(depth: u32, level: u32) -> u32 {
    (1 << (depth - level)) / 4 + 1
}

/// Returns the number of blocks before those of a level: of all coarser ones.
///
/// Σ (2^i + 1)³ over the coarser levels, whose two coarsest have one block each.
#[inline]
pub fn level_offset(depth: u32, level: u32) -> u32 {
    let above = depth - level;
    if above < 2 {
        return above;
    }
    let m = above - 2;
    let p = 1u32 << m;
    let square = p * p;
    let cube = square * p;
    2 + (cube - 1) / 7 + (square - 1) + 3 * (p - 1) + m
}

/// Returns the number of blocks of a whole pyramid.
#[inline]
pub fn block_count(depth: u32) -> u32 {
    let side = blocks_along(depth, 0);
    level_offset(depth, 0) + side * side * side
}

/// Returns how many bits of a word are set.
#[inline]
pub fn bit_count(word: u32) -> u32 {
    let pairs = word - ((word >> 1) & 0x5555_5555);
    let fours = (pairs & 0x3333_3333) + ((pairs >> 2) & 0x3333_3333);
    let eights = (fours + (fours >> 4)) & 0x0F0F_0F0F;
    eights.wrapping_mul(0x0101_0101) >> 24
}

/// Returns the position of set bit `n` of a word, counted from the lowest, 0 first; 31 if there are fewer.
#[inline]
pub fn nth_bit(word: u32, n: u32) -> u32 {
    let mut at = 0;
    let mut left = n;
    let mut rest = word;
    // Halves, quarters …: five steps.
    let mut width = 16;
    while width > 0 {
        let count = bit_count(rest & ((1 << width) - 1));
        if count <= left {
            left -= count;
            at += width;
            rest >>= width;
        }
        width /= 2;
    }
    at
}

/// Returns the bit of a point within its block, 0 to 63.
#[inline]
pub fn point_bit(point: UVec3) -> u32 {
    ((point.z & 3) << 4) | ((point.y & 3) << 2) | (point.x & 3)
}

/// Returns the block of a point of a level, counted over the whole pyramid.
#[inline]
pub fn block_of(depth: u32, level: u32, point: UVec3) -> u32 {
    let side = blocks_along(depth, level);
    level_offset(depth, level) + (((point.z >> 2) * side + (point.y >> 2)) * side + (point.x >> 2))
}

/// Returns the number of the voxel at a lattice point of a level; [`NO_VOXEL`] where there is none, or off the lattice.
///
/// Coordinates below 0 wrap to large ones, which are off the lattice.
#[inline]
pub fn voxel_at(blocks: &[u32], depth: u32, level: u32, point: UVec3) -> u32 {
    let last = 1u32 << (depth - level);
    if point.x > last || point.y > last || point.z > last {
        return NO_VOXEL;
    }
    let at = BLOCK_WORDS * block_of(depth, level, point);
    let bit = point_bit(point);
    let low = blocks[at as usize];
    let (word, before) = if bit < 32 { (low, 0) } else { (blocks[(at + 1) as usize], bit_count(low)) };
    let mask = 1u32 << (bit & 31);
    if word & mask == 0 {
        NO_VOXEL
    } else {
        blocks[(at + 2) as usize] + before + bit_count(word & (mask - 1))
    }
}

/// Returns the lattice point that a voxel of a level stands at: the inverse of [`voxel_at`].
#[inline]
pub fn point_of(blocks: &[u32], depth: u32, level: u32, voxel: u32) -> UVec3 {
    let side = blocks_along(depth, level);
    let first = level_offset(depth, level);
    let mut low = first;
    let mut high = first + side * side * side;
    // The last block whose first voxel is not above; empty blocks share theirs with the next.
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        if blocks[(BLOCK_WORDS * middle + 2) as usize] <= voxel {
            low = middle;
        } else {
            high = middle;
        }
    }
    let at = BLOCK_WORDS * low;
    let within = voxel - blocks[(at + 2) as usize];
    let word = blocks[at as usize];
    let count = bit_count(word);
    let bit = if within < count {
        nth_bit(word, within)
    } else {
        32 + nth_bit(blocks[(at + 1) as usize], within - count)
    };
    let block = low - first;
    let row = block / side;
    let layer = row / side;
    UVec3::new(
        4 * (block - row * side) + (bit & 3),
        4 * (row - layer * side) + ((bit >> 2) & 3),
        4 * layer + (bit >> 4),
    )
}

/// Returns a point as one word, ten bits for each coordinate.
#[inline]
pub fn pack_point(point: UVec3) -> u32 {
    point.x | (point.y << 10) | (point.z << 20)
}

/// Returns the point that [`pack_point`] packed.
#[inline]
pub fn unpack_point(word: u32) -> UVec3 {
    UVec3::new(word & 1023, (word >> 10) & 1023, word >> 20)
}
