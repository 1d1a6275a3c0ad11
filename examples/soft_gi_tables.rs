//! Prints what the knobs of soft global illumination cost and what they are worth, and draws its curves: the tables and
//! figures of `docs/soft-gi.md`.
//!
//! `cargo run --release --example soft_gi_tables [FOLDER]`; curves are written to FOLDER as .svg where it is given. The dragon is
//! taken from the folder `TWINLIGHT_SCENES`, and left out where it is not there. Errors are of the light on a floor under
//! spheres, against rays to the spheres themselves under the same light, and of pictures against the path tracer's meshes.

#[path = "common/curves.rs"]
mod curves;

use curves::{Curve, draw};
use glam::Vec3;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use twinlight::backend::Cpu;
use twinlight::picture::Picture;
use twinlight::report::error::picture_error;
use twinlight::scene::{Camera, Scene, bvh::Bvh, daylight};
use twinlight::technique::reference::{self, Bounces, Reference};
use twinlight::technique::soft_gi::{
    ENTRIES, Exponential, Operator, SoftGi, Surroundings, exact_operator_table, log_occlusion_table,
    optimal_linear_table, render,
};
use twinlight::technique::{Job, LightPart, View, World};
use twinlight_kernels::passes::elements::Triangle;
use twinlight_kernels::sampling::hash::{hash, unit_float};
use twinlight_kernels::sh;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const SIDE: u32 = 512;

/// A random blocker over a hemisphere: direction and sine.
fn blocker(seed: u32) -> (Vec3, f32) {
    let u = |k: u32| unit_float(hash(4 * seed + k));
    let (z, (s, c)) = (u(0), (std::f32::consts::TAU * u(1)).sin_cos());
    let r = (1.0 - z * z).sqrt();
    // Log-uniform from 0.1 to 0.7.
    (Vec3::new(r * c, r * s, z), 0.1 * 7.0f32.powf(u(2)))
}

/// RMS over the sphere of what an exponential gives for `m` blockers, less the ordered product chain; order 4.
fn exponential_error(m: u32, exponential: impl Fn(&[f32; 16]) -> [f32; 16]) -> f64 {
    let table = log_occlusion_table(4, ENTRIES as usize);
    let sets = 60;
    let mut sum = 0.0;
    for set in 0..sets {
        let mut logarithm = [0.0f32; 16];
        let mut chain = [0.0f32; 16];
        chain[0] = sh::UNIT;
        for k in 0..m {
            let (direction, alpha) = blocker(1000 * set + k + 7 * m);
            let f = sh::log_occlusion::<4>(&table, ENTRIES, sh::occlusion_key(alpha));
            logarithm = sh::add_scaled(&logarithm, &sh::rotate_zonal::<4, 16>(&f, direction), 1.0);
            let v = sh::rotate_zonal::<4, 16>(&sh::visibility::<4>(alpha), direction);
            chain = sh::product(&chain, &v);
        }
        let got = exponential(&logarithm);
        let square: f32 = got.iter().zip(&chain).map(|(a, b)| (a - b) * (a - b)).sum();
        sum += f64::from(square) / (4.0 * std::f64::consts::PI);
    }
    (sum / f64::from(sets)).sqrt()
}

fn exponentials(folder: Option<&Path>) -> Result<()> {
    let pairs = optimal_linear_table(4);
    let entries = pairs.len() as u32 / 2;
    type Kind<'a> = (&'a str, Box<dyn Fn(&[f32; 16]) -> [f32; 16] + 'a>);
    let kinds: Vec<Kind> = vec![
        ("hybrid, τ = ½", Box::new(|f| sh::hybrid(f, 0.5))),
        ("hybrid, τ = 1", Box::new(|f| sh::hybrid_with_table(f, 1.0, &pairs, entries))),
        ("hybrid, τ = ¼", Box::new(|f| sh::hybrid(f, 0.25))),
        ("taylor, τ = 1", Box::new(|f| sh::taylor(f, 1.0))),
        ("optimal linear", Box::new(|f| sh::clamp_to_feasible(&sh::optimal_linear(f, &pairs, entries)))),
        ("series of 3", Box::new(|f| sh::product_series(f, 3))),
        ("series of 9", Box::new(|f| sh::product_series(f, 9))),
    ];
    let counts = [1, 2, 4, 8, 16, 32, 64];
    println!(
        "| RMS against the product, order 4 | {} |",
        counts.map(|m| format!("{m} blockers")).join(" | ")
    );
    println!("|---|{}", "---|".repeat(counts.len()));
    let mut all = Vec::new();
    for (name, kind) in &kinds {
        let errors = counts.map(|m| exponential_error(m, kind));
        println!("| {name} | {} |", errors.map(|e| format!("{e:.4}")).join(" | "));
        let points = counts.iter().zip(errors).map(|(&m, e)| (f64::from(m), e)).collect();
        all.push(Curve { name: (*name).into(), points });
    }
    if let Some(folder) = folder {
        draw(
            &folder.join("soft-gi-exponentials.svg"),
            "overlapping blockers",
            "RMS against the product",
            &all,
        )?;
    }
    Ok(())
}

/// Frobenius norm of an operator less the exact one, over the exact one's; order 3.
fn operators(folder: Option<&Path>) -> Result<()> {
    let table = exact_operator_table(ENTRIES as usize);
    let mut curves: Vec<Curve> = ["point", "averaged, polynomials", "averaged"]
        .map(|n| Curve { name: n.into(), points: vec![] })
        .into();
    println!(
        "\n| error of the operator | {} |\n|---|---|---|---|",
        curves.iter().map(|c| c.name.clone()).collect::<Vec<_>>().join(" | ")
    );
    for step in 1..=19 {
        let alpha = step as f32 / 20.0;
        let cap = sh::cap::<3>(alpha);
        let kernels = [
            sh::rotate_zonal::<3, 9>(&[0.0; 3], Vec3::Z),
            sh::rotate_zonal::<3, 9>(&sh::averaged_operator_fit(alpha), Vec3::Z),
            sh::rotate_zonal::<3, 9>(&sh::averaged_operator(alpha), Vec3::Z),
        ];
        let mut sums = [0.0f64; 4];
        for column in 0..9 {
            let mut f = [0.0f32; 9];
            f[column] = 1.0;
            let exact = sh::exact_operator(&table, ENTRIES, alpha, &f);
            for k in 0..3 {
                let mean = if k == 0 { sh::basis::<9>(Vec3::NEG_Z)[column] } else { kernels[k][column] };
                let sent = sh::rotate_zonal::<3, 9>(&cap.map(|c| c * mean), Vec3::Z);
                sums[k] += sent.iter().zip(&exact).map(|(a, b)| f64::from((a - b) * (a - b))).sum::<f64>();
            }
            sums[3] += exact.iter().map(|b| f64::from(b * b)).sum::<f64>();
        }
        for k in 0..3 {
            curves[k].points.push((f64::from(alpha), (sums[k] / sums[3]).sqrt()));
        }
        if [2, 10, 18].contains(&step) {
            let shown: Vec<String> =
                curves.iter().map(|c| format!("{:.1} %", 100.0 * c.points[c.points.len() - 1].1)).collect();
            println!("| sin θ = {alpha} | {} |", shown.join(" | "));
        }
    }
    if let Some(folder) = folder {
        draw(
            &folder.join("soft-gi-operators.svg"),
            "sin θ",
            "error relative to the exact operator",
            &curves,
        )?;
    }
    Ok(())
}

/// A scene with the path tracer's picture of it under the light of an order.
struct Subject {
    name: &'static str,
    scene: Scene,
    camera: Camera,
    world: World<Cpu>,
    around: Surroundings,
    right: [Picture; 2],
}

fn subject(cpu: &mut Cpu, name: &'static str, scene: Scene, camera: Camera) -> Result<Subject> {
    let smooth = Scene { environment: Surroundings::new(&scene).as_environment(4, 256), ..scene };
    let tree = Bvh::build(&smooth.triangles, &smooth.materials)?;
    let view = View::new(&camera, SIDE / 4, SIDE / 4)?;
    let settings = Reference { samples: 1024, bounces: Bounces::Count(1), ..Default::default() };
    let right = reference::render(&smooth, &tree, &view, &settings, &AtomicBool::new(false), |_| ());
    let world = World::upload(cpu, &smooth, &tree, false)?;
    let around = Surroundings::new(&smooth);
    let sum = |a: &Picture, b: &Picture| Picture {
        pixels: a.pixels.iter().zip(&b.pixels).map(|(a, b)| *a + *b).collect(),
        ..a.clone()
    };
    let all = sum(&right.direct, &right.indirect);
    Ok(Subject { name, scene: smooth, camera, world, around, right: [right.direct, all] })
}

/// The flat parts of a scene, and its proxies as meshes: what the technique takes the scene for.
fn proxies_as_meshes(scene: &Scene) -> Scene {
    let flat = |t: &&Triangle| (t.p0.y.abs().max(t.p1.y.abs())).max(t.p2.y.abs()) < 1e-3;
    let mut triangles: Vec<Triangle> = scene.triangles.iter().filter(flat).copied().collect();
    let like = scene.triangles[scene.triangles.len() - 1];
    let (rings, sectors) = (24u32, 48u32);
    let point = |i: u32, j: u32| {
        let (s, c) = (std::f32::consts::PI * i as f32 / rings as f32).sin_cos();
        let (sj, cj) = (std::f32::consts::TAU * j as f32 / sectors as f32).sin_cos();
        Vec3::new(s * cj, c, s * sj)
    };
    for proxy in &scene.proxies {
        let mut add = |corners: [Vec3; 3]| {
            let at = corners.map(|n| (proxy.centre + n * proxy.radius).extend(0.0));
            let [n0, n1, n2] = corners.map(|n| n.extend(0.0));
            triangles.push(Triangle { p0: at[0], p1: at[1], p2: at[2], n0, n1, n2, ..like });
        };
        for i in 0..rings {
            for j in 0..sectors {
                let [a, b, c, d] = [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                if i + 1 < rings {
                    add([a, c, b]);
                }
                if i > 0 {
                    add([a, d, c]);
                }
            }
        }
    }
    Scene { triangles, ..scene.clone() }
}

fn shrunk(picture: &Picture, width: u32) -> Picture {
    let step = picture.width / width;
    let mut small = Picture::new(width, picture.height / step);
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (i as u32 % picture.width / step, i as u32 / picture.width / step);
        small.pixels[(y * width + x) as usize] += *pixel / (step * step) as f32;
    }
    small
}

fn knobs(cpu: &mut Cpu, s: &Subject) -> Result<()> {
    println!(
        "\n| {}, {} proxies | shadowed: RMSE, mean | all: RMSE, mean | ms |\n|---|---|---|---|",
        s.name,
        s.around.proxies.len()
    );
    type Change = (&'static str, fn(&mut SoftGi));
    let changes: [Change; 16] = [
        ("as it is: order 4, receivers ½", |_| ()),
        ("order 2", |s| s.order = 2),
        ("order 3", |s| s.order = 3),
        ("order 5", |s| s.order = 5),
        ("a receiver for each pixel", |s| s.receiver_scale = 1),
        ("receivers ¼", |s| s.receiver_scale = 4),
        ("receivers ⅛", |s| s.receiver_scale = 8),
        ("optimal linear", |s| s.exponential = Exponential::OptimalLinear),
        ("series of 9", |s| s.exponential = Exponential::Series),
        ("product of visibilities", |s| s.exponential = Exponential::Product),
        ("hybrid, τ = 1", |s| s.tau = 1.0),
        ("taylor, τ = 1", |s| (s.exponential, s.tau) = (Exponential::Taylor, 1.0)),
        ("hybrid, τ = ¼", |s| s.tau = 0.25),
        ("point operator", |s| s.operator = Operator::Point),
        ("exact operator", |s| s.operator = Operator::Exact),
        ("η = 4 for both", |s| (s.shadow_reach, s.light_reach) = (Some(4.0), 4.0)),
    ];
    let view = View::new(&s.camera, SIDE, SIDE)?;
    for (what, change) in changes {
        let mut settings = SoftGi::default();
        change(&mut settings);
        let mut cells = Vec::new();
        let mut time = 0.0;
        for (light, right) in [(LightPart::Direct, &s.right[0]), (LightPart::All, &s.right[1])] {
            let job = Job { light, ..Job::default() };
            let (rendered, _) = render(cpu, &s.world, &s.around, &view, &job, &settings)?;
            let e = picture_error(&shrunk(&rendered.picture, SIDE / 4), right).ok_or("sizes differ")?;
            cells.push(format!("{:.2} %, {:.4}", 100.0 * e.relative_rmse, e.mean_ratio));
            time = rendered.timings.iter().map(|t| t.nanoseconds * 1e-6).sum();
        }
        println!("| {what} | {} | {time:.0} |", cells.join(" | "));
    }
    let bare = Surroundings { proxies: vec![], ..s.around.clone() };
    let (rendered, _) = render(cpu, &s.world, &bare, &view, &Job::default(), &SoftGi::default())?;
    let e = picture_error(&shrunk(&rendered.picture, SIDE / 4), &s.right[1]).ok_or("sizes differ")?;
    println!("| no proxies | | {:.2} %, {:.4} | |", 100.0 * e.relative_rmse, e.mean_ratio);
    Ok(())
}

/// What more proxies cost, beside one another over the floor: work follows what they reach.
fn proxies(cpu: &mut Cpu, s: &Subject) -> Result<()> {
    println!(
        "\n| proxies | pairs with receivers | of all | culling ms | occlusion ms | indirect ms | exponential ms |\n|---|---|---|---|---|---|---|"
    );
    let view = View::new(&s.camera, SIDE, SIDE)?;
    for count in [8u32, 32, 128, 512] {
        let side = f64::from(count).sqrt().ceil() as u32;
        // As much volume however many: a row of small ones instead of few large.
        let radius = 0.5 * (8.0 / count as f32).cbrt();
        let mut around = s.around.clone();
        around.proxies = (0..count)
            .map(|i| {
                let at = |k: u32| 8.0 * ((k as f32 + 0.5) / side as f32 - 0.5);
                let mut proxy = s.around.proxies[0];
                proxy.sphere = Vec3::new(at(i % side), radius * 1.2, at(i / side)).extend(radius);
                proxy
            })
            .collect();
        let (rendered, c) = render(cpu, &s.world, &around, &view, &Job::default(), &SoftGi::default())?;
        let of = |stage: &str| -> f64 {
            rendered.timings.iter().filter(|t| t.stage == stage).map(|t| t.nanoseconds * 1e-6).sum()
        };
        let share = 100.0 * c.pairs as f64 / (f64::from(c.proxies) * f64::from(c.receivers));
        println!(
            "| {count} | {} | {share:.1} % | {:.2} | {:.1} | {:.1} | {:.1} |",
            c.pairs,
            of("culling"),
            of("occlusion"),
            of("indirect"),
            of("exponential")
        );
    }
    Ok(())
}

fn main() -> Result<()> {
    let folder = std::env::args().nth(1).map(PathBuf::from);
    exponentials(folder.as_deref())?;
    operators(folder.as_deref())?;
    let mut cpu = Cpu::new(None)?;
    let spheres = Scene::open("spheres")?;
    let camera = spheres.view();
    let s = subject(&mut cpu, "spheres", spheres, camera)?;
    knobs(&mut cpu, &s)?;
    proxies(&mut cpu, &s)?;
    println!("\n{} triangles", s.scene.triangles.len());
    let scenes = std::env::var_os("TWINLIGHT_SCENES").map(PathBuf::from).unwrap_or_default();
    let path = scenes.join("dragon.glb");
    if !path.is_file() {
        eprintln!("left out: dragon.glb is not in the folder TWINLIGHT_SCENES");
        return Ok(());
    }
    let open = || -> Result<Scene> {
        let mut dragon = Scene::open(&path.display().to_string())?;
        dragon.lights.clear();
        dragon.environment = daylight(Vec3::new(0.5, 0.6, 0.4).normalize(), 3.0)?;
        Ok(dragon)
    };
    let camera =
        Camera { eye: Vec3::new(0.6, 1.2, 2.4), target: Vec3::new(0.0, 0.45, 0.0), up: Vec3::Y, fov: 40.0 };
    let mut dragon = open()?;
    dragon.fit_proxies(64)?;
    let as_spheres = proxies_as_meshes(&dragon);
    let s = subject(&mut cpu, "dragon.glb's 64 spheres", as_spheres, camera)?;
    knobs(&mut cpu, &s)?;
    let s = subject(&mut cpu, "dragon.glb", dragon, camera)?;
    knobs(&mut cpu, &s)?;
    println!("\n| spheres fitted | difference of volume | all: RMSE, mean |\n|---|---|---|");
    for count in [8, 32, 128, 512] {
        let mut dragon = open()?;
        let fit = dragon.fit_proxies(count)?;
        let around = Surroundings { radiance: s.around.radiance, ..Surroundings::new(&dragon) };
        let view = View::new(&s.camera, SIDE, SIDE)?;
        let (rendered, _) = render(&mut cpu, &s.world, &around, &view, &Job::default(), &SoftGi::default())?;
        let e = picture_error(&shrunk(&rendered.picture, SIDE / 4), &s.right[1]).ok_or("sizes differ")?;
        println!(
            "| {count} | {:.1} % | {:.2} %, {:.4} |",
            100.0 * fit.error,
            100.0 * e.relative_rmse,
            e.mean_ratio
        );
    }
    cpu.take_timings();
    Ok(())
}
