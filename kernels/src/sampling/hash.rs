//! Which random number belongs to an index or a place, the same on every backend and in every frame?

use crate::math::{floor, is_nan};
use glam::Vec3;

/// Returns a well-mixed bijection of the 32-bit integers: PCG RXS-M-XS (Jarzynski and Olano 2020).
#[inline]
pub fn hash(x: u32) -> u32 {
    let state = x.wrapping_mul(747_796_405).wrapping_add(2_891_336_453);
    let word = ((state >> ((state >> 28) + 4)) ^ state).wrapping_mul(277_803_737);
    (word >> 22) ^ word
}

/// Returns a hash of both arguments, in order; for a fixed `seed` a bijection of `value`.
#[inline]
pub fn combine(seed: u32, value: u32) -> u32 {
    hash(hash(seed).wrapping_add(value))
}

/// Returns a number in [0, 1 − 2⁻²⁴], every multiple of 2⁻²⁴ equally often, from the upper 24 bits.
#[inline]
pub fn unit_float(hash: u32) -> f32 {
    // 2⁻²⁴
    (hash >> 8) as f32 * 5.960_464_5e-8
}

/// Returns a hash of the cell floor(position · cells_per_length) that holds a position.
///
/// Positions in one cell share the hash, so the last bits of a position do not decide it. −0 and +0 are one
/// cell, all NaN components count as one value, ±∞ as cells of their own.
#[inline]
pub fn position_hash(position: Vec3, cells_per_length: f32) -> u32 {
    let x = cell_bits(position.x * cells_per_length);
    let y = cell_bits(position.y * cells_per_length);
    let z = cell_bits(position.z * cells_per_length);
    combine(combine(hash(x), y), z)
}

/// The bits of floor(x) as f32: unlike an integer they tell huge cells apart as well.
#[inline]
fn cell_bits(x: f32) -> u32 {
    if is_nan(x) {
        return 0x7FC0_0000;
    }
    let cell = floor(x);
    if cell == 0.0 { 0 } else { cell.to_bits() }
}
