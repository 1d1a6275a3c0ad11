//! What is the sum of many vectors, in one order that every backend follows?

use glam::Vec4;

/// Values that one work item adds up.
pub const REDUCE_BLOCK: u32 = 8;

gpu_struct! {
    /// Parameters of [`reduce_sum`].
    pub struct ReduceParams {
        /// Number of values to add up.
        pub count: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

/// Returns the sum of the [`REDUCE_BLOCK`] values of block `index` as a binary tree, missing ones counting as 0.
///
/// Run again on its own output until one value is left: the tree depends on `count` alone, so the sum is
/// reproducible, and its error grows with the logarithm of `count`.
#[inline]
pub fn reduce_sum(index: u32, params: &ReduceParams, values: &[Vec4]) -> Vec4 {
    let first = index * REDUCE_BLOCK;
    let count = params.count;
    let a = value(values, first, count) + value(values, first + 1, count);
    let b = value(values, first + 2, count) + value(values, first + 3, count);
    let c = value(values, first + 4, count) + value(values, first + 5, count);
    let d = value(values, first + 6, count) + value(values, first + 7, count);
    (a + b) + (c + d)
}

#[inline]
fn value(values: &[Vec4], i: u32, count: u32) -> Vec4 {
    if i < count { values[i as usize] } else { Vec4::ZERO }
}
