//! Voxel cone tracing over a sparse pyramid. Crassin et al. 2011 (VCT).
//!
//! A voxel stores an optical depth for each axis and a radiance for each of the six directions that its surfaces may
//! face. Both are interpolated, the radiance weighted by the optical depth: a wall then has the same transmittance
//! wherever a cone samples it, with any step, at any level.

pub mod build;
pub mod clip;
pub mod filter;
pub mod inject;
pub mod lobes;
pub mod march;
pub mod moving;
pub mod storage;
pub mod trace;
pub mod view;
pub mod voxelise;
