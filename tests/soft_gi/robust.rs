//! Do hard cases stay in range: receivers inside proxies, α → 1, heavy overlap, no proxies, no light?

use crate::support::*;
use crate::*;
use glam::Vec3;
use twinlight::scene::Environment;
use twinlight::technique::soft_gi::{Exponential, Operator};

/// Renders with every value checked; returns the largest of the picture.
fn largest(s: &Scene, settings: &SoftGi) -> f32 {
    let job = Job { check_finite: true, ..Job::default() };
    let (rendered, _) = render_on(&mut Cpu::new(Some(2)).unwrap(), s, &above(24), &job, settings);
    for n in &rendered.non_finite {
        assert_eq!(n.count, 0, "{} is not finite", n.buffer);
    }
    let dark = matches!(s.environment, Environment::None);
    assert!(dark || rendered.non_finite.len() > 4);
    let p = rendered.picture.pixels.iter().map(|p| p.max_element()).fold(0.0, f32::max);
    assert!(rendered.picture.pixels.iter().all(|p| p.min_element() >= 0.0), "negative radiance");
    p
}

fn every() -> Vec<SoftGi> {
    let mut all = Vec::new();
    for order in 2..=5 {
        for (exponential, tau) in [
            (Exponential::Hybrid, 0.5),
            (Exponential::Hybrid, 1.0),
            (Exponential::OptimalLinear, 0.5),
            (Exponential::Series, 0.5),
            (Exponential::Taylor, 0.5),
            (Exponential::Product, 0.5),
        ] {
            let operator = match order {
                2 => Operator::Point,
                3 => Operator::AveragedFit,
                4 => Operator::Averaged,
                _ => Operator::Exact,
            };
            all.push(SoftGi { order, exponential, tau, operator, receiver_scale: 2, ..SoftGi::default() });
        }
    }
    all
}

#[test]
fn hard_cases_stay_in_range() {
    let cases: Vec<(&str, Vec<Sphere>)> = vec![
        ("none", vec![]),
        ("receivers inside", vec![sphere(v(0.0, 0.3, 0.0), 2.0, 1.0)]),
        ("centre on the floor", vec![sphere(Vec3::ZERO, 1.0, 1.0)]),
        ("touching", vec![sphere(v(0.0, 1.0, 0.0), 1.0, 1.0)]),
        ("256 in one place", (0..256).map(|_| sphere(v(0.0, 1.2, 0.0), 1.0, 1.0)).collect()),
        ("tiny", vec![sphere(v(0.0, 0.5, 0.0), 1e-6, 1.0)]),
        ("enormous", vec![sphere(v(0.0, 1e6, 0.0), 9.9e5, 1.0)]),
        ("below", vec![sphere(v(0.0, -3.0, 0.0), 1.0, 1.0)]),
        ("far", vec![sphere(v(1e9, 1.0, 0.0), 1.0, 1.0)]),
    ];
    for (what, proxies) in cases {
        let mut s = floor_with(proxies);
        s.environment = Environment::Constant(Vec3::ONE);
        for settings in every() {
            let most = largest(&s, &settings);
            // A floor of albedo 1 under a sky of 1; the cheap exponentials ring most, and many products.
            let scaled = matches!(settings.exponential, Exponential::Hybrid | Exponential::Taylor);
            let robust = scaled && settings.tau <= 0.5;
            assert!(most < if robust { 1.5 } else { 2.0 }, "{what}, {settings:?}: {most}");
        }
    }
}

#[test]
fn without_light_it_is_dark_and_without_proxies_even() {
    let mut s = floor_with(vec![sphere(v(0.0, 0.6, 0.0), 0.5, 1.0)]);
    s.environment = Environment::None;
    assert_eq!(largest(&s, &fine()), 0.0);
    let mut bare = floor_with(vec![]);
    bare.environment = Environment::Constant(Vec3::splat(2.0));
    let most = largest(&bare, &fine());
    assert!((most - 2.0).abs() < 1e-3, "{most}");
}

#[test]
fn what_cannot_be_done_is_refused() {
    let s = floor_with(vec![sphere(Vec3::Y, 0.1, 1.0); 40_000]);
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let world = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
    let around = Surroundings::new(&s);
    let refused = soft_gi::render(&mut cpu, &world, &around, &above(8), &Job::default(), &fine());
    assert!(refused.err().unwrap().to_string().contains("40000 proxies"));
    let settings = SoftGi { order: 9, ..fine() };
    let refused = soft_gi::render(&mut cpu, &world, &around, &above(8), &Job::default(), &settings);
    assert!(refused.err().unwrap().to_string().contains("order"));
}
