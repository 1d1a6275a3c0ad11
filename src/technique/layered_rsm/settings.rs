//! Which knobs do layered reflective shadow maps have, and what do they do to error and cost?

use crate::error::SettingsError;
use crate::technique::cones::{Cones, MAX_ROUNDS, check_rounds, in_range};
use crate::technique::gathered::check_illumination;
use crate::technique::voxel_cones::check_resolution;
use twinlight_kernels::gaussian::UNORM16_DEVIATION;
use twinlight_kernels::passes::layered_rsm::layers::texels_before;
use twinlight_kernels::passes::layered_rsm::texel::{
    MOMENTS_DEVIATION16, MOMENTS_FLOAT, MOMENTS_UNORM16, texel_words,
};

/// What a byte above the binary voxels holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Opacity {
    /// For each axis which share of the rays along it is stopped: a wall stays opaque at every level.
    Covered,
    /// The mean of the voxels below, as published: a wall lets through twice as much from level to level.
    Mean,
}

/// How depths are stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moments {
    /// Mean and variance as floats, 16 bytes a texel with all else.
    Float,
    /// Means of depth and squared depth in 16-bit fixed point, as published, 12 bytes.
    Unorm16,
    /// Mean and standard deviation in 16-bit fixed point, 12 bytes.
    Deviation16,
}

/// By what surfaces count within a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weights {
    /// By their area as who looks sees it, the radiance being the mean over lit and shadowed surfaces: eqs. 3 and 4.
    Area,
    /// Algorithm 1 as published, with all its assumptions: too dark where light comes at a slant, or surfaces are seen at one,
    /// or are smaller than a sample.
    Opacity,
}

/// The knobs of layered reflective shadow maps.
///
/// Errors named here are of indirect light; `docs/layered-rsm.md` has them measured.
#[derive(Clone, Debug, PartialEq)]
pub struct LayeredRsm {
    /// Binary voxels along each side: a power of two, 8 to 512. Memory goes with its cube, 4.3 MiB at 256.
    pub resolution: u32,
    /// What filtered voxels hold.
    pub opacity: Opacity,
    /// Texels along a side of each light's map: a power of two, 16 to 4096; layers have half of it.
    pub map: u32,
    /// Layers by depth, 1 to 8.
    pub depth_layers: u32,
    /// Layers by ⟨n·l⟩, 1 to 8.
    pub normal_layers: u32,
    /// How depths are stored.
    pub moments: Moments,
    /// The smallest deviation of depths as a share of half a layer, 0 to 1; if none, what the format can tell.
    pub deviation: Option<f32>,
    /// Overlap of depth layers as a share of a layer, 0 to 1, with the decay of eq. 15 between them. Without, every layer
    /// that a sample reaches is read, which loses nothing.
    pub overlap: f32,
    /// By what surfaces count.
    pub weights: Weights,
    /// Radius within which surfaces belong to a sample, in half widths of its voxels, 0.1 to 8. Larger ones leak, smaller ones lose.
    pub window: f32,
    /// Diameter looked up on the map as a share of the width of a sample's voxels, 0.1 to 8.
    pub footprint: f32,
    /// The finest level of the layers that is looked up, 0 to 12: higher is calmer and less sharp.
    pub least_level: f32,
    /// The coarsest level of the layers that is looked up, 0 to 12: lower is sharper, and flickers where samples are wide; all if none.
    pub most_level: Option<u32>,
    /// How cones go through the voxels.
    pub cones: Cones,
    /// Shadows of lights by cones through the voxels instead of rays.
    pub shadow_cones: bool,
    /// Radius of point and spot lights for these, metres.
    pub light_radius: f32,
    /// Half of the angle that a sun spans for these, degrees, 0 to 45.
    pub sun_angle: f32,
    /// Pixels at which light is gathered; half of the picture's sides if none, at most 2²⁰. Cost: their number.
    pub illumination: Option<(u32, u32)>,
}

impl Default for LayeredRsm {
    fn default() -> Self {
        Self {
            resolution: 128,
            opacity: Opacity::Covered,
            map: 512,
            depth_layers: 2,
            normal_layers: 2,
            moments: Moments::Deviation16,
            deviation: None,
            overlap: 0.0,
            weights: Weights::Area,
            window: 1.5,
            footprint: 1.0,
            least_level: 0.0,
            most_level: None,
            cones: Cones::default(),
            shadow_cones: false,
            light_radius: 0.0,
            sun_angle: 0.0,
            illumination: None,
        }
    }
}

/// Bytes of layers that one gathering reads, at most: lights beyond are gathered after each other.
const LAYER_BYTES: u64 = 96 << 20;

impl LayeredRsm {
    /// The names of [`LayeredRsm::preset`].
    pub const PRESETS: [&str; 3] = ["paper-sibenik", "paper-sponza", "paper-sponza-dragon"];

    /// The settings of the paper's tables (§6) for pictures of 1280 × 720 gathered at every pixel.
    pub fn preset(name: &str) -> Option<Self> {
        let (resolution, depth_layers) = match name {
            "paper-sibenik" => (256, 2),
            "paper-sponza" => (512, 2),
            "paper-sponza-dragon" => (512, 3),
            _ => return None,
        };
        Some(Self {
            resolution,
            opacity: Opacity::Mean,
            map: 1024,
            depth_layers,
            normal_layers: 2,
            moments: Moments::Unorm16,
            overlap: 0.1,
            weights: Weights::Opacity,
            window: 1.0,
            footprint: 1.0,
            cones: Cones {
                count: 6,
                specular_half_angle: Some(5.0),
                width: 1.0,
                interleave: false,
                ..Cones::default()
            },
            shadow_cones: true,
            illumination: Some((1280, 720)),
            ..Self::default()
        })
    }

    /// log₂ of the resolution.
    pub fn depth(&self) -> u32 {
        self.resolution.ilog2()
    }

    /// Number of layers.
    pub fn layers(&self) -> u32 {
        self.depth_layers * self.normal_layers
    }

    /// The kernels' number of the format.
    pub(super) fn format(&self) -> u32 {
        match self.moments {
            Moments::Float => MOMENTS_FLOAT,
            Moments::Unorm16 => MOMENTS_UNORM16,
            Moments::Deviation16 => MOMENTS_DEVIATION16,
        }
    }

    /// The smallest deviation, as a share of half a layer.
    pub(super) fn least_deviation(&self) -> f32 {
        self.deviation.unwrap_or(match self.moments {
            Moments::Float => 1.0e-5,
            Moments::Unorm16 => 2.0 * UNORM16_DEVIATION,
            Moments::Deviation16 => 1.0e-4,
        })
    }

    /// Levels of the layers: down to one texel.
    pub(super) fn levels(&self) -> u32 {
        self.map.ilog2()
    }

    /// Words of all layers and levels of a light.
    pub fn words_per_light(&self) -> u32 {
        let texels = texels_before(self.map / 2, self.levels() - 1) + 1;
        texels * self.layers() * texel_words(self.format())
    }

    /// Lights that are gathered together: as many as buffers and loops hold.
    pub(super) fn lights_at_once(&self) -> u32 {
        let by_bytes = (LAYER_BYTES / (4 * u64::from(self.words_per_light()))).max(1) as u32;
        (1..=by_bytes.min(64)).rev().find(|&lights| self.rounds(lights) <= MAX_ROUNDS).unwrap_or(1)
    }

    /// Rounds of loops that a pixel's cones take with this many lights.
    fn rounds(&self, lights: u32) -> u32 {
        self.cones.rounds(self.depth(), self.cones.count, 9 + lights * (1 + self.layers()), 40)
    }

    /// Refuses what cannot be done for a picture of this size.
    ///
    /// # Errors
    /// The first knob that is out of range, with its range.
    pub fn check(&self, width: u32, height: u32) -> Result<(), SettingsError> {
        check_resolution(self.resolution)?;
        self.cones.check()?;
        if !self.map.is_power_of_two() || !(16..=4096).contains(&self.map) {
            let reason = format!("{} is not a power of two from 16 to 4096", self.map);
            return Err(SettingsError { knob: "rsm", reason });
        }
        in_range("depth-layers", self.depth_layers as f32, 1.0, 8.0)?;
        in_range("normal-layers", self.normal_layers as f32, 1.0, 8.0)?;
        in_range("deviation", self.deviation.unwrap_or(0.0), 0.0, 1.0)?;
        in_range("layer-overlap", self.overlap, 0.0, 1.0)?;
        in_range("window", self.window, 0.1, 8.0)?;
        in_range("footprint", self.footprint, 0.1, 8.0)?;
        in_range("least-level", self.least_level, 0.0, 12.0)?;
        if let Some(most) = self.most_level {
            in_range("most-level", most as f32, self.least_level, 12.0)?;
        }
        in_range("light-radius", self.light_radius, 0.0, 1.0e6)?;
        in_range("sun-angle", self.sun_angle, 0.0, 45.0)?;
        let bytes = 4 * u64::from(self.words_per_light());
        if bytes > 128 << 20 {
            let reason = format!(
                "{} texels in {} layers are {} MiB a light, over 128; fewer layers or a smaller map",
                self.map,
                self.layers(),
                bytes >> 20
            );
            return Err(SettingsError { knob: "rsm", reason });
        }
        check_rounds(self.rounds(1))?;
        check_illumination(self.illumination, width, height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_settings_are_accepted_and_others_refused() {
        for name in LayeredRsm::PRESETS {
            let settings = LayeredRsm::preset(name).unwrap();
            settings.check(1280, 720).unwrap();
            assert_eq!(settings.layers(), if name.ends_with("dragon") { 6 } else { 4 });
        }
        assert!(LayeredRsm::preset("paper-teapot").is_none());
        type Spoil = fn(&mut LayeredRsm);
        let spoilt: [(&str, Spoil); 13] = [
            ("resolution", |s| s.resolution = 100),
            ("rsm", |s| s.map = 1000),
            ("rsm", |s| (s.map, s.depth_layers, s.normal_layers) = (4096, 8, 8)),
            ("depth-layers", |s| s.depth_layers = 0),
            ("normal-layers", |s| s.normal_layers = 9),
            ("layer-overlap", |s| s.overlap = f32::NAN),
            ("window", |s| s.window = 0.0),
            ("most-level", |s| s.most_level = Some(13)),
            ("most-level", |s| (s.least_level, s.most_level) = (2.5, Some(2))),
            ("light-radius", |s| s.light_radius = -1.0),
            ("sun-angle", |s| s.sun_angle = 90.0),
            ("step", |s| (s.cones.count, s.cones.step) = (64, 0.125)),
            ("illumination", |s| s.illumination = Some((0, 4))),
        ];
        for (knob, spoil) in spoilt {
            let mut settings = LayeredRsm::default();
            spoil(&mut settings);
            assert_eq!(settings.check(512, 512).unwrap_err().knob, knob);
        }
    }

    #[test]
    fn lights_are_grouped_by_bytes_and_by_rounds() {
        let usual = LayeredRsm::default();
        assert!(usual.lights_at_once() >= 4, "{}", usual.lights_at_once());
        let large = LayeredRsm { map: 4096, depth_layers: 1, normal_layers: 1, ..usual.clone() };
        assert_eq!(large.lights_at_once(), 1);
        let many = LayeredRsm { depth_layers: 8, normal_layers: 8, map: 64, ..usual };
        assert!(many.rounds(many.lights_at_once()) <= MAX_ROUNDS);
    }
}
