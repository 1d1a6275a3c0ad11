//! What do proxies throw onto other surfaces by their gloss?
//!
//! A light that a glossy side sees is mirrored into a Phong lobe. Lobes stand behind the sides' radiance in the same
//! buffer, two words of four for each side and light: the mirrored direction with the exponent in w, and the radiance
//! in the lobe's middle. The paper's proxies are diffuse only; without these a metal block throws no bright patch.

use super::grid::GridParams;
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{FRAC_1_PI, div, dot, max, min, pow_fast};
use crate::passes::light::incident_light;
use crate::passes::material::mirror_direction;
use crate::passes::scene::Light;
use crate::passes::surface::Surface;
use glam::{Vec3, Vec4};

/// Lobes are cut off where n·(1 − cos) is this: at 6e-6 of their middle.
const LOBE_EDGE: f32 = 12.0;

gpu_struct! {
    /// Parameters of [`add_lobes`].
    pub struct LobeParams {
        /// First light of this run.
        pub first_light: u32,
        /// Number of lights of this run, at most 32.
        pub light_count: u32,
        /// Number of all lights.
        pub lights: u32,
        /// Number of sides: twice the proxies.
        pub sides: u32,
    }
}

/// Returns word `index` of the sides' radiance and lobes: `previous`, or this run's lobes where `index` is one of theirs.
///
/// Radiance in the middle of a lobe is kₛ·(n + 2)/2π·E·cos θ, in W/(m² sr); 0 in shadow and for a dull side.
#[inline]
pub fn add_lobes(
    index: u32,
    params: &LobeParams,
    surfaces: &[Surface],
    gloss: &[Vec4],
    lights: &[Light],
    visibility: &[u32],
    previous: &[Vec4],
) -> Vec4 {
    if index < params.sides {
        return previous[index as usize];
    }
    let word = index - params.sides;
    let lobe = word / 2;
    let side = lobe / params.lights;
    let light = lobe - side * params.lights;
    if light < params.first_light || light >= params.first_light + params.light_count {
        return previous[index as usize];
    }
    let s = &surfaces[side as usize];
    let own = gloss[side as usize];
    let normal = s.normal.truncate();
    if s.triangle == NO_TRIANGLE || visibility[side as usize] & (1 << (light - params.first_light)) == 0 {
        return normal.extend(0.0) * if word & 1 == 0 { 1.0 } else { 0.0 };
    }
    let incident = incident_light(&lights[light as usize], s.position.truncate());
    if word & 1 == 0 {
        return mirror_direction(normal, incident.direction).extend(own.w);
    }
    let cosine = max(0.0, dot(incident.direction, normal));
    let middle = (own.w + 2.0) * (0.5 * FRAC_1_PI) * cosine;
    (own.truncate() * incident.irradiance * middle).extend(0.0)
}

/// The exponent of a lobe as it falls on or leaves discs at a distance, given 1/distance.
///
/// A lobe of exponent n has a variance of about 1/n, a disc of radius r that of a normal distribution of half its
/// radius, (r/2d)². Unblurred, a narrow lobe would show the gaps between proxies.
#[inline]
pub(super) fn blurred(exponent: f32, disc_radius: f32, inverse_distance: f32) -> f32 {
    let blur = 0.5 * disc_radius * inverse_distance;
    div(exponent, 1.0 + exponent * (blur * blur))
}

/// The first word of a side's lobes.
#[inline]
fn first_lobe(sides: u32, lights: u32, side: u32) -> u32 {
    sides + 2 * lights * side
}

/// The radiance that a side mirrors toward `direction`, its lobes blurred by the discs' radius at a distance.
#[inline]
pub(super) fn mirrored(
    (sides, lights): (u32, u32),
    side: u32,
    direction: Vec3,
    disc_radius: f32,
    inverse_distance: f32,
    radiance: &[Vec4],
) -> Vec3 {
    let first = first_lobe(sides, lights, side);
    let blur = 0.5 * disc_radius * inverse_distance;
    let mut sum = Vec3::ZERO;
    // Loops are dear to a work item, and few scenes have more than two lights.
    for_two!(0, lights, |light| {
        let at = first + 2 * light;
        sum += lobe_toward(direction, radiance[at as usize], radiance[(at + 1) as usize], blur);
    });
    if lights > 2 {
        for light in 2..lights {
            let at = first + 2 * light;
            sum += lobe_toward(direction, radiance[at as usize], radiance[(at + 1) as usize], blur);
        }
    }
    sum
}

/// The radiance of one lobe along `direction`; `blur` is the angle that half a disc's radius spans.
#[inline]
fn lobe_toward(direction: Vec3, lobe: Vec4, middle: Vec4, blur: f32) -> Vec3 {
    let cosine = min(dot(lobe.truncate(), direction), 1.0);
    let widening = 1.0 + lobe.w * (blur * blur);
    let lit = max(max(middle.x, middle.y), middle.z) > 0.0;
    if lit && cosine > 0.0 && lobe.w * (1.0 - cosine) < LOBE_EDGE * widening {
        let exponent = div(lobe.w, widening);
        // Wider is lower: the lobe's whole stays.
        let height = div(exponent + 2.0, lobe.w + 2.0);
        middle.truncate() * (height * pow_fast(cosine, exponent))
    } else {
        Vec3::ZERO
    }
}

/// Whether one of a proxy's sides mirrors a light.
#[inline]
pub(super) fn mirrors(params: &GridParams, proxy: u32, radiance: &[Vec4]) -> bool {
    let first = first_lobe(2 * params.proxies, params.lights, 2 * proxy);
    let mut brightest = 0.0;
    for lobe in 0..2 * params.lights {
        let middle = radiance[(first + 2 * lobe + 1) as usize];
        brightest = max(brightest, max(max(middle.x, middle.y), middle.z));
    }
    brightest > 0.0
}
