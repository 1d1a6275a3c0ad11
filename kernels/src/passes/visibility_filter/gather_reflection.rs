//! How much light do the visible voxels send into a pixel's specular lobe? VF §3.3, eq. 7.

use super::gather_voxels::GatherVoxelsParams;
use super::gloss::blurred;
use super::grid::Voxel;
use super::list::ListHeader;
use super::march::is_glossy;
use super::merged_lists::{DONE, Lists, cells, weights};
use super::proxy::Proxy;
use super::seen::{see_proxy, see_voxel};
use crate::gaussian::{one_minus_cosine, specular_falloff};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{MIN_POSITIVE, PI, acos, div, dot, log2, max, min, normalize_or, pow_fast, rsqrt};
use crate::passes::material::mirror_direction;
use crate::passes::surface::Surface;
use glam::{Vec3, Vec4};

/// What a voxel off the specular lobe weighs in it: without any in the lobe these decide.
const OFF_LOBE: f32 = 1.0e-6;

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
        let mirror = mirror_direction(normal, to_viewer);
        let deviation = params.specular_deviation;
        // cosᶯ = 1 − 1.1774 σ where cosⁿ = ½.
        let half = 1.0 - 1.177_41 * min(deviation, 0.5);
        let filter_exponent = -log2(half);
        let given = params.specular_exponent > 0.0 && deviation > 0.0;
        // A lobe about as wide as eq. 7 with the exponent that is given.
        let own = if given { div(params.specular_exponent, filter_exponent) } else { exponent };
        Self {
            mirror,
            exponent: max(own, 1.0e-3),
            deviation,
            filter_exponent,
            disc_radius: params.disc_radius,
        }
    }

    /// The weight of a direction per solid angle, 1 in the middle of a distant lobe; 0 beyond the edge.
    #[inline]
    fn weight(&self, direction: Vec3, inverse_distance: f32) -> f32 {
        let exponent = blurred(self.exponent, self.disc_radius, inverse_distance);
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
        let edge = max(1.0 - div(LOBE_EDGE, blurred(self.exponent, self.disc_radius, 2.0 * inverse)), -1.0);
        // asin x ≤ π/2·x
        let half_angle = (0.5 * PI) * (radius * inverse);
        acos(dot(self.mirror, between) * inverse) <= acos(edge) + half_angle
    }
}

/// Returns what the specular lobe of pixel `index` reflects of visible voxels, for a specular colour of 1; w is 1, or 0
/// where there is no lobe.
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
    if s.triangle == NO_TRIANGLE || !is_glossy(own) {
        return Vec4::ZERO;
    }
    let (from, normal) = (s.position.truncate(), s.normal.truncate());
    let cells = cells(index, params);
    let weights = weights(params, &cells, &s, headers);
    let lobe = Lobe::new(params, &s, own.w);
    let (mut coverage, mut known) = (0.0, 0.0);
    for k in 0..4 {
        let covered = headers[cells.pixels[k] as usize].normal.w;
        if covered >= 0.0 {
            coverage += weights[k] * covered;
            known += weights[k];
        }
    }
    // Without a glossy neighbour: as if all of the lobe ended on the scene.
    coverage = if known > MIN_POSITIVE { div(coverage, known) } else { max(dot(lobe.mirror, normal), 0.0) };
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
            let mut i = v.begin;
            while i < v.end {
                for_two!(i, v.end, |at| {
                    let seen = see_proxy(params, from, at, proxies, radiance);
                    let cosine = dot(seen.direction, normal);
                    if cosine > 0.0 {
                        let weight = lobe.weight(seen.direction, seen.inverse_distance) * member.weight;
                        let size = seen.size * seen.openness * (cosine * weight);
                        light += seen.radiance * size;
                        whole += size;
                    }
                });
                i += 2;
            }
        }
        member = merged.take(lists);
    }
    if !(whole > MIN_POSITIVE) {
        return Vec4::W;
    }
    (light * div(coverage, whole)).extend(1.0)
}
