//! Where do rays, discs, boxes, triangles and voxels meet?

pub mod bvh;
