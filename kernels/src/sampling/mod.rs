//! Where are samples taken, and which share of the whole does each stand for?

pub mod attenuation;
pub mod halton;
pub mod hash;
pub mod hemisphere;
pub mod interleaved;
pub mod roulette;
pub mod voxel_hash;
