//! What is the running sum of a list of counts, and which items carry a flag?
//!
//! An exclusive scan is three passes over blocks of [`SCAN_BLOCK`] items, repeated on the block sums while there
//! is more than one block. All integer: the same on every backend.

use super::Accumulate;

/// Items in a block of the scan.
pub const SCAN_BLOCK: u32 = 32;

gpu_struct! {
    /// Parameters of the scan passes.
    pub struct ScanParams {
        /// Number of values to scan.
        pub count: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }

    /// Parameters of [`compact_indices`].
    pub struct CompactParams {
        /// Number of flags.
        pub count: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

/// Returns the sum of block `index` of the values, modulo 2³²; the last block may be short.
#[inline]
pub fn block_sums(index: u32, params: &ScanParams, values: &[u32]) -> u32 {
    sum_range(values, index * SCAN_BLOCK, block_end(index, params.count))
}

/// Returns the sum of the values of the same block before `index`.
#[inline]
pub fn scan_blocks(index: u32, params: &ScanParams, values: &[u32]) -> u32 {
    let _ = params;
    sum_range(values, index / SCAN_BLOCK * SCAN_BLOCK, index)
}

/// Returns the sum within the block plus the scanned sum of the blocks before: the exclusive scan.
#[inline]
pub fn add_block_offsets(index: u32, params: &ScanParams, within: &[u32], offsets: &[u32]) -> u32 {
    let _ = params;
    within[index as usize].wrapping_add(offsets[(index / SCAN_BLOCK) as usize])
}

/// Writes `index` to its place in the compacted list when its flag is not 0; `places` is the scan of the flags (0 or 1).
///
/// The output must be cleared first.
#[inline]
pub fn compact_indices(
    index: u32,
    params: &CompactParams,
    flags: &[u32],
    places: &[u32],
    output: &mut impl Accumulate,
) {
    if index < params.count && flags[index as usize] != 0 {
        output.or(places[index as usize], index);
    }
}

/// Returns which of `count` owners item `index` belongs to, with the exclusive scan of their counts; it has some.
#[inline]
pub fn owner(starts: &[u32], count: u32, index: u32) -> u32 {
    let mut low = 0;
    let mut high = count;
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        if starts[middle as usize] <= index {
            low = middle;
        } else {
            high = middle;
        }
    }
    low
}

#[inline]
fn block_end(block: u32, count: u32) -> u32 {
    let end = (block + 1) * SCAN_BLOCK;
    if end < count { end } else { count }
}

#[inline]
fn sum_range(values: &[u32], begin: u32, end: u32) -> u32 {
    let mut sum = 0u32;
    for i in begin..end {
        sum = sum.wrapping_add(values[i as usize]);
    }
    sum
}
