//! Which voxels does the pyramid have, and how dense is each? VCT §4.1–4.3.

use super::clip::{Part, part_in_cube};
use super::storage::{MAX_OPTICAL_DEPTH, pack_depths, unpack_depths};
use super::voxelise::in_cells;
use crate::geometry::lattice::{
    BLOCK_WORDS, NO_VOXEL, bit_count, block_of, blocks_along, level_offset, pack_point, point_bit, point_of,
    unpack_point, voxel_at,
};
use crate::math::{abs, div, dot, exp, floor, ln_one_plus, max, min, to_u32};
use crate::passes::Accumulate;
use crate::passes::material::{base_color, reflectance, texture_coordinates};
use crate::passes::scene::{MATERIAL_MASKED, Material, Triangle};
use crate::passes::surface::geometric_normal;
use glam::{UVec3, Vec3, Vec4};

/// Words of a leaf's sums: covered area across x, y, z; area times albedo in red, green, blue; area; unused.
pub const LEAF_WORDS: u32 = 8;
/// Sums of areas are in units of 2⁻²⁰ of a voxel's face: a leaf takes 4095 faces before it overflows.
pub const AREA_SCALE: f32 = 1_048_576.0;
/// The optical depth of a surface that spans a leaf: 0.25 % of the light gets through.
pub const FULL_DEPTH: f32 = 6.0;

/// [`PyramidParams::flags`]: one optical depth and one radiance for all directions.
pub const ISOTROPIC: u32 = 1;

gpu_struct! {
    /// Parameters of the passes over a pyramid's voxels.
    pub struct PyramidParams {
        /// Lattice point (0, 0, 0) in metres; w is the voxel edge of level 0, metres.
        pub lower: Vec4,
        /// 1/(voxel edge of level 0), 1/m.
        pub inverse_edge: f32,
        /// Depth of the pyramid.
        pub depth: u32,
        /// Level of the voxels that the pass makes.
        pub level: u32,
        /// Number of that level's first voxel.
        pub first: u32,
        /// Number of the first voxel of the level below.
        pub child_first: u32,
        /// [`ISOTROPIC`]; from bit 8 on the radiance's [storage](super::storage::storage_of).
        pub flags: u32,
        /// Number of leaves.
        pub leaves: u32,
        /// 1 where a triangle counts as if it spanned each of its voxels.
        pub thin: u32,
        /// Units of power per watt.
        pub power_scale: f32,
        /// Units of stored radiance per W/(m² sr).
        pub radiance_scale: f32,
        /// Number of lit voxels before those of this level.
        pub first_lit: u32,
        /// Number of lit voxels before those of the level below.
        pub child_first_lit: u32,
        /// Words before the lobes in a radiance; 0 where there are none.
        pub lobes: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

/// Returns word `index` of the marked points of level `params.level`, two words for each of its blocks: those with a marked
/// child among the 27 around them.
#[inline]
pub fn parent_masks(index: u32, params: &PyramidParams, children: &[u32]) -> u32 {
    let (depth, level) = (params.depth, params.level);
    let side = blocks_along(depth, level);
    let block = index / 2;
    let row = block / side;
    let layer = row / side;
    let corner = UVec3::new(4 * (block - row * side), 4 * (row - layer * side), 4 * layer + 2 * (index & 1));
    if nothing_near(params, corner, children) {
        return 0;
    }
    let last = 1u32 << (depth - level);
    let mut word = 0u32;
    for bit in 0..32 {
        let point = corner + UVec3::new(bit & 3, (bit >> 2) & 3, bit >> 4);
        let on = point.x <= last && point.y <= last && point.z <= last;
        if on && has_child(params, point, children) {
            word |= 1 << bit;
        }
    }
    word
}

/// Whether no child of the 4 × 4 × 2 points from `corner` on can be marked, by the blocks that they lie in.
#[inline]
fn nothing_near(params: &PyramidParams, corner: UVec3, children: &[u32]) -> bool {
    let below = params.level - 1;
    let side = blocks_along(params.depth, below);
    let begin = |c: u32| if c == 0 { 0 } else { (2 * c - 1) / 4 };
    let end = |c: u32, span: u32| {
        let last = (2 * (c + span) - 1) / 4;
        if last < side { last } else { side - 1 }
    };
    let mut marked = 0u32;
    for z in begin(corner.z)..end(corner.z, 2) + 1 {
        for y in begin(corner.y)..end(corner.y, 4) + 1 {
            for x in begin(corner.x)..end(corner.x, 4) + 1 {
                let at = 2 * ((z * side + y) * side + x);
                marked |= children[at as usize] | children[(at + 1) as usize];
            }
        }
    }
    marked == 0
}

/// Whether one of the 27 children around a point is marked.
#[inline]
fn has_child(params: &PyramidParams, point: UVec3, children: &[u32]) -> bool {
    let below = params.level - 1;
    let last = 1u32 << (params.depth - below);
    let first = level_offset(params.depth, below);
    let mut found = 0u32;
    for number in 0..27 {
        let child = child_of(point, number);
        if child.x <= last && child.y <= last && child.z <= last {
            let bit = point_bit(child);
            let at = 2 * (block_of(params.depth, below, child) - first) + bit / 32;
            found |= (children[at as usize] >> (bit & 31)) & 1;
        }
    }
    found != 0
}

/// Child `number` of 27, x fastest; coordinates below 0 wrap.
#[inline]
pub(super) fn child_of(point: UVec3, number: u32) -> UVec3 {
    let (x, y, z) = (number % 3, number / 3 % 3, number / 9);
    UVec3::new(
        (2 * point.x + x).wrapping_sub(1),
        (2 * point.y + y).wrapping_sub(1),
        (2 * point.z + z).wrapping_sub(1),
    )
}

/// Returns the number of marked points of block `index`.
#[inline]
pub fn block_counts(index: u32, params: &PyramidParams, masks: &[u32]) -> u32 {
    let _ = params;
    bit_count(masks[(2 * index) as usize]) + bit_count(masks[(2 * index + 1) as usize])
}

/// Returns word `index` of the blocks: two words of marks, then the number of the first voxel, from the scan of the counts.
#[inline]
pub fn pack_blocks(index: u32, params: &PyramidParams, masks: &[u32], starts: &[u32]) -> u32 {
    let _ = params;
    let block = index / BLOCK_WORDS;
    let word = index - BLOCK_WORDS * block;
    if word < 2 { masks[(2 * block + word) as usize] } else { starts[block as usize] }
}

/// Returns the lattice point of voxel `index` of the level, packed.
#[inline]
pub fn voxel_points(index: u32, params: &PyramidParams, blocks: &[u32]) -> u32 {
    pack_point(point_of(blocks, params.depth, params.level, params.first + index))
}

/// Whether a masked material has a hole there.
#[inline]
fn is_hole(m: &Material, texels: &[u32], uv: glam::Vec2) -> bool {
    m.flags & MATERIAL_MASKED != 0 && base_color(m, texels, uv).w < m.cutoff
}

/// Texture coordinates u, v of a point on a triangle: weights of its second and third corner.
#[inline]
fn weights_at(a: Vec3, b: Vec3, c: Vec3, point: Vec3) -> (f32, f32) {
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (bb, bc, cc) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));
    let (pb, pc) = (dot(ap, ab), dot(ap, ac));
    let determinant = bb * cc - bc * bc;
    if !(determinant > 1.0e-30) {
        return (0.0, 0.0);
    }
    (div(cc * pb - bc * pc, determinant), div(bb * pc - bc * pb, determinant))
}

/// A triangle's part in a voxel, as its sums need it.
pub(super) struct Covered {
    pub(super) leaf: u32,
    /// Area, in faces of a voxel; 0 in a hole.
    pub(super) area: f32,
    /// The area that it really has there.
    pub(super) clipped: f32,
    pub(super) normal: Vec3,
    /// Weights of the second and third corner at the part's centroid.
    pub(super) u: f32,
    pub(super) v: f32,
}

/// What pair `index` covers of its voxel.
#[inline]
pub(super) fn covered(
    index: u32,
    params: &PyramidParams,
    pairs: &[u32],
    blocks: &[u32],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> Covered {
    let point = unpack_point(pairs[(2 * index) as usize]);
    let t = &triangles[pairs[(2 * index + 1) as usize] as usize];
    let voxel = voxel_at(blocks, params.depth, 0, point);
    let (part, u, v) = part_of(params, point, t);
    let hole = is_hole(&materials[t.material as usize], texels, texture_coordinates(t, u, v));
    let area = if params.thin != 0 { 1.0 } else { part.area };
    Covered {
        leaf: voxel.wrapping_sub(params.first),
        area: if hole || voxel == NO_VOXEL { 0.0 } else { area },
        clipped: part.area,
        normal: geometric_normal(t),
        u,
        v,
    }
}

/// A triangle's part in a voxel, with the weights of its second and third corner at the part's centroid.
#[inline]
fn part_of(params: &PyramidParams, point: UVec3, t: &Triangle) -> (Part, f32, f32) {
    let lattice = Vec3::new(point.x as f32, point.y as f32, point.z as f32);
    let (a, b, c) = in_cells(params.lower.truncate().extend(params.inverse_edge), t);
    let (a, b, c) = (a - lattice, b - lattice, c - lattice);
    let part = part_in_cube(a, b, c);
    let (u, v) = weights_at(a, b, c, part.centroid);
    (part, u, v)
}

/// Whether there is a hole in the middle of a triangle's part in a voxel.
#[inline]
pub(crate) fn hole_in(
    params: &PyramidParams,
    point: UVec3,
    t: &Triangle,
    materials: &[Material],
    texels: &[u32],
) -> bool {
    let m = &materials[t.material as usize];
    if m.flags & MATERIAL_MASKED == 0 {
        return false;
    }
    let (_, u, v) = part_of(params, point, t);
    is_hole(m, texels, texture_coordinates(t, u, v))
}

/// A value in [0, 4095] in units of 2⁻²⁰.
#[inline]
fn fixed(value: f32) -> u32 {
    to_u32(floor(min(value, 4095.0) * AREA_SCALE + 0.5))
}

/// Adds what pair `index`'s triangle covers of its voxel to the leaf's sums, [`LEAF_WORDS`] each, in fixed point.
#[inline]
pub fn accumulate_leaves(
    index: u32,
    params: &PyramidParams,
    pairs: &[u32],
    blocks: &[u32],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
    output: &mut impl Accumulate,
) {
    let part = covered(index, params, pairs, blocks, triangles, materials, texels);
    if part.area > 0.0 {
        let t = &triangles[pairs[(2 * index + 1) as usize] as usize];
        let r = reflectance(&materials[t.material as usize], texels, texture_coordinates(t, part.u, part.v));
        let at = LEAF_WORDS * part.leaf;
        let n = part.normal;
        output.add(at, fixed(part.area * abs(n.x)));
        output.add(at + 1, fixed(part.area * abs(n.y)));
        output.add(at + 2, fixed(part.area * abs(n.z)));
        output.add(at + 3, fixed(part.area * r.diffuse.x));
        output.add(at + 4, fixed(part.area * r.diffuse.y));
        output.add(at + 5, fixed(part.area * r.diffuse.z));
        output.add(at + 6, fixed(part.area));
    }
}

/// The area that a leaf's surfaces cover across each axis, in faces of a voxel.
#[inline]
pub(super) fn leaf_areas(sums: &[u32], leaf: u32) -> Vec3 {
    let at = LEAF_WORDS * leaf;
    let (x, y, z) = (sums[at as usize], sums[(at + 1) as usize], sums[(at + 2) as usize]);
    // 2⁻²⁰
    Vec3::new(x as f32, y as f32, z as f32) * 9.536_743e-7
}

/// The mean albedo of a leaf's surfaces by their area; 0 without any.
#[inline]
pub(super) fn leaf_albedo(sums: &[u32], leaf: u32) -> Vec3 {
    let at = LEAF_WORDS * leaf;
    let (r, g, b) = (sums[(at + 3) as usize], sums[(at + 4) as usize], sums[(at + 5) as usize]);
    let whole = max(sums[(at + 6) as usize] as f32, 1.0);
    Vec3::new(div(r as f32, whole), div(g as f32, whole), div(b as f32, whole))
}

/// Returns the optical depths of leaf `index`, packed: [`FULL_DEPTH`] for each face's worth of covered area.
///
/// In proportion to the area, so that a surface through several voxels has the same depth wherever a ray crosses it.
#[inline]
pub fn leaf_depths(index: u32, params: &PyramidParams, sums: &[u32]) -> u32 {
    let depths = leaf_areas(sums, index) * FULL_DEPTH;
    pack_depths(if params.flags & ISOTROPIC != 0 { Vec3::splat(mean_of(depths)) } else { depths })
}

#[inline]
fn mean_of(v: Vec3) -> f32 {
    ((v.x + v.y) + v.z) * 0.333_333_34
}

/// What share of the light a depth takes.
#[inline]
pub(super) fn opacity_of(depth: f32) -> f32 {
    if depth > 0.0 { 1.0 - exp(-depth) } else { 0.0 }
}

/// The depth that takes this share of the light, at most [`MAX_OPTICAL_DEPTH`].
#[inline]
pub(super) fn depth_of(opacity: f32) -> f32 {
    min(max(-ln_one_plus(-min(opacity, 0.999_9)), 0.0), MAX_OPTICAL_DEPTH)
}

/// Weight of a child beside (0 or 2) or on (1) the axis in the filter across it: ¼, ½, ¼.
#[inline]
pub(super) fn side_weight(place: u32) -> f32 {
    if place == 1 { 0.5 } else { 0.25 }
}

/// How much of a child's depth counts along an axis: all of the middle one, half of its neighbours, two edges together.
#[inline]
pub(super) fn share_along(place: u32) -> f32 {
    if place == 1 { 1.0 } else { 0.5 }
}

/// Child `(along, left, up)` of the 27 as its number, for an axis: along it, and across it.
#[inline]
pub(super) fn numbered(axis: u32, along: u32, left: u32, up: u32) -> u32 {
    if axis == 0 {
        along + 3 * left + 9 * up
    } else if axis == 1 {
        left + 3 * along + 9 * up
    } else {
        left + 3 * up + 9 * along
    }
}

#[inline]
pub(super) fn component(v: Vec3, axis: u32) -> f32 {
    if axis == 0 {
        v.x
    } else if axis == 1 {
        v.y
    } else {
        v.z
    }
}

/// Returns the optical depths of voxel `index` of a level above the leaves, packed, from its 27 children.
///
/// Along an axis depths add up; across it the *opacities* of the nine columns are averaged: the share of rays that are
/// blocked, VCT §4.3. Weights ¼, ½, ¼ on each axis are VCT's 3³ kernel (§8.2), which shares each child among the parents
/// around it and loses nothing.
#[inline]
pub fn filter_depths(
    index: u32,
    params: &PyramidParams,
    points: &[u32],
    blocks: &[u32],
    children: &[u32],
) -> u32 {
    filtered_depths(params, unpack_point(points[index as usize]), blocks, children)
}

#[inline]
pub(super) fn filtered_depths(params: &PyramidParams, point: UVec3, blocks: &[u32], children: &[u32]) -> u32 {
    let mut words = [0u32; 27];
    for number in 0..27 {
        let child = voxel_at(blocks, params.depth, params.level - 1, child_of(point, number));
        if child != NO_VOXEL {
            words[number as usize] = children[(child - params.child_first) as usize];
        }
    }
    let mut opacity = Vec3::ZERO;
    for axis in 0..3 {
        let mut blocked = 0.0;
        for column in 0..9 {
            let (left, up) = (column % 3, column / 3);
            let mut depth = 0.0;
            for along in 0..3 {
                let word = words[numbered(axis, along, left, up) as usize];
                depth += component(unpack_depths(word), axis) * share_along(along);
            }
            blocked += opacity_of(depth) * (side_weight(left) * side_weight(up));
        }
        if axis == 0 {
            opacity.x = blocked;
        } else if axis == 1 {
            opacity.y = blocked;
        } else {
            opacity.z = blocked;
        }
    }
    if params.flags & ISOTROPIC != 0 {
        opacity = Vec3::splat(mean_of(opacity));
    }
    pack_depths(Vec3::new(depth_of(opacity.x), depth_of(opacity.y), depth_of(opacity.z)))
}
