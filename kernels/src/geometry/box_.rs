//! Over which part of a ray is it inside a box, without ever losing what the triangle test would hit?
//!
//! The slab test with two guards. The far end is moved out by 1 + 2γ(3) (Ize 2013, "Robust BVH ray
//! traversal"), which covers the rounding of the slabs themselves. The planes are moved out by [`PADDING`]
//! times the largest coordinate of the origin, and by [`pad_bounds`] times that of the box, which covers
//! the rounding of [`super::triangle`]: it may accept a ray that passes a corner at up to 5·2⁻²⁴ of its
//! distance.

use crate::math::{abs, max, max_abs, min, recip};
use glam::{Vec3, Vec4};

/// Share of the largest coordinate by which planes move out: 16 rounding errors.
pub const PADDING: f32 = 9.536_743e-7;
/// The least distance that planes move out, for rays that run inside a plane from the world's origin.
const LEAST_PADDING: f32 = 1e-12;
/// Direction components are kept at least this far from 0, so that inverses and slabs stay finite.
const LEAST_DIRECTION: f32 = 1e-20;
/// Its inverse; a constant, so that no division is left to run time.
const LARGEST_INVERSE: f32 = 1.0 / LEAST_DIRECTION;
/// 1 + 2γ(3) with γ(n) = n·2⁻²⁴/(1 − n·2⁻²⁴), rounded up.
const FAR_FACTOR: f32 = 1.0 + 3.576_278_7e-7;

/// What the box tests need of a ray, computed once per ray.
#[derive(Clone, Copy)]
pub struct BoxRay {
    /// 1/direction; a component below 1e-20 counts as 1e-20 with its sign.
    pub inverse: Vec3,
    /// The origin as the lower planes see it: moved up.
    pub origin_for_min: Vec3,
    /// The origin as the upper planes see it: moved down.
    pub origin_for_max: Vec3,
}

impl BoxRay {
    /// Returns the ray from `origin` along `direction` (any length but 0), prepared for the box tests.
    ///
    /// Coordinates up to 1e18 stay finite throughout. A NaN direction component counts as 1e-20.
    #[inline]
    pub fn new(origin: Vec3, direction: Vec3) -> Self {
        let padding = max(max_abs(origin) * PADDING, LEAST_PADDING);
        let moved = Vec3::new(padding, padding, padding);
        Self {
            inverse: Vec3::new(
                safe_inverse(direction.x),
                safe_inverse(direction.y),
                safe_inverse(direction.z),
            ),
            origin_for_min: origin + moved,
            origin_for_max: origin - moved,
        }
    }
}

#[inline]
fn safe_inverse(d: f32) -> f32 {
    if abs(d) >= LEAST_DIRECTION {
        recip(d)
    } else if d < 0.0 {
        -LARGEST_INVERSE
    } else {
        LARGEST_INVERSE
    }
}

/// Returns the bounds moved out by [`PADDING`] times their largest coordinate: what a tree should store.
#[inline]
pub fn pad_bounds(lower: Vec3, upper: Vec3) -> (Vec3, Vec3) {
    let padding = max(max_abs(lower), max_abs(upper)) * PADDING;
    let moved = Vec3::new(padding, padding, padding);
    (lower - moved, upper + moved)
}

/// Returns (t_near, t_far), the ray's parameters in the box and [t_min, t_max]; t_near > t_far is a miss.
///
/// t_min ≥ 0; t_far is already widened. A box with lower.x > upper.x is empty and missed, flat boxes are
/// not. NaN planes or origins give either answer, never NaN parameters beyond [t_min, t_max]; sanitise them
/// before. Returns the same bits as a lane of [`four_boxes`].
#[inline]
pub fn box_interval(lower: Vec3, upper: Vec3, ray: &BoxRay, t_min: f32, t_max: f32) -> (f32, f32) {
    let x0 = (lower.x - ray.origin_for_min.x) * ray.inverse.x;
    let x1 = (upper.x - ray.origin_for_max.x) * ray.inverse.x;
    let y0 = (lower.y - ray.origin_for_min.y) * ray.inverse.y;
    let y1 = (upper.y - ray.origin_for_max.y) * ray.inverse.y;
    let z0 = (lower.z - ray.origin_for_min.z) * ray.inverse.z;
    let z1 = (upper.z - ray.origin_for_max.z) * ray.inverse.z;
    let near = max(max(min(x0, x1), min(y0, y1)), max(min(z0, z1), t_min));
    let far = min(min(max(x0, x1), max(y0, y1)), min(max(z0, z1), t_max)) * FAR_FACTOR;
    if lower.x <= upper.x { (near, far) } else { (1.0, 0.0) }
}

/// Returns t_near of four boxes and the bits of the lanes that the ray meets in [t_min, t_max], t_min ≥ 0.
///
/// Lanes with min_x > max_x are empty and never met. Minimum and maximum are `a < b ? a : b` in each lane on
/// every backend, so lanes give the bits of [`box_interval`]; a NaN in a lane spoils that lane alone.
#[inline(always)]
pub fn four_boxes(
    min_x: Vec4,
    max_x: Vec4,
    min_y: Vec4,
    max_y: Vec4,
    min_z: Vec4,
    max_z: Vec4,
    ray: &BoxRay,
    t_min: f32,
    t_max: f32,
) -> (Vec4, u32) {
    let x0 = (min_x - Vec4::splat(ray.origin_for_min.x)) * Vec4::splat(ray.inverse.x);
    let x1 = (max_x - Vec4::splat(ray.origin_for_max.x)) * Vec4::splat(ray.inverse.x);
    let y0 = (min_y - Vec4::splat(ray.origin_for_min.y)) * Vec4::splat(ray.inverse.y);
    let y1 = (max_y - Vec4::splat(ray.origin_for_max.y)) * Vec4::splat(ray.inverse.y);
    let z0 = (min_z - Vec4::splat(ray.origin_for_min.z)) * Vec4::splat(ray.inverse.z);
    let z1 = (max_z - Vec4::splat(ray.origin_for_max.z)) * Vec4::splat(ray.inverse.z);
    let near = x0.min(x1).max(y0.min(y1)).max(z0.min(z1).max(Vec4::splat(t_min)));
    let far = x0.max(x1).min(y0.max(y1)).min(z0.max(z1).min(Vec4::splat(t_max)));
    (near, lanes_at_most(near, far * Vec4::splat(FAR_FACTOR)) & lanes_at_most(min_x, max_x))
}

/// Bits of the lanes where a ≤ b; NaN is never at most anything.
#[inline(always)]
pub(super) fn lanes_at_most(a: Vec4, b: Vec4) -> u32 {
    #[cfg(not(target_arch = "spirv"))]
    {
        a.cmple(b).bitmask()
    }
    // glam's mask would become a branch per lane.
    #[cfg(target_arch = "spirv")]
    {
        let bit = |met: bool, bit: u32| if met { bit } else { 0 };
        bit(a.x <= b.x, 1) | bit(a.y <= b.y, 2) | bit(a.z <= b.z, 4) | bit(a.w <= b.w, 8)
    }
}
