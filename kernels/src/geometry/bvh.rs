//! Which triangle does a ray meet first, and does it meet any?
//!
//! A tree of four-wide nodes over blocks of four triangles, walked with an explicit stack. The four lanes are
//! `Vec4` component-wise operations: SSE on a CPU, vectors in SPIR-V.

use super::box_::{BoxRay, four_boxes};
use super::triangle::{TriangleRay, four_triangles};
use glam::{UVec4, Vec3, Vec4};

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
/// Mask of an index into the stack, so that no bounds are left to check; within them it changes nothing.
const LAST_ENTRY: u32 = STACK_SIZE - 1;

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

gpu_struct! {
    /// What a ray meets first.
    pub struct Hit {
        /// Distance in lengths of the ray's direction; the ray's own end for a miss.
        pub t: f32,
        /// Weight of the triangle's second corner.
        pub u: f32,
        /// Weight of the triangle's third corner.
        pub v: f32,
        /// Triangle index, or [`NO_TRIANGLE`].
        pub triangle: u32,
    }
}

/// A ray and the part of it that counts.
#[derive(Clone, Copy)]
pub struct Ray {
    /// Where it starts, metres.
    pub origin: Vec3,
    /// Where it goes; any length but 0.
    pub direction: Vec3,
    /// Start of the part that counts, in lengths of the direction, at least 0.
    pub t_min: f32,
    /// End of the part that counts.
    pub t_max: f32,
}

/// Decides whether a meeting with a [`MASKED`] triangle counts.
pub trait HitFilter {
    /// Returns false where the triangle has a hole at (u, v).
    fn accepts(&self, triangle: u32, u: f32, v: f32) -> bool;
}

/// Counts every meeting: for scenes without masked materials.
#[derive(Clone, Copy)]
pub struct AcceptAll;

impl HitFilter for AcceptAll {
    #[inline]
    fn accepts(&self, _triangle: u32, _u: f32, _v: f32) -> bool {
        true
    }
}

/// Returns the nearest triangle that the ray meets, either side; `triangle` is [`NO_TRIANGLE`] for a miss.
///
/// The tree must satisfy [`STACK_SIZE`]; its root is node 0. Rays with NaN, or of length 0, meet nothing.
#[inline]
pub fn nearest_hit(nodes: &[BvhNode], blocks: &[TriangleBlock], ray: &Ray, filter: &impl HitFilter) -> Hit {
    walk::<false>(nodes, blocks, ray, filter)
}

/// Returns whether the ray meets any triangle.
#[inline]
pub fn any_hit(nodes: &[BvhNode], blocks: &[TriangleBlock], ray: &Ray, filter: &impl HitFilter) -> bool {
    walk::<true>(nodes, blocks, ray, filter).triangle != NO_TRIANGLE
}

/// Walks the tree, front to back for the nearest meeting; with `ANY` the first meeting in any order ends it.
#[inline]
fn walk<const ANY: bool>(
    nodes: &[BvhNode],
    blocks: &[TriangleBlock],
    ray: &Ray,
    filter: &impl HitFilter,
) -> Hit {
    let box_ray = BoxRay::new(ray.origin, ray.direction);
    let triangle_ray = TriangleRay::new(ray.origin, ray.direction);
    let mut hit = Hit { t: ray.t_max, u: 0.0, v: 0.0, triangle: NO_TRIANGLE };
    if triangle_ray.lanes == 0 || !(ray.t_min <= ray.t_max) {
        return hit;
    }
    let mut stack = [0u32; STACK_SIZE as usize];
    let mut entry = [0.0f32; STACK_SIZE as usize];
    let mut top = 0u32;
    let mut current = 0u32;
    loop {
        if current & LEAF != 0 {
            hit = intersect_leaf(blocks, current, &triangle_ray, ray.t_min, hit, filter);
            if ANY && hit.triangle != NO_TRIANGLE {
                return hit;
            }
        } else {
            let node = &nodes[current as usize];
            let (near, mask) = four_boxes(
                node.min_x, node.max_x, node.min_y, node.max_y, node.min_z, node.max_z, &box_ray, ray.t_min,
                hit.t,
            );
            if mask != 0 {
                let near = near.to_array();
                let children = node.children.to_array();
                let mut next = NO_CHILD;
                let mut next_near = 0.0;
                // One child goes next, the others wait on the stack. The nearest, unless any meeting will do: then
                // the order decides nothing, and comparing costs more time than it saves.
                for lane in 0..4 {
                    if mask & (1 << lane) != 0 {
                        let child = children[lane];
                        let child_near = near[lane];
                        let nearer = next == NO_CHILD || (!ANY && child_near < next_near);
                        let (waiting, waiting_near) =
                            if nearer { (next, next_near) } else { (child, child_near) };
                        if nearer {
                            next = child;
                            next_near = child_near;
                        }
                        if waiting != NO_CHILD {
                            stack[(top & LAST_ENTRY) as usize] = waiting;
                            entry[(top & LAST_ENTRY) as usize] = waiting_near;
                            top += 1;
                        }
                    }
                }
                current = next;
                continue;
            }
        }
        loop {
            if top == 0 {
                return hit;
            }
            top -= 1;
            if ANY || entry[(top & LAST_ENTRY) as usize] <= hit.t {
                break;
            }
        }
        current = stack[(top & LAST_ENTRY) as usize];
    }
}

/// Returns the nearer of `hit` and what the ray meets in the blocks of a leaf.
// Called once per leaf with a dozen values: the call alone was a twentieth of the walk's instructions.
#[inline(always)]
fn intersect_leaf(
    blocks: &[TriangleBlock],
    leaf: u32,
    ray: &TriangleRay,
    t_min: f32,
    hit: Hit,
    filter: &impl HitFilter,
) -> Hit {
    let mut hit = hit;
    let first = leaf & 0x0FFF_FFFF;
    let count = ((leaf >> 28) & 7) + 1;
    for index in first..first + count {
        let b = &blocks[index as usize];
        let four = four_triangles(b.x0, b.y0, b.z0, b.x1, b.y1, b.z1, b.x2, b.y2, b.z2, ray, t_min, hit.t);
        if four.mask != 0 {
            let t = four.t.to_array();
            let u = four.u.to_array();
            let v = four.v.to_array();
            let triangles = b.triangles.to_array();
            for lane in 0..4 {
                let id = triangles[lane];
                let met = four.mask & (1 << lane) != 0 && id != NO_TRIANGLE && t[lane] <= hit.t;
                if met && (id & MASKED == 0 || filter.accepts(id & !MASKED, u[lane], v[lane])) {
                    hit = Hit { t: t[lane], u: u[lane], v: v[lane], triangle: id & !MASKED };
                }
            }
        }
    }
    hit
}
