//! Do cones that each pixel turns another way make up for few of them, and does their mean stay on its surface?

use crate::cpu;
use crate::support::*;
use glam::{Vec3, Vec4};
use twinlight::picture::Picture;
use twinlight::report::error::picture_error;
use twinlight::scene::Scene;
use twinlight::technique::reference::{Bounces, Reference};
use twinlight::technique::voxel_cones::{self, VoxelCones};
use twinlight::technique::{Cones, Job, LightPart, World};
use twinlight_kernels::passes::elements::{InterleavedParams, Surface};
use twinlight_kernels::passes::filter_interleaved;
use twinlight_kernels::sampling::interleaved::interleaved_turn;

const SIDE: u32 = 16;

/// Surfaces of two walls that meet between columns 7 and 8.
fn corner() -> Vec<Surface> {
    (0..SIDE * SIDE)
        .map(|i| {
            let (x, y) = ((i % SIDE) as f32 - 7.5, (i / SIDE) as f32);
            let left = x < 0.0;
            let position = if left { v(0.0, y, -x) } else { v(x, y, 0.0) };
            let normal = if left { Vec3::X } else { Vec3::Z };
            Surface {
                position: position.extend(5.0),
                normal: normal.extend(0.0),
                triangle: 0,
                ..Default::default()
            }
        })
        .collect()
}

fn filtered(surfaces: &[Surface], value: impl Fn(u32, u32) -> Vec4) -> Vec<Vec4> {
    let values: Vec<Vec4> = (0..SIDE * SIDE).map(|i| value(i % SIDE, i / SIDE)).collect();
    let params = InterleavedParams { columns: SIDE, rows: SIDE, ..Default::default() };
    (0..SIDE * SIDE).map(|i| filter_interleaved(i, &params, surfaces, &values)).collect()
}

#[test]
fn the_mean_has_every_turn_and_one_wall() {
    let walls = corner();
    // What depends on the turn alone is the same everywhere inside a wall: the mean of all sixteen.
    let turned =
        filtered(&walls, |x, y| Vec4::splat((std::f32::consts::TAU * interleaved_turn(x, y)).cos() + 2.0));
    for (x, y) in [(3, 4), (4, 9), (11, 5), (12, 11), (13, 8)] {
        let got = turned[(y * SIDE + x) as usize].x;
        assert!((got - 2.0).abs() < 1e-5, "{x}, {y}: {got}");
    }
    // One wall's light stays on it.
    let split = filtered(&walls, |x, _| Vec4::splat(if x < 8 { 1.0 } else { 3.0 }));
    for (i, got) in split.iter().enumerate() {
        let right = if i as u32 % SIDE < 8 { 1.0 } else { 3.0 };
        assert!((got.x - right).abs() < 1e-5, "pixel {i}: {got}");
    }
    // Negative control: over one plane the edge would be blurred.
    let flat: Vec<Surface> = (0..SIDE * SIDE)
        .map(|i| {
            let at = v((i % SIDE) as f32, (i / SIDE) as f32, 0.0);
            Surface {
                position: at.extend(5.0),
                normal: Vec3::Z.extend(0.0),
                triangle: 0,
                ..Default::default()
            }
        })
        .collect();
    let blurred = filtered(&flat, |x, _| Vec4::splat(if x < 8 { 1.0 } else { 3.0 }));
    assert!((1.5..2.0).contains(&blurred[7].x), "{}", blurred[7].x);
    // Nothing stays nothing, and a row of no pixels is refused no work.
    let nothing = Surface { triangle: u32::MAX, ..Default::default() };
    assert_eq!(filter_interleaved(0, &InterleavedParams::default(), &[nothing], &[Vec4::ONE]), Vec4::ZERO);
    let one = InterleavedParams { columns: 0, rows: 1, ..Default::default() };
    assert_eq!(filter_interleaved(0, &one, &walls[..1], &[Vec4::ONE]), Vec4::ONE);
}

#[test]
fn few_cones_are_made_up_for() {
    let s = Scene::open("cornell-box").unwrap();
    let view = view(&s.view(), 64, 64);
    let reference = Reference { emissive: false, ..settings(Bounces::Count(1), 1024) };
    let right = trace(&s, &view, &reference).indirect;
    let with = |interleave: bool| -> Picture {
        let cones = Cones { interleave, ..Cones::default() };
        let settings = VoxelCones { cones, illumination: Some((64, 64)), ..Default::default() };
        let job = Job { light: LightPart::Indirect, ..Job::default() };
        let mut cpu = cpu();
        let world = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
        voxel_cones::render(&mut cpu, &world, &view, &job, &settings).unwrap().0.picture
    };
    let [turned, alike] = [true, false].map(|i| picture_error(&with(i), &right).unwrap());
    println!("turned {turned:?}\nalike {alike:?}");
    assert!(turned.relative_rmse < 0.85 * alike.relative_rmse, "{turned:?}, {alike:?}");
    assert!((turned.mean_ratio - alike.mean_ratio).abs() < 0.03);
}
