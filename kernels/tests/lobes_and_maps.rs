//! Are lobe directions, gathering weights and octahedral maps right where the plain formulas lose digits or divide by 0?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/draw.rs"]
mod draw;

use draw::Draw;
use glam::{Vec2, Vec3};
use twinlight_kernels::gaussian::gathering_weights;
use twinlight_kernels::passes::light_map::{octahedron_direction, octahedron_point};
use twinlight_kernels::sampling::hemisphere::phong_lobe_direction;

/// sin θ of the lobe's direction for u, in double precision.
fn sine(u: f32, exponent: f32) -> f64 {
    let log_cosine = (1.0 - f64::from(u)).ln() / (f64::from(exponent) + 1.0);
    (-(2.0 * log_cosine).exp_m1()).sqrt()
}

#[test]
fn narrow_lobes_keep_their_digits() {
    let mut draw = Draw::new(41);
    let (mut worst, mut worst_naive) = (0.0f64, 0.0f64);
    for _ in 0..100_000 {
        let exponent = draw.log_uniform(1e-3, 1e5);
        let u = Vec2::new(draw.uniform(0.0, 0.999), draw.uniform(0.0, 1.0));
        let d = phong_lobe_direction(u, exponent);
        assert!((d.length() - 1.0).abs() < 5e-7 && d.z >= 0.0, "{d} of {u}, {exponent}");
        let expected = sine(u.x, exponent);
        if expected < 1e-4 {
            continue;
        }
        let got = f64::from(d.x).hypot(f64::from(d.y));
        worst = worst.max((got / expected - 1.0).abs());
        let cosine = (1.0 - u.x).powf(1.0 / (exponent + 1.0));
        let naive = f64::from((1.0 - cosine * cosine).max(0.0).sqrt());
        worst_naive = worst_naive.max((naive / expected - 1.0).abs());
    }
    println!("sine of the lobe's direction: {worst:.1e} here, {worst_naive:.1e} by 1 − cos²");
    assert!(worst < 4e-7, "{worst}");
    assert!(worst_naive > 1e-2, "negative control: {worst_naive}");
    // Mean cosine (n + 1)/(n + 2), and the ends.
    for exponent in [0.0f32, 10.0, 50.0, 1024.0] {
        let n = 4_096;
        let mean: f64 = (0..n)
            .map(|i| f64::from(phong_lobe_direction(Vec2::new((i as f32 + 0.5) / n as f32, 0.3), exponent).z))
            .sum::<f64>()
            / f64::from(n);
        let e = f64::from(exponent);
        assert!((mean - (e + 1.0) / (e + 2.0)).abs() < 1e-4, "{mean} for {exponent}");
    }
    for u in [0.0, 1.0, -3.0, 2.0, f32::NAN, f32::INFINITY] {
        for exponent in [0.0, -1.0, 1e30, f32::NAN, f32::INFINITY] {
            let d = phong_lobe_direction(Vec2::new(u, u), exponent);
            assert!(d.is_finite(), "{d} of {u}, {exponent}");
        }
    }
}

#[test]
fn gathering_weights_sum_to_one_or_none_exist() {
    let mut draw = Draw::new(42);
    let (mut fallbacks, mut left_out, mut naive_fails) = (0, 0, 0);
    for _ in 0..50_000 {
        let (s, t) = (draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0));
        let bilinear = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        let own = Vec3::from_array(draw.direction());
        let mut distance = [0.0; 4];
        let mut normal = [own; 4];
        for i in 0..4 {
            distance[i] = draw.log_uniform(1e-6, 1e3);
            match draw.bits() % 4 {
                0 => normal[i] = Vec3::ZERO,
                1 => normal[i] = Vec3::from_array(draw.direction()),
                _ => {}
            }
        }
        let weights = gathering_weights(&bilinear, &distance, &normal, own, 0.01, 0.1);
        let exists = normal.iter().any(|n| *n != Vec3::ZERO);
        let sum: f64 = weights.iter().map(|&w| f64::from(w)).sum();
        assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)), "{weights:?}");
        assert!((sum - if exists { 1.0 } else { 0.0 }).abs() < 3e-7, "{weights:?} sum to {sum}");
        assert!(
            (0..4).all(|i| normal[i] != Vec3::ZERO || weights[i] == 0.0),
            "{weights:?}: weight of nothing"
        );
        // The formula as printed, in single precision.
        let printed: f32 = (0..4)
            .filter(|&i| normal[i] != Vec3::ZERO)
            .map(|i| {
                let (d, n) = (distance[i] / 0.01, (1.0 - normal[i].dot(own)) / 0.1);
                bilinear[i] * (-0.5 * d * d).exp() * (-0.5 * n * n).exp()
            })
            .sum();
        naive_fails += u32::from(exists && (printed <= 0.0 || printed.is_nan()));
        fallbacks += u32::from(weights.iter().filter(|&&w| w == 1.0).count() == 1);
        left_out += u32::from(weights.iter().any(|&w| w > 0.0 && w < 1e-3));
    }
    assert!(fallbacks > 100 && left_out > 10, "{fallbacks} {left_out}");
    assert!(
        naive_fails > 1_000,
        "negative control: the printed formula divides by 0 in {naive_fails} cases only"
    );
    let same = gathering_weights(&[0.1, 0.2, 0.3, 0.4], &[0.0; 4], &[Vec3::X; 4], Vec3::X, 0.01, 0.1);
    for (w, b) in same.into_iter().zip([0.1f32, 0.2, 0.3, 0.4]) {
        assert!((w - b).abs() < 1e-6, "alike neighbours: bilinear");
    }
}

#[test]
fn octahedral_maps_come_back() {
    let mut draw = Draw::new(43);
    let mut worst = 0.0f32;
    for i in 0..50_000 {
        let mut d = Vec3::from_array(draw.direction());
        if i % 8 == 0 {
            d[i / 8 % 3] = 0.0;
        }
        let d = d.normalize_or(Vec3::X);
        let p = octahedron_point(d * draw.log_uniform(1e-6, 1e6));
        assert!(p.abs().max_element() <= 1.0, "{p} of {d}");
        worst = worst.max((octahedron_direction(p.x, p.y) - d).length());
    }
    assert!(worst < 1e-6, "{worst}");
    // Negative control: without folding the lower half it does not.
    let below = Vec3::new(0.6, 0.0, -0.8);
    let sum = below.abs().element_sum();
    assert!((octahedron_direction(below.x / sum, below.y / sum) - below).length() > 0.5);
    assert_eq!(octahedron_point(Vec3::ZERO), Vec2::ZERO);
    assert!(octahedron_direction(1.0, 1.0).is_finite() && octahedron_point(Vec3::NEG_Z).abs() == Vec2::ONE);
}
