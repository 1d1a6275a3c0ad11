//! What can be asked of `twinlight render`?

use crate::cli::Failure;
use crate::cli::knobs::Knobs;
use crate::cli::options::{BackendOptions, SceneOptions};
use crate::technique::Upsampling;
use crate::technique::reference::Bounces;
use clap::{Args, Parser, ValueEnum};
use std::path::PathBuf;
use std::time::Duration;

#[derive(Args, Clone)]
pub(crate) struct RenderArguments {
    #[command(flatten)]
    pub(crate) scene: SceneOptions,
    #[command(flatten)]
    pub(super) backend: BackendOptions,
    /// How light is computed
    #[arg(long, default_value = "auto")]
    pub(super) technique: Technique,
    /// Where the passes run
    #[arg(long = "backend", default_value = "cpu", value_name = "BACKEND")]
    pub(super) machine: Machine,
    /// The picture's file, .png or .exr [default: the scene's name with .png]
    #[arg(short, long, value_name = "OUT.png|OUT.exr")]
    pub(super) output: Option<PathBuf>,
    /// Frames of an animation, both included; written as OUT/0000.png and so on, or by a pattern such as OUT/%04d.exr [default: the moment 0]
    #[arg(long, value_name = "A..B", value_parser = parse_frames)]
    pub(super) frames: Option<(u32, u32)>,
    /// Frames per second of --frames
    #[arg(long, default_value_t = 25.0, value_name = "N")]
    pub(super) fps: f64,
    /// Turn the camera around its target, degrees a frame
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub(super) orbit: Option<f64>,
    /// Leave out frames whose file is there
    #[arg(long)]
    pub(super) resume: bool,
    /// Render every N-th frame only, from the I-th on: part I of N
    #[arg(long, value_name = "I/N", value_parser = parse_shard)]
    pub(super) shard: Option<(u32, u32)>,
    /// Effects to compute where the scene has use for them [default: all; see twinlight explain]
    #[arg(long, value_delimiter = ',', value_name = "a,b,c")]
    pub(super) effects: Option<Vec<String>>,
    /// Leave out effects that can add no more than this share of the light
    #[arg(long, default_value_t = 0.0, value_name = "SHARE", allow_hyphen_values = true)]
    pub(super) quality: f64,
    /// Choose settings by which the passes are expected to take no longer, such as 40ms or 1.5s; with knobs given, leave out effects
    #[arg(long, value_name = "TIME", value_parser = parse_budget)]
    pub(super) budget: Option<Duration>,
    /// Choose the quickest settings by which the picture is expected to be no further off, such as 5%
    #[arg(long, value_name = "PERCENT", value_parser = parse_error)]
    pub(super) error: Option<f64>,
    /// Measure the curves again by which --budget and --error choose
    #[arg(long)]
    pub(super) recalibrate: bool,
    /// Reflections beyond direct light, or all (reference)
    #[arg(long, default_value = "1", value_parser = parse_bounces, value_name = "N|all")]
    pub(super) bounces: Bounces,
    /// Paths per pixel (reference), or rays per pixel for the sky, emissive surfaces and occlusion
    #[arg(long, default_value_t = 64, value_parser = clap::value_parser!(u32).range(1..=16_777_216))]
    pub(super) samples: u32,
    /// Seed of random numbers
    #[arg(long, default_value_t = 1)]
    pub(super) seed: u32,
    /// Let the reference see each pixel's centre only, as the techniques do
    #[arg(long)]
    pub(super) pixel_centre: bool,
    /// Which light goes into the picture
    #[arg(long, default_value = "all")]
    pub(super) only: Only,
    /// λ of the occlusion falloff 1/(1 + λ r), 1/m
    #[arg(long, default_value_t = 0.0, value_name = "λ", allow_hyphen_values = true)]
    pub(super) falloff: f32,
    /// Distance beyond which nothing occludes, metres
    #[arg(long, default_value_t = 1.0e30, value_name = "METRES", allow_hyphen_values = true)]
    pub(super) reach: f32,
    /// How light that is gathered at fewer pixels becomes that of all
    #[arg(long, default_value = "bilateral")]
    pub(super) upsampling: UpsamplingChoice,
    /// Buffers to save as pictures beside the output
    #[arg(long, value_delimiter = ',', value_name = "a,b,c")]
    pub(super) dump: Vec<String>,
    /// Exposure of .png in stops
    #[arg(long, default_value_t = 0.0, value_name = "E", allow_hyphen_values = true)]
    pub(super) exposure: f32,
    /// Picture to measure the error against, such as the reference's; .exr of the same size
    #[arg(long, value_name = "REFERENCE.exr")]
    pub(super) against: Option<PathBuf>,
    /// Count non-finite values in every buffer; any is a failure
    #[arg(long)]
    pub(super) check_finite: bool,
    /// Print nothing but errors
    #[arg(long)]
    pub(super) quiet: bool,
    /// Print the tables as one JSON object
    #[arg(long)]
    pub(super) json: bool,
    #[command(flatten)]
    pub(super) knobs: Knobs,
}

#[derive(Clone, Copy, ValueEnum, PartialEq, Eq, Debug)]
pub(crate) enum Technique {
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
pub(crate) enum Only {
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

fn parse_error(text: &str) -> Result<f64, String> {
    match text.strip_suffix('%').and_then(|n| n.trim().parse::<f64>().ok()) {
        Some(x) if x > 0.0 && x <= 1000.0 => Ok(0.01 * x),
        _ => Err("expected a relative error such as 5%".into()),
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

/// `--upsampling`.
#[derive(Clone, Copy, ValueEnum, PartialEq, Eq, Debug)]
pub(crate) enum UpsamplingChoice {
    /// By place, depth and normal
    Bilateral,
    /// By place: light bleeds over edges
    Bilinear,
    /// From the nearest
    Nearest,
}

impl UpsamplingChoice {
    pub(super) fn kind(self) -> Upsampling {
        match self {
            Self::Bilateral => Upsampling::Bilateral,
            Self::Bilinear => Upsampling::Bilinear,
            Self::Nearest => Upsampling::Nearest,
        }
    }
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
        let short = |text: &str| text.chars().take(200).collect::<String>();
        Failure::Request(format!("{}: {}", short(&words.join(" ")), short(first)))
    })?;
    Ok(line.arguments)
}
