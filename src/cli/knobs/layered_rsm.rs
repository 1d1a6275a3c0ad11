//! Which options set the knobs of layered reflective shadow maps?

use super::set;
use crate::technique::layered_rsm::{LayeredRsm, Moments, Opacity, Weights};
use clap::{Args, ValueEnum};

/// The knobs; what is left out keeps the default or the preset's value.
#[derive(Args, Clone, Default, PartialEq)]
#[command(next_help_heading = "Layered reflective shadow maps")]
pub(crate) struct LayeredRsmOptions {
    /// What filtered binary voxels hold
    #[arg(long)]
    opacity: Option<OpacityChoice>,
    /// Side of each light's reflective shadow map, texels: a power of two from 16 to 4096
    #[arg(long, value_name = "N")]
    rsm: Option<u32>,
    /// Layers by depth, 1 to 8
    #[arg(long, value_name = "N")]
    depth_layers: Option<u32>,
    /// Layers by the cosine to the light, 1 to 8
    #[arg(long, value_name = "N")]
    normal_layers: Option<u32>,
    /// How depths are stored
    #[arg(long)]
    moments: Option<MomentsChoice>,
    /// Smallest deviation of depths, as a share of half a layer [default: what the format can tell]
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    deviation: Option<f32>,
    /// Overlap of depth layers, as a share of a layer; 0 reads every layer that a sample reaches
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    layer_overlap: Option<f32>,
    /// By what surfaces count within a sample
    #[arg(long)]
    weights: Option<WeightsChoice>,
    /// Radius within which surfaces belong to a sample, in half widths of its voxels
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    window: Option<f32>,
    /// Diameter looked up on the map, as a share of the width of a sample's voxels
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    footprint: Option<f32>,
    /// Finest level of the layers that is looked up: higher flickers less, and is less sharp
    #[arg(long, value_name = "LEVEL", allow_hyphen_values = true)]
    least_level: Option<f32>,
    /// Coarsest level of the layers that is looked up: lower is sharper, and flickers [default: all]
    #[arg(long, value_name = "LEVEL")]
    most_level: Option<u32>,
    /// Shadows of lights by cones
    #[arg(long, value_name = "BOOL")]
    shadow_cones: Option<bool>,
    /// Radius of point and spot lights for shadows by cones, which it turns on; metres
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    light_radius: Option<f32>,
    /// Half of the angle that suns span for shadows by cones, which it turns on; degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    sun_angle: Option<f32>,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum OpacityChoice {
    /// What is covered along each axis
    Covered,
    /// The mean, as published: walls leak
    Mean,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum MomentsChoice {
    /// Mean and variance as floats
    Float,
    /// Means of depth and squared depth in 16 bits, as published
    Unorm16,
    /// Mean and deviation in 16 bits
    Deviation16,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum WeightsChoice {
    /// Area, lit and shadowed
    Area,
    /// Share of the light's rays, as published
    Opacity,
}

impl LayeredRsmOptions {
    /// Sets the knobs that the options name.
    pub(super) fn apply(&self, s: &mut LayeredRsm) {
        set(&mut s.map, self.rsm);
        set(&mut s.depth_layers, self.depth_layers);
        set(&mut s.normal_layers, self.normal_layers);
        s.deviation = self.deviation.or(s.deviation);
        set(&mut s.overlap, self.layer_overlap);
        set(&mut s.window, self.window);
        set(&mut s.footprint, self.footprint);
        set(&mut s.least_level, self.least_level);
        s.most_level = self.most_level.or(s.most_level);
        s.shadow_cones |= self.light_radius.is_some() || self.sun_angle.is_some();
        set(&mut s.shadow_cones, self.shadow_cones);
        set(&mut s.light_radius, self.light_radius);
        set(&mut s.sun_angle, self.sun_angle);
        match self.opacity {
            Some(OpacityChoice::Covered) => s.opacity = Opacity::Covered,
            Some(OpacityChoice::Mean) => s.opacity = Opacity::Mean,
            None => {}
        }
        match self.moments {
            Some(MomentsChoice::Float) => s.moments = Moments::Float,
            Some(MomentsChoice::Unorm16) => s.moments = Moments::Unorm16,
            Some(MomentsChoice::Deviation16) => s.moments = Moments::Deviation16,
            None => {}
        }
        match self.weights {
            Some(WeightsChoice::Area) => s.weights = Weights::Area,
            Some(WeightsChoice::Opacity) => s.weights = Weights::Opacity,
            None => {}
        }
    }
}
