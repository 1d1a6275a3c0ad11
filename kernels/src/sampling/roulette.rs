//! How many samples does a primitive get when it has earned a fraction of one?

use crate::math::{floor, is_finite, saturate, to_u32};

/// Returns whether a hash accepts an event of probability p: never at 0 and NaN, always from 1 on.
///
/// Exact on the 2²⁴ values of the upper bits. VF prints the comparison the other way round.
#[inline]
pub fn accept(hash: u32, p: f32) -> bool {
    (hash >> 8) < to_u32(floor(saturate(p) * 16_777_216.0))
}

/// Returns floor(expected) plus one with the probability of the remainder: `expected` samples on average.
///
/// `expected` is area × density; 0 for negative, NaN and infinite. From 2²⁴ on it is an integer by itself;
/// the result saturates at 4 294 967 040.
#[inline]
pub fn sample_count(expected: f32, hash: u32) -> u32 {
    if !is_finite(expected) || !(expected > 0.0) {
        return 0;
    }
    let whole = floor(expected);
    let extra = if accept(hash, expected - whole) { 1 } else { 0 };
    to_u32(whole) + extra
}
