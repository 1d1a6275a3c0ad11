//! `twinlight tradeoff`: what does accuracy cost?

mod kernels;

use super::Failure;
use super::options::BackendOptions;
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
pub(crate) struct TradeoffArguments {
    /// Measure the kernels: their errors against float64, and nanoseconds per call
    #[arg(long, required = true)]
    kernels: bool,
    #[command(flatten)]
    backend: BackendOptions,
    /// Folder to write kernels.json, kernels.csv and kernels.md into
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    json: bool,
    /// No progress
    #[arg(long)]
    quiet: bool,
}

pub(crate) fn run(a: &TradeoffArguments) -> Result<(), Failure> {
    kernels::run(&a.backend, a.output.as_deref(), a.json, a.quiet)
}
