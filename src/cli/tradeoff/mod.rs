//! `twinlight tradeoff`: what does accuracy cost in time?

mod attribution;
mod kernels;
mod measure;
mod page;
mod pictures;
mod plot;
mod record;
mod run;
mod sweep;

pub(crate) use measure::Subject;
pub(crate) use sweep::{Trial, steps_of};

use super::Failure;
use super::options::{BackendOptions, LookOptions};
use super::render::Machine;
use clap::{Args, ValueEnum};
use std::path::{Path, PathBuf};
use std::time::Duration;

#[derive(Args)]
pub(crate) struct TradeoffArguments {
    /// Scenes as for render; options of one alone may follow it in its argument: "sponza.glb --fov 60"
    #[arg(required_unless_present = "kernels", conflicts_with = "kernels", value_name = "SCENE")]
    scenes: Vec<String>,
    /// Measure the kernels instead: their errors against 64-bit floats, and nanoseconds of a call
    #[arg(long)]
    kernels: bool,
    #[command(flatten)]
    look: LookOptions,
    #[command(flatten)]
    backend: BackendOptions,
    /// Where the passes run; the path tracer always runs on the CPU
    #[arg(long = "backend", default_value = "cpu", value_name = "BACKEND")]
    machine: Machine,
    /// Techniques to try, and reference for the path tracer [default: all that have something to do]
    #[arg(long, value_delimiter = ',', value_name = "a,b,c")]
    techniques: Option<Vec<String>>,
    /// Leave out single knobs: try the defaults and each technique's steps from quick to good
    #[arg(long)]
    steps_only: bool,
    /// Do not take techniques apart stage by stage
    #[arg(long)]
    no_attribution: bool,
    /// Paths per pixel of the reference
    #[arg(long, default_value_t = 256, value_parser = clap::value_parser!(u32).range(2..=1_000_000))]
    samples: u32,
    /// Frames by whose median a setting's time is told, after one that does not count
    #[arg(long, default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    repeats: u32,
    /// Pixels along a side that are averaged before pictures are compared
    #[arg(long, default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=64))]
    block: u32,
    /// Begin no trial after this time, such as 90s or 20m
    #[arg(long, value_name = "TIME", value_parser = parse_limit)]
    time_limit: Option<Duration>,
    /// Of which points pictures are kept
    #[arg(long, default_value = "all")]
    pictures: Pictures,
    /// Line that names whose scene it is, beside its pictures
    #[arg(long, default_value = "", value_name = "TEXT")]
    credit: String,
    /// Forget what an earlier run in the folder measured
    #[arg(long)]
    restart: bool,
    /// Folder of the report
    #[arg(short, long, required_unless_present = "kernels", value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print nothing but errors
    #[arg(long)]
    quiet: bool,
    /// Print the data as one JSON object
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, ValueEnum, PartialEq, Eq, Debug)]
enum Pictures {
    /// All
    All,
    /// Defaults and those that no other point beats
    Front,
    /// None
    None,
}

fn parse_limit(text: &str) -> Result<Duration, String> {
    let scaled = |unit: &str, scale: f64| {
        text.strip_suffix(unit).and_then(|n| n.parse::<f64>().ok()).map(|n| n * scale)
    };
    match scaled("m", 60.0).or_else(|| scaled("s", 1.0)) {
        Some(seconds) if seconds > 0.0 && seconds < 1.0e7 => Ok(Duration::from_secs_f64(seconds)),
        _ => Err("expected a time such as 90s or 20m".into()),
    }
}

/// Where the parts of a report lie.
struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Makes the folder.
    fn make(path: &Path) -> Result<Self, Failure> {
        let made = std::fs::create_dir_all(path.join("parts"));
        made.map_err(|e| Failure::Request(format!("--output {}: {e}; give another folder", path.display())))?;
        Ok(Self { path: path.to_owned() })
    }

    /// Removes what an earlier run left for one that goes on.
    fn forget_parts(&self) {
        for entry in std::fs::read_dir(self.path.join("parts")).into_iter().flatten().flatten() {
            let _ = std::fs::remove_file(entry.path());
        }
    }

    fn record(&self) -> PathBuf {
        self.path.join("tradeoff.json")
    }

    /// What only a run that goes on needs, and the pictures of the page.
    fn part(&self, scene: &str, name: &str) -> PathBuf {
        self.path.join("parts").join(format!("{scene}.{name}"))
    }

    fn picture(&self, scene: &str, name: &str) -> PathBuf {
        self.part(scene, &format!("{name}.jpg"))
    }
}

pub(crate) fn run(a: &TradeoffArguments) -> Result<(), Failure> {
    match &a.output {
        _ if a.kernels => kernels::run(&a.backend, a.output.as_deref(), a.json, a.quiet),
        Some(output) => run::run(a, output),
        None => Err(Failure::Request("--output: give a folder for the report".into())),
    }
}
