//! Is what a plan says what runs, is nothing else done, and does what outlives a picture give the same picture?

#[path = "../support/mod.rs"]
mod support;

mod bounds;
mod changes;
mod costs;
mod decisions;

use glam::Vec3;
use support::{grey, metal, quad, v};
use twinlight::plan::{Request, Technique};
use twinlight::scene::{BUILT_IN, Environment, Scene, light};
use twinlight::technique::layered_rsm::LayeredRsm;
use twinlight::technique::soft_gi::SoftGi;
use twinlight::technique::visibility_filter::{Visibility, VisibilityFilter};
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{Cones, Job, LightPart, View};

/// Every technique with small settings, and those of their forms that run other passes.
fn techniques() -> Vec<Technique> {
    let cones = Cones { count: 5, ..Cones::default() };
    let filter = VisibilityFilter { proxies: 400, grid: [6; 3], rays: 9, ..Default::default() };
    let voxels = VoxelCones { resolution: 16, cones: cones.clone(), light_map: 64, ..Default::default() };
    let layered = LayeredRsm { resolution: 16, map: 64, cones, ..Default::default() };
    vec![
        Technique::Direct,
        Technique::AmbientOcclusion,
        Technique::VisibilityFilter(filter.clone()),
        Technique::VisibilityFilter(VisibilityFilter { visibility: Visibility::Proxies, ..filter }),
        Technique::VoxelCones(voxels.clone()),
        Technique::VoxelCones(VoxelCones { bounces: 3, ..voxels.clone() }),
        Technique::VoxelCones(VoxelCones { occlusion: true, ..voxels }),
        Technique::SoftGi(SoftGi::default()),
        Technique::LayeredRsm(layered.clone()),
        Technique::LayeredRsm(LayeredRsm { shadow_cones: true, light_radius: 0.1, ..layered }),
    ]
}

/// The built-in scenes, and one each with what they lack.
fn scenes() -> Vec<Scene> {
    let mut all: Vec<Scene> = BUILT_IN.iter().map(|name| Scene::open(name).unwrap()).collect();
    let mut open = Scene::open("cornell-glossy").unwrap();
    open.name = "glossy under a sky".into();
    open.environment = Environment::Constant(Vec3::new(0.2, 0.3, 0.4));
    open.lights.push(light::sun(v(0.2, -1.0, 0.3).normalize(), Vec3::splat(2.0)));
    all.push(open);
    let mut unlit = Scene::open("cornell-box").unwrap();
    unlit.name = "unlit".into();
    unlit.lights.clear();
    all.push(unlit);
    let mut mirror = support::scene();
    mirror.name = "mirror under a sky".into();
    quad(
        &mut mirror,
        [v(-1.0, 0.0, -1.0), v(-1.0, 0.0, 1.0), v(1.0, 0.0, 1.0), v(1.0, 0.0, -1.0)],
        metal(0.7, 0.3),
    );
    quad(
        &mut mirror,
        [v(-1.0, 0.0, -1.0), v(1.0, 0.0, -1.0), v(1.0, 1.0, -1.0), v(-1.0, 1.0, -1.0)],
        grey(0.5),
    );
    mirror.environment = Environment::Constant(Vec3::ONE);
    all.push(mirror);
    all
}

fn request(scene: &Scene, technique: &Technique, emissive: bool, light: LightPart) -> Request {
    let view = View::new(&scene.view(), 24, 20).unwrap();
    let light = if matches!(technique, Technique::AmbientOcclusion) { LightPart::All } else { light };
    let job = Job { rays: 4, light, ..Job::default() };
    Request { emissive, ..Request::new(technique.clone(), view, job) }
}
