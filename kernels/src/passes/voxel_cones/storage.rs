//! How are optical depths and radiances stored in words?

use crate::math::{clamp, div, exp2, floor, log2, max, min, sqrt, to_u32};
use glam::Vec3;

/// The largest optical depth of a voxel: 3e-4 of the light gets through.
pub const MAX_OPTICAL_DEPTH: f32 = 8.0;

/// Returns optical depths along x, y and z as one word, ten bits each of their roots: steps of 0.006 at 1, 8e-6 at 0.
///
/// 0 and [`MAX_OPTICAL_DEPTH`] are exact; what is outside is clamped, NaN counts as 0.
#[inline]
pub fn pack_depths(depths: Vec3) -> u32 {
    ten_bits(depths.x) | (ten_bits(depths.y) << 10) | (ten_bits(depths.z) << 20)
}

#[inline]
fn ten_bits(depth: f32) -> u32 {
    to_u32(floor(sqrt(clamp(depth, 0.0, MAX_OPTICAL_DEPTH) * 0.125) * 1023.0 + 0.5))
}

/// Returns the depths that [`pack_depths`] packed.
#[inline]
pub fn unpack_depths(word: u32) -> Vec3 {
    // 8/1023²
    const SCALE: f32 = 7.644_318e-6;
    let x = (word & 1023) as f32;
    let y = ((word >> 10) & 1023) as f32;
    let z = ((word >> 20) & 1023) as f32;
    Vec3::new(x * x * SCALE, y * y * SCALE, z * z * SCALE)
}

/// The largest radiance that a word holds.
pub const MAX_RADIANCE: f32 = 65_408.0;

/// Returns a radiance as one word: nine bits for each colour, five for a common exponent (RGB9E5); 0.2 % of the largest.
///
/// Clamped to [0, 65408]; NaN counts as 0.
#[inline]
pub fn pack_radiance(radiance: Vec3) -> u32 {
    let r = clamp(radiance.x, 0.0, MAX_RADIANCE);
    let g = clamp(radiance.y, 0.0, MAX_RADIANCE);
    let b = clamp(radiance.z, 0.0, MAX_RADIANCE);
    let largest = max(max(r, g), b);
    // The smallest step is 2⁻²⁴: nothing is left below half of it.
    if !(largest > 1.0e-9) {
        return 0;
    }
    let mut exponent = floor(clamp(log2(largest), -16.0, 15.0)) + 1.0;
    let mut scale = exp2(9.0 - exponent);
    // Rounding up to 512 needs the next exponent.
    if floor(largest * scale + 0.5) >= 512.0 {
        exponent += 1.0;
        scale *= 0.5;
    }
    let part = |x: f32| to_u32(min(floor(x * scale + 0.5), 511.0));
    part(r) | (part(g) << 9) | (part(b) << 18) | (to_u32(exponent + 15.0) << 27)
}

/// Returns the radiance that [`pack_radiance`] packed.
#[inline]
pub fn unpack_radiance(word: u32) -> Vec3 {
    // 2^(exponent − 15 − 9), by the bits of the exponent.
    let scale = f32::from_bits(((word >> 27) + 127 - 24) << 23);
    Vec3::new(
        (word & 511) as f32 * scale,
        ((word >> 9) & 511) as f32 * scale,
        ((word >> 18) & 511) as f32 * scale,
    )
}

/// How voxels' radiance is stored: nine bits for each colour and a common exponent (RGB9E5), one word.
pub const SHARED_EXPONENT: u32 = 0;
/// Eight bits for each colour, from 0 to [`FIXED_RANGE`], one word.
pub const UNORM8: u32 = 1;
/// Ten bits for each colour, from 0 to [`FIXED_RANGE`], one word.
pub const FIXED: u32 = 2;
/// IEEE binary16, two words.
pub const HALF: u32 = 3;
/// IEEE binary32, three words.
pub const FLOAT: u32 = 4;
/// The largest radiance in a fixed number of equal steps, in stored units, of which a typical one is 1.
pub const FIXED_RANGE: f32 = 64.0;
/// The storage's place in the flags of parameters.
pub const STORAGE_SHIFT: u32 = 8;

/// Returns the storage that the flags of parameters name.
#[inline]
pub fn storage_of(flags: u32) -> u32 {
    flags >> STORAGE_SHIFT
}

/// Returns the words that a radiance takes.
#[inline]
pub fn words_of(storage: u32) -> u32 {
    if storage == FLOAT {
        3
    } else if storage == HALF {
        2
    } else {
        1
    }
}

/// Returns a number of [0, 65408] as binary16, rounded to nearest, ties away from 0 below 2⁻¹⁴ and to even above.
#[inline]
fn half(x: f32) -> u32 {
    // 2⁻¹⁴ and 2²⁴
    if x < 6.103_515_6e-5 {
        return to_u32(floor(x * 16_777_216.0 + 0.5));
    }
    let bits = x.to_bits();
    // The exponent's bias falls from 127 to 15.
    ((bits + 0xFFF + ((bits >> 13) & 1)) >> 13) - (112 << 10)
}

/// Returns the number of a binary16 without sign, which is finite.
#[inline]
fn from_half(half: u32) -> f32 {
    if half < 0x400 {
        // 2⁻²⁴
        return half as f32 * 5.960_464_5e-8;
    }
    f32::from_bits((half + (112 << 10)) << 13)
}

/// Equal steps from 0 to [`FIXED_RANGE`].
#[inline]
fn in_steps(radiance: Vec3, most: f32, bits: u32) -> u32 {
    // 1/64
    let scale = most * 0.015_625;
    let part = |x: f32| to_u32(min(floor(x * scale + 0.5), most));
    part(radiance.x) | (part(radiance.y) << bits) | (part(radiance.z) << (2 * bits))
}

/// Returns word `word` of a radiance in a storage; clamped to [0, 65408], NaN counts as 0.
#[inline]
pub fn radiance_word(storage: u32, radiance: Vec3, word: u32) -> u32 {
    if storage == SHARED_EXPONENT {
        return pack_radiance(radiance);
    }
    let r = clamp(radiance.x, 0.0, MAX_RADIANCE);
    let g = clamp(radiance.y, 0.0, MAX_RADIANCE);
    let b = clamp(radiance.z, 0.0, MAX_RADIANCE);
    if storage == UNORM8 {
        in_steps(Vec3::new(r, g, b), 255.0, 8)
    } else if storage == FIXED {
        in_steps(Vec3::new(r, g, b), 1023.0, 10)
    } else if storage == HALF {
        if word == 0 { half(r) | (half(g) << 16) } else { half(b) }
    } else if word == 0 {
        r.to_bits()
    } else if word == 1 {
        g.to_bits()
    } else {
        b.to_bits()
    }
}

/// Returns radiance `entry` of a buffer in a storage.
#[inline]
pub fn load_radiance(radiance: &[u32], storage: u32, entry: u32) -> Vec3 {
    let at = words_of(storage) * entry;
    let first = radiance[at as usize];
    if storage == SHARED_EXPONENT {
        unpack_radiance(first)
    } else if storage == UNORM8 {
        // 64/255
        Vec3::new((first & 255) as f32, ((first >> 8) & 255) as f32, ((first >> 16) & 255) as f32)
            * 0.250_980_4
    } else if storage == FIXED {
        // 64/1023
        Vec3::new((first & 1023) as f32, ((first >> 10) & 1023) as f32, ((first >> 20) & 1023) as f32)
            * 6.256_109_5e-2
    } else if storage == HALF {
        let second = radiance[(at + 1) as usize];
        Vec3::new(from_half(first & 0xFFFF), from_half(first >> 16), from_half(second & 0xFFFF))
    } else {
        let (second, third) = (radiance[(at + 1) as usize], radiance[(at + 2) as usize]);
        Vec3::new(f32::from_bits(first), f32::from_bits(second), f32::from_bits(third))
    }
}

/// Returns a / b, 0 where b is not above 2⁻⁶⁰.
#[inline]
pub(super) fn ratio(a: Vec3, b: f32) -> Vec3 {
    if b > 8.673_617e-19 { Vec3::new(div(a.x, b), div(a.y, b), div(a.z, b)) } else { Vec3::ZERO }
}
