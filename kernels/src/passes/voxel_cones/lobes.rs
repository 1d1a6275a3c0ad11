//! What do glossy leaves mirror of the lights? VCT §4.3 and §7.
//!
//! Photons that meet a glossy surface leave its reflected power together with the mean direction to the light, the mean
//! normal and the mean variance of the surface's lobe. A cone that meets the voxel convolves the lobes of light,
//! normals and surface with its own: variances add. Lobes stand behind the lit voxels' radiance in the same buffer, and only in scenes
//! with gloss.

use super::build::{PyramidParams, child_of, component, leaf_areas, opacity_of, side_weight};
use super::inject::{PhotonParams, photon_at, whole};
use super::storage::{pack_radiance, unpack_depths, unpack_radiance};
use crate::gaussian::{length_to_variance, lobe_of_mean};
use crate::geometry::bvh::Hit;
use crate::geometry::lattice::{NO_VOXEL, unpack_point, voxel_at};
use crate::math::{FRAC_1_PI, clamp, div, dot, floor, length, max, min, pow_fast, recip, sqrt, to_u32};
use crate::passes::Accumulate;
use crate::passes::scene::{Light, Material, Triangle};
use glam::Vec3;

/// Words of a lit leaf's mirrored power: red, green, blue, their largest; that times the direction to the light, the
/// normal, the variance of the surface's lobe; unused.
pub const LOBE_POWER_WORDS: u32 = 12;
/// Words of a lit voxel's lobes: reflected irradiance, mean direction to the light, mean normal, variance of the surface's lobe.
pub const LOBE_WORDS: u32 = 4;

/// A signed value as a word that sums modulo 2³².
#[inline]
fn signed(value: f32, dither: f32) -> u32 {
    if value < 0.0 { 0u32.wrapping_sub(whole(-value, dither)) } else { whole(value, dither) }
}

/// Adds what the glossy surface under photon `index` mirrors to its lit leaf's [`LOBE_POWER_WORDS`].
#[inline]
pub fn inject_lobes(
    index: u32,
    params: &PhotonParams,
    hits: &[Hit],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
    lights: &[Light],
    blocks: &[u32],
    places: &[u32],
    output: &mut impl Accumulate,
) {
    let photon = photon_at(index, params, hits, triangles, materials, texels, lights, blocks, places);
    let power = photon.reflectance.specular * photon.power;
    let weight = max(max(power.x, power.y), power.z);
    if photon.place == 0 || !(weight > 0.0) {
        return;
    }
    let at = LOBE_POWER_WORDS * (photon.place - 1);
    let dither = photon.dither;
    let (light, normal) = (photon.to_light * weight, photon.normal * weight);
    output.add(at, whole(power.x, dither));
    output.add(at + 1, whole(power.y, dither));
    output.add(at + 2, whole(power.z, dither));
    output.add(at + 3, whole(weight, dither));
    output.add(at + 4, signed(light.x, dither));
    output.add(at + 5, signed(light.y, dither));
    output.add(at + 6, signed(light.z, dither));
    output.add(at + 7, signed(normal.x, dither));
    output.add(at + 8, signed(normal.y, dither));
    output.add(at + 9, signed(normal.z, dither));
    output.add(at + 10, whole(weight * phong_variance(photon.reflectance.exponent), dither));
}

/// The variance of a Phong lobe by its mean length (n + 1)/(n + 2): 1/(n + 1).
#[inline]
fn phong_variance(exponent: f32) -> f32 {
    recip(1.0 + max(exponent, 0.0))
}

/// Returns a mean of unit vectors as one word, ten bits for each coordinate; coordinates outside [−1, 1] are clamped.
#[inline]
pub fn pack_mean(v: Vec3) -> u32 {
    let part = |x: f32| to_u32(floor(clamp(x, -1.0, 1.0) * 511.0 + 511.5));
    part(v.x) | (part(v.y) << 10) | (part(v.z) << 20)
}

/// Returns the vector that [`pack_mean`] packed: each coordinate within 0.001, 0 exact.
#[inline]
pub fn unpack_mean(word: u32) -> Vec3 {
    // 1/511
    const STEP: f32 = 1.956_947_2e-3;
    let part = |bits: u32| ((bits & 1023) as f32 - 511.0) * STEP;
    Vec3::new(part(word), part(word >> 10), part(word >> 20))
}

#[inline]
fn signed_sums(power: &[u32], at: u32) -> Vec3 {
    let (x, y, z) = (power[at as usize], power[(at + 1) as usize], power[(at + 2) as usize]);
    Vec3::new((x as i32) as f32, (y as i32) as f32, (z as i32) as f32)
}

/// Writes the [`LOBE_WORDS`] of lit leaf `index` from its sums: mirrored power over the leaf's surface, in units of
/// `params.radiance_scale`, and means.
#[inline]
pub fn lit_lobes(
    index: u32,
    params: &PyramidParams,
    lit: &[u32],
    sums: &[u32],
    power: &[u32],
    output: &mut impl Accumulate,
) {
    let at = LOBE_POWER_WORDS * index;
    let weight = power[(at + 3) as usize] as f32;
    if !(weight > 0.0) {
        return;
    }
    let areas = leaf_areas(sums, lit[index as usize]);
    let area = length(Vec3::new(min(areas.x, 1.0), min(areas.y, 1.0), min(areas.z, 1.0)));
    let face = params.lower.w * params.lower.w;
    let watts = max(area, 1.525_878_9e-5) * face * params.power_scale;
    let sum = Vec3::new(
        power[at as usize] as f32,
        power[(at + 1) as usize] as f32,
        power[(at + 2) as usize] as f32,
    );
    let inverse = recip(weight);
    let to = LOBE_WORDS * index;
    output.or(to, pack_radiance(sum * (recip(watts) * params.radiance_scale)));
    output.or(to + 1, pack_mean(signed_sums(power, at + 4) * inverse));
    output.or(to + 2, pack_mean(signed_sums(power, at + 7) * inverse));
    output.or(to + 3, (power[(at + 10) as usize] as f32 * inverse).to_bits());
}

/// Writes the [`LOBE_WORDS`] of lit voxel `index` of a level above the leaves: the mean of its 27 children by weight in
/// VCT's kernel and opacity, directions by what they mirror too.
#[inline]
pub fn filter_lobes(
    index: u32,
    params: &PyramidParams,
    lit: &[u32],
    points: &[u32],
    blocks: &[u32],
    depths: &[u32],
    children: &[u32],
    lobes: &[u32],
    output: &mut impl Accumulate,
) {
    let point = unpack_point(points[lit[index as usize] as usize]);
    let (mut light, mut normal) = (Vec3::ZERO, Vec3::ZERO);
    let (mut all, mut opaque, mut bright, mut variance) = (Vec3::ZERO, 0.0, 0.0, 0.0);
    for number in 0..27 {
        let child = voxel_at(blocks, params.depth, params.level - 1, child_of(point, number));
        if child != NO_VOXEL {
            let kernel = side_weight(number % 3) * side_weight(number / 3 % 3) * side_weight(number / 9 % 3);
            let depth = unpack_depths(depths[child as usize]);
            let weight = kernel * ((opacity_of(depth.x) + opacity_of(depth.y)) + opacity_of(depth.z));
            opaque += weight;
            let place = children[(child - params.child_first) as usize];
            if place > 0 {
                let at = LOBE_WORDS * (place - 1 - params.child_first_lit);
                let own = unpack_radiance(lobes[at as usize]) * weight;
                let by = max(max(own.x, own.y), own.z);
                all += own;
                bright += by;
                light += unpack_mean(lobes[(at + 1) as usize]) * by;
                normal += unpack_mean(lobes[(at + 2) as usize]) * by;
                variance += f32::from_bits(lobes[(at + 3) as usize]) * by;
            }
        }
    }
    if bright > 1.0e-18 && opaque > 1.0e-18 {
        let inverse = div(1.0, bright);
        let to = LOBE_WORDS * index;
        output.or(to, pack_radiance(all * div(1.0, opaque)));
        output.or(to + 1, pack_mean(light * inverse));
        output.or(to + 2, pack_mean(normal * inverse));
        output.or(to + 3, (variance * inverse).to_bits());
    }
}

/// Returns word `index` of the lobes of the leaves of a new list, from those of `places` behind `radiance`.
#[inline]
pub fn keep_lobes(index: u32, params: &PyramidParams, lit: &[u32], places: &[u32], radiance: &[u32]) -> u32 {
    let leaf = index / LOBE_WORDS;
    let k = index - LOBE_WORDS * leaf;
    let place = places[(params.first + lit[leaf as usize]) as usize];
    if place > 0 { radiance[(params.lobes + LOBE_WORDS * (place - 1) + k) as usize] } else { 0 }
}

/// Returns the variance that a cone of this half angle's tangent adds: tan²(ψ/2), see
/// [`cone_deviation`](crate::gaussian::cone_deviation).
#[inline]
pub fn cone_variance(tangent: f32) -> f32 {
    let half = div(tangent, 1.0 + sqrt(1.0 + tangent * tangent));
    half * half
}

/// Returns the radiance that lobes send against `direction`, in stored units; `at` is the first of their words.
///
/// The Phong lobe whose variance is the sum of those of surface, light, normals (which turn the mirrored light by
/// twice their angle) and cone. 0 behind the surface.
#[inline]
pub fn mirrored(radiance: &[u32], at: u32, direction: Vec3, cone: f32) -> Vec3 {
    let reflected = unpack_radiance(radiance[at as usize]);
    if !(max(max(reflected.x, reflected.y), reflected.z) > 0.0) {
        return Vec3::ZERO;
    }
    let mean_normal = unpack_mean(radiance[(at + 2) as usize]);
    let normal = lobe_of_mean(mean_normal, Vec3::Y);
    let light = lobe_of_mean(unpack_mean(radiance[(at + 1) as usize]), normal.axis);
    let mirror = normal.axis * (2.0 * dot(normal.axis, light.axis)) - light.axis;
    let cosine = min(-dot(mirror, direction), 1.0);
    if !(cosine > 0.0) || dot(normal.axis, direction) >= 0.0 {
        return Vec3::ZERO;
    }
    let surface = f32::from_bits(radiance[(at + 3) as usize]);
    let normals = 4.0 * length_to_variance(length(mean_normal));
    let variance = ((surface + light.variance) + normals) + cone;
    let exponent = max(recip(max(variance, 1.0e-4)) - 1.0, 0.0);
    // The whole of the surface's own lobe, spread over the wider one.
    let own = max(recip(max(surface, 1.0e-4)) - 1.0, 0.0);
    let whole = div(own + 2.0, own + 1.0);
    reflected * (whole * (exponent + 1.0) * (0.5 * FRAC_1_PI) * pow_fast(cosine, exponent))
}

/// Returns the mean normal behind these words and the variance of all lobes but the cone's; 0 where nothing is mirrored.
#[inline]
pub fn lobe_normal(radiance: &[u32], at: u32) -> (Vec3, f32) {
    let reflected = unpack_radiance(radiance[at as usize]);
    if !(component(reflected, 0) + component(reflected, 1) + component(reflected, 2) > 0.0) {
        return (Vec3::ZERO, 0.0);
    }
    let normal = unpack_mean(radiance[(at + 2) as usize]);
    let light = length_to_variance(length(unpack_mean(radiance[(at + 1) as usize])));
    let surface = f32::from_bits(radiance[(at + 3) as usize]);
    (normal, (surface + light) + 4.0 * length_to_variance(length(normal)))
}
