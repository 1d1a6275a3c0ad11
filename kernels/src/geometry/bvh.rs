//! Which triangle does a ray meet first, and does it meet any?
//!
//! A tree of four-wide nodes over blocks of four triangles, walked with an explicit stack. The four lanes are
//! `Vec4` component-wise operations: SSE on a CPU, vectors in SPIR-V.

use glam::{UVec4, Vec4};

/// A lane of [`BvhNode::children`] without a child.
pub const NO_CHILD: u32 = 0xFFFF_FFFF;
/// Bit of a child that is a leaf: bits 0–27 are its first block, bits 28–30 the number of blocks less one.
pub const LEAF: u32 = 0x8000_0000;
/// The largest number of blocks in a leaf.
pub const MAX_LEAF_BLOCKS: u32 = 7;
/// A lane of [`TriangleBlock::triangles`] without a triangle; also what a miss reports.
pub const NO_TRIANGLE: u32 = 0xFFFF_FFFF;
/// Bit of a lane of [`TriangleBlock::triangles`] whose material may be a hole: the alpha has to be looked up.
pub const MASKED: u32 = 0x8000_0000;
/// Entries of the traversal stack; a builder must keep 3 × depth + 1 within it.
pub const STACK_SIZE: u32 = 64;

gpu_struct! {
    /// Four children with their bounds; empty lanes have min > max.
    pub struct BvhNode {
        /// Lower x of the four children.
        pub min_x: Vec4,
        /// Upper x of the four children.
        pub max_x: Vec4,
        /// Lower y of the four children.
        pub min_y: Vec4,
        /// Upper y of the four children.
        pub max_y: Vec4,
        /// Lower z of the four children.
        pub min_z: Vec4,
        /// Upper z of the four children.
        pub max_z: Vec4,
        /// Node index, [`LEAF`] encoding, or [`NO_CHILD`].
        pub children: UVec4,
    }

    /// Four triangles, one per lane.
    pub struct TriangleBlock {
        /// x of the first corners.
        pub x0: Vec4,
        /// y of the first corners.
        pub y0: Vec4,
        /// z of the first corners.
        pub z0: Vec4,
        /// x of the second corners.
        pub x1: Vec4,
        /// y of the second corners.
        pub y1: Vec4,
        /// z of the second corners.
        pub z1: Vec4,
        /// x of the third corners.
        pub x2: Vec4,
        /// y of the third corners.
        pub y2: Vec4,
        /// z of the third corners.
        pub z2: Vec4,
        /// Triangle index with the [`MASKED`] bit, or [`NO_TRIANGLE`].
        pub triangles: UVec4,
    }
}
