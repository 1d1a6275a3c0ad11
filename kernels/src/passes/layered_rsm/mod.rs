//! Layered reflective shadow maps with binary voxel cones. Sugihara, Rauwendaal, Salvi 2014 (LRSM).
//!
//! Voxels say only where something is: a bit for each, a byte above. What surfaces send is looked up in prefiltered maps of
//! what each light sees.

pub mod layers;
pub mod lookup;
pub mod reflect;
pub mod shadow;
pub mod texel;
pub mod trace;
pub mod voxels;
