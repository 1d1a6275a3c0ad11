//! How many rays a second does each backend trace?
//!
//! `cargo bench --bench rays` traces the primary rays of a 512 × 512 picture and the shadow rays to its light: those
//! of surfaces that face it. The throughput is rays a second. The built-in `cornell-box` is always there; Sponza (the
//! view `sponza-nave` of `views.json`) comes from the folder of scenes, `TWINLIGHT_SCENES` or `shared/scenes` beside
//! the workspace. What each pass does beside the walk (making the ray, reading the surface) is in the time.

mod common;

use common::{open_gpus, time};
use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Duration;
use twinlight::backend::{Backend, BackendError, Cpu};
use twinlight::scene::{Camera, Scene, bvh::Bvh, light};
use twinlight::technique::{View, World};
use twinlight_kernels::geometry::bvh::{Hit, NO_TRIANGLE};
use twinlight_kernels::math::dot;
use twinlight_kernels::passes::elements::{CameraParams, Light, LightParams, Surface};
use twinlight_kernels::passes::light::incident_light;

const SIDE: u32 = 512;
const PIXELS: u32 = SIDE * SIDE;

/// What one picture needs besides the scene's buffers.
struct Shot {
    camera: CameraParams,
    light: LightParams,
    surfaces: Vec<Surface>,
    /// Surfaces that face the light: as many shadow rays.
    shadow_rays: u64,
}

impl Shot {
    fn new(cpu: &mut Cpu, world: &World<Cpu>, view: &View) -> Result<Self, BackendError> {
        let camera = view.params(0);
        let mut hits = cpu.alloc("hits", PIXELS as usize)?;
        trace(cpu, world, &camera, &mut hits)?;
        let mut surfaces = cpu.alloc("surfaces", PIXELS as usize)?;
        let w = world;
        cpu.resolve_surfaces(&camera, &hits, &w.triangles, &w.materials, &w.texels, &mut surfaces, PIXELS)?;
        let surfaces = cpu.download(&surfaces)?;
        let faces_light = |s: &&Surface| {
            let towards = |light: &Light| incident_light(light, s.position.truncate()).direction;
            s.triangle != NO_TRIANGLE && dot(towards(&world.lights.as_slice()[0]), s.normal.truncate()) > 0.0
        };
        let shadow_rays = surfaces.iter().filter(faces_light).count() as u64;
        let light = LightParams { eye: camera.eye, light_count: 1, ..Default::default() };
        Ok(Self { camera, light, surfaces, shadow_rays })
    }
}

fn trace<B: Backend>(
    backend: &mut B,
    w: &World<B>,
    camera: &CameraParams,
    hits: &mut B::Buffer<Hit>,
) -> Result<(), BackendError> {
    backend.trace_primary(camera, &w.nodes, &w.blocks, &w.triangles, &w.materials, &w.texels, hits, PIXELS)
}

/// Times both kinds of rays on one backend.
fn rays<B: Backend>(
    group: &mut BenchmarkGroup<'_, WallTime>,
    machine: &str,
    backend: &mut B,
    w: &World<B>,
    shot: &Shot,
) -> Result<(), BackendError> {
    let mut hits = backend.alloc("hits", PIXELS as usize)?;
    group.throughput(Throughput::Elements(u64::from(PIXELS)));
    time(group, &format!("primary/{machine}"), backend, |backend| trace(backend, w, &shot.camera, &mut hits));
    let surfaces = backend.upload("surfaces", &shot.surfaces)?;
    let mut visible = backend.alloc("visibility", PIXELS as usize)?;
    group.throughput(Throughput::Elements(shot.shadow_rays));
    time(group, &format!("shadow/{machine}"), backend, |backend| {
        backend.light_visibility(
            &shot.light,
            &surfaces,
            &w.lights,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut visible,
            PIXELS,
        )
    });
    Ok(())
}

fn vector(value: &serde_json::Value) -> Option<Vec3> {
    let at = |i: usize| value.get(i)?.as_f64();
    Some(Vec3::new(at(0)? as f32, at(1)? as f32, at(2)? as f32))
}

/// The view `sponza-nave` of the folder's `views.json`: its scene under its sun, through its camera.
fn sponza(folder: &Path) -> Result<Scene, Box<dyn Error>> {
    let list: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(folder.join("views.json"))?)?;
    let views = list["views"].as_array().map_or(&[][..], Vec::as_slice);
    let view = views.iter().find(|v| v["name"] == "sponza-nave").ok_or("no view sponza-nave")?;
    let file = folder.join(view["scene"].as_str().ok_or("the view names no scene")?);
    let mut scene = Scene::open(&file.to_string_lossy())?;
    let lit = &view["light"];
    let direction = vector(&lit["direction"]).ok_or("its light has no direction")?;
    scene.lights = vec![light::sun(direction, vector(&lit["intensity"]).unwrap_or(Vec3::ONE))];
    scene.camera = Some(Camera {
        eye: vector(&view["eye"]).ok_or("the view has no eye")?,
        target: vector(&view["target"]).ok_or("the view has no target")?,
        up: Vec3::Y,
        fov: view["fov"].as_f64().ok_or("the view has no fov")? as f32,
    });
    Ok(scene)
}

fn scenes() -> Result<Vec<Scene>, Box<dyn Error>> {
    let mut scenes = vec![Scene::open("cornell-box")?];
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let folder = std::env::var_os("TWINLIGHT_SCENES").map_or_else(beside, PathBuf::from);
    match sponza(&folder) {
        Ok(scene) => scenes.push(scene),
        Err(error) => eprintln!(
            "skipped: sponza: {}: {error}; set TWINLIGHT_SCENES to the folder of scenes",
            folder.display()
        ),
    }
    Ok(scenes)
}

fn every_scene(c: &mut Criterion) -> Result<(), Box<dyn Error>> {
    let mut cpu = Cpu::new(None)?;
    let mut gpus = open_gpus();
    for scene in scenes()? {
        let tree = Bvh::build(&scene.triangles, &scene.materials)?;
        let world = World::upload(&mut cpu, &scene, &tree, false)?;
        let view = View::new(&scene.view(), SIDE, SIDE)?;
        let shot = Shot::new(&mut cpu, &world, &view)?;
        let mut group = c.benchmark_group(format!("rays/{}", scene.name));
        rays(&mut group, "cpu", &mut cpu, &world, &shot)?;
        for (machine, gpu) in &mut gpus {
            let world = World::upload(gpu, &scene, &tree, false)?;
            rays(&mut group, machine, gpu, &world, &shot)?;
        }
        group.finish();
    }
    Ok(())
}

fn all(c: &mut Criterion) {
    every_scene(c).expect("the scenes are traced");
}

criterion_group! {
    name = benches;
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(500))
        .measurement_time(Duration::from_secs(3))
        .sample_size(20);
    targets = all
}
criterion_main!(benches);
