//! In which order do (key, index) pairs stand when sorted by key, ties by index?
//!
//! A stable radix sort, four bits at a time: count the digits per block, scan the counts, place each item. Items
//! are interleaved as key, index, key, index, …

use super::Accumulate;

/// Items in a block of the sort.
pub const SORT_BLOCK: u32 = 128;
/// Values of a digit.
pub const DIGITS: u32 = 16;

gpu_struct! {
    /// Parameters of the sort passes.
    pub struct DigitParams {
        /// Number of items.
        pub count: u32,
        /// Position of the digit's lowest bit: 0, 4, … 28.
        pub shift: u32,
        /// Number of blocks, ⌈count / [`SORT_BLOCK`]⌉.
        pub blocks: u32,
        /// Padding.
        pub pad: u32,
    }
}

/// The digit of item `i`.
#[inline]
fn digit(items: &[u32], i: u32, shift: u32) -> u32 {
    (items[(2 * i) as usize] >> shift) & (DIGITS - 1)
}

/// Adds item `index` to the count of (its digit, its block), at `digit · blocks + block`; the output starts cleared.
#[inline]
pub fn count_digits(index: u32, params: &DigitParams, items: &[u32], output: &mut impl Accumulate) {
    if index < params.count {
        output.add(digit(items, index, params.shift) * params.blocks + index / SORT_BLOCK, 1);
    }
}

/// Writes item `index` behind all of smaller digit, and of the same digit before it; the output starts cleared.
///
/// `offsets` is the exclusive scan of the counts of [`count_digits`].
#[inline]
pub fn place_by_digit(
    index: u32,
    params: &DigitParams,
    items: &[u32],
    offsets: &[u32],
    output: &mut impl Accumulate,
) {
    if index >= params.count {
        return;
    }
    let own = digit(items, index, params.shift);
    let block = index / SORT_BLOCK;
    let mut place = offsets[(own * params.blocks + block) as usize];
    for i in block * SORT_BLOCK..index {
        if digit(items, i, params.shift) == own {
            place += 1;
        }
    }
    output.or(2 * place, items[(2 * index) as usize]);
    output.or(2 * place + 1, items[(2 * index + 1) as usize]);
}
