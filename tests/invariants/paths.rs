//! Does the path tracer tell the same in other units, elsewhere, turned, with its axes swapped, under other magnitudes of light?

use crate::SIDE;
use crate::places::{brighter, maps, scaled};
use crate::support::{mapped, settings, trace, view};
use glam::{Mat3, Vec3};
use twinlight::report::error::picture_error;
use twinlight::scene::{Camera, Scene};
use twinlight::technique::reference::{Bounces, Reference, ReferenceResult};

const SAMPLES: u32 = 64;

fn traced(scene: &Scene, camera: &Camera) -> ReferenceResult {
    // Lights alone: what surfaces emit is not scaled with them.
    let settings = Reference { emissive: false, ..settings(Bounces::Count(2), SAMPLES) };
    trace(scene, &view(camera, SIDE, SIDE), &settings)
}

#[test]
fn units_places_and_axes_do_not_matter() {
    let s = Scene::open("cornell-box").unwrap();
    let base = traced(&s, &s.view()).all();
    let mut row = String::new();
    for (what, turn, scale, shift, kind) in maps() {
        let (s, camera) = mapped(&s, turn, scale, shift);
        let e = picture_error(&traced(&s, &camera).all(), &base).unwrap();
        row += &format!(" {:.4}, {:.1} % |", e.mean_ratio, 100.0 * e.relative_rmse);
        // Moved and scaled, paths are the same but where they pass edges; else they are others, and noise is what differs.
        let (mean, rmse) = if kind == 0 { (2e-3, 0.06) } else { (0.02, 0.3) };
        assert!((e.mean_ratio - 1.0).abs() < mean && e.relative_rmse < rmse, "{what}: {e:?}");
    }
    println!("| reference |{row}");
    // Negative control: other proportions.
    let (s, camera) = mapped(&s, Mat3::from_diagonal(Vec3::new(1.0, 1.4, 1.0)), 1.0, Vec3::ZERO);
    let e = picture_error(&traced(&s, &camera).all(), &base).unwrap();
    assert!((e.mean_ratio - 1.0).abs() > 0.02, "{e:?}");
}

#[test]
fn a_million_times_the_light_is_a_million_times_the_picture() {
    let s = Scene::open("cornell-box").unwrap();
    let base = traced(&s, &s.view()).all();
    for factor in [1e6, 1e-6, 2f32.powi(20), 2f32.powi(-20)] {
        let got = traced(&brighter(&s, factor), &s.view()).all();
        let e = picture_error(&got, &scaled(&base, factor)).unwrap();
        println!("reference × {factor:e}: {:.1e} RMSE, mean ratio {:.7}", e.relative_rmse, e.mean_ratio);
        let rounding = if factor.log2().fract() == 0.0 { 0.0 } else { 2e-6 };
        assert!(e.relative_rmse <= rounding, "× {factor:e}: {e:?}");
        let off = picture_error(&got, &scaled(&base, factor * 1.02)).unwrap();
        assert!(off.relative_rmse > rounding, "negative control: {off:?}");
    }
}
