//! Where do point proxies lie, and which surfaces do they stand for? VF §3.1.

use crate::geometry::bvh::{Hit, NO_TRIANGLE};
use crate::math::{cross, div, length};
use crate::passes::material::{base_color, texture_coordinates};
use crate::passes::scan::owner;
use crate::passes::scene::{MATERIAL_MASKED, Material, Triangle};
use crate::passes::surface::{Surface, geometric_normal, surface_at};
use crate::sampling::halton::halton;
use crate::sampling::hash::{combine, position_hash};
use crate::sampling::hemisphere::{fold_barycentrics, triangle_point};
use crate::sampling::roulette::sample_count;
use glam::{Vec3, Vec4};

gpu_struct! {
    /// Parameters of the passes that make proxies.
    pub struct ProxyParams {
        /// Proxies per square metre.
        pub density: f32,
        /// Radius of every disc, metres.
        pub radius: f32,
        /// Cells per metre of the positions that decide the roulette: finer than the smallest triangle.
        pub cells_per_length: f32,
        /// Seed of the roulette and of the places within triangles.
        pub seed: u32,
        /// Number of triangles.
        pub triangles: u32,
        /// Number of proxies.
        pub proxies: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }

    /// A disc that stands for the surface around it.
    pub struct Proxy {
        /// Centre in metres; w is the radius, 0 for one that fell into a hole of the material.
        pub position: Vec4,
        /// Unit normal by the triangle's winding; w is the area it stands for in m², 0 in a hole.
        pub normal: Vec4,
        /// Index of its triangle.
        pub triangle: u32,
        /// Barycentric weight of the triangle's second corner.
        pub u: f32,
        /// Barycentric weight of its third corner.
        pub v: f32,
        /// Padding.
        pub pad: u32,
    }
}

/// Returns the triangle's area in m².
#[inline]
pub fn triangle_area(t: &Triangle) -> f32 {
    let a = t.p0.truncate();
    0.5 * length(cross(t.p1.truncate() - a, t.p2.truncate() - a))
}

/// The random word of a triangle, by its place: the same in every frame and for any order of triangles.
#[inline]
fn triangle_hash(params: &ProxyParams, t: &Triangle) -> u32 {
    // 1/3
    let centroid = ((t.p0.truncate() + t.p1.truncate()) + t.p2.truncate()) * 0.333_333_34;
    combine(params.seed, position_hash(centroid, params.cells_per_length))
}

/// Returns how many proxies triangle `index` gets: its area times the density on average.
///
/// The fraction of a proxy is decided by roulette on a hash of the place, accepted when the hash is *below* it; VF's
/// sentence reads the other way round and would favour small triangles.
#[inline]
pub fn proxy_counts(index: u32, params: &ProxyParams, triangles: &[Triangle]) -> u32 {
    let t = &triangles[index as usize];
    sample_count(triangle_area(t) * params.density, triangle_hash(params, t))
}

/// Returns the last of the ascending `starts` that is at most `index`; `starts[0]` is 0.
///
/// Returns proxy `index`: the next Halton point of its triangle, from a start that the triangle's hash chooses.
///
/// `starts` is the exclusive scan of [`proxy_counts`]. A triangle that earned at least one proxy shares its area
/// among those it has, so that the areas add up exactly; one that earned less stands for 1/density.
#[inline]
pub fn make_proxies(
    index: u32,
    params: &ProxyParams,
    starts: &[u32],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> Proxy {
    let triangle = owner(starts, params.triangles, index);
    let t = &triangles[triangle as usize];
    let start = starts[triangle as usize];
    let next = if triangle + 1 < params.triangles { starts[(triangle + 1) as usize] } else { params.proxies };
    // Hashed again: the roulette left only small hashes to triangles below one proxy.
    let offset = combine(triangle_hash(params, t), 1) & 0xFFFF;
    let weights = fold_barycentrics(halton(offset + (index - start)));
    let position = triangle_point(t.p0.truncate(), t.p1.truncate(), t.p2.truncate(), weights);
    let whole = triangle_area(t);
    let area = if whole * params.density >= 1.0 {
        div(whole, (next - start) as f32)
    } else {
        div(1.0, params.density)
    };
    let m = &materials[t.material as usize];
    let hole = m.flags & MATERIAL_MASKED != 0
        && base_color(m, texels, texture_coordinates(t, weights.y, weights.z)).w < m.cutoff;
    let radius = if hole { 0.0 } else { params.radius };
    Proxy {
        position: position.extend(radius),
        normal: geometric_normal(t).extend(if hole { 0.0 } else { area }),
        triangle,
        u: weights.y,
        v: weights.z,
        pad: 0,
    }
}

/// Returns the proxy as a surface that is seen from one side: its front at even `index`, its back at odd.
#[inline]
pub fn proxy_surfaces(
    index: u32,
    params: &ProxyParams,
    proxies: &[Proxy],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> Surface {
    let _ = params;
    let p = &proxies[(index / 2) as usize];
    let towards: Vec3 = if index & 1 == 0 { -p.normal.truncate() } else { p.normal.truncate() };
    let triangle = if p.position.w > 0.0 { p.triangle } else { NO_TRIANGLE };
    surface_at(&Hit { t: 0.0, u: p.u, v: p.v, triangle }, towards, triangles, materials, texels)
}
