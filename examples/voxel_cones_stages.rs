//! Prints what each stage of voxel cone tracing costs, and that it follows what the scene calls for: tables of
//! `docs/voxel-cones.md`.
//!
//! `cargo run --release --example voxel_cones_stages [RESOLUTION [SIDE]]`, 256 voxels and pictures of 512 × 512 if nothing is given.
//! The scene is Sponza from the folder `TWINLIGHT_SCENES`, or the built-in `spheres`; a ball of 960 triangles moves in it.
//! Times are sums of the passes' own, on the CPU and on the first GPU that answers; a software driver's say how much
//! work there is, not how fast a GPU does it.

use std::path::PathBuf;
use twinlight::backend::{Backend, Cpu, Gpu, GpuOptions};
use twinlight::scene::{Bounds, Camera, Scene, bvh::Bvh, light};
use twinlight::technique::voxel_cones::{Lighting, Pyramid, VoxelCones, render_lit, render_openness};
use twinlight::technique::{Cones, Job, View, World};
use twinlight_kernels::geometry::lattice::unpack_point;
use twinlight_kernels::passes::elements::{Light, Triangle};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Sponza, or the scene that needs no file; and how it is looked at.
fn subject() -> Result<(Scene, Camera)> {
    let folder = std::env::var_os("TWINLIGHT_SCENES").map(PathBuf::from).unwrap_or_default();
    let path = folder.join("sponza.glb");
    if !path.is_file() {
        let scene = Scene::open("spheres")?;
        let camera = scene.view();
        return Ok((scene, camera));
    }
    let mut scene = Scene::open(&path.display().to_string())?;
    scene.lights = vec![light::parse_sun("0.25,-1,0.15:12,11,9.5")?];
    let [eye, target] = [[-11.0, 1.7, -0.5], [8.0, 4.5, 0.0]].map(Into::into);
    Ok((scene, Camera { eye, target, up: glam::Vec3::Y, fov: 60.0 }))
}

/// Adds a ball to a scene, in front of the camera.
fn add_ball(scene: &mut Scene, camera: &Camera) {
    let centre = camera.eye.lerp(camera.target, 0.3);
    let radius = 0.04 * scene.bounds().size().max_element();
    let (rings, sectors) = (16, 32);
    let point = |i: u32, j: u32| {
        let (s, c) = (std::f32::consts::PI * i as f32 / rings as f32).sin_cos();
        let (sj, cj) = (std::f32::consts::TAU * j as f32 / sectors as f32).sin_cos();
        glam::Vec3::new(s * cj, c, s * sj)
    };
    let triangle = |a: glam::Vec3, b: glam::Vec3, c: glam::Vec3| Triangle {
        p0: (centre + a * radius).extend(0.0),
        p1: (centre + b * radius).extend(0.0),
        p2: (centre + c * radius).extend(0.0),
        n0: a.extend(0.0),
        n1: b.extend(0.0),
        n2: c.extend(0.0),
        ..scene.triangles[0]
    };
    let mut ball = Vec::new();
    for i in 0..rings {
        for j in 0..sectors {
            let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
            ball.extend((i + 1 < rings).then(|| triangle(a, b, c)));
            ball.extend((i > 0).then(|| triangle(a, c, d)));
        }
    }
    scene.triangles.extend(ball);
}

/// Milliseconds since the last call, of all passes or of a stage's.
fn time<B: Backend>(backend: &mut B, stage: Option<&str>) -> Result<f64> {
    let timings = backend.take_timings()?;
    let own = timings.iter().filter(|t| stage.is_none_or(|s| t.stage == s));
    Ok(own.map(|t| t.nanoseconds * 1e-6).sum())
}

fn stages<B: Backend>(
    backend: &mut B,
    scene: &Scene,
    standing: u32,
    view: &View,
    settings: &VoxelCones,
) -> Result<Vec<(String, f64)>> {
    let tree = Bvh::build(&scene.triangles, &scene.materials)?;
    let world = World::upload(backend, scene, &tree, false)?;
    let bounds = Bounds::of(&scene.triangles);
    let mut rows = Vec::new();
    backend.take_timings()?;
    let base = Pyramid::build_part(backend, &world, settings, &bounds, 0..standing)?;
    rows.push(("voxelisation of what stands".to_owned(), time(backend, None)?));
    let pyramid = base.with_moving(backend, &world, standing..world.triangle_count)?;
    rows.push(("update for the moving ball".to_owned(), time(backend, None)?));
    drop(base);
    let lighting = Lighting::new(backend, &world, &pyramid, settings)?;
    let timings = backend.take_timings()?;
    for stage in ["injection", "filtering"] {
        let own =
            timings.iter().filter(|t| t.stage == stage).map(|t| t.nanoseconds * 1e-6).sum::<f64>() + 0.0;
        rows.push((stage.to_owned(), own));
    }
    let settings = VoxelCones { illumination: Some((view.width, view.height)), ..settings.clone() };
    let rendered = render_lit(backend, &world, &pyramid, &lighting, view, &Job::default(), &settings)?;
    for stage in ["injection", "direct", "diffuse", "specular"] {
        let own =
            rendered.timings.iter().filter(|t| t.stage == stage).map(|t| t.nanoseconds * 1e-6).sum::<f64>()
                + 0.0;
        let what = if stage == "injection" { "injection when no light moved" } else { stage };
        rows.push((what.to_owned(), own));
    }
    for degrees in [10.0, 20.0, 30.0, 60.0] {
        let cones = Cones { half_angle: Some(0.5 * degrees), count: 3, ..settings.cones.clone() };
        let settings = VoxelCones { cones, occlusion: true, ..settings.clone() };
        let rendered = render_openness(backend, &world, &pyramid, view, &Job::default(), &settings)?;
        let own = rendered.timings.iter().filter(|t| t.stage == "occlusion");
        rows.push((format!("occlusion, 3 cones of {degrees}°"), own.map(|t| t.nanoseconds * 1e-6).sum()));
    }
    Ok(rows)
}

/// What a narrower light costs: work follows the voxels that it lights.
fn lit_table(scene: &Scene, camera: &Camera, settings: &VoxelCones) -> Result<()> {
    println!("\n| spot of | lit voxels | of all | filtering ms | of that at 80° |\n|---|---|---|---|---|");
    let tree = Bvh::build(&scene.triangles, &scene.materials)?;
    let mut whole = None;
    for outer in [80.0f32, 40.0, 20.0, 10.0, 5.0] {
        let eye = camera.eye.lerp(camera.target, 0.05);
        let direction = (camera.target - camera.eye).normalize();
        let lamp: Light =
            light::spot(eye, direction, glam::Vec3::ONE, 0.5 * outer.to_radians(), outer.to_radians());
        let lamped = Scene { lights: vec![lamp], ..scene.clone() };
        let mut cpu = Cpu::new(None)?;
        let world = World::upload(&mut cpu, &lamped, &tree, false)?;
        let pyramid = Pyramid::build(&mut cpu, &world, settings)?;
        cpu.take_timings();
        let mut best = f64::INFINITY;
        let mut lit = 0;
        for _ in 0..3 {
            lit = Lighting::new(&mut cpu, &world, &pyramid, settings)?.size().0;
            best = best.min(time(&mut cpu, Some("filtering"))?);
        }
        let whole = *whole.get_or_insert(best);
        let share = 100.0 * f64::from(lit) / f64::from(pyramid.voxels());
        println!("| {outer}° | {lit} | {share:.1} % | {best:.1} | {:.2} |", best / whole);
    }
    Ok(())
}

/// What bricks of 3³ voxels with shared borders would take: one for each octree node of 2³ cells of a level.
fn memory_table(scene: &Scene, settings: &VoxelCones) -> Result<()> {
    let tree = Bvh::build(&scene.triangles, &scene.materials)?;
    let mut cpu = Cpu::new(None)?;
    let world = World::upload(&mut cpu, scene, &tree, false)?;
    let p = Pyramid::build(&mut cpu, &world, settings)?;
    let mut cells: Vec<u32> = cpu.download(&p.points[0]);
    let mut nodes = 0usize;
    while cells.len() > 1 {
        let half = |word: u32| {
            let c = unpack_point(word) / 2;
            c.x | (c.y << 10) | (c.z << 20)
        };
        cells = cells.into_iter().map(half).collect();
        cells.sort_unstable();
        cells.dedup();
        nodes += cells.len();
    }
    let mib = |words: f64| words * 4.0 / 1_048_576.0;
    let (voxels, blocks) = (f64::from(p.voxels()), cpu.download(&p.blocks).len() as f64);
    println!(
        "\n| {}³ | places of voxels | MiB for a word each and the way to it |\n|---|---|---|",
        settings.resolution
    );
    // A node has a pointer to its children and one to its brick.
    let bricks = 27.0 * nodes as f64;
    println!("| bricks of 3³ | {bricks:.0} | {:.1} |", mib(bricks + 2.0 * nodes as f64));
    println!("| this pyramid | {voxels:.0} | {:.1} |", mib(voxels + blocks));
    println!("\nAll that stays: {:.1} MiB without light.", p.bytes() as f64 / 1_048_576.0);
    Ok(())
}

fn main() -> Result<()> {
    let number = |n: usize, default: u32| std::env::args().nth(n).map_or(Ok(default), |text| text.parse());
    let settings = VoxelCones { resolution: number(1, 256)?, ..Default::default() };
    let (mut scene, camera) = subject()?;
    let view = View::new(&camera, number(2, 512)?, number(2, 512)?)?;
    settings.check(view.width, view.height)?;
    println!("{}: {} triangles\n", scene.name, scene.triangles.len());
    let standing = scene.triangles.len() as u32;
    let plain = scene.clone();
    add_ball(&mut scene, &camera);
    let mut columns =
        vec![("CPU".to_owned(), stages(&mut Cpu::new(None)?, &scene, standing, &view, &settings)?)];
    match Gpu::new(&GpuOptions::default()) {
        Ok(mut gpu) => {
            let name = gpu.adapter().name.clone();
            columns.push((name, stages(&mut gpu, &scene, standing, &view, &settings)?));
        }
        Err(error) => eprintln!("no GPU: {error}"),
    }
    let names: Vec<&str> = columns.iter().map(|c| c.0.as_str()).collect();
    println!("| ms | {} |\n|---|{}", names.join(" | "), "---|".repeat(names.len()));
    for (i, (stage, _)) in columns[0].1.iter().enumerate() {
        let times: Vec<String> = columns.iter().map(|c| format!("{:.1}", c.1[i].1)).collect();
        println!("| {stage} | {} |", times.join(" | "));
    }
    lit_table(&plain, &camera, &settings)?;
    memory_table(&plain, &settings)
}
