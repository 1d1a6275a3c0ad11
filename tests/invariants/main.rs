//! What must not change a picture? Every technique, and the path tracer: units, places, axes, magnitudes of light, threads, machines.
//!
//! `cargo test --test invariants -- --nocapture` prints the tables of `docs/numerics.md`.

#[path = "../support/mod.rs"]
mod support;

mod energy;
mod machines;
mod paths;
mod places;

use glam::Vec3;
use twinlight::backend::{Backend, Cpu};
use twinlight::picture::Picture;
use twinlight::plan::{Request, Technique};
use twinlight::renderer::Renderer;
use twinlight::scene::{Camera, Environment, Scene};
use twinlight::technique::layered_rsm::LayeredRsm;
use twinlight::technique::soft_gi::SoftGi;
use twinlight::technique::visibility_filter::VisibilityFilter;
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{Cones, Job, LightPart, View};

/// Sides of the pictures.
const SIDE: u32 = 32;

fn filter() -> VisibilityFilter {
    let all = Some((SIDE, SIDE));
    VisibilityFilter { proxies: 20_000, rays: 64, illumination: all, marching: all, ..Default::default() }
}

fn cones() -> Cones {
    Cones { count: 32, ..Cones::default() }
}

fn voxels() -> VoxelCones {
    VoxelCones { resolution: 64, cones: cones(), illumination: Some((SIDE, SIDE)), ..Default::default() }
}

fn layered() -> LayeredRsm {
    LayeredRsm { resolution: 64, cones: cones(), illumination: Some((SIDE, SIDE)), ..Default::default() }
}

/// The techniques, each with a scene that calls for it.
fn subjects() -> Vec<(Scene, Technique)> {
    let cornell = || Scene::open("cornell-box").unwrap();
    let mut spheres = Scene::open("spheres").unwrap();
    spheres.environment = Environment::Constant(Vec3::new(0.5, 0.7, 1.0));
    vec![
        (cornell(), Technique::Direct),
        (cornell(), Technique::AmbientOcclusion),
        (cornell(), Technique::VisibilityFilter(filter())),
        (cornell(), Technique::VoxelCones(voxels())),
        (cornell(), Technique::LayeredRsm(layered())),
        (spheres, Technique::SoftGi(SoftGi { receiver_scale: 1, ..SoftGi::default() })),
    ]
}

/// Indirect light, or what a technique without it makes.
fn part(technique: &Technique) -> LightPart {
    match technique {
        Technique::Direct | Technique::AmbientOcclusion => LightPart::All,
        _ => LightPart::Indirect,
    }
}

fn render_on<B: Backend>(
    backend: B,
    scene: &Scene,
    camera: &Camera,
    technique: &Technique,
    light: LightPart,
) -> Picture {
    let view = View::new(camera, SIDE, SIDE).unwrap();
    let job = Job { light, check_finite: true, ..Job::default() };
    let mut renderer = Renderer::new(backend, scene.clone()).unwrap();
    let plan = renderer.plan(&Request::new(technique.clone(), view, job)).unwrap();
    let rendered = renderer.render(&plan).unwrap().rendered;
    for n in &rendered.non_finite {
        assert_eq!(n.count, 0, "{}: {} values of {} are not finite", technique.name(), n.count, n.buffer);
    }
    rendered.picture
}

fn render(scene: &Scene, camera: &Camera, technique: &Technique) -> Picture {
    render_on(Cpu::new(Some(2)).unwrap(), scene, camera, technique, part(technique))
}
