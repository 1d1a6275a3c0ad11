//! Prints how the knobs of layered reflective shadow maps trade error for time: the tables of `docs/layered-rsm.md`.
//!
//! `cargo run --release --example layered_rsm_tables [SAMPLES [SCENE]]`. Pictures of 512 × 512 are averaged to 128 × 128 and
//! compared with the path tracer's indirect light (SAMPLES paths for each of these pixels, 8192 if none are given) of one
//! bounce. Scenes from files are taken from the folder `TWINLIGHT_SCENES`, and left out where it has none.

#[path = "common/tables.rs"]
mod tables;

use tables::{Result, SIDE, Subject, error, reference, subjects};
use twinlight::backend::Cpu;
use twinlight::picture::Picture;
use twinlight::scene::bvh::Bvh;
use twinlight::technique::layered_rsm::{self, LayeredRsm, Moments, Opacity, Weights};
use twinlight::technique::voxel_cones::{self, VoxelCones};
use twinlight::technique::{Job, LightPart, Rendered, View, World};

/// What a line of the table changes.
type Change = (&'static str, fn(&mut LayeredRsm));

const CHANGES: [Change; 24] = [
    ("as it is: 128³, 16 cones, maps 512², 2 × 2 layers", |_| ()),
    ("64³", |s| s.resolution = 64),
    ("256³", |s| s.resolution = 256),
    ("512³", |s| s.resolution = 512),
    ("maps 256²", |s| s.map = 256),
    ("maps 1024²", |s| s.map = 1024),
    ("6 cones", |s| s.cones.count = 6),
    ("32 cones", |s| s.cones.count = 32),
    ("64 cones", |s| s.cones.count = 64),
    ("16 cones, alike in all pixels", |s| s.cones.interleave = false),
    ("1 layer", |s| (s.depth_layers, s.normal_layers) = (1, 1)),
    ("2 × 1 layers", |s| (s.depth_layers, s.normal_layers) = (2, 1)),
    ("1 × 2 layers", |s| (s.depth_layers, s.normal_layers) = (1, 2)),
    ("4 × 4 layers", |s| (s.depth_layers, s.normal_layers) = (4, 4)),
    ("overlap 0.2 and decay", |s| s.overlap = 0.2),
    ("moments as floats", |s| s.moments = Moments::Float),
    ("moments in UNORM16", |s| s.moments = Moments::Unorm16),
    ("window 0.75", |s| s.window = 0.75),
    ("window 2", |s| s.window = 2.0),
    ("footprint ½", |s| s.footprint = 0.5),
    ("footprint 2", |s| s.footprint = 2.0),
    ("algorithm 1 as published", |s| s.weights = Weights::Opacity),
    ("mean opacity, as published", |s| s.opacity = Opacity::Mean),
    ("both as published", |s| (s.weights, s.opacity) = (Weights::Opacity, Opacity::Mean)),
];

fn line(what: &str, rendered: &Rendered, right: &Picture, bytes: u64) -> Result<()> {
    let error = error(&rendered.picture, right)?;
    let time: f64 = rendered.timings.iter().map(|t| t.nanoseconds * 1e-6).sum();
    println!(
        "| {what} | {:.1} % | {:.3} | {time:.0} | {:.1} |",
        100.0 * error.relative_rmse,
        error.mean_ratio,
        bytes as f64 / 1_048_576.0
    );
    Ok(())
}

fn main() -> Result<()> {
    let samples = std::env::args().nth(1).map_or(Ok(8192), |text| text.parse())?;
    for subject in subjects(std::env::args().nth(2).as_deref())? {
        let right = reference(&subject, 1, samples)?;
        let Subject { name, scene, camera } = subject;
        println!("| {name} | relative RMSE | mean ratio | ms | MiB |\n|---|---|---|---|---|");
        let tree = Bvh::build(&scene.triangles, &scene.materials)?;
        let view = View::new(&camera, SIDE, SIDE)?;
        let mut cpu = Cpu::new(None)?;
        let world = World::upload(&mut cpu, &scene, &tree, false)?;
        let job = Job { light: LightPart::Indirect, ..Job::default() };
        for (what, change) in CHANGES {
            let mut settings = LayeredRsm::default();
            change(&mut settings);
            let (rendered, counts) = layered_rsm::render(&mut cpu, &world, &view, &job, &settings)?;
            line(what, &rendered, &right, counts.voxel_bytes + counts.layer_bytes)?;
        }
        let (rendered, counts) = voxel_cones::render(&mut cpu, &world, &view, &job, &VoxelCones::default())?;
        line("voxel cones as they are", &rendered, &right, counts.bytes)?;
    }
    Ok(())
}
