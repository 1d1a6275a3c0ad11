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
use super::list::{LIST_HEADER, ListHeader, list_stride};
use super::proxy::Proxy;
use crate::gaussian::gathering_weights;
use crate::gaussian::{one_minus_cosine, specular_falloff};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{PI, abs, acos, div, dot, exp_minus_one, log2, max, min, normalize_or, pow_fast, rsqrt};
use crate::passes::surface::Surface;
use crate::passes::upsample::{Footprint, footprint};
use crate::sh::lambert_intensity;
use glam::{Vec3, Vec4};

/// Bit of [`GatherVoxelsParams::flags`]: voxels count by the share of rays that met them.
pub const GATHER_SHARE: u32 = 1;
/// [`GatherVoxelsParams::clamp`]: A/(πd² + A), the form factor of a disc.
pub const CLAMP_DISC: u32 = 0;
/// [`GatherVoxelsParams::clamp`]: A/max(πd², A), constant within the disc's radius.
pub const CLAMP_RADIUS: u32 = 1;
/// [`GatherVoxelsParams::clamp`]: A/πd², unbounded.
pub const CLAMP_NONE: u32 = 2;

/// Cosines at the receiver below this count as this one in means: a voxel may be visible by its neighbours only.
const LEAST_COSINE: f32 = 1.0e-3;
/// What a voxel off the specular lobe weighs in it: without any in the lobe these decide.
const OFF_LOBE: f32 = 1.0e-6;

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
        /// Padding.
        pub pad: u32,
    }
}

/// The lists of four coarse pixels, merged.
struct Lists {
    at: [u32; 4],
    end: [u32; 4],
    /// Weight of one listed voxel.
    weight: [f32; 4],
    /// Weight of one ray that met it.
    per_ray: [f32; 4],
    /// Rays that the counts are out of, weighted.
    rays: f32,
}

/// A voxel that some of the lists name.
struct Member {
    voxel: u32,
    /// Sum of the weights of the lists that name it.
    weight: f32,
    /// Sum of the weights of the rays that met it.
    share: f32,
}

/// No voxel is left.
const DONE: u32 = 0xFFFF_FFFF;

impl Lists {
    #[inline]
    fn new(params: &GatherVoxelsParams, cells: &Footprint, weights: &[f32; 4], lists: &[u32]) -> Self {
        let stride = list_stride(params.capacity);
        let mut all = Self { at: [0; 4], end: [0; 4], weight: [0.0; 4], per_ray: [0.0; 4], rays: 0.0 };
        for k in 0..4 {
            let first = cells.pixels[k] * stride;
            let (rays, kept, dropped) =
                (lists[first as usize], lists[(first + 1) as usize], lists[(first + 2) as usize]);
            if weights[k] > 0.0 {
                all.at[k] = first + LIST_HEADER;
                all.end[k] = first + LIST_HEADER + 2 * kept;
                // The voxels that are kept stand for those without room.
                all.weight[k] = if dropped == 0 {
                    weights[k]
                } else {
                    weights[k] * div((kept + dropped) as f32, max(kept as f32, 1.0))
                };
                all.per_ray[k] = div(weights[k], max(rays as f32, 1.0));
                all.rays += weights[k] * (rays as f32);
            }
        }
        all
    }

    /// Takes the lowest voxel that is left.
    #[inline]
    fn take(&mut self, lists: &[u32]) -> Member {
        let mut lowest = DONE;
        for k in 0..4 {
            if self.at[k] < self.end[k] {
                let voxel = lists[self.at[k] as usize] - 1;
                lowest = if voxel < lowest { voxel } else { lowest };
            }
        }
        let mut member = Member { voxel: lowest, weight: 0.0, share: 0.0 };
        for k in 0..4 {
            if self.at[k] < self.end[k] && lists[self.at[k] as usize] - 1 == lowest {
                member.weight += self.weight[k];
                member.share += self.per_ray[k] * (lists[(self.at[k] + 1) as usize] as f32);
                self.at[k] += 2;
            }
        }
        member
    }
}

/// Weights of the four coarse pixels, VF eq. 5 w_G·w_l over their sum; all 0 where none has a surface.
#[inline]
fn weights(
    params: &GatherVoxelsParams,
    cells: &Footprint,
    s: &Surface,
    headers: &[ListHeader],
) -> [f32; 4] {
    let mut distance = [0.0; 4];
    let mut normal = [Vec3::ZERO; 4];
    for k in 0..4 {
        let h = &headers[cells.pixels[k] as usize];
        if h.position.w >= 0.0 {
            distance[k] = dot(h.position.truncate() - s.position.truncate(), s.normal.truncate());
            normal[k] = h.normal.truncate();
        }
    }
    let deviation = params.depth_deviation * s.position.w;
    gathering_weights(&cells.bilinear, &distance, &normal, s.normal.truncate(), deviation, params.normal_deviation)
}

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
    if squared > area * 8.673_617e-19 && whole > crate::math::MIN_POSITIVE { div(area, whole) } else { 0.0 }
}

/// A small emitter as seen from a point.
struct Seen {
    /// Unit direction toward it.
    direction: Vec3,
    inverse_distance: f32,
    /// Its share of the hemisphere's projected solid angle, without the receiver's cosine.
    size: f32,
    radiance: Vec3,
    /// Openness of the side that is seen: how much it counts in means.
    openness: f32,
}

#[inline]
fn see_proxy(
    params: &GatherVoxelsParams,
    from: Vec3,
    index: u32,
    proxies: &[Proxy],
    radiance: &[Vec4],
) -> Seen {
    let p = &proxies[index as usize];
    let between = p.position.truncate() - from;
    let squared = dot(between, between);
    let inverse_distance = rsqrt(max(squared, crate::math::MIN_POSITIVE));
    let direction = between * inverse_distance;
    let cosine = -dot(p.normal.truncate(), direction);
    let side = radiance[(2 * index + if cosine >= 0.0 { 0 } else { 1 }) as usize];
    Seen {
        direction,
        inverse_distance,
        size: solid_share(params, squared, p.normal.w) * abs(cosine),
        radiance: side.truncate(),
        openness: side.w,
    }
}

#[inline]
fn see_voxel(params: &GatherVoxelsParams, from: Vec3, v: &Voxel) -> Seen {
    let between = v.centroid.truncate() - from;
    let squared = dot(between, between);
    let inverse_distance = rsqrt(max(squared, crate::math::MIN_POSITIVE));
    let direction = between * inverse_distance;
    let towards = -direction;
    let intensity = Vec3::new(
        lambert_intensity(v.front_red, towards) + lambert_intensity(v.back_red, towards),
        lambert_intensity(v.front_green, towards) + lambert_intensity(v.back_green, towards),
        lambert_intensity(v.front_blue, towards) + lambert_intensity(v.back_blue, towards),
    );
    let area = lambert_intensity(v.front_area, towards) + lambert_intensity(v.back_area, towards);
    if !(area > crate::math::MIN_POSITIVE) || !(v.mean_area > crate::math::MIN_POSITIVE) {
        return Seen { direction, inverse_distance, size: 0.0, radiance: Vec3::ZERO, openness: 1.0 };
    }
    let radiance = Vec3::new(div(intensity.x, area), div(intensity.y, area), div(intensity.z, area));
    // As many proxies of mean area as make up the projected area.
    let size = solid_share(params, squared, v.mean_area) * div(area, v.mean_area);
    Seen { direction, inverse_distance, size, radiance, openness: 1.0 }
}

/// Whether a voxel counts proxy by proxy: its centroid is nearer than R.
#[inline]
fn is_near(params: &GatherVoxelsParams, from: Vec3, v: &Voxel) -> bool {
    let between = v.centroid.truncate() - from;
    dot(between, between) < params.near_range * params.near_range
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
    let (mut sum, mut whole, mut met) = (Vec3::ZERO, 0.0, 0.0);
    let mut visible = 0.0;
    let mut member = merged.take(lists);
    while member.voxel != DONE {
        visible += 1.0;
        met += member.share;
        let v = &voxels[member.voxel as usize];
        if by_share {
            let (light, size) = voxel_light(params, from, normal, v, proxies, radiance);
            if size > crate::math::MIN_POSITIVE {
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
        sum = if whole > crate::math::MIN_POSITIVE { sum * div(met, whole) } else { Vec3::ZERO };
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
    let expected = if found > crate::math::MIN_POSITIVE { div(size * member.weight, found) } else { 0.0 };
    let difference = member.share - expected;
    let squared = difference * difference;
    let noise = (params.trust * params.trust) * div(size, max(rays, 1.0));
    let all = squared + noise;
    if all > crate::math::MIN_POSITIVE { expected + difference * div(squared, all) } else { expected }
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
    if !is_near(params, from, v) {
        let seen = see_voxel(params, from, v);
        let size = seen.size * max(dot(seen.direction, normal), least);
        return (seen.radiance * size, size);
    }
    let (mut light, mut whole) = (Vec3::ZERO, 0.0);
    for i in v.begin..v.end {
        let seen = see_proxy(params, from, i, proxies, radiance);
        let openness = if by_share { seen.openness } else { 1.0 };
        let size = seen.size * openness * max(dot(seen.direction, normal), least);
        light += seen.radiance * size;
        whole += size;
    }
    (light, whole)
}

#[inline]
fn cells(index: u32, params: &GatherVoxelsParams) -> Footprint {
    let pixel = params.first_pixel + index;
    footprint(
        pixel % params.width,
        pixel / params.width,
        params.scale_x,
        params.scale_y,
        params.coarse_width,
        params.coarse_height,
    )
}

/// A specular lobe about a direction.
struct Lobe {
    mirror: Vec3,
    exponent: f32,
    /// σ_θ, 0 for the Phong lobe.
    deviation: f32,
    /// The exponent with which eq. 7 is half where the Phong lobe is, over that lobe's.
    filter_exponent: f32,
    disc_radius: f32,
}

/// Lobes are cut off where n·(1 − cos) is this: at 3e-4 of their middle.
const LOBE_EDGE: f32 = 8.0;

impl Lobe {
    #[inline]
    fn new(params: &GatherVoxelsParams, s: &Surface, exponent: f32) -> Self {
        let (position, normal) = (s.position.truncate(), s.normal.truncate());
        let to_viewer = normalize_or(params.eye.truncate() - position, normal);
        let mirror = normalize_or(normal * (2.0 * dot(normal, to_viewer)) - to_viewer, normal);
        let deviation = params.specular_deviation;
        // cosᶯ = 1 − 1.1774 σ where cosⁿ = ½.
        let half = 1.0 - 1.177_41 * min(deviation, 0.5);
        Self {
            mirror,
            exponent: max(exponent, 1.0e-3),
            deviation,
            filter_exponent: -log2(half),
            disc_radius: params.disc_radius,
        }
    }

    /// The exponent of the lobe as it falls on discs at a distance, given 1/distance.
    ///
    /// A lobe of exponent n has a variance of about 1/n, a disc of radius r that of a normal distribution of half its
    /// radius, (r/2d)². Unblurred, a narrow lobe would see the gaps between proxies.
    #[inline]
    fn blurred(&self, inverse_distance: f32) -> f32 {
        let blur = 0.5 * self.disc_radius * inverse_distance;
        div(self.exponent, 1.0 + self.exponent * (blur * blur))
    }

    /// The weight of a direction per solid angle, 1 in the middle of a distant lobe; 0 beyond the edge.
    #[inline]
    fn weight(&self, direction: Vec3, inverse_distance: f32) -> f32 {
        let exponent = self.blurred(inverse_distance);
        let gap = one_minus_cosine(self.mirror, direction);
        if !(exponent * gap < LOBE_EDGE) || !(gap < 1.0) {
            return 0.0;
        }
        let shape = if self.deviation > 0.0 {
            specular_falloff(gap, exponent * self.filter_exponent, self.deviation)
        } else {
            pow_fast(1.0 - gap, exponent)
        };
        // Wider is lower: the lobe's whole stays.
        shape * div(exponent + 1.0, self.exponent + 1.0)
    }

    /// Whether the sphere around a voxel's proxies can be in the lobe.
    #[inline]
    fn reaches(&self, from: Vec3, v: &Voxel) -> bool {
        let between = v.centroid.truncate() - from;
        let squared = dot(between, between);
        let radius = v.centroid.w;
        // Twice the radius: nearer, the blur changes too much within the voxel.
        if squared <= 4.0 * (radius * radius) {
            return true;
        }
        let inverse = rsqrt(squared);
        // Of the nearest point, at least half as far.
        let edge = max(1.0 - div(LOBE_EDGE, self.blurred(2.0 * inverse)), -1.0);
        // asin x ≤ π/2·x
        let half_angle = (0.5 * PI) * (radius * inverse);
        acos(dot(self.mirror, between) * inverse) <= acos(edge) + half_angle
    }
}

/// Returns what the specular lobe of pixel `index` reflects of visible voxels, for a specular colour of 1.
///
/// The mean radiance of the visible proxies, each weighted by its solid angle, the cosine and the lobe (or eq. 7),
/// times the lobe's coverage: VF's effective number of light sources, N_c, is the sum of these weights over lit
/// and dark proxies alike.
#[inline]
pub fn gather_specular(
    index: u32,
    params: &GatherVoxelsParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    headers: &[ListHeader],
    lists: &[u32],
    voxels: &[Voxel],
    proxies: &[Proxy],
    radiance: &[Vec4],
) -> Vec4 {
    let s = surfaces[index as usize];
    let own = gloss[index as usize];
    if s.triangle == NO_TRIANGLE || !(max(max(own.x, own.y), own.z) > 0.0) {
        return Vec4::ZERO;
    }
    let (from, normal) = (s.position.truncate(), s.normal.truncate());
    let cells = cells(index, params);
    let weights = weights(params, &cells, &s, headers);
    let mut coverage = 0.0;
    for k in 0..4 {
        coverage += weights[k] * headers[cells.pixels[k] as usize].normal.w;
    }
    let lobe = Lobe::new(params, &s, own.w);
    let mut merged = Lists::new(params, &cells, &weights, lists);
    let (mut light, mut whole) = (Vec3::ZERO, 0.0);
    let mut member = merged.take(lists);
    while member.voxel != DONE {
        let v = &voxels[member.voxel as usize];
        let seen = see_voxel(params, from, v);
        let size = OFF_LOBE * seen.size * max(dot(seen.direction, normal), 0.0);
        light += seen.radiance * (member.weight * size);
        whole += member.weight * size;
        if lobe.reaches(from, v) {
            for i in v.begin..v.end {
                let seen = see_proxy(params, from, i, proxies, radiance);
                let cosine = dot(seen.direction, normal);
                if cosine > 0.0 {
                    let weight = lobe.weight(seen.direction, seen.inverse_distance) * member.weight;
                    let size = seen.size * seen.openness * (cosine * weight);
                    light += seen.radiance * size;
                    whole += size;
                }
            }
        }
        member = merged.take(lists);
    }
    if !(whole > crate::math::MIN_POSITIVE) {
        return Vec4::ZERO;
    }
    (light * div(coverage, whole)).extend(0.0)
}

