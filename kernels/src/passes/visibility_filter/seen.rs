//! How large and how bright is a proxy or a voxel, seen from a point? VF eq. 6.

use super::gather_voxels::{CLAMP_DISC, CLAMP_RADIUS, GatherVoxelsParams};
use super::gloss::mirrored;
use super::grid::Voxel;
use super::proxy::Proxy;
use crate::math::{MIN_POSITIVE, PI, abs, div, dot, max, rsqrt};
use crate::sh::lambert_intensity;
use glam::{Vec3, Vec4};

/// A/(πd² + A) or what the clamp makes of it, without cosines.
#[inline]
fn solid_share(params: &GatherVoxelsParams, squared: f32, area: f32) -> f32 {
    let disc = PI * squared;
    let whole = if params.clamp == CLAMP_DISC {
        disc + area
    } else if params.clamp == CLAMP_RADIUS {
        max(disc, area)
    } else {
        disc
    };
    // In the same place (2⁻⁶⁰ of the area) there is no direction.
    if squared > area * 8.673_617e-19 && whole > MIN_POSITIVE { div(area, whole) } else { 0.0 }
}

/// A small emitter as seen from a point.
pub(super) struct Seen {
    /// Unit direction toward it.
    pub(super) direction: Vec3,
    pub(super) inverse_distance: f32,
    /// Its share of the hemisphere's projected solid angle, without the receiver's cosine.
    pub(super) size: f32,
    pub(super) radiance: Vec3,
    /// Openness of the side that is seen: how much it counts in means.
    pub(super) openness: f32,
}

/// A proxy as seen from a point.
#[inline]
pub(super) fn see_proxy(
    params: &GatherVoxelsParams,
    from: Vec3,
    index: u32,
    proxies: &[Proxy],
    radiance: &[Vec4],
) -> Seen {
    let p = &proxies[index as usize];
    let between = p.position.truncate() - from;
    let squared = dot(between, between);
    let inverse_distance = rsqrt(max(squared, MIN_POSITIVE));
    let direction = between * inverse_distance;
    let cosine = -dot(p.normal.truncate(), direction);
    let number = 2 * index + if cosine >= 0.0 { 0 } else { 1 };
    let side = radiance[number as usize];
    let mut light = side.truncate();
    if params.lights > 0 {
        let lobes = (params.sides, params.lights);
        light += mirrored(lobes, number, -direction, params.disc_radius, inverse_distance, radiance);
    }
    Seen {
        direction,
        inverse_distance,
        size: solid_share(params, squared, p.normal.w) * abs(cosine),
        radiance: light,
        openness: side.w,
    }
}

/// What of a voxel faces a point.
struct Facing {
    light: Vec3,
    area: f32,
}

impl Facing {
    #[inline]
    fn add(&mut self, area: Vec4, light: Vec4, towards: Vec3) {
        let projected = lambert_intensity(area, towards);
        self.light += light.truncate() * projected;
        self.area += projected;
    }
}

/// All proxies of a voxel as seen from a distant point, by their sums in spherical harmonics.
#[inline]
pub(super) fn see_voxel(params: &GatherVoxelsParams, from: Vec3, v: &Voxel) -> Seen {
    let between = v.centroid.truncate() - from;
    let squared = dot(between, between);
    let inverse_distance = rsqrt(max(squared, MIN_POSITIVE));
    let direction = between * inverse_distance;
    let mut sum = Facing { light: Vec3::ZERO, area: 0.0 };
    sum.add(v.right_area, v.right_light, -direction);
    sum.add(v.left_area, v.left_light, -direction);
    sum.add(v.up_area, v.up_light, -direction);
    sum.add(v.down_area, v.down_light, -direction);
    sum.add(v.near_area, v.near_light, -direction);
    sum.add(v.far_area, v.far_light, -direction);
    let area = sum.area;
    if !(area > MIN_POSITIVE) || !(v.mean_area > MIN_POSITIVE) {
        return Seen { direction, inverse_distance, size: 0.0, radiance: Vec3::ZERO, openness: 1.0 };
    }
    let radiance = Vec3::new(div(sum.light.x, area), div(sum.light.y, area), div(sum.light.z, area));
    // As many proxies of mean area as make up the projected area.
    let size = solid_share(params, squared, v.mean_area) * div(area, v.mean_area);
    Seen { direction, inverse_distance, size, radiance, openness: 1.0 }
}

/// Whether a voxel counts proxy by proxy: its centroid is nearer than R, or some of its proxies mirror a light.
#[inline]
pub(super) fn counts_singly(params: &GatherVoxelsParams, from: Vec3, v: &Voxel) -> bool {
    let between = v.centroid.truncate() - from;
    v.glossy > 0 || dot(between, between) < params.near_range * params.near_range
}
