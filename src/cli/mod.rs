//! What does the `twinlight` command do? One file per subcommand.

mod compare;
mod devices;
mod knobs;
mod options;
mod render;
mod table;
mod tradeoff;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

#[derive(Parser)]
#[command(name = "twinlight", version, about = "Indirect illumination for glTF scenes, on CPU or GPU")]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Render one picture
    Render(Box<render::RenderArguments>),
    /// Print what would run for a picture, and why: effects, passes, buffers, and what runs again after a change
    Explain(Box<render::RenderArguments>),
    /// Run both backends and compare them pass by pass
    Compare(Box<compare::CompareArguments>),
    /// Measure what accuracy costs in time: settings of all techniques, against the path tracer
    Tradeoff(Box<tradeoff::TradeoffArguments>),
    /// List the GPU adapters, their limits, and whether they can run strict arithmetic
    Devices(devices::DevicesArguments),
}

/// Why the command ends without success.
pub(crate) enum Failure {
    /// The request was wrong: exit code 2.
    Request(String),
    /// The work failed: exit code 1.
    Work(String),
}

impl From<crate::error::SceneError> for Failure {
    fn from(e: crate::error::SceneError) -> Self {
        Self::Request(e.to_string())
    }
}

impl From<crate::backend::BackendError> for Failure {
    fn from(e: crate::backend::BackendError) -> Self {
        match e {
            crate::backend::BackendError::Settings(_) | crate::backend::BackendError::Scene(_) => {
                Self::Request(e.to_string())
            }
            _ => Self::Work(e.to_string()),
        }
    }
}

impl From<crate::backend::GpuError> for Failure {
    fn from(e: crate::backend::GpuError) -> Self {
        Self::Work(e.to_string())
    }
}

impl From<crate::backend::CpuError> for Failure {
    fn from(e: crate::backend::CpuError) -> Self {
        Self::Work(e.to_string())
    }
}

impl From<crate::picture::OutputError> for Failure {
    fn from(e: crate::picture::OutputError) -> Self {
        match e {
            crate::picture::OutputError::Extension { .. } => Self::Request(e.to_string()),
            _ => Self::Work(e.to_string()),
        }
    }
}

/// Runs the command: exit code 0 when done, 1 when the work failed, 2 when the request was wrong.
pub fn main() -> ExitCode {
    let result = match Arguments::parse().command {
        Command::Render(a) => render::run(&a),
        Command::Explain(a) => render::explain(&a),
        Command::Compare(a) => compare::run(&a),
        Command::Tradeoff(a) => tradeoff::run(&a),
        Command::Devices(a) => devices::run(&a),
    };
    let (code, message) = match result {
        Ok(()) => return ExitCode::SUCCESS,
        Err(Failure::Work(message)) => (1, message),
        Err(Failure::Request(message)) => (2, message),
    };
    eprintln!("error: {}", message.split_whitespace().collect::<Vec<_>>().join(" "));
    ExitCode::from(code)
}

/// Whether a line of `render` is understood, of a built-in scene in place of its own; no file is read, nothing is rendered.
///
/// # Errors
/// What the command would say, in one line.
#[doc(hidden)]
pub fn understands(words: &[String]) -> Result<(), String> {
    let understood = render::parse_line(words).and_then(|mut a| {
        a.scene.scene = "cornell-box".into();
        (a.scene.look.environment, a.scene.look.fit_spheres) = (None, None);
        let (_, view) = a.scene.open()?;
        render::request_of(&a, &view)
    });
    match understood {
        Ok(_) => Ok(()),
        Err(Failure::Request(reason) | Failure::Work(reason)) => {
            Err(reason.split_whitespace().collect::<Vec<_>>().join(" "))
        }
    }
}

/// Prints to standard output; a reader that went away ends the command quietly, as for other tools.
pub(crate) fn print_out(text: &str) -> Result<(), Failure> {
    use std::io::Write;
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Ok(()) => Ok(()),
        Err(e) if e.kind() == std::io::ErrorKind::BrokenPipe => Ok(()),
        Err(e) => Err(Failure::Work(format!("cannot write to standard output: {e}"))),
    }
}
