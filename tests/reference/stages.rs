//! Are stages of cones what they are said to be when they are taken apart?

use std::sync::atomic::AtomicBool;
use twinlight::backend::Cpu;
use twinlight::report::halves::Halves;
use twinlight::scene::{Scene, bvh::Bvh};
use twinlight::technique::layered_rsm::LayeredRsm;
use twinlight::technique::reference::stages::{Exact, Stages};
use twinlight::technique::reference::{self, Bounces, Reference};
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{View, World};

#[test]
fn with_all_stages_exact_nothing_is_left_of_the_error() {
    let scene = Scene::open("cornell-box").unwrap();
    let tree = Bvh::build(&scene.triangles, &scene.materials).unwrap();
    let view = View::new(&scene.view(), 48, 48).unwrap();
    let traced = |seed| {
        let settings = Reference {
            bounces: Bounces::Count(1),
            samples: 256,
            seed,
            pixel_filter: false,
            ..Reference::default()
        };
        reference::render(&scene, &tree, &view, &settings, &AtomicBool::new(false), |_| ()).indirect
    };
    let right = Halves::new(traced(1), traced(2)).unwrap().averaged(4);
    let mut cpu = Cpu::new(None).unwrap();
    let world = World::upload(&mut cpu, &scene, &tree, false).unwrap();
    let techniques = [
        Stages::voxel_cones(&mut cpu, &world, &VoxelCones { resolution: 64, ..Default::default() }).unwrap(),
        Stages::layered_rsm(&mut cpu, &world, &LayeredRsm { resolution: 64, ..Default::default() }).unwrap(),
    ];
    for stages in techniques {
        let error = |exact| {
            let of = |seed| stages.render(&scene, &tree, &view, exact, 32, seed).averaged(4);
            right.errors_of_two(&of(11), &of(12)).unwrap()
        };
        let [nothing, visibility, radiance, both] =
            [Exact::Nothing, Exact::Visibility, Exact::Radiance, Exact::Both].map(error);
        println!("{nothing:?}\n{visibility:?}\n{radiance:?}\n{both:?}");
        assert!(both.relative_rmse < 0.04 && (both.mean_ratio - 1.0).abs() < 0.02, "{both:?}");
        // The cones' own light is worse than either half of it.
        assert!(nothing.relative_rmse > 0.12, "{nothing:?}");
        assert!(visibility.relative_rmse < nothing.relative_rmse, "{visibility:?} {nothing:?}");
        assert!(radiance.relative_rmse < 0.8 * nothing.relative_rmse, "{radiance:?} {nothing:?}");
        // Cones can only let less through than there is: some light is lost.
        assert!(radiance.mean_ratio > 0.8 && radiance.mean_ratio < 1.0, "{radiance:?}");
    }
}
