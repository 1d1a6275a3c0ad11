//! What does each texel of a light's map reflect? LRSM §3 and table 1; Dachsbacher, Stamminger 2005.

use crate::geometry::bvh::{Hit, NO_TRIANGLE};
use crate::math::{FRAC_1_PI, dot, max, min};
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
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }

    /// A texel of a reflective shadow map. Squared depths are left to who filters.
    pub struct ReflectiveTexel {
        /// Diffusely reflected radiance ρE⟨n·l⟩/π in stored units, RGB9E5.
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
    let radiance = s.diffuse.truncate() * incident.irradiance * (cosine * FRAC_1_PI * params.radiance_scale);
    ReflectiveTexel { radiance: pack_radiance(radiance), normal: pack_mean(normal), depth: hit.t, cosine }
}
