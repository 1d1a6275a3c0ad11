//! Which options set the knobs of voxel cone tracing?

use super::Failure;
use super::options::parse_size;
use crate::technique::voxel_cones::{VoxelCones, Voxelisation};
use clap::{Args, ValueEnum};

/// The knobs; what is left out keeps the default or the preset's value.
#[derive(Args, Clone, Default, PartialEq)]
#[command(next_help_heading = "Voxel cones")]
pub(crate) struct VoxelConesOptions {
    /// Start from published settings: paper-sponza, paper-ao-10, paper-ao-20, paper-ao-30, paper-ao-60
    #[arg(long, value_name = "NAME")]
    cone_preset: Option<String>,
    /// Voxels along the longest side of the scene: a power of two from 8 to 512
    #[arg(long, value_name = "N")]
    resolution: Option<u32>,
    /// How a triangle counts in the voxels that it meets
    #[arg(long)]
    voxelisation: Option<VoxelisationChoice>,
    /// Whether voxels have six directional values
    #[arg(long, value_name = "BOOL")]
    anisotropic: Option<bool>,
    /// Cones over the hemisphere, 1 to 64
    #[arg(long, value_name = "N")]
    cones: Option<u32>,
    /// Half angle of the diffuse cones in degrees [default: as the number of cones needs]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    half_angle: Option<f32>,
    /// Half angle of the specular cone in degrees [default: of the surface's lobe]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    specular_half_angle: Option<f32>,
    /// Step of cones, as a share of the width of the voxels they sample
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    step: Option<f32>,
    /// Width of the voxels that cones sample, as a share of the cone's
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    voxel_width: Option<f32>,
    /// Where cones start, in voxels
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    start: Option<f32>,
    /// Half voxels over a surface within which nothing counts for its own cones
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    clearance: Option<f32>,
    /// Share of a cone that may be left unseen
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    cutoff: Option<f32>,
    /// Bounces of indirect light, 1 to 16
    #[arg(long, value_name = "N")]
    voxel_bounces: Option<u32>,
    /// Cones of a voxel for bounces beyond the first
    #[arg(long, value_name = "N")]
    bounce_cones: Option<u32>,
    /// Side of a light's map of photons, texels
    #[arg(long, value_name = "N")]
    photons: Option<u32>,
    /// Pixels at which cones gather light [default: half of the picture's sides]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    cone_pixels: Option<(u32, u32)>,
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
    /// The settings that the options ask for.
    pub(crate) fn settings(&self) -> Result<VoxelCones, Failure> {
        let mut s = match &self.cone_preset {
            None => VoxelCones::default(),
            Some(name) => VoxelCones::preset(name).ok_or_else(|| {
                Failure::Request(format!(
                    "--cone-preset {name}: voxel-cones has {}",
                    VoxelCones::PRESETS.join(", ")
                ))
            })?,
        };
        fn set<T: Copy>(knob: &mut T, option: Option<T>) {
            *knob = option.unwrap_or(*knob);
        }
        set(&mut s.resolution, self.resolution);
        set(&mut s.anisotropic, self.anisotropic);
        set(&mut s.cones, self.cones);
        s.half_angle = self.half_angle.or(s.half_angle);
        s.specular_half_angle = self.specular_half_angle.or(s.specular_half_angle);
        set(&mut s.step, self.step);
        set(&mut s.width, self.voxel_width);
        set(&mut s.start, self.start);
        set(&mut s.clearance, self.clearance);
        set(&mut s.cutoff, self.cutoff);
        set(&mut s.bounces, self.voxel_bounces);
        set(&mut s.bounce_cones, self.bounce_cones);
        set(&mut s.light_map, self.photons);
        s.illumination = self.cone_pixels.or(s.illumination);
        s.occlusion |= self.occlusion;
        match self.voxelisation {
            Some(VoxelisationChoice::Area) => s.voxelisation = Voxelisation::Area,
            Some(VoxelisationChoice::Thin) => s.voxelisation = Voxelisation::Thin,
            None => {}
        }
        Ok(s)
    }
}
