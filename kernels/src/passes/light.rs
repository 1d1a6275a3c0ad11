//! How much light arrives from sources without extent, and what does the surface make of it?

use super::material::{AlphaTest, phong_lobe};
use super::scene::{LIGHT_SPOT, LIGHT_SUN, Light, Material, Triangle};
use super::surface::{Surface, ray_origin};
use crate::geometry::bvh::{BvhNode, NO_TRIANGLE, Ray, TriangleBlock, any_hit};
use crate::math::{FRAC_1_PI, acos, div, dot, max, normalize_or, recip, saturate};
use glam::{Vec3, Vec4};

/// Lights whose visibility fits into one word.
pub const LIGHTS_PER_WORD: u32 = 32;

gpu_struct! {
    /// Parameters of the passes over lights.
    pub struct LightParams {
        /// Position of the eye; w is 0.
        pub eye: Vec4,
        /// First light of this run.
        pub first_light: u32,
        /// Number of lights of this run, at most [`LIGHTS_PER_WORD`].
        pub light_count: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }
}

/// What a light sends to a point.
#[derive(Clone, Copy)]
pub struct Incident {
    /// Unit direction toward the light.
    pub direction: Vec3,
    /// Distance in metres, 1e30 for a sun.
    pub distance: f32,
    /// Irradiance on a surface that faces the light, W/m².
    pub irradiance: Vec3,
}

/// Returns what the light sends to a point, were nothing in between: I/d² for points and spots.
///
/// At the light itself (d² < 2⁻¹²⁶) nothing arrives.
#[inline]
pub fn incident_light(light: &Light, point: Vec3) -> Incident {
    if light.kind == LIGHT_SUN {
        return Incident {
            direction: -light.direction.truncate(),
            distance: 1.0e30,
            irradiance: light.intensity.truncate(),
        };
    }
    let to_light = light.position.truncate() - point;
    let squared = dot(to_light, to_light);
    let direction = normalize_or(to_light, Vec3::Y);
    if squared < crate::math::MIN_POSITIVE {
        return Incident { direction, distance: 0.0, irradiance: Vec3::ZERO };
    }
    let mut share = recip(squared);
    if light.kind == LIGHT_SPOT {
        share *= spot_share(light, direction);
    }
    Incident {
        direction,
        distance: crate::math::sqrt(squared),
        irradiance: light.intensity.truncate() * share,
    }
}

/// Returns the share of a spot's intensity toward a point: linear in the angle between the half angles.
#[inline]
fn spot_share(light: &Light, to_light: Vec3) -> f32 {
    let cosine = -dot(light.direction.truncate(), to_light);
    let angle = acos(cosine);
    if angle >= light.outer {
        0.0
    } else if angle <= light.inner {
        1.0
    } else {
        saturate(div(light.outer - angle, light.outer - light.inner))
    }
}

/// Returns bit i set where light `first_light` + i is visible from the surface of pixel `index` and lights it.
#[inline]
pub fn light_visibility(
    index: u32,
    params: &LightParams,
    surfaces: &[Surface],
    lights: &[Light],
    nodes: &[BvhNode],
    blocks: &[TriangleBlock],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> u32 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return 0;
    }
    let position = s.position.truncate();
    let normal = s.normal.truncate();
    let triangle = &triangles[s.triangle as usize];
    let filter = AlphaTest { triangles, materials, texels };
    let mut visible = 0u32;
    for i in 0..params.light_count {
        let light = &lights[(params.first_light + i) as usize];
        let incident = incident_light(light, position);
        let e = incident.irradiance;
        if dot(incident.direction, normal) > 0.0 && max(max(e.x, e.y), e.z) > 0.0 {
            let origin = ray_origin(position, triangle, incident.direction);
            let ray = shadow_ray(light, origin, incident.direction);
            if !any_hit(nodes, blocks, &ray, &filter) {
                visible |= 1 << i;
            }
        }
    }
    visible
}

/// Returns the ray from `origin` to the light; `direction` is a sun's.
#[inline]
pub fn shadow_ray(light: &Light, origin: Vec3, direction: Vec3) -> Ray {
    if light.kind == LIGHT_SUN {
        Ray { origin, direction, t_min: 0.0, t_max: 1.0e30 }
    } else {
        // To the light's own position, so that a rounded direction cannot miss it; 1 is the light.
        Ray { origin, direction: light.position.truncate() - origin, t_min: 0.0, t_max: 1.0 - 1.0e-5 }
    }
}

/// The irradiance of a surface by a light that it sees.
#[inline]
pub(super) fn irradiance_on(light: &Light, s: &Surface) -> Vec3 {
    let incident = incident_light(light, s.position.truncate());
    incident.irradiance * max(0.0, dot(incident.direction, s.normal.truncate()))
}

/// What a lobe of this exponent (w) reflects of a light that the surface sees toward the eye, for a specular colour of 1.
#[inline]
pub(super) fn lobe_radiance(light: &Light, s: &Surface, exponent: f32, eye: Vec3) -> Vec3 {
    let (position, normal) = (s.position.truncate(), s.normal.truncate());
    let to_viewer = normalize_or(eye - position, normal);
    let incident = incident_light(light, position);
    let reflected = phong_lobe(normal, to_viewer, incident.direction, exponent);
    let cosine = max(0.0, dot(incident.direction, normal));
    incident.irradiance * (cosine * reflected)
}

/// Returns `previous` plus the radiance that pixel `index` reflects diffusely from the visible lights of this run.
#[inline]
pub fn shade_diffuse(
    index: u32,
    params: &LightParams,
    surfaces: &[Surface],
    lights: &[Light],
    visibility: &[u32],
    previous: &[Vec4],
) -> Vec4 {
    let s = &surfaces[index as usize];
    let visible = visibility[index as usize];
    let mut irradiance = Vec3::ZERO;
    for i in 0..params.light_count {
        if visible & (1 << i) != 0 {
            irradiance += irradiance_on(&lights[(params.first_light + i) as usize], s);
        }
    }
    let radiance = s.diffuse.truncate() * irradiance * FRAC_1_PI;
    previous[index as usize] + radiance.extend(0.0)
}

/// Returns `previous` plus the radiance that pixel `index` reflects in its specular lobe from the visible lights.
#[inline]
pub fn shade_specular(
    index: u32,
    params: &LightParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    lights: &[Light],
    visibility: &[u32],
    previous: &[Vec4],
) -> Vec4 {
    let s = &surfaces[index as usize];
    let visible = visibility[index as usize];
    let lobe = gloss[index as usize];
    let mut radiance = Vec3::ZERO;
    for i in 0..params.light_count {
        if visible & (1 << i) != 0 {
            let light = &lights[(params.first_light + i) as usize];
            radiance += lobe_radiance(light, s, lobe.w, params.eye.truncate());
        }
    }
    previous[index as usize] + (radiance * lobe.truncate()).extend(0.0)
}
