//! What does a surface receive from all around: the environment, emissive surfaces, and how open is it?
//!
//! Cosine-distributed rays per pixel. Directions are a rotated Halton set: world-independent, a hash of the pixel
//! turns it, so that neighbours differ and a pixel does not change between frames.

use super::material::{AlphaTest, emitted_radiance, texture_coordinates};
use super::scene::{Material, Triangle};
use super::surface::{CameraParams, Surface, camera_direction, geometric_normal, ray_origin};
use crate::geometry::bvh::{BvhNode, Hit, NO_TRIANGLE, Ray, TriangleBlock, nearest_hit};
use crate::math::{FRAC_1_PI, acos, atan2, div, dot, floor, max, min_u32, recip, saturate, to_u32};
use crate::sampling::halton::{halton, rotated};
use crate::sampling::hash::{combine, unit_float};
use crate::sampling::hemisphere::{cosine_hemisphere, to_world};
use glam::{UVec4, Vec2, Vec3, Vec4};

/// Bit of [`GatherParams::flags`]: emissive surfaces emit.
pub const GATHER_EMISSION: u32 = 1;

gpu_struct! {
    /// Parameters of the passes that trace rays all around.
    pub struct GatherParams {
        /// Radiance of the environment where it has no map; w is 0.
        pub environment: Vec4,
        /// Words before the environment map in the texels, its width, its height (0 without a map), how many smaller copies
        /// follow, each of half the width and height of the one before.
        pub map: UVec4,
        /// Rays per pixel, at least 1.
        pub rays: u32,
        /// Seed of the directions.
        pub seed: u32,
        /// [`GATHER_EMISSION`].
        pub flags: u32,
        /// λ of the occlusion's falloff 1/(1 + λ r), 1/m; 0 counts every occluder alike.
        pub falloff: f32,
        /// Row-major number of the first pixel of the band, so that bands do not repeat each other.
        pub first_pixel: u32,
        /// Distance beyond which nothing occludes, metres.
        pub reach: f32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }
}

/// Returns ray `ray` of pixel `pixel`'s cosine-distributed set about `normal`.
#[inline]
pub fn gather_direction(pixel: u32, ray: u32, seed: u32, normal: Vec3) -> Vec3 {
    turned_direction(combine(seed, pixel), ray, normal)
}

/// Returns point `ray` of the Halton sequence, shifted by hashes of `turn`, as a cosine-distributed direction.
#[inline]
pub fn turned_direction(turn: u32, ray: u32, normal: Vec3) -> Vec3 {
    let point = halton(ray);
    let u = Vec2::new(rotated(point.x, unit_float(turn)), rotated(point.y, unit_float(combine(turn, 1))));
    to_world(cosine_hemisphere(u), normal)
}

/// Returns the environment's radiance along a unit direction.
///
/// A map is equirectangular with y up: u = ½ + atan2(x, −z)/2π, v = acos(y)/π from the top row; its texels are
/// three words of f32 bits, bilinear between texel centres, repeating in u.
#[inline]
pub fn environment_radiance(params: &GatherParams, texels: &[u32], direction: Vec3) -> Vec3 {
    let width = params.map.y;
    let height = params.map.z;
    if height == 0 {
        return params.environment.truncate();
    }
    // 1/2π
    let u = 0.5 + atan2(direction.x, -direction.z) * 0.159_154_94;
    let v = acos(direction.y) * FRAC_1_PI;
    let x = saturate(u) * (width as f32) - 0.5;
    let y = max(saturate(v) * (height as f32) - 0.5, 0.0);
    let (cell_x, cell_y) = (floor(x), floor(y));
    let (fx, fy) = (saturate(x - cell_x), saturate(y - cell_y));
    let x0 = if cell_x < 0.0 { width - 1 } else { min_u32(to_u32(cell_x), width - 1) };
    let x1 = if x0 + 1 >= width { 0 } else { x0 + 1 };
    let y0 = min_u32(to_u32(cell_y), height - 1);
    let y1 = min_u32(y0 + 1, height - 1);
    let top = map_texel(params, texels, x0, y0) * (1.0 - fx) + map_texel(params, texels, x1, y0) * fx;
    let bottom = map_texel(params, texels, x0, y1) * (1.0 - fx) + map_texel(params, texels, x1, y1) * fx;
    top * (1.0 - fy) + bottom * fy
}

#[inline]
fn map_texel(params: &GatherParams, texels: &[u32], x: u32, y: u32) -> Vec3 {
    let at = params.map.x + 3 * (y * params.map.y + x);
    Vec3::new(
        f32::from_bits(texels[at as usize]),
        f32::from_bits(texels[(at + 1) as usize]),
        f32::from_bits(texels[(at + 2) as usize]),
    )
}

/// Returns the radiance that leaves the hit surface toward the ray's origin on its own: emission of the front face.
#[inline]
pub fn emission_at(
    hit: &Hit,
    direction: Vec3,
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> Vec3 {
    let t = &triangles[hit.triangle as usize];
    if dot(geometric_normal(t), direction) > 0.0 {
        return Vec3::ZERO;
    }
    emitted_radiance(&materials[t.material as usize], texels, texture_coordinates(t, hit.u, hit.v))
}

/// Returns `previous` plus what pixel `index` reflects diffusely from the environment and from emissive surfaces.
#[inline]
pub fn gather_direct(
    index: u32,
    params: &GatherParams,
    surfaces: &[Surface],
    nodes: &[BvhNode],
    blocks: &[TriangleBlock],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
    previous: &[Vec4],
) -> Vec4 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return previous[index as usize];
    }
    let filter = AlphaTest { triangles, materials, texels };
    let triangle = &triangles[s.triangle as usize];
    let mut sum = Vec3::ZERO;
    for ray in 0..params.rays {
        let direction = gather_direction(params.first_pixel + index, ray, params.seed, s.normal.truncate());
        let origin = ray_origin(s.position.truncate(), triangle, direction);
        let hit = nearest_hit(nodes, blocks, &Ray { origin, direction, t_min: 0.0, t_max: 1.0e30 }, &filter);
        if hit.triangle == NO_TRIANGLE {
            sum += environment_radiance(params, texels, direction);
        } else if params.flags & GATHER_EMISSION != 0 {
            sum += emission_at(&hit, direction, triangles, materials, texels);
        }
    }
    let radiance = s.diffuse.truncate() * (sum * recip(params.rays as f32));
    previous[index as usize] + radiance.extend(0.0)
}

/// Returns the cosine-weighted openness of pixel `index` in [0, 1]: 1 where nothing occludes, and for no surface.
///
/// An occluder at distance r counts 1/(1 + λ r), and not at all beyond the reach.
#[inline]
pub fn ambient_openness(
    index: u32,
    params: &GatherParams,
    surfaces: &[Surface],
    nodes: &[BvhNode],
    blocks: &[TriangleBlock],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> f32 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return 1.0;
    }
    let filter = AlphaTest { triangles, materials, texels };
    let triangle = &triangles[s.triangle as usize];
    let mut occluded = 0.0;
    for ray in 0..params.rays {
        let direction = gather_direction(params.first_pixel + index, ray, params.seed, s.normal.truncate());
        let origin = ray_origin(s.position.truncate(), triangle, direction);
        let hit =
            nearest_hit(nodes, blocks, &Ray { origin, direction, t_min: 0.0, t_max: params.reach }, &filter);
        if hit.triangle != NO_TRIANGLE {
            occluded += recip(1.0 + params.falloff * hit.t);
        }
    }
    saturate(1.0 - div(occluded, params.rays as f32))
}

/// Returns `previous` where pixel `index` sees a surface, the environment where it sees none.
#[inline]
pub fn fill_background(
    index: u32,
    params: &CameraParams,
    environment: &[GatherParams],
    surfaces: &[Surface],
    texels: &[u32],
    previous: &[Vec4],
) -> Vec4 {
    if surfaces[index as usize].triangle != NO_TRIANGLE {
        return previous[index as usize];
    }
    let pixel = params.first_pixel + index;
    let x = (pixel % params.width) as f32 + 0.5;
    let y = (pixel / params.width) as f32 + 0.5;
    environment_radiance(&environment[0], texels, camera_direction(params, x, y)).extend(0.0)
}
