//! What is known of the surfaces behind a texel of a layer, and in how many bits? LRSM table 1 and eqs. 10, 11.
//!
//! Depths are relative to their layer, −1 at its near end to 1 at its far one, so that the variance does not cancel.
//! Means are over the light's rays.

use crate::gaussian::variance_from_moments;
use crate::math::{clamp, div, floor, max, sqrt, to_u32};
use crate::passes::voxel_cones::storage::{pack_radiance, unpack_radiance};
use glam::Vec3;

/// Mean and variance of the depth as floats: four words a texel.
pub const MOMENTS_FLOAT: u32 = 0;
/// The means of depth and squared depth in 16-bit fixed point, as published: three words a texel.
pub const MOMENTS_UNORM16: u32 = 1;
/// Mean and standard deviation of the depth in 16-bit fixed point: three words a texel.
pub const MOMENTS_DEVIATION16: u32 = 2;

/// Returns the words of a texel in one of these formats.
#[inline]
pub fn texel_words(format: u32) -> u32 {
    if format == MOMENTS_FLOAT { 4 } else { 3 }
}

/// What is known of the surfaces of a layer behind a texel, or several.
#[derive(Clone, Copy)]
pub struct LayerTexel {
    /// What they reflect, times opacity: radiance, or flux for each ray of the light, in stored units.
    pub reflected: Vec3,
    /// Share of the light's rays that meet one of them.
    pub opacity: f32,
    /// Mean of their normals.
    pub normal: Vec3,
    /// Mean of their depths.
    pub mean: f32,
    /// Variance of their depths, at least 0.
    pub variance: f32,
}

impl LayerTexel {
    /// No surface.
    pub const EMPTY: Self =
        Self { reflected: Vec3::ZERO, opacity: 0.0, normal: Vec3::ZERO, mean: 0.0, variance: 0.0 };
}

const STEPS: f32 = 65_535.0;
/// 1/65535
const STEP: f32 = 1.525_902_2e-5;

#[inline]
fn sixteen(value: f32) -> u32 {
    to_u32(floor(clamp(value, 0.0, 1.0) * STEPS + 0.5))
}

/// Returns the words of a texel; the fourth is 0 where the format has three.
#[inline]
pub fn pack_texel(format: u32, t: &LayerTexel) -> [u32; 4] {
    if !(t.opacity > 0.0) {
        return [0; 4];
    }
    let part = |x: f32| to_u32(floor(clamp(x, -1.0, 1.0) * 127.0 + 127.5));
    // Not even a very small share is none.
    let opacity = max(floor(clamp(t.opacity, 0.0, 1.0) * 255.0 + 0.5), 1.0);
    let normal =
        part(t.normal.x) | (part(t.normal.y) << 8) | (part(t.normal.z) << 16) | (to_u32(opacity) << 24);
    let reflected = pack_radiance(t.reflected);
    let half = 0.5 * t.mean + 0.5;
    if format == MOMENTS_FLOAT {
        [reflected, normal, t.mean.to_bits(), t.variance.to_bits()]
    } else if format == MOMENTS_UNORM16 {
        [reflected, normal, sixteen(half) | (sixteen(0.25 * t.variance + half * half) << 16), 0]
    } else {
        [reflected, normal, sixteen(half) | (sixteen(sqrt(t.variance)) << 16), 0]
    }
}

/// Returns the texel at word `at`.
#[inline]
pub fn unpack_texel(format: u32, words: &[u32], at: u32) -> LayerTexel {
    let packed = words[(at + 1) as usize];
    let opacity = packed >> 24;
    if opacity == 0 {
        return LayerTexel::EMPTY;
    }
    // 1/127 and 1/255
    let part = |bits: u32| ((bits & 255) as f32 - 127.0) * 7.874_016e-3;
    let moments = words[(at + 2) as usize];
    let (low, high) = ((moments & 0xFFFF) as f32 * STEP, (moments >> 16) as f32 * STEP);
    let (mean, variance) = if format == MOMENTS_FLOAT {
        (f32::from_bits(moments), f32::from_bits(words[(at + 3) as usize]))
    } else if format == MOMENTS_UNORM16 {
        (2.0 * low - 1.0, 4.0 * variance_from_moments(low, high, 0.0))
    } else {
        (2.0 * low - 1.0, high * high)
    };
    LayerTexel {
        reflected: unpack_radiance(words[at as usize]),
        opacity: opacity as f32 * 3.921_568_6e-3,
        normal: Vec3::new(part(packed), part(packed >> 8), part(packed >> 16)),
        mean,
        variance,
    }
}

/// A sum of texels by weight.
#[derive(Clone, Copy)]
pub struct TexelSum {
    reflected: Vec3,
    opacity: f32,
    normal: Vec3,
    /// Σ weight·opacity·(depth − pivot), and that of its square.
    first: f32,
    second: f32,
    /// Depths are told from here: what is near keeps its precision.
    pivot: f32,
}

impl TexelSum {
    /// No texel yet; depths are told from `pivot`.
    #[inline]
    pub fn new(pivot: f32) -> Self {
        Self { reflected: Vec3::ZERO, opacity: 0.0, normal: Vec3::ZERO, first: 0.0, second: 0.0, pivot }
    }

    /// Whether no surface was added.
    #[inline]
    pub fn is_empty(&self) -> bool {
        !(self.opacity > 0.0)
    }

    /// Adds a texel; weights sum to 1. LRSM eq. 13.
    #[inline]
    pub fn add(&mut self, t: &LayerTexel, weight: f32) {
        let share = weight * t.opacity;
        let depth = t.mean - self.pivot;
        self.reflected += t.reflected * weight;
        self.opacity += share;
        self.normal += t.normal * share;
        self.first += depth * share;
        self.second += (t.variance + depth * depth) * share;
    }

    /// The texels as one. LRSM eqs. 10 and 11, divided by the opacity before the difference is taken.
    #[inline]
    pub fn whole(&self) -> LayerTexel {
        if !(self.opacity > 1.0e-18) {
            return LayerTexel::EMPTY;
        }
        let inverse = div(1.0, self.opacity);
        let offset = self.first * inverse;
        LayerTexel {
            reflected: self.reflected,
            opacity: self.opacity,
            normal: self.normal * inverse,
            mean: self.pivot + offset,
            variance: variance_from_moments(offset, self.second * inverse, 0.0),
        }
    }
}
