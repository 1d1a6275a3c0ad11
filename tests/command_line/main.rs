//! Does the command do what its contract says: files, output, exit codes, messages?

#[allow(dead_code)]
#[path = "../scene/file.rs"]
mod file;
#[path = "../support/mod.rs"]
mod support;

mod devices;
mod faults;
mod pictures;
mod plans;
mod refusals;
mod signals;
mod tradeoff;

use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Command, Stdio};

/// What a finished command left.
struct Ran {
    /// Exit code; `None` where a signal ended it.
    code: Option<i32>,
    /// Standard output.
    out: String,
    /// Standard error.
    err: String,
}

impl Ran {
    /// The standard output as exactly one JSON object.
    fn json(&self) -> serde_json::Value {
        let value: serde_json::Value = serde_json::from_str(&self.out)
            .unwrap_or_else(|e| panic!("{e} in {:?}; standard error: {}", self.out, self.err));
        assert!(value.is_object(), "{value}");
        value
    }

    /// Lines of standard error that begin with `error:`.
    fn errors(&self) -> Vec<&str> {
        self.err.lines().filter(|l| l.starts_with("error:")).collect()
    }
}

/// The command, to be run in a folder, its input closed.
fn command(folder: &Path, arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_twinlight"));
    command.current_dir(folder).args(arguments).stdin(Stdio::null());
    // Without it the system's Wayland library, loaded by Vulkan drivers, prints an "error:" of its own.
    command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    command
}

fn finish(mut command: Command) -> Ran {
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    let ran = Ran { code: output.status.code(), out: text(output.stdout), err: text(output.stderr) };
    assert!(!ran.err.contains("panicked"), "{}", ran.err);
    ran
}

/// Runs the command in a folder to its end.
fn run(folder: &Path, arguments: &[&str]) -> Ran {
    finish(command(folder, arguments))
}

/// Runs the command and expects success.
fn succeed(folder: &Path, arguments: &[&str]) -> Ran {
    let ran = run(folder, arguments);
    assert_eq!(ran.code, Some(0), "{arguments:?}: {}", ran.err);
    ran
}

/// The names in a folder with their contents, folders as empty.
fn listing(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| {
            let entry = entry.unwrap();
            let bytes = std::fs::read(entry.path()).unwrap_or_default();
            (entry.file_name().into_string().unwrap(), bytes)
        })
        .collect()
}

/// Takes every GPU driver away from a command.
fn without_drivers(mut command: Command) -> Command {
    command.env("VK_ICD_FILENAMES", "/nonexistent").env("VK_DRIVER_FILES", "/nonexistent");
    command
}
