//! How is a scene rendered? Each technique is a sequence of passes, written once for every backend.

pub mod ambient_occlusion;
mod cones;
pub mod direct;
mod gathered;
pub mod gbuffer;
mod job;
pub mod layered_rsm;
pub mod light_map;
pub mod reference;
pub mod soft_gi;
pub mod visibility_filter;
pub mod voxel_cones;
mod voxelised;
mod world;

pub use cones::Cones;
pub use gathered::MAX_PIXELS;
pub use job::{Inspection, Job, LightPart, NonFinite, Rendered, Upsampling};
pub use world::{View, World, environment_params};
