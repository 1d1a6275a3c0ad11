//! How is the project built and checked? Every step of CI is one of these commands.

mod choices;
mod composites;
mod manifest;
mod report;
mod shaders;
mod spirv;
mod spread;
mod steps;

use clap::{Parser, Subcommand};
use std::path::PathBuf;
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "cargo xtask", about = "Build and check Twinlight")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Build the SPIR-V modules, or check that a rebuild gives the committed bytes
    Shaders {
        #[command(subcommand)]
        action: shaders::Action,
    },
    /// Get the software Vulkan driver where possible, then run every test
    Test {
        /// Arguments for the test runner
        #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
        rest: Vec<String>,
    },
    /// Check the formatting
    Fmt,
    /// Run clippy with warnings denied
    Clippy,
    /// Build the documentation with warnings denied
    Doc,
    /// Measure what accuracy costs in time, and write docs/tradeoff and the README's table from it
    Report {
        /// On the GPU instead of the CPU
        #[arg(long)]
        gpu: bool,
        /// Leave out the kernels
        #[arg(long)]
        no_kernels: bool,
        /// Go on where an earlier run stopped
        #[arg(long)]
        resume: bool,
        /// Begin no measurement of a scene after this time, such as 8m
        #[arg(long)]
        limit: Option<String>,
        /// Measure nothing: write the table from the data that is there
        #[arg(long)]
        table: bool,
    },
    /// Compare two runs of the report: folders such as docs/tradeoff/cpu
    Spread { one: PathBuf, other: PathBuf },
    /// Choose settings by time and by error from cameras that no curve was measured from, and write what came of it
    Choices,
    /// Run the fuzz targets from their corpora; needs a nightly toolchain and cargo-fuzz
    Fuzz {
        /// Compile them only, with any toolchain
        #[arg(long)]
        check: bool,
        /// Seconds of each target
        #[arg(long, default_value_t = 60)]
        seconds: u32,
    },
    /// Everything that CI runs: test, shaders check, fmt, clippy, fuzz targets, doc
    Ci,
}

fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Shaders { action } => shaders::run(action),
        Command::Test { rest } => steps::test(&rest),
        Command::Fmt => steps::fmt(),
        Command::Clippy => steps::clippy(),
        Command::Doc => steps::doc(),
        Command::Report { table: true, .. } => report::write_tables(),
        Command::Report { gpu, no_kernels, resume, limit, .. } => {
            report::report(gpu, !no_kernels, resume, limit.as_deref())
        }
        Command::Spread { one, other } => spread::run(&one, &other),
        Command::Choices => choices::run(),
        Command::Fuzz { check: true, .. } => steps::check_fuzz_targets(),
        Command::Fuzz { seconds, .. } => steps::fuzz(seconds),
        Command::Ci => steps::ci(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::FAILURE
        }
    }
}
