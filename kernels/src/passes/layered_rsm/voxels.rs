//! Where is something, in a bit for each voxel and a byte for each above? LRSM §5.
//!
//! Dense: 2^depth voxels along each axis, then levels of half the side, each in its place behind the bits. A byte holds either the
//! mean of the eight voxels below, as published, or for each axis which share of the rays along it is stopped, in steps of
//! a fifth: 6³ = 216 values. A wall then stays opaque at every level; as a mean it fades by half from one to the next.

use super::lookup::Maps;
use crate::geometry::lattice::unpack_point;
use crate::math::{abs, floor, ln_one_plus, max, min, to_u32};
use crate::passes::Accumulate;
use crate::passes::scene::{Material, Triangle};
use crate::passes::voxel_cones::build::{PyramidParams, hole_in};
use crate::passes::voxel_cones::march::{Medium, Sample};
use crate::passes::voxel_cones::storage::MAX_OPTICAL_DEPTH;
use glam::{UVec3, Vec3};

gpu_struct! {
    /// Parameters of [`shrink_voxels`].
    pub struct ShrinkParams {
        /// Depth: 2^depth voxels along each axis.
        pub depth: u32,
        /// The level to make, from 1.
        pub level: u32,
        /// 1 for the mean, 0 for what is covered along each axis.
        pub mean: u32,
        /// Padding.
        pub pad: u32,
    }
}

/// Returns the number of words of all levels: 2^(3·depth) bits, then bytes.
#[inline]
pub fn voxel_words(depth: u32) -> u32 {
    level_word(depth, depth) + 1
}

/// Returns the first word of a level; for level ≥ 1 bytes, four a word.
#[inline]
pub fn level_word(depth: u32, level: u32) -> u32 {
    if level == 0 {
        return 0;
    }
    let bits = 1u32 << (3 * depth);
    // Σ 8^(depth − i) for i from 1 below `level`.
    let above = 1u32 << (3 * (depth - level + 1));
    bits / 32 + (bits - above) / 28
}

/// The number of a voxel in its level.
#[inline]
fn number(depth: u32, level: u32, point: UVec3) -> u32 {
    let bits = depth - level;
    (((point.z << bits) | point.y) << bits) | point.x
}

/// Sets the bit of pair `index`'s voxel, unless its triangle has a hole there.
#[inline]
pub fn mark_bits(
    index: u32,
    params: &PyramidParams,
    pairs: &[u32],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
    output: &mut impl Accumulate,
) {
    let point = unpack_point(pairs[(2 * index) as usize]);
    let t = &triangles[pairs[(2 * index + 1) as usize] as usize];
    if !hole_in(params, point, t, materials, texels) {
        let at = number(params.depth, 0, point);
        output.or(at / 32, 1 << (at & 31));
    }
}

/// The shares of a byte, in fifths along each axis.
#[inline]
fn fifths(code: u32) -> Vec3 {
    Vec3::new((code % 6) as f32, (code / 6 % 6) as f32, (code / 36) as f32) * 0.2
}

/// Which share of rays along each axis is stopped, as a byte; halves are rounded down, for no fog is to stay of what fades.
#[inline]
pub fn pack_cover(cover: Vec3) -> u32 {
    let part = |x: f32| to_u32(floor(min(max(x, 0.0), 1.0) * 5.0 + 0.499_9));
    part(cover.x) + 6 * part(cover.y) + 36 * part(cover.z)
}

/// Returns what [`pack_cover`] packed, within a tenth; 0 and 1 are exact.
#[inline]
pub fn unpack_cover(byte: u32) -> Vec3 {
    fifths(byte & 255)
}

/// 1/255
const BYTE: f32 = 3.921_568_6e-3;

/// What a voxel covers along each axis, or its mean for all three, from the words of its level.
#[inline]
fn cover_at(depth: u32, level: u32, mean: bool, voxels: &[u32], point: UVec3) -> Vec3 {
    let at = number(depth, level, point);
    if level == 0 {
        let bit = (voxels[(at / 32) as usize] >> (at & 31)) & 1;
        return Vec3::splat(bit as f32);
    }
    let byte = (voxels[(at / 4) as usize] >> (8 * (at & 3))) & 255;
    if mean { Vec3::splat(byte as f32 * BYTE) } else { unpack_cover(byte) }
}

/// Returns four voxels of level `params.level` as a word, from the words of the level below.
#[inline]
pub fn shrink_voxels(index: u32, params: &ShrinkParams, below: &[u32]) -> u32 {
    let bits = params.depth - params.level;
    let all = 1u32 << (3 * bits);
    let side = (1u32 << bits) - 1;
    let mut word = 0;
    for k in 0..4 {
        let at = 4 * index + k;
        if at < all {
            let point = UVec3::new(at & side, (at >> bits) & side, at >> (2 * bits));
            word |= shrunk(params, below, point) << (8 * k);
        }
    }
    word
}

/// The byte of a voxel from the eight below it.
#[inline]
fn shrunk(params: &ShrinkParams, below: &[u32], point: UVec3) -> u32 {
    let mean = params.mean != 0;
    let mut cover = [Vec3::ZERO; 8];
    let mut sum = 0.0;
    for k in 0..8 {
        let child = UVec3::new(2 * point.x + (k & 1), 2 * point.y + ((k >> 1) & 1), 2 * point.z + (k >> 2));
        let one = cover_at(params.depth, params.level - 1, mean, below, child);
        sum += one.x;
        cover[k as usize] = one;
    }
    if mean {
        return to_u32(floor(sum * (0.125 * 255.0) + 0.5));
    }
    // The larger of two behind each other: what is one wall stays one.
    let x = (max(cover[0].x, cover[1].x) + max(cover[2].x, cover[3].x))
        + (max(cover[4].x, cover[5].x) + max(cover[6].x, cover[7].x));
    let y = (max(cover[0].y, cover[2].y) + max(cover[1].y, cover[3].y))
        + (max(cover[4].y, cover[6].y) + max(cover[5].y, cover[7].y));
    let z = (max(cover[0].z, cover[4].z) + max(cover[1].z, cover[5].z))
        + (max(cover[2].z, cover[6].z) + max(cover[3].z, cover[7].z));
    pack_cover(Vec3::new(x, y, z) * 0.25)
}

/// The optical depth that stops this share of the light.
#[inline]
fn depth_of(share: f32) -> f32 {
    if share >= 0.999_6 { MAX_OPTICAL_DEPTH } else { -ln_one_plus(-share) }
}

/// The optical depth of a voxel that covers this many fifths: −2 ln(1 − n/5), twice what stops that share of the light. What
/// a slanted surface leaves uncovered its next voxel covers; were the two as if at random, a quarter would get through.
#[inline]
fn depth_of_fifths(n: u32) -> f32 {
    if n == 0 {
        0.0
    } else if n == 5 {
        MAX_OPTICAL_DEPTH
    } else if n == 1 {
        0.446_287_1
    } else if n == 2 {
        1.021_651_2
    } else if n == 3 {
        1.832_581_5
    } else {
        3.218_876
    }
}

/// The optical depths of a voxel along the axes; 0 for an empty one.
#[inline]
fn depths_at(depth: u32, level: u32, mean: bool, voxels: &[u32], point: UVec3) -> Vec3 {
    let at = number(depth, level, point);
    if level == 0 {
        let bit = (voxels[(at / 32) as usize] >> (at & 31)) & 1;
        return Vec3::splat(bit as f32 * MAX_OPTICAL_DEPTH);
    }
    let byte = (voxels[(level_word(depth, level) + at / 4) as usize] >> (8 * (at & 3))) & 255;
    if byte == 0 {
        Vec3::ZERO
    } else if mean {
        Vec3::splat(depth_of(byte as f32 * BYTE))
    } else {
        Vec3::new(depth_of_fifths(byte % 6), depth_of_fifths(byte / 6 % 6), depth_of_fifths(byte / 36))
    }
}

/// Binary voxels with their levels: they stop light, and tell where they are.
#[derive(Clone, Copy)]
pub struct Occluders<'a> {
    /// log₂ of the voxels along each side.
    pub depth: u32,
    /// Whether levels hold means.
    pub mean: bool,
    /// Bits, then levels of bytes.
    pub voxels: &'a [u32],
}

impl Medium for Occluders<'_> {
    const CENTRE: f32 = 0.5;

    #[inline]
    fn voxel(&self, level: u32, point: UVec3, direction: Vec3, cone: f32) -> Sample {
        let _ = cone;
        let side = 1u32 << (self.depth - level);
        if point.x >= side || point.y >= side || point.z >= side {
            return Sample::EMPTY;
        }
        let depths = depths_at(self.depth, level, self.mean, self.voxels, point);
        let density = if self.mean {
            depths.x
        } else {
            (depths.x * abs(direction.x) + depths.y * abs(direction.y)) + depths.z * abs(direction.z)
        };
        if density <= 0.0 {
            return Sample::EMPTY;
        }
        // Where it is, so that the mean of many says where the surface is that they are of.
        let edge = (1u32 << level) as f32;
        let centre = (Vec3::new(point.x as f32, point.y as f32, point.z as f32) + Vec3::splat(0.5)) * edge;
        Sample { density, carried: centre * density }
    }

    #[inline]
    fn light(&self, carried: Vec3, direction: Vec3, width: f32) -> Vec3 {
        let _ = (carried, direction, width);
        Vec3::ZERO
    }
}

/// Occluders, and the maps that say what surfaces within them send.
#[derive(Clone, Copy)]
pub struct BinaryVoxels<'a> {
    /// The voxels.
    pub occluders: Occluders<'a>,
    /// The maps.
    pub maps: Maps<'a>,
}

impl Medium for BinaryVoxels<'_> {
    const CENTRE: f32 = Occluders::CENTRE;

    #[inline]
    fn voxel(&self, level: u32, point: UVec3, direction: Vec3, cone: f32) -> Sample {
        self.occluders.voxel(level, point, direction, cone)
    }

    #[inline]
    fn light(&self, carried: Vec3, direction: Vec3, width: f32) -> Vec3 {
        self.maps.radiance(carried, direction, width)
    }
}
