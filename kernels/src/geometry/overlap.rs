//! Which voxels does a triangle occupy?
//!
//! Two answers. *Conservative*: the closed triangle and the closed cube share a point; nothing is lost,
//! walls are up to two voxels thick. *Thin*: the triangle meets the cube's axis cross, the three segments
//! of length 1 through its centre. That is the least set that no path over voxel faces can cross
//! (6-separating; the target of Schwarz and Seidel 2010, section 4.2, tested exactly instead of through the
//! cross's bounding diamond). Triangles smaller than a voxel may meet no cross at all.

use crate::math::{abs, cross, dot, is_finite, max, max_abs, min};
use glam::{UVec3, Vec3};

/// 8·2⁻²⁴: what rounding may move a boundary by, in units of the largest coordinate.
const SLACK: f32 = 4.768_371_6e-7;

/// The corners relative to the voxel's centre, and half the voxel's edge with slack for rounding.
#[derive(Clone, Copy)]
struct Relative {
    a: Vec3,
    b: Vec3,
    c: Vec3,
    half: f32,
    /// The largest coordinate.
    reach: f32,
}

#[inline]
fn relative(a: Vec3, b: Vec3, c: Vec3, voxel: UVec3) -> Relative {
    let centre = Vec3::new(voxel.x as f32 + 0.5, voxel.y as f32 + 0.5, voxel.z as f32 + 0.5);
    let (a, b, c) = (a - centre, b - centre, c - centre);
    let reach = max(max(max_abs(a), max_abs(b)), max_abs(c));
    Relative { a, b, c, half: 0.5 + SLACK * reach, reach }
}

/// Returns whether the closed triangle and the closed voxel share a point; coordinates in voxels.
///
/// Never misses an overlap; also reports voxels that the triangle misses by up to 5e-7 of its largest
/// distance from the voxel. Points and segments (triangles of area 0) work like any. Coordinates below 1e9;
/// NaN and ±∞ give false.
///
/// The separating axes of Akenine-Möller 2001: three of the box, one normal, nine edge products.
#[inline]
pub fn overlaps_conservative(a: Vec3, b: Vec3, c: Vec3, voxel: UVec3) -> bool {
    let r = relative(a, b, c, voxel);
    let finite = is_finite(((a.x + a.y) + (a.z + b.x)) + ((b.y + b.z) + (c.x + c.y)) + c.z);
    let lower_x = min(min(r.a.x, r.b.x), r.c.x);
    let upper_x = max(max(r.a.x, r.b.x), r.c.x);
    let lower_y = min(min(r.a.y, r.b.y), r.c.y);
    let upper_y = max(max(r.a.y, r.b.y), r.c.y);
    let lower_z = min(min(r.a.z, r.b.z), r.c.z);
    let upper_z = max(max(r.a.z, r.b.z), r.c.z);
    if !finite
        || lower_x > r.half
        || upper_x < -r.half
        || lower_y > r.half
        || upper_y < -r.half
        || lower_z > r.half
        || upper_z < -r.half
    {
        return false;
    }
    let ab = b - a;
    let bc = c - b;
    let ca = a - c;
    let normal = cross(ab, bc);
    let of_box = r.half * ((abs(normal.x) + abs(normal.y)) + abs(normal.z));
    // The normal of a sliver is mostly rounding: its error goes with the edges, not with the normal.
    let of_rounding = 6.0 * SLACK * r.reach * (max_abs(ab) * max_abs(bc));
    if abs(dot(normal, r.a)) > of_box + of_rounding {
        return false;
    }
    !edge_separates(ab, r.a, r.c, r.half)
        && !edge_separates(bc, r.b, r.a, r.half)
        && !edge_separates(ca, r.c, r.b, r.half)
}

/// Whether an axis edge × coordinate axis separates the box from the edge's corner and the opposite one.
#[inline]
fn edge_separates(edge: Vec3, corner: Vec3, opposite: Vec3, half: f32) -> bool {
    separates(edge.y, edge.z, corner.y, corner.z, opposite.y, opposite.z, half)
        || separates(edge.z, edge.x, corner.z, corner.x, opposite.z, opposite.x, half)
        || separates(edge.x, edge.y, corner.x, corner.y, opposite.x, opposite.y, half)
}

/// The same in the plane: the axis is the edge's normal.
#[inline]
fn separates(edge_x: f32, edge_y: f32, x0: f32, y0: f32, x1: f32, y1: f32, half: f32) -> bool {
    let p = x0 * edge_y - y0 * edge_x;
    let q = x1 * edge_y - y1 * edge_x;
    let extent = half * (abs(edge_x) + abs(edge_y));
    min(p, q) > extent || max(p, q) < -extent
}

/// Returns whether the triangle meets the voxel's axis cross; coordinates in voxels.
///
/// Where the segment between the centres of two neighbours is crossed, at least one of them is reported, at
/// edges and corners shared by triangles too: edge functions have the right sign or are 0, and 0 counts as
/// inside. Triangles of area 0 meet nothing. Coordinates below 1e9; NaN and ±∞ give false.
#[inline]
pub fn overlaps_thin(a: Vec3, b: Vec3, c: Vec3, voxel: UVec3) -> bool {
    let finite = is_finite(((a.x + a.y) + (a.z + b.x)) + ((b.y + b.z) + (c.x + c.y)) + c.z);
    if !finite {
        return false;
    }
    let r = relative(a, b, c, voxel);
    meets_axis(r.a.x, r.a.y, r.a.z, r.b.x, r.b.y, r.b.z, r.c.x, r.c.y, r.c.z, r.half)
        || meets_axis(r.a.y, r.a.z, r.a.x, r.b.y, r.b.z, r.b.x, r.c.y, r.c.z, r.c.x, r.half)
        || meets_axis(r.a.z, r.a.x, r.a.y, r.b.z, r.b.x, r.b.y, r.c.z, r.c.x, r.c.y, r.half)
}

/// Whether the segment from −half to half on the third axis meets the triangle.
#[inline]
fn meets_axis(
    ax: f32,
    ay: f32,
    az: f32,
    bx: f32,
    by: f32,
    bz: f32,
    cx: f32,
    cy: f32,
    cz: f32,
    half: f32,
) -> bool {
    let of_a = cx * by - cy * bx;
    let of_b = ax * cy - ay * cx;
    let of_c = bx * ay - by * ax;
    let area = (of_a + of_b) + of_c;
    let front = min(min(of_a, of_b), of_c) >= 0.0 && area > 0.0;
    let back = max(max(of_a, of_b), of_c) <= 0.0 && area < 0.0;
    // The height over the centre, times the area: no division.
    let height = (of_a * az + of_b * bz) + of_c * cz;
    (front || back) && abs(height) <= half * abs(area)
}
