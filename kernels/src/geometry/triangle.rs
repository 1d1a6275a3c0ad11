//! Where does a ray meet a triangle, so that no ray slips between neighbours at an edge or a corner?
//!
//! Woop, Benthin and Wald 2013, "Watertight ray/triangle intersection". Corners are taken relative to the
//! origin and sheared so that the ray becomes the z axis; the test is then in the plane. A sheared corner
//! depends on the ray and the corner alone, so neighbours see the same one, and each edge function is a
//! difference of two rounded products: rounding is monotonic, so its sign is right or the function is 0.
//! Zero counts as inside on both sides of an edge. Together: a ray that crosses a closed surface hits it,
//! at edges and corners too, where it may hit more than one triangle. Plücker edge tests have the first
//! property (equal edges) but not the second (right signs), and let rays through at corners.

use super::box_::lanes_at_most;
use crate::math::{MIN_POSITIVE, abs, div, is_finite, max, min, recip};
use glam::{Vec3, Vec4};

const ALL_LANES: u32 = 15;

/// What the triangle tests need of a ray, computed once per ray.
#[derive(Clone, Copy)]
pub struct TriangleRay {
    /// The origin, axes rotated so that z is the axis of the direction's largest component.
    pub origin: Vec3,
    /// Shear (d.x/d.z, d.y/d.z) and scale 1/d.z of the direction with rotated axes.
    pub shear: Vec3,
    /// The axis that became z.
    pub axis: u32,
    /// Bits of the lanes that can hit: 15, or 0 for a ray that meets nothing.
    pub lanes: u32,
}

impl TriangleRay {
    /// Returns the ray from `origin` along `direction` (any length), prepared for the triangle tests.
    ///
    /// A direction of 0 (all components below 2⁻¹²⁶), NaN or ±∞ in either argument give a ray that meets
    /// nothing.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        let x = abs(direction.x);
        let y = abs(direction.y);
        let z = abs(direction.z);
        let axis = if x >= y && x >= z {
            0
        } else if y >= z {
            1
        } else {
            2
        };
        let d = rotate_axes(direction, axis);
        let finite = is_finite(direction.x)
            && is_finite(direction.y)
            && is_finite(direction.z)
            && is_finite(origin.x)
            && is_finite(origin.y)
            && is_finite(origin.z);
        if !finite || abs(d.z) < MIN_POSITIVE {
            return Self { origin: Vec3::ZERO, shear: Vec3::ZERO, axis, lanes: 0 };
        }
        let shear = Vec3::new(div(d.x, d.z), div(d.y, d.z), recip(d.z));
        Self { origin: rotate_axes(origin, axis), shear, axis, lanes: ALL_LANES }
    }
}

/// v with the axes turned so that `axis` becomes z.
#[inline]
fn rotate_axes(v: Vec3, axis: u32) -> Vec3 {
    if axis == 0 {
        Vec3::new(v.y, v.z, v.x)
    } else if axis == 1 {
        Vec3::new(v.z, v.x, v.y)
    } else {
        v
    }
}

/// A ray's meeting with one triangle.
#[derive(Clone, Copy)]
pub struct TriangleHit {
    /// Whether the ray meets the triangle; the rest is 0 if it does not.
    pub hit: bool,
    /// The ray's parameter, in lengths of its direction.
    pub t: f32,
    /// Weight of the second corner: the point is (1 − u − v)A + uB + vC. In [0, 1 + 2⁻²²].
    pub u: f32,
    /// Weight of the third corner, in [0, 1 + 2⁻²²].
    pub v: f32,
}

/// Returns where the ray meets the triangle abc, from either side, with t in [t_min, t_max] (both included).
///
/// Corners within 1e18 of the origin; triangles whose doubled area seen along the ray is below 2⁻¹²⁶,
/// edge-on ones and ones with two equal corners are missed. t is a convex combination of the corners'
/// depths: its error is below 8·2⁻²⁴ of the farthest corner's depth plus what the rounding of corners (2⁻²⁴
/// of their distance) moves a slanted surface along the ray. Same bits as a lane of [`four_triangles`].
#[inline]
pub fn ray_triangle(a: Vec3, b: Vec3, c: Vec3, ray: &TriangleRay, t_min: f32, t_max: f32) -> TriangleHit {
    const MISS: TriangleHit = TriangleHit { hit: false, t: 0.0, u: 0.0, v: 0.0 };
    let a = rotate_axes(a, ray.axis) - ray.origin;
    let b = rotate_axes(b, ray.axis) - ray.origin;
    let c = rotate_axes(c, ray.axis) - ray.origin;
    let ax = a.x - ray.shear.x * a.z;
    let ay = a.y - ray.shear.y * a.z;
    let bx = b.x - ray.shear.x * b.z;
    let by = b.y - ray.shear.y * b.z;
    let cx = c.x - ray.shear.x * c.z;
    let cy = c.y - ray.shear.y * c.z;
    let of_a = cx * by - cy * bx;
    let of_b = ax * cy - ay * cx;
    let of_c = bx * ay - by * ax;
    let area = (of_a + of_b) + of_c;
    let front = min(min(of_a, of_b), of_c) >= 0.0 && area >= MIN_POSITIVE;
    let back = max(max(of_a, of_b), of_c) <= 0.0 && area <= -MIN_POSITIVE;
    if ray.lanes == 0 || !(front || back) {
        return MISS;
    }
    let inverse = recip(area);
    let w = of_a * inverse;
    let u = of_b * inverse;
    let v = of_c * inverse;
    let t = ((w * a.z + u * b.z) + v * c.z) * ray.shear.z;
    if t >= t_min && t <= t_max { TriangleHit { hit: true, t, u, v } } else { MISS }
}

/// A ray's meetings with four triangles, one per lane.
#[derive(Clone, Copy)]
pub struct FourHits {
    /// The ray's parameters; only lanes in `mask` mean something.
    pub t: Vec4,
    /// Weights of the second corners.
    pub u: Vec4,
    /// Weights of the third corners.
    pub v: Vec4,
    /// Bits of the lanes that are hit.
    pub mask: u32,
}

/// Returns where the ray meets four triangles given by the coordinates of their corners; see
/// [`ray_triangle`].
///
/// Lanes without a triangle may hold three equal corners. Divides only when a lane passes the edge tests.
#[inline(always)]
pub fn four_triangles(
    x0: Vec4,
    y0: Vec4,
    z0: Vec4,
    x1: Vec4,
    y1: Vec4,
    z1: Vec4,
    x2: Vec4,
    y2: Vec4,
    z2: Vec4,
    ray: &TriangleRay,
    t_min: f32,
    t_max: f32,
) -> FourHits {
    // The same branch for every triangle of a ray: cheaper than a projection that needs no turned axes.
    let (x0, y0, z0, x1, y1, z1, x2, y2, z2) = if ray.axis == 0 {
        (y0, z0, x0, y1, z1, x1, y2, z2, x2)
    } else if ray.axis == 1 {
        (z0, x0, y0, z1, x1, y1, z2, x2, y2)
    } else {
        (x0, y0, z0, x1, y1, z1, x2, y2, z2)
    };
    let origin_x = Vec4::splat(ray.origin.x);
    let origin_y = Vec4::splat(ray.origin.y);
    let origin_z = Vec4::splat(ray.origin.z);
    let shear_x = Vec4::splat(ray.shear.x);
    let shear_y = Vec4::splat(ray.shear.y);
    let az = z0 - origin_z;
    let bz = z1 - origin_z;
    let cz = z2 - origin_z;
    let ax = (x0 - origin_x) - shear_x * az;
    let ay = (y0 - origin_y) - shear_y * az;
    let bx = (x1 - origin_x) - shear_x * bz;
    let by = (y1 - origin_y) - shear_y * bz;
    let cx = (x2 - origin_x) - shear_x * cz;
    let cy = (y2 - origin_y) - shear_y * cz;
    let of_a = cx * by - cy * bx;
    let of_b = ax * cy - ay * cx;
    let of_c = bx * ay - by * ax;
    let area = (of_a + of_b) + of_c;
    let least = Vec4::splat(MIN_POSITIVE);
    let front = lanes_at_most(Vec4::ZERO, of_a.min(of_b).min(of_c)) & lanes_at_most(least, area);
    let back = lanes_at_most(of_a.max(of_b).max(of_c), Vec4::ZERO) & lanes_at_most(area, -least);
    let mask = (front | back) & ray.lanes;
    if mask == 0 {
        return FourHits { t: Vec4::ZERO, u: Vec4::ZERO, v: Vec4::ZERO, mask: 0 };
    }
    let inverse = recip_lanes(area, mask);
    let w = of_a * inverse;
    let u = of_b * inverse;
    let v = of_c * inverse;
    let t = ((w * az + u * bz) + v * cz) * Vec4::splat(ray.shear.z);
    let in_range = lanes_at_most(Vec4::splat(t_min), t) & lanes_at_most(t, Vec4::splat(t_max));
    FourHits { t, u, v, mask: mask & in_range }
}

/// 1/x in the lanes of the mask, rounded as [`recip`]; the others are whatever is cheapest.
#[inline(always)]
fn recip_lanes(x: Vec4, mask: u32) -> Vec4 {
    #[cfg(not(target_arch = "spirv"))]
    {
        let _ = mask;
        Vec4::ONE / x
    }
    #[cfg(target_arch = "spirv")]
    {
        let lane = |value: f32, bit: u32| if mask & bit != 0 { recip(value) } else { 1.0 };
        Vec4::new(lane(x.x, 1), lane(x.y, 2), lane(x.z, 4), lane(x.w, 8))
    }
}
