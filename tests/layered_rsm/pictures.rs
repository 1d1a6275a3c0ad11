//! Do pictures agree with the path tracer's, are they the same on every machine, and is nothing done in vain?

use crate::support::*;
use crate::{cpu, indirect, render_on};
use glam::Vec3;
use twinlight::backend::Cpu;
use twinlight::report::error::picture_error;
use twinlight::scene::{BUILT_IN, Camera, Environment, Scene, light};
use twinlight::technique::layered_rsm::{DUMPS, LayeredRsm, Moments, Opacity, Weights};
use twinlight::technique::reference::{Bounces, Reference};
use twinlight::technique::{Cones, Job, LightPart, View};
use twinlight_kernels::passes::elements::Light;

/// The scene from a file, if the folder of scenes has it.
fn from_file(name: &str, eye: Vec3, target: Vec3, fov: f32, lamp: Light) -> Option<(Scene, Camera)> {
    let mut s = Scene::open(scene_file(name)?.to_str()?).ok()?;
    s.lights = vec![lamp];
    Some((s, camera(eye, target, fov)))
}

/// What is within which error: of the mean, and relative RMSE.
fn subjects() -> Vec<(Scene, Camera, f64, f64)> {
    let mut all: Vec<(Scene, Camera, f64, f64)> =
        [("cornell-box", 0.06, 0.42), ("cornell-glossy", 0.16, 0.7)]
            .into_iter()
            .map(|(name, mean, rmse)| {
                let s = Scene::open(name).unwrap();
                let c = s.view();
                (s, c, mean, rmse)
            })
            .collect();
    let sun = light::sun(v(0.25, -1.0, 0.15).normalize(), v(12.0, 11.0, 9.5));
    let lamp = light::point(v(0.0, 8.0, 0.0), v(120.0, 115.0, 100.0));
    let files = [
        (from_file("sponza.glb", v(-11.0, 1.7, -0.5), v(8.0, 4.5, 0.0), 60.0, sun), 0.16, 1.3),
        (from_file("sibenik.glb", v(-14.0, 4.0, 0.0), v(10.0, 7.0, 0.0), 65.0, lamp), 0.08, 0.35),
    ];
    all.extend(files.into_iter().filter_map(|(s, mean, rmse)| s.map(|(s, c)| (s, c, mean, rmse))));
    all
}

#[test]
fn indirect_light_agrees_with_the_path_tracers() {
    for (s, camera, mean, rmse) in subjects() {
        let view = view(&camera, 48, 48);
        let settings = Reference { emissive: false, ..settings(Bounces::Count(1), 1024) };
        let right = trace(&s, &view, &settings).indirect;
        let with = |settings: &LayeredRsm| picture_error(&indirect(&s, &view, settings), &right).unwrap();
        let e = with(&LayeredRsm::default());
        let one = with(&LayeredRsm { depth_layers: 1, normal_layers: 1, ..Default::default() });
        let published = with(&LayeredRsm {
            weights: Weights::Opacity,
            opacity: Opacity::Mean,
            moments: Moments::Unorm16,
            ..Default::default()
        });
        println!("{}: {e:?}\n  one layer {one:?}\n  as published {published:?}", s.name);
        assert!((e.mean_ratio - 1.0).abs() < mean && e.relative_rmse < rmse, "{}: {e:?}", s.name);
        assert!(e.relative_rmse < 1.1 * one.relative_rmse, "{}: layers {e:?}, one {one:?}", s.name);
        if s.name == "sponza" {
            // Where a map shows many depths side by side.
            assert!((e.mean_ratio - 1.0).abs() < 0.6 * (one.mean_ratio - 1.0).abs(), "{e:?}, {one:?}");
        }
        // Negative control: what is mended would be seen.
        assert!(published.mean_ratio < 0.6, "{}: {published:?}", s.name);
    }
}

/// Small settings.
fn small() -> LayeredRsm {
    LayeredRsm {
        resolution: 32,
        map: 64,
        cones: Cones { count: 5, ..Cones::default() },
        ..Default::default()
    }
}

/// As published, with shadows by cones.
fn published() -> LayeredRsm {
    LayeredRsm {
        opacity: Opacity::Mean,
        weights: Weights::Opacity,
        moments: Moments::Unorm16,
        overlap: 0.2,
        depth_layers: 3,
        shadow_cones: true,
        light_radius: 0.1,
        sun_angle: 2.0,
        ..small()
    }
}

#[test]
fn any_number_of_threads_and_the_strict_gpu_write_the_same_bits() {
    let mut gpu = strict_gpu();
    for name in BUILT_IN {
        let mut s = Scene::open(name).unwrap();
        s.lights.push(light::spot(v(0.0, 1.5, 0.9), v(0.3, -1.0, -0.6).normalize(), Vec3::ONE, 0.3, 0.7));
        s.lights.push(light::sun(v(0.2, -1.0, 0.1).normalize(), Vec3::ONE));
        s.environment = Environment::Constant(Vec3::new(0.2, 0.3, 0.4));
        let view = view(&s.view(), 56, 40);
        for settings in
            [small(), published(), LayeredRsm { moments: Moments::Float, shadow_cones: true, ..small() }]
        {
            let job = Job { rays: 4, ..Job::default() };
            let on = |threads| {
                render_on(&mut Cpu::new(Some(threads)).unwrap(), &s, &view, &job, &settings).0.picture
            };
            let one = on(1);
            assert!(one.mean().min_element() > 0.0);
            for threads in [2, 7] {
                assert!(same_bits(&one, &on(threads)), "{name}, {threads} threads");
            }
            if let Some(gpu) = &mut gpu {
                let got = render_on(gpu, &s, &view, &job, &settings).0.picture;
                let (worst, at) = difference(&got, &one);
                assert!(same_bits(&got, &one), "{name}: off by {worst:e} at pixel {at}");
            }
        }
    }
}

#[test]
fn sponza_is_the_same_on_the_strict_gpu() {
    let sun = light::sun(v(0.25, -1.0, 0.15).normalize(), v(12.0, 11.0, 9.5));
    let sponza = from_file("sponza.glb", v(-11.0, 1.7, -0.5), v(8.0, 4.5, 0.0), 60.0, sun);
    let (Some(mut gpu), Some((s, camera))) = (strict_gpu(), sponza) else { return };
    let view = view(&camera, 72, 48);
    let settings = LayeredRsm { resolution: 128, map: 256, shadow_cones: true, ..small() };
    let one = render_on(&mut Cpu::new(None).unwrap(), &s, &view, &Job::default(), &settings).0.picture;
    let got = render_on(&mut gpu, &s, &view, &Job::default(), &settings).0.picture;
    let (worst, at) = difference(&got, &one);
    assert!(same_bits(&got, &one), "off by {worst:e} at pixel {at}");
}

fn passes(s: &Scene, view: &View, job: &Job, settings: &LayeredRsm) -> Vec<(&'static str, &'static str)> {
    let rendered = render_on(&mut cpu(), s, view, job, settings).0;
    rendered.timings.iter().map(|t| (t.stage, t.pass)).collect()
}

#[test]
fn only_what_the_scene_and_the_request_call_for_runs() {
    let (plain, glossy) = (Scene::open("cornell-box").unwrap(), Scene::open("cornell-glossy").unwrap());
    let view = view(&plain.view(), 24, 24);
    let soft = LayeredRsm { shadow_cones: true, ..small() };
    let all = passes(&glossy, &view, &Job::default(), &soft);
    for stage in ["voxelisation", "maps", "diffuse", "specular", "shadows", "direct", "upsampling"] {
        assert!(all.iter().any(|p| p.0 == stage), "{stage} is not in {all:?}");
    }
    assert!(all.iter().all(|p| p.1 != "light_visibility"), "rays and cones for the same shadows");
    let without = passes(&plain, &view, &Job::default(), &small());
    for pass in ["layered_specular", "shadow_cone", "shade_soft_diffuse"] {
        assert!(without.iter().all(|p| p.1 != pass), "{pass} ran");
    }
    let direct = Job { light: LightPart::Direct, ..Job::default() };
    assert!(passes(&plain, &view, &direct, &small()).iter().all(|p| p.0 == "direct"));
    let soft_direct = passes(&plain, &view, &direct, &soft);
    assert!(soft_direct.iter().all(|p| p.0 != "maps" && p.0 != "diffuse"), "{soft_direct:?}");
    let unlit = Scene { lights: Vec::new(), ..plain.clone() };
    let unlit = passes(&unlit, &view, &Job::default(), &small());
    for pass in ["trace_light_map", "layered_diffuse", "mark_bits"] {
        assert!(unlit.iter().all(|p| p.1 != pass), "{pass} ran without a light");
    }
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
    let mut touching = lonely.clone();
    // The light on the surface itself, and one far away.
    touching.lights = vec![
        light::point(touching.triangles[0].p0.truncate(), Vec3::splat(1e6)),
        light::point(v(0.0, 1e5, 0.0), Vec3::splat(1e-6)),
        light::spot(v(0.0, 3.0, 0.0), Vec3::NEG_Y, Vec3::ONE, 1.5, 3.1),
    ];
    let mut far = lonely.clone();
    for t in &mut far.triangles {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p += v(1e6, 1e6, -1e6).extend(0.0);
        }
    }
    let mut unlit = Scene::open("cornell-glossy").unwrap();
    unlit.lights.clear();
    unlit.environment = Environment::Constant(Vec3::ONE);
    let scenes = [lonely, flat, touching, far, unlit, Scene::open("spheres").unwrap()];
    for (i, s) in scenes.iter().enumerate() {
        let view = view(&s.view(), 20, 16);
        for settings in [
            LayeredRsm { resolution: 8, map: 16, ..small() },
            published(),
            LayeredRsm { window: 8.0, footprint: 8.0, least_level: 12.0, shadow_cones: true, ..small() },
            LayeredRsm {
                window: 0.1,
                footprint: 0.1,
                moments: Moments::Float,
                deviation: Some(0.0),
                ..small()
            },
        ] {
            let dumps = DUMPS.iter().map(|d| (*d).to_owned()).collect();
            let job = Job { rays: 2, check_finite: true, dumps, ..Job::default() };
            let (rendered, counts) = render_on(&mut cpu(), s, &view, &job, &settings);
            for n in &rendered.non_finite {
                assert_eq!(n.count, 0, "scene {i}: {} in {} ({counts:?})", n.count, n.buffer);
            }
            assert!(rendered.picture.mean().is_finite());
        }
    }
}

#[test]
fn dumps_have_pictures() {
    let s = Scene::open("cornell-glossy").unwrap();
    let view = view(&s.view(), 20, 16);
    let settings = LayeredRsm { shadow_cones: true, ..small() };
    let dumps = ["rsm", "layers", "shadow", "ao", "diffuse", "specular", "indirect"].map(str::to_owned);
    let job = Job { dumps: dumps.to_vec(), ..Job::default() };
    let (rendered, _) = render_on(&mut cpu(), &s, &view, &job, &settings);
    for name in &dumps {
        let p = rendered.dumps.get(name).unwrap_or_else(|| panic!("no {name}"));
        assert!(p.mean().max_element() > 0.0, "{name} is black");
    }
    let size = |name: &str| (rendered.dumps[name].width, rendered.dumps[name].height);
    assert_eq!((size("rsm"), size("layers"), size("shadow")), ((64, 64), (4 * 32, 32), (20, 16)));
}

/// A library's frames: voxels and maps outlive a picture, and give the same bits as when made anew.
#[test]
fn what_has_not_changed_is_not_made_again() {
    use twinlight::technique::layered_rsm::{BinaryVoxels, Maps, render, render_lit};
    let s = Scene::open("cornell-box").unwrap();
    let mut cpu = cpu();
    let world = crate::world(&mut cpu, &s);
    let settings = small();
    let voxels = BinaryVoxels::build(&mut cpu, &world, &settings).unwrap();
    let maps = Maps::build(&mut cpu, &world, &settings).unwrap();
    cpu.take_timings();
    for eye in [0.0, 0.2] {
        let c = s.view();
        let view = view(&Camera { eye: c.eye + v(eye, 0.0, 0.0), ..c }, 20, 16);
        let job = Job::default();
        let kept = render_lit(&mut cpu, &world, &voxels, &maps, &view, &job, &settings).unwrap();
        assert!(kept.timings.iter().all(|t| t.stage != "voxelisation" && t.stage != "maps"));
        let anew = render(&mut cpu, &world, &view, &job, &settings).unwrap().0;
        assert!(same_bits(&kept.picture, &anew.picture));
        assert!(anew.timings.iter().any(|t| t.stage == "maps"), "negative control");
    }
}
