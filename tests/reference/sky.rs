//! Light from all around: open planes, closed boxes, walls.

use crate::support::*;
use glam::Vec3;
use twinlight::backend::Cpu;
use twinlight::picture::Picture;
use twinlight::scene::{Environment, Scene};
use twinlight::technique::reference::Bounces;
use twinlight::technique::{Job, View, World, ambient_occlusion};

fn occlusion(scene: &Scene, view: &View, job: &Job) -> Picture {
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let world = World::upload(&mut cpu, scene, &tree(scene), false).unwrap();
    ambient_occlusion::render(&mut cpu, &world, view, job).unwrap().picture
}

#[test]
fn an_open_plane_reflects_the_sky_and_is_not_occluded() {
    let mut s = scene();
    square(&mut s, 0.0, 50.0, true, grey(0.6));
    s.environment = Environment::Constant(Vec3::splat(1.5));
    let view = view(&camera(v(0.0, 2.0, 2.0), v(0.3, 0.0, 0.0), 50.0), 24, 16);
    for bounces in [Bounces::Count(0), Bounces::Count(3), Bounces::All] {
        let picture = trace(&s, &view, &settings(bounces, 8)).all();
        for p in &picture.pixels {
            assert!(relative(p.x, 0.9) < 1e-6, "{p}");
            assert!(relative(p.x, 0.9 / std::f64::consts::PI) > 0.1, "negative control: π");
        }
    }
    assert!(occlusion(&s, &view, &Job::default()).pixels.iter().all(|p| *p == Vec3::ONE));
    // The plane's edge with the sky behind it: both are bright, nothing between them.
    let horizon = View { frame: camera(v(0.0, 2.0, 60.0), v(0.0, 2.0, 0.0), 50.0).frame().unwrap(), ..view };
    let picture = trace(&s, &horizon, &settings(Bounces::Count(0), 1)).all();
    let near = |p: &Vec3, x: f64| relative(p.x, x) < 1e-6;
    assert!(picture.pixels.iter().all(|p| near(p, 0.9) || near(p, 1.5)));
    assert!(picture.pixels.iter().any(|p| near(p, 0.9)) && picture.pixels.iter().any(|p| near(p, 1.5)));
}

#[test]
fn a_closed_box_is_fully_occluded_and_dark() {
    for turn in [0.0, 0.1, 0.785, 2.0] {
        let mut s = scene();
        room(&mut s, v(1.0, 0.7, 1.3), turn, grey(0.9));
        s.environment = Environment::Constant(Vec3::ONE);
        let view = view(&camera(v(0.1, -0.2, 0.3), v(0.9, 0.6, -0.4), 120.0), 96, 64);
        let picture = occlusion(&s, &view, &Job::default());
        assert!(picture.pixels.iter().all(|p| *p == Vec3::ZERO), "turn {turn}");
        let reference = trace(&s, &view, &settings(Bounces::Count(3), 8)).all();
        assert!(reference.pixels.iter().all(|p| *p == Vec3::ZERO), "turn {turn}");
        s.triangles.pop();
        let open = occlusion(&s, &view, &Job::default());
        assert!(open.pixels.iter().any(|p| *p != Vec3::ZERO), "negative control: a missing triangle");
    }
}

/// Openness of the floor at distance `d` from a long wall of height `h`, both at right angles.
fn beside_a_wall(d: f64, h: f64) -> f64 {
    1.0 - 0.5 * (1.0 - d / (d * d + h * h).sqrt())
}

/// A floor of albedo 1 with a black wall at x = 0, seen in a spot at distance `d`.
fn wall(d: f32, height: f32) -> (Scene, View) {
    let mut s = scene();
    quad(&mut s, [v(0.0, 0.0, 60.0), v(60.0, 0.0, 60.0), v(60.0, 0.0, -60.0), v(0.0, 0.0, -60.0)], grey(1.0));
    let top = [v(0.0, 0.0, 60.0), v(0.0, 0.0, -60.0), v(0.0, height, -60.0), v(0.0, height, 60.0)];
    quad(&mut s, top, grey(0.0));
    s.environment = Environment::Constant(Vec3::ONE);
    (s, view(&camera(v(d, 1.0, 0.0), v(d, 0.0, 0.0), 0.05), 8, 8))
}

#[test]
fn a_wall_takes_its_share_of_the_sky() {
    for (d, height) in [(0.5, 1.0), (1.0, 0.5), (0.05, 8.0), (0.02, 40.0)] {
        let expected = beside_a_wall(f64::from(d), f64::from(height));
        let (s, view) = wall(d, height);
        let result = trace(&s, &view, &settings(Bounces::Count(0), 4096));
        assert_mean(&format!("wall of {height} m at {d} m"), &result.statistics[0], expected, 0.02);
        let job = Job { rays: 4096, ..Job::default() };
        // Independent draws would give 4σ = 4 √(p(1 − p)/rays) at most; Halton points do better.
        let tolerance = 4.0 * (expected * (1.0 - expected) / 4096.0).sqrt();
        for p in &occlusion(&s, &view, &job).pixels {
            assert!((f64::from(p.x) - expected).abs() < tolerance, "{} for {expected}", p.x);
            assert!((f64::from(p.x) - (1.0 - expected)).abs() > tolerance || (expected - 0.5).abs() < 0.05);
        }
        if height == 40.0 {
            assert!((expected - 0.5).abs() < 1e-3, "at the foot of a high wall half the sky is left");
        }
    }
}

#[test]
fn reach_and_falloff_weigh_occluders_by_distance() {
    // A ceiling 2 m above: λ = 1 leaves about 1 − E[1/(1 + 2/cos)] open, a reach of 1.9 m everything.
    let mut s = scene();
    square(&mut s, 0.0, 40.0, true, grey(1.0));
    square(&mut s, 2.0, 40.0, false, grey(1.0));
    let view = view(&camera(v(0.0, 1.0, 0.0), Vec3::ZERO, 1.0), 4, 4);
    let job = Job { rays: 4096, ..Job::default() };
    let mean = |job: &Job| f64::from(occlusion(&s, &view, job).mean().x);
    assert!(mean(&job) < 0.01, "almost closed: {}", mean(&job));
    assert_eq!(mean(&Job { reach: 1.9, ..job.clone() }), 1.0);
    // Mean of 1/(1 + λ h/c) = c/(c + λ h) over the density 2c dc.
    let quadrature = |lambda: f64| {
        let n = 100_000;
        let sum: f64 = (0..n)
            .map(|i| (f64::from(i) + 0.5) / f64::from(n))
            .map(|c| 2.0 * c * c / (c + 2.0 * lambda))
            .sum();
        1.0 - sum / f64::from(n)
    };
    for lambda in [0.25f32, 1.0, 4.0] {
        let got = mean(&Job { falloff: lambda, ..job.clone() });
        let expected = quadrature(f64::from(lambda));
        assert!((got - expected).abs() < 5e-3, "λ = {lambda}: {got}, expected {expected}");
        assert!((got - quadrature(1.2 * f64::from(lambda))).abs() > 5e-3, "negative control");
    }
}
