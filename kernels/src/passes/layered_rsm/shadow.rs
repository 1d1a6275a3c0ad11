//! How much of a light with an extent does a surface see? LRSM §6, after Crassin 2011: a cone as wide as the light.

use super::trace::occluders;
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{FRAC_1_PI, div, dot, exp, max};
use crate::passes::light::{LightParams, incident_light, irradiance_on, lobe_radiance};
use crate::passes::scene::{LIGHT_SUN, Light};
use crate::passes::surface::Surface;
use crate::passes::voxel_cones::march::{Ray, march};
use crate::passes::voxel_cones::trace::{ConeParams, on_lattice};
use glam::Vec4;

/// Voxels before a light that hide nothing of it: as far as the last sample reaches.
const END: f32 = 2.0;
const THIRD: f32 = 0.333_333_34;

/// Returns the share of light `params.light` that pixel `index` sees, in [0, 1]; 0 where it does not reach.
#[inline]
pub fn shadow_cone(
    index: u32,
    params: &ConeParams,
    surfaces: &[Surface],
    lights: &[Light],
    voxels: &[u32],
) -> f32 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return 0.0;
    }
    let light = &lights[params.light as usize];
    let (position, normal) = (s.position.truncate(), s.normal.truncate());
    let incident = incident_light(light, position);
    let e = incident.irradiance;
    if !(dot(incident.direction, normal) > 0.0 && max(max(e.x, e.y), e.z) > 0.0) {
        return 0.0;
    }
    let sun = light.kind == LIGHT_SUN;
    let ray = Ray {
        origin: on_lattice(params, position),
        direction: incident.direction,
        normal,
        tangent: if sun { params.extent } else { div(params.extent, max(incident.distance, 1.0e-18)) },
        // What the light stands in or before does not hide it.
        reach: if sun {
            params.reach
        } else {
            (incident.distance - params.extent) * params.inverse_edge - END
        },
    };
    let medium = occluders(params, voxels);
    let met = march(params, &ray, &medium);
    // What hides a part of the light hides the same part of it all the way through: both of a box's sides, or a wall of several
    // voxels, are one occluder. The densest tells that part:
    // depths are twice those that stop the covered share, of half as much again as a voxel.
    if medium.mean { met.through } else { exp(-met.densest * THIRD) }
}

/// Returns `previous` plus the radiance that pixel `index` reflects diffusely of light `params.first_light`, of which it sees
/// `visible`.
#[inline]
pub fn shade_soft_diffuse(
    index: u32,
    params: &LightParams,
    surfaces: &[Surface],
    lights: &[Light],
    visible: &[f32],
    previous: &[Vec4],
) -> Vec4 {
    let share = visible[index as usize];
    if !(share > 0.0) {
        return previous[index as usize];
    }
    let s = &surfaces[index as usize];
    let irradiance = irradiance_on(&lights[params.first_light as usize], s);
    previous[index as usize] + (s.diffuse.truncate() * irradiance * (FRAC_1_PI * share)).extend(0.0)
}

/// Returns `previous` plus what pixel `index` reflects of that light in its specular lobe.
#[inline]
pub fn shade_soft_specular(
    index: u32,
    params: &LightParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    lights: &[Light],
    visible: &[f32],
    previous: &[Vec4],
) -> Vec4 {
    let share = visible[index as usize];
    if !(share > 0.0) {
        return previous[index as usize];
    }
    let (s, lobe) = (&surfaces[index as usize], gloss[index as usize]);
    let light = &lights[params.first_light as usize];
    let radiance = lobe_radiance(light, s, lobe.w, params.eye.truncate());
    previous[index as usize] + (radiance * lobe.truncate() * share).extend(0.0)
}
