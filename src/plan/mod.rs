//! What runs, and why? The one place that decides it, from what a scene has and from what is asked for.
//!
//! A [`Plan`] names the effects that are called for. Techniques follow it: they make no buffer, pipeline or pass for another. What follows from it,
//! [`Costs`], is found by running the technique on a backend that only [notes](crate::backend::Recorder) what is asked of it.

mod choice;
mod effect;
mod explain;

pub use choice::choose;
pub use effect::{Bound, Effect};
pub use explain::{Change, Costs, stages};

use crate::error::SettingsError;
use crate::scene::{Census, Scene};
use crate::technique::layered_rsm::LayeredRsm;
use crate::technique::soft_gi::SoftGi;
use crate::technique::visibility_filter::VisibilityFilter;
use crate::technique::voxel_cones::VoxelCones;
use crate::technique::{Job, LightPart, View};

/// A technique with its knobs.
#[derive(Clone, Debug, PartialEq)]
pub enum Technique {
    /// Light straight from its sources.
    Direct,
    /// Openness by rays.
    AmbientOcclusion,
    /// Point proxies in voxels with filtered visibility.
    VisibilityFilter(VisibilityFilter),
    /// Cones through filtered voxels.
    VoxelCones(VoxelCones),
    /// Spherical proxies under soft surroundings.
    SoftGi(SoftGi),
    /// Cones through binary voxels and layered maps.
    LayeredRsm(LayeredRsm),
}

impl Technique {
    /// Its name on the command line.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Direct => "direct",
            Self::AmbientOcclusion => "ambient-occlusion",
            Self::VisibilityFilter(_) => "visibility-filter",
            Self::VoxelCones(_) => "voxel-cones",
            Self::SoftGi(_) => "soft-gi",
            Self::LayeredRsm(_) => "layered-rsm",
        }
    }

    /// Refuses knobs out of range, for pictures of this size.
    ///
    /// # Errors
    /// The first knob that is, with its range.
    pub fn check(&self, width: u32, height: u32) -> Result<(), SettingsError> {
        match self {
            Self::Direct | Self::AmbientOcclusion => Ok(()),
            Self::VisibilityFilter(s) => s.check(width, height),
            Self::VoxelCones(s) => s.check(width, height),
            Self::SoftGi(s) => s.check(width, height),
            Self::LayeredRsm(s) => s.check(width, height),
        }
    }

    fn is_occlusion(&self) -> bool {
        matches!(self, Self::AmbientOcclusion) || matches!(self, Self::VoxelCones(s) if s.occlusion)
    }

    /// Whether it can compute the effect at all.
    fn has(&self, effect: Effect) -> bool {
        use Effect::*;
        if self.is_occlusion() {
            return effect == Occlusion;
        }
        match effect {
            Lights | Emission | Gloss => true,
            SoftShadows => matches!(self, Self::LayeredRsm(_)),
            Environment => !matches!(self, Self::SoftGi(_)),
            Bounce | SpecularBounce => {
                matches!(self, Self::VisibilityFilter(_) | Self::VoxelCones(_) | Self::LayeredRsm(_))
            }
            FurtherBounces => matches!(self, Self::VoxelCones(_)),
            ProxyShadows | ProxyBounce => matches!(self, Self::SoftGi(_)),
            Occlusion => false,
        }
    }
}

/// What is asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Request {
    /// How light is computed.
    pub technique: Technique,
    /// From where, in how many pixels.
    pub view: View,
    /// What all techniques share. Its part of the light bounds the effects too.
    pub job: Job,
    /// Whether emissive surfaces may emit.
    pub emissive: bool,
    /// The effects to have where the scene has use for them; all if none are named.
    pub effects: Option<Vec<Effect>>,
    /// Effects are left out that can add no more than this, as a share of the light that they are bounded by.
    pub quality: f64,
}

impl Request {
    /// All that the scene calls for.
    pub fn new(technique: Technique, view: View, job: Job) -> Self {
        Self { technique, view, job, emissive: false, effects: None, quality: 0.0 }
    }
}

/// Whether an effect is called for, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct Decision {
    /// The effect.
    pub effect: Effect,
    /// Whether it is computed.
    pub called: bool,
    /// In a few words.
    pub why: String,
    /// What it can add at most, where it is left out although light would take that way, and materials bound it.
    pub bound: Option<Bound>,
}

/// What will run.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// The technique, its knobs as far as the effects need them.
    pub technique: Technique,
    /// From where, in how many pixels.
    pub view: View,
    /// What all techniques share.
    pub job: Job,
    /// A decision for each effect, in the order of [`Effect::ALL`].
    pub decisions: Vec<Decision>,
}

impl Plan {
    /// Decides what a request calls for in a scene.
    ///
    /// # Errors
    /// Knobs out of range.
    pub fn new(scene: &Scene, request: &Request) -> Result<Self, SettingsError> {
        Self::from_census(&scene.census(), request)
    }

    /// Decides what a request calls for in a scene of which this is known.
    ///
    /// # Errors
    /// Knobs out of range.
    pub fn from_census(census: &Census, request: &Request) -> Result<Self, SettingsError> {
        request.technique.check(request.view.width, request.view.height)?;
        if !(request.quality >= 0.0 && request.quality <= 1.0) {
            let reason = format!("{} is not from 0 to 1", request.quality);
            return Err(SettingsError { knob: "quality", reason });
        }
        let mut decisions: Vec<Decision> = Vec::new();
        for effect in Effect::ALL {
            let before = |e: Effect| decisions.iter().any(|d: &Decision| d.effect == e && d.called);
            decisions.push(choice::decide(effect, census, request, &before));
        }
        let mut plan = Self {
            technique: request.technique.clone(),
            view: request.view,
            job: request.job.clone(),
            decisions,
        };
        plan.settle();
        Ok(plan)
    }

    /// Whether an effect is computed.
    pub fn calls(&self, effect: Effect) -> bool {
        self.decisions.iter().any(|d| d.effect == effect && d.called)
    }

    /// Whether light is gathered that comes by way of other surfaces.
    pub fn gathers(&self) -> bool {
        [Effect::Bounce, Effect::SpecularBounce, Effect::ProxyBounce].iter().any(|&e| self.calls(e))
    }

    /// The same plan with light gathered at a share of the picture's pixels, if a number was named: for trials at other sizes.
    pub(crate) fn without_pixels(&self) -> Self {
        let mut plan = self.clone();
        match &mut plan.technique {
            Technique::VisibilityFilter(s) => s.illumination = None,
            Technique::VoxelCones(s) => s.illumination = None,
            Technique::LayeredRsm(s) => s.illumination = None,
            _ => {}
        }
        plan
    }

    /// Sets knobs and job to what the effects need.
    fn settle(&mut self) {
        let (soft, further) = (self.calls(Effect::SoftShadows), self.calls(Effect::FurtherBounces));
        if self.technique.is_occlusion() {
            return;
        }
        match &mut self.technique {
            Technique::VoxelCones(s) if !further => s.bounces = 1,
            Technique::LayeredRsm(s) => s.shadow_cones &= soft,
            _ => {}
        }
        if self.job.light == LightPart::All {
            use Effect::*;
            let straight = [Lights, Environment, Emission, ProxyShadows].iter().any(|&e| self.calls(e));
            if !self.gathers() {
                self.job.light = LightPart::Direct;
            } else if !straight {
                self.job.light = LightPart::Indirect;
            }
        }
    }
}
