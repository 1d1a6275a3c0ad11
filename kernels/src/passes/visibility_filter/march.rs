//! Which voxel does a ray of a coarse pixel see first? VF §3.1, sparse shadow rays.

use super::grid::{GridParams, voxel_number};
use super::proxy::Proxy;
use crate::geometry::bvh::{BvhNode, NO_TRIANGLE, Ray, TriangleBlock, nearest_hit};
use crate::geometry::disc::ray_disc;
use crate::geometry::voxel_walk::VoxelWalk;
use crate::math::{div, dot, max, normalize_or, recip};
use crate::passes::gather::turned_direction;
use crate::passes::material::{AlphaTest, mirror_direction};
use crate::passes::scene::{Material, Triangle};
use crate::passes::surface::{Surface, ray_origin};
use crate::sampling::halton::{halton, rotated};
use crate::sampling::hash::{combine, position_hash, unit_float};
use crate::sampling::hemisphere::{phong_lobe_direction, to_world};
use crate::sampling::voxel_hash::encode;
use glam::{UVec4, Vec2, Vec3, Vec4};

/// No voxel: the ray leaves the scene.
pub const NO_VOXEL: u32 = 0xFFFF_FFFF;
/// Bit of [`MarchParams::flags`]: a place in the world chooses the directions, not the pixel.
pub const WORLD_ANCHORED: u32 = 1;
/// The coverage of a pixel without a specular lobe.
pub const NO_LOBE: f32 = -1.0;
/// Longest way of a ray, metres.
const FAR: f32 = 1.0e30;

gpu_struct! {
    /// Parameters of the passes that send rays from coarse pixels.
    pub struct MarchParams {
        /// Lower corner of both grids; w is 0.
        pub lower: Vec4,
        /// 1/(cell edge) along each axis of the grid that rays walk through; w is 0.
        pub cell_inverse_size: Vec4,
        /// Its cells along each axis; w is their number.
        pub cell_dims: UVec4,
        /// 1/(voxel edge) along each axis of the grid of voxels; w is 0.
        pub voxel_inverse_size: Vec4,
        /// Its voxels along each axis; w is their number.
        pub voxel_dims: UVec4,
        /// Position of the eye; w is 0.
        pub eye: Vec4,
        /// Rays per pixel over the cosine-weighted hemisphere, at least 1.
        pub diffuse_rays: u32,
        /// Rays per pixel in the specular lobe; 0 in scenes without gloss.
        pub lobe_rays: u32,
        /// Seed of the directions.
        pub seed: u32,
        /// [`WORLD_ANCHORED`].
        pub flags: u32,
        /// Cells per metre of the places that choose directions.
        pub cells_per_length: f32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

/// The proxy that a ray meets.
#[derive(Clone, Copy)]
pub struct ProxyHit {
    /// Index of the proxy, [`NO_VOXEL`] for none.
    pub proxy: u32,
    /// The ray's parameter there.
    pub t: f32,
}

/// What a ray through the grid starts from, and what it wants to know.
#[derive(Clone, Copy)]
#[cfg_attr(not(target_arch = "spirv"), derive(Debug))]
pub struct ProxyRay {
    /// Start in metres.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// 1 where the start is on the front of its triangle, −1 on the back, 0 in free space.
    ///
    /// From a surface, a disc that the ray leaves through its back within two radii is the surface's own: on curved
    /// surfaces and at edges discs stand out.
    pub side: f32,
}

/// Whether a disc can be met: its centre is within a radius of the ray's line, with 4e-6·|o − c|² for rounding.
#[inline]
fn near_line(ray: &ProxyRay, p: &Proxy) -> bool {
    let to_center = p.position.truncate() - ray.origin;
    let along = dot(to_center, ray.direction);
    let squared = dot(to_center, to_center);
    squared - along * along <= p.position.w * p.position.w + 4.0e-6 * squared
}

/// Returns the proxy that the ray meets first, cell by cell from its start; it ends with the first cell that has one.
#[inline]
pub fn trace_proxies(
    grid: &GridParams,
    starts: &[u32],
    pairs: &[u32],
    proxies: &[Proxy],
    ray: &ProxyRay,
) -> ProxyHit {
    let inverse = grid.inverse_size.truncate();
    let origin = (ray.origin - grid.lower.truncate()) * inverse;
    let dims = grid.dims.truncate();
    let mut walk = VoxelWalk::new(origin, ray.direction * inverse, dims, FAR);
    let mut hit = ProxyHit { proxy: NO_VOXEL, t: FAR };
    while walk.inside {
        let cell = encode(walk.voxel, dims);
        let end = starts[(cell + 1) as usize];
        // Discs reach into the voxel, and the crossing is rounded.
        let t_max = walk.t_exit * 1.000_01;
        for i in starts[cell as usize]..end {
            let index = pairs[(2 * i + 1) as usize];
            let p = &proxies[index as usize];
            if !near_line(ray, p) {
                continue;
            }
            let normal = p.normal.truncate();
            let center = p.position.truncate();
            let d = ray_disc(ray.origin, ray.direction, center, normal, p.position.w, 0.0, t_max);
            if !d.hit || d.t >= hit.t {
                continue;
            }
            let own = ray.side * dot(ray.direction, normal) > 0.0 && d.t < 2.0 * p.position.w;
            if own {
                continue;
            }
            hit = ProxyHit { proxy: index, t: d.t };
        }
        if hit.proxy != NO_VOXEL {
            return hit;
        }
        walk.step();
    }
    hit
}

/// The word that turns the directions of a pixel.
#[inline]
fn turn(pixel: u32, params: &MarchParams, position: Vec3) -> u32 {
    if params.flags & WORLD_ANCHORED != 0 {
        combine(params.seed, position_hash(position, params.cells_per_length))
    } else {
        combine(params.seed, pixel)
    }
}

/// The direction of ray `ray` in the lobe of exponent n about the mirror image of the view.
#[inline]
fn lobe_direction(turn: u32, ray: u32, exponent: f32, to_viewer: Vec3, normal: Vec3) -> Vec3 {
    let point = halton(ray);
    let u = Vec2::new(
        rotated(point.x, unit_float(combine(turn, 2))),
        rotated(point.y, unit_float(combine(turn, 3))),
    );
    to_world(phong_lobe_direction(u, exponent), mirror_direction(normal, to_viewer))
}

/// Whether the surface has a specular lobe.
#[inline]
pub(super) fn is_glossy(gloss: Vec4) -> bool {
    max(max(gloss.x, gloss.y), gloss.z) > 0.0
}

/// Returns the direction of ray `index` % rays of pixel `index` / rays, 0 for one that is not sent.
#[inline]
fn ray_direction(index: u32, params: &MarchParams, s: &Surface, gloss: &[Vec4]) -> Vec3 {
    let rays = params.diffuse_rays + params.lobe_rays;
    let pixel = index / rays;
    let ray = index - pixel * rays;
    let position = s.position.truncate();
    let normal = s.normal.truncate();
    let turn = turn(pixel, params, position);
    if ray < params.diffuse_rays {
        return turned_direction(turn, ray, normal);
    }
    let lobe = gloss[pixel as usize];
    if !is_glossy(lobe) {
        return Vec3::ZERO;
    }
    let to_viewer = normalize_or(params.eye.truncate() - position, normal);
    let direction = lobe_direction(turn, ray - params.diffuse_rays, lobe.w, to_viewer, normal);
    if dot(direction, normal) > 0.0 { direction } else { Vec3::ZERO }
}

/// The grid that rays walk through, made for the discs: few of them in each cell.
#[inline]
fn cells(params: &MarchParams) -> GridParams {
    GridParams {
        lower: params.lower,
        inverse_size: params.cell_inverse_size,
        dims: params.cell_dims,
        proxies: 0,
        pairs: 0,
        weighted: 0,
        lights: 0,
    }
}

/// The grid of the voxels that lists name.
#[inline]
fn voxels(params: &MarchParams) -> GridParams {
    GridParams { inverse_size: params.voxel_inverse_size, dims: params.voxel_dims, ..cells(params) }
}

/// Returns the voxel of the proxy that ray `index` meets first, [`NO_VOXEL`] for none.
///
/// Rays of a pixel follow each other: first those over the hemisphere, then those in the specular lobe. `gloss` is not
/// read when there are none of the latter.
#[inline]
pub fn march_rays(
    index: u32,
    params: &MarchParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    starts: &[u32],
    pairs: &[u32],
    proxies: &[Proxy],
) -> u32 {
    let s = surfaces[(index / (params.diffuse_rays + params.lobe_rays)) as usize];
    if s.triangle == NO_TRIANGLE {
        return NO_VOXEL;
    }
    let direction = ray_direction(index, params, &s, gloss);
    if direction == Vec3::ZERO {
        return NO_VOXEL;
    }
    let ray = ProxyRay { origin: s.position.truncate(), direction, side: s.normal.w };
    let hit = trace_proxies(&cells(params), starts, pairs, proxies, &ray);
    if hit.proxy == NO_VOXEL {
        NO_VOXEL
    } else {
        voxel_number(&voxels(params), proxies[hit.proxy as usize].position.truncate())
    }
}

/// Returns the voxel of the triangle that ray `index` meets first: [`march_rays`] without discs.
#[inline]
pub fn trace_rays(
    index: u32,
    params: &MarchParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    nodes: &[BvhNode],
    blocks: &[TriangleBlock],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> u32 {
    let s = surfaces[(index / (params.diffuse_rays + params.lobe_rays)) as usize];
    if s.triangle == NO_TRIANGLE {
        return NO_VOXEL;
    }
    let direction = ray_direction(index, params, &s, gloss);
    if direction == Vec3::ZERO {
        return NO_VOXEL;
    }
    let origin = ray_origin(s.position.truncate(), &triangles[s.triangle as usize], direction);
    let filter = AlphaTest { triangles, materials, texels };
    let hit = nearest_hit(nodes, blocks, &Ray { origin, direction, t_min: 0.0, t_max: FAR }, &filter);
    if hit.triangle == NO_TRIANGLE {
        NO_VOXEL
    } else {
        voxel_number(&voxels(params), origin + direction * hit.t)
    }
}

/// Returns the share of the specular lobe that ends on the scene, times the cosine: the mean over the lobe's rays.
///
/// (n + 2)/(n + 1) · mean(cos θ · hit): what the lobe reflects where everything has radiance 1; [`NO_LOBE`] without gloss.
/// `voxels` is what [`march_rays`] found.
#[inline]
pub fn lobe_coverage(
    index: u32,
    params: &MarchParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    voxels: &[u32],
) -> f32 {
    let s = surfaces[index as usize];
    let lobe = gloss[index as usize];
    if s.triangle == NO_TRIANGLE || !is_glossy(lobe) || params.lobe_rays == 0 {
        return NO_LOBE;
    }
    let first = index * (params.diffuse_rays + params.lobe_rays);
    let mut sum = 0.0;
    for ray in params.diffuse_rays..params.diffuse_rays + params.lobe_rays {
        if voxels[(first + ray) as usize] != NO_VOXEL {
            sum += max(0.0, dot(ray_direction(first + ray, params, &s, gloss), s.normal.truncate()));
        }
    }
    let n = max(lobe.w, 0.0);
    div(sum, params.lobe_rays as f32) * ((n + 2.0) * recip(n + 1.0))
}
