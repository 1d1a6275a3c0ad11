//! Does the light stay what it is when the scene is turned, moved or mirrored, or cones step otherwise?

use crate::indirect;
use crate::support::*;
use glam::{Mat3, Vec3};
use twinlight::picture::Picture;
use twinlight::report::error::picture_error;
use twinlight::scene::Scene;
use twinlight::technique::Cones;
use twinlight::technique::voxel_cones::VoxelCones;

fn seen(turn: Mat3, shift: Vec3, settings: &VoxelCones) -> Picture {
    let (s, camera) = mapped(&Scene::open("cornell-box").unwrap(), turn, 1.0, shift);
    indirect(&s, &view(&camera, 32, 32), settings, false)
}

fn base_settings() -> VoxelCones {
    VoxelCones { resolution: 64, cones: Cones { count: 32, ..Cones::default() }, ..Default::default() }
}

#[test]
fn places_and_axes_do_not_matter() {
    let settings = base_settings();
    let base = seen(Mat3::IDENTITY, Vec3::ZERO, &settings);
    let swapped = Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X);
    // What is left of turning: slanted walls leak at coarse levels, whose columns they cover in part.
    for (what, turn, shift, (mean, rmse)) in [
        ("moved", Mat3::IDENTITY, Vec3::new(3.0, -7.0, 11.0), (0.002, 0.02)),
        ("axes swapped", swapped, Vec3::ZERO, (0.03, 0.2)),
        ("turned by 90°", Mat3::from_rotation_y(std::f32::consts::FRAC_PI_2), Vec3::ZERO, (0.03, 0.25)),
        ("turned by 20°", Mat3::from_rotation_y(0.35), Vec3::ZERO, (0.05, 0.2)),
        (
            "turned about all axes",
            Mat3::from_euler(glam::EulerRot::XYZ, 0.4, 0.3, 0.2),
            Vec3::ZERO,
            (0.13, 0.3),
        ),
    ] {
        let e = picture_error(&seen(turn, shift, &settings), &base).unwrap();
        println!("{what}: RMSE {:.1} %, mean ratio {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        assert!((e.mean_ratio - 1.0).abs() < mean && e.relative_rmse < rmse, "{what}: {e:?}");
    }
    // Negative control: a scene of other size is another.
    let other = seen(Mat3::from_diagonal(Vec3::new(1.0, 1.5, 1.0)), Vec3::ZERO, &settings);
    let e = picture_error(&other, &base).unwrap();
    assert!((e.mean_ratio - 1.0).abs() > 0.05 || e.relative_rmse > 0.3, "{e:?}");
}

#[test]
fn steps_do_not_matter() {
    let with = |step: f32| {
        seen(
            Mat3::IDENTITY,
            Vec3::ZERO,
            &VoxelCones { cones: Cones { step, ..base_settings().cones }, ..base_settings() },
        )
    };
    let fine = with(0.125);
    for step in [0.25, 0.5, 1.0] {
        let e = picture_error(&with(step), &fine).unwrap();
        println!("step {step}: RMSE {:.2} %, mean ratio {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        assert!((e.mean_ratio - 1.0).abs() < 0.03 && e.relative_rmse < 0.12, "{step}: {e:?}");
    }
    let e = picture_error(&with(16.0), &fine).unwrap();
    assert!((e.mean_ratio - 1.0).abs() > 0.03 || e.relative_rmse > 0.12, "negative control: {e:?}");
}
