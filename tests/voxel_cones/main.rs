//! Does voxel cone tracing keep what it promises, and does its light agree with the path tracer's?

#[path = "../support/mod.rs"]
mod support;

mod invariance;
mod light;
mod lobes;
mod moving;
mod pictures;
mod structure;
mod turned;

use support::tree;
use twinlight::backend::{Backend, Cpu};
use twinlight::picture::Picture;
use twinlight::scene::Scene;
use twinlight::technique::voxel_cones::{self, Counts, Pyramid, VoxelCones};
use twinlight::technique::{Job, LightPart, Rendered, View, World};

fn cpu() -> Cpu {
    Cpu::new(Some(2)).unwrap()
}

/// A scene's voxels on the host.
struct Built {
    cpu: Cpu,
    pyramid: Pyramid<Cpu>,
    blocks: Vec<u32>,
    depths: Vec<u32>,
    sums: Vec<u32>,
}

impl Built {
    fn new(scene: &Scene, settings: &VoxelCones) -> Self {
        let mut cpu = cpu();
        let world = World::upload(&mut cpu, scene, &tree(scene), false).unwrap();
        let pyramid = Pyramid::build(&mut cpu, &world, settings).unwrap();
        let (blocks, depths) = (cpu.download(&pyramid.blocks), cpu.download(&pyramid.depths));
        let sums = cpu.download(&pyramid.sums);
        Self { cpu, pyramid, blocks, depths, sums }
    }
}

fn render_on<B: Backend>(
    backend: &mut B,
    scene: &Scene,
    view: &View,
    job: &Job,
    settings: &VoxelCones,
    emissive: bool,
) -> (Rendered, Counts) {
    let world = World::upload(backend, scene, &tree(scene), emissive).unwrap();
    voxel_cones::render(backend, &world, view, job, settings).unwrap()
}

/// Only indirect light.
fn indirect_job() -> Job {
    Job { light: LightPart::Indirect, ..Job::default() }
}

/// Indirect light, gathered at every pixel.
fn indirect(scene: &Scene, view: &View, settings: &VoxelCones, emissive: bool) -> Picture {
    let settings = VoxelCones { illumination: Some((view.width, view.height)), ..settings.clone() };
    render_on(&mut cpu(), scene, view, &indirect_job(), &settings, emissive).0.picture
}
