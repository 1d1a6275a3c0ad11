//! Do the Gaussian stand-ins keep their digits, their ranges and their limits?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/draw.rs"]
mod draw;
mod oracle;

use draw::{Draw, EDGES};
use glam::Vec3;
use serde_json::Value;
use twinlight_kernels::gaussian::*;

const EPS: f64 = 1.0 / 16_777_216.0;

fn number(case: &Value, name: &str) -> f64 {
    case[name].as_f64().unwrap_or_else(|| panic!("{name} in {case}"))
}

fn cases<'a>(file: &'a Value, name: &str) -> &'a Vec<Value> {
    file[name].as_array().unwrap()
}

fn relative(got: f32, want: f64) -> f64 {
    let error = if want == 0.0 { f64::from(got).abs() } else { (f64::from(got) / want - 1.0).abs() };
    if error.is_nan() { f64::INFINITY } else { error }
}

#[test]
fn lobes_meet_the_vectors() {
    let file = oracle::vector_file("gaussian_lobes");
    let mut worst = 0.0f64;
    let mut clamped = 0;
    for case in cases(&file, "cases") {
        let length = number(case, "len") as f32;
        worst = worst.max(relative(variance_to_length(number(case, "sigma2") as f32), number(case, "len")));
        if length < MIN_LENGTH {
            assert_eq!(length_to_variance(length), length_to_variance(MIN_LENGTH));
            clamped += 1;
            continue;
        }
        worst = worst.max(relative(length_to_variance(length), number(case, "sigma2")));
        if let Some(kappa) = case["vmf_kappa"].as_f64() {
            assert!(relative(von_mises_fisher_concentration(length), kappa) < 0.05, "kappa at {length}");
        }
    }
    assert_eq!(clamped, 1, "only the 1e-6 case lies below the shortest length");
    for case in cases(&file, "convolutions") {
        let got = convolve_lengths(number(case, "len_a") as f32, number(case, "len_b") as f32);
        worst = worst.max(relative(got, number(case, "len_conv")));
    }
    for case in cases(&file, "cones") {
        let angle = number(case, "half_angle_deg").to_radians();
        worst = worst.max(relative(cone_deviation(angle as f32), number(case, "sigma")));
        assert!(relative(angle.cos() as f32, number(case, "sigma")) > 1e-2, "planted fault: sigma = cos psi");
    }
    println!("lobes: {worst:.2e} relative");
    assert!(worst <= 1e-6);
}

#[test]
fn lobe_lengths_round_trip_and_commute() {
    let mut draw = Draw::new(21);
    let (mut trip, mut against) = (0.0f64, 0.0f64);
    for _ in 0..100_000 {
        let a = draw.log_uniform(MIN_LENGTH, 1.0).min(1.0);
        let b = 1.0 - draw.log_uniform(1e-7, 0.99);
        trip = trip.max(relative(variance_to_length(length_to_variance(a)), f64::from(a)));
        trip = trip.max(relative(variance_to_length(length_to_variance(b)), f64::from(b)));
        let c = convolve_lengths(a, b);
        assert_eq!(c.to_bits(), convolve_lengths(b, a).to_bits());
        assert!(c > 0.0 && c <= 1.0);
        against = against.max(relative(c, 1.0 / (1.0 / f64::from(a) + 1.0 / f64::from(b) - 1.0)));
    }
    println!("round trip {:.2} eps, convolution {:.2} eps", trip / EPS, against / EPS);
    assert!(trip <= 4.0 * EPS && against <= 4.0 * EPS);
    for x in EDGES {
        for value in [
            length_to_variance(x),
            variance_to_length(x),
            convolve_lengths(x, 0.5),
            cone_deviation(x),
            von_mises_fisher_concentration(x),
            spread_to_variance(x, x),
        ] {
            assert!(value.is_finite() && value >= 0.0, "{x:e}: {value}");
        }
    }
    let lobe = lobe_of_mean(Vec3::ZERO, Vec3::Y);
    assert_eq!((lobe.axis, lobe.variance), (Vec3::Y, length_to_variance(MIN_LENGTH)));
    assert_eq!(length_to_variance(1.000_001), 0.0);
}

#[test]
fn tight_lobes_keep_their_variance_when_the_spread_is_accumulated() {
    let mut draw = Draw::new(22);
    for spread in [1e-2f32, 1e-3, 1e-4] {
        let directions: Vec<[f64; 3]> = (0..256)
            .map(|_| {
                let (x, y) = (f64::from(spread * draw.normal()), f64::from(spread * draw.normal()));
                let r = (1.0 + x * x + y * y).sqrt();
                [(x / r) as f32, (y / r) as f32, (1.0 / r) as f32].map(f64::from)
            })
            .collect();
        let mean = [0, 1, 2].map(|c| directions.iter().map(|d| d[c]).sum::<f64>() / 256.0);
        let v = directions.iter().map(|d| (0..3).map(|c| (d[c] - mean[c]).powi(2)).sum::<f64>()).sum::<f64>()
            / 256.0;
        let length = (mean[0] * mean[0] + mean[1] * mean[1] + mean[2] * mean[2]).sqrt();
        // 1 − |D|² = v holds for exact unit vectors only: σ² from v needs no cancelling subtraction.
        let want = v / (length * (1.0 + length));
        assert!(relative(spread_to_variance(v as f32, length as f32), want) <= 3e-7);
        let naive = relative(length_to_variance(length as f32), want);
        assert!(spread > 1e-3 || naive > 1e-2, "planted fault: from the length ({naive:e} at {spread:e})");
    }
}

#[test]
fn specular_weights_meet_the_vectors() {
    let file = oracle::vector_file("specular_weight");
    let mut worst = 0.0f64;
    let mut tiny = 0;
    for case in cases(&file, "cases") {
        let (cosine, n, sigma) =
            (number(case, "cos"), number(case, "n") as f32, number(case, "sigma") as f32);
        let got = specular_weight((1.0 - cosine) as f32, n, sigma);
        let want = number(case, "weight");
        if want < 1e-36 {
            // Held up by the exponent's floor of −87.
            assert!(got > 0.0 && got < 1e-34, "{case}: {got:e}");
            tiny += 1;
            continue;
        }
        worst = worst.max(relative(got, want));
    }
    // Behind the surface, n = 2: a cosine that is not clamped mirrors the lobe.
    let weight = |cosine: f64| {
        (-0.5 * ((1.0 - cosine * cosine) / 0.5).powi(2)).exp() / (0.5 * (2.0 * std::f64::consts::PI).sqrt())
    };
    assert!(relative(specular_weight(1.9, 2.0, 0.5), weight(0.0)) <= 1e-5);
    assert!(relative(weight(-0.9) as f32, weight(0.0)) > 1.0, "planted fault: cos not clamped");
    println!("specular_weight: {worst:.2e} relative, {tiny} below 1e-36");
    assert!(worst <= 1e-5);
    assert!(tiny < 8);
}

#[test]
fn specular_lobes_keep_their_digits_when_tight() {
    let mut draw = Draw::new(23);
    let (mut worst, mut worst_naive) = (0.0f64, 0.0f64);
    for _ in 0..50_000 {
        let theta = f64::from(draw.log_uniform(1e-4, 1.5));
        let n = draw.log_uniform(0.1, 2000.0);
        let (l, r) = (Vec3::new(theta.sin() as f32, 0.0, theta.cos() as f32), Vec3::Z);
        // The truth is that of the rounded vectors.
        let gap = 0.5 * (f64::from(l.x).powi(2) + (f64::from(l.z) - 1.0).powi(2));
        let want = -(f64::from(n) * (-gap).ln_1p()).exp_m1();
        worst = worst.max(relative(lobe_offset(one_minus_cosine(l, r), n), want));
        worst_naive = worst_naive.max(relative(1.0 - l.dot(r).powf(n), want));
    }
    println!("lobe_offset: {worst:.2e} relative, naive {worst_naive:.2e}");
    assert!(worst <= 1e-6);
    assert!(worst_naive > 1e-2, "planted fault: from the cosine");
}

#[test]
fn specular_weight_is_positive_bounded_and_monotone() {
    let mut draw = Draw::new(24);
    for _ in 0..50_000 {
        let (n, sigma) = (draw.log_uniform(0.1, 1000.0), draw.log_uniform(1e-3, 10.0));
        let near = draw.log_uniform(1e-7, 1.0);
        let far = near * (1.0 + draw.log_uniform(1e-5, 1.0));
        let (a, b) = (specular_falloff(near, n, sigma), specular_falloff(far, n, sigma));
        assert!(a > 0.0 && a <= 1.0);
        // Within the error of the exponential: the exponents themselves are in order.
        assert!(b <= a * (1.0 + 2e-7), "n {n} sigma {sigma}: {near:e} gives {a:e}, {far:e} gives {b:e}");
        assert_eq!(specular_falloff(1.0, n, sigma), specular_falloff(draw.uniform(1.0, 2.0), n, sigma));
        let peak = specular_weight(0.0, n, sigma);
        assert!(specular_weight(near, n, sigma) <= peak);
    }
    for x in EDGES {
        for y in EDGES {
            for value in [specular_weight(x, y, 0.2), specular_weight(0.3, x, y), specular_falloff(y, 3.0, x)]
            {
                assert!(value.is_finite() && value >= 0.0, "{x:e} {y:e}: {value}");
            }
        }
    }
    assert_eq!(lobe_offset(0.7, 0.0), 0.0);
    assert!(
        (specular_falloff(1.0, 10.0, 0.5) - (-2.0f32).exp()).abs() < 1e-6,
        "does not vanish at 90 degrees"
    );
}
