//! Which hard case costs the usual formula its digits, and what does the kernel make of it?
//!
//! `cargo test -p twinlight-kernels --test hard_cases -- --nocapture` prints the table of `docs/numerics.md`: the largest relative
//! error of both over random inputs of each case, against float64. The usual formula is the planted fault: it must fail.

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods, clippy::neg_cmp_op_on_partial_ord, clippy::zero_divided_by_zero)]

#[path = "oracle/draw.rs"]
mod draw;
mod oracle;

use draw::Draw;
use glam::{UVec3, Vec2, Vec3, Vec4};
use twinlight_kernels::cone::*;
use twinlight_kernels::gaussian::*;
use twinlight_kernels::geometry::disc::ray_disc;
use twinlight_kernels::geometry::voxel_walk::VoxelWalk;
use twinlight_kernels::math::{erf, normalize_or};
use twinlight_kernels::sampling::{attenuation, halton, hemisphere, roulette, voxel_hash};
use twinlight_kernels::sh;

/// Inputs of a case.
const COUNT: usize = 4000;

/// What the usual formula gives, what the kernel gives, and what is right.
type Three = (f32, f32, f64);

/// In float64.
fn length(v: Vec3) -> f64 {
    v.to_array().iter().map(|&x| f64::from(x).powi(2)).sum::<f64>().sqrt()
}

fn error(got: f32, right: f64) -> f64 {
    let got = f64::from(got);
    let error = if right == 0.0 { got.abs() } else { (got / right - 1.0).abs() };
    if error.is_nan() { f64::INFINITY } else { error }
}

/// Prints a row, and checks that the kernel is within its tolerance and the usual formula is not.
fn row(kernel: &str, case: &str, tolerance: f64, one: impl FnMut(&mut Draw) -> Three) {
    measure(kernel, case, tolerance, one, |x| {
        if x.is_infinite() { "∞ or NaN".into() } else { format!("{x:.1e}") }
    });
}

fn measure(
    kernel: &str,
    case: &str,
    tolerance: f64,
    mut one: impl FnMut(&mut Draw) -> Three,
    figure: impl Fn(f64) -> String,
) {
    let mut draw = Draw::new(kernel.len() as u64 * 31 + case.len() as u64);
    let (mut naive, mut own) = (0.0f64, 0.0f64);
    for _ in 0..COUNT {
        let (usual, kernel, right) = one(&mut draw);
        naive = naive.max(error(usual, right));
        own = own.max(error(kernel, right));
    }
    let test = std::thread::current().name().unwrap_or_default().to_owned();
    println!("| `{kernel}` | {case} | {} | {} | `{test}` |", figure(naive), figure(own));
    assert!(own <= tolerance, "{kernel}, {case}: {own:e} is beyond {tolerance:e}");
    assert!(naive > tolerance, "{kernel}, {case}: the usual formula passes with {naive:e}");
}

/// The same for decisions: a wrong one is an error of 1.
fn decide(kernel: &str, case: &str, mut one: impl FnMut(&mut Draw) -> (bool, bool, bool)) {
    let three = |d: &mut Draw| {
        let (usual, kernel, right) = one(d);
        let wrong = |x: bool| if x == right { 0.0 } else { 1.0 };
        (wrong(usual), wrong(kernel), 0.0)
    };
    measure(kernel, case, 0.0, three, |x| if x == 0.0 { "right".into() } else { "wrong".into() });
}

#[test]
fn rays_and_discs() {
    let naive = |o: Vec3, d: Vec3, c: Vec3, n: Vec3, r: f32| {
        let t = (c - o).dot(n) / d.dot(n);
        (t > 0.0 && (o + d * t).distance(c) <= r, t)
    };
    row("ray_disc", "directions of 1e-30 … 1e-25: t", 5e-7, |d| {
        let direction =
            Vec3::new(d.uniform(-0.2, 0.2), d.uniform(-0.2, 0.2), -1.0) * d.log_uniform(1e-30, 1e-25);
        let origin = Vec3::new(0.0, 0.0, 2.0);
        let t = naive(origin, direction, Vec3::ZERO, Vec3::Z, 1.0).1
            * if direction.dot(direction) > 0.0 { 1.0 } else { f32::NAN };
        let hit = ray_disc(origin, direction, Vec3::ZERO, Vec3::Z, 1.0, 0.0, f32::MAX);
        (t, if hit.hit { hit.t } else { f32::NAN }, 2.0 / -f64::from(direction.z))
    });
    decide("ray_disc", "rays in the disc's plane, that miss", |d| {
        let (sin, cos) = d.uniform(0.0, 6.0).sin_cos();
        let direction = Vec3::new(cos, sin, 0.0);
        let origin = -direction * 3.0;
        // 0/0: a comparison the other way round takes NaN for a hit.
        let t = -origin.z / direction.z;
        let usual = !((origin + direction * t).length() > 1.0);
        (usual, ray_disc(origin, direction, Vec3::ZERO, Vec3::Z, 1.0, 0.0, 1e30).hit, false)
    });
    decide("ray_disc", "radius 0 or −0, met in its middle", |d| {
        let radius = if d.bits().is_multiple_of(2) { 0.0 } else { -0.0 };
        let origin = Vec3::Z * d.uniform(1.0, 2.0);
        let usual = naive(origin, Vec3::NEG_Z, Vec3::ZERO, Vec3::Z, radius).0;
        (usual, ray_disc(origin, Vec3::NEG_Z, Vec3::ZERO, Vec3::Z, radius, 0.0, 1e30).hit, false)
    });
}

#[test]
fn voxels() {
    row("VoxelWalk", "parameter of the 500th crossing", 1e-6, |d| {
        let direction = Vec3::new(d.uniform(0.5, 1.0), 0.0, 0.0);
        let origin = Vec3::new(d.uniform(0.0, 1.0), 0.2, 0.2);
        let mut walk = VoxelWalk::new(origin, direction, UVec3::splat(600), 1e30);
        let mut added = (1.0 - origin.x) / direction.x;
        for _ in 1..500 {
            added += 1.0 / direction.x;
        }
        while walk.inside && walk.voxel.x < 499 {
            walk.step();
        }
        (added, walk.t_exit, (500.0 - f64::from(origin.x)) / f64::from(direction.x))
    });
    decide("VoxelWalk", "direction ±0 along an axis, from a boundary: a first voxel", |d| {
        let y = (d.bits() % 5) as f32;
        let direction = Vec3::new(1.0, if d.bits().is_multiple_of(2) { 0.0 } else { -0.0 }, 0.0);
        let origin = Vec3::new(-1.0, y, 0.5);
        // Slabs with 0 · ∞.
        let inverse = direction.recip();
        let (a, b) = ((Vec3::ZERO - origin) * inverse, (Vec3::splat(8.0) - origin) * inverse);
        let enter = a.x.min(b.x).max(if a.y < b.y { a.y } else { b.y });
        let usual = enter <= a.x.max(b.x);
        (usual && !enter.is_nan(), VoxelWalk::new(origin, direction, UVec3::splat(8), 1e30).inside, true)
    });
    decide("fits_u32", "grids of 1300³ … 1999³: whether 32 bits number their voxels", |d| {
        let dims = UVec3::splat(1300 + d.bits() % 700);
        let count = u64::from(dims.x) * u64::from(dims.y) * u64::from(dims.z);
        // A product that wraps is not always less than a factor.
        let wrapped = dims.x.wrapping_mul(dims.y).wrapping_mul(dims.z);
        (wrapped >= dims.x * dims.y, voxel_hash::fits_u32(dims), count <= u64::from(u32::MAX))
    });
    decide("voxel_of", "points on the far side, beyond, or below: the nearest voxel", |d| {
        let (x, right) = match d.bits() % 3 {
            0 => (4.0, 3),
            1 => (d.log_uniform(4.0, 1e30), 3),
            _ => (-d.log_uniform(1e-3, 1e30), 0),
        };
        let own = voxel_hash::voxel_of(Vec3::new(x, 0.5, 0.5), Vec3::ZERO, Vec3::ONE, UVec3::splat(4));
        (x.floor() as i32 == right, own.x == right as u32 && own.y == 0 && own.z == 0, true)
    });
}

#[test]
fn samples() {
    decide("radical_inverse_2", "indices above 2²⁴: below 1", |d| {
        let index = u32::MAX - d.bits() % 128;
        (index.reverse_bits() as f32 * 2f32.powi(-32) < 1.0, halton::radical_inverse_2(index) < 1.0, true)
    });
    row("radical_inverse_5", "as a running product of 1/5", 2.0e-7, |d| {
        let index = d.bits() % 1_220_703_125;
        let (mut rest, mut factor, mut x, mut numerator, mut power) = (index, 1.0f32, 0.0f32, 0u64, 1u64);
        while rest > 0 {
            factor /= 5.0;
            x += factor * (rest % 5) as f32;
            (numerator, power) = (numerator * 5 + u64::from(rest % 5), power * 5);
            rest /= 5;
        }
        (x, halton::radical_inverse_5(index), numerator as f64 / power as f64)
    });
    decide("accept", "a probability of 0: never", |d| {
        // The smallest hash is the one that `≤` takes.
        let hash = d.bits() & 0xFF;
        ((hash >> 8) as f32 / 16_777_216.0 <= 0.0, roulette::accept(hash, 0.0), false)
    });
    decide("fold_barycentrics", "u + v above 1: inside the triangle", |d| {
        let u = Vec2::new(d.uniform(0.5, 1.0), d.uniform(0.5, 1.0));
        let w = hemisphere::fold_barycentrics(u);
        (1.0 - u.x - u.y >= 0.0, w.min_element() >= 0.0, true)
    });
    row("bounded_inverse_square", "1/d² at d = 1e-25 … 1e-20, radius 0.1", 1e-6, |d| {
        let distance = d.log_uniform(1e-25, 1e-20);
        let squared = distance * distance;
        (1.0 / squared, attenuation::bounded_inverse_square(squared, 0.1), 1.0 / f64::from(0.1f32 * 0.1f32))
    });
    row("vpl_form_factor", "discs nearer than their radius: no more than all", 0.0, |d| {
        let (distance, area) = (d.log_uniform(1e-3, 0.3), 1.0);
        let usual = (area / (std::f32::consts::PI * distance * distance) - 1.0).max(0.0);
        let own = attenuation::vpl_form_factor(Vec3::ZERO, Vec3::Z, Vec3::Z * distance, Vec3::NEG_Z, area);
        (usual, (own - 1.0).max(0.0), 0.0)
    });
    row("normalize_or", "lengths of 1e-37 … 1e-24 and 1e20 … 1e38", 5e-7, |d| {
        let size =
            if d.bits().is_multiple_of(2) { d.log_uniform(1e-37, 1e-24) } else { d.log_uniform(1e20, 1e38) };
        let v = Vec3::new(d.uniform(0.5, 1.0), d.uniform(-1.0, 1.0), d.uniform(-1.0, 1.0)) * size;
        let right = f64::from(v.x) / length(v);
        ((v / (v.x * v.x + v.y * v.y + v.z * v.z).sqrt()).x, normalize_or(v, Vec3::Y).x, right)
    });
}

#[test]
fn harmonics() {
    row("cap", "small caps: 1 − cos θ", 5e-7, |d| {
        let alpha = d.log_uniform(1e-5, 1e-2);
        let a = f64::from(alpha);
        let right = std::f64::consts::PI.sqrt() * (a * a / (1.0 + (1.0 - a * a).sqrt()));
        let usual = std::f32::consts::PI.sqrt() * (1.0 - (1.0 - alpha * alpha).sqrt());
        (usual, sh::cap::<3>(alpha)[0], right)
    });
    decide("blocker", "receivers inside the sphere: α within [0, 1]", |d| {
        let radius = d.uniform(1.0, 2.0);
        let centre = Vec3::new(0.0, d.uniform(0.1, 0.9), 0.0);
        let b = sh::blocker(centre, radius, Vec3::ZERO, Vec3::Y, sh::FADE);
        (
            (radius / centre.length()).asin().is_finite(),
            (0.0..=1.0).contains(&b.alpha) && b.direction.is_finite(),
            true,
        )
    });
    decide("hybrid", "sums of many blockers: g·g ≤ √4π g₀, within 1e-4", |d| {
        let mut f = [0.0f32; 9];
        f[0] = d.uniform(-60.0, -20.0);
        f[1..].iter_mut().for_each(|x| *x = d.uniform(-30.0, 30.0));
        let feasible = |g: &[f32; 9]| {
            let (g0, whole) = (f64::from(g[0]), (4.0 * std::f64::consts::PI).sqrt());
            let sum: f64 = g.iter().map(|&x| f64::from(x) * f64::from(x)).sum();
            sum.is_finite() && g0 >= -1e-6 && sum <= whole * g0 * 1.0001 + 1e-6
        };
        // The exponential of the rest by scaling and squaring, without what keeps it feasible.
        let mut g = f.map(|x| x / 64.0);
        g[0] = (4.0 * std::f32::consts::PI).sqrt();
        for _ in 0..6 {
            g = sh::square::<9>(&g);
        }
        let scale = (f[0] / (4.0 * std::f32::consts::PI).sqrt()).exp();
        (feasible(&g.map(|x| x * scale)), feasible(&sh::hybrid::<9>(&f, 0.5)), true)
    });
    decide("log_occlusion", "keys from 1 to 1.001 of a table of 64 entries: inside it", |d| {
        let u = d.uniform(1.0, 1.001);
        let table: Vec<f32> = (0..64 * 3).map(|i| -(i as f32)).collect();
        let row = sh::log_occlusion::<3>(&table, 64, u);
        // Neither beyond the table nor drawn on beyond its end.
        (((u * 63.0) as usize + 1) < 64, row[..] == table[63 * 3..], true)
    });
}

#[test]
fn depths() {
    row("variance_from_moments", "depths at 0.9, spread 1e-4: raw moments", 1e-4, |d| {
        let depths: Vec<f32> = (0..16).map(|_| 0.9 + d.uniform(-1e-4, 1e-4)).collect();
        let moments = |of: &dyn Fn(f32) -> f32| {
            let (mut a, mut b) = (0.0f32, 0.0f32);
            for &z in &depths {
                (a, b) = (a + of(z), b + of(z) * of(z));
            }
            (a / 16.0, b / 16.0)
        };
        let (m1, m2) = moments(&|z| z);
        let (low, high) = (0.8995f32, 0.9005f32);
        let (s1, s2) = moments(&|z| layer_coordinate(z, low, high));
        let half = 0.5 * (high - low);
        let mean = depths.iter().map(|&z| f64::from(z)).sum::<f64>() / 16.0;
        let right = depths.iter().map(|&z| (f64::from(z) - mean).powi(2)).sum::<f64>() / 16.0;
        (m2 - m1 * m1, variance_from_moments(s1, s2, 0.0) * half * half, right)
    });
    row("depth_coverage", "windows narrower than σ/20", 1e-5, |d| {
        let sigma = d.log_uniform(1e-3, 1.0);
        let radius = sigma * d.log_uniform(1e-6, 1e-3);
        let offset = sigma * d.uniform(-2.0, 2.0);
        let (q, w) = (f64::from(offset) / f64::from(sigma), f64::from(radius) / f64::from(sigma));
        let density = (-0.5 * q * q).exp() / (2.0 * std::f64::consts::PI).sqrt();
        let right = 2.0 * w * density * (1.0 + (q * q - 1.0) * w * w / 6.0);
        let scale = 1.0 / (sigma * 2f32.sqrt());
        let usual = 0.5 * (erf((offset + radius) * scale) - erf((offset - radius) * scale));
        (usual, depth_coverage(0.0, sigma, offset, radius), right)
    });
    row("depth_coverage", "σ = 0, on the window's rim too", 0.0, |d| {
        let (mean, radius) = (0.5f32, 0.25f32);
        let (centre, right) = match d.bits() % 3 {
            0 => (mean - radius, 0.5),
            1 => (mean + radius * d.uniform(-0.99, 0.99), 1.0),
            _ => (mean + radius * d.uniform(1.01, 2.0), 0.0),
        };
        // 0 · ∞ on the rim.
        let scale = 1.0 / (0.0 * 2f32.sqrt());
        let usual = 0.5 * (erf((centre - mean + radius) * scale) - erf((centre - mean - radius) * scale));
        (usual, depth_coverage(mean, 0.0, centre, radius), right)
    });
    row("gaussian_falloff", "σ = 0, at the middle", 0.0, |_| {
        let sigma = 0.0f32;
        ((-0.5 * (0.0f32 / sigma).powi(2)).exp(), gaussian_falloff(0.0, sigma), 1.0)
    });
    row("layer_decay", "two layers, over their overlap and at the outer ends: sum 1", 1e-5, |d| {
        let (cut, overlap) = (d.uniform(0.3, 0.7), d.uniform(0.01, 0.1));
        let z = match d.bits() % 3 {
            0 => cut + d.uniform(-0.5, 0.5) * overlap,
            1 => d.uniform(0.0, 1.0) * overlap,
            _ => 1.0 - d.uniform(0.0, 1.0) * overlap,
        };
        let (end, begin) = (cut + 0.5 * overlap, cut - 0.5 * overlap);
        // As printed each layer fades at both ends, the first at 0 and the last at 1 too.
        let printed = |low: f32, high: f32| {
            ((z - low) / overlap).clamp(0.0, 1.0) * ((high - z) / overlap).clamp(0.0, 1.0)
        };
        let sum =
            layer_decay(z, 0.0, end, overlap, true, false) + layer_decay(z, begin, 1.0, overlap, false, true);
        (printed(0.0, end) + printed(begin, 1.0), sum, 1.0)
    });
}

#[test]
fn lobes() {
    row("spread_to_variance", "normals spread by 1e-3: σ² from their mean length", 1e-4, |d| {
        let normals: Vec<Vec3> = (0..8)
            .map(|_| Vec3::new(d.uniform(-1e-3, 1e-3), d.uniform(-1e-3, 1e-3), 1.0).normalize())
            .collect();
        let mean = normals.iter().sum::<Vec3>() / 8.0;
        let spread = normals.iter().map(|n| (*n - mean).length_squared()).sum::<f32>() / 8.0;
        let at = |axis: usize| normals.iter().map(|n| f64::from(n[axis])).sum::<f64>() / 8.0;
        let exact = [at(0), at(1), at(2)];
        let squared = normals
            .iter()
            .map(|n| (0..3).map(|axis| (f64::from(n[axis]) - exact[axis]).powi(2)).sum::<f64>())
            .sum::<f64>()
            / 8.0;
        let short = exact.iter().map(|x| x * x).sum::<f64>().sqrt();
        let right = squared / (short * (1.0 + short));
        (length_to_variance(mean.length()), spread_to_variance(spread, mean.length()), right)
    });
    decide(
        "length_to_variance",
        "opposite normals, or a length above 1 by rounding: finite and ≥ 0",
        |d| {
            let length = if d.bits().is_multiple_of(2) { 0.0 } else { 1.0 + f32::EPSILON };
            let fine = |x: f32| x.is_finite() && x >= 0.0;
            (fine((1.0 - length) / length), fine(length_to_variance(length)), true)
        },
    );
    row("lobe_offset", "lobes of 1e-3 … 1e-2 rad from an f32 cosine, n = 1000", 1e-4, |d| {
        let angle = d.log_uniform(1e-3, 1e-2);
        let (a, b) = (Vec3::Z, Vec3::new(angle.sin(), 0.0, angle.cos()));
        let gap = 0.5 * length(a - b).powi(2);
        let right = -(1000.0 * (-gap).ln_1p()).exp_m1();
        (1.0 - a.dot(b).powf(1000.0), lobe_offset(one_minus_cosine(a, b), 1000.0), right)
    });
    row("lobe_offset", "directions behind the surface, fractional n", 0.0, |d| {
        let cosine = d.uniform(-1.0, -0.1);
        (1.0 - cosine.powf(2.5), lobe_offset(1.0 - cosine, 2.5), 1.0)
    });
    row("cone_deviation", "needles: σ_v as printed, cos ψ", 1e-5, |d| {
        let angle = d.uniform(0.01, 0.2);
        (angle.cos(), cone_deviation(angle), (0.5 * f64::from(angle)).tan())
    });
}

#[test]
fn cones() {
    row("corrected_opacity", "opacities of 1e-8 … 1e-4", 3e-7, |d| {
        let (alpha, ratio) = (d.log_uniform(1e-8, 1e-4), d.uniform(0.1, 0.9));
        let right = -(f64::from(ratio) * (-f64::from(alpha)).ln_1p()).exp_m1();
        (1.0 - (1.0 - alpha).powf(ratio), corrected_opacity(alpha, ratio), right)
    });
    row("corrected_opacity", "opaque voxels, short steps: a logarithm that saturates", 0.0, |d| {
        let ratio = d.uniform(0.01, 0.1);
        (1.0 - (ratio * f32::MIN_POSITIVE.ln()).exp(), corrected_opacity(1.0, ratio), 1.0)
    });
    row("premultiplied_scale", "opacities of 1e-30 … 1e-10", 5e-7, |d| {
        let (alpha, ratio) = (d.log_uniform(1e-30, 1e-10), d.uniform(0.1, 0.9));
        ((1.0 - (1.0 - alpha).powf(ratio)) / alpha, premultiplied_scale(alpha, ratio), f64::from(ratio))
    });
    row("accumulate", "a segment in eight steps, as printed", 1e-6, |d| {
        let (alpha, colour) = (d.uniform(0.1, 0.9), d.uniform(0.1, 1.0));
        let step = corrected_opacity(alpha, 0.125);
        let (mut printed, mut printed_alpha, mut own) = (0.0f32, 0.0f32, Vec4::ZERO);
        for _ in 0..8 {
            printed = printed_alpha * printed + (1.0 - printed_alpha) * step * colour;
            printed_alpha += (1.0 - printed_alpha) * step;
            own = accumulate(own, Vec3::splat(colour), step);
        }
        (printed, own.x, f64::from(alpha) * f64::from(colour))
    });
    row("mip_level", "cones narrower than a voxel, and without width", 0.0, |d| {
        let diameter = if d.bits().is_multiple_of(4) { 0.0 } else { d.uniform(0.0, 0.99) };
        (diameter.log2(), mip_level(diameter, 8.0), 0.0)
    });
    decide("step_length", "cones without width: a step above 0", |d| {
        let (voxel, factor) = (d.uniform(0.1, 1.0), d.uniform(0.0, 1.0));
        (0.0 * factor > 0.0, step_length(0.0, voxel, factor) > 0.0, true)
    });
    decide("aperture_tangent", "half angles of 85° to 90°: at most 11.44", |d| {
        let angle = d.uniform(85.1f32, 90.0).to_radians();
        (angle.tan() <= 11.44, aperture_tangent(angle) <= 11.44, true)
    });
}

#[test]
fn weights() {
    let samples = |depth: f32, normal: Vec3| CoarseSamples {
        bilinear: [0.25; 4],
        depth: [depth; 4],
        normal: [normal; 4],
    };
    row("upsampling_weights", "no sample matches: the sum of weights", 1e-6, |d| {
        // 88° apart: the 32nd power of the cosine underflows.
        let normal = Vec3::new(1.0, d.uniform(0.0, 0.01), 0.0).normalize();
        let weights = upsampling_weights(&samples(1.0, normal), 1.0, Vec3::Y);
        let usual = normal.y.max(0.0).powi(32) * 0.25;
        (4.0 * usual / (4.0 * usual), weights.iter().sum(), 1.0)
    });
    row("depth_similarity", "the same depth, ε = 0: weight over weight", 1e-6, |d| {
        let z = d.uniform(1.0, 10.0);
        let usual = 1.0 / (z - z).abs();
        (usual / usual, depth_similarity(z, z) / depth_similarity(z, z), 1.0)
    });
    row("normal_similarity", "normals that are opposite: an even power", 0.0, |d| {
        let n = Vec3::new(d.uniform(-0.1, 0.1), 1.0, 0.0).normalize();
        (n.dot(-n).powi(32), normal_similarity(n, -n), 0.0)
    });
    row("normal_similarity", "one normal, whose square rounds to above 1: what is over 1", 0.0, |d| {
        let n = Vec3::new(d.uniform(-1.0, 1.0), d.uniform(-1.0, 1.0), 1.0).normalize();
        ((n.dot(n).powi(32) - 1.0).max(0.0), (normal_similarity(n, n) - 1.0).max(0.0), 0.0)
    });
    row("mean_or_zero", "no neighbour", 0.0, |_| (0.0f32 / 0.0, mean_or_zero(Vec3::ZERO, 0.0).x, 0.0));
}
