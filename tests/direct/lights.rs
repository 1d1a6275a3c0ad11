//! Lights without extent: the technique against the path tracer, and many lights against one by one.

use crate::support::*;
use crate::{direct_light, openness};
use glam::Vec3;
use twinlight::picture::Picture;
use twinlight::scene::{BUILT_IN, Environment, Scene, light};
use twinlight::technique::Job;
use twinlight::technique::reference::{Bounces, Reference};

/// A built-in with one light of each kind.
fn lit(name: &str) -> Scene {
    let mut s = Scene::open(name).unwrap();
    s.environment = Environment::None;
    let along = v(-0.2, -1.0, -0.3).normalize();
    s.lights.push(light::spot(v(0.5, 1.9, 0.6), along, v(3.0, 2.0, 1.0), 0.3, 0.6));
    s.lights.push(light::sun(v(0.3, -0.5, -1.0).normalize(), v(0.4, 0.5, 0.9)));
    s
}

#[test]
fn the_technique_is_the_path_tracer_without_bounces() {
    for (name, tolerance) in [("cornell-box", 1e-5), ("cornell-glossy", 1e-5), ("spheres", 1e-5)] {
        let s = lit(name);
        let view = view(&s.view(), 160, 120);
        let technique = direct_light(&s, &view, &Job::default(), false);
        let reference = Reference { emissive: false, ..settings(Bounces::Count(0), 1) };
        let right = trace(&s, &view, &reference).all();
        let (worst, at) = difference(&technique, &right);
        println!("{name}: largest relative difference {worst:e}");
        assert!(
            worst < tolerance,
            "{name}, pixel {at}: {} and {}, {worst:e}",
            technique.pixels[at],
            right.pixels[at]
        );
        assert!(right.mean().min_element() > 0.01);
        for fault in 0..s.lights.len() {
            let mut faulty = s.clone();
            faulty.lights[fault].intensity *= 1.0001;
            let worst = difference(&technique, &trace(&faulty, &view, &reference).all()).0;
            assert!(worst > tolerance, "{name}: negative control: light {fault} 0.01 % brighter");
        }
    }
}

#[test]
fn forty_lights_are_the_sum_of_forty_pictures() {
    for name in ["cornell-box", "cornell-glossy"] {
        let mut s = Scene::open(name).unwrap();
        s.lights = (0..40)
            .map(|i| {
                let (a, b) = (i as f32 * 0.618 % 1.0, i as f32 * 0.414 % 1.0);
                let at = v(1.8 * a - 0.9, 1.9 - 0.4 * b, 1.8 * b - 0.9);
                light::point(at, v(0.05 + 0.01 * i as f32, 0.1, 0.2))
            })
            .collect();
        let view = view(&s.view(), 80, 60);
        let together = direct_light(&s, &view, &Job::default(), false);
        let mut sums = vec![glam::DVec3::ZERO; together.pixels.len()];
        let mut without_33 = sums.clone();
        for (i, light) in s.lights.iter().enumerate() {
            let one = Scene { lights: vec![*light], ..s.clone() };
            for (k, p) in direct_light(&one, &view, &Job::default(), false).pixels.iter().enumerate() {
                sums[k] += p.as_dvec3();
                without_33[k] += if i == 33 { glam::DVec3::ZERO } else { p.as_dvec3() };
            }
        }
        let picture = |sums: &[glam::DVec3]| Picture {
            pixels: sums.iter().map(|s| s.as_vec3()).collect(),
            ..together.clone()
        };
        let worst = difference(&together, &picture(&sums)).0;
        assert!(worst < 1e-5, "{name}: {worst}");
        assert!(difference(&together, &picture(&without_33)).0 > 1e-3, "negative control: one light missing");
    }
}

#[test]
fn the_sky_and_emissive_surfaces_agree_with_the_path_tracer_in_the_mean() {
    for name in ["cornell-box", "spheres"] {
        let mut s = Scene::open(name).unwrap();
        s.lights.clear();
        if name == "cornell-box" {
            s.environment = Environment::Constant(v(0.2, 0.3, 0.4));
        }
        let view = view(&s.view(), 64, 48);
        let got = direct_light(&s, &view, &Job { rays: 256, ..Job::default() }, true).mean();
        let right = trace(&s, &view, &settings(Bounces::Count(0), 256)).statistics[0];
        let off =
            (f64::from(got.element_sum()) / 3.0 - right.mean.element_sum() / 3.0) / right.standard_error;
        println!("{name}: {got}, {} ± {}: {off:.2} sigma", right.mean, right.standard_error);
        // The technique's own rays err as much as the path tracer's.
        assert!(off.abs() < 4.0 * 2f64.sqrt(), "{name}: {got} is {off} sigma from {}", right.mean);
        let dark = direct_light(&s, &view, &Job { rays: 256, ..Job::default() }, false).mean();
        if name == "cornell-box" {
            let off = f64::from(dark.x) - right.mean.x;
            assert!(off.abs() > 6.0 * right.standard_error, "negative control: no emission");
        }
    }
}

#[test]
fn nothing_is_written_that_is_not_finite() {
    for name in BUILT_IN {
        let s = lit(name);
        let view = view(&s.view(), 64, 48);
        let mut cpu = twinlight::backend::Cpu::new(Some(2)).unwrap();
        let world = twinlight::technique::World::upload(&mut cpu, &s, &tree(&s), true).unwrap();
        let job = Job { rays: 4, check_finite: true, ..Job::default() };
        let rendered = twinlight::technique::direct::render(&mut cpu, &world, &view, &job).unwrap();
        assert!(rendered.non_finite.len() >= 3, "{:?}", rendered.non_finite);
        assert!(rendered.non_finite.iter().all(|n| n.count == 0), "{:?}", rendered.non_finite);
    }
    // Negative control: a light of infinite intensity is found.
    let mut s = lit("cornell-box");
    s.lights[0].intensity = Vec3::INFINITY.extend(0.0);
    let view = view(&s.view(), 16, 16);
    let mut cpu = twinlight::backend::Cpu::new(Some(2)).unwrap();
    let world = twinlight::technique::World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
    let job = Job { check_finite: true, ..Job::default() };
    let rendered = twinlight::technique::direct::render(&mut cpu, &world, &view, &job).unwrap();
    assert!(rendered.non_finite.iter().any(|n| n.count > 0));
}

#[test]
fn a_scene_without_surfaces_in_view_is_background() {
    let mut s = Scene::open("cornell-box").unwrap();
    s.environment = Environment::Constant(v(0.1, 0.2, 0.3));
    let view = view(&camera(v(0.0, 1.0, 3.0), v(0.0, 1.0, 9.0), 40.0), 8, 8);
    let picture = direct_light(&s, &view, &Job::default(), true);
    assert!(picture.pixels.iter().all(|p| *p == v(0.1, 0.2, 0.3)));
    assert!(openness(&s, &view, &Job::default()).pixels.iter().all(|p| *p == Vec3::ONE));
}
