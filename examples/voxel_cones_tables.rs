//! Prints how the knobs of voxel cone tracing trade error for time: the tables of `docs/voxel-cones.md`.
//!
//! `cargo run --release --example voxel_cones_tables [SAMPLES [SCENE]]`. Pictures of 512 × 512 are averaged to 128 × 128 and
//! compared with the path tracer's indirect light (SAMPLES paths for each of these pixels, 8192 if none are given) of one
//! bounce, and of two where two are asked for. Scenes from files are taken from the folder `TWINLIGHT_SCENES`, and left out
//! where it has none.

#[path = "common/tables.rs"]
mod tables;

use tables::{COARSE, Result, SIDE, Subject, error, reference, subjects};
use twinlight::backend::Cpu;
use twinlight::scene::{Scene, bvh::Bvh};
use twinlight::technique::voxel_cones::{self, VoxelCones, Voxelisation};
use twinlight::technique::{Cones, Job, LightPart, View, World, ambient_occlusion};

/// What a line of the table changes.
type Change = (&'static str, fn(&mut VoxelCones));

const CHANGES: [Change; 17] = [
    ("128³, 16 cones", |_| ()),
    ("32³", |s| s.resolution = 32),
    ("64³", |s| s.resolution = 64),
    ("256³", |s| s.resolution = 256),
    ("6 cones", |s| s.cones.count = 6),
    ("32 cones", |s| s.cones.count = 32),
    ("64 cones", |s| s.cones.count = 64),
    ("64 cones, 256³", |s| (s.cones.count, s.resolution) = (64, 256)),
    ("turned pixel by pixel, the default", |s| s.cones.interleave = true),
    ("16 cones of 10°", |s| s.cones.half_angle = Some(5.0)),
    ("16 cones of 60°", |s| s.cones.half_angle = Some(30.0)),
    ("voxels as wide as cones", |s| s.cones.width = 1.0),
    ("step ½", |s| s.cones.step = 0.5),
    ("no clearance", |s| s.cones.clearance = 0.0),
    ("one value for all directions", |s| s.anisotropic = false),
    ("thin voxels", |s| s.voxelisation = Voxelisation::Thin),
    ("two bounces", |s| (s.bounces, s.bounce_cones) = (2, 16)),
];

fn main() -> Result<()> {
    let samples = std::env::args().nth(1).map_or(Ok(8192), |text| text.parse())?;
    for subject in subjects(std::env::args().nth(2).as_deref())? {
        let right = [reference(&subject, 1, samples)?, reference(&subject, 2, samples)?];
        let Subject { name, scene, camera } = subject;
        println!("| {name} | relative RMSE | mean ratio | ms | MiB |\n|---|---|---|---|---|");
        let tree = Bvh::build(&scene.triangles, &scene.materials)?;
        let view = View::new(&camera, SIDE, SIDE)?;
        let mut cpu = Cpu::new(None)?;
        let world = World::upload(&mut cpu, &scene, &tree, false)?;
        let job = Job { light: LightPart::Indirect, ..Job::default() };
        for (what, change) in CHANGES {
            // Alike in all pixels, so that each knob shows by itself.
            let mut settings = VoxelCones::default();
            settings.cones.interleave = false;
            change(&mut settings);
            let (rendered, counts) = voxel_cones::render(&mut cpu, &world, &view, &job, &settings)?;
            let error = error(&rendered.picture, &right[settings.bounces as usize - 1])?;
            let time: f64 = rendered.timings.iter().map(|t| t.nanoseconds * 1e-6).sum();
            println!(
                "| {what} | {:.1} % | {:.3} | {time:.0} | {:.1} |",
                100.0 * error.relative_rmse,
                error.mean_ratio,
                counts.bytes as f64 / 1_048_576.0
            );
        }
        occlusion(&mut cpu, &world, &view, &scene)?;
    }
    Ok(())
}

/// Openness by cones against that by rays; λ lets it fall to a half over a tenth of the scene.
fn occlusion(cpu: &mut Cpu, world: &World<Cpu>, view: &View, scene: &Scene) -> Result<()> {
    let falloff = 10.0 / scene.bounds().size().max_element();
    let job = Job { rays: 256, falloff, ..Job::default() };
    let right = ambient_occlusion::render(cpu, world, &view.resized(COARSE, COARSE), &job)?.picture;
    println!("\n| occlusion, λ = {falloff:.2}/m | relative RMSE | mean ratio | ms |\n|---|---|---|---|");
    for (what, count, degrees, resolution) in [
        ("16 cones", 16, None, 128),
        ("16 cones, 256³", 16, None, 256),
        ("3 cones of 10°", 3, Some(10.0), 128),
        ("3 cones of 20°", 3, Some(20.0), 128),
        ("3 cones of 30°", 3, Some(30.0), 128),
        ("3 cones of 60°", 3, Some(60.0), 128),
    ] {
        let cones = Cones { count, half_angle: degrees.map(|d: f32| 0.5 * d), ..Default::default() };
        let settings = VoxelCones { cones, resolution, occlusion: true, ..Default::default() };
        let (rendered, _) = voxel_cones::render(cpu, world, view, &job, &settings)?;
        let error = error(&rendered.picture, &right)?;
        let own = rendered.timings.iter().filter(|t| t.stage == "occlusion");
        let time: f64 = own.map(|t| t.nanoseconds * 1e-6).sum();
        println!("| {what} | {:.1} % | {:.3} | {time:.0} |", 100.0 * error.relative_rmse, error.mean_ratio);
    }
    Ok(())
}
