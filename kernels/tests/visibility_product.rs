//! Is the product of visibilities what float64 makes of it, in order, and what do sums of logarithms miss of it?

// Oracles may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/draw.rs"]
mod draw;
mod oracle;
#[path = "oracle/sh.rs"]
mod sh_oracle;

use draw::Draw;
use glam::{Vec3, Vec4};
use sh_oracle::Algebra;
use twinlight_kernels::passes::elements::{ShVector, SoftParams, SphereProxy, Surface};
use twinlight_kernels::passes::soft_gi::accumulate::{
    accumulate_occlusion, exponentiate4, multiply_visibility,
};
use twinlight_kernels::passes::soft_gi::{HYBRID, PRODUCT};
use twinlight_kernels::sh;

const ENTRIES: u32 = 64;

/// No proxy is out of reach.
const FAR: f32 = 1e6;

fn params(order: u32, reach: f32, proxies: &[SphereProxy]) -> SoftParams {
    SoftParams {
        width: 1,
        height: 1,
        tile: 8,
        tiles_x: 1,
        proxies: proxies.len() as u32,
        order,
        exponential: PRODUCT,
        tau: 0.5,
        shadow_reach: reach,
        entries: ENTRIES,
        fade: sh::FADE,
        ..Default::default()
    }
}

/// A receiver at 0 whose normal is up.
fn receiver() -> Vec<Surface> {
    vec![Surface { position: Vec4::W, normal: Vec4::new(0.0, 1.0, 0.0, 1.0), ..Default::default() }]
}

/// Balls of these sines over the receiver, clear of its plane.
fn balls(draw: &mut Draw, sines: &[f32]) -> Vec<SphereProxy> {
    let one = |sine: &f32| {
        let d = loop {
            let d = Vec3::from_array(draw.direction());
            if d.y > sine + 0.01 {
                break d;
            }
        };
        SphereProxy { sphere: (d * 2.0).extend(2.0 * sine), albedo: Vec4::ONE }
    };
    sines.iter().map(one).collect()
}

fn multiplied(order: u32, reach: f32, proxies: &[SphereProxy]) -> ShVector {
    let lists: Vec<u32> = (0..proxies.len() as u32).collect();
    multiply_visibility(
        0,
        &params(order, reach, proxies),
        &receiver(),
        proxies,
        &[0],
        &[lists.len() as u32],
        &lists,
    )
}

fn numbers(v: &ShVector) -> [f32; 28] {
    bytemuck::cast(*v)
}

/// The product in float64, in the order of `proxies`; in the feasible ball after each. And the weights.
fn in_float64(order: usize, reach: f32, proxies: &[SphereProxy]) -> (Vec<f64>, Vec<f64>) {
    let algebra = Algebra::new(order);
    let mut seen = vec![0.0; order * order];
    seen[0] = sh_oracle::s4();
    let mut weights = Vec::new();
    for p in proxies {
        let b = sh::blocker(p.sphere.truncate(), p.sphere.w, Vec3::ZERO, Vec3::Y, sh::FADE);
        let u = sh::occlusion_key(b.alpha);
        let weight = f64::from(b.weight * sh::influence_weight(u, sh::influence_key(reach), 2.0));
        weights.push(weight);
        let whole = sh_oracle::visibility(order, sh_oracle::key(f64::from(b.alpha)));
        let zonal = sh_oracle::zonal_part(&whole, order);
        let y = sh_oracle::basis(order, b.direction.to_array().map(f64::from));
        // A zonal function about d: f_lm = √(4π/(2l + 1)) z_l y_lm(d).
        let past: Vec<f64> = (0..order * order)
            .map(|i| {
                let l = i.isqrt();
                let full = (4.0 * std::f64::consts::PI / (2 * l + 1) as f64).sqrt() * zonal[l] * y[i];
                let none = if i == 0 { sh_oracle::s4() } else { 0.0 };
                none + weight * (full - none)
            })
            .collect();
        seen = algebra.product(&seen, &past);
        sh_oracle::clamp_to_feasible(&mut seen);
    }
    (seen, weights)
}

fn worst(got: &ShVector, want: &[f64]) -> f64 {
    numbers(got).iter().zip(want).map(|(g, w)| (f64::from(*g) - w).abs()).fold(0.0, f64::max)
        / sh_oracle::s4()
}

#[test]
fn products_agree_with_float64_in_every_order() {
    let mut draw = Draw::new(91);
    let (mut most, mut turned) = (0.0f64, 0.0f64);
    for order in 2..=5 {
        for count in [1, 2, 5, 16] {
            let sines: Vec<f32> = (0..count).map(|_| draw.log_uniform(0.02, 0.7)).collect();
            let proxies = balls(&mut draw, &sines);
            let got = multiplied(order, FAR, &proxies);
            let (right, weights) = in_float64(order as usize, FAR, &proxies);
            assert!(weights.iter().all(|w| *w == 1.0));
            most = most.max(worst(&got, &right));
            // Planted fault: products of few bands are not associative, the order counts.
            let back: Vec<_> = proxies.iter().rev().copied().collect();
            turned = turned.max(worst(&multiplied(order, FAR, &back), &right));
            let covered = numbers(&got)[27];
            assert!((covered + got.c0.x - sh::UNIT).abs() < 1e-4, "{covered} and {}", got.c0.x);
        }
    }
    println!("off by {most:.1e} of √4π, in reverse order by {turned:.1e}");
    assert!(most < 2e-6 && turned > 1e-3, "{most} {turned}");
}

#[test]
fn fading_balls_cover_by_their_weight() {
    let mut draw = Draw::new(94);
    let (mut most, mut fading, mut without) = (0.0f64, 0u32, 0.0f64);
    for _ in 0..200 {
        // Near the end of their reach, and one that holds the receiver from below.
        let sine = draw.log_uniform(0.19, 0.29);
        let mut proxies = balls(&mut draw, &[sine, 0.4]);
        let sphere = Vec4::new(draw.uniform(0.2, 1.2), -draw.uniform(0.0, 0.9), 0.0, 1.0);
        proxies.push(SphereProxy { sphere, albedo: Vec4::ONE });
        let got = multiplied(4, 5.0, &proxies);
        let (right, weights) = in_float64(4, 5.0, &proxies);
        most = most.max(worst(&got, &right));
        fading += u32::from(weights.iter().any(|w| *w > 0.0 && *w < 1.0));
        without = without.max(worst(&multiplied(4, FAR, &proxies), &right));
    }
    println!(
        "{fading} of 200 sets hold a ball that fades: off by {most:.1e} of √4π, {without:.1e} were it whole"
    );
    assert!(most < 2e-6 && fading > 50 && without > 1e-3, "{most} {fading} {without}");
}

#[test]
fn what_small_balls_cover_keeps_its_digits() {
    let mut draw = Draw::new(92);
    let (mut most, mut of_difference) = (0.0f64, 0.0f64);
    for _ in 0..200 {
        let sine = draw.log_uniform(1e-4, 0.1);
        let got = multiplied(4, FAR, &balls(&mut draw, &[sine]));
        let b = f64::from(sine);
        // √4π of the visibility's coefficient is the solid angle over √4π.
        let want = 2.0 * std::f64::consts::PI * (b * b / (1.0 + (1.0 - b * b).sqrt())) / sh_oracle::s4();
        most = most.max((f64::from(numbers(&got)[27]) / want - 1.0).abs());
        of_difference = of_difference.max((f64::from(sh::UNIT - got.c0.x) / want - 1.0).abs());
    }
    println!("coverage off by {most:.1e}, by √4π − g₀ {of_difference:.1e}");
    assert!(most < 1e-5 && of_difference > 1e-2, "{most} {of_difference}");
}

#[test]
fn sums_of_logarithms_stand_for_products() {
    let algebra = Algebra::new(4);
    let table = sh_oracle::log_occlusion_table(&algebra, ENTRIES as usize);
    let mut draw = Draw::new(93);
    let rms = |count: usize, draw: &mut Draw| {
        let mut sum = 0.0f64;
        for _ in 0..40 {
            let sines: Vec<f32> = (0..count).map(|_| draw.log_uniform(0.1, 0.7)).collect();
            let proxies = balls(draw, &sines);
            let lists: Vec<u32> = (0..count as u32).collect();
            let p = SoftParams { exponential: HYBRID, ..params(4, FAR, &proxies) };
            let logs =
                accumulate_occlusion(0, &p, &receiver(), &proxies, &[0], &[count as u32], &lists, &table);
            let hybrid = numbers(&exponentiate4(0, &p, &[logs], &[0.0]));
            let product = numbers(&multiplied(4, FAR, &proxies));
            let square: f64 = (0..16).map(|i| f64::from(hybrid[i] - product[i]).powi(2)).sum();
            sum += square / (4.0 * std::f64::consts::PI);
        }
        (sum / 40.0).sqrt()
    };
    let [one, four, sixteen] = [1, 4, 16].map(|count| rms(count, &mut draw));
    println!(
        "hybrid beside the product, RMS: {one:.4} for one ball, {four:.4} for four, {sixteen:.4} for 16"
    );
    assert!(one < 3e-3 && four < 0.03 && sixteen < 0.12, "{one} {four} {sixteen}");
    assert!(sixteen > 5.0 * one, "negative control: they are not the same thing");
}
