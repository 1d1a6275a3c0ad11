//! What do a receiver's proxies reflect of the surroundings? SGI §5.

use super::receiver::Receiver;
use super::{AVERAGED, AVERAGED_FIT, EXACT, SoftParams, SphereProxy};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{FRAC_1_PI, dot, max, orthonormal_frame};
use crate::passes::evaluate_sh::{ShVector, load};
use crate::passes::surface::Surface;
use crate::sh::{self, Blocker, CLAMPED_COSINE, UNIT};
use glam::{Mat3, Vec3, Vec4};

/// The surroundings' irradiance for any normal, order 3, in three colours.
struct Irradiance {
    red: [f32; 9],
    green: [f32; 9],
    blue: [f32; 9],
}

impl Irradiance {
    /// Σ a_i f_i for each colour.
    #[inline]
    fn dot(&self, a: &[f32; 9]) -> Vec3 {
        Vec3::new(sh::dot(&self.red, a), sh::dot(&self.green, a), sh::dot(&self.blue, a))
    }
}

/// ∫ over the proxy's cap of the cosine to the receiver's normal: two zonal functions, by the angle between their axes.
#[inline]
fn form_factor(cap: &[f32; 3], cosine: f32) -> f32 {
    let x = cosine;
    // Legendre polynomials 0 to 2.
    (cap[0] * CLAMPED_COSINE[0] + cap[1] * (CLAMPED_COSINE[1] * x))
        + cap[2] * (CLAMPED_COSINE[2] * (1.5 * (x * x) - 0.5))
}

/// The irradiance, for an albedo of 1, that a proxy's light gives; its mean radiance times its form factor.
#[inline]
fn averaged(params: &SoftParams, light: &Irradiance, b: &Blocker, cap: &[f32; 3], n: Vec3) -> Vec3 {
    let mean = if params.operator == AVERAGED || params.operator == AVERAGED_FIT {
        let operator = if params.operator == AVERAGED {
            sh::averaged_operator(b.alpha)
        } else {
            sh::averaged_operator_fit(b.alpha)
        };
        light.dot(&sh::rotate_zonal::<3, 9>(&operator, b.direction))
    } else {
        light.dot(&sh::basis::<9>(-b.direction))
    };
    let radiance = Vec3::new(max(mean.x, 0.0), max(mean.y, 0.0), max(mean.z, 0.0)) * FRAC_1_PI;
    radiance * form_factor(cap, dot(b.direction, n))
}

/// The same by the exact operator, in the frame whose z points to the proxy.
#[inline]
fn exact(params: &SoftParams, light: &Irradiance, b: &Blocker, n: Vec3, table: &[f32]) -> Vec3 {
    let (x, y) = orthonormal_frame(b.direction);
    // Rows are the frame's axes: the map into it.
    let into = Mat3::from_cols(x, y, b.direction).transpose();
    let cosine = [CLAMPED_COSINE[0], CLAMPED_COSINE[1], CLAMPED_COSINE[2]];
    let receiver = sh::rotate_zonal::<3, 9>(&cosine, into * n);
    let entries = params.operator_entries;
    Vec3::new(
        sh::dot(&sent(table, entries, b.alpha, &into, &light.red), &receiver),
        sh::dot(&sent(table, entries, b.alpha, &into, &light.green), &receiver),
        sh::dot(&sent(table, entries, b.alpha, &into, &light.blue), &receiver),
    ) * FRAC_1_PI
}

/// What a proxy of irradiance `f` sends, in its frame.
#[inline]
fn sent(table: &[f32], entries: u32, alpha: f32, into: &Mat3, f: &[f32; 9]) -> [f32; 9] {
    sh::exact_operator(table, entries, alpha, &sh::rotate(into, f))
}

/// Returns the irradiance that proxies of receiver `index` reflect onto it, overlap ignored; w is their solid angle, which
/// overlap counts twice in too. `light` are the red, green and blue irradiance of [`irradiance`](sh::irradiance).
#[inline]
pub fn accumulate_indirect(
    index: u32,
    params: &SoftParams,
    surfaces: &[Surface],
    proxies: &[SphereProxy],
    starts: &[u32],
    counts: &[u32],
    lists: &[u32],
    light: &[ShVector],
    table: &[f32],
) -> Vec4 {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return Vec4::ZERO;
    }
    let light = Irradiance { red: load(&light[0]), green: load(&light[1]), blue: load(&light[2]) };
    let receiver = Receiver::new(index, params, s, starts, counts);
    let least = sh::influence_key(params.light_reach);
    let least_shadow = sh::influence_key(params.shadow_reach);
    let mut sum = Vec4::ZERO;
    for k in 0..receiver.count {
        let proxy = &proxies[receiver.number(k, lists) as usize];
        let met = receiver.met(params, proxy.sphere);
        let (b, weight) = (met.blocker, met.weight(least));
        // ξ compares solid angles with what shadows: the same proxies must count in both.
        let shadows = met.weight(least_shadow);
        if weight > 0.0 || shadows > 0.0 {
            let cap = sh::cap::<3>(b.alpha);
            let sent = if params.operator == EXACT {
                exact(params, &light, &b, receiver.normal, table)
            } else {
                averaged(params, &light, &b, &cap, receiver.normal)
            };
            sum += (proxy.albedo.truncate() * sent * weight).extend(UNIT * cap[0] * shadows);
        }
    }
    sum
}
