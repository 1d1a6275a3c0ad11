//! How does light get into the leaves? VCT §8.2.
//!
//! A light's map is a set of photons, each with the power of its texel. A photon leaves its reflected power with the leaf that
//! it meets, divided among the directions that the surface faces; a leaf's radiance is that power over the area that
//! faces the direction. All sums are integers: the order of photons does not show.

use super::build::{ISOTROPIC, PyramidParams, component, covered, leaf_areas};
use super::storage::{radiance_word, storage_of, words_of};
use crate::geometry::bvh::{Hit, NO_TRIANGLE};
use crate::geometry::lattice::{NO_VOXEL, voxel_at};
use crate::math::{FRAC_1_PI, PI, dot, floor, max, min, recip, to_u32};
use crate::passes::Accumulate;
use crate::passes::light::incident_light;
use crate::passes::light_map::{PROJECT_PARALLEL, texel_measure};
use crate::passes::material::{Reflectance, emitted_radiance, reflectance, texture_coordinates};
use crate::passes::scene::{Light, Material, Triangle};
use crate::passes::surface::geometric_normal;
use crate::sampling::hash::{combine, unit_float};
use glam::{UVec3, Vec3, Vec4};

/// Words of a lit leaf's power: red, green, blue for each of +x, −x, +y, −y, +z, −z.
pub const POWER_WORDS: u32 = 18;
/// Radiances of a lit voxel: one for each of these directions, of one word in the usual storage.
pub const RADIANCE_WORDS: u32 = 6;

gpu_struct! {
    /// A light's photons and the leaves that take them.
    pub struct PhotonParams {
        /// Lattice point (0, 0, 0) in metres; w is the voxel edge, metres.
        pub lower: Vec4,
        /// 1/(voxel edge), 1/m.
        pub inverse_edge: f32,
        /// Depth of the pyramid.
        pub depth: u32,
        /// Number of the first leaf.
        pub first: u32,
        /// The light.
        pub light: u32,
        /// How its map is laid over the directions, as in [`LightMapParams`](crate::passes::light_map::LightMapParams).
        pub projection: u32,
        /// Texels along a side of the map.
        pub size: u32,
        /// Tangent of the half angle (perspective) or half the side in metres (parallel).
        pub spread: f32,
        /// Units of power per watt.
        pub scale: f32,
    }
}

/// The leaf that holds a point, counted from the first; [`NO_VOXEL`] if none does.
#[inline]
fn leaf_at(params: &PhotonParams, blocks: &[u32], point: Vec3) -> u32 {
    // Voxels are centred on lattice points.
    let p = (point - params.lower.truncate()) * params.inverse_edge + Vec3::splat(0.5);
    // Below 0 a coordinate would count as 0.
    if !(p.x >= 0.0 && p.y >= 0.0 && p.z >= 0.0) {
        return NO_VOXEL;
    }
    let cell = UVec3::new(to_u32(floor(p.x)), to_u32(floor(p.y)), to_u32(floor(p.z)));
    let voxel = voxel_at(blocks, params.depth, 0, cell);
    if voxel == NO_VOXEL { NO_VOXEL } else { voxel - params.first }
}

#[inline]
fn hit_point(hit: &Hit, t: &Triangle) -> Vec3 {
    let w = (1.0 - hit.u) - hit.v;
    (t.p0.truncate() * w + t.p1.truncate() * hit.u) + t.p2.truncate() * hit.v
}

/// Sets the flag of the leaf that photon `index` meets.
#[inline]
pub fn mark_lit(
    index: u32,
    params: &PhotonParams,
    hits: &[Hit],
    triangles: &[Triangle],
    blocks: &[u32],
    output: &mut impl Accumulate,
) {
    let hit = hits[index as usize];
    if hit.triangle != NO_TRIANGLE {
        let leaf = leaf_at(params, blocks, hit_point(&hit, &triangles[hit.triangle as usize]));
        if leaf != NO_VOXEL {
            output.or(leaf, 1);
        }
    }
}

/// A photon with what it meets.
pub(super) struct Photon {
    /// Number of the lit leaf, plus one; 0 for a photon that meets none.
    pub(super) place: u32,
    /// What it brings, in units of power.
    pub(super) power: Vec3,
    pub(super) reflectance: Reflectance,
    /// Of the side that it meets.
    pub(super) normal: Vec3,
    pub(super) to_light: Vec3,
    /// In [0, 1): what fractions are rounded up by, so that dim photons are not lost.
    pub(super) dither: f32,
}

/// What photon `index` meets; `places` are the lit leaves' numbers, plus one.
#[inline]
pub(super) fn photon_at(
    index: u32,
    params: &PhotonParams,
    hits: &[Hit],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
    lights: &[Light],
    blocks: &[u32],
    places: &[u32],
) -> Photon {
    let hit = hits[index as usize];
    // A photon that meets nothing reads the first triangle, and has no place.
    let triangle = if hit.triangle == NO_TRIANGLE { 0 } else { hit.triangle };
    let t = &triangles[triangle as usize];
    let point = hit_point(&hit, t);
    let leaf = if hit.triangle == NO_TRIANGLE { NO_VOXEL } else { leaf_at(params, blocks, point) };
    let incident = incident_light(&lights[params.light as usize], point);
    // Intensity times solid angle, or a sun's irradiance times area.
    let squared =
        if params.projection == PROJECT_PARALLEL { 1.0 } else { incident.distance * incident.distance };
    let power =
        incident.irradiance * (squared * texel_measure(params.projection, params.size, params.spread, index));
    let flat = geometric_normal(t);
    Photon {
        place: if leaf == NO_VOXEL { 0 } else { places[leaf as usize] },
        power: power * params.scale,
        reflectance: reflectance(
            &materials[t.material as usize],
            texels,
            texture_coordinates(t, hit.u, hit.v),
        ),
        normal: if dot(flat, incident.direction) < 0.0 { -flat } else { flat },
        to_light: incident.direction,
        dither: unit_float(combine(params.light, index)),
    }
}

/// Adds the power that photon `index` leaves with its leaf to that lit leaf's [`POWER_WORDS`]; `places` are the lit
/// leaves' numbers, plus one.
#[inline]
pub fn inject_photons(
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
    let p = photon_at(index, params, hits, triangles, materials, texels, lights, blocks, places);
    if p.place > 0 {
        add_power(POWER_WORDS * (p.place - 1), p.reflectance.diffuse * p.power, p.normal, p.dither, output);
    }
}

/// Divides power among the directions that a surface faces.
#[inline]
fn add_power(at: u32, power: Vec3, normal: Vec3, dither: f32, output: &mut impl Accumulate) {
    for k in 0..6 {
        let facing = if k & 1 == 0 { component(normal, k / 2) } else { -component(normal, k / 2) };
        if facing > 0.0 {
            output.add(at + 3 * k, whole(power.x * facing, dither));
            output.add(at + 3 * k + 1, whole(power.y * facing, dither));
            output.add(at + 3 * k + 2, whole(power.z * facing, dither));
        }
    }
}

/// A power in whole units, at most 2·10⁹.
#[inline]
pub(super) fn whole(value: f32, dither: f32) -> u32 {
    to_u32(floor(min(max(value, 0.0), 2.0e9) + dither))
}

/// Sets the flag of the leaf of pair `index` where its triangle emits.
#[inline]
pub fn mark_emissive(
    index: u32,
    params: &PyramidParams,
    pairs: &[u32],
    blocks: &[u32],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
    output: &mut impl Accumulate,
) {
    let part = covered(index, params, pairs, blocks, triangles, materials, texels);
    let t = &triangles[pairs[(2 * index + 1) as usize] as usize];
    let e = emitted_radiance(&materials[t.material as usize], texels, texture_coordinates(t, part.u, part.v));
    if part.area > 0.0 && max(max(e.x, e.y), e.z) > 0.0 {
        output.or(part.leaf, 1);
    }
}

/// Adds the power that the front of pair `index`'s triangle emits within its voxel to that lit leaf's [`POWER_WORDS`].
#[inline]
pub fn inject_emission(
    index: u32,
    params: &PyramidParams,
    pairs: &[u32],
    blocks: &[u32],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
    places: &[u32],
    output: &mut impl Accumulate,
) {
    let part = covered(index, params, pairs, blocks, triangles, materials, texels);
    let t = &triangles[pairs[(2 * index + 1) as usize] as usize];
    let e = emitted_radiance(&materials[t.material as usize], texels, texture_coordinates(t, part.u, part.v));
    let place = if part.area > 0.0 { places[part.leaf as usize] } else { 0 };
    if place > 0 && max(max(e.x, e.y), e.z) > 0.0 {
        let face = params.lower.w * params.lower.w;
        let power = e * (PI * part.clipped * face * params.power_scale);
        add_power(POWER_WORDS * (place - 1), power, part.normal, 0.5, output);
    }
}

/// The power that a lit leaf sends along one direction.
#[inline]
fn power_toward(power: &[u32], place: u32, direction: u32) -> Vec3 {
    let at = POWER_WORDS * place + 3 * direction;
    Vec3::new(power[at as usize] as f32, power[(at + 1) as usize] as f32, power[(at + 2) as usize] as f32)
}

/// Returns word `index` of the lit leaves' radiance, [`RADIANCE_WORDS`] entries each: power over π times the area that faces the
/// direction, in units of `params.radiance_scale`.
#[inline]
pub fn lit_radiance(index: u32, params: &PyramidParams, lit: &[u32], sums: &[u32], power: &[u32]) -> u32 {
    let storage = storage_of(params.flags);
    let entry = index / words_of(storage);
    let place = entry / RADIANCE_WORDS;
    let k = entry - RADIANCE_WORDS * place;
    let areas = leaf_areas(sums, lit[place as usize]);
    // Not more than a face is seen, and lit, of sheets behind each other.
    let areas = Vec3::new(min(areas.x, 1.0), min(areas.y, 1.0), min(areas.z, 1.0));
    let (mut sum, mut area) = (power_toward(power, place, k), component(areas, k / 2));
    if params.flags & ISOTROPIC != 0 {
        sum = Vec3::ZERO;
        for direction in 0..6 {
            sum += power_toward(power, place, direction);
        }
        area = (areas.x + areas.y) + areas.z;
    }
    let face = params.lower.w * params.lower.w;
    // 2⁻¹⁶: less area than can be told from rounding radiates as if it had that much.
    let watts = max(area, 1.525_878_9e-5) * face * params.power_scale;
    let word = index - words_of(storage) * entry;
    radiance_word(storage, sum * (FRAC_1_PI * recip(watts) * params.radiance_scale), word)
}
