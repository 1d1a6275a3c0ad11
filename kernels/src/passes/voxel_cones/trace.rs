//! What do pixels gather with their cones? VCT §6 and §8.1.

use super::build::{component, leaf_albedo, leaf_areas};
use super::inject::RADIANCE_WORDS;
use super::march::{Medium, Pyramid, Ray, march};
use super::storage::{load_radiance, radiance_word, storage_of, words_of};
use crate::cone::ConeSum;
use crate::geometry::bvh::NO_TRIANGLE;
use crate::geometry::lattice::unpack_point;
use crate::math::{PI, clamp, div, dot, floor, log2, max, min, normalize_or, sqrt, to_u32};
use crate::passes::gather::{GatherParams, environment_radiance};
use crate::passes::material::mirror_direction;
use crate::passes::surface::Surface;
use crate::sampling::hemisphere::{cone, to_world};
use crate::sampling::interleaved::interleaved_turn;
use glam::{UVec4, Vec3, Vec4};

/// [`ConeParams::flags`]: the environment lights what cones miss.
pub const CONES_SEE_ENVIRONMENT: u32 = 1;
/// [`ConeParams::flags`]: one radiance for all directions.
pub const CONES_ISOTROPIC: u32 = 2;
/// [`ConeParams::flags`]: binary voxels are filtered to their mean instead of to what they cover.
pub const CONES_MEAN_OPACITY: u32 = 4;

/// The tangent of the widest cone, 85°.
const WIDEST: f32 = 11.43;

gpu_struct! {
    /// Parameters of the passes that trace cones.
    pub struct ConeParams {
        /// Lattice point (0, 0, 0) in metres; w is the voxel edge of level 0, metres.
        pub lower: Vec4,
        /// Position of the eye; w is 0.
        pub eye: Vec4,
        /// Radiance of the environment where it has no map; w is 0.
        pub environment: Vec4,
        /// Where the environment map is, as in [`GatherParams`].
        pub map: UVec4,
        /// 1/(voxel edge of level 0), 1/m.
        pub inverse_edge: f32,
        /// Depth of the pyramid.
        pub depth: u32,
        /// Number of cones over the hemisphere.
        pub cones: u32,
        /// Tangent of the cones' half angle; 0 takes that of the set, or of the specular lobe.
        pub tangent: f32,
        /// Voxels' width as a share of the cone's.
        pub width: f32,
        /// Step as a share of the voxels' width.
        pub step: f32,
        /// Where cones start, in voxel edges of level 0.
        pub start: f32,
        /// Half voxels over a surface within which nothing counts for its cones.
        pub clearance: f32,
        /// Share of a cone that may be left unseen.
        pub cutoff: f32,
        /// λ of the occlusion's falloff, per voxel edge of level 0.
        pub falloff: f32,
        /// Where occlusion ends, in voxel edges of level 0.
        pub reach: f32,
        /// W/(m² sr) per unit of stored radiance.
        pub radiance_unit: f32,
        /// [`CONES_SEE_ENVIRONMENT`], [`CONES_ISOTROPIC`]; from bit 8 on the radiance's [storage](storage_of).
        pub flags: u32,
        /// Number of the first leaf.
        pub first: u32,
        /// Units of stored radiance per W/(m² sr).
        pub radiance_scale: f32,
        /// Words before the lobes in the radiance; 0 where there are none.
        pub lobes: u32,
        /// Number of layered reflective shadow maps.
        pub maps: u32,
        /// The light of a shadow's cones.
        pub light: u32,
        /// Its radius in metres, or the tangent of a sun's half angle.
        pub extent: f32,
        /// Pixels in a row, where each of 4 × 4 pixels turns its cones another way ([`filter_interleaved`]); 0 where none does.
        ///
        /// [`filter_interleaved`]: crate::passes::interleaved::filter_interleaved
        pub columns: u32,
    }
}

/// Returns a point in voxel edges of level 0.
#[inline]
pub fn on_lattice(params: &ConeParams, point: Vec3) -> Vec3 {
    (point - params.lower.truncate()) * params.inverse_edge
}

/// The ray of cone `number` over a surface, and its weight.
#[inline]
fn hemisphere_cone(params: &ConeParams, origin: Vec3, normal: Vec3, number: u32, turn: f32) -> (Ray, f32) {
    let own = cone(params.cones, number, turn);
    let direction = to_world(own.direction, normal);
    let tangent = if params.tangent > 0.0 { params.tangent } else { own.tangent };
    (Ray { origin, direction, normal, tangent, reach: params.reach }, own.weight)
}

/// The turn of pixel `index` in rows of `columns`; none of all where that is 0.
#[inline]
fn pixel_turn(index: u32, columns: u32) -> f32 {
    if columns == 0 { 0.0 } else { interleaved_turn(index % columns, index / columns) }
}

/// The medium that a pyramid's buffers are.
#[inline]
fn pyramid<'a>(
    params: &ConeParams,
    blocks: &'a [u32],
    depths: &'a [u32],
    places: &'a [u32],
    radiance: &'a [u32],
) -> Pyramid<'a> {
    let storage = storage_of(params.flags);
    Pyramid { depth: params.depth, lobes: params.lobes, storage, blocks, depths, places, radiance }
}

/// Returns the cosine-weighted openness of pixel `index` in [0, 1] by cones: 1 where nothing occludes, and for no surface.
///
/// What occludes at distance r counts 1/(1 + λr). VCT §6.
#[inline]
pub fn cone_openness(
    index: u32,
    params: &ConeParams,
    surfaces: &[Surface],
    blocks: &[u32],
    depths: &[u32],
    places: &[u32],
    radiance: &[u32],
) -> f32 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return 1.0;
    }
    let medium = pyramid(params, blocks, depths, places, radiance);
    let origin = on_lattice(params, s.position.truncate());
    let turn = pixel_turn(index, params.columns);
    let mut sum = ConeSum::EMPTY;
    for number in 0..params.cones {
        let (ray, weight) = hemisphere_cone(params, origin, s.normal.truncate(), number, turn);
        let met = march(params, &ray, &medium);
        sum = sum.with(Vec4::new(1.0 - met.occluded, 0.0, 0.0, 0.0), weight);
    }
    sum.mean(Vec4::ONE).x
}

/// What the environment sends through a cone that nothing stops: from the copies of its map whose texels are as wide.
#[inline]
fn environment(params: &ConeParams, texels: &[u32], direction: Vec3, tangent: f32) -> Vec3 {
    let map = params.map;
    // Rows that the cone spans; 1.1 rad is where the tangent begins to say much more than the angle.
    let rows = div(2.0 * min(tangent, 1.1), PI) * (map.z as f32);
    let level = clamp(log2(max(rows, 1.0)), 0.0, map.w as f32);
    let lower = floor(level);
    let fine = environment_copy(params, texels, direction, to_u32(lower));
    if lower >= level {
        return fine;
    }
    let coarse = environment_copy(params, texels, direction, to_u32(lower) + 1);
    fine + (coarse - fine) * (level - lower)
}

/// What copy `number` of the environment's map has along a direction.
#[inline]
fn environment_copy(params: &ConeParams, texels: &[u32], direction: Vec3, number: u32) -> Vec3 {
    let mut map = params.map;
    for _ in 0..number {
        map.x += 3 * map.y * map.z;
        map.y = if map.y > 1 { map.y / 2 } else { 1 };
        map.z = if map.z > 1 { map.z / 2 } else { map.z };
    }
    let of = GatherParams {
        environment: params.environment,
        map,
        rays: 1,
        seed: 0,
        flags: 0,
        falloff: 0.0,
        first_pixel: 0,
        reach: 0.0,
        pad0: 0,
        pad1: 0,
    };
    environment_radiance(&of, texels, direction)
}

/// Returns the light that arrives at pixel `index` from voxels all around: irradiance/π, and in w the share of the
/// hemisphere that cones found open. VCT §8.1.
#[inline]
pub fn cone_diffuse(
    index: u32,
    params: &ConeParams,
    surfaces: &[Surface],
    blocks: &[u32],
    depths: &[u32],
    places: &[u32],
    radiance: &[u32],
) -> Vec4 {
    diffuse_through(index, surfaces, params, &pyramid(params, blocks, depths, places, radiance))
}

/// Returns [`cone_diffuse`] of pixel `index`, through any voxels.
#[inline]
pub fn diffuse_through<M: Medium>(index: u32, surfaces: &[Surface], params: &ConeParams, medium: &M) -> Vec4 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return Vec4::ZERO;
    }
    let origin = on_lattice(params, s.position.truncate());
    let turn = pixel_turn(index, params.columns);
    let mut sum = ConeSum::EMPTY;
    for number in 0..params.cones {
        let (ray, weight) = hemisphere_cone(params, origin, s.normal.truncate(), number, turn);
        let met = march(params, &ray, medium);
        sum = sum.with((met.light * params.radiance_unit).extend(met.through), weight);
    }
    sum.mean(Vec4::ZERO)
}

/// Returns the tangent of a cone as wide as a Phong lobe of this exponent: with the same mean cosine, cos ψ = n/(n + 2).
#[inline]
pub fn lobe_tangent(exponent: f32) -> f32 {
    let n = max(exponent, 1.0e-3);
    min(div(2.0 * sqrt(n + 1.0), n), WIDEST)
}

/// Returns what the specular lobe of pixel `index` reflects of voxels and environment, for a specular colour of 1; w is
/// 1, or 0 where there is no lobe. VCT §8.1.
#[inline]
pub fn cone_specular(
    index: u32,
    params: &ConeParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    blocks: &[u32],
    depths: &[u32],
    places: &[u32],
    radiance: &[u32],
    texels: &[u32],
) -> Vec4 {
    let medium = pyramid(params, blocks, depths, places, radiance);
    specular_through(&surfaces[index as usize], gloss[index as usize], params, texels, &medium)
}

/// Returns [`cone_specular`] of a surface with this specular colour and exponent, through any voxels.
#[inline]
pub fn specular_through<M: Medium>(
    s: &Surface,
    own: Vec4,
    params: &ConeParams,
    texels: &[u32],
    medium: &M,
) -> Vec4 {
    if s.triangle == NO_TRIANGLE || !(max(max(own.x, own.y), own.z) > 0.0) {
        return Vec4::ZERO;
    }
    let (position, normal) = (s.position.truncate(), s.normal.truncate());
    let to_viewer = normalize_or(params.eye.truncate() - position, normal);
    let direction = mirror_direction(normal, to_viewer);
    let tangent = if params.tangent > 0.0 { params.tangent } else { lobe_tangent(own.w) };
    let origin = on_lattice(params, position);
    let ray = Ray { origin, direction, normal, tangent, reach: params.reach };
    let met = march(params, &ray, medium);
    let mut light = met.light * params.radiance_unit;
    if params.flags & CONES_SEE_ENVIRONMENT != 0 {
        light += environment(params, texels, direction, tangent) * met.through;
    }
    // (n + 2)/(n + 1): the lobe's whole with the cosine of a light near its middle.
    let whole = div(own.w + 2.0, own.w + 1.0) * max(dot(direction, normal), 0.0);
    (light * whole).extend(1.0)
}

/// Returns word `index` of the radiance that leaves reflect of other voxels and of the environment: albedo times what cones
/// gather over the sides that face the word's direction. VCT §8.1 with the structure as its own receiver.
#[inline]
pub fn bounce_radiance(
    index: u32,
    params: &ConeParams,
    points: &[u32],
    sums: &[u32],
    blocks: &[u32],
    depths: &[u32],
    places: &[u32],
    radiance: &[u32],
    texels: &[u32],
) -> u32 {
    let storage = storage_of(params.flags);
    let entry = index / words_of(storage);
    let leaf = entry / RADIANCE_WORDS;
    let k = entry - RADIANCE_WORDS * leaf;
    let axis = k / 2;
    let area = component(leaf_areas(sums, leaf), axis);
    if !(area > 0.0) {
        return 0;
    }
    let sign = if k & 1 == 0 { 1.0 } else { -1.0 };
    let normal = match axis {
        0 => Vec3::new(sign, 0.0, 0.0),
        1 => Vec3::new(0.0, sign, 0.0),
        _ => Vec3::new(0.0, 0.0, sign),
    };
    let point = unpack_point(points[leaf as usize]);
    let origin = Vec3::new(point.x as f32, point.y as f32, point.z as f32);
    let medium = pyramid(params, blocks, depths, places, radiance);
    let mut sum = ConeSum::EMPTY;
    for number in 0..params.cones {
        let (ray, weight) = hemisphere_cone(params, origin, normal, number, 0.0);
        let met = march(params, &ray, &medium);
        let mut light = met.light;
        if params.flags & CONES_SEE_ENVIRONMENT != 0 {
            light += environment(params, texels, ray.direction, ray.tangent)
                * (met.through * params.radiance_scale);
        }
        sum = sum.with(light.extend(met.through), weight);
    }
    let word = index - words_of(storage) * entry;
    radiance_word(storage, leaf_albedo(sums, leaf) * sum.mean(Vec4::ZERO).truncate(), word)
}

/// Returns word `index` of the leaves' radiance: what lit ones send of direct light plus a bounce; without directions the
/// bounce's mean over the sides that send any.
#[inline]
pub fn add_bounce(index: u32, params: &ConeParams, places: &[u32], radiance: &[u32], bounced: &[u32]) -> u32 {
    let storage = storage_of(params.flags);
    let entry = index / words_of(storage);
    let leaf = entry / RADIANCE_WORDS;
    let k = entry - RADIANCE_WORDS * leaf;
    let place = places[(params.first + leaf) as usize];
    let own = if place > 0 {
        load_radiance(radiance, storage, RADIANCE_WORDS * (place - 1) + k)
    } else {
        Vec3::ZERO
    };
    let mut more = load_radiance(bounced, storage, entry);
    if params.flags & CONES_ISOTROPIC != 0 {
        let mut sides = 0.0;
        more = Vec3::ZERO;
        for side in 0..RADIANCE_WORDS {
            let one = load_radiance(bounced, storage, RADIANCE_WORDS * leaf + side);
            sides += if max(max(one.x, one.y), one.z) > 0.0 { 1.0 } else { 0.0 };
            more += one;
        }
        more *= div(1.0, max(sides, 1.0));
    }
    radiance_word(storage, own + more, index - words_of(storage) * entry)
}
