//! Which tree do rays walk to find triangles?
//!
//! A binary tree over the triangles' boxes, built with obvhs, is collapsed into the four-wide nodes of
//! [`twinlight_kernels::geometry::bvh`], opening the child with the largest surface first. Where a binary subtree is
//! so unbalanced that the traversal stack could overflow, its triangles are halved by count instead, so the depth
//! is guaranteed. The same triangles give the same bits whatever the number of threads.

mod binary;
mod split;
#[cfg(test)]
mod tests;

use super::Bounds;
use crate::error::SceneError;
use binary::{Binary, Subtree};
use glam::{UVec4, Vec4};
use twinlight_kernels::geometry::box_::pad_bounds;
use twinlight_kernels::geometry::bvh::{
    BvhNode, LEAF, MASKED, MAX_LEAF_BLOCKS, NO_CHILD, NO_TRIANGLE, STACK_SIZE, TriangleBlock,
};
use twinlight_kernels::passes::scene::{MATERIAL_MASKED, Material, Triangle};

/// The largest number of triangles in a tree, and in a scene: 2²⁷.
pub const MAX_TRIANGLES: usize = 1 << 27;
/// The largest depth that the traversal stack allows.
pub const MAX_DEPTH: u32 = (STACK_SIZE - 1) / 3;
/// The largest magnitude of a coordinate, metres.
pub const MAX_COORDINATE: f32 = super::MAX_VALUE;

/// Bounds of a lane without a child: no ray meets them.
const EMPTY_MIN: f32 = 3.0e38;
const EMPTY_MAX: f32 = -3.0e38;

/// A four-wide tree over blocks of four triangles.
#[derive(Clone, Debug, PartialEq)]
pub struct Bvh {
    /// The nodes; the first is the root, children follow their parents. Never empty.
    pub nodes: Vec<BvhNode>,
    /// The triangles in the order of the leaves. May be empty.
    pub blocks: Vec<TriangleBlock>,
    /// Levels of nodes: 1 when the root has leaves only. 3 × depth + 1 ≤ [`STACK_SIZE`].
    pub depth: u32,
}

impl Bvh {
    /// Builds the tree over all triangles; lanes whose material is masked carry [`MASKED`].
    ///
    /// No triangles give one node without children; a triangle whose material index is out of range counts as
    /// opaque. Equal input gives equal bits.
    ///
    /// # Errors
    /// More than [`MAX_TRIANGLES`], or a coordinate that is not finite or larger than [`MAX_COORDINATE`].
    pub fn build(triangles: &[Triangle], materials: &[Material]) -> Result<Self, SceneError> {
        if triangles.len() > MAX_TRIANGLES {
            return Err(SceneError::TooLarge {
                what: "triangles".into(),
                count: triangles.len() as u64,
                limit: MAX_TRIANGLES as u64,
            });
        }
        let bounds: Vec<Bounds> = triangles.iter().map(Bounds::of_triangle).collect();
        if let Some(bad) = triangles.iter().position(|t| !all_usable(t)) {
            return Err(SceneError::Value {
                what: format!("triangle {bad}"),
                reason: format!("a coordinate is not finite or beyond {MAX_COORDINATE:e} m"),
            });
        }
        let mut binary = Binary::build(&bounds);
        let mut builder =
            Collapse { bvh: Self { nodes: vec![], blocks: vec![], depth: 0 }, triangles, materials };
        let root = binary.root();
        builder.node(&mut binary, &bounds, root, MAX_DEPTH);
        Ok(builder.bvh)
    }

    /// Returns the bytes of both buffers.
    pub fn bytes(&self) -> usize {
        size_of_val(self.nodes.as_slice()) + size_of_val(self.blocks.as_slice())
    }
}

/// Whether min and max can't have hidden a NaN and every coordinate is in range.
fn all_usable(triangle: &Triangle) -> bool {
    [triangle.p0, triangle.p1, triangle.p2]
        .iter()
        .all(|p| p.truncate().to_array().iter().all(|c| c.abs() <= MAX_COORDINATE))
}

/// The four-wide tree while it grows.
struct Collapse<'a> {
    bvh: Bvh,
    triangles: &'a [Triangle],
    materials: &'a [Material],
}

impl Collapse<'_> {
    /// Appends the node over `subtree` and all below it, in at most `levels` levels; returns its index.
    ///
    /// Recursion is at most [`MAX_DEPTH`] deep.
    fn node(&mut self, binary: &mut Binary, bounds: &[Bounds], subtree: Subtree, levels: u32) -> u32 {
        self.bvh.depth = self.bvh.depth.max(MAX_DEPTH + 1 - levels);
        let index = self.bvh.nodes.len();
        self.bvh.nodes.push(empty_node());
        let children = open_four(binary, bounds, subtree, levels);
        for (lane, &child) in children.iter().enumerate() {
            let around = binary.bounds(bounds, child);
            let link = if binary.is_leaf(child) {
                self.leaf(binary.triangles(child))
            } else {
                self.node(binary, bounds, child, levels - 1)
            };
            // Moved out so that no ray that the triangle test would let hit is lost at the box.
            let (min, max) = pad_bounds(around.min, around.max);
            let node = &mut self.bvh.nodes[index];
            (node.min_x[lane], node.max_x[lane]) = (min.x, max.x);
            (node.min_y[lane], node.max_y[lane]) = (min.y, max.y);
            (node.min_z[lane], node.max_z[lane]) = (min.z, max.z);
            node.children[lane] = link;
        }
        index as u32
    }

    /// Appends blocks with these triangles; returns the child that stands for them.
    fn leaf(&mut self, indices: &[u32]) -> u32 {
        let first = self.bvh.blocks.len() as u32;
        for four in indices.chunks(4) {
            let mut block = TriangleBlock { triangles: UVec4::splat(NO_TRIANGLE), ..Default::default() };
            for (lane, &index) in four.iter().enumerate() {
                let triangle = &self.triangles[index as usize];
                let (a, b, c) = (triangle.p0, triangle.p1, triangle.p2);
                (block.x0[lane], block.y0[lane], block.z0[lane]) = (a.x, a.y, a.z);
                (block.x1[lane], block.y1[lane], block.z1[lane]) = (b.x, b.y, b.z);
                (block.x2[lane], block.y2[lane], block.z2[lane]) = (c.x, c.y, c.z);
                let material = self.materials.get(triangle.material as usize);
                let masked = material.is_some_and(|m| m.flags & MATERIAL_MASKED != 0);
                block.triangles[lane] = index | if masked { MASKED } else { 0 };
            }
            self.bvh.blocks.push(block);
        }
        let count = self.bvh.blocks.len() as u32 - first;
        debug_assert!((1..=MAX_LEAF_BLOCKS).contains(&count));
        LEAF | (count - 1) << 28 | first
    }
}

/// Returns up to four subtrees that together are `subtree`, by opening the one with the largest surface.
fn open_four(binary: &mut Binary, bounds: &[Bounds], subtree: Subtree, levels: u32) -> Vec<Subtree> {
    if subtree.is_empty() {
        return vec![];
    }
    // Too little slack for an unbalanced tree: from here on halve by count, which always fits.
    let subtree = if levels_needed(subtree.len()) >= levels { subtree.by_count() } else { subtree };
    let mut children = vec![subtree];
    while children.len() < 4 {
        let openable = |child: &Subtree| !binary.is_leaf(*child);
        let area = |child: &Subtree| binary.bounds(bounds, *child).half_area();
        let largest = (0..children.len())
            .filter(|&i| openable(&children[i]))
            // By count where halved, so that the four parts are equal; the earlier one of equals.
            .max_by(|&i, &j| {
                let (a, b) = (&children[i], &children[j]);
                let order = if a.is_by_count() { a.len().cmp(&b.len()) } else { area(a).total_cmp(&area(b)) };
                order.then(j.cmp(&i))
            });
        let Some(largest) = largest else { break };
        let (left, right) = binary.open(bounds, children[largest]);
        children[largest] = left;
        children.insert(largest + 1, right);
    }
    children
}

/// Returns how many levels of four-wide nodes a balanced tree over `count` triangles has.
fn levels_needed(count: usize) -> u32 {
    let mut levels = 1;
    let mut holds = 16;
    while holds < count {
        holds *= 4;
        levels += 1;
    }
    levels
}

fn empty_node() -> BvhNode {
    let (min, max) = (Vec4::splat(EMPTY_MIN), Vec4::splat(EMPTY_MAX));
    BvhNode {
        min_x: min,
        max_x: max,
        min_y: min,
        max_y: max,
        min_z: min,
        max_z: max,
        children: UVec4::splat(NO_CHILD),
    }
}
