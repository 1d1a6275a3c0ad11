//! What does each texel of a light's map reflect? LRSM §3 and table 1; Dachsbacher, Stamminger 2005.

use super::lookup::LEAST_LIT_COSINE;
use crate::geometry::bvh::{Hit, NO_TRIANGLE};
use crate::math::{FRAC_1_PI, div, dot, max, min};
use crate::passes::light::incident_light;
use crate::passes::scene::{Light, Material, Triangle};
use crate::passes::surface::surface_at;
use crate::passes::voxel_cones::lobes::pack_mean;
use crate::passes::voxel_cones::storage::pack_radiance;

gpu_struct! {
    /// Parameters of [`reflect_light`].
    pub struct ReflectParams {
        /// The light.
        pub light: u32,
        /// Units of stored radiance per W/(m² sr).
        pub radiance_scale: f32,
        /// 0 tells radiance, else flux.
        pub flux: u32,
        /// 1 over the squared depth that flux is told for, 1/m²; 0 for parallel rays.
        pub inverse_squared: f32,
    }

    /// A texel of a reflective shadow map. Squared depths are left to who filters.
    pub struct ReflectiveTexel {
        /// Diffusely reflected radiance ρE⟨n·l⟩/π as published, or the flux ρE/π·(depth/farthest)² for each ray, which neither distance
        /// nor slant changes: what is filtered is then as smooth as albedo and intensity are. In stored units, RGB9E5.
        pub radiance: u32,
        /// Unit normal on the light's side, ten bits each.
        pub normal: u32,
        /// Depth along the light's ray, metres.
        pub depth: f32,
        /// ⟨n·l⟩ in [0, 1]; −1 where the light's ray meets nothing: the texel's opacity.
        pub cosine: f32,
    }
}

/// Returns what texel `index` of a light's map reflects of the light.
#[inline]
pub fn reflect_light(
    index: u32,
    params: &ReflectParams,
    hits: &[Hit],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
    lights: &[Light],
) -> ReflectiveTexel {
    let hit = hits[index as usize];
    if hit.triangle == NO_TRIANGLE {
        return ReflectiveTexel { radiance: 0, normal: 0, depth: 0.0, cosine: -1.0 };
    }
    let t = &triangles[hit.triangle as usize];
    let w = (1.0 - hit.u) - hit.v;
    let point = (t.p0.truncate() * w + t.p1.truncate() * hit.u) + t.p2.truncate() * hit.v;
    let incident = incident_light(&lights[params.light as usize], point);
    let s = surface_at(&hit, -incident.direction, triangles, materials, texels);
    let normal = s.normal.truncate();
    let cosine = min(max(dot(normal, incident.direction), 0.0), 1.0);
    let mut radiance =
        s.diffuse.truncate() * incident.irradiance * (cosine * FRAC_1_PI * params.radiance_scale);
    if params.flux != 0 {
        let squared = if params.inverse_squared > 0.0 { hit.t * hit.t * params.inverse_squared } else { 1.0 };
        radiance *= div(squared, max(cosine, LEAST_LIT_COSINE));
    }
    ReflectiveTexel { radiance: pack_radiance(radiance), normal: pack_mean(normal), depth: hit.t, cosine }
}
