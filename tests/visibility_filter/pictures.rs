//! Does the light agree with the path tracer's, better with higher knobs, and bit for bit between machines?

use crate::support::*;
use crate::{indirect, indirect_job, render_on};
use glam::Vec3;
use twinlight::backend::{Backend, Cpu};
use twinlight::picture::Picture;
use twinlight::report::error::{PictureError, picture_error};
use twinlight::scene::{BUILT_IN, Scene, light};
use twinlight::technique::reference::{Bounces, Reference};
use twinlight::technique::visibility_filter::{Gather, Visibility, VisibilityFilter};
use twinlight::technique::{Job, LightPart, View};

const SIDE: u32 = 64;

/// Settings whose pixels are all those of the picture.
fn full(rays: u32) -> VisibilityFilter {
    let size = Some((SIDE, SIDE));
    VisibilityFilter {
        marching: size,
        illumination: size,
        rays,
        proxies: 30_000,
        filter: (1, 1),
        ..Default::default()
    }
}

fn reference(s: &Scene, view: &View, samples: u32) -> Picture {
    let settings = Reference { emissive: false, ..settings(Bounces::Count(1), samples) };
    trace(s, view, &settings).indirect
}

fn error(s: &Scene, view: &View, settings: &VisibilityFilter, right: &Picture) -> PictureError {
    let e = picture_error(&indirect(s, view, settings), right).unwrap();
    println!(
        "{}: {} proxies, {} rays, {:?}, {:?}: {:.1} %, mean ratio {:.4}",
        s.name,
        settings.proxies,
        settings.rays,
        settings.marching_size(SIDE, SIDE),
        settings.gather,
        100.0 * e.relative_rmse,
        e.mean_ratio
    );
    e
}

#[test]
fn the_cornell_box_is_as_bright_as_it_should_be_and_better_with_higher_knobs() {
    let s = Scene::open("cornell-box").unwrap();
    let view = view(&s.view(), SIDE, SIDE);
    let right = reference(&s, &view, 4096);
    let high = error(&s, &view, &full(256), &right);
    assert!((high.mean_ratio - 1.0).abs() < 0.03 && high.relative_rmse < 0.15, "{high:?}");
    let fewer_rays = error(&s, &view, &full(8), &right);
    assert!(fewer_rays.relative_rmse > 1.2 * high.relative_rmse, "{fewer_rays:?}");
    let fewer_proxies = error(&s, &view, &VisibilityFilter { proxies: 500, ..full(256) }, &right);
    assert!(fewer_proxies.relative_rmse > 1.1 * high.relative_rmse, "{fewer_proxies:?}");
    let coarser = error(&s, &view, &VisibilityFilter { marching: Some((12, 12)), ..full(256) }, &right);
    assert!(coarser.relative_rmse > 1.2 * high.relative_rmse, "{coarser:?}");
    // The rays alone, and discs instead of triangles, are as bright.
    for settings in [
        VisibilityFilter { trust: 0.0, ..full(256) },
        VisibilityFilter { visibility: Visibility::Proxies, ..full(256) },
    ] {
        let e = error(&s, &view, &settings, &right);
        assert!((e.mean_ratio - 1.0).abs() < 0.05 && e.relative_rmse < 0.15, "{e:?}");
    }
    // The paper's sum: less noise, but too bright behind the blocks.
    let sum = error(&s, &view, &VisibilityFilter { gather: Gather::Sum, grid: [6; 3], ..full(256) }, &right);
    assert!(sum.relative_rmse > 1.2 * high.relative_rmse, "negative control: the sum is not worse: {sum:?}");
}

/// An empty room with a glossy floor of Phong exponent `exponent`.
fn glossy(exponent: f32) -> Scene {
    let mut s = Scene::open("cornell-box").unwrap();
    for m in &mut s.materials[4..5] {
        m.metallic = 0.5;
        m.roughness = (2.0 / (exponent + 2.0)).powf(0.25);
    }
    // Without the blocks.
    s.triangles.drain(10..34);
    s
}

#[test]
fn glossy_floors_reflect_as_they_should() {
    for exponent in [10.0, 50.0] {
        let s = glossy(exponent);
        // The floor before the back wall.
        let view = view(&camera(v(0.0, 0.6, 0.95), v(0.0, 0.05, -0.5), 50.0), SIDE, SIDE);
        let right = reference(&s, &view, 4096);
        let settings = VisibilityFilter { lobe_rays: 32, ..full(128) };
        let e = error(&s, &view, &settings, &right);
        let without = error(&s, &view, &VisibilityFilter { lobe_rays: 0, ..settings.clone() }, &right);
        assert!((e.mean_ratio - 1.0).abs() < 0.05 && e.relative_rmse < 0.25, "Ns {exponent}: {e:?}");
        assert!(without.relative_rmse > 1.5 * e.relative_rmse, "negative control: {without:?}");
        let weighed = VisibilityFilter { specular_deviation: 0.2, ..settings };
        let e = error(&s, &view, &weighed, &right);
        assert!((e.mean_ratio - 1.0).abs() < 0.08 && e.relative_rmse < 0.25, "Ns {exponent}, eq. 7: {e:?}");
        // Half where the lobe is, as it is chosen by default; another one blurs.
        let given = |n: f32| VisibilityFilter { specular_exponent: Some(n), ..weighed.clone() };
        let same = error(&s, &view, &given(-exponent * (1.0f32 - 1.177_41 * 0.2).log2()), &right);
        assert!((same.relative_rmse / e.relative_rmse - 1.0).abs() < 1e-3, "Ns {exponent}: {same:?}, {e:?}");
        let wide = error(&s, &view, &given(1.0), &right);
        println!("Ns {exponent}: {e:?}, exponent given {same:?}, 1 {wide:?}");
        assert!(wide.relative_rmse > 1.1 * same.relative_rmse, "negative control: {wide:?}");
    }
}

#[test]
fn a_metal_block_throws_its_patch_onto_the_wall() {
    let s = Scene::open("cornell-glossy").unwrap();
    let view = view(&s.view(), SIDE, SIDE);
    let right = reference(&s, &view, 16_384);
    let high = error(&s, &view, &full(128), &right);
    assert!((high.mean_ratio - 1.0).abs() < 0.05 && high.relative_rmse < 0.25, "{high:?}");
    let dull = error(&s, &view, &VisibilityFilter { proxy_gloss: false, ..full(128) }, &right);
    assert!(dull.mean_ratio < 0.95 && dull.relative_rmse > 1.5 * high.relative_rmse, "without: {dull:?}");
}

#[test]
fn lists_that_are_too_short_keep_the_brightness_of_an_open_scene() {
    // A floor and a lit wall under a black sky, which half of the rays meet.
    let mut s = scene();
    square(&mut s, 0.0, 3.0, true, grey(0.7));
    quad(&mut s, [v(-3.0, 0.0, -3.0), v(3.0, 0.0, -3.0), v(3.0, 3.0, -3.0), v(-3.0, 3.0, -3.0)], grey(0.7));
    s.lights = vec![light::point(v(0.0, 2.0, 0.0), Vec3::splat(5.0))];
    let view = view(&camera(v(0.0, 2.0, 4.0), v(0.0, 0.5, -1.0), 60.0), SIDE, SIDE);
    let settings = VisibilityFilter { grid: [24; 3], ..full(64) };
    let mean = |capacity| {
        let settings = VisibilityFilter { capacity, ..settings.clone() };
        let (rendered, counts) =
            render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &indirect_job(), &settings);
        (rendered.picture.mean().y, counts)
    };
    let (roomy, counts) = mean(None);
    assert_eq!(counts.dropped, 0);
    for capacity in [100, 30] {
        let (tight, counts) = mean(Some(capacity));
        println!(
            "{} of {} lists too long: {:.3} of the light",
            counts.full_lists,
            SIDE * SIDE,
            tight / roomy
        );
        assert!(counts.full_lists > 500, "{counts:?}");
        assert!((tight / roomy - 1.0).abs() < 0.1, "{tight} for {roomy} with lists of {capacity}");
    }
}

#[test]
fn gloss_keeps_its_light_up_to_its_border() {
    let floor = |right: &str| {
        let mut s = Scene::open("cornell-box").unwrap();
        s.triangles.drain(..2);
        let (polished, dull) = (metal(0.8, 0.3), grey(0.5));
        for (x, m) in [(-1.0, polished), (0.0, if right == "dull" { dull } else { polished })] {
            quad(&mut s, [v(x, 0.0, 1.0), v(x + 1.0, 0.0, 1.0), v(x + 1.0, 0.0, -1.0), v(x, 0.0, -1.0)], m);
        }
        s.triangles.drain(8..32);
        let view = view(&camera(v(-0.3, 0.8, 0.9), v(-0.1, 0.0, -0.2), 45.0), 64, 64);
        let settings = VisibilityFilter { lobe_rays: 32, ..VisibilityFilter::default() };
        let job = Job { dumps: vec!["gloss".into(), "position".into(), "specular".into()], ..indirect_job() };
        render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &job, &settings).0
    };
    let (split, whole) = (floor("dull"), floor("polished"));
    let (mut compared, mut worst) = (0, 0.0f32);
    for i in 0..split.picture.pixels.len() {
        let x = split.dumps["position"].pixels[i].x;
        let on_floor = split.dumps["position"].pixels[i].y.abs() < 1e-4;
        if on_floor && x < -0.02 && x > -0.4 && split.dumps["gloss"].pixels[i].x > 0.0 {
            compared += 1;
            worst = worst.max((split.picture.pixels[i].y / whole.picture.pixels[i].y - 1.0).abs());
        }
    }
    println!("{compared} glossy pixels near the border: {:.1} % off at most", 100.0 * worst);
    assert!(compared > 100 && worst < 0.25, "{compared} pixels, off by {worst}");
}

fn exr(picture: &Picture) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    picture.save(&path, 0.0).unwrap();
    std::fs::read(path).unwrap()
}

/// Small settings that use every part.
fn small() -> VisibilityFilter {
    VisibilityFilter { proxies: 8_000, grid: [9, 7, 8], rays: 12, lobe_rays: 6, ..Default::default() }
}

#[test]
fn any_number_of_threads_and_the_strict_gpu_write_the_same_file() {
    let mut gpu = strict_gpu();
    for name in BUILT_IN {
        let mut s = Scene::open(name).unwrap();
        s.lights.push(light::spot(v(0.0, 1.5, 0.9), v(0.3, -1.0, -0.6), Vec3::ONE, 0.3, 0.7));
        let view = view(&s.view(), 72, 56);
        for settings in [
            small(),
            VisibilityFilter { gather: Gather::Sum, light_map: 64, capacity: Some(20), ..small() },
            VisibilityFilter { visibility: Visibility::Proxies, ..small() },
        ] {
            let job = Job { rays: 4, ..Job::default() };
            let on = |threads| {
                render_on(&mut Cpu::new(Some(threads)).unwrap(), &s, &view, &job, &settings).0.picture
            };
            let one = on(1);
            assert!(one.mean().min_element() > 0.0);
            for threads in [2, 7] {
                assert!(exr(&one) == exr(&on(threads)), "{name}, {threads} threads");
            }
            if let Some(gpu) = &mut gpu {
                let got = render_on(gpu, &s, &view, &job, &settings).0.picture;
                let (worst, at) = difference(&got, &one);
                assert!(exr(&got) == exr(&one), "{name}: off by {worst:e} at pixel {at}");
            }
        }
    }
}

#[test]
fn sponza_is_the_same_file_on_the_strict_gpu() {
    let Some(mut gpu) = strict_gpu() else { return };
    for (file, light) in [
        ("sponza.glb", light::sun(v(0.25, -1.0, 0.15).normalize(), v(12.0, 11.0, 9.5))),
        ("cornell-glossy.glb", light::point(v(0.0, 1.4, 0.0), Vec3::splat(1.5))),
    ] {
        let Some(path) = scene_file(file) else { continue };
        let mut s = Scene::open(path.to_str().unwrap()).unwrap();
        s.lights = vec![light];
        let view = if file.starts_with("sponza") {
            view(&camera(v(-11.0, 1.7, -0.5), v(8.0, 4.5, 0.0), 60.0), 96, 72)
        } else {
            view(&camera(v(0.0, 0.8, 3.2), v(0.0, 0.8, 0.0), 36.0), 96, 72)
        };
        let settings = VisibilityFilter { proxies: 40_000, grid: [20; 3], ..small() };
        let (rendered, _) = render_on(&mut Cpu::new(None).unwrap(), &s, &view, &Job::default(), &settings);
        let got = render_on(&mut gpu, &s, &view, &Job::default(), &settings).0.picture;
        let (worst, at) = difference(&got, &rendered.picture);
        assert!(exr(&got) == exr(&rendered.picture), "{file}: off by {worst:e} at pixel {at}");
    }
}

fn passes<B: Backend>(backend: &mut B, s: &Scene, job: &Job) -> Vec<(&'static str, &'static str)> {
    let view = view(&s.view(), 32, 32);
    let rendered = render_on(backend, s, &view, job, &small()).0;
    rendered.timings.iter().map(|t| (t.stage, t.pass)).collect()
}

#[test]
fn only_what_the_scene_and_the_request_call_for_runs() {
    let (plain, glossy) = (Scene::open("cornell-box").unwrap(), glossy(20.0));
    let mut cpu = Cpu::new(Some(1)).unwrap();
    let all = passes(&mut cpu, &glossy, &Job::default());
    for stage in ["voxelisation", "lighting", "marching", "filter", "illumination", "direct", "upsampling"] {
        assert!(all.iter().any(|p| p.0 == stage), "{stage} is not in {all:?}");
    }
    let specular = ["resolve_gloss", "lobe_coverage", "gather_specular", "add_specular_reflection"];
    let without = passes(&mut cpu, &plain, &Job::default());
    for pass in specular {
        assert!(all.iter().any(|p| p.1 == pass), "{pass} did not run");
        assert!(without.iter().all(|p| p.1 != pass), "{pass} ran without gloss");
    }
    let direct = passes(&mut cpu, &plain, &Job { light: LightPart::Direct, ..Job::default() });
    assert!(direct.iter().all(|p| p.0 == "direct"), "{direct:?}");
    let indirect = passes(&mut cpu, &plain, &indirect_job());
    assert!(indirect.iter().all(|p| p.0 == "lighting" || p.1 != "light_visibility"), "{indirect:?}");
}
