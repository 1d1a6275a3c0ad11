//! Do bilateral weights sum to one, and fall back where nothing matches?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/draw.rs"]
mod draw;

use draw::{Draw, EDGES};
use glam::Vec3;
use twinlight_kernels::gaussian::*;

const EPS: f64 = 1.0 / 16_777_216.0;

fn unit(draw: &mut Draw) -> Vec3 {
    Vec3::from_array(draw.direction())
}

#[test]
fn upsampling_weights_sum_to_one_and_fall_back() {
    let mut draw = Draw::new(28);
    let (mut worst_sum, mut worst_bilinear, mut worst_truth) = (0.0f64, 0.0f64, 0.0f64);
    let mut fallbacks = 0;
    for _ in 0..50_000 {
        let (s, t) = (draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0));
        let bilinear = [(1.0 - s) * (1.0 - t), s * (1.0 - t), (1.0 - s) * t, s * t];
        let (normal, depth) = (unit(&mut draw), draw.log_uniform(1e-3, 1e4));
        let same = CoarseSamples { bilinear, depth: [depth; 4], normal: [normal; 4] };
        let weights = upsampling_weights(&same, depth, normal);
        let total: f64 = bilinear.iter().map(|&b| f64::from(b)).sum();
        for i in 0..4 {
            worst_bilinear =
                worst_bilinear.max((f64::from(weights[i]) - f64::from(bilinear[i]) / total).abs() / EPS);
        }
        let mut samples = same;
        for i in 0..4 {
            samples.depth[i] = depth * draw.uniform(0.9, 1.1);
            samples.normal[i] = if draw.bits().is_multiple_of(4) { -normal } else { unit(&mut draw) };
        }
        let weights = upsampling_weights(&samples, depth, normal);
        assert!(weights.iter().all(|w| (0.0..=1.0).contains(w)));
        worst_sum = worst_sum.max((weights.iter().map(|&w| f64::from(w)).sum::<f64>() - 1.0).abs() / EPS);
        if weights.iter().filter(|&&w| w == 1.0).count() == 1
            && weights.iter().filter(|&&w| w == 0.0).count() == 3
        {
            fallbacks += 1;
            continue;
        }
        let truth: Vec<f64> = (0..4)
            .map(|i| {
                let cosine: f64 =
                    (0..3).map(|c| f64::from(normal[c]) * f64::from(samples.normal[i][c])).sum();
                let z = 1e-3 * f64::from(depth) + (f64::from(depth) - f64::from(samples.depth[i])).abs();
                f64::from(bilinear[i]) * cosine.clamp(0.0, 1.0).powi(32) / z
            })
            .collect();
        let sum: f64 = truth.iter().sum();
        for i in 0..4 {
            worst_truth = worst_truth.max((f64::from(weights[i]) - truth[i] / sum).abs());
        }
    }
    println!(
        "sum {worst_sum:.2} eps, bilinear {worst_bilinear:.2} eps, truth {worst_truth:.2e}, {fallbacks} fallbacks"
    );
    assert!(worst_sum <= 4.0 && worst_bilinear <= 4.0);
    // 32nd powers of a rounded dot product.
    assert!(worst_truth <= 2e-5);
    assert!(fallbacks > 100);
}

#[test]
fn upsampling_handles_opposite_missing_and_distant_samples() {
    let opposite = CoarseSamples { bilinear: [0.25; 4], depth: [2.0, 1.5, 1.5, 3.0], normal: [-Vec3::Z; 4] };
    assert_eq!(upsampling_weights(&opposite, 1.0, Vec3::Z), [0.0, 1.0, 0.0, 0.0]);
    assert_eq!((-1.0f32).powi(32), 1.0, "planted fault: an unclamped cosine would weigh 1");
    assert_eq!(normal_similarity(Vec3::Z, -Vec3::Z), 0.0);
    let missing = CoarseSamples { normal: [Vec3::ZERO; 4], ..opposite };
    assert_eq!(upsampling_weights(&missing, 1.0, Vec3::Z), [0.0; 4]);
    let one = CoarseSamples { normal: [Vec3::ZERO, Vec3::ZERO, Vec3::ZERO, -Vec3::Z], ..opposite };
    assert_eq!(upsampling_weights(&one, 1.0, Vec3::Z), [0.0, 0.0, 0.0, 1.0]);
    for scale in [1e-6f32, 1.0, 1e6] {
        let samples = CoarseSamples {
            bilinear: [0.25; 4],
            depth: [scale, 1.1 * scale, 1.2 * scale, 1.3 * scale],
            normal: [Vec3::Z; 4],
        };
        let weights = upsampling_weights(&samples, scale, Vec3::Z);
        assert!((weights[0] - 0.982).abs() < 2e-3, "scale {scale}: {weights:?}");
    }
    assert!((normal_similarity(Vec3::Z, Vec3::new(0.5, 0.0, 3f32.sqrt() / 2.0)) - 1.002e-2).abs() < 1e-5);
    for x in EDGES {
        for y in EDGES {
            let samples =
                CoarseSamples { bilinear: [x, y, 0.5, 0.5], depth: [y, x, x, y], normal: [Vec3::X; 4] };
            let weights = upsampling_weights(&samples, x, Vec3::X);
            assert!(weights.iter().all(|w| w.is_finite() && *w >= 0.0), "{x:e} {y:e}: {weights:?}");
            for value in [gaussian_falloff(x, y), geometric_weight(x, y, x, y), depth_similarity(x, y)] {
                assert!(value.is_finite() && value >= 0.0, "{x:e} {y:e}: {value}");
            }
        }
    }
}

#[test]
fn visibility_is_shared_symmetrically_and_with_oneself() {
    let mut draw = Draw::new(29);
    for _ in 0..50_000 {
        let (a, b) = (unit(&mut draw), unit(&mut draw));
        let (za, zb) = (draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0));
        let dot = twinlight_kernels::math::dot;
        let limits = (draw.uniform(0.0, 0.5), draw.uniform(-1.0, 1.0));
        let forward = shares_visibility(za - zb, dot(a, b), limits.0, limits.1);
        assert_eq!(forward, shares_visibility(zb - za, dot(b, a), limits.0, limits.1));
        assert_eq!(forward, (za - zb).abs() <= limits.0 && dot(a, b) >= limits.1);
        assert!(shares_visibility(0.0, dot(a, a), 0.0, 1.0), "a pixel accepts itself");
    }
    assert!(!shares_visibility(f32::NAN, 1.0, 1.0, 0.0));
    assert!(!shares_visibility(0.0, f32::NAN, 1.0, 0.0));
    assert!(shares_visibility(0.25, 0.5, 0.25, 0.5), "limits are inclusive");
    assert_eq!(mean_or_zero(Vec3::ONE, 0.0), Vec3::ZERO);
    assert_eq!(mean_or_zero(Vec3::ONE, 2.0), Vec3::splat(0.5));
    assert!((gaussian_falloff(1.0, 1.0) - (-0.5f32).exp()).abs() < 1e-7);
}

#[test]
fn planes_are_told_by_the_angle_over_them() {
    let mut draw = Draw::new(91);
    for _ in 0..20_000 {
        let normal = unit(&mut draw);
        let across = normal.any_orthonormal_vector();
        let (angle, scale) = (draw.uniform(0.0, 0.4), draw.log_uniform(1e-6, 1e6));
        let apart = (across * angle.cos() + normal * angle.sin()) * scale;
        let right = (1.0 - 16.0 * f64::from(angle).sin().powi(2)).max(0.0);
        let got = f64::from(plane_similarity(apart, normal));
        assert!((got - right).abs() < 1e-5, "{angle} at {scale}: {got} for {right}");
        // Planted fault: a scale in metres instead of an angle would depend on the unit.
        assert_eq!(plane_similarity(apart * 4.0, normal), plane_similarity(apart, normal));
    }
    assert_eq!(plane_similarity(Vec3::ZERO, Vec3::Y), 1.0, "a point and itself");
    assert_eq!(plane_similarity(Vec3::Y, Vec3::Y), 0.0);
}

#[test]
fn weights_by_place_skip_what_has_no_surface() {
    let all = CoarseSamples { bilinear: [0.1, 0.2, 0.3, 0.4], depth: [1.0; 4], normal: [Vec3::Z; 4] };
    assert_eq!(place_weights(&all, true), [0.0, 0.0, 0.0, 1.0]);
    for (got, want) in place_weights(&all, false).iter().zip(all.bilinear) {
        assert!((got - want).abs() < 1.0e-6);
    }
    let some = CoarseSamples { normal: [Vec3::Z, Vec3::X, Vec3::ZERO, Vec3::ZERO], ..all };
    assert_eq!(place_weights(&some, true), [0.0, 1.0, 0.0, 0.0]);
    let weights = place_weights(&some, false);
    assert!((weights[0] - 1.0 / 3.0).abs() < 1.0e-6 && weights[2] == 0.0, "{weights:?}");
    assert_eq!(place_weights(&CoarseSamples { normal: [Vec3::ZERO; 4], ..all }, false), [0.0; 4]);
    // Where the only one with a surface has no weight, it stands for all the same.
    let normal = [Vec3::ZERO, Vec3::Z, Vec3::ZERO, Vec3::ZERO];
    let edge = CoarseSamples { bilinear: [1.0, 0.0, 0.0, 0.0], normal, ..all };
    assert_eq!(place_weights(&edge, false), [0.0, 1.0, 0.0, 0.0]);
}
