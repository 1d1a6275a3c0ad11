//! How much light do the visible voxels send to a pixel? VF §3.3, eqs. 5–7.
//!
//! A pixel reads the lists of the four coarse pixels around it, each with its weight. A voxel nearer than R counts
//! proxy by proxy, a farther one by its sum in spherical harmonics. Two readings of eq. 5 are offered:
//!
//! - *sum* (the paper's): every proxy of a listed voxel sends its light, as if nothing stood between; N_c is the sum
//!   of weights. Too bright where a voxel is partly hidden, too dark where rays missed one.
//! - *share*: a voxel sends its mean radiance from a solid angle Ω, and N_c = ΣΩ over the share of rays that met
//!   anything. Ω is that of the proxies where the share of rays that met the voxel agrees with it, that share where it
//!   does not: smooth in the open, right behind what hides. A closed room of radiance 1 gives 1 with any settings.

use super::grid::Voxel;
use super::list::ListHeader;
use super::merged_lists::{DONE, Lists, Member, cells, weights};
use super::proxy::Proxy;
use super::seen::{counts_singly, see_proxy, see_voxel};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{MIN_POSITIVE, div, dot, exp_minus_one, max};
use crate::passes::surface::Surface;
use glam::{Vec3, Vec4};

/// Bit of [`GatherVoxelsParams::flags`]: voxels count by the share of rays that met them.
pub const GATHER_SHARE: u32 = 1;
/// [`GatherVoxelsParams::clamp`]: A/(πd² + A), the form factor of a disc.
pub const CLAMP_DISC: u32 = 0;
/// [`GatherVoxelsParams::clamp`]: A/max(πd², A), constant within the disc's radius.
pub const CLAMP_RADIUS: u32 = 1;
/// [`GatherVoxelsParams::clamp`]: A/πd², unbounded.
pub const CLAMP_NONE: u32 = 2;

/// Cosines at the receiver below this count as this one for distant voxels: part of one may be above the horizon.
const LEAST_COSINE: f32 = 1.0e-3;
gpu_struct! {
    /// Parameters of the passes that gather the light of voxels.
    pub struct GatherVoxelsParams {
        /// Position of the eye; w is 0.
        pub eye: Vec4,
        /// Pixels in a row of the picture that is gathered.
        pub width: u32,
        /// Row-major number of the first pixel of the band.
        pub first_pixel: u32,
        /// Coarse pixels in a row.
        pub coarse_width: u32,
        /// Rows of coarse pixels.
        pub coarse_height: u32,
        /// Coarse pixels per pixel, across.
        pub scale_x: f32,
        /// Coarse pixels per pixel, down.
        pub scale_y: f32,
        /// R in metres: voxels nearer than this count proxy by proxy.
        pub near_range: f32,
        /// Standard deviation of the distance from the pixel's plane, as a share of its distance from the eye.
        pub depth_deviation: f32,
        /// Standard deviation of 1 − N·N′.
        pub normal_deviation: f32,
        /// σ_θ of eq. 7; 0 weighs by the surface's own lobe cosᴺˢ.
        pub specular_deviation: f32,
        /// Voxels that a list has room for.
        pub capacity: u32,
        /// [`GATHER_SHARE`].
        pub flags: u32,
        /// [`CLAMP_DISC`], [`CLAMP_RADIUS`] or [`CLAMP_NONE`].
        pub clamp: u32,
        /// Standard errors by which a share of rays may differ from the proxies' solid angle before it counts more.
        pub trust: f32,
        /// Radius of the discs in metres: what a lobe cannot resolve.
        pub disc_radius: f32,
        /// Lights whose mirrored lobes stand behind the sides' radiance; 0 if none do.
        pub lights: u32,
        /// Number of sides: twice the proxies.
        pub sides: u32,
        /// n of eq. 7 for all surfaces; 0 takes it from each surface's lobe.
        pub specular_exponent: f32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }
}

/// Returns the light that arrives at pixel `index` from visible voxels: irradiance/π, and in w how many there are.
///
/// Times the albedo it is reflected radiance. VF eqs. 5 and 6; by *sum* or by *share*, see the module.
#[inline]
pub fn gather_diffuse(
    index: u32,
    params: &GatherVoxelsParams,
    surfaces: &[Surface],
    headers: &[ListHeader],
    lists: &[u32],
    voxels: &[Voxel],
    proxies: &[Proxy],
    radiance: &[Vec4],
) -> Vec4 {
    let s = surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return Vec4::ZERO;
    }
    let (from, normal) = (s.position.truncate(), s.normal.truncate());
    let cells = cells(index, params);
    let weights = weights(params, &cells, &s, headers);
    let mut merged = Lists::new(params, &cells, &weights, lists);
    let by_share = params.flags & GATHER_SHARE != 0;
    let (mut sum, mut whole) = (Vec3::ZERO, 0.0);
    let mut visible = 0.0;
    let mut member = merged.take(lists);
    while member.voxel != DONE {
        visible += 1.0;
        let v = &voxels[member.voxel as usize];
        if by_share && !(member.share > 0.0) {
            // Only rays of specular lobes met it.
        } else if by_share {
            let (light, size) = voxel_light(params, from, normal, v, proxies, radiance);
            if size > MIN_POSITIVE {
                let seen = seen_share(params, size, &member, merged.rays);
                sum += light * div(seen, size);
                whole += seen;
            }
        } else if v.lit > 0 {
            let (light, _) = voxel_light(params, from, normal, v, proxies, radiance);
            sum += light * member.weight;
        }
        member = merged.take(lists);
    }
    if by_share {
        sum = if whole > MIN_POSITIVE { sum * div(merged.met, whole) } else { Vec3::ZERO };
    }
    sum.extend(visible)
}

/// Returns the share of the hemisphere that a voxel fills, from what its proxies fill and what the rays say.
///
/// The proxies' share F is exact for a voxel in the open; the rays' share is right in any case but noisy, with a variance
/// of F/N. With δ their difference and T = trust·√(F/N): F + δ·δ²/(δ² + T²). A voxel that is found at all by N rays with
/// probability 1 − e^(−NF) counts F over it, so that those which are missed are made up for.
#[inline]
fn seen_share(params: &GatherVoxelsParams, size: f32, member: &Member, rays: f32) -> f32 {
    let hits = rays * size;
    // Beyond 16 the probability is 1 − 1e-7.
    let found = if hits < 16.0 { -exp_minus_one(-hits) } else { 1.0 };
    let expected = if found > MIN_POSITIVE { div(size * member.weight, found) } else { 0.0 };
    let difference = member.share - expected;
    let squared = difference * difference;
    let noise = (params.trust * params.trust) * div(size, max(rays, 1.0));
    let all = squared + noise;
    if all > MIN_POSITIVE { expected + difference * div(squared, all) } else { expected }
}

/// The light of a voxel (radiance × projected solid angle/π) and its projected solid angle/π.
#[inline]
fn voxel_light(
    params: &GatherVoxelsParams,
    from: Vec3,
    normal: Vec3,
    v: &Voxel,
    proxies: &[Proxy],
    radiance: &[Vec4],
) -> (Vec3, f32) {
    let by_share = params.flags & GATHER_SHARE != 0;
    let least = if by_share { LEAST_COSINE } else { 0.0 };
    if !counts_singly(params, from, v) {
        let seen = see_voxel(params, from, v);
        let size = seen.size * max(dot(seen.direction, normal), least);
        return (seen.radiance * size, size);
    }
    let mut sum = Vec4::ZERO;
    let mut i = v.begin;
    // Two at a time: a software driver ends all loops of a work item after 65 535 rounds.
    while i < v.end {
        for_two!(i, v.end, |at| {
            let seen = see_proxy(params, from, at, proxies, radiance);
            let openness = if by_share { seen.openness } else { 1.0 };
            // Nothing below the horizon: a voxel that neighbours saw may lie behind this surface.
            let size = seen.size * openness * max(dot(seen.direction, normal), 0.0);
            sum += (seen.radiance * size).extend(size);
        });
        i += 2;
    }
    (sum.truncate(), sum.w)
}
