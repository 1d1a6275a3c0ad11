//! Do a sphere's replacement by a surface's plane, and what it reflects, agree with the vectors, and are they continuous?

// Oracles may use what kernels may not.
#![allow(clippy::disallowed_methods)]

mod oracle;

use glam::Vec3;
use oracle::{numbers, vector_file};
use twinlight_kernels::sh::{FADE, averaged_operator, averaged_operator_fit, blocker};

fn vec3(value: &serde_json::Value) -> Vec3 {
    let n = numbers(value);
    Vec3::new(n[0] as f32, n[1] as f32, n[2] as f32)
}

#[test]
fn spheres_are_replaced_as_the_vectors_say() {
    let file = vector_file("self_shadow_rule");
    let (mut checked, mut skipped, mut naive) = (0, 0, 0.0f64);
    for case in file["cases"].as_array().unwrap() {
        let (p, n, c) = (vec3(&case["p"]), vec3(&case["n"]), vec3(&case["c"]));
        let r = case["r"].as_f64().unwrap() as f32;
        let got = blocker(c, r, p, n, FADE);
        if case["skip"].as_bool().unwrap() {
            assert_eq!(got.weight, 0.0, "{case}");
            skipped += 1;
            continue;
        }
        let want = |name: &str| case[name].as_f64().unwrap();
        assert!((f64::from(got.weight) - want("weight")).abs() < 2e-5, "{got:?} for {case}");
        assert!((f64::from(got.alpha) - want("alpha")).abs() < 2e-5, "{got:?} for {case}");
        // Close to the centre directions are ill defined, as is what is below the plane.
        assert!((got.direction - vec3(&case["dir"])).length() < 1e-3, "{got:?} for {case}");
        assert!(got.alpha <= 1.0 && got.weight >= 0.0 && got.weight <= 1.0);
        naive = naive.max((f64::from((r / (c - p).length()).min(1.0)) - want("alpha")).abs());
        checked += 1;
    }
    println!("{checked} cases, {skipped} left out");
    assert!(checked > 40 && skipped > 4);
    assert!(naive > 0.1, "negative control: the sphere itself would do");
}

#[test]
fn replacement_is_continuous() {
    // A sphere moves through the plane beside, over and around the receiver: nothing jumps.
    let n = Vec3::Z;
    // As one would write it: spheres below the plane do not count, others as a whole.
    let mut hard = 0.0f32;
    for lateral in [0.0f32, 0.3, 0.9, 1.05, 1.4, 3.0] {
        let effect = |h: f32| {
            let b = blocker(Vec3::new(lateral, 0.0, h), 1.0, Vec3::ZERO, n, FADE);
            // Solid angle counted.
            let c = ((1.0 - b.alpha) * (1.0 + b.alpha)).max(0.0).sqrt();
            b.weight * (1.0 - c)
        };
        let steps = 4_000;
        let mut worst = 0.0f32;
        for i in 0..steps {
            let at = |i: i32| effect(-1.5 + 3.0 * i as f32 / steps as f32);
            worst = worst.max((at(i) - at(i + 1)).abs());
            let cut = |i: i32| {
                let h = -1.5 + 3.0 * i as f32 / steps as f32;
                let sine = (1.0 / (lateral * lateral + h * h).sqrt().max(1.0)).min(1.0);
                if h > 0.0 { 1.0 - (1.0 - sine * sine).sqrt() } else { 0.0 }
            };
            hard = hard.max((cut(i) - cut(i + 1)).abs());
        }
        // The solid angle has an infinite slope where α = 1.
        assert!(worst < 0.06, "at {lateral} a jump of {worst}");
        assert!(effect(-1.01) == 0.0 && effect(1.4) > 0.02);
    }
    println!("cut off at the plane: a jump of {hard}");
    assert!(hard > 0.9, "{hard}");
    for odd in [f32::NAN, f32::INFINITY, 0.0, -1.0] {
        let b = blocker(Vec3::X, odd, Vec3::ZERO, n, FADE);
        assert!(b.alpha.is_finite() && b.weight.is_finite() && b.direction.is_finite(), "{odd}: {b:?}");
    }
    let same = blocker(Vec3::ZERO, 1.0, Vec3::ZERO, n, FADE);
    assert_eq!((same.alpha, same.direction), (1.0, n), "a centre on the receiver");
}

#[test]
fn the_averaged_operator_keeps_its_digits() {
    let file = vector_file("d_operator");
    let (mut worst, mut of_fit, mut printed) = (0.0f64, 0.0f64, 0.0f64);
    for case in file["cases"].as_array().unwrap() {
        let alpha = case["alpha"].as_f64().unwrap() as f32;
        let want = numbers(&case["D"]);
        let got = averaged_operator(alpha);
        let fit = averaged_operator_fit(alpha);
        // The form as printed, with its cancellation.
        let d = 1.0 / alpha.max(1e-6);
        let root = (d * d - 1.0).max(0.0).sqrt();
        let as_printed = -(3.0f32.sqrt()) * (2.0 * d * d * d - 2.0 * root * d * d - root + 1.0)
            / (6.0 * std::f32::consts::PI.sqrt() * d * (d - root));
        printed = printed.max((f64::from(as_printed) / want[1] - 1.0).abs());
        for l in 0..3 {
            worst = worst.max((f64::from(got[l]) / want[l] - 1.0).abs());
            of_fit = of_fit.max((f64::from(fit[l]) - want[l]).abs());
        }
    }
    println!("stable form {worst:.1e}, polynomials {of_fit:.1e} off");
    assert!(worst < 1e-6 && of_fit < 6e-3, "{worst}, {of_fit}");
    assert!(printed > 1e-5 || printed.is_nan(), "negative control: the printed form keeps its digits too");
}

#[test]
fn a_wider_fade_lets_less_of_an_enclosing_sphere_through() {
    // From below its middle, beside it: outside by a quarter of the radius.
    let at = |fade: f32| blocker(Vec3::new(1.25, 0.0, -0.05), 1.0, Vec3::ZERO, Vec3::Z, fade).weight;
    let weights = [0.1, 0.25, 0.5, 1.0].map(at);
    assert!(weights[0] == 1.0 && weights.windows(2).all(|w| w[0] >= w[1]) && weights[3] < 0.5, "{weights:?}");
    for odd in [0.0, -1.0, f32::NAN] {
        assert!((0.0..=1.0).contains(&at(odd)), "{odd}");
    }
}
