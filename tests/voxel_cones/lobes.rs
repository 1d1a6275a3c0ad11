//! Do glossy voxels mirror what glossy surfaces would?

use crate::support::*;
use crate::{cpu, indirect, render_on};
use glam::Vec3;
use twinlight::picture::Picture;
use twinlight::report::error::picture_error;
use twinlight::scene::{Scene, light};
use twinlight::technique::reference::{Bounces, Reference};
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{Cones, Job, LightPart};
use twinlight_kernels::passes::material::phong_lobe;
use twinlight_kernels::passes::scene::Material;
use twinlight_kernels::passes::voxel_cones::lobes::{cone_variance, mirrored, pack_mean, unpack_mean};
use twinlight_kernels::passes::voxel_cones::storage::pack_radiance;
use twinlight_kernels::sampling::hash::{hash, unit_float};

fn unit(i: u32) -> Vec3 {
    let z = 2.0 * unit_float(hash(2 * i)) - 1.0;
    let (s, c) = (std::f32::consts::TAU * unit_float(hash(2 * i + 1))).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(r * c, r * s, z)
}

#[test]
fn words_keep_means() {
    for i in 0..2_000 {
        let mean = unit(i) * unit_float(hash(i ^ 77));
        let got = unpack_mean(pack_mean(mean));
        assert!((got - mean).abs().max_element() < 0.001, "{mean} became {got}");
    }
    assert_eq!(unpack_mean(pack_mean(Vec3::ZERO)), Vec3::ZERO);
    assert_eq!(unpack_mean(pack_mean(Vec3::splat(9.0))), Vec3::ONE);
    assert!(unpack_mean(pack_mean(Vec3::NAN)).is_finite());
    // As one would write it: a direction and a length.
    let apart = |mean: Vec3| mean.normalize() * mean.length();
    assert!([Vec3::ZERO, Vec3::NAN].iter().all(|mean| apart(*mean).is_nan()));
}

/// The words of a voxel that reflects an irradiance of 1 from one direction.
fn words(light: Vec3, normal: Vec3, exponent: f32) -> [u32; 4] {
    [pack_radiance(Vec3::ONE), pack_mean(light), pack_mean(normal), (1.0 / (1.0 + exponent)).to_bits()]
}

#[test]
fn a_voxel_of_one_surface_mirrors_as_the_surface() {
    let normal = Vec3::Y;
    for exponent in [3.0f32, 20.0] {
        for i in 0..300 {
            let (light, viewer) = (unit(i), unit(i + 1_000));
            let (light, viewer) = (light * light.y.signum(), viewer * viewer.y.signum());
            let got = mirrored(&words(light, normal, exponent), 0, -viewer, 0.0).x;
            let right = phong_lobe(normal, viewer, light, exponent);
            // Means are kept to 0.001, which widens the lobe a little.
            assert!((got - right).abs() < 0.08 * (exponent + 2.0) / 6.0, "{got} for {right}");
        }
    }
    let above = words(Vec3::Y, normal, 5.0);
    assert_eq!(mirrored(&above, 0, Vec3::Y, 0.0), Vec3::ZERO, "nothing is mirrored backward");
}

#[test]
fn wider_lobes_send_as_much() {
    // ∫ L cos of the angle off the mirror is (n + 2)/(n + 1)·R, whatever the variance adds up to.
    for (cone, shortness) in [(0.0, 1.0), (0.3, 1.0), (0.0, 0.7), (0.9, 0.5)] {
        let light = Vec3::new(0.0, shortness, 0.0);
        let w = words(light, Vec3::Y, 8.0);
        let count = 40_000;
        let mut sum = 0.0f64;
        for i in 0..count {
            let viewer = unit(i);
            if viewer.y > 0.0 {
                sum += f64::from(mirrored(&w, 0, -viewer, cone).x);
            }
        }
        let whole = sum * 4.0 * std::f64::consts::PI / f64::from(count);
        println!("cone {cone}, mean of length {shortness}: {whole:.3}");
        // The axis is the normal: nothing of the lobe is cut off. Means are kept to 0.001, angles are summed by 40,000 points.
        assert!((whole - 10.0 / 9.0).abs() < 0.03, "{whole}");
    }
    assert!((cone_variance(1.0) - 0.1716).abs() < 1e-3, "tan²(22.5°)");
    // Nothing known of directions: as good as a dull surface.
    let blind = mirrored(&words(Vec3::ZERO, Vec3::ZERO, 8.0), 0, Vec3::NEG_Y, 0.0);
    assert!(blind.is_finite() && blind.x <= 0.33, "{blind}");
}

fn reference(s: &Scene) -> Picture {
    let settings = Reference { emissive: false, ..settings(Bounces::Count(1), 1024) };
    trace(s, &view(&s.view(), 48, 48), &settings).indirect
}

#[test]
fn a_metal_block_throws_its_patch() {
    let s = Scene::open("cornell-glossy").unwrap();
    let mut dull = s.clone();
    for m in &mut dull.materials {
        if m.metallic > 0.0 {
            // As glossy voxels were before: what metal mirrors is lost.
            m.base = (m.base.truncate() * 0.0).extend(1.0);
            m.metallic = 0.0;
            m.roughness = 1.0;
        }
    }
    let view = view(&s.view(), 48, 48);
    let right = reference(&s);
    let settings =
        VoxelCones { cones: Cones { count: 32, ..Cones::default() }, resolution: 64, ..Default::default() };
    let with = picture_error(&indirect(&s, &view, &settings, false), &right).unwrap();
    let without = picture_error(&indirect(&dull, &view, &settings, false), &right).unwrap();
    println!("with lobes {with:?}\nwithout {without:?}");
    assert!((with.mean_ratio - 1.0).abs() < 0.06, "{with:?}");
    assert!(without.mean_ratio < 0.95 && without.relative_rmse > with.relative_rmse, "negative control");
}

#[test]
fn dull_scenes_have_no_lobes() {
    let passes = |name: &str| {
        let s = Scene::open(name).unwrap();
        let job = Job { light: LightPart::Indirect, ..Job::default() };
        let settings = VoxelCones { resolution: 32, light_map: 96, ..Default::default() };
        let (rendered, _) = render_on(&mut cpu(), &s, &view(&s.view(), 16, 16), &job, &settings, false);
        rendered.timings.iter().filter(|t| t.pass.contains("lobes")).count()
    };
    assert_eq!(passes("cornell-box"), 0);
    assert!(passes("cornell-glossy") > 2);
}

#[test]
fn a_second_bounce_keeps_the_lobes() {
    // The last floor reflects nothing diffusely: all that its leaves hold is lobes.
    let black = Material { base: Vec3::ZERO.extend(1.0), metallic: 0.0, roughness: 0.4, ..metal(0.9, 0.5) };
    for floor in [metal(0.9, 0.5), black] {
        let mut s = scene();
        square(&mut s, 0.0, 1.0, true, floor);
        let wall = [v(-1.0, 0.0, -1.0), v(1.0, 0.0, -1.0), v(1.0, 1.5, -1.0), v(-1.0, 1.5, -1.0)];
        quad(&mut s, wall, grey(0.5));
        let down = v(0.0, -0.9, -0.6).normalize();
        s.lights = vec![light::spot(v(0.0, 1.4, 0.9), down, Vec3::splat(4.0), 0.2, 0.3)];
        let view = view(&camera(v(0.0, 0.7, 2.0), v(0.0, 0.7, -1.0), 40.0), 24, 24);
        let mean = |bounces| {
            let cones = Cones { count: 32, ..Cones::default() };
            let settings = VoxelCones { bounces, cones, resolution: 64, ..Default::default() };
            indirect(&s, &view, &settings, false).mean().y
        };
        let (one, two) = (mean(1), mean(2));
        println!("one bounce {one:.4}, two {two:.4}");
        assert!(one > 0.0 && two >= 0.999 * one && two < 1.6 * one, "{one}, {two}");
    }
}
