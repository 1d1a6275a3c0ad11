//! Which options set the knobs of the techniques?
//!
//! What several techniques have stands here once: `--preset`, `--illumination`, and those of cones.

mod cones;
mod layered_rsm;
mod soft_gi;
mod visibility_filter;
mod voxel_cones;

use super::Failure;
use super::options::parse_size;
use crate::technique::layered_rsm::LayeredRsm;
use crate::technique::soft_gi::SoftGi;
use crate::technique::visibility_filter::VisibilityFilter;
use crate::technique::voxel_cones::VoxelCones;
use clap::Args;

/// The knobs of all techniques; what is left out keeps the default or the preset's value.
#[derive(Args, Clone, Default, PartialEq)]
pub(crate) struct Knobs {
    /// Start from published settings of the technique, such as paper-sponza; options beside it win
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// Pixels at which indirect light is gathered [default: half of the picture's sides]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    illumination: Option<(u32, u32)>,
    #[command(flatten)]
    cones: cones::ConeOptions,
    #[command(flatten)]
    filter: visibility_filter::VisibilityFilterOptions,
    #[command(flatten)]
    voxels: voxel_cones::VoxelConesOptions,
    #[command(flatten)]
    soft: soft_gi::SoftGiOptions,
    #[command(flatten)]
    layered: layered_rsm::LayeredRsmOptions,
}

/// Sets a knob if its option is given.
fn set<T: Copy>(knob: &mut T, option: Option<T>) {
    *knob = option.unwrap_or(*knob);
}

/// A technique with knobs.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Of {
    VisibilityFilter,
    VoxelCones,
    SoftGi,
    LayeredRsm,
}

impl Of {
    const ALL: [Self; 4] = [Self::VisibilityFilter, Self::VoxelCones, Self::SoftGi, Self::LayeredRsm];

    fn presets(self) -> &'static [&'static str] {
        match self {
            Self::VisibilityFilter => &VisibilityFilter::PRESETS,
            Self::VoxelCones => &VoxelCones::PRESETS,
            Self::SoftGi => &SoftGi::PRESETS,
            Self::LayeredRsm => &LayeredRsm::PRESETS,
        }
    }
}

impl Knobs {
    /// The preset, if this technique has it.
    fn preset_of(&self, technique: Of) -> Option<&str> {
        self.preset.as_deref().filter(|name| technique.presets().contains(name))
    }

    /// The settings of the visibility filter.
    pub(crate) fn visibility_filter(&self) -> VisibilityFilter {
        let preset = self.preset_of(Of::VisibilityFilter).and_then(VisibilityFilter::preset);
        let mut s = preset.unwrap_or_default();
        s.illumination = self.illumination.or(s.illumination);
        self.filter.apply(&mut s);
        s
    }

    /// The settings of voxel cones.
    pub(crate) fn voxel_cones(&self) -> VoxelCones {
        let mut s = self.preset_of(Of::VoxelCones).and_then(VoxelCones::preset).unwrap_or_default();
        s.illumination = self.illumination.or(s.illumination);
        set(&mut s.resolution, self.cones.resolution);
        self.cones.apply(&mut s.cones);
        self.voxels.apply(&mut s);
        s
    }

    /// The settings of soft global illumination.
    pub(crate) fn soft_gi(&self) -> SoftGi {
        let mut s = self.preset_of(Of::SoftGi).and_then(SoftGi::preset).unwrap_or_default();
        self.soft.apply(&mut s);
        s
    }

    /// The settings of layered reflective shadow maps.
    pub(crate) fn layered_rsm(&self) -> LayeredRsm {
        let mut s = self.preset_of(Of::LayeredRsm).and_then(LayeredRsm::preset).unwrap_or_default();
        s.illumination = self.illumination.or(s.illumination);
        set(&mut s.resolution, self.cones.resolution);
        self.cones.apply(&mut s.cones);
        self.layered.apply(&mut s);
        s
    }

    /// Refuses presets that none of these techniques has, and options that do nothing for any of them; `name` is what was chosen.
    pub(crate) fn check(&self, techniques: &[Of], name: &str) -> Result<(), Failure> {
        let known: Vec<&str> = techniques.iter().flat_map(|t| t.presets()).copied().collect();
        if let Some(preset) = self.preset.as_ref().filter(|p| !known.contains(&p.as_str())) {
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(Failure::Request(format!("--preset {preset}: {name} has {known}")));
        }
        let has = |of: &[Of]| of.iter().any(|t| techniques.contains(t));
        let cones = [Of::VoxelCones, Of::LayeredRsm];
        let gathering = [Of::VisibilityFilter, Of::VoxelCones, Of::LayeredRsm];
        let idle = [
            ("--illumination does", self.illumination.is_some() && !has(&gathering)),
            ("the options of cones do", self.cones != Default::default() && !has(&cones)),
            (
                "the options of the visibility filter do",
                self.filter != Default::default() && !has(&[Of::VisibilityFilter]),
            ),
            ("the options of voxel cones do", self.voxels != Default::default() && !has(&[Of::VoxelCones])),
            (
                "the options of soft global illumination do",
                self.soft != Default::default() && !has(&[Of::SoftGi]),
            ),
            (
                "the options of layered reflective shadow maps do",
                self.layered != Default::default() && !has(&[Of::LayeredRsm]),
            ),
        ];
        match idle.iter().find(|(_, idle)| *idle) {
            Some((what, _)) => {
                Err(Failure::Request(format!("{what} nothing for --technique {name}; leave them out")))
            }
            None => Ok(()),
        }
    }

    /// [`Self::check`] where all techniques run.
    pub(crate) fn check_all(&self) -> Result<(), Failure> {
        self.check(&Of::ALL, "this")
    }
}
