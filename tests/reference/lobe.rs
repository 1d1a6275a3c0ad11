//! The glossy lobe: quadrature in double precision against scattered paths, and no more energy than arrives.

use crate::support::*;
use glam::{DVec3, Vec3};
use std::f64::consts::{PI, TAU};
use twinlight::scene::{Environment, EnvironmentMap, Scene};
use twinlight::technique::View;
use twinlight::technique::reference::Bounces;
use twinlight_kernels::passes::scene::Material;

/// Phong exponent, specular colour and diffuse albedo by the mapping that the conventions document.
fn mapping(m: &Material) -> (f64, f64, f64) {
    let (base, metallic, roughness) = (f64::from(m.base.x), f64::from(m.metallic), f64::from(m.roughness));
    let fourth = roughness.powi(4).max(2.0 / 1026.0);
    let gloss = 1.0 - fourth;
    let dielectric = 0.04 * (1.0 - metallic);
    (
        2.0 / fourth - 2.0,
        gloss * (dielectric + metallic * base),
        base * (1.0 - gloss * (metallic + dielectric)),
    )
}

/// Radiance toward `viewer` of a floor under a sky, by the midpoint rule over the hemisphere.
fn quadrature(m: &Material, viewer: DVec3, sky: &Environment, with_norm: bool) -> f64 {
    let (exponent, specular, diffuse) = mapping(m);
    let mirror = DVec3::new(-viewer.x, viewer.y, -viewer.z);
    let norm = if with_norm { exponent + 2.0 } else { exponent + 1.0 };
    let (rings, sectors) = (900, 1800);
    let mut sum = 0.0;
    for i in 0..rings {
        let theta = (f64::from(i) + 0.5) / f64::from(rings) * PI / 2.0;
        let (sin, cos) = theta.sin_cos();
        for j in 0..sectors {
            let (s, c) = ((f64::from(j) + 0.5) / f64::from(sectors) * TAU).sin_cos();
            let to_light = DVec3::new(sin * c, cos, sin * s);
            let lobe = norm / TAU * mirror.dot(to_light).max(0.0).powf(exponent);
            let radiance = f64::from(sky.radiance(to_light.as_vec3()).x);
            sum += (diffuse / PI + specular * lobe) * radiance * cos * sin;
        }
    }
    sum * (PI / 2.0 / f64::from(rings)) * (TAU / f64::from(sectors))
}

/// A floor under a sky, seen through one pencil of rays from `viewer`.
fn floor(m: Material, sky: &Environment, viewer: Vec3) -> (Scene, View) {
    let mut s = scene();
    square(&mut s, 0.0, 20.0, true, m);
    s.environment = sky.clone();
    (s, view(&camera(viewer * 3.0, Vec3::ZERO, 0.05), 16, 16))
}

/// Bright on one side, so that a lobe in the wrong place shows.
fn uneven_sky() -> Environment {
    let radiance = |d: Vec3| Vec3::splat(1.0 + d.x + 0.5 * d.z * d.z);
    Environment::Map(EnvironmentMap::from_directions(128, 64, radiance).unwrap())
}

#[test]
fn scattered_paths_find_what_quadrature_finds() {
    let dielectric = Material { roughness: 0.5, ..grey(0.5) };
    let half_metal = Material { metallic: 0.5, roughness: 0.6, ..grey(0.7) };
    let materials = [("dielectric", dielectric), ("half metal", half_metal), ("metal", metal(0.9, 0.5))];
    for (name, m) in materials {
        for (sky_name, sky) in [("white", Environment::Constant(Vec3::ONE)), ("uneven", uneven_sky())] {
            for viewer in [v(0.0, 1.0, 0.0), v(1.0, 1.0, 0.2).normalize(), v(1.0, 0.25, 0.0).normalize()] {
                let (s, view) = floor(m, &sky, viewer);
                let result = trace(&s, &view, &settings(Bounces::Count(0), 512));
                let expected = quadrature(&m, viewer.as_dvec3(), &sky, true);
                let what = format!("{name} under {sky_name} sky from {viewer}");
                assert_mean(&what, &result.statistics[0], expected, 0.08);
            }
        }
    }
    // Negative control: the lobe's other norm, (n + 1)/2π, is a different answer.
    let sky = Environment::Constant(Vec3::ONE);
    let (m, up) = (metal(0.9, 0.5), Vec3::Y);
    let (s, view) = floor(m, &sky, up);
    let result = trace(&s, &view, &settings(Bounces::Count(0), 512));
    assert!(sigmas(&result.statistics[0], quadrature(&m, DVec3::Y, &sky, false)) > 4.0);
}

#[test]
fn seen_straight_on_the_lobe_reflects_its_whole_colour() {
    let sky = Environment::Constant(Vec3::ONE);
    for roughness in [0.1, 0.3, 0.7, 0.95] {
        let m = Material { metallic: 0.3, roughness, ..grey(0.8) };
        let (s, view) = floor(m, &sky, Vec3::Y);
        let result = trace(&s, &view, &settings(Bounces::Count(0), 512));
        let (_, specular, diffuse) = mapping(&m);
        assert_mean(&format!("roughness {roughness}"), &result.statistics[0], specular + diffuse, 0.02);
    }
}

#[test]
fn a_glossy_furnace_gains_no_energy() {
    let inside = |m: Material| {
        let mut s = scene();
        room(&mut s, v(1.0, 0.7, 1.3), 0.3, Material { emission: Vec3::ONE.extend(0.0), ..m });
        let view = view(&camera(v(0.1, -0.2, 0.3), v(0.9, 0.6, -0.4), 110.0), 48, 32);
        trace(&s, &view, &settings(Bounces::Count(8), 128)).statistics[2]
    };
    let bound = |albedo: f64| (1.0 - albedo.powi(10)) / (1.0 - albedo);
    for roughness in [0.05, 0.25, 0.5, 0.8] {
        for metallic in [0.0, 0.5, 1.0] {
            let m = Material { metallic, ..metal(0.8, roughness) };
            let (_, specular, diffuse) = mapping(&m);
            let s = inside(m);
            let most = bound(specular + diffuse);
            assert!(s.mean.x <= most + 4.0 * s.standard_error + 1e-5 * most, "{s:?} exceeds {most}");
            assert!(
                s.mean.x >= bound(diffuse) - 4.0 * s.standard_error - 1e-5,
                "{s:?} lacks the diffuse part"
            );
        }
    }
    // Negative control: a surface that reflects a tenth more exceeds the bound of the one it claims to be.
    let (claimed, actual) = (metal(0.8, 0.8), metal(0.88, 0.8));
    let (_, specular, diffuse) = mapping(&Material { metallic: 0.0, ..claimed });
    let s = inside(Material { metallic: 0.0, ..actual });
    assert!(s.mean.x > bound(specular + diffuse) + 4.0 * s.standard_error, "{s:?}");
}
