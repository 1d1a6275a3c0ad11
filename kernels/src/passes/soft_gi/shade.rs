//! What light arrives at a receiver? SGI eqs. 10 and 12.

use super::{REFLECTED, SHADOWED, SoftParams};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{FRAC_1_PI, div, max, min, saturate};
use crate::passes::evaluate_sh::{ShVector, load};
use crate::passes::surface::Surface;
use crate::sh::{self, CLAMPED_COSINE, UNIT};
use glam::{Vec3, Vec4};

/// ∫ visibility × cosine × light, each of them in the same order: Σ Γ_ijk o_i h_j l_k.
#[inline]
// Copies between slices do not compile to SPIR-V.
#[allow(clippy::manual_memcpy)]
fn shadowed<const N: usize, const B: usize>(s: &Surface, occlusion: &ShVector, light: &[ShVector]) -> Vec3 {
    let mut cosine = [0.0; B];
    for l in 0..B {
        cosine[l] = CLAMPED_COSINE[l];
    }
    let receiver = sh::rotate_zonal::<B, N>(&cosine, s.normal.truncate());
    let seen = sh::product(&load::<N>(occlusion), &receiver);
    Vec3::new(
        sh::dot(&seen, &load::<N>(&light[0])),
        sh::dot(&seen, &load::<N>(&light[1])),
        sh::dot(&seen, &load::<N>(&light[2])),
    )
}

/// Returns irradiance/π that receiver `index` has of the surroundings past its proxies; w is what they cover of the visibility's
/// first coefficient, √4π for all. `light` are the surroundings' radiance in red, green and blue.
#[inline]
pub fn shade_shadowed(
    index: u32,
    params: &SoftParams,
    surfaces: &[Surface],
    occlusion: &[ShVector],
    light: &[ShVector],
) -> Vec4 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return Vec4::ZERO;
    }
    let o = &occlusion[index as usize];
    let irradiance = match params.order {
        2 => shadowed::<4, 2>(s, o, light),
        3 => shadowed::<9, 3>(s, o, light),
        4 => shadowed::<16, 4>(s, o, light),
        _ => shadowed::<25, 5>(s, o, light),
    };
    // The series rings: the sum may be below 0, never a coefficient's business.
    let lit = Vec3::new(max(irradiance.x, 0.0), max(irradiance.y, 0.0), max(irradiance.z, 0.0));
    (lit * FRAC_1_PI).extend(o.c24.w)
}

/// Returns ξ: how much of the proxies' solid angles is left where they overlap, in [0, 1]; 1 without any. SGI eq. 12.
///
/// What counts of a proxy lies over the receiver's plane, so that not more than half of all directions can be covered; cheap
/// exponentials of very many proxies say more.
#[inline]
pub fn overlap_share(covered: f32, solid_angle: f32) -> f32 {
    // Of less than 10⁻⁴ sr little is known but that it does not overlap.
    if solid_angle > 1.0e-4 { saturate(div(min(covered, 0.5 * UNIT) * UNIT, solid_angle)) } else { 1.0 }
}

/// Returns the light that arrives at receiver `index`, irradiance/π: what passes the proxies and what they reflect, as
/// `params.parts` asks; w is ξ.
#[inline]
pub fn combine_soft(index: u32, params: &SoftParams, shadowed: &[Vec4], reflected: &[Vec4]) -> Vec4 {
    let (past, sent) = (shadowed[index as usize], reflected[index as usize]);
    let share = overlap_share(past.w, sent.w);
    let mut light = Vec3::ZERO;
    if params.parts & SHADOWED != 0 {
        light += past.truncate();
    }
    if params.parts & REFLECTED != 0 {
        let own = sent.truncate() * (share * FRAC_1_PI);
        light += Vec3::new(max(own.x, 0.0), max(own.y, 0.0), max(own.z, 0.0));
    }
    light.extend(share)
}
