//! Which hard cases have an exact answer that the usual formula does not give?

// Planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/draw.rs"]
mod draw;
mod oracle;
#[path = "oracle/sh.rs"]
mod sh_oracle;

use draw::Draw;
use glam::{Vec3, Vec4};
use twinlight_kernels::gaussian::{minimum_deviation, weighted_moments};
use twinlight_kernels::math::without_faint;
use twinlight_kernels::passes::soft_gi::shade::overlap_share;
use twinlight_kernels::sh::*;

#[test]
fn nothing_in_a_texel_has_no_depth_and_the_least_variance() {
    let floor = minimum_deviation(1.0, 0.0);
    for opacity in [0.0, -0.0, f32::MIN_POSITIVE, f32::NAN] {
        let (mean, variance) = weighted_moments(opacity, 0.0, 0.0, floor);
        assert_eq!((mean, variance), (0.0, floor * floor), "{opacity}");
    }
    let usual = |m1: f32, opacity: f32| m1 / opacity;
    assert!(usual(0.0, 0.0).is_nan(), "planted fault: moments over the opacity");
    // Negative control: half a texel's depths are those of a whole one's.
    assert_eq!(weighted_moments(0.5, 0.25, 0.25, 0.1), weighted_moments(1.0, 0.5, 0.5, 0.1));
}

#[test]
fn proxies_that_cover_nothing_do_not_overlap() {
    let mut draw = Draw::new(77);
    assert_eq!(overlap_share(0.0, 0.0), 1.0);
    let mut usual_is_off = 0;
    for _ in 0..1000 {
        let angle = draw.log_uniform(1e-38, 1e-4);
        // What is covered is known to some 1e-7 of the sphere, which is all of a small angle.
        let covered = angle / (4.0 * std::f32::consts::PI).sqrt() + draw.uniform(-1e-6, 1e-6);
        assert_eq!(overlap_share(covered, angle), 1.0);
        let usual = covered * (4.0 * std::f32::consts::PI).sqrt() / angle;
        usual_is_off += u32::from(!(0.9..1.1).contains(&usual));
    }
    assert!(usual_is_off > 500, "planted fault: the quotient is right but for {usual_is_off} of 1000");
}

#[test]
fn no_more_than_half_of_all_directions_is_covered() {
    let all = 4.0 * std::f32::consts::PI;
    // 256 proxies in one place, and what a cheap exponential says of them: 90 % of everything.
    let (covered, solid_angle) = (0.9 * UNIT, 0.6 * all);
    let share = overlap_share(covered, solid_angle);
    assert!((share - 0.5 / 0.6).abs() < 1e-6, "{share}");
    let usual = (covered * UNIT / solid_angle).min(1.0);
    assert!(usual * solid_angle > 0.55 * all, "planted fault: proxies would send from below the surface");
}

#[test]
fn light_too_faint_for_a_device_is_none() {
    let kept = without_faint(Vec4::new(1e-27, -1e-27, 0.5, 1e30));
    assert_eq!(kept, Vec4::new(1e-27, -1e-27, 0.5, 1e30));
    let mut draw = Draw::new(78);
    let mut differ = 0;
    for _ in 0..1000 {
        // A sum of terms near 2⁻¹²⁶, on a device that flushes them and on one that does not.
        let terms: [f32; 4] = std::array::from_fn(|_| draw.log_uniform(1e-40, 1e-36));
        let flushed = |x: &f32| if x.is_subnormal() { 0.0 } else { *x };
        let sums = [terms.iter().sum::<f32>(), terms.iter().map(flushed).sum::<f32>()];
        differ += u32::from(sums[0] != sums[1]);
        let [one, other] = sums.map(|sum| without_faint(Vec4::splat(sum)));
        assert!(one == other && one == Vec4::ZERO);
    }
    assert!(differ > 100, "planted fault: plain sums differ in {differ} of 1000");
}

/// A blocker more lets no more light through, but for the ringing of few bands, which may be 0.056 of all light.
#[test]
fn a_further_blocker_brightens_by_no_more_than_ringing() {
    const ENTRIES: u32 = 64;
    let algebra = sh_oracle::Algebra::new(4);
    let table = sh_oracle::log_occlusion_table(&algebra, ENTRIES as usize);
    let all = (4.0 * std::f32::consts::PI).sqrt();
    let mut draw = Draw::new(79);
    let mut rises = Vec::new();
    let mut bright = 0;
    for _ in 0..300 {
        let mut f = [0.0f32; 16];
        let mut before = all;
        for _ in 0..32 {
            let (z, phi) = (draw.uniform(-1.0, 1.0), draw.uniform(0.0, std::f32::consts::TAU));
            let r = (1.0 - z * z).sqrt();
            let zonal: [f32; 4] = log_occlusion(&table, ENTRIES, occlusion_key(draw.log_uniform(0.1, 0.7)));
            f = add_scaled(&f, &rotate_zonal(&zonal, Vec3::new(r * phi.cos(), r * phi.sin(), z)), 1.0);
            let after = hybrid(&f, 0.5)[0];
            rises.push((after - before) / all);
            before = after;
        }
        bright += u32::from(before > 0.9 * all);
    }
    rises.sort_by(f32::total_cmp);
    let (most, nearly) = (rises[rises.len() - 1], rises[rises.len() - 1 - rises.len() / 1000]);
    println!("rise of a blocker: {most:.4} at most, {nearly:.4} for 99.9 %, {:.4} at least", rises[0]);
    assert!(most <= 0.056 && nearly <= 0.03, "{most} {nearly}");
    // Negative control: blockers do darken, and all 32 of them much.
    assert!(rises[0] < -0.03 && bright == 0, "{} {bright}", rises[0]);
}
