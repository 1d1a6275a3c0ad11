//! What does a clear sky send? Preetham, Shirley and Smits 1999, over Perez' distribution.

use super::{Environment, EnvironmentMap};
use glam::{Mat3, Vec3};

/// Columns of the map.
const WIDTH: u32 = 256;
/// Lumens per watt of daylight: what turns luminance into radiance.
const EFFICACY: f32 = 179.0;
/// Radiance of the ground over that of the horizon.
const GROUND: f32 = 0.25;

/// A, B, C, D, E of Perez' formula for luminance and chromaticities x, y: slope and offset over turbidity.
const PEREZ: [[(f32, f32); 5]; 3] = [
    [(0.1787, -1.4630), (-0.3554, 0.4275), (-0.0227, 5.3251), (0.1206, -2.5771), (-0.0670, 0.3703)],
    [(-0.0193, -0.2592), (-0.0665, 0.0008), (-0.0004, 0.2125), (-0.0641, -0.8989), (-0.0033, 0.0452)],
    [(-0.0167, -0.2608), (-0.0950, 0.0092), (-0.0079, 0.2102), (-0.0441, -1.6537), (-0.0109, 0.0529)],
];
/// Chromaticity of the zenith: rows by powers of turbidity, columns by powers of the sun's angle.
const ZENITH_X: [[f32; 4]; 3] = [
    [0.00166, -0.00375, 0.00209, 0.0],
    [-0.02903, 0.06377, -0.03202, 0.00394],
    [0.11693, -0.21196, 0.06052, 0.25886],
];
const ZENITH_Y: [[f32; 4]; 3] = [
    [0.00275, -0.00610, 0.00317, 0.0],
    [-0.04214, 0.08970, -0.04153, 0.00516],
    [0.15346, -0.26756, 0.06670, 0.26688],
];

fn perez(c: &[(f32, f32); 5], turbidity: f32, cosine: f32, gamma: f32) -> f32 {
    let [a, b, c, d, e] = c.map(|(slope, offset)| slope * turbidity + offset);
    (1.0 + a * (b / cosine).exp()) * (1.0 + c * (d * gamma).exp() + e * gamma.cos().powi(2))
}

fn zenith(m: &[[f32; 4]; 3], turbidity: f32, angle: f32) -> f32 {
    let row = |r: &[f32; 4]| ((r[0] * angle + r[1]) * angle + r[2]) * angle + r[3];
    (row(&m[0]) * turbidity + row(&m[1])) * turbidity + row(&m[2])
}

/// Returns the sky of a clear day without the sun's disc, `to_sun` of unit length and above the horizon, turbidity from 2 (very
/// clear) to 10 (haze), as a map of 256 × 128 in W/(m² sr); the ground is a quarter as bright as the horizon.
///
/// # Errors
/// What is out of range.
pub fn daylight(to_sun: Vec3, turbidity: f32) -> Result<Environment, String> {
    if !(2.0..=10.0).contains(&turbidity) {
        return Err("the turbidity is not from 2 to 10".into());
    }
    if to_sun.y <= 0.0 || to_sun.is_nan() {
        return Err("the sun is not above the horizon".into());
    }
    let sun = to_sun.y.min(1.0).acos();
    let chi = (4.0 / 9.0 - turbidity / 120.0) * (std::f32::consts::PI - 2.0 * sun);
    let above = [
        ((4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192).max(0.0),
        zenith(&ZENITH_X, turbidity, sun),
        zenith(&ZENITH_Y, turbidity, sun),
    ];
    let radiance = |d: Vec3| {
        let cosine = d.y.max(0.01);
        let gamma = d.dot(to_sun).clamp(-1.0, 1.0).acos();
        let at = |k: usize| {
            above[k] * perez(&PEREZ[k], turbidity, cosine, gamma) / perez(&PEREZ[k], turbidity, 1.0, sun)
        };
        let (luminance, x, y) = (at(0).max(0.0), at(1), at(2));
        let xyz = Vec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance;
        // CIE XYZ to linear Rec.709.
        let rgb = Mat3::from_cols(
            Vec3::new(3.2406, -0.9689, 0.0557),
            Vec3::new(-1.5372, 1.8758, -0.2040),
            Vec3::new(-0.4986, 0.0415, 1.0570),
        ) * xyz;
        rgb.max(Vec3::ZERO) * (1000.0 / EFFICACY)
    };
    let ground = (0..64)
        .map(|i| {
            let (s, c) = (std::f32::consts::TAU * i as f32 / 64.0).sin_cos();
            radiance(Vec3::new(c, 0.01, s).normalize())
        })
        .sum::<Vec3>()
        * (GROUND / 64.0);
    let map =
        EnvironmentMap::from_directions(WIDTH, WIDTH / 2, |d| if d.y < 0.0 { ground } else { radiance(d) });
    map.map(Environment::Map)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sky_is_blue_and_bright_by_the_sun() {
        let to_sun = Vec3::new(0.6, 0.6, 0.2).normalize();
        let sky = daylight(to_sun, 3.0).unwrap();
        let (near, zenith) =
            (sky.radiance((to_sun + Vec3::new(0.0, 0.2, 0.0)).normalize()), sky.radiance(Vec3::Y));
        let far = sky.radiance(Vec3::new(-0.5, 0.7, -0.4).normalize());
        println!("near the sun {near}, zenith {zenith}, away {far}");
        assert!(far.z > far.y && far.y > far.x, "blue: {far}");
        assert!(near.y > 2.0 * far.y, "brighter near the sun");
        // Some kcd/m²: 10³/179 W/(m² sr) each.
        assert!((5.0..200.0).contains(&zenith.y), "{zenith}");
        let haze = daylight(to_sun, 9.0).unwrap().radiance(Vec3::new(-0.5, 0.7, -0.4).normalize());
        assert!(haze.z / haze.x < far.z / far.x, "haze is greyer: {haze}");
        assert!(daylight(Vec3::NEG_Y, 3.0).is_err() && daylight(to_sun, 1.0).is_err());
        assert!(daylight(to_sun, f32::NAN).is_err());
    }
}
