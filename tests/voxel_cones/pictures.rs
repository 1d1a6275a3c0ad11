//! Does the light agree with the path tracer's, better with higher knobs, and bit for bit between machines?

use crate::support::*;
use crate::{cpu, indirect, indirect_job, render_on};
use glam::Vec3;
use twinlight::backend::{Backend, Cpu};
use twinlight::picture::Picture;
use twinlight::report::error::{PictureError, picture_error};
use twinlight::scene::{BUILT_IN, Environment, Scene, light};
use twinlight::technique::reference::{Bounces, Reference};
use twinlight::technique::voxel_cones::{
    self, DUMPS, Lighting, Pyramid, RadianceStorage, VoxelCones, Voxelisation, render_lit,
};
use twinlight::technique::{Cones, Job, LightPart, View, World, ambient_occlusion};

const SIDE: u32 = 48;

fn at(resolution: u32) -> VoxelCones {
    VoxelCones { resolution, ..Default::default() }
}

fn error(got: &Picture, right: &Picture, what: &str) -> PictureError {
    let e = picture_error(got, right).unwrap();
    println!("{what}: {:.1} %, mean ratio {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
    e
}

#[test]
fn the_cornell_box_is_as_bright_as_it_should_be_and_better_with_more_cones() {
    let s = Scene::open("cornell-box").unwrap();
    let view = view(&s.view(), SIDE, SIDE);
    let settings = Reference { emissive: false, ..settings(Bounces::Count(1), 2048) };
    let right = trace(&s, &view, &settings).indirect;
    let with = |count, resolution| {
        let got = indirect(
            &s,
            &view,
            &VoxelCones { cones: Cones { count, ..Cones::default() }, ..at(resolution) },
            false,
        );
        error(&got, &right, &format!("{count} cones, {resolution}³"))
    };
    let (few, some, many) = (with(6, 64), with(16, 64), with(48, 64));
    assert!((some.mean_ratio - 1.0).abs() < 0.06 && some.relative_rmse < 0.4, "{some:?}");
    assert!((many.mean_ratio - 1.0).abs() < 0.06 && many.relative_rmse < 0.28, "{many:?}");
    assert!(few.relative_rmse > some.relative_rmse && some.relative_rmse > many.relative_rmse);
    let finer = with(16, 256);
    assert!((finer.mean_ratio / some.mean_ratio - 1.0).abs() < 0.05, "brightness drifts with the resolution");
}

#[test]
fn what_storages_of_radiance_cost() {
    let s = Scene::open("cornell-glossy").unwrap();
    let view = view(&s.view(), SIDE, SIDE);
    let with = |storage| {
        let settings = VoxelCones { storage, bounces: 2, illumination: Some((SIDE, SIDE)), ..at(64) };
        let (rendered, counts) = render_on(&mut cpu(), &s, &view, &indirect_job(), &settings, false);
        (rendered.picture, counts)
    };
    let (right, most) = with(RadianceStorage::Float);
    // Equal steps lose what is dim, and what is beyond 64 typical radiances.
    let table = [
        (RadianceStorage::Half, 3e-4),
        (RadianceStorage::Shared, 3e-3),
        (RadianceStorage::Fixed, 0.03),
        (RadianceStorage::Unorm8, 0.15),
    ];
    let mut before = 0.0;
    for (storage, allowed) in table {
        let (picture, counts) = with(storage);
        let e = error(&picture, &right, &format!("{storage:?}, {counts:?}"));
        assert!(e.relative_rmse < allowed && e.relative_rmse > before, "{storage:?}: {e:?}");
        assert!((e.mean_ratio - 1.0).abs() < allowed, "{storage:?}: {e:?}");
        assert_ne!(format!("{counts:?}"), format!("{most:?}"), "{storage:?} takes as much memory");
        before = e.relative_rmse;
    }
}

#[test]
fn occlusion_agrees_with_rays() {
    let s = Scene::open("cornell-box").unwrap();
    let view = view(&s.view(), SIDE, SIDE);
    let mut cpu = cpu();
    let world = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
    let job = Job { rays: 512, falloff: 3.0, ..Job::default() };
    let right = ambient_occlusion::render(&mut cpu, &world, &view, &job).unwrap().picture;
    let with = |settings: VoxelCones, what: &str| {
        let settings = VoxelCones { occlusion: true, ..settings };
        error(
            &render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &job, &settings, false).0.picture,
            &right,
            what,
        )
    };
    let e = with(at(128), "128³");
    assert!((e.mean_ratio - 1.0).abs() < 0.06 && e.relative_rmse < 0.09, "{e:?}");
    let bare =
        with(VoxelCones { cones: Cones { clearance: 0.0, ..Cones::default() }, ..at(128) }, "no clearance");
    assert!(bare.relative_rmse > 2.0 * e.relative_rmse, "negative control: {bare:?}");
    let mut empty = scene();
    square(&mut empty, 0.0, 1.0, true, grey(0.5));
    let above = crate::support::view(&camera(v(0.0, 2.0, 0.0), Vec3::ZERO, 40.0), 16, 16);
    let settings = VoxelCones { occlusion: true, ..at(32) };
    let open = render_on(&mut cpu, &empty, &above, &Job::default(), &settings, false).0.picture;
    assert_eq!(open.mean(), Vec3::ONE, "a plane does not occlude itself");
}

/// Small settings.
fn small() -> VoxelCones {
    VoxelCones {
        resolution: 32,
        cones: Cones { count: 5, ..Cones::default() },
        light_map: 96,
        ..Default::default()
    }
}

#[test]
fn any_number_of_threads_and_the_strict_gpu_write_the_same_bits() {
    let mut gpu = strict_gpu();
    for name in BUILT_IN {
        let mut s = Scene::open(name).unwrap();
        s.lights.push(light::spot(v(0.0, 1.5, 0.9), v(0.3, -1.0, -0.6), Vec3::ONE, 0.3, 0.7));
        s.lights.push(light::sun(v(0.2, -1.0, 0.1).normalize(), Vec3::ONE));
        s.environment = Environment::Constant(Vec3::new(0.2, 0.3, 0.4));
        let view = view(&s.view(), 56, 40);
        for settings in [
            small(),
            VoxelCones {
                anisotropic: false,
                voxelisation: Voxelisation::Thin,
                bounces: 2,
                bounce_cones: 3,
                ..small()
            },
            VoxelCones { occlusion: true, resolution: 64, ..small() },
        ] {
            let job = Job { rays: 4, ..Job::default() };
            let on = |threads| {
                render_on(&mut Cpu::new(Some(threads)).unwrap(), &s, &view, &job, &settings, true).0.picture
            };
            let one = on(1);
            assert!(one.mean().min_element() > 0.0);
            for threads in [2, 7] {
                assert!(same_bits(&one, &on(threads)), "{name}, {threads} threads");
            }
            if let Some(gpu) = &mut gpu {
                let got = render_on(gpu, &s, &view, &job, &settings, true).0.picture;
                let (worst, at) = difference(&got, &one);
                assert!(same_bits(&got, &one), "{name}: off by {worst:e} at pixel {at}");
            }
        }
    }
}

#[test]
fn sponza_is_the_same_on_the_strict_gpu() {
    let (Some(mut gpu), Some(path)) = (strict_gpu(), scene_file("sponza.glb")) else { return };
    let mut s = Scene::open(path.to_str().unwrap()).unwrap();
    s.lights = vec![light::sun(v(0.25, -1.0, 0.15).normalize(), v(12.0, 11.0, 9.5))];
    let view = view(&camera(v(-11.0, 1.7, -0.5), v(8.0, 4.5, 0.0), 60.0), 72, 48);
    let settings = VoxelCones { resolution: 128, light_map: 256, ..small() };
    let one = render_on(&mut Cpu::new(None).unwrap(), &s, &view, &Job::default(), &settings, false).0.picture;
    let got = render_on(&mut gpu, &s, &view, &Job::default(), &settings, false).0.picture;
    let (worst, at) = difference(&got, &one);
    assert!(same_bits(&got, &one), "off by {worst:e} at pixel {at}");
}

fn passes<B: Backend>(
    backend: &mut B,
    s: &Scene,
    view: &View,
    job: &Job,
) -> Vec<(&'static str, &'static str)> {
    let rendered = render_on(backend, s, view, job, &small(), false).0;
    rendered.timings.iter().map(|t| (t.stage, t.pass)).collect()
}

#[test]
fn only_what_the_scene_and_the_request_call_for_runs() {
    let (plain, glossy) = (Scene::open("cornell-box").unwrap(), Scene::open("cornell-glossy").unwrap());
    let view = view(&plain.view(), 24, 24);
    let mut cpu = cpu();
    let all = passes(&mut cpu, &glossy, &view, &Job::default());
    for stage in ["voxelisation", "injection", "filtering", "diffuse", "specular", "direct", "upsampling"] {
        assert!(all.iter().any(|p| p.0 == stage), "{stage} is not in {all:?}");
    }
    let without = passes(&mut cpu, &plain, &view, &Job::default());
    for pass in ["cone_specular", "bounce_radiance", "mark_emissive"] {
        assert!(without.iter().all(|p| p.1 != pass), "{pass} ran");
    }
    let direct = passes(&mut cpu, &plain, &view, &Job { light: LightPart::Direct, ..Job::default() });
    assert!(direct.iter().all(|p| p.0 == "direct"), "{direct:?}");
    let unlit = Scene { lights: Vec::new(), ..plain.clone() };
    let unlit = passes(&mut cpu, &unlit, &view, &Job::default());
    assert!(unlit.iter().all(|p| p.1 != "trace_light_map" && p.1 != "filter_radiance"), "{unlit:?}");
}

#[test]
fn odd_scenes_and_settings_are_finite() {
    let mut lonely = scene();
    lonely.materials.push(grey(0.5));
    lonely.triangles.push(Scene::open("cornell-box").unwrap().triangles[0]);
    lonely.triangles[0].material = 0;
    lonely.lights = vec![light::point(v(0.0, 1.0, 0.0), Vec3::ONE)];
    let mut flat = lonely.clone();
    flat.triangles[0].p2 = flat.triangles[0].p1;
    let mut holes = scene();
    square(&mut holes, 0.0, 1.0, true, masked(0.1));
    holes.lights = lonely.lights.clone();
    let mut far = Scene::open("cornell-box").unwrap();
    for t in &mut far.triangles {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p += v(3e4, -1e4, 2e4).extend(0.0);
        }
    }
    let scenes = [lonely, flat, holes, far, Scene::open("spheres").unwrap()];
    for (i, s) in scenes.iter().enumerate() {
        let view = view(&s.view(), 20, 16);
        for settings in [
            VoxelCones { resolution: 8, ..small() },
            VoxelCones {
                voxelisation: Voxelisation::Thin,
                cones: Cones { half_angle: Some(85.0), ..small().cones },
                ..small()
            },
            VoxelCones {
                cones: Cones { half_angle: Some(0.5), step: 1.0 / 64.0, count: 1, ..small().cones },
                resolution: 16,
                bounce_cones: 2,
                ..small()
            },
            VoxelCones {
                cones: Cones {
                    start: 0.0,
                    clearance: 0.0,
                    cutoff: 0.5,
                    width: 4.0,
                    step: 64.0,
                    ..small().cones
                },
                ..small()
            },
        ] {
            let dumps = DUMPS.iter().map(|d| (*d).to_owned()).collect();
            let job = Job { rays: 2, check_finite: true, dumps, ..Job::default() };
            let (rendered, counts) = render_on(&mut cpu(), s, &view, &job, &settings, true);
            for n in &rendered.non_finite {
                assert_eq!(n.count, 0, "scene {i}: {} in {} ({counts:?})", n.count, n.buffer);
            }
            assert!(rendered.picture.mean().is_finite());
        }
    }
    let _ = indirect_job();
}

#[test]
fn an_unmoved_light_is_not_injected_again() {
    let s = Scene::open("cornell-glossy").unwrap();
    let view = view(&s.view(), 24, 24);
    let mut cpu = cpu();
    let world = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
    let at_once = voxel_cones::render(&mut cpu, &world, &view, &Job::default(), &small()).unwrap().0;
    let pyramid = Pyramid::build(&mut cpu, &world, &small()).unwrap();
    let lighting = Lighting::new(&mut cpu, &world, &pyramid, &small()).unwrap();
    cpu.take_timings();
    for turn in 0..2 {
        let job = Job::default();
        let again = render_lit(&mut cpu, &world, &pyramid, &lighting, &view, &job, &small()).unwrap();
        assert!(same_bits(&again.picture, &at_once.picture), "picture {turn}");
        for stage in ["voxelisation", "injection", "filtering", "bounces"] {
            assert!(again.timings.iter().all(|t| t.stage != stage), "{stage} ran again");
        }
    }
    assert!(at_once.timings.iter().any(|t| t.stage == "injection"), "negative control");
}
