//! Does the ray–disc test decide as exact arithmetic does, in the hard cases too?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

mod oracle;
#[path = "oracle/random.rs"]
mod random;
#[path = "oracle/vector64.rs"]
mod vector64;

use glam::Vec3;
use oracle::{numbers, vector_file};
use random::{Random, SPECIAL};
use twinlight_kernels::geometry::disc::{DiscHit, ray_disc};
use vector64::exact;

fn vec3(value: &serde_json::Value) -> Vec3 {
    let v = numbers(value);
    Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
}

/// The textbook test, p = o + td: the planted fault.
fn naive(o: Vec3, d: Vec3, c: Vec3, n: Vec3, r: f32, t_min: f32, t_max: f32) -> DiscHit {
    let t = (c - o).dot(n) / d.dot(n);
    let p = o + d * t;
    DiscHit { hit: t >= t_min && t <= t_max && (p - c).dot(p - c) <= r * r, t }
}

type Test = fn(Vec3, Vec3, Vec3, Vec3, f32, f32, f32) -> DiscHit;

/// Cases of the vector file that a test gets wrong, and its largest relative error of t.
fn wrong_cases(test: Test) -> (Vec<String>, f64) {
    let file = vector_file("ray_disc");
    let cases = file["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 65);
    let mut wrong = Vec::new();
    let mut worst = 0.0f64;
    for case in cases {
        let number = |name: &str| case[name].as_f64().expect(name) as f32;
        let got = test(
            vec3(&case["origin"]),
            vec3(&case["dir"]),
            vec3(&case["center"]),
            vec3(&case["normal"]),
            number("radius"),
            number("tmin"),
            number("tmax"),
        );
        if got.hit != case["hit"].as_bool().expect("hit") {
            wrong.push(case["tag"].to_string());
        } else if got.hit {
            let t = case["t"].as_f64().expect("t");
            worst = worst.max((f64::from(got.t) - t).abs() / t.abs().max(1e-300));
        }
    }
    (wrong, worst)
}

#[test]
fn all_vectors_are_decided_exactly() {
    let (wrong, worst) = wrong_cases(ray_disc);
    println!("t error {worst:e}");
    assert!(wrong.is_empty(), "{wrong:?}");
    assert!(worst <= 5e-7, "{worst:e}");
    let (wrong, _) = wrong_cases(naive);
    println!("the naive test fails at {wrong:?}");
    assert!(!wrong.is_empty(), "the planted fault was not seen");
}

#[test]
fn hits_agree_with_float64_away_from_the_rim() {
    let mut random = Random::new(1);
    let (mut hits, mut worst) = (0, 0.0f64);
    for _ in 0..200_000 {
        let scale = random.log_uniform(1e-6, 1e6).abs();
        let (origin, center) = (random.point(scale), random.point(scale));
        let radius = scale * random.range(0.01, 1.0);
        let normal = random.direction();
        let direction = (center + random.point(radius) - origin) * random.log_uniform(1e-12, 1e12).abs();
        let got = ray_disc(origin, direction, center, normal, radius, 0.0, 3e38);
        let (d, n, v) = (exact(direction), exact(normal), exact(center) - exact(origin));
        let den = d.dot(n);
        if den.abs() < 2e-3 * d.length() * n.length() {
            continue;
        }
        let t = v.dot(n) / den;
        let margin = f64::from(radius) - (d * t - v).length();
        let noise = 16.0 * 2f64.powi(-24) * (v.length() + t.abs() * d.length()) / (den.abs() / d.length());
        if margin.abs() > noise.max(1e-5 * f64::from(radius))
            && t.abs() * d.length() > 1e-6 * f64::from(scale)
        {
            assert_eq!(
                got.hit,
                margin > 0.0 && t >= 0.0,
                "{origin:?} {direction:?} {center:?} {normal:?} {radius}"
            );
        }
        if got.hit {
            hits += 1;
            let condition = v.length() / v.dot(n).abs();
            worst = worst.max((f64::from(got.t) - t).abs() / t / condition.max(d.length() / den.abs()));
        }
    }
    println!("{hits} hits, t error {worst:e} of the condition");
    assert!(hits > 20_000 && worst < 5e-7);
}

#[test]
fn scaling_the_direction_and_turning_the_normal_change_nothing() {
    let mut random = Random::new(2);
    let (mut hits, mut moved) = (0, 0.0f32);
    for _ in 0..50_000 {
        let (origin, center, normal) = (random.point(1.0), random.point(1.0), random.direction());
        let direction = center + random.point(0.4) - origin;
        let test = |d: Vec3, n: Vec3| ray_disc(origin, d, center, n, 0.3, 0.0, 3e38);
        let base = test(direction, normal);
        let turned = test(direction, normal * -1.0);
        assert_eq!((base.hit, base.t), (turned.hit, turned.t));
        for k in [2f32.powi(-70), 0.25, 8.0, 2f32.powi(80)] {
            let scaled = test(direction * k, normal);
            assert_eq!(base.hit, scaled.hit);
            assert_eq!(base.t.to_bits(), (scaled.t * k).to_bits());
        }
        if base.hit {
            hits += 1;
            let k = random.log_uniform(1e-3, 1e3).abs();
            let scaled = test(direction * k, normal);
            let ahead = direction.normalize().dot(normal).abs();
            if scaled.hit && ahead > 0.2 && base.t > 0.2 {
                moved = moved.max((scaled.t * k - base.t).abs() / (base.t * 2f32.powi(-23)) * ahead);
            }
        }
    }
    println!("{hits} hits, other scales move t by {moved} ULP of the condition");
    assert!(hits > 5_000 && moved <= 4.0);
}

#[test]
fn any_input_gives_a_finite_answer() {
    let mut random = Random::new(3);
    let mut hits = 0;
    for _ in 0..100_000 {
        let mut values = [0.0f32; 15];
        for v in &mut values {
            *v = if random.below(4) == 0 {
                SPECIAL[random.below(SPECIAL.len() as u32) as usize]
            } else {
                random.log_uniform(1e-20, 1e20)
            };
        }
        let v = |i: usize| Vec3::new(values[i], values[i + 1], values[i + 2]);
        let h = ray_disc(v(0), v(3), v(6), v(9), values[12], values[13], values[14]);
        assert!(h.t.is_finite());
        assert!(h.hit || h.t == 0.0);
        let bad = values[..13].iter().any(|x| x.is_nan());
        assert!(!(h.hit && bad), "{values:?}");
        hits += u32::from(h.hit);
    }
    println!("{hits} hits");
}
