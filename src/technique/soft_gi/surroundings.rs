//! What light do the surroundings give, in spherical harmonics, and which proxies stand in it? SGI §3.

use super::SoftGi;
use crate::scene::{Environment, EnvironmentMap, Scene};
use glam::{DVec3, Mat3, Vec3};
use twinlight_kernels::passes::elements::{ShVector, SphereProxy, Vec4};
use twinlight_kernels::sh;

/// Coefficients of order 5.
const N: usize = 25;
/// How much of the brightest irradiance one proxy at the end of its reach may take: ¹⁄₆₄, which gives a light as peaked as order 4
/// can be the paper's 15.
const LEAST_SHADE: f32 = 1.0 / 64.0;

/// A scene as soft global illumination sees it.
#[derive(Clone, Debug)]
pub struct Surroundings {
    /// Radiance by direction in red, green and blue, order 5.
    pub radiance: [[f32; N]; 3],
    /// The proxies.
    pub proxies: Vec<SphereProxy>,
}

impl Surroundings {
    /// Projects a scene's environment and takes its proxies.
    pub fn new(scene: &Scene) -> Self {
        let proxies = scene
            .proxies
            .iter()
            .map(|s| SphereProxy { sphere: s.centre.extend(s.radius), albedo: s.albedo.extend(0.0) })
            .collect();
        Self { radiance: project(&scene.environment), proxies }
    }

    /// Radiance toward a unit direction in the given order; it rings, and may be below 0.
    pub fn seen(&self, order: u32, direction: Vec3) -> Vec3 {
        let basis = sh::basis::<N>(direction);
        let count = (order * order) as usize;
        let of = |c: usize| -> f32 { (0..count).map(|i| self.radiance[c][i] * basis[i]).sum() };
        Vec3::new(of(0), of(1), of(2))
    }

    /// The same with its light turned: what was seen along d is seen along `rotation`·d.
    pub fn turned(&self, rotation: &Mat3) -> Self {
        Self { radiance: self.radiance.map(|c| sh::rotate(rotation, &c)), ..self.clone() }
    }

    /// The light as a map of radiances, negative ones 0: what a path tracer needs to see the same light.
    pub fn as_environment(&self, order: u32, width: u32) -> Environment {
        let map = EnvironmentMap::from_directions(width, (width / 2).max(1), |d| {
            self.seen(order, d).max(Vec3::ZERO)
        });
        map.map_or(Environment::None, Environment::Map)
    }

    /// The three colours' radiance, for the passes.
    pub(super) fn light(&self) -> [ShVector; 3] {
        self.radiance.map(|c| vector(&c))
    }

    /// The three colours' irradiance by normal, order 3, for the passes.
    pub(super) fn irradiance(&self) -> [ShVector; 3] {
        self.radiance.map(|c| {
            let first: [f32; 9] = std::array::from_fn(|i| c[i]);
            let mut all = [0.0; N];
            all[..9].copy_from_slice(&sh::irradiance::<3, 9>(&first));
            vector(&all)
        })
    }

    /// η: beyond how many of its radii a proxy takes less than ¹⁄₆₄ of the brightest irradiance.
    pub fn shadow_reach(&self, settings: &SoftGi) -> f32 {
        settings.shadow_reach.unwrap_or_else(|| {
            let (mut radiance, mut irradiance) = (0.0f32, 0.0f32);
            for i in 0..512 {
                let d = fibonacci(i, 512);
                radiance = radiance.max(self.seen(settings.order, d).max_element());
                let basis = sh::basis::<N>(d);
                for c in &self.radiance {
                    let e = sh::irradiance::<5, N>(c);
                    irradiance = irradiance.max(sh::dot(&e, &basis));
                }
            }
            // A small proxy of sine α takes π α² of its direction's radiance.
            let reach = std::f32::consts::PI * radiance / (LEAST_SHADE * irradiance);
            if reach.is_finite() { reach.sqrt().clamp(2.0, 64.0) } else { 2.0 }
        })
    }
}

/// Direction `i` of `count` evenly spread ones.
fn fibonacci(i: u32, count: u32) -> Vec3 {
    let z = 1.0 - (2.0 * i as f32 + 1.0) / count as f32;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = (2.399_963_2 * i as f32).sin_cos();
    Vec3::new(r * c, r * s, z)
}

fn vector(c: &[f32; N]) -> ShVector {
    let four = |i: usize| Vec4::new(c[i], c[i + 1], c[i + 2], c[i + 3]);
    ShVector {
        c0: four(0),
        c4: four(4),
        c8: four(8),
        c12: four(12),
        c16: four(16),
        c20: four(20),
        c24: Vec4::new(c[24], 0.0, 0.0, 0.0),
    }
}

/// ∫ radiance × basis over all directions, texel by texel of a map.
fn project(environment: &Environment) -> [[f32; N]; 3] {
    let mut out = [[0.0; N]; 3];
    match environment {
        Environment::None => {}
        Environment::Constant(radiance) => {
            for c in 0..3 {
                out[c][0] = radiance[c] * sh::UNIT;
            }
        }
        Environment::Map(map) => {
            let mut sum = [[0.0f64; N]; 3];
            let edge = |row: u32| (std::f64::consts::PI * f64::from(row) / f64::from(map.height)).cos();
            for row in 0..map.height {
                let area = std::f64::consts::TAU / f64::from(map.width) * (edge(row) - edge(row + 1));
                for column in 0..map.width {
                    let d = EnvironmentMap::direction(column, row, map.width, map.height);
                    let texel = map.data[(row * map.width + column) as usize].truncate().as_dvec3() * area;
                    add(&mut sum, &sh::basis::<N>(d), texel);
                }
            }
            for c in 0..3 {
                out[c] = sum[c].map(|x| x as f32);
            }
        }
    }
    out
}

fn add(sum: &mut [[f64; N]; 3], basis: &[f32; N], texel: DVec3) {
    for c in 0..3 {
        for i in 0..N {
            sum[c][i] += texel[c] * f64::from(basis[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn scene(environment: Environment) -> Scene {
        Scene { environment, ..Scene::default() }
    }

    #[test]
    fn low_orders_of_a_map_come_back() {
        let function = |d: Vec3| Vec3::new(1.0 + d.x, 2.0 + d.y * d.z, 1.5 + d.z);
        let map = EnvironmentMap::from_directions(128, 64, function).unwrap();
        let s = Surroundings::new(&scene(Environment::Map(map)));
        let mut worst = 0.0f32;
        for i in 0..200 {
            let d = fibonacci(i, 200);
            worst = worst.max((s.seen(3, d) - function(d)).abs().max_element());
        }
        println!("worst {worst:e}");
        assert!(worst < 3e-3, "{worst}");
        assert!((s.seen(1, Vec3::X) - function(Vec3::X)).abs().max_element() > 0.1, "negative control");
    }

    #[test]
    fn light_turns() {
        let map =
            EnvironmentMap::from_directions(64, 32, |d| Vec3::new(d.x.max(0.0), d.y.powi(2), 1.0 + d.z));
        let s = Surroundings::new(&scene(Environment::Map(map.unwrap())));
        let rotation = Mat3::from_rotation_y(0.8) * Mat3::from_rotation_x(0.3);
        let turned = s.turned(&rotation);
        for i in 0..100 {
            let d = fibonacci(i, 100);
            let (got, right) = (turned.seen(5, rotation * d), s.seen(5, d));
            assert!((got - right).abs().max_element() < 1e-5, "{got} for {right}");
            assert!(s.seen(5, rotation * d) != right, "negative control");
        }
    }

    #[test]
    fn reach_follows_the_light() {
        let even = Surroundings::new(&scene(Environment::Constant(Vec3::splat(3.0))));
        let settings = SoftGi::default();
        assert!((even.shadow_reach(&settings) - 8.0).abs() < 0.1, "{}", even.shadow_reach(&settings));
        let map =
            EnvironmentMap::from_directions(64, 32, |d| Vec3::splat(if d.y > 0.99 { 100.0 } else { 0.0 }));
        let peaked = Surroundings::new(&scene(Environment::Map(map.unwrap()))).shadow_reach(&settings);
        println!("peaked: {peaked}");
        assert!((12.0..18.0).contains(&peaked), "{peaked}");
        assert_eq!(Surroundings::new(&scene(Environment::None)).shadow_reach(&settings), 2.0);
        let fixed = SoftGi { shadow_reach: Some(5.0), ..settings };
        assert_eq!(even.shadow_reach(&fixed), 5.0);
    }
}
