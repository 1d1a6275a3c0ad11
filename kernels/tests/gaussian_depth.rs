//! Do depth windows and layers keep their digits, and variances their sign?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/draw.rs"]
mod draw;
mod oracle;

use draw::{Draw, EDGES};
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
