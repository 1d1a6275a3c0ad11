//! Which of several sets of directions does a pixel take, so that its neighbourhood has them all?

/// Returns the part of a turn, of sixteenths, by which pixel (x, y) turns its directions.
///
/// Each of any 4 × 4 neighbours has another; the order is Bayer's, so that those beside each other differ much.
#[inline]
pub fn interleaved_turn(x: u32, y: u32) -> f32 {
    let z = x ^ y;
    let order = ((z & 1) << 3) | ((y & 1) << 2) | (z & 2) | ((y & 2) >> 1);
    order as f32 * 0.0625
}
