//! How is a scene rendered? Each technique is a sequence of passes, written once for every backend.

pub mod ambient_occlusion;
pub mod direct;
mod gathered;
pub mod gbuffer;
mod job;
pub mod light_map;
pub mod reference;
pub mod soft_gi;
pub mod visibility_filter;
pub mod voxel_cones;
mod world;

pub use job::{Inspection, Job, LightPart, NonFinite, Rendered};
pub use world::{View, World, environment_params};
