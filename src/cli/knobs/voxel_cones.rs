//! Which options set the knobs of voxel cone tracing?

use super::set;
use crate::technique::voxel_cones::{RadianceStorage, VoxelCones, Voxelisation};
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
    /// How voxels store radiance
    #[arg(long)]
    radiance_storage: Option<StorageChoice>,
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

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum StorageChoice {
    /// Nine bits for each colour, and a common exponent
    Shared,
    /// Eight bits in equal steps
    Unorm8,
    /// Ten bits in equal steps
    Fixed,
    /// 16-bit floats
    Half,
    /// 32-bit floats
    Float,
}

impl VoxelConesOptions {
    /// Sets the knobs that the options name.
    pub(super) fn apply(&self, s: &mut VoxelCones) {
        set(&mut s.anisotropic, self.anisotropic);
        set(&mut s.bounces, self.voxel_bounces);
        set(&mut s.bounce_cones, self.bounce_cones);
        set(&mut s.light_map, self.photons);
        s.occlusion |= self.occlusion;
        let storage = self.radiance_storage.map(|choice| match choice {
            StorageChoice::Shared => RadianceStorage::Shared,
            StorageChoice::Unorm8 => RadianceStorage::Unorm8,
            StorageChoice::Fixed => RadianceStorage::Fixed,
            StorageChoice::Half => RadianceStorage::Half,
            StorageChoice::Float => RadianceStorage::Float,
        });
        set(&mut s.storage, storage);
        match self.voxelisation {
            Some(VoxelisationChoice::Area) => s.voxelisation = Voxelisation::Area,
            Some(VoxelisationChoice::Thin) => s.voxelisation = Voxelisation::Thin,
            None => {}
        }
    }
}
