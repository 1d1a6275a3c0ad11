//! Does a picture stay what it is in other units, elsewhere, turned, with its axes swapped, under other magnitudes of light?

use crate::support::mapped;
use crate::{render, subjects};
use glam::{EulerRot, Mat3, Vec3};
use std::f32::consts::FRAC_PI_2;
use twinlight::picture::Picture;
use twinlight::plan::Technique;
use twinlight::report::error::picture_error;
use twinlight::scene::{Environment, Scene};

/// By how much means and pictures may change: moved or scaled, axes swapped, turned.
fn allowed(technique: &Technique) -> [(f64, f64); 3] {
    match technique {
        // Rays: only those that pass an edge may decide otherwise, a pixel here and there.
        Technique::Direct => [(1e-3, 0.01), (2e-3, 0.08), (2e-3, 0.08)],
        // Another frame has other rays.
        Technique::AmbientOcclusion => [(0.01, 0.1), (0.02, 0.12), (0.02, 0.12)],
        Technique::VisibilityFilter(_) => [(0.02, 0.1), (0.05, 0.15), (0.06, 0.2)],
        // Slanted walls leak at coarse levels, whose columns they cover in part.
        Technique::VoxelCones(_) => [(0.01, 0.06), (0.03, 0.2), (0.13, 0.3)],
        Technique::LayeredRsm(_) => [(0.01, 0.06), (0.04, 0.12), (0.18, 0.3)],
        Technique::SoftGi(_) => [(2e-3, 5e-3), (2e-3, 5e-3), (2e-3, 5e-3)],
    }
}

/// What a map is called, its turn, scale and shift, and which of [`allowed`] it is.
type Map = (&'static str, Mat3, f32, Vec3, usize);

pub fn maps() -> [Map; 6] {
    let swapped = Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X);
    let slanted = Mat3::from_euler(EulerRot::XYZ, 0.4, 0.3, 0.2);
    let far = Vec3::new(3.0, -7.0, 11.0);
    [
        ("moved", Mat3::IDENTITY, 1.0, far, 0),
        ("in millimetres", Mat3::IDENTITY, 1e3, Vec3::ZERO, 0),
        ("in kilometres", Mat3::IDENTITY, 1e-3, Vec3::ZERO, 0),
        ("axes swapped", swapped, 1.0, Vec3::ZERO, 1),
        ("turned by 90°", Mat3::from_rotation_y(FRAC_PI_2), 1.0, Vec3::ZERO, 1),
        ("turned about all axes", slanted, 1.0, Vec3::ZERO, 2),
    ]
}

#[test]
fn units_places_and_axes_do_not_matter() {
    println!("| technique | {} |", maps().map(|m| m.0).join(" | "));
    for (scene, technique) in subjects() {
        let base = render(&scene, &scene.view(), &technique);
        let mut row = String::new();
        let mut faults = Vec::new();
        for (what, turn, scale, shift, kind) in maps() {
            let (s, camera) = mapped(&scene, turn, scale, shift);
            let e = picture_error(&render(&s, &camera, &technique), &base).unwrap();
            row += &format!(" {:.4}, {:.1} % |", e.mean_ratio, 100.0 * e.relative_rmse);
            let (mean, rmse) = allowed(&technique)[kind];
            if !((e.mean_ratio - 1.0).abs() <= mean && e.relative_rmse <= rmse) {
                faults.push(what);
            }
        }
        println!("| {} |{row}", technique.name());
        assert!(faults.is_empty(), "{}: {faults:?} change the picture:{row}", technique.name());
        // Negative control: a picture of other proportions is another.
        let (s, camera) = mapped(&scene, Mat3::from_diagonal(Vec3::new(1.0, 1.4, 1.0)), 1.0, Vec3::ZERO);
        let e = picture_error(&render(&s, &camera, &technique), &base).unwrap();
        let (mean, rmse) = allowed(&technique)[2];
        assert!((e.mean_ratio - 1.0).abs() > mean || e.relative_rmse > rmse, "{}: {e:?}", technique.name());
    }
}

pub fn brighter(scene: &Scene, factor: f32) -> Scene {
    let mut s = scene.clone();
    s.lights.iter_mut().for_each(|l| l.intensity *= factor);
    if let Environment::Constant(c) = &mut s.environment {
        *c *= factor;
    }
    s
}

pub fn scaled(picture: &Picture, factor: f32) -> Picture {
    let mut p = picture.clone();
    p.pixels.iter_mut().for_each(|x| *x *= factor);
    p
}

#[test]
fn a_million_times_the_light_is_a_million_times_the_picture() {
    for (scene, technique) in subjects() {
        if matches!(technique, Technique::AmbientOcclusion) {
            continue;
        }
        let base = render(&scene, &scene.view(), &technique);
        // Powers of two change no digit, others round otherwise what is kept in few bits.
        for factor in [1e6, 1e-6, 2f32.powi(20), 2f32.powi(-20)] {
            let got = render(&brighter(&scene, factor), &scene.view(), &technique);
            let e = picture_error(&got, &scaled(&base, factor)).unwrap();
            println!(
                "{} × {factor:e}: {:.1e} RMSE, mean ratio {:.7}",
                technique.name(),
                e.relative_rmse,
                e.mean_ratio
            );
            let rounding = match technique {
                _ if factor.log2().fract() == 0.0 => 0.0,
                Technique::VisibilityFilter(_) => 5e-4,
                _ => 2e-6,
            };
            assert!(e.relative_rmse <= rounding, "{} × {factor:e}: {e:?}", technique.name());
            let off = picture_error(&got, &scaled(&base, factor * 1.02)).unwrap();
            assert!(off.relative_rmse > rounding, "negative control: {off:?}");
        }
    }
}
