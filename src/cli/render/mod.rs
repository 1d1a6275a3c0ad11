//! `twinlight render`: one picture, or one for each frame; and `twinlight explain`: what would run, and why.

mod explained;
mod frames;
mod output;
mod passes;
mod path_traced;

use super::knobs::{Knobs, Of};
use super::options::{ArithmeticChoice, BackendOptions, Kept, SceneOptions, build_tree};
use super::{Failure, print_out};
use crate::picture::Picture;
use crate::plan::{Change, Plan, Request, choose};
use crate::scene::Scene;
use crate::technique::reference::Bounces;
use crate::technique::{ambient_occlusion, direct, layered_rsm, soft_gi, visibility_filter, voxel_cones};
use clap::{Args, Parser, ValueEnum};
use output::{check_output, dump_path, note_error, open_reference, report, write};
use std::path::{Path, PathBuf};
use std::time::Duration;
use twinlight_kernels::passes::PassTiming;

#[derive(Args, Clone)]
pub(crate) struct RenderArguments {
    #[command(flatten)]
    pub(crate) scene: SceneOptions,
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
    /// Frames of an animation, both included; written as OUT/0000.png and so on, or by a pattern such as OUT/%04d.exr [default: the moment 0]
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    frames: Option<(u32, u32)>,
    /// Frames per second of --frames
    #[arg(long, default_value_t = 25.0, value_name = "N")]
    fps: f64,
    /// Turn the camera around its target, degrees a frame
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    orbit: Option<f64>,
    /// Leave out frames whose file is there
    #[arg(long)]
    resume: bool,
    /// Render every N-th frame only, from the I-th on: part I of N
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    shard: Option<(u32, u32)>,
    /// Effects to compute where the scene has use for them [default: all; see twinlight explain]
    #[arg(long, value_delimiter = ',', value_name = "a,b,c")]
    effects: Option<Vec<String>>,
    /// Leave out effects that can add no more than this share of the light
    #[arg(long, default_value_t = 0.0, value_name = "SHARE", allow_hyphen_values = true)]
    quality: f64,
    /// Leave out effects until the passes are expected to take no longer, such as 40ms or 1.5s
    #[arg(long, value_name = "TIME", value_parser = parse_budget)]
    budget: Option<Duration>,
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
    knobs: Knobs,
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
    /// Cones through filtered voxels: direct light and one or more bounces, or occlusion
    VoxelCones,
    /// Spherical proxies under soft surroundings: shadows and one bounce
    SoftGi,
    /// Cones through binary voxels and layered maps of what lights see: direct light and one bounce
    LayeredRsm,
}

#[derive(Clone, Copy, ValueEnum, PartialEq, Eq)]
pub(crate) enum Machine {
    Cpu,
    Gpu,
    /// A GPU where there is a real one, else the CPU
    Auto,
}

impl Machine {
    /// Whether passes run on a GPU: for `auto`, where there is a real one.
    pub(crate) fn is_gpu(self) -> bool {
        use twinlight_gpu::wgpu::DeviceType;
        let real = |kind| matches!(kind, DeviceType::DiscreteGpu | DeviceType::IntegratedGpu);
        match self {
            Self::Cpu => false,
            Self::Gpu => true,
            Self::Auto => twinlight_gpu::adapters().iter().any(|x| real(x.get_info().device_type)),
        }
    }
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

fn parse_frames(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once("..").and_then(|(a, b)| Some((a.parse().ok()?, b.parse().ok()?)));
    match parsed {
        Some((first, last)) if first <= last && last < 100_000 => Ok((first, last)),
        _ => Err("expected A..B with A up to B, at most 99999".into()),
    }
}

fn parse_shard(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once('/').and_then(|(i, n)| Some((i.parse().ok()?, n.parse().ok()?)));
    match parsed {
        Some((i, n)) if i >= 1 && i <= n => Ok((i, n)),
        _ => Err("expected I/N with I from 1 to N, such as 3/16".into()),
    }
}

fn parse_budget(text: &str) -> Result<Duration, String> {
    let (number, unit) = match text.strip_suffix("ms") {
        Some(number) => (number, 1e-3),
        None => (text.strip_suffix('s').unwrap_or(""), 1.0),
    };
    match number.parse::<f64>() {
        Ok(x) if x > 0.0 && x * unit < 1e6 => Ok(Duration::from_secs_f64(x * unit)),
        _ => Err("expected a time such as 40ms or 1.5s".into()),
    }
}

/// What a technique made, ready to be written.
struct Outcome {
    picture: Picture,
    report: String,
    json: serde_json::Value,
    dumps: Vec<(String, Picture)>,
    interrupted: bool,
    /// The passes that ran; none for the reference.
    ran: Vec<PassTiming>,
    /// What had changed since the frame before.
    changes: Vec<Change>,
}

/// A command line of `render`.
#[derive(Parser)]
#[command(no_binary_name = true, args_override_self = true)]
struct Line {
    #[command(flatten)]
    arguments: RenderArguments,
}

/// Reads words that stand for a command line of `render`.
pub(crate) fn parse_line(words: &[String]) -> Result<RenderArguments, Failure> {
    let line = Line::try_parse_from(words).map_err(|e| {
        let text = e.to_string();
        let first = text.lines().next().unwrap_or_default().trim_start_matches("error: ");
        Failure::Request(format!("{}: {first}", words.join(" ")))
    })?;
    Ok(line.arguments)
}

/// What the options ask of their technique.
pub(crate) fn request_of(a: &RenderArguments, view: &crate::technique::View) -> Result<Request, Failure> {
    check_request(a, a.technique)?;
    passes::request(a, a.technique, view)
}

impl RenderArguments {
    /// `--arithmetic`.
    pub(crate) fn arithmetic(&self) -> Option<ArithmeticChoice> {
        self.backend.arithmetic
    }
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
    if a.technique != Technique::Auto {
        check_request(a, a.technique)?;
    }
    match a.frames {
        Some(frames) => frames::run(a, frames),
        None if a.orbit.is_some() || a.resume || a.shard.is_some() => {
            Err(Failure::Request("--orbit, --resume and --shard: for frames; give --frames A..B".into()))
        }
        None => one(a, Moment::default(), a.output.as_deref(), &mut Session::default()).map(|_| ()),
    }
}

/// Prints the plan of a picture, and what follows from it.
pub(crate) fn explain(a: &RenderArguments) -> Result<(), Failure> {
    if a.budget.is_some() {
        return Err(Failure::Request(
            "--budget: it takes trials, and explain renders nothing; leave it out".into(),
        ));
    }
    let mut kept = Kept::default();
    let (scene, view) = a.scene.open_at(0.0, 0.0, &mut kept)?;
    let (next, _) = a.scene.open_at(1.0 / 25.0, 0.0, &mut kept)?;
    let motion = explained::Motion::between(&scene, &next);
    let (technique, reason) = chosen(a, &scene, a.frames.is_some() && motion.any());
    check_request(a, technique)?;
    let request = passes::request(a, technique, &view)?;
    let tree = build_tree(&scene)?;
    let plan = Plan::new(&scene, &request).map_err(|e| Failure::Request(e.to_string()))?;
    let costs = crate::renderer::costs(&scene, &tree, &plan)?;
    if a.json {
        return print_out(&format!("{}\n", explained::json(&scene, motion, &plan, &costs, reason)));
    }
    let auto = reason.map_or_else(String::new, |why| format!("auto chose {}: {why}\n", name(technique)));
    print_out(&format!("{auto}{}\n{}{}", explained::census(&scene, motion), plan.text(), costs.text()))
}

/// What frames share.
#[derive(Default)]
struct Session {
    kept: Kept,
    running: Option<passes::Running>,
    /// Whether meshes or lights move.
    moving: bool,
}

/// When, and how far the camera has turned.
#[derive(Clone, Copy, Default)]
struct Moment {
    seconds: f64,
    degrees: f64,
}

/// Renders the scene at a moment; returns the passes that ran and what had changed.
fn one(
    a: &RenderArguments,
    moment: Moment,
    output: Option<&Path>,
    session: &mut Session,
) -> Result<(Vec<PassTiming>, Vec<Change>), Failure> {
    let (scene, view) = a.scene.open_at(moment.seconds, moment.degrees, &mut session.kept)?;
    let (technique, reason) = chosen(a, &scene, session.moving);
    check_request(a, technique)?;
    let output = output.map_or_else(|| PathBuf::from(format!("{}.png", scene.name)), Path::to_owned);
    for path in std::iter::once(output.clone()).chain(a.dump.iter().map(|name| dump_path(&output, name))) {
        check_output(&path)?;
    }
    if !a.quiet {
        for warning in &scene.warnings {
            eprintln!("note: {warning}");
        }
        if let Some(why) = reason {
            eprintln!("note: auto chose {}: {why}", name(technique));
        }
    }
    let reference = a.against.as_deref().map(|path| open_reference(path, &view)).transpose()?;
    let mut outcome = match technique {
        Technique::Reference => {
            let cpu = a.backend.cpu()?;
            cpu.install(|| path_traced::run(a, &scene, &build_tree(&scene)?, &view))
        }
        _ => passes::run(a, technique, &mut session.running, scene, &view),
    }?;
    if let Some(reference) = reference {
        note_error(&mut outcome, &reference);
    }
    let written = write(a, &output, &outcome)?;
    report(a, &outcome, &written)?;
    if outcome.interrupted {
        return Err(Failure::Work(format!("interrupted; {} holds what was done", output.display())));
    }
    Ok((outcome.ran, outcome.changes))
}

/// The technique that is asked for, or the one that suits the scene, with the reason.
fn chosen(a: &RenderArguments, scene: &Scene, moving: bool) -> (Technique, Option<&'static str>) {
    if a.technique != Technique::Auto {
        return (a.technique, None);
    }
    let (chosen, why) = choose(&scene.census(), a.only.light(), a.scene.look.emissive, moving);
    (Technique::from_str(chosen, false).unwrap_or(Technique::Direct), Some(why))
}

/// The technique's name as an option.
fn name(technique: Technique) -> String {
    technique.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
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
    if technique == Technique::Reference && (a.effects.is_some() || a.quality > 0.0 || a.budget.is_some()) {
        return Err(Failure::Request(
            "--effects, --quality and --budget do nothing for --technique reference; leave them out".into(),
        ));
    }
    if technique == Technique::Reference && a.machine == Machine::Gpu {
        return Err(Failure::Request(
            "--technique reference runs on the CPU; leave out --backend gpu".into(),
        ));
    }
    let of: &[Of] = match technique {
        Technique::VisibilityFilter => &[Of::VisibilityFilter],
        Technique::VoxelCones => &[Of::VoxelCones],
        Technique::SoftGi => &[Of::SoftGi],
        Technique::LayeredRsm => &[Of::LayeredRsm],
        _ => &[],
    };
    a.knobs.check(of, &name(technique))?;
    let (width, height) = a.scene.look.size;
    match technique {
        Technique::VisibilityFilter => a.knobs.visibility_filter().check(width, height),
        Technique::VoxelCones => a.knobs.voxel_cones().check(width, height),
        Technique::SoftGi => a.knobs.soft_gi().check(width, height),
        Technique::LayeredRsm => a.knobs.layered_rsm().check(width, height),
        _ => Ok(()),
    }
    .map_err(|e| Failure::Request(e.to_string()))?;
    check_dumps(a, technique)
}

/// Refuses buffers that the technique does not have.
fn check_dumps(a: &RenderArguments, technique: Technique) -> Result<(), Failure> {
    if technique == Technique::VoxelCones {
        let settings = a.knobs.voxel_cones();
        for dump in &a.dump {
            let Some((_, level)) = voxel_cones::voxel_view(dump) else { continue };
            let depth = settings.depth();
            if level > depth {
                return Err(Failure::Request(format!("--dump {dump}: levels are 0 to {depth} here")));
            }
            if settings.occlusion && !dump.starts_with("occlusion") {
                return Err(Failure::Request(format!(
                    "--dump {dump}: with --occlusion voxels have no light"
                )));
            }
        }
        if settings.occlusion && a.only != Only::All {
            return Err(Failure::Request("--only: occlusion is not light; leave it out".into()));
        }
    }
    let known: &[&str] = match technique {
        Technique::Reference => &["direct", "indirect"],
        Technique::AmbientOcclusion => &ambient_occlusion::DUMPS,
        Technique::VisibilityFilter => &visibility_filter::DUMPS,
        Technique::VoxelCones => &voxel_cones::DUMPS,
        Technique::SoftGi => &soft_gi::DUMPS,
        Technique::LayeredRsm => &layered_rsm::DUMPS,
        _ => &direct::DUMPS,
    };
    for name in &a.dump {
        let of_voxels = technique == Technique::VoxelCones && voxel_cones::voxel_view(name).is_some();
        if !known.contains(&name.as_str()) && !of_voxels {
            return Err(Failure::Request(format!("--dump {name}: this technique has {}", known.join(", "))));
        }
    }
    Ok(())
}
