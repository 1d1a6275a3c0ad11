//! Does the technique for direct light give what the path tracer, its own parts, and the other backend give?

#[path = "../support/mod.rs"]
mod support;

mod bands;
mod leaks;
mod lights;
mod machines;

use support::tree;
use twinlight::backend::Cpu;
use twinlight::picture::Picture;
use twinlight::scene::Scene;
use twinlight::technique::{Job, View, World, ambient_occlusion, direct};

/// Direct light by the technique on the CPU.
fn direct_light(scene: &Scene, view: &View, job: &Job, emissive: bool) -> Picture {
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let world = World::upload(&mut cpu, scene, &tree(scene), emissive).unwrap();
    direct::render(&mut cpu, &world, view, job).unwrap().picture
}

/// Openness on the CPU.
fn openness(scene: &Scene, view: &View, job: &Job) -> Picture {
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let world = World::upload(&mut cpu, scene, &tree(scene), false).unwrap();
    ambient_occlusion::render(&mut cpu, &world, view, job).unwrap().picture
}
