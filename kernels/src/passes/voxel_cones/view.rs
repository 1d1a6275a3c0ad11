//! What do the voxels themselves look like?

use super::lobes::{LOBE_WORDS, lobe_normal};
use super::march::sent_toward;
use crate::geometry::lattice::{NO_VOXEL, voxel_at};
use crate::geometry::voxel_walk::VoxelWalk;
use crate::math::{div, exp};
use crate::passes::surface::{CameraParams, pixel_direction};
use glam::{UVec3, Vec3, Vec4};

/// [`VoxelViewParams::what`]: radiance toward the eye, and in w the opacity.
pub const VIEW_RADIANCE: u32 = 0;
/// [`VoxelViewParams::what`]: mean normal of what is mirrored, and in w the variance of its lobes.
pub const VIEW_LOBES: u32 = 1;

gpu_struct! {
    /// What [`draw_voxels`] draws.
    pub struct VoxelViewParams {
        /// Lattice point (0, 0, 0) in metres; w is the voxel edge of level 0, metres.
        pub lower: Vec4,
        /// 1/(voxel edge of level 0), 1/m.
        pub inverse_edge: f32,
        /// Depth of the pyramid.
        pub depth: u32,
        /// Level of the voxels.
        pub level: u32,
        /// [`VIEW_RADIANCE`] or [`VIEW_LOBES`].
        pub what: u32,
        /// Words before the lobes in the radiance; 0 where there are none.
        pub lobes: u32,
        /// W/(m² sr) per unit of stored radiance.
        pub radiance_unit: f32,
        /// How radiance is stored: [`SHARED_EXPONENT`](super::storage::SHARED_EXPONENT) or another.
        pub storage: u32,
        /// Padding.
        pub pad1: u32,
    }
}

/// Returns what pixel `index` of the band sees of the voxels of a level, as cubes; 0 where it sees none. `view` has one
/// element.
#[inline]
pub fn draw_voxels(
    index: u32,
    params: &CameraParams,
    view: &[VoxelViewParams],
    blocks: &[u32],
    depths: &[u32],
    places: &[u32],
    radiance: &[u32],
) -> Vec4 {
    let v = &view[0];
    let direction = pixel_direction(index, params);
    let edge = (1u32 << v.level) as f32;
    // Voxels are centred on lattice points.
    let on_level = (params.eye.truncate() - v.lower.truncate()) * div(v.inverse_edge, edge);
    let count = (1u32 << (v.depth - v.level)) + 1;
    let mut walk = VoxelWalk::new(on_level + Vec3::splat(0.5), direction, UVec3::splat(count), 1.0e30);
    let mut seen = Vec4::ZERO;
    let mut found = false;
    while walk.inside && !found {
        let voxel = voxel_at(blocks, v.depth, v.level, walk.voxel);
        if voxel != NO_VOXEL {
            let sent = sent_toward(voxel, direction, v.lobes, v.storage, 0.0, depths, places, radiance);
            found = sent.density > 0.0;
            if found && v.what == VIEW_LOBES {
                let place = places[voxel as usize];
                if v.lobes > 0 && place > 0 {
                    let (normal, variance) = lobe_normal(radiance, v.lobes + LOBE_WORDS * (place - 1));
                    seen = normal.extend(variance);
                }
            } else if found {
                let light = sent.carried * div(v.radiance_unit, sent.density);
                seen = light.extend(1.0 - exp(-sent.density));
            }
        }
        walk.step();
    }
    seen
}
