//! Which proxies are in which voxel, and what does a voxel send out? VF §3.1, eqs. 1–3.
//!
//! Proxies stand in the order of the voxel of their centre. A second list names each proxy in *every* cell of a finer
//! grid that its disc overlaps: rays look there, since a disc that reaches over a border would else be invisible
//! beyond it.

use super::gloss::mirrors;
use super::proxy::Proxy;
use crate::math::{MIN_POSITIVE, abs, div, dot, max, sqrt};
use crate::passes::scan::owner;
use crate::sampling::voxel_hash::{encode, voxel_of};
use crate::sh::{CLAMPED_COSINE, rotate_zonal};
use glam::{UVec3, UVec4, Vec3, Vec4};

/// Zonal coefficients l ≤ 1 of a Lambert emitter.
const LAMBERT: [f32; 2] = [CLAMPED_COSINE[0], CLAMPED_COSINE[1]];

gpu_struct! {
    /// The voxel grid and the number of items.
    pub struct GridParams {
        /// Lower corner in metres; w is 0.
        pub lower: Vec4,
        /// 1/(voxel edge) along each axis, 1/m; w is 0.
        pub inverse_size: Vec4,
        /// Voxels along each axis; w is their number.
        pub dims: UVec4,
        /// Number of proxies.
        pub proxies: u32,
        /// Number of (voxel, proxy) pairs that the pass looks at.
        pub pairs: u32,
        /// 1 if the sides of proxies count by their openness, 0 if all alike.
        pub weighted: u32,
        /// Lights whose mirrored lobes stand behind the sides' radiance; 0 if none do.
        pub lights: u32,
    }

    /// What a voxel sends out, and which proxies have their centre in it.
    pub struct Voxel {
        /// Centroid of the lit proxies by emitted power, of all by area where none is lit; w is the radius of a
        /// sphere around it that holds all their centres.
        pub centroid: Vec4,
        /// Projected area of the sides that face +x most, m²: their intensity in spherical harmonics l ≤ 1 if each had
        /// radiance 1.
        pub right_area: Vec4,
        /// Their mean radiance; w is 0.
        pub right_light: Vec4,
        /// Projected area of the sides that face −x most.
        pub left_area: Vec4,
        /// Their mean radiance.
        pub left_light: Vec4,
        /// Projected area of the sides that face +y most.
        pub up_area: Vec4,
        /// Their mean radiance.
        pub up_light: Vec4,
        /// Projected area of the sides that face −y most.
        pub down_area: Vec4,
        /// Their mean radiance.
        pub down_light: Vec4,
        /// Projected area of the sides that face +z most.
        pub near_area: Vec4,
        /// Their mean radiance.
        pub near_light: Vec4,
        /// Projected area of the sides that face −z most.
        pub far_area: Vec4,
        /// Their mean radiance.
        pub far_light: Vec4,
        /// First proxy.
        pub begin: u32,
        /// One behind the last proxy.
        pub end: u32,
        /// Number of lit proxies.
        pub lit: u32,
        /// Mean area of the proxies, m².
        pub mean_area: f32,
        /// Number of proxies that mirror a light: what they send is no low harmonic.
        pub glossy: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

/// Returns the number of the voxel that holds a point.
#[inline]
pub(super) fn voxel_number(grid: &GridParams, point: Vec3) -> u32 {
    let dims = grid.dims.truncate();
    encode(voxel_of(point, grid.lower.truncate(), grid.inverse_size.truncate(), dims), dims)
}

/// Returns word `index` of the pairs (voxel of the centre, proxy), interleaved.
#[inline]
pub fn proxy_keys(index: u32, params: &GridParams, proxies: &[Proxy]) -> u32 {
    let proxy = index / 2;
    if index & 1 == 1 { proxy } else { voxel_number(params, proxies[proxy as usize].position.truncate()) }
}

/// Returns the proxy that stands at place `index` of the sorted pairs.
#[inline]
pub fn reorder_proxies(index: u32, params: &GridParams, pairs: &[u32], proxies: &[Proxy]) -> Proxy {
    let _ = params;
    proxies[pairs[(2 * index + 1) as usize] as usize]
}

/// Returns the first place of the sorted pairs whose voxel is `index` or above; the number of pairs behind the last.
#[inline]
pub fn cell_starts(index: u32, params: &GridParams, pairs: &[u32]) -> u32 {
    let mut low = 0;
    let mut high = params.pairs;
    while low < high {
        let middle = low + (high - low) / 2;
        if pairs[(2 * middle) as usize] < index {
            low = middle + 1;
        } else {
            high = middle;
        }
    }
    low
}

/// The cells that the box around a disc overlaps: the lowest, and how many along each axis.
#[inline]
fn overlapped(grid: &GridParams, p: &Proxy) -> (UVec3, UVec3) {
    let n = p.normal.truncate();
    // Half the extent of a disc along an axis: r √(1 − n²).
    let half = Vec3::new(
        p.position.w * sqrt(max(0.0, 1.0 - n.x * n.x)),
        p.position.w * sqrt(max(0.0, 1.0 - n.y * n.y)),
        p.position.w * sqrt(max(0.0, 1.0 - n.z * n.z)),
    );
    let (lower, inverse, dims) = (grid.lower.truncate(), grid.inverse_size.truncate(), grid.dims.truncate());
    let first = voxel_of(p.position.truncate() - half, lower, inverse, dims);
    let last = voxel_of(p.position.truncate() + half, lower, inverse, dims);
    (first, UVec3::new(last.x - first.x + 1, last.y - first.y + 1, last.z - first.z + 1))
}

/// Returns how many cells the box around proxy `index` overlaps; 0 for one in a hole.
#[inline]
pub fn overlap_counts(index: u32, params: &GridParams, proxies: &[Proxy]) -> u32 {
    let p = &proxies[index as usize];
    if !(p.position.w > 0.0) {
        return 0;
    }
    let (_, span) = overlapped(params, p);
    span.x * span.y * span.z
}

/// Returns word `index` of the pairs (overlapped cell, proxy), interleaved; `starts` scans [`overlap_counts`].
#[inline]
pub fn overlap_pairs(index: u32, params: &GridParams, starts: &[u32], proxies: &[Proxy]) -> u32 {
    let pair = index / 2;
    let proxy = owner(starts, params.proxies, pair);
    if index & 1 == 1 {
        return proxy;
    }
    let (first, span) = overlapped(params, &proxies[proxy as usize]);
    let within = pair - starts[proxy as usize];
    let row = within / span.x;
    let layer = row / span.y;
    let voxel =
        UVec3::new(first.x + (within - row * span.x), first.y + (row - layer * span.y), first.z + layer);
    encode(voxel, params.dims.truncate())
}

/// Returns a side's radiance before any light: black, with its openness in w.
#[inline]
pub fn dark_sides(index: u32, params: &GridParams, openness: &[f32]) -> Vec4 {
    let _ = params;
    Vec4::new(0.0, 0.0, 0.0, openness[index as usize])
}

/// Sums over the sides of a voxel's proxies, by the axis that they face most.
struct Groups {
    area: [Vec4; 6],
    light: [Vec4; 6],
}

impl Groups {
    /// Adds a Lambert emitter of this area and normal.
    #[inline]
    fn add(&mut self, normal: Vec3, radiance: Vec3, area: f32) {
        let group = facing(normal);
        self.area[group] += Vec4::from_array(rotate_zonal::<2, 4>(&LAMBERT, normal)) * area;
        self.light[group] += (radiance * area).extend(area);
    }

    /// The mean radiance of a group, 0 for an empty one.
    #[inline]
    fn mean(&self, group: usize) -> Vec4 {
        let sum = self.light[group];
        if sum.w > MIN_POSITIVE { weighted_mean(sum.truncate(), sum.w).extend(0.0) } else { Vec4::ZERO }
    }
}

/// Which of +x, −x, +y, −y, +z, −z a normal faces most.
#[inline]
fn facing(n: Vec3) -> usize {
    let (x, y, z) = (abs(n.x), abs(n.y), abs(n.z));
    if x >= y && x >= z {
        if n.x >= 0.0 { 0 } else { 1 }
    } else if y >= z {
        if n.y >= 0.0 { 2 } else { 3 }
    } else if n.z >= 0.0 {
        4
    } else {
        5
    }
}

/// Returns what voxel `index` sends out: the sum over its proxies, VF eqs. 2 and 3.
///
/// `starts` are the [`cell_starts`] of the proxies, `radiance` is that of each proxy's front and back with the side's
/// openness in w, and the lobes of [`add_lobes`](super::gloss::add_lobes) behind. A proxy of area A is a Lambert emitter: intensity A·L·max(0, n·ω) on either side. Sides are summed in six
/// groups by the axis that they face: two bands cannot tell the walls of a corner apart, and the lit outside of a dark
/// room would shine into it. Summed in the order of the proxies, so neither threads nor a fixed-point scale show.
#[inline]
pub fn sum_voxels(
    index: u32,
    params: &GridParams,
    starts: &[u32],
    proxies: &[Proxy],
    radiance: &[Vec4],
) -> Voxel {
    let begin = starts[index as usize];
    let end = starts[(index + 1) as usize];
    let mut groups = Groups { area: [Vec4::ZERO; 6], light: [Vec4::ZERO; 6] };
    let (mut by_power, mut power) = (Vec3::ZERO, 0.0);
    let (mut by_area, mut area) = (Vec3::ZERO, 0.0);
    let (mut lit, mut glossy) = (0, 0);
    for i in begin..end {
        let p = &proxies[i as usize];
        let (position, normal, own) = (p.position.truncate(), p.normal.truncate(), p.normal.w);
        let (front, back) = (radiance[(2 * i) as usize], radiance[(2 * i + 1) as usize]);
        let weighted = params.weighted != 0;
        let (front_area, back_area) = if weighted { (own * front.w, own * back.w) } else { (own, own) };
        groups.add(normal, front.truncate(), front_area);
        groups.add(-normal, back.truncate(), back_area);
        by_area += position * own;
        area += own;
        let sum = front + back;
        let own_power = ((sum.x + sum.y) + sum.z) * own;
        let gloss = params.lights > 0 && mirrors(params, i, radiance);
        if gloss {
            glossy += 1;
        }
        if own_power > 0.0 || gloss {
            lit += 1;
        }
        if own_power > 0.0 {
            by_power += position * own_power;
            power += own_power;
        }
    }
    let centroid = if power > MIN_POSITIVE {
        weighted_mean(by_power, power)
    } else if area > MIN_POSITIVE {
        weighted_mean(by_area, area)
    } else {
        Vec3::ZERO
    };
    let mut squared = 0.0;
    for i in begin..end {
        let offset = proxies[i as usize].position.truncate() - centroid;
        squared = max(squared, dot(offset, offset));
    }
    Voxel {
        centroid: centroid.extend(sqrt(squared)),
        right_area: groups.area[0],
        right_light: groups.mean(0),
        left_area: groups.area[1],
        left_light: groups.mean(1),
        up_area: groups.area[2],
        up_light: groups.mean(2),
        down_area: groups.area[3],
        down_light: groups.mean(3),
        near_area: groups.area[4],
        near_light: groups.mean(4),
        far_area: groups.area[5],
        far_light: groups.mean(5),
        begin,
        end,
        lit,
        mean_area: if end > begin { div(area, (end - begin) as f32) } else { 0.0 },
        glossy,
        pad0: 0,
        pad1: 0,
        pad2: 0,
    }
}

#[inline]
fn weighted_mean(sum: Vec3, weight: f32) -> Vec3 {
    Vec3::new(div(sum.x, weight), div(sum.y, weight), div(sum.z, weight))
}
