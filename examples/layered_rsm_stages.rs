//! Prints what each stage of layered reflective shadow maps costs beside voxel cones, what they need of memory, what a light more
//! costs, and how a moving light flickers: tables of `docs/layered-rsm.md`.
//!
//! `cargo run --release --example layered_rsm_stages [WIDTH HEIGHT]`, the paper's 1280 × 720 if nothing is given. The scenes are Sponza and Sibenik
//! from the folder `TWINLIGHT_SCENES`, and the built-in `cornell-glossy`. Times are sums of the passes' own, on the CPU and on the first
//! GPU that answers; a software driver's say how much work there is, not how fast a GPU does it.

#[allow(dead_code)]
#[path = "common/tables.rs"]
mod tables;

use tables::{Result, Subject, subjects};
use twinlight::backend::{Backend, Cpu, Gpu, GpuOptions};
use twinlight::picture::Picture;
use twinlight::scene::{Scene, bvh::Bvh, light};
use twinlight::technique::layered_rsm::{self, Counts, LayeredRsm};
use twinlight::technique::voxel_cones::{self, VoxelCones};
use twinlight::technique::{Cones, Job, LightPart, Rendered, View, World};

/// Milliseconds of a stage's passes.
fn of(rendered: &Rendered, stage: &str) -> f64 {
    rendered.timings.iter().filter(|t| t.stage == stage).map(|t| t.nanoseconds * 1e-6).sum::<f64>() + 0.0
}

/// The rows of the paper's table 3: voxelisation, light, shadows, diffuse, specular; by voxel cones and by layered maps.
fn stages<B: Backend>(
    backend: &mut B,
    subject: &Subject,
    preset: &str,
    (width, height): (u32, u32),
) -> Result<(Vec<[f64; 2]>, Counts, u64)> {
    let view = View::new(&subject.camera, width, height)?;
    let tree = Bvh::build(&subject.scene.triangles, &subject.scene.materials)?;
    let world = World::upload(backend, &subject.scene, &tree, false)?;
    let published = LayeredRsm::preset(preset).ok_or("a preset is missing")?;
    // The paper's sizes with this project's defaults for what it mends.
    let usual = LayeredRsm::default();
    let settings = LayeredRsm {
        illumination: Some((width, height)),
        opacity: usual.opacity,
        weights: usual.weights,
        moments: usual.moments,
        overlap: usual.overlap,
        ..published
    };
    let job = Job::default();
    backend.take_timings()?;
    let (layered, counts) = layered_rsm::render(backend, &world, &view, &job, &settings)?;
    let others = VoxelCones {
        resolution: settings.resolution,
        cones: Cones { ..settings.cones.clone() },
        light_map: settings.map,
        illumination: settings.illumination,
        ..Default::default()
    };
    let (voxels, sizes) = voxel_cones::render(backend, &world, &view, &job, &others)?;
    let rows = vec![
        [of(&voxels, "voxelisation"), of(&layered, "voxelisation")],
        [of(&voxels, "injection") + of(&voxels, "filtering"), of(&layered, "maps")],
        [f64::NAN, of(&layered, "shadows")],
        [of(&voxels, "diffuse"), of(&layered, "diffuse")],
        [of(&voxels, "specular"), of(&layered, "specular")],
    ];
    Ok((rows, counts, sizes.bytes))
}

fn stage_tables(subject: &Subject, preset: &str, size: (u32, u32)) -> Result<()> {
    let mut columns = vec![("CPU".to_owned(), stages(&mut Cpu::new(None)?, subject, preset, size)?)];
    match Gpu::new(&GpuOptions::default()) {
        Ok(mut gpu) => {
            let name = gpu.adapter().name.clone();
            columns.push((name, stages(&mut gpu, subject, preset, size)?));
        }
        Err(error) => eprintln!("no GPU: {error}"),
    }
    let (_, (_, counts, voxel_cones)) = &columns[0];
    println!("\n{}, {} × {}, sizes of `{preset}`:\n", subject.name, size.0, size.1);
    let heads = columns.iter().map(|c| format!("{0}, voxel cones | {0}, layered maps", c.0));
    println!("| ms | {} |\n|---|{}", heads.collect::<Vec<_>>().join(" | "), "---|---|".repeat(columns.len()));
    for (i, what) in ["voxelisation", "photons or maps", "shadow cones", "6 diffuse cones", "1 specular cone"]
        .iter()
        .enumerate()
    {
        let cells: Vec<String> = columns
            .iter()
            .flat_map(|c| c.1.0[i])
            .map(|ms| if ms.is_nan() { "rays".to_owned() } else { format!("{ms:.0}") })
            .collect();
        println!("| {what} | {} |", cells.join(" | "));
    }
    let mb = |bytes: u64| bytes as f64 * 1e-6;
    println!("\n| MB | voxels | map, not kept | layers | in all |\n|---|---|---|---|---|");
    let whole = counts.voxel_bytes + counts.map_bytes + counts.layer_bytes;
    println!(
        "| layered maps | {:.1} | {:.1} | {:.1} | {:.1} |\n| voxel cones | | | | {:.1} |",
        mb(counts.voxel_bytes),
        mb(counts.map_bytes),
        mb(counts.layer_bytes),
        mb(whole),
        mb(*voxel_cones)
    );
    Ok(())
}

/// Time against the number of lights.
fn light_table(subject: &Subject) -> Result<()> {
    println!("\n| lights in {} | maps ms | diffuse ms | MiB of layers |\n|---|---|---|---|", subject.name);
    let tree = Bvh::build(&subject.scene.triangles, &subject.scene.materials)?;
    let view = View::new(&subject.camera, 256, 256)?;
    let lamp = subject.scene.lights[0];
    for count in [1, 2, 4, 8] {
        let scene = Scene { lights: vec![lamp; count], ..subject.scene.clone() };
        let mut cpu = Cpu::new(None)?;
        let world = World::upload(&mut cpu, &scene, &tree, false)?;
        let job = Job { light: LightPart::Indirect, ..Job::default() };
        let settings = LayeredRsm::default();
        let mut best = [f64::INFINITY; 2];
        let mut bytes = 0;
        for _ in 0..3 {
            let (rendered, counts) = layered_rsm::render(&mut cpu, &world, &view, &job, &settings)?;
            bytes = counts.layer_bytes;
            best = [best[0].min(of(&rendered, "maps")), best[1].min(of(&rendered, "diffuse"))];
        }
        println!("| {count} | {:.0} | {:.0} | {:.1} |", best[0], best[1], bytes as f64 / 1_048_576.0);
    }
    Ok(())
}

/// What frames differ by beyond a steady change, over their mean: the mean absolute second difference, of all pixels but the
/// `worst` that change most.
fn flicker(frames: &[Picture], worst: usize) -> f64 {
    let mut of_pixel = vec![0.0f64; frames[0].pixels.len()];
    for w in frames.windows(3) {
        let pixels = w[0].pixels.iter().zip(&w[1].pixels).zip(&w[2].pixels);
        for (sum, ((a, b), c)) in of_pixel.iter_mut().zip(pixels) {
            *sum += f64::from((*a - *b * 2.0 + *c).abs().element_sum());
        }
    }
    of_pixel.sort_by(|a, b| b.total_cmp(a));
    of_pixel[worst..].iter().sum::<f64>() / (frames.len() - 2) as f64 / (total(frames) / frames.len() as f64)
}

/// The sum of all pixels of all frames.
fn total(frames: &[Picture]) -> f64 {
    frames.iter().flat_map(|f| &f.pixels).map(|p| f64::from(p.element_sum())).sum()
}

/// Flicker of a light that moves 11 mm a frame, and what is left of detail, against the finest level that is looked up.
fn flicker_table() -> Result<()> {
    println!(
        "\n| finest level | flicker, diffuse | flicker, specular | but for 10 pixels | light, diffuse | light, specular | sharpness, specular |\n|---|---|---|---|---|---|---|"
    );
    let mut scene = Scene::open("cornell-glossy")?;
    let tree = Bvh::build(&scene.triangles, &scene.materials)?;
    let view = View::new(&scene.view(), 96, 96)?;
    let mut light_at_0 = None;
    for least_level in [0.0, 1.0, 2.0, 3.0, 4.0, 5.0] {
        let settings = LayeredRsm {
            least_level,
            cones: Cones { specular_half_angle: Some(5.0), ..Cones::default() },
            illumination: Some((96, 96)),
            ..Default::default()
        };
        let job = Job {
            light: LightPart::Indirect,
            dumps: vec!["diffuse".to_owned(), "specular".to_owned()],
            ..Job::default()
        };
        let (mut diffuse, mut specular) = (Vec::new(), Vec::new());
        for i in 0..8 {
            let at = glam::Vec3::new(-0.2 + 0.011 * i as f32, 1.2, 0.1);
            scene.lights = vec![light::point(at, glam::Vec3::splat(2.0))];
            let mut cpu = Cpu::new(None)?;
            let world = World::upload(&mut cpu, &scene, &tree, false)?;
            let mut rendered = layered_rsm::render(&mut cpu, &world, &view, &job, &settings)?.0;
            diffuse.extend(rendered.dumps.remove("diffuse"));
            specular.extend(rendered.dumps.remove("specular"));
        }
        let whole_light = *light_at_0.get_or_insert([total(&diffuse), total(&specular)]);
        // Mean absolute difference of neighbouring pixels in a row, over the mean.
        let first = &specular[0].pixels;
        let edges: f64 = first.windows(2).map(|w| f64::from((w[0] - w[1]).abs().element_sum())).sum();
        let whole: f64 = first.iter().map(|p| f64::from(p.element_sum())).sum();
        println!(
            "| {least_level} | {:.2} % | {:.2} % | {:.2} % | {:.3} | {:.3} | {:.1} % |",
            100.0 * flicker(&diffuse, 0),
            100.0 * flicker(&specular, 0),
            100.0 * flicker(&specular, 10),
            total(&diffuse) / whole_light[0],
            total(&specular) / whole_light[1],
            100.0 * edges / whole
        );
    }
    Ok(())
}

fn main() -> Result<()> {
    if std::env::args().nth(1).as_deref() == Some("flicker") {
        return flicker_table();
    }
    let number = |n: usize, default: u32| std::env::args().nth(n).map_or(Ok(default), |text| text.parse());
    let size = (number(1, 1280)?, number(2, 720)?);
    let mut lit = None;
    let scenes = [
        ("cornell-glossy", "paper-sibenik"),
        ("sibenik.glb", "paper-sibenik"),
        ("sponza.glb", "paper-sponza"),
    ];
    for (name, preset) in scenes {
        if let Some(subject) = subjects(Some(name))?.into_iter().next() {
            stage_tables(&subject, preset, size)?;
            lit = Some(subject);
        }
    }
    light_table(&lit.ok_or("no scene")?)?;
    flicker_table()
}
