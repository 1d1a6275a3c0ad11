//! What do pixels gather with cones through binary voxels? LRSM §3.

use super::lookup::{LayeredMap, Maps};
use super::voxels::{BinaryVoxels, Occluders};
use crate::passes::surface::Surface;
use crate::passes::voxel_cones::trace::{CONES_MEAN_OPACITY, ConeParams, diffuse_through, specular_through};
use glam::Vec4;

/// The voxels alone.
#[inline]
pub fn occluders<'a>(params: &ConeParams, voxels: &'a [u32]) -> Occluders<'a> {
    Occluders { depth: params.depth, mean: params.flags & CONES_MEAN_OPACITY != 0, voxels }
}

/// The medium that these buffers are.
#[inline]
fn binary<'a>(
    params: &ConeParams,
    voxels: &'a [u32],
    maps: &'a [LayeredMap],
    layers: &'a [u32],
) -> BinaryVoxels<'a> {
    BinaryVoxels {
        occluders: occluders(params, voxels),
        maps: Maps { count: params.maps, lower: params.lower, maps, layers },
    }
}

/// Returns the light that arrives at pixel `index` from what the maps' lights see: irradiance/π, and in w the share of
/// the hemisphere that cones found open. LRSM eq. 1.
#[inline]
pub fn layered_diffuse(
    index: u32,
    params: &ConeParams,
    surfaces: &[Surface],
    voxels: &[u32],
    maps: &[LayeredMap],
    layers: &[u32],
) -> Vec4 {
    diffuse_through(index, surfaces, params, &binary(params, voxels, maps, layers))
}

/// Returns what the specular lobe of pixel `index` reflects of that and of the environment, for a specular colour of 1; w is
/// 1, or 0 where there is no lobe.
#[inline]
pub fn layered_specular(
    index: u32,
    params: &ConeParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    voxels: &[u32],
    maps: &[LayeredMap],
    layers: &[u32],
    texels: &[u32],
) -> Vec4 {
    let medium = binary(params, voxels, maps, layers);
    specular_through(&surfaces[index as usize], gloss[index as usize], params, texels, &medium)
}
