//! Which knobs does voxel cone tracing have, and what do they do to error and cost?

use crate::error::SettingsError;
use crate::technique::cones::{Cones, check_rounds};
use crate::technique::gathered::check_illumination;
use twinlight_kernels::geometry::lattice::MAX_DEPTH;
use twinlight_kernels::passes::voxel_cones::storage;

/// How a triangle counts in the voxels that it meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Voxelisation {
    /// By the area that lies in each voxel that it touches: brightness and optical depth do not depend on the resolution.
    Area,
    /// Fully, in voxels whose axis cross it meets: the thinnest set without holes.
    Thin,
}

/// How voxels store their radiance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RadianceStorage {
    /// Nine bits for each colour and a common exponent, one word: 0.2 % of the largest colour.
    #[default]
    Shared,
    /// Eight bits for each colour in equal steps up to 64 typical radiances, one word.
    Unorm8,
    /// Ten bits, likewise.
    Fixed,
    /// IEEE binary16, two words.
    Half,
    /// IEEE binary32, three words.
    Float,
}

impl RadianceStorage {
    /// The same for the passes, in the flags of their parameters.
    pub(super) fn flags(self) -> u32 {
        self.number() << storage::STORAGE_SHIFT
    }

    /// The same for the passes.
    pub(super) fn number(self) -> u32 {
        match self {
            Self::Shared => storage::SHARED_EXPONENT,
            Self::Unorm8 => storage::UNORM8,
            Self::Fixed => storage::FIXED,
            Self::Half => storage::HALF,
            Self::Float => storage::FLOAT,
        }
    }
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
    /// How radiance is stored.
    pub storage: RadianceStorage,
    /// How cones go through the voxels.
    pub cones: Cones,
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
            storage: RadianceStorage::default(),
            cones: Cones::default(),
            bounces: 1,
            bounce_cones: 6,
            light_map: 1024,
            illumination: None,
            occlusion: false,
        }
    }
}

/// Smaller copies of an environment's map, at most: of 2¹⁶ rows.
const MAX_COPIES: u32 = 16;

impl VoxelCones {
    /// The names of [`VoxelCones::preset`].
    pub const PRESETS: [&str; 5] =
        ["paper-sponza", "paper-ao-10", "paper-ao-20", "paper-ao-30", "paper-ao-60"];

    /// The settings of the paper's tables (§10), for a picture of 512 × 512: Sponza in 512³ voxels with three diffuse cones
    /// and one specular one of 10°, and occlusion by three cones of 10°, 20°, 30° and 60°. Apertures are whole angles.
    pub fn preset(name: &str) -> Option<Self> {
        let sponza = Self {
            resolution: 512,
            cones: Cones {
                count: 3,
                specular_half_angle: Some(5.0),
                width: 1.0,
                interleave: false,
                ..Cones::default()
            },
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
        let cones = Cones { half_angle: Some(0.5 * degrees), ..sponza.cones };
        Some(Self { cones, occlusion: true, ..sponza })
    }

    /// The depth of the pyramid: log₂ of the resolution.
    pub fn depth(&self) -> u32 {
        self.resolution.ilog2()
    }

    /// Rounds of loops that a pixel or a leaf takes for its cones, at most: nine for each step; twice those to the
    /// environment's smallest copy at its end.
    fn rounds(&self) -> u32 {
        let of = |count: u32| self.cones.rounds(self.depth(), count, 9, 2 + 2 * MAX_COPIES);
        of(self.cones.count).max(of(self.bounce_cones))
    }

    /// Refuses what cannot be done for a picture of this size.
    ///
    /// # Errors
    /// The first knob that is out of range, with its range.
    pub fn check(&self, width: u32, height: u32) -> Result<(), SettingsError> {
        let refuse = |knob: &'static str, reason: String| Err(SettingsError { knob, reason });
        check_resolution(self.resolution)?;
        self.cones.check()?;
        for (knob, value, low, high) in [
            ("bounce-cones", self.bounce_cones, 1, 64),
            ("bounces", self.bounces, 1, 16),
            ("photons", self.light_map, 16, 8192),
        ] {
            if !(low..=high).contains(&value) {
                return refuse(knob, format!("{value} is not from {low} to {high}"));
            }
        }
        check_rounds(self.rounds())?;
        check_illumination(self.illumination, width, height)
    }
}

/// Refuses what is no number of voxels.
pub(in crate::technique) fn check_resolution(resolution: u32) -> Result<(), SettingsError> {
    if resolution.is_power_of_two() && (8..=1 << MAX_DEPTH).contains(&resolution) {
        return Ok(());
    }
    let reason = format!("{resolution} is not a power of two from 8 to {}", 1 << MAX_DEPTH);
    Err(SettingsError { knob: "resolution", reason })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_settings_are_accepted_and_others_refused() {
        for name in VoxelCones::PRESETS {
            let settings = VoxelCones::preset(name).unwrap();
            settings.check(512, 512).unwrap();
            assert_eq!((settings.resolution, settings.depth(), settings.cones.count), (512, 9, 3));
            assert_eq!(settings.occlusion, name.contains("ao"));
        }
        assert!(VoxelCones::preset("paper-teapot").is_none());
        type Spoil = fn(&mut VoxelCones);
        let spoilt: [(&str, Spoil); 12] = [
            ("step", |s| (s.cones.count, s.cones.step) = (64, 0.125)),
            ("step", |s| (s.cones.half_angle, s.cones.step) = (Some(0.5), 0.015_625)),
            ("resolution", |s| s.resolution = 100),
            ("resolution", |s| s.resolution = 1024),
            ("resolution", |s| s.resolution = 0),
            ("cones", |s| s.cones.count = 0),
            ("bounces", |s| s.bounces = 17),
            ("photons", |s| s.light_map = 1),
            ("half-angle", |s| s.cones.half_angle = Some(f32::NAN)),
            ("step", |s| s.cones.step = 0.0),
            ("cutoff", |s| s.cones.cutoff = f32::INFINITY),
            ("illumination", |s| s.illumination = Some((0, 4))),
        ];
        for (knob, spoil) in spoilt {
            let mut settings = VoxelCones::default();
            spoil(&mut settings);
            assert_eq!(settings.check(512, 512).unwrap_err().knob, knob);
        }
    }
}
