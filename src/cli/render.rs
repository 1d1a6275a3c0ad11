//! `twinlight render`: one picture.

use super::options::{ArithmeticChoice, BackendOptions, SceneOptions, build_tree};
use super::visibility_filter::VisibilityFilterOptions;
use super::{Failure, print_out, table};
use crate::backend::Backend;
use crate::picture::{Format, Picture};
use crate::scene::{Scene, bvh::Bvh};
use crate::technique::reference::{self, Bounces, Reference, ReferenceResult};
use crate::report::error::{PictureError, picture_error};
use crate::technique::{Job, LightPart, Rendered, View, World, ambient_occlusion, direct, visibility_filter};
use clap::{Args, ValueEnum};
use serde_json::json;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

#[derive(Args)]
pub(crate) struct RenderArguments {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    backend: BackendOptions,
    /// How light is computed
    #[arg(long, default_value = "auto")]
    technique: Technique,
    /// Where the passes run
    #[arg(long = "backend", default_value = "cpu", value_name = "BACKEND")]
    machine: Machine,
    /// The picture's file, .png or .exr [default: the scene's name with .png]
    #[arg(short, long, value_name = "OUT.png|OUT.exr")]
    output: Option<PathBuf>,
    /// Reflections beyond direct light, or all (reference)
    #[arg(long, default_value = "1", value_parser = parse_bounces, value_name = "N|all")]
    bounces: Bounces,
    /// Paths per pixel (reference), or rays per pixel for the sky, emissive surfaces and occlusion
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    samples: u32,
    /// Seed of random numbers
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Let the reference see each pixel's centre only, as the techniques do
    #[arg(long)]
    pixel_centre: bool,
    /// Which light goes into the picture
    #[arg(long, default_value = "all")]
    only: Only,
    /// λ of the occlusion falloff 1/(1 + λ r), 1/m
    #[arg(long, default_value_t = 0.0, value_name = "λ", allow_hyphen_values = true)]
    falloff: f32,
    /// Distance beyond which nothing occludes, metres
    #[arg(long, default_value_t = 1.0e30, value_name = "METRES", allow_hyphen_values = true)]
    reach: f32,
    /// Buffers to save as pictures beside the output
    #[arg(long, value_delimiter = ',', value_name = "a,b,c")]
    dump: Vec<String>,
    /// Exposure of .png in stops
    #[arg(long, default_value_t = 0.0, value_name = "E", allow_hyphen_values = true)]
    exposure: f32,
    /// Picture to measure the error against, such as the reference's; .exr of the same size
    #[arg(long, value_name = "REFERENCE.exr")]
    against: Option<PathBuf>,
    /// Count non-finite values in every buffer; any is a failure
    #[arg(long)]
    check_finite: bool,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Print the tables as one JSON object
    #[arg(long)]
    json: bool,
    #[command(flatten)]
    filter: VisibilityFilterOptions,
}

#[derive(Clone, Copy, ValueEnum, PartialEq, Eq, Debug)]
enum Technique {
    /// What the scene calls for
    Auto,
    /// Light straight from its sources
    Direct,
    /// Path tracing
    Reference,
    /// Openness to the surroundings
    AmbientOcclusion,
    /// Point proxies in voxels, with filtered visibility: direct light and one bounce
    VisibilityFilter,
}

#[derive(Clone, Copy, ValueEnum, PartialEq, Eq)]
enum Machine {
    Cpu,
    Gpu,
    /// A GPU where there is a real one, else the CPU
    Auto,
}

#[derive(Clone, Copy, ValueEnum, PartialEq, Eq, Debug)]
enum Only {
    Indirect,
    Direct,
    All,
}

fn parse_bounces(text: &str) -> Result<Bounces, String> {
    match text {
        "all" => Ok(Bounces::All),
        _ => match text.parse() {
            Ok(n) if n <= 4096 => Ok(Bounces::Count(n)),
            _ => Err("expected a number from 0 to 4096, or all".into()),
        },
    }
}

/// What a technique made, ready to be written.
struct Outcome {
    picture: Picture,
    report: String,
    json: serde_json::Value,
    dumps: Vec<(String, Picture)>,
    interrupted: bool,
}

pub(crate) fn run(a: &RenderArguments) -> Result<(), Failure> {
    if !a.exposure.is_finite() || a.exposure.abs() > 100.0 {
        return Err(Failure::Request("--exposure: give stops from -100 to 100".into()));
    }
    if !(a.falloff >= 0.0 && a.falloff <= 1.0e18 && a.reach > 0.0 && a.reach <= 1.0e30) {
        return Err(Failure::Request(
            "--falloff must be from 0 to 1e18, --reach from above 0 to 1e30".into(),
        ));
    }
    let technique = if a.technique == Technique::Auto { Technique::Direct } else { a.technique };
    check_request(a, technique)?;
    let (scene, view) = a.scene.open()?;
    let output = a.output.clone().unwrap_or_else(|| PathBuf::from(format!("{}.png", scene.name)));
    for path in std::iter::once(output.clone()).chain(a.dump.iter().map(|name| dump_path(&output, name))) {
        check_output(&path)?;
    }
    if !a.quiet {
        for warning in &scene.warnings {
            eprintln!("note: {warning}");
        }
        if a.technique == Technique::Auto {
            eprintln!(
                "note: auto chose direct: the only technique for pictures without a path tracer so far"
            );
        }
    }
    let reference = a.against.as_deref().map(|path| open_reference(path, &view)).transpose()?;
    let cpu = a.backend.cpu()?;
    let tree = cpu.install(|| build_tree(&scene))?;
    let mut outcome = match technique {
        Technique::Reference => cpu.install(|| run_reference(a, &scene, &tree, &view)),
        _ => run_passes(a, technique, cpu, &scene, &tree, &view),
    }?;
    if let Some(error) = reference.and_then(|reference| picture_error(&outcome.picture, &reference)) {
        note_error(&mut outcome, &error);
    }
    let written = write(a, &output, &outcome)?;
    report(a, &outcome, &written)?;
    if outcome.interrupted {
        return Err(Failure::Work(format!("interrupted; {} holds what was done", output.display())));
    }
    Ok(())
}

/// Reads the picture that the error is measured against.
fn open_reference(path: &Path, view: &View) -> Result<Picture, Failure> {
    let refuse = |reason: String| Failure::Request(format!("--against {}: {reason}", path.display()));
    let picture = Picture::open_exr(path).map_err(|e| refuse(format!("{e}; give an .exr of linear radiance")))?;
    if (picture.width, picture.height) != (view.width, view.height) {
        return Err(refuse(format!(
            "it has {}x{} pixels, the picture {}x{}; render both at one size",
            picture.width, picture.height, view.width, view.height
        )));
    }
    Ok(picture)
}

fn note_error(outcome: &mut Outcome, error: &PictureError) {
    outcome.report += &format!(
        "relative RMSE {:.2} %, mean ratio {:.4}\n",
        100.0 * error.relative_rmse,
        error.mean_ratio
    );
    outcome.json["relative_rmse"] = json!(error.relative_rmse);
    outcome.json["mean_ratio"] = json!(error.mean_ratio);
}

/// Refuses what the technique cannot do, before any work.
fn check_request(a: &RenderArguments, technique: Technique) -> Result<(), Failure> {
    if technique == Technique::Direct && a.only == Only::Indirect {
        return Err(Failure::Request(
            "--technique direct has no indirect light; try --technique reference".into(),
        ));
    }
    if technique == Technique::AmbientOcclusion && a.only != Only::All {
        return Err(Failure::Request(
            "--only: ambient occlusion is not light; leave it out or choose another technique".into(),
        ));
    }
    if technique == Technique::Reference && a.machine == Machine::Gpu {
        return Err(Failure::Request(
            "--technique reference runs on the CPU; leave out --backend gpu".into(),
        ));
    }
    let known: &[&str] = match technique {
        Technique::Reference => &["direct", "indirect"],
        Technique::AmbientOcclusion => &ambient_occlusion::DUMPS,
        Technique::VisibilityFilter => &visibility_filter::DUMPS,
        _ => &direct::DUMPS,
    };
    for name in &a.dump {
        if !known.contains(&name.as_str()) {
            return Err(Failure::Request(format!("--dump {name}: this technique has {}", known.join(", "))));
        }
    }
    Ok(())
}

/// Makes sure that the picture can be written, before the work begins.
fn check_output(output: &Path) -> Result<(), Failure> {
    Format::of(output)?;
    let folder = output.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        return Err(Failure::Request(format!(
            "--output {}: its folder does not exist; make it first",
            output.display()
        )));
    }
    if output.is_dir() {
        return Err(Failure::Request(format!(
            "--output {}: this is a folder; give a file name",
            output.display()
        )));
    }
    Ok(())
}

fn run_passes(
    a: &RenderArguments,
    technique: Technique,
    mut cpu: crate::backend::Cpu,
    scene: &Scene,
    tree: &Bvh,
    view: &View,
) -> Result<Outcome, Failure> {
    let gpu = match a.machine {
        Machine::Cpu => false,
        Machine::Gpu => true,
        Machine::Auto => {
            use twinlight_gpu::wgpu::DeviceType;
            twinlight_gpu::adapters().iter().any(|x| {
                matches!(x.get_info().device_type, DeviceType::DiscreteGpu | DeviceType::IntegratedGpu)
            })
        }
    };
    if gpu {
        let mut gpu = a.backend.gpu(ArithmeticChoice::Fast)?;
        let name = format!("gpu, {}, {:?}", twinlight_gpu::describe(gpu.adapter()), gpu.variant());
        draw(a, technique, &mut gpu, scene, tree, view, &name)
    } else {
        let name = format!("cpu, {} threads", cpu.threads());
        draw(a, technique, &mut cpu, scene, tree, view, &name)
    }
}

fn draw<B: Backend>(
    a: &RenderArguments,
    technique: Technique,
    backend: &mut B,
    scene: &Scene,
    tree: &Bvh,
    view: &View,
    machine: &str,
) -> Result<Outcome, Failure> {
    let world = World::upload(backend, scene, tree, a.scene.emissive)?;
    let job = Job {
        rays: a.samples,
        seed: a.seed,
        falloff: a.falloff,
        reach: a.reach,
        light: match a.only {
            Only::All => LightPart::All,
            Only::Direct => LightPart::Direct,
            Only::Indirect => LightPart::Indirect,
        },
        dumps: a.dump.clone(),
        check_finite: a.check_finite,
    };
    let mut notes = String::new();
    let mut counted = serde_json::Value::Null;
    let rendered: Rendered = match technique {
        Technique::AmbientOcclusion => ambient_occlusion::render(backend, &world, view, &job)?,
        Technique::VisibilityFilter => {
            let settings = a.filter.settings()?;
            let (rendered, c) = visibility_filter::render(backend, &world, view, &job, &settings)?;
            notes = format!("{} proxies, {} in overlapped voxels, lists of {} voxels\n", c.proxies, c.pairs, c.capacity);
            if c.full_lists > 0 {
                notes += &format!(
                    "{} lists were too small for {} voxels in all: raise --list-capacity\n",
                    c.full_lists, c.dropped
                );
            }
            counted = json!({ "proxies": c.proxies, "pairs": c.pairs, "list_capacity": c.capacity,
                "full_lists": c.full_lists, "dropped_voxels": c.dropped });
            rendered
        }
        _ => direct::render(backend, &world, view, &job)?,
    };
    let bad: u64 = rendered.non_finite.iter().map(|n| n.count).sum();
    if bad > 0 {
        let where_: Vec<String> = rendered
            .non_finite
            .iter()
            .filter(|n| n.count > 0)
            .map(|n| format!("{} in {}", n.count, n.buffer))
            .collect();
        return Err(Failure::Work(format!(
            "non-finite values: {}; please report the scene",
            where_.join(", ")
        )));
    }
    let mean = rendered.picture.mean();
    let mut text = format!("{technique:?} on {machine}\n{}", table::passes_text(&rendered.timings));
    text += &notes;
    text += &format!("mean {:.5} {:.5} {:.5}\n", mean.x, mean.y, mean.z);
    if a.check_finite {
        text += &format!("non-finite values: 0 in {} buffers\n", rendered.non_finite.len());
    }
    let json = json!({
        "technique": format!("{technique:?}"),
        "machine": machine,
        "passes": table::passes_json(&rendered.timings),
        "stages": table::stages_json(&rendered.timings),
        "counts": counted,
        "mean": mean.to_array(),
    });
    Ok(Outcome {
        picture: rendered.picture,
        report: text,
        json,
        dumps: rendered.dumps.into_iter().collect(),
        interrupted: false,
    })
}

fn run_reference(a: &RenderArguments, scene: &Scene, tree: &Bvh, view: &View) -> Result<Outcome, Failure> {
    let settings = Reference {
        bounces: a.bounces,
        samples: a.samples,
        seed: a.seed,
        emissive: a.scene.emissive,
        pixel_filter: !a.pixel_centre,
    };
    let stop = Arc::new(AtomicBool::new(false));
    let seen = stop.clone();
    // Without a handler an interruption simply ends the command: nothing is written then.
    let _ = ctrlc::set_handler(move || seen.store(true, Ordering::Relaxed));
    let bar = if a.quiet {
        indicatif::ProgressBar::hidden()
    } else {
        indicatif::ProgressBar::new(u64::from(a.samples))
    };
    if let Ok(style) =
        indicatif::ProgressStyle::with_template("{bar:40} {pos}/{len} paths per pixel, {eta} left")
    {
        bar.set_style(style);
    }
    let start = std::time::Instant::now();
    let result =
        reference::render(scene, tree, view, &settings, &stop, |done| bar.set_position(u64::from(done)));
    bar.finish_and_clear();
    if result.samples == 0 {
        return Err(Failure::Work(
            "interrupted before the first paths were done; nothing was written".into(),
        ));
    }
    if a.check_finite {
        let bad = |p: &Picture| p.pixels.iter().filter(|c| !c.is_finite()).count();
        let (direct, indirect) = (bad(&result.direct), bad(&result.indirect));
        if direct + indirect > 0 {
            return Err(Failure::Work(format!(
                "non-finite pixels: {direct} in direct, {indirect} in indirect; please report the scene"
            )));
        }
    }
    Ok(reference_outcome(a, result, start.elapsed().as_secs_f64(), stop.load(Ordering::Relaxed)))
}

fn reference_outcome(
    a: &RenderArguments,
    result: ReferenceResult,
    seconds: f64,
    interrupted: bool,
) -> Outcome {
    let mut text = format!("Reference on cpu: {} paths per pixel in {seconds:.2} s\n", result.samples);
    text += "light      mean r       mean g       mean b   standard error   pixel standard error\n";
    let mut json = json!({ "technique": "Reference", "samples": result.samples, "seconds": seconds });
    for (name, s) in ["direct", "indirect", "all"].iter().zip(&result.statistics) {
        text += &format!(
            "{name:<8} {:>12.6} {:>12.6} {:>12.6} {:>12.6} {:>12.6}\n",
            s.mean.x, s.mean.y, s.mean.z, s.standard_error, s.pixel_standard_error
        );
        json[name] = json!({
            "mean": s.mean.to_array(),
            "standard_error": s.standard_error,
            "pixel_standard_error": s.pixel_standard_error,
        });
    }
    let picture = match a.only {
        Only::Direct => result.direct.clone(),
        Only::Indirect => result.indirect.clone(),
        Only::All => result.all(),
    };
    let mut dumps = Vec::new();
    for name in &a.dump {
        let dump = if name == "direct" { result.direct.clone() } else { result.indirect.clone() };
        dumps.push((name.clone(), dump));
    }
    Outcome { picture, report: text, json, dumps, interrupted }
}

/// The file of a buffer's picture, beside the output: `a.png` has `a.normal.png`.
fn dump_path(output: &Path, name: &str) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let extension = output.extension().unwrap_or_default().to_string_lossy();
    output.with_file_name(format!("{stem}.{name}.{extension}"))
}

/// Writes the picture and its dumps; returns the files' names.
fn write(a: &RenderArguments, output: &Path, outcome: &Outcome) -> Result<Vec<String>, Failure> {
    let mut names = vec![output.display().to_string()];
    outcome.picture.save(output, a.exposure)?;
    for (name, picture) in &outcome.dumps {
        let path = dump_path(output, name);
        picture.save(&path, 0.0)?;
        names.push(path.display().to_string());
    }
    Ok(names)
}

fn report(a: &RenderArguments, outcome: &Outcome, written: &[String]) -> Result<(), Failure> {
    if a.json {
        let mut json = outcome.json.clone();
        json["files"] = json!(written);
        print_out(&format!("{json}\n"))
    } else if !a.quiet {
        print_out(&format!("{}wrote {}\n", outcome.report, written.join(", ")))
    } else {
        Ok(())
    }
}
