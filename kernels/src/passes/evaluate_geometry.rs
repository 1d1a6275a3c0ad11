//! Do intersections, voxel walks and overlaps give the same bits on this device?

use super::evaluate::{EvaluateParams, Evaluation, bit, of_words};
use crate::geometry::box_::{BoxRay, box_interval, four_boxes, pad_bounds};
use crate::geometry::disc::ray_disc;
use crate::geometry::overlap::{overlaps_conservative, overlaps_thin};
use crate::geometry::triangle::{TriangleRay, four_triangles, ray_triangle};
use crate::geometry::voxel_walk::VoxelWalk;
use crate::math::to_u32;
use crate::sampling::hash::combine;
use crate::sampling::voxel_hash::encode;
use glam::{UVec3, UVec4, Vec3, Vec4};

/// Selects the function that [`evaluate_geometry`] evaluates.
///
/// a and b are the ray: origin and start, direction and end.
pub mod function {
    #![allow(missing_docs)]
    /// The disc about c of radius c.w and normal d.
    pub const DISC: u32 = 0;
    /// The box from c to d.
    pub const BOX: u32 = 1;
    /// Four boxes, and whether each lane gives the bits of one box.
    pub const FOUR_BOXES: u32 = 2;
    /// The triangle c, d, e.
    pub const TRIANGLE: u32 = 3;
    /// The same with its corners in four orders, and whether each lane gives the bits of one triangle.
    pub const FOUR_TRIANGLES: u32 = 4;
    /// Up to `count` voxels of the grid of c voxels: their number, their hash, the last, whether the walk goes on.
    pub const VOXEL_WALK: u32 = 5;
    /// The triangle c, d, e and the voxel a: conservative overlap, thin overlap.
    pub const OVERLAP: u32 = 6;
    /// Number of functions.
    pub const COUNT: u32 = 7;
}

/// Returns the selected function of the inputs at `index`; 0 for an unknown selection.
#[inline]
#[allow(clippy::too_many_arguments)]
pub fn evaluate_geometry(
    index: u32,
    params: &EvaluateParams,
    a: &[Vec4],
    b: &[Vec4],
    c: &[Vec4],
    d: &[Vec4],
    e: &[Vec4],
) -> Evaluation {
    let (a, b) = (a[index as usize], b[index as usize]);
    let (c, d, e) = (c[index as usize], d[index as usize], e[index as usize]);
    match params.function {
        function::DISC => {
            let met = ray_disc(a.truncate(), b.truncate(), c.truncate(), d.truncate(), c.w, a.w, b.w);
            Evaluation { numbers: Vec4::new(met.t, 0.0, 0.0, 0.0), words: UVec4::new(bit(met.hit), 0, 0, 0) }
        }
        function::BOX => {
            let (lower, upper) = pad_bounds(c.truncate(), d.truncate());
            let ray = BoxRay::new(a.truncate(), b.truncate());
            let (near, far) = box_interval(lower, upper, &ray, a.w, b.w);
            Evaluation {
                numbers: Vec4::new(near, far, lower.x, upper.y),
                words: UVec4::new(bit(near <= far), 0, 0, 0),
            }
        }
        function::FOUR_BOXES => boxes(a, b, c.truncate(), d.truncate()),
        function::TRIANGLE => {
            let ray = TriangleRay::new(a.truncate(), b.truncate());
            let met = ray_triangle(c.truncate(), d.truncate(), e.truncate(), &ray, a.w, b.w);
            Evaluation {
                numbers: Vec4::new(met.t, met.u, met.v, 0.0),
                words: UVec4::new(bit(met.hit), ray.axis, ray.lanes, 0),
            }
        }
        function::FOUR_TRIANGLES => triangles(a, b, c.truncate(), d.truncate(), e.truncate()),
        function::VOXEL_WALK => walk(params.count, a, b, voxel(c)),
        function::OVERLAP => {
            let (p, q, r) = (c.truncate(), d.truncate(), e.truncate());
            let cell = voxel(a);
            let conservative = bit(overlaps_conservative(p, q, r, cell));
            of_words(UVec4::new(conservative, bit(overlaps_thin(p, q, r, cell)), 0, 0))
        }
        _ => of_words(UVec4::ZERO),
    }
}

#[inline]
fn voxel(v: Vec4) -> UVec3 {
    UVec3::new(to_u32(v.x), to_u32(v.y), to_u32(v.z))
}

/// The box, its two halves along x, and the box turned inside out.
#[inline]
fn boxes(a: Vec4, b: Vec4, lower: Vec3, upper: Vec3) -> Evaluation {
    let ray = BoxRay::new(a.truncate(), b.truncate());
    let middle = 0.5 * (lower.x + upper.x);
    let min_x = Vec4::new(lower.x, lower.x, middle, upper.x);
    let max_x = Vec4::new(upper.x, middle, upper.x, lower.x);
    let (near, mask) = four_boxes(
        min_x,
        max_x,
        Vec4::splat(lower.y),
        Vec4::splat(upper.y),
        Vec4::splat(lower.z),
        Vec4::splat(upper.z),
        &ray,
        a.w,
        b.w,
    );
    let (near, left, right) = (near.to_array(), min_x.to_array(), max_x.to_array());
    let mut equal = 0;
    for lane in 0..4 {
        let low = Vec3::new(left[lane], lower.y, lower.z);
        let high = Vec3::new(right[lane], upper.y, upper.z);
        let (one_near, one_far) = box_interval(low, high, &ray, a.w, b.w);
        let met = mask & (1 << lane) != 0;
        if met == (one_near <= one_far) && (!met || one_near == near[lane]) {
            equal |= 1 << lane;
        }
    }
    let at = |lane: u32| if mask & (1 << lane) != 0 { near[lane as usize] } else { 0.0 };
    Evaluation { numbers: Vec4::new(at(0), at(1), at(2), at(3)), words: UVec4::new(mask, equal, 0, 0) }
}

/// The triangle with its corners in four orders, one per lane.
#[inline]
fn triangles(a: Vec4, b: Vec4, p: Vec3, q: Vec3, r: Vec3) -> Evaluation {
    let ray = TriangleRay::new(a.truncate(), b.truncate());
    let four = four_triangles(
        Vec4::new(p.x, q.x, r.x, p.x),
        Vec4::new(p.y, q.y, r.y, p.y),
        Vec4::new(p.z, q.z, r.z, p.z),
        Vec4::new(q.x, r.x, p.x, r.x),
        Vec4::new(q.y, r.y, p.y, r.y),
        Vec4::new(q.z, r.z, p.z, r.z),
        Vec4::new(r.x, p.x, q.x, q.x),
        Vec4::new(r.y, p.y, q.y, q.y),
        Vec4::new(r.z, p.z, q.z, q.z),
        &ray,
        a.w,
        b.w,
    );
    let (t, u, v) = (four.t.to_array(), four.u.to_array(), four.v.to_array());
    let mut equal = 0;
    for lane in 0..4 {
        let (first, second, third) = match lane {
            0 => (p, q, r),
            1 => (q, r, p),
            2 => (r, p, q),
            _ => (p, r, q),
        };
        let one = ray_triangle(first, second, third, &ray, a.w, b.w);
        let met = four.mask & (1 << lane) != 0;
        if met == one.hit && (!met || (one.t == t[lane] && one.u == u[lane] && one.v == v[lane])) {
            equal |= 1 << lane;
        }
    }
    let at = |lane: u32| if four.mask & (1 << lane) != 0 { t[lane as usize] } else { 0.0 };
    Evaluation { numbers: Vec4::new(at(0), at(1), at(2), at(3)), words: UVec4::new(four.mask, equal, 0, 0) }
}

/// The first `count` voxels of a walk, hashed in order.
#[inline]
fn walk(count: u32, a: Vec4, b: Vec4, dims: UVec3) -> Evaluation {
    let mut walk = VoxelWalk::new(a.truncate(), b.truncate(), dims, b.w);
    let mut cells = 0;
    let mut all = 0;
    let mut last = 0;
    let mut interval = Vec4::ZERO;
    for _ in 0..count {
        if walk.inside {
            cells += 1;
            last = encode(walk.voxel, dims);
            all = combine(all, last);
            interval = Vec4::new(walk.t_enter, walk.t_exit, 0.0, 0.0);
            walk.step();
        }
    }
    Evaluation { numbers: interval, words: UVec4::new(cells, all, last, bit(walk.inside)) }
}
