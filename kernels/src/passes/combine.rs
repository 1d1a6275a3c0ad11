//! What do buffers of radiance add up to, and what do surfaces reflect of light that is known?

use super::surface::Surface;
use crate::math::recip;
use glam::{Vec3, Vec4};

gpu_struct! {
    /// Parameters of [`add_radiance`].
    pub struct AddParams {
        /// Padding: the pass needs none.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
        /// Padding.
        pub pad3: u32,
    }
}

/// Returns the sum of both buffers at `index`.
#[inline]
pub fn add_radiance(index: u32, params: &AddParams, a: &[Vec4], b: &[Vec4]) -> Vec4 {
    let _ = params;
    a[index as usize] + b[index as usize]
}

/// Returns `previous` plus what the surface of pixel `index` reflects of `light`, irradiance/π: albedo × light.
#[inline]
pub fn add_diffuse_reflection(
    index: u32,
    params: &AddParams,
    surfaces: &[Surface],
    light: &[Vec4],
    previous: &[Vec4],
) -> Vec4 {
    let _ = params;
    let reflected = surfaces[index as usize].diffuse.truncate() * light[index as usize].truncate();
    previous[index as usize] + reflected.extend(0.0)
}

/// Less than this share of the light is none: its reciprocal would not be finite.
const LEAST_KNOWN: f32 = 1.0e-18;

/// Returns `previous` plus `light` times the specular colour of pixel `index`.
///
/// The light's w is how much of it is known: upsampled over the border of a surface without gloss, less than 1.
#[inline]
pub fn add_specular_reflection(
    index: u32,
    params: &AddParams,
    gloss: &[Vec4],
    light: &[Vec4],
    previous: &[Vec4],
) -> Vec4 {
    let _ = params;
    let known = light[index as usize];
    let whole = if known.w > LEAST_KNOWN { known.truncate() * recip(known.w) } else { Vec3::ZERO };
    let reflected = gloss[index as usize].truncate() * whole;
    previous[index as usize] + reflected.extend(0.0)
}
