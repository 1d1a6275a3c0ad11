//! Which options set the knobs of cones through voxels, of either kind?

use super::set;
use crate::technique::Cones;
use clap::Args;

/// The knobs; what is left out keeps the default or the preset's value.
#[derive(Args, Clone, Default, PartialEq)]
#[command(next_help_heading = "Cones (voxel-cones, layered-rsm)")]
pub(crate) struct ConeOptions {
    /// Voxels along the longest side of the scene: a power of two from 8 to 512
    #[arg(long, value_name = "N")]
    pub(super) resolution: Option<u32>,
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
    /// Whether neighbouring pixels turn their cones differently, and share what they find
    #[arg(long, value_name = "BOOL")]
    interleave: Option<bool>,
    /// Share of a cone that may be left unseen
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    cutoff: Option<f32>,
}

impl ConeOptions {
    /// Sets the knobs that the options name.
    pub(super) fn apply(&self, c: &mut Cones) {
        set(&mut c.count, self.cones);
        c.half_angle = self.half_angle.or(c.half_angle);
        c.specular_half_angle = self.specular_half_angle.or(c.specular_half_angle);
        set(&mut c.step, self.step);
        set(&mut c.width, self.voxel_width);
        set(&mut c.start, self.start);
        set(&mut c.clearance, self.clearance);
        set(&mut c.interleave, self.interleave);
        set(&mut c.cutoff, self.cutoff);
    }
}
