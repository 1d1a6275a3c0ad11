//! Which options set the knobs of voxel cone tracing?

use super::set;
use crate::technique::voxel_cones::{VoxelCones, Voxelisation};
use clap::{Args, ValueEnum};

/// The knobs; what is left out keeps the default or the preset's value.
#[derive(Args, Clone, Default, PartialEq)]
#[command(next_help_heading = "Voxel cones")]
pub(crate) struct VoxelConesOptions {
    /// How a triangle counts in the voxels that it meets
    #[arg(long)]
    voxelisation: Option<VoxelisationChoice>,
    /// Whether voxels have six directional values
    #[arg(long, value_name = "BOOL")]
    anisotropic: Option<bool>,
    /// Bounces of indirect light, 1 to 16
    #[arg(long, value_name = "N")]
    voxel_bounces: Option<u32>,
    /// Cones of a voxel for bounces beyond the first
    #[arg(long, value_name = "N")]
    bounce_cones: Option<u32>,
    /// Side of a light's map of photons, texels
    #[arg(long, value_name = "N")]
    photons: Option<u32>,
    /// Render the openness to the surroundings instead of light
    #[arg(long)]
    occlusion: bool,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum VoxelisationChoice {
    /// By the area in each voxel that it touches
    Area,
    /// Fully, in the thinnest set of voxels without holes
    Thin,
}

impl VoxelConesOptions {
    /// Sets the knobs that the options name.
    pub(super) fn apply(&self, s: &mut VoxelCones) {
        set(&mut s.anisotropic, self.anisotropic);
        set(&mut s.bounces, self.voxel_bounces);
        set(&mut s.bounce_cones, self.bounce_cones);
        set(&mut s.light_map, self.photons);
        s.occlusion |= self.occlusion;
        match self.voxelisation {
            Some(VoxelisationChoice::Area) => s.voxelisation = Voxelisation::Area,
            Some(VoxelisationChoice::Thin) => s.voxelisation = Voxelisation::Thin,
            None => {}
        }
    }
}
