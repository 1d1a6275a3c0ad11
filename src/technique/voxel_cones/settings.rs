//! Which knobs does voxel cone tracing have, and what do they do to error and cost?

use crate::error::SettingsError;
use twinlight_kernels::cone::{diameter, mip_level};
use twinlight_kernels::geometry::lattice::MAX_DEPTH;
use twinlight_kernels::sampling::hemisphere::cone;

/// How a triangle counts in the voxels that it meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voxelisation {
    /// By the area that lies in each voxel that it touches: brightness and optical depth do not depend on the resolution.
    Area,
    /// Fully, in voxels whose axis cross it meets: the thinnest set without holes.
    Thin,
}

/// The knobs of voxel cone tracing.
///
/// Errors named here are of indirect light; `docs/voxel-cones.md` has them measured.
#[derive(Clone, Debug, PartialEq)]
pub struct VoxelCones {
    /// Voxels along the longest side of the scene: a power of two, 8 to 512. Leaks and the size of what is lost go with its inverse,
    /// memory and time of the build with its square.
    pub resolution: u32,
    /// How triangles count.
    pub voxelisation: Voxelisation,
    /// Six directional values for each voxel above the leaves; without, one. Walls of two colours leak into each other without.
    pub anisotropic: bool,
    /// Cones over the hemisphere, 1 to 64. The error by their width falls with their number, cost rises with it.
    pub cones: u32,
    /// Half angle of the diffuse cones in degrees, 0.5 to 85; if none, that of the set: 30 for six.
    pub half_angle: Option<f32>,
    /// Half angle of the specular cone in degrees; if none, that of the surface's lobe.
    pub specular_half_angle: Option<f32>,
    /// Step as a share of the width of the voxels sampled, ¹⁄₆₄ to 64. Longer steps are cheaper; transmittance does not change.
    pub step: f32,
    /// Voxels' width as a share of the cone's, 0.1 to 4. Narrower ones blur less, and cost more steps.
    pub width: f32,
    /// Where cones start, in voxels of the finest level, 0 to 16.
    pub start: f32,
    /// Half voxels over a surface within which voxels do not count for its own cones, 0 to 4: what would shadow itself.
    pub clearance: f32,
    /// Share of a cone that may be left unseen, 0 to 0.5: the error by it is at most this.
    pub cutoff: f32,
    /// Bounces of indirect light, 1 to 16. Each more gathers cones at every leaf.
    pub bounces: u32,
    /// Cones of a leaf for bounces beyond the first, 1 to 64.
    pub bounce_cones: u32,
    /// Texels along a side of a light's map of photons, 16 to 8192. Too few leave leaves dark.
    pub light_map: u32,
    /// Pixels at which light is gathered; half of the picture's sides if none, at most 2²⁰. Cost: their number.
    pub illumination: Option<(u32, u32)>,
    /// The picture is the openness to the surroundings instead of light.
    pub occlusion: bool,
}

impl Default for VoxelCones {
    fn default() -> Self {
        Self {
            resolution: 128,
            voxelisation: Voxelisation::Area,
            anisotropic: true,
            cones: 16,
            half_angle: None,
            specular_half_angle: None,
            step: 1.0,
            width: 0.5,
            start: 1.0,
            clearance: 2.0,
            cutoff: 0.01,
            bounces: 1,
            bounce_cones: 6,
            light_map: 1024,
            illumination: None,
            occlusion: false,
        }
    }
}

/// Some devices end all loops of a work item after 65 535 rounds, and say nothing.
const MAX_ROUNDS: u32 = 65_000;
/// The tangent of the half angle of the narrowest specular lobe's cone.
const NARROWEST_LOBE: f32 = 0.0625;

/// The largest number of pixels at which light is gathered.
pub const MAX_PIXELS: u64 = 1 << 20;

impl VoxelCones {
    /// The names of [`VoxelCones::preset`].
    pub const PRESETS: [&str; 5] =
        ["paper-sponza", "paper-ao-10", "paper-ao-20", "paper-ao-30", "paper-ao-60"];

    /// The settings of the paper's tables (§10), for a picture of 512 × 512: Sponza in 512³ voxels with three diffuse cones
    /// and one specular one of 10°, and occlusion by three cones of 10°, 20°, 30° and 60°. Apertures are whole angles.
    pub fn preset(name: &str) -> Option<Self> {
        let sponza = Self {
            resolution: 512,
            cones: 3,
            specular_half_angle: Some(5.0),
            step: 1.0,
            width: 1.0,
            illumination: Some((512, 512)),
            ..Self::default()
        };
        let degrees = match name {
            "paper-sponza" => return Some(sponza),
            "paper-ao-10" => 10.0,
            "paper-ao-20" => 20.0,
            "paper-ao-30" => 30.0,
            "paper-ao-60" => 60.0,
            _ => return None,
        };
        Some(Self { half_angle: Some(0.5 * degrees), occlusion: true, ..sponza })
    }

    /// Pixels at which light is gathered for a picture of this size.
    pub fn illumination_size(&self, width: u32, height: u32) -> (u32, u32) {
        self.illumination.unwrap_or_else(|| {
            let (mut w, mut h) = (width.div_ceil(2), height.div_ceil(2));
            while u64::from(w) * u64::from(h) > MAX_PIXELS {
                (w, h) = (w.div_ceil(2), h.div_ceil(2));
            }
            (w, h)
        })
    }

    /// The depth of the pyramid: log₂ of the resolution.
    pub fn depth(&self) -> u32 {
        self.resolution.ilog2()
    }

    /// Rounds of loops that a pixel or a leaf takes for its cones, at most: nine for each step.
    fn rounds(&self) -> u32 {
        let own = |cones: u32| self.half_angle.map_or(cone(cones, 0, 0.0).tangent, |d| d.to_radians().tan());
        let specular = self.specular_half_angle.map_or(NARROWEST_LOBE, |d| d.to_radians().tan());
        let of = |cones: u32, tangent: f32| cones.saturating_mul(9 * self.steps(tangent) + 2);
        of(self.cones, own(self.cones))
            .max(of(self.bounce_cones, own(self.bounce_cones)))
            .max(of(1, specular))
    }

    /// Steps of the longest cone through the scene.
    fn steps(&self, tangent: f32) -> u32 {
        let end = 1.74 * self.resolution as f32 * (1.0 + 2.0 * tangent * self.width) + 1.0;
        let (mut t, mut steps) = (self.start, 0);
        while t < end && steps < MAX_ROUNDS {
            let level = mip_level(diameter(t, tangent) * self.width, self.depth() as f32);
            t += level.exp2() * self.step;
            steps += 1;
        }
        steps
    }

    /// Refuses what cannot be done for a picture of this size.
    ///
    /// # Errors
    /// The first knob that is out of range, with its range.
    pub fn check(&self, width: u32, height: u32) -> Result<(), SettingsError> {
        let refuse = |knob: &'static str, reason: String| Err(SettingsError { knob, reason });
        if !self.resolution.is_power_of_two() || !(8..=1 << MAX_DEPTH).contains(&self.resolution) {
            let reason = format!("{} is not a power of two from 8 to {}", self.resolution, 1 << MAX_DEPTH);
            return refuse("resolution", reason);
        }
        for (knob, value, low, high) in [
            ("cones", self.cones, 1, 64),
            ("bounce-cones", self.bounce_cones, 1, 64),
            ("bounces", self.bounces, 1, 16),
            ("photons", self.light_map, 16, 8192),
        ] {
            if !(low..=high).contains(&value) {
                return refuse(knob, format!("{value} is not from {low} to {high}"));
            }
        }
        for (knob, value, low, high) in [
            ("half-angle", self.half_angle.unwrap_or(1.0), 0.5, 85.0),
            ("specular-half-angle", self.specular_half_angle.unwrap_or(1.0), 0.5, 85.0),
            ("step", self.step, 1.0 / 64.0, 64.0),
            ("voxel-width", self.width, 0.1, 4.0),
            ("start", self.start, 0.0, 16.0),
            ("clearance", self.clearance, 0.0, 4.0),
            ("cutoff", self.cutoff, 0.0, 0.5),
        ] {
            if !(value >= low && value <= high) {
                return refuse(knob, format!("{value} is not from {low} to {high}"));
            }
        }
        let rounds = self.rounds();
        if rounds > MAX_ROUNDS {
            let reason = format!(
                "cones take {rounds} rounds of loops a pixel, over {MAX_ROUNDS}; longer steps, or fewer or wider cones"
            );
            return refuse("step", reason);
        }
        let (w, h) = self.illumination_size(width, height);
        let pixels = u64::from(w) * u64::from(h);
        if pixels == 0 || pixels > MAX_PIXELS {
            return refuse("illumination", format!("{w}x{h} is not from 1 to {MAX_PIXELS} pixels"));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_settings_are_accepted_and_others_refused() {
        for name in VoxelCones::PRESETS {
            let settings = VoxelCones::preset(name).unwrap();
            settings.check(512, 512).unwrap();
            assert_eq!((settings.resolution, settings.depth(), settings.cones), (512, 9, 3));
            assert_eq!(settings.occlusion, name.contains("ao"));
        }
        assert!(VoxelCones::preset("paper-teapot").is_none());
        type Spoil = fn(&mut VoxelCones);
        let spoilt: [(&str, Spoil); 12] = [
            ("step", |s| (s.cones, s.step) = (64, 0.125)),
            ("step", |s| (s.half_angle, s.step) = (Some(0.5), 0.015_625)),
            ("resolution", |s| s.resolution = 100),
            ("resolution", |s| s.resolution = 1024),
            ("resolution", |s| s.resolution = 0),
            ("cones", |s| s.cones = 0),
            ("bounces", |s| s.bounces = 17),
            ("photons", |s| s.light_map = 1),
            ("half-angle", |s| s.half_angle = Some(f32::NAN)),
            ("step", |s| s.step = 0.0),
            ("cutoff", |s| s.cutoff = f32::INFINITY),
            ("illumination", |s| s.illumination = Some((0, 4))),
        ];
        for (knob, spoil) in spoilt {
            let mut settings = VoxelCones::default();
            spoil(&mut settings);
            assert_eq!(settings.check(512, 512).unwrap_err().knob, knob);
        }
    }
}
