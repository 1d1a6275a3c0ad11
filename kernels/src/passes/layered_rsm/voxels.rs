//! Where is something, in a bit for each voxel and two bytes for each above? LRSM §5.
//!
//! Dense: 2^depth voxels along each axis, then levels of half the side, each in its place behind the bits. The first byte holds either the
//! mean of the eight voxels below, as published, or for each axis which share of the rays along it is stopped, in steps of
//! a fifth: 6³ = 216 values. A wall then stays opaque at every level; as a mean it fades by half from one to the next. The second
//! says in the same steps where in the voxel that is: half a coarse voxel off, a wall would be lit from elsewhere.

use super::lookup::Maps;
use crate::geometry::lattice::unpack_point;
use crate::math::{abs, div, floor, ln_one_plus, max, min, to_u32};
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

/// Returns the number of words of all levels: 2^(3·depth) bits, then two bytes each.
#[inline]
pub fn voxel_words(depth: u32) -> u32 {
    level_word(depth, depth) + 1
}

/// Returns the first word of a level; for level ≥ 1 two voxels a word.
#[inline]
pub fn level_word(depth: u32, level: u32) -> u32 {
    if level == 0 {
        return 0;
    }
    let bits = 1u32 << (3 * depth);
    // Σ 8^(depth − i) for i from 1 below `level`.
    let above = 1u32 << (3 * (depth - level + 1));
    bits / 32 + (bits - above) / 14
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

/// Three shares as a byte, in fifths, with what is added before rounding down.
#[inline]
fn pack_fifths(shares: Vec3, added: f32) -> u32 {
    let part = |x: f32| to_u32(floor(min(max(x, 0.0), 1.0) * 5.0 + added));
    part(shares.x) + 6 * part(shares.y) + 36 * part(shares.z)
}

/// Which share of rays along each axis is stopped, as a byte; halves are rounded down, for no fog is to stay of what fades.
#[inline]
pub fn pack_cover(cover: Vec3) -> u32 {
    pack_fifths(cover, 0.499_9)
}

/// Returns what [`pack_cover`] packed, within a tenth; 0 and 1 are exact.
#[inline]
pub fn unpack_cover(byte: u32) -> Vec3 {
    fifths(byte & 255)
}

/// 1/255
const BYTE: f32 = 3.921_568_6e-3;

/// What a voxel holds.
#[derive(Clone, Copy)]
struct Held {
    /// What it covers along each axis, or its mean for all three.
    cover: Vec3,
    /// Where in it that is, in [0, 1]³.
    place: Vec3,
}

/// What a voxel holds, from the words of its level.
#[inline]
fn held_at(depth: u32, level: u32, mean: bool, voxels: &[u32], point: UVec3) -> Held {
    let at = number(depth, level, point);
    if level == 0 {
        let bit = (voxels[(at / 32) as usize] >> (at & 31)) & 1;
        return Held { cover: Vec3::splat(bit as f32), place: Vec3::splat(0.5) };
    }
    let both = voxels[(at / 2) as usize] >> (16 * (at & 1));
    let cover = if mean { Vec3::splat((both & 255) as f32 * BYTE) } else { unpack_cover(both) };
    Held { cover, place: unpack_cover(both >> 8) }
}

/// Returns two voxels of level `params.level` as a word, from the words of the level below.
#[inline]
pub fn shrink_voxels(index: u32, params: &ShrinkParams, below: &[u32]) -> u32 {
    let bits = params.depth - params.level;
    let all = 1u32 << (3 * bits);
    let side = (1u32 << bits) - 1;
    let mut word = 0;
    for k in 0..2 {
        let at = 2 * index + k;
        if at < all {
            let point = UVec3::new(at & side, (at >> bits) & side, at >> (2 * bits));
            word |= shrunk(params, below, point) << (16 * k);
        }
    }
    word
}

/// The bytes of a voxel from the eight below it.
#[inline]
fn shrunk(params: &ShrinkParams, below: &[u32], point: UVec3) -> u32 {
    let mean = params.mean != 0;
    let mut cover = [Vec3::ZERO; 8];
    let (mut sum, mut whole, mut place) = (0.0, 0.0, Vec3::ZERO);
    for k in 0..8 {
        let half = UVec3::new(k & 1, (k >> 1) & 1, k >> 2);
        let child = point * 2 + half;
        let one = held_at(params.depth, params.level - 1, mean, below, child);
        sum += one.cover.x;
        cover[k as usize] = one.cover;
        let weight = (one.cover.x + one.cover.y) + one.cover.z;
        place += (Vec3::new(half.x as f32, half.y as f32, half.z as f32) + one.place) * (0.5 * weight);
        whole += weight;
    }
    let place = if whole > 0.0 { pack_fifths(place * div(1.0, whole), 0.5) << 8 } else { 0 };
    if mean {
        return to_u32(floor(sum * (0.125 * 255.0) + 0.5)) | place;
    }
    // The larger of two behind each other: what is one wall stays one.
    let x = (max(cover[0].x, cover[1].x) + max(cover[2].x, cover[3].x))
        + (max(cover[4].x, cover[5].x) + max(cover[6].x, cover[7].x));
    let y = (max(cover[0].y, cover[2].y) + max(cover[1].y, cover[3].y))
        + (max(cover[4].y, cover[6].y) + max(cover[5].y, cover[7].y));
    let z = (max(cover[0].z, cover[4].z) + max(cover[1].z, cover[5].z))
        + (max(cover[2].z, cover[6].z) + max(cover[3].z, cover[7].z));
    pack_cover(Vec3::new(x, y, z) * 0.25) | place
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

/// A voxel's optical depths along the axes, and where in it that is.
struct Depths {
    along: Vec3,
    place: Vec3,
}

/// The optical depths of a voxel; 0 for an empty one.
#[inline]
fn depths_at(depth: u32, level: u32, mean: bool, voxels: &[u32], point: UVec3) -> Depths {
    let at = number(depth, level, point);
    let centre = Vec3::splat(0.5);
    if level == 0 {
        let bit = (voxels[(at / 32) as usize] >> (at & 31)) & 1;
        return Depths { along: Vec3::splat(bit as f32 * MAX_OPTICAL_DEPTH), place: centre };
    }
    let both = voxels[(level_word(depth, level) + at / 2) as usize] >> (16 * (at & 1));
    let byte = both & 255;
    if byte == 0 {
        Depths { along: Vec3::ZERO, place: centre }
    } else if mean {
        Depths { along: Vec3::splat(depth_of(byte as f32 * BYTE)), place: centre }
    } else {
        let (x, y, z) = (byte % 6, byte / 6 % 6, byte / 36);
        let along = Vec3::new(depth_of_fifths(x), depth_of_fifths(y), depth_of_fifths(z));
        Depths { along, place: unpack_cover(both >> 8) }
    }
}

/// Binary voxels with their levels: they stop light, and tell where they are.
#[derive(Clone, Copy)]
pub struct Occluders<'a> {
    /// log₂ of the voxels along each side.
    pub depth: u32,
    /// Whether levels hold means.
    pub mean: bool,
    /// Bits, then levels of two bytes a voxel.
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
        let Depths { along: depths, place } = depths_at(self.depth, level, self.mean, self.voxels, point);
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
        let at = (Vec3::new(point.x as f32, point.y as f32, point.z as f32) + place) * edge;
        Sample { density, carried: at * density }
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
