//! Where do rays, discs, boxes, triangles and voxels meet?

pub mod box_;
pub mod bvh;
pub mod disc;
pub mod lattice;
pub mod overlap;
pub mod triangle;
pub mod voxel_walk;
