//! How do samples along a cone add up, front to back?

use glam::{Vec3, Vec4};

/// Returns `front` over `back`, both premultiplied (colour·opacity, opacity): front + (1 − α)·back.
///
/// Associative within 4·2⁻²⁴; opacities in [0, 1] give one in [0, 1] that is not below that of `front`, and an opaque
/// front hides the back exactly. VCT §5, LRSM eq. 1; VCT prints αc + …, which holds for an un-premultiplied c only.
#[inline]
pub fn composite(front: Vec4, back: Vec4) -> Vec4 {
    front + back * (1.0 - front.w)
}

/// Returns `front` (premultiplied) over a sample whose colour is *not* multiplied by its opacity.
///
/// c ← c + (1 − α) α₂ c₂, α ← α + (1 − α) α₂. VCT §5.
#[inline]
pub fn accumulate(front: Vec4, colour: Vec3, opacity: f32) -> Vec4 {
    composite(front, (colour * opacity).extend(opacity))
}
