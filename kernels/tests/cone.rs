//! Do cones step, composite and fade as their formulas say, at the ends of every range too?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/draw.rs"]
mod draw;
mod oracle;

use draw::{Draw, EDGES};
use glam::{Vec3, Vec4};
use twinlight_kernels::cone::*;

const EPS: f64 = 1.0 / 16_777_216.0;

fn truth(alpha: f32, ratio: f32) -> f64 {
    -(f64::from(ratio) * (-f64::from(alpha)).ln_1p()).exp_m1()
}

/// Largest relative error of a step correction against the vectors.
fn worst_on_vectors(function: fn(f32, f32) -> f32) -> f64 {
    let file = oracle::vector_file("step_correction");
    let mut worst = 0.0f64;
    for case in file["cases"].as_array().unwrap() {
        let number = |name: &str| case[name].as_f64().unwrap();
        let got = f64::from(function(number("alpha") as f32, number("ratio") as f32));
        let want = number("corrected");
        let error = if want == 0.0 { got.abs() } else { (got / want - 1.0).abs() };
        worst = worst.max(if error.is_nan() { f64::INFINITY } else { error });
    }
    worst
}

#[test]
fn step_correction_meets_the_vectors() {
    let worst = worst_on_vectors(corrected_opacity);
    println!("corrected_opacity: {worst:.2e} relative");
    assert!(worst <= 3e-7);
    // Planted fault: the printed formula evaluated as it stands.
    assert!(worst_on_vectors(|alpha, ratio| 1.0 - (1.0 - alpha).powf(ratio)) > 1e-2);
}

#[test]
fn step_correction_keeps_its_ends_and_halves() {
    let mut draw = Draw::new(11);
    let (mut worst_half, mut worst_identity, mut worst_scale) = (0.0f64, 0.0f64, 0.0f64);
    for _ in 0..100_000 {
        let alpha = if draw.bits() & 1 == 0 {
            draw.log_uniform(1e-12, 1.0)
        } else {
            1.0 - draw.log_uniform(6e-8, 1.0)
        };
        let ratio = draw.log_uniform(1e-3, 64.0);
        let half = corrected_opacity(alpha, 0.5 * ratio);
        let whole = corrected_opacity(alpha, ratio);
        let composed = f64::from(half) + (1.0 - f64::from(half)) * f64::from(half);
        worst_half = worst_half.max((composed - f64::from(whole)).abs());
        assert!((0.0..=1.0).contains(&whole), "alpha {alpha:e} ratio {ratio:e}: {whole:e}");
        worst_identity = worst_identity
            .max((f64::from(corrected_opacity(alpha, 1.0)) / f64::from(alpha) - 1.0).abs() / EPS);
        let scale = truth(alpha, ratio) / f64::from(alpha);
        worst_scale = worst_scale.max((f64::from(premultiplied_scale(alpha, ratio)) / scale - 1.0).abs());
    }
    println!("halves {worst_half:.2e}, ratio 1 {worst_identity:.2} eps, colour {worst_scale:.2e} relative");
    assert!(worst_half <= 1e-6);
    assert!(worst_identity <= 2.0 * 2.0, "ratio 1 is the identity within 2 ULP");
    assert!(worst_scale <= 4e-7);
    for ratio in [1.0 / 64.0, 0.5, 1.0, 3.0, 1e6] {
        assert_eq!(corrected_opacity(1.0, ratio), 1.0);
        assert_eq!(corrected_opacity(0.0, ratio), 0.0);
        assert_eq!(premultiplied_scale(0.0, ratio), ratio);
        assert_eq!(premultiplied_scale(1e-30, ratio), ratio);
    }
    assert_eq!(corrected_opacity(1.0, 0.0), 0.0);
    // Planted fault: the saturating logarithm without the branch for opaque voxels.
    let unguarded =
        -twinlight_kernels::math::exp_minus_one(1.0 / 64.0 * twinlight_kernels::math::ln_one_plus(-1.0));
    assert!(unguarded < 0.9);
}

#[test]
fn corrected_samples_composite_alike_at_any_step() {
    let mut draw = Draw::new(12);
    let mut worst = 0.0f32;
    let mut worst_uncorrected = 0.0f32;
    for _ in 0..20_000 {
        let alpha = draw.uniform(0.0, 1.0);
        let colour = Vec3::new(draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0));
        let sample = (colour * alpha).extend(alpha);
        let k = 1 + draw.bits() % 8;
        let mut sum = Vec4::ZERO;
        let mut uncorrected = Vec4::ZERO;
        for _ in 0..k {
            let part = corrected_sample(sample, 1.0 / k as f32);
            sum = composite(sum, part);
            uncorrected = composite(uncorrected, sample.truncate().extend(part.w));
        }
        worst = worst.max((sum - sample).abs().max_element());
        worst_uncorrected = worst_uncorrected.max((uncorrected - sample).abs().max_element());
    }
    println!("splitting a segment: {worst:.2e}");
    assert!(worst <= 1e-6);
    assert!(worst_uncorrected > 0.1, "planted fault: colour not scaled");
}

#[test]
fn over_is_associative_bounded_and_hides() {
    let mut draw = Draw::new(13);
    let mut worst = 0.0f64;
    let mut worst_printed = 0.0f64;
    for _ in 0..100_000 {
        let mut sample = || {
            let alpha = [0.0, 1.0, draw.uniform(0.0, 1.0)][(draw.bits() % 8).min(2) as usize];
            let c = Vec3::new(draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0));
            (c * alpha).extend(alpha)
        };
        let (a, b, c) = (sample(), sample(), sample());
        let left = composite(composite(a, b), c);
        let right = composite(a, composite(b, c));
        worst = worst.max(f64::from((left - right).abs().max_element()) / EPS);
        let printed = |f: Vec4, s: Vec4| {
            (f.truncate() * f.w + s.truncate() * (1.0 - f.w)).extend(f.w + (1.0 - f.w) * s.w)
        };
        let wrong = printed(printed(a, b), c) - printed(a, printed(b, c));
        worst_printed = worst_printed.max(f64::from(wrong.abs().max_element()) / EPS);
        assert!(left.w <= 1.0 && left.w >= a.w);
        let opaque = a.truncate().extend(1.0);
        assert_eq!(composite(opaque, b), opaque);
        assert_eq!(composite(Vec4::ZERO, b), b);
        if b.w > 0.0 {
            let colour = b.truncate() / b.w;
            assert!((accumulate(a, colour, b.w) - composite(a, b)).abs().max_element() <= 2e-7);
        }
    }
    println!("associativity: {worst:.2} eps");
    assert!(worst <= 4.0);
    assert!(worst_printed > 1e4, "planted fault: the printed accumulation");
}

#[test]
fn mip_levels_are_whole_at_powers_of_two_and_monotone() {
    for max_level in [0.0, 1.0, 5.0, 9.0, 32.0] {
        for diameter in [0.0, -0.0, -3.0, 1e-30, 0.5, 1.0, f32::NAN, f32::MIN] {
            assert_eq!(mip_level(diameter, max_level), 0.0, "diameter {diameter}");
        }
        for k in 0..40 {
            assert_eq!(mip_level(2f32.powi(k), max_level), (k as f32).min(max_level));
        }
        assert_eq!(mip_level(f32::MAX, max_level), max_level);
    }
    assert_eq!(mip_level(100.0, f32::NAN), 0.0);
    assert_eq!(mip_level(f32::INFINITY, 2.5), 2.5);
    let mut draw = Draw::new(14);
    let mut worst = 0.0f64;
    for _ in 0..100_000 {
        let a = draw.log_uniform(0.5, 1024.0);
        // Further apart than the error of the logarithm: neighbouring floats may round to either side.
        let b = a * (1.0 + draw.log_uniform(1e-6, 1.0));
        assert!(mip_level(a, 9.0) <= mip_level(b, 9.0), "{a:e} {b:e}");
        let want = f64::from(a.clamp(1.0, 512.0)).log2();
        worst = worst.max((f64::from(mip_level(a, 9.0)) - want).abs());
    }
    println!("mip_level: {worst:.2e} absolute");
    assert!(worst <= 1e-6);
    assert!((f64::from(10f32.ln()) - 10f64.log2()).abs() > 0.1, "planted fault: the natural logarithm");
}

/// Marches through a constant field; returns (accumulated opacity, steps).
fn march(half_angle: f32, opacity: f32, factor: f32) -> (f32, u32) {
    let (voxel, range, cutoff) = (1.0, 200.0, 0.99);
    let tangent = aperture_tangent(half_angle);
    let mut sum = Vec4::ZERO;
    let mut t = voxel;
    for step in 0..step_count_bound(range, voxel, factor) {
        if t > range || sum.w >= cutoff {
            return (sum.w, step);
        }
        let width = diameter(t, tangent);
        let length = step_length(width, voxel, factor);
        let size = 2f32.powf(mip_level(width, 9.0).floor());
        sum = composite(sum, corrected_sample(Vec4::splat(opacity), length / size));
        t += length;
    }
    (sum.w, u32::MAX)
}

#[test]
fn marches_end_for_every_aperture() {
    for half_angle in [0.0, 1e-7, 0.01, 0.5, 1.0, 1.4835, std::f32::consts::FRAC_PI_2, 3.0, f32::NAN, -1.0] {
        for factor in [0.0, 0.25, 1.0, 2.0, f32::NAN] {
            let (empty, steps) = march(half_angle, 0.0, factor);
            assert!(steps < u32::MAX, "half angle {half_angle}, factor {factor}: no end");
            assert_eq!(empty, 0.0);
            assert_eq!(march(half_angle, 1.0, factor).0, 1.0, "a full scene is opaque");
        }
    }
    assert!((aperture_tangent(std::f32::consts::FRAC_PI_2) - 11.43).abs() < 0.01);
    assert!(std::f32::consts::FRAC_PI_2.tan().abs() > 1e6, "planted fault: the unclamped tangent");
    let mut worst = 0.0f64;
    for i in 1..1000 {
        let angle = MAX_HALF_ANGLE * i as f32 / 1000.0;
        worst = worst.max((f64::from(aperture_tangent(angle)) / f64::from(angle).tan() - 1.0).abs());
    }
    assert!(worst <= 4e-7, "tangent: {worst:e}");
}

#[test]
fn cone_sums_are_exact_for_empty_and_closed_scenes() {
    let mut draw = Draw::new(15);
    for _ in 0..10_000 {
        let count = 1 + draw.bits() % 16;
        let (mut open, mut closed, mut fixed) = (ConeSum::EMPTY, ConeSum::EMPTY, 0.0f32);
        for _ in 0..count {
            let weight = draw.uniform(0.01, 1.0);
            open = open.with(Vec4::ONE, weight);
            closed = closed.with(Vec4::ZERO, weight);
            fixed += weight / count as f32;
        }
        assert_eq!(open.mean(Vec4::ZERO), Vec4::ONE);
        assert_eq!(closed.mean(Vec4::ONE), Vec4::ZERO);
        assert!(count == 1 || fixed < 1.0, "planted fault: a constant divisor");
    }
    let fallback = Vec4::new(1.0, 2.0, 3.0, 4.0);
    assert_eq!(ConeSum::EMPTY.mean(fallback), fallback);
    assert_eq!(ConeSum::EMPTY.with(Vec4::ONE, f32::NAN).mean(fallback), fallback);
}

#[test]
fn falloff_is_the_reciprocal_and_total() {
    let mut draw = Draw::new(16);
    for _ in 0..50_000 {
        let (r, lambda) = (draw.log_uniform(1e-9, 1e9), draw.log_uniform(1e-9, 1e9));
        let want = 1.0 / (1.0 + f64::from(r) * f64::from(lambda));
        assert!((f64::from(distance_falloff(r, lambda)) / want - 1.0).abs() <= 2e-7, "{r:e} {lambda:e}");
    }
    assert_eq!(distance_falloff(0.0, 5.0), 1.0);
    assert_eq!(faded_opacity(0.5, 1.0, 1.0), 0.25);
    for x in EDGES {
        for y in EDGES {
            for value in [
                corrected_opacity(x, y),
                premultiplied_scale(x, y),
                mip_level(x, y),
                aperture_tangent(x),
                distance_falloff(x, y),
                step_count_bound(x, y, 1.0) as f32,
                step_length(x.min(1e18), y.min(1e18), x),
            ] {
                assert!(value.is_finite(), "{x:e} {y:e}: {value}");
            }
            for value in [corrected_opacity(x, y), distance_falloff(x, y)] {
                assert!((0.0..=1.0).contains(&value), "{x:e} {y:e}: {value}");
            }
        }
    }
}
