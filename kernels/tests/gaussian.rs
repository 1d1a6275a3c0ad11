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
        let mirrored = (-0.5 * ((1.0 - cosine.abs().powf(n.into())) / f64::from(sigma)).powi(2)).exp();
        let wrong =
            relative((mirrored / (f64::from(sigma) * (2.0 * std::f64::consts::PI).sqrt())) as f32, want);
        assert!(cosine > -0.5 || n > 5.0 || wrong > 1e-3, "planted fault: cos not clamped");
    }
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

/// Error of a depth coverage in units of its allowed error.
fn coverage_excess(
    function: fn(f32, f32, f32, f32) -> f32,
    mu: f32,
    sigma: f32,
    zc: f32,
    rc: f32,
    want: f64,
) -> f64 {
    let got = f64::from(function(mu, sigma, zc, rc));
    let scale = f64::from(zc).abs() + f64::from(mu).abs() + f64::from(rc);
    let mut allowed = 1.3e-7;
    if sigma > 0.0 {
        allowed += 0.4 * EPS * scale / f64::from(sigma);
    }
    let error = (got - want).abs();
    if error.is_nan() { f64::INFINITY } else { error / allowed }
}

fn naive_coverage(mu: f32, sigma: f32, zc: f32, rc: f32) -> f32 {
    let s = sigma * std::f32::consts::SQRT_2;
    let erf = twinlight_kernels::math::erf;
    0.5 * (erf((zc + rc) / s - mu / s) - erf((zc - rc) / s - mu / s))
}

#[test]
fn depth_coverage_meets_the_vectors() {
    let file = oracle::vector_file("lrsm_depth_weight");
    let (mut worst, mut naive) = (0.0f64, 0.0f64);
    for case in cases(&file, "cases") {
        let [mu, sigma, zc, rc] = ["mu", "sigma", "zc", "rc"].map(|name| number(case, name) as f32);
        worst = worst.max(coverage_excess(depth_coverage, mu, sigma, zc, rc, number(case, "v")));
        naive = naive.max(coverage_excess(naive_coverage, mu, sigma, zc, rc, number(case, "v")));
    }
    println!("depth_coverage: {worst:.2} of the allowed error, naive {naive:.2}");
    assert!(worst <= 1.0);
    assert!(naive > 1.0, "planted fault: the naive order (NaN at sigma 0)");
}

#[test]
fn depth_coverage_is_a_symmetric_monotone_share() {
    let mut draw = Draw::new(25);
    let (mut worst, mut worst_narrow, mut worst_difference) = (0.0f64, 0.0f64, 0.0f64);
    for _ in 0..30_000 {
        let (mu, zc) = (draw.uniform(0.0, 1.0), draw.uniform(0.0, 1.0));
        let (sigma, rc) = (draw.log_uniform(1e-5, 1.0), draw.log_uniform(1e-5, 1.0));
        let v = depth_coverage(mu, sigma, zc, rc);
        assert!((0.0..=1.0).contains(&v));
        assert_eq!(v, depth_coverage(-mu, sigma, -zc, rc));
        assert_eq!(v, depth_coverage(zc, sigma, mu, rc));
        assert!(depth_coverage(mu, sigma, zc, 1.01 * rc) >= v - 2.6e-7);
        let d = f64::from(zc) - f64::from(mu);
        let s = f64::from(sigma) * 2f64.sqrt();
        let want = 0.5 * (oracle::erf((d + f64::from(rc)) / s) - oracle::erf((d - f64::from(rc)) / s));
        worst = worst.max(coverage_excess(depth_coverage, mu, sigma, zc, rc, want));
        // d exactly representable, so that only the formula errs.
        let (r, q) = (draw.log_uniform(1e-6, 0.05) * sigma, draw.uniform(-2.0, 2.0));
        let d = q * sigma;
        let w = f64::from(r) / f64::from(sigma);
        let q = f64::from(d) / f64::from(sigma);
        let term = (-0.5 * q * q).exp() / (2.0 * std::f64::consts::PI).sqrt();
        let (q2, w2) = (q * q, w * w);
        let series =
            2.0 * w * term * (1.0 + (q2 - 1.0) * w2 / 6.0 + (q2 * q2 - 6.0 * q2 + 3.0) * w2 * w2 / 120.0);
        worst_narrow = worst_narrow.max(relative(depth_coverage(0.0, sigma, d, r), series));
        worst_difference = worst_difference.max(relative(naive_coverage(0.0, sigma, d, r), series));
    }
    println!(
        "coverage {worst:.2} of allowed; narrow {worst_narrow:.2e} relative, naive {worst_difference:.2e}"
    );
    assert!(worst <= 1.0);
    assert!(worst_narrow <= 1e-5);
    assert!(worst_difference > 1e-3, "planted fault: erf difference for narrow windows");
}

#[test]
fn depth_coverage_tends_to_the_step() {
    for (zc, want) in [(0.5, 1.0), (0.6, 1.0), (0.75, 0.5), (0.25, 0.5), (0.9, 0.0), (0.0, 0.0)] {
        assert_eq!(depth_coverage(0.5, 0.0, zc, 0.25), want);
        for sigma in [1e-20, 1e-10, 1e-6, 1e-4] {
            assert!((depth_coverage(0.5, sigma, zc, 0.25) - want).abs() < 1e-6, "{zc} {sigma}");
        }
    }
    assert_eq!(depth_coverage(0.5, 0.0, 0.5, 0.0), 0.0);
    for x in EDGES {
        for y in EDGES {
            for value in [
                depth_coverage(x, y, 0.3, 0.1),
                depth_coverage(0.3, 0.1, x, y),
                depth_coverage(x, 1e-3, y, x),
            ] {
                assert!((0.0..=1.0).contains(&value), "{x:e} {y:e}: {value}");
            }
            let (mean, variance) = weighted_moments(x, y, x, y);
            for value in
                [mean, variance, variance_from_moments(x, y, 1e-3), layer_decay(x, y, 1.0, 0.1, false, false)]
            {
                assert!(value.is_finite(), "{x:e} {y:e}: {value}");
            }
            assert!(variance >= 0.0);
        }
    }
}

#[test]
fn variance_has_a_floor_and_ignores_shifts() {
    let mut draw = Draw::new(26);
    let floor = minimum_deviation(1.0, 0.0);
    let (mut worst, mut worst_raw) = (0.0f64, 0.0f64);
    for _ in 0..5_000 {
        let (z_min, size) = (draw.uniform(0.0, 0.5), draw.uniform(0.1, 0.5));
        let spread = draw.log_uniform(0.02, 0.1);
        let centre = z_min + 0.5 * size;
        let depths: Vec<f32> =
            (0..64).map(|_| centre + size * spread * draw.normal().clamp(-4.0, 4.0)).collect();
        let moments = |f: &dyn Fn(f32) -> f32| {
            let (mut m1, mut m2) = (0.0f32, 0.0f32);
            for &z in &depths {
                m1 += f(z) / 64.0;
                m2 += f(z) * f(z) / 64.0;
            }
            (m1, m2)
        };
        let (m1, m2) = moments(&|z| layer_coordinate(z, z_min, z_min + size));
        let exact: Vec<f64> = depths
            .iter()
            .map(|&z| {
                let half = 0.5 * (f64::from(z_min + size) - f64::from(z_min));
                (f64::from(z) - f64::from(z_min) - half) / half
            })
            .collect();
        let mean = exact.iter().sum::<f64>() / 64.0;
        let want = exact.iter().map(|z| (z - mean).powi(2)).sum::<f64>() / 64.0;
        worst = worst.max(relative(variance_from_moments(m1, m2, 0.0), want));
        let (far1, far2) = moments(&|z| layer_coordinate(z, z_min, z_min + size) + 100.0);
        worst_raw = worst_raw.max(relative(variance_from_moments(far1, far2, 0.0), want));
        let alpha = draw.uniform(0.01, 1.0);
        let (mean_w, variance_w) = weighted_moments(alpha, alpha * m1, alpha * m2, 0.0);
        assert!((f64::from(mean_w) - mean).abs() < 1e-6 && relative(variance_w, want) < 2e-5);
        let constant = draw.uniform(-1.0, 1.0);
        assert_eq!(variance_from_moments(constant, constant * constant, floor), floor * floor);
        assert_eq!(variance_from_moments(constant, 0.5 * constant * constant, floor), floor * floor);
    }
    println!("variance: {worst:.2e} relative, unshifted {worst_raw:.2e}");
    assert!(worst <= 1e-5);
    assert!(worst_raw > 1e-2, "planted fault: moments of unshifted depths");
    assert_eq!(minimum_deviation(1.0, 0.1), 0.05);
}

#[test]
fn overlapping_layers_sum_to_one() {
    let mut draw = Draw::new(27);
    let mut worst = 0.0f32;
    let mut worst_faded = 0.0f32;
    for _ in 0..50_000 {
        let (cut, overlap) = (draw.uniform(0.3, 0.7), draw.log_uniform(1e-4, 0.2));
        let z = draw.uniform(0.0, 1.0);
        let sum = layer_decay(z, 0.0, cut + overlap, overlap, true, false)
            + layer_decay(z, cut, 1.0, overlap, false, true);
        // The two fractions round independently: (z − cut)/overlap and (cut + overlap − z)/overlap.
        worst = worst.max((sum - 1.0).abs() * overlap);
        let faded = layer_decay(z, 0.0, cut + overlap, overlap, false, false)
            + layer_decay(z, cut, 1.0, overlap, false, false);
        worst_faded = worst_faded.max((faded - 1.0).abs() * overlap);
    }
    println!("decay sums: {worst:.2e} times 1/overlap");
    assert!(worst <= 3e-7);
    assert!(worst_faded > 1e-2, "planted fault: outermost ends fade");
    for i in 0..=1000 {
        let t = i as f32 / 1000.0;
        assert!((smooth_step(t) + smooth_step(1.0 - t) - 1.0).abs() <= 2.4e-7);
    }
    assert_eq!(
        layer_decay(0.5, 0.0, 0.5, 0.0, true, false) + layer_decay(0.5, 0.5, 1.0, 0.0, false, true),
        1.0
    );
}

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
