//! How does radiance rise from the leaves? VCT §8.2 and §9.
//!
//! Only voxels above lit ones are filtered: they are marked level by level from the lit list below.

use super::build::{
    ISOTROPIC, PyramidParams, child_of, component, numbered, opacity_of, share_along, side_weight,
};
use super::inject::RADIANCE_WORDS;
use super::lobes::LOBE_WORDS;
use super::storage::{load_radiance, radiance_word, ratio, storage_of, unpack_depths, words_of};
use crate::geometry::lattice::{NO_VOXEL, unpack_point, voxel_at};
use crate::math::exp;
use crate::passes::Accumulate;
use glam::{UVec3, Vec3};

/// Sets the flags of the voxels of level `params.level` that lit voxel `index` of the level below has a share in.
#[inline]
pub fn mark_lit_parents(
    index: u32,
    params: &PyramidParams,
    lit: &[u32],
    points: &[u32],
    blocks: &[u32],
    output: &mut impl Accumulate,
) {
    let point = unpack_point(points[lit[index as usize] as usize]);
    for number in 0..8 {
        // A child on an odd coordinate lies between two parents.
        let (x, y, z) = (number & 1, (number >> 1) & 1, number >> 2);
        if x <= point.x & 1 && y <= point.y & 1 && z <= point.z & 1 {
            let parent = UVec3::new(point.x / 2 + x, point.y / 2 + y, point.z / 2 + z);
            let voxel = voxel_at(blocks, params.depth, params.level, parent);
            if voxel != NO_VOXEL {
                output.or(voxel - params.first, 1);
            }
        }
    }
}

/// Returns the number, plus one, of each lit voxel among all lit ones; 0 for a dark one. `starts` scans the flags.
#[inline]
pub fn lit_places(index: u32, params: &PyramidParams, flags: &[u32], starts: &[u32]) -> u32 {
    if flags[index as usize] != 0 { params.first_lit + starts[index as usize] + 1 } else { 0 }
}

/// The place of a voxel that is not lit.
const DARK: u32 = 0xFFFF_FFFF;

/// Returns 1 where a word of that leaf's radiance is not 0, or where it mirrors: `places` and `direct` hold the lobes.
#[inline]
pub fn mark_bright(
    index: u32,
    params: &PyramidParams,
    radiance: &[u32],
    places: &[u32],
    direct: &[u32],
) -> u32 {
    let mut any = 0;
    let words = RADIANCE_WORDS * words_of(storage_of(params.flags));
    for k in 0..words {
        any |= radiance[(words * index + k) as usize];
    }
    let place = places[(params.first + index) as usize];
    if params.lobes > 0 && place > 0 {
        any |= direct[(params.lobes + LOBE_WORDS * (place - 1)) as usize];
    }
    if any != 0 { 1 } else { 0 }
}

/// Returns word `index` of the lit leaves' radiance, from that of all leaves.
#[inline]
pub fn keep_lit(index: u32, params: &PyramidParams, lit: &[u32], radiance: &[u32]) -> u32 {
    let words = RADIANCE_WORDS * words_of(storage_of(params.flags));
    let place = index / words;
    let k = index - words * place;
    radiance[(words * lit[place as usize] + k) as usize]
}

/// What the child columns of a voxel send along one direction.
struct Sent {
    light: Vec3,
    opacity: f32,
}

/// Front to back through each column of three children, then the mean of the nine columns.
#[inline]
fn sent(k: u32, depths: &[u32; 27], lit: &[u32; 27], radiance: &[u32], storage: u32) -> Sent {
    let axis = k / 2;
    let mut all = Sent { light: Vec3::ZERO, opacity: 0.0 };
    for column in 0..9 {
        let (left, up) = (column % 3, column / 3);
        let mut through = 1.0;
        let mut light = Vec3::ZERO;
        for step in 0..3 {
            // Seen from the side that the radiance leaves to.
            let along = if k & 1 == 0 { 2 - step } else { step };
            let number = numbered(axis, along, left, up);
            let depth = component(unpack_depths(depths[number as usize]), axis) * share_along(along);
            if depth > 0.0 {
                let place = lit[number as usize];
                if place != DARK {
                    let own = load_radiance(radiance, storage, RADIANCE_WORDS * place + k);
                    light += own * (through * opacity_of(depth));
                }
                through *= exp(-depth);
            }
        }
        let weight = side_weight(left) * side_weight(up);
        all.light += light * weight;
        all.opacity += (1.0 - through) * weight;
    }
    all
}

/// Writes a radiance of an output.
#[inline]
fn store(output: &mut impl Accumulate, storage: u32, entry: u32, radiance: Vec3) {
    let words = words_of(storage);
    for word in 0..words {
        output.or(words * entry + word, radiance_word(storage, radiance, word));
    }
}

/// Writes the [`RADIANCE_WORDS`] radiances of lit voxel `index` of a level above the leaves, from its 27 children.
///
/// `children` are the [`lit_places`] of the level below, `radiance` is its lit voxels'.
#[inline]
pub fn filter_radiance(
    index: u32,
    params: &PyramidParams,
    lit: &[u32],
    points: &[u32],
    blocks: &[u32],
    depths: &[u32],
    children: &[u32],
    radiance: &[u32],
    output: &mut impl Accumulate,
) {
    let point = unpack_point(points[lit[index as usize] as usize]);
    let mut own_depths = [0u32; 27];
    let mut own_lit = [DARK; 27];
    for number in 0..27 {
        let child = voxel_at(blocks, params.depth, params.level - 1, child_of(point, number));
        if child != NO_VOXEL {
            own_depths[number as usize] = depths[child as usize];
            let place = children[(child - params.child_first) as usize];
            own_lit[number as usize] = if place > 0 { place - 1 - params.child_first_lit } else { DARK };
        }
    }
    let at = RADIANCE_WORDS * index;
    let storage = storage_of(params.flags);
    let mut all = Sent { light: Vec3::ZERO, opacity: 0.0 };
    for k in 0..RADIANCE_WORDS {
        let one = sent(k, &own_depths, &own_lit, radiance, storage);
        if params.flags & ISOTROPIC != 0 {
            all.light += one.light;
            all.opacity += one.opacity;
        } else {
            store(output, storage, at + k, ratio(one.light, one.opacity));
        }
    }
    if params.flags & ISOTROPIC != 0 {
        let mean = ratio(all.light, all.opacity);
        for k in 0..RADIANCE_WORDS {
            store(output, storage, at + k, mean);
        }
    }
}
