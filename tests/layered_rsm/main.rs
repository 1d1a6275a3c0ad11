//! Do layered reflective shadow maps keep what they promise, and does their light agree with the path tracer's?

#[path = "../support/mod.rs"]
mod support;

mod layers;
mod light;
mod pictures;
mod shadow;
mod voxels;

use support::tree;
use twinlight::backend::{Backend, Cpu};
use twinlight::picture::Picture;
use twinlight::scene::Scene;
use twinlight::technique::layered_rsm::{self, Counts, LayeredRsm};
use twinlight::technique::{Job, LightPart, Rendered, View, World};

fn cpu() -> Cpu {
    Cpu::new(Some(2)).unwrap()
}

fn world(cpu: &mut Cpu, s: &Scene) -> World<Cpu> {
    World::upload(cpu, s, &tree(s), false).unwrap()
}

fn render_on<B: Backend>(
    backend: &mut B,
    scene: &Scene,
    view: &View,
    job: &Job,
    settings: &LayeredRsm,
) -> (Rendered, Counts) {
    let world = World::upload(backend, scene, &tree(scene), false).unwrap();
    layered_rsm::render(backend, &world, view, job, settings).unwrap()
}

/// Indirect light, gathered at every pixel.
fn indirect(scene: &Scene, view: &View, settings: &LayeredRsm) -> Picture {
    let settings = LayeredRsm { illumination: Some((view.width, view.height)), ..settings.clone() };
    let job = Job { light: LightPart::Indirect, ..Job::default() };
    render_on(&mut cpu(), scene, view, &job, &settings).0.picture
}
