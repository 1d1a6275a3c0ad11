//! What does a cone gather while it steps through prefiltered voxels?
//!
//! [`mip_level`] and [`step_length`] say where and at which level to sample, [`corrected_sample`] what the sample
//! counts for, [`composite`] how samples add up front to back, and [`ConeSum`] how cones add up.

mod composite;
mod occlusion;
mod step;

pub use composite::{accumulate, composite};
pub use occlusion::{ConeSum, distance_falloff, faded_opacity};
pub use step::{
    MAX_HALF_ANGLE, MAX_STEP_RATIO, aperture_tangent, corrected_opacity, corrected_sample, diameter,
    mip_level, premultiplied_scale, step_count_bound, step_length,
};
