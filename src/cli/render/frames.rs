//! `twinlight render --frames`: one picture for each moment of an animation.

use super::{RenderArguments, Session, one};
use crate::cli::{Failure, print_out};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::time::Instant;

/// Renders frames `first` to `last` into the folder that `--output` names.
pub(super) fn run(a: &RenderArguments, (first, last): (u32, u32)) -> Result<(), Failure> {
    if !(a.fps > 0.0 && a.fps <= 1.0e6) {
        return Err(Failure::Request(format!("--fps {}: give a number from above 0 to 1e6", a.fps)));
    }
    if a.against.is_some() {
        return Err(Failure::Request("--against: for one picture; leave out --frames".into()));
    }
    if a.json {
        return Err(Failure::Request("--json: for one picture; leave out --frames".into()));
    }
    let folder = a.output.clone().unwrap_or_else(|| {
        let stem = PathBuf::from(&a.scene.scene);
        PathBuf::from(stem.file_stem().unwrap_or_default())
    });
    if folder.is_file() {
        return Err(Failure::Request(format!(
            "--output {}: with --frames this is a folder, and it is a file",
            folder.display()
        )));
    }
    std::fs::create_dir_all(&folder).map_err(|e| {
        Failure::Work(format!("cannot make the folder {}: {e}; give another with -o", folder.display()))
    })?;
    let quiet = RenderArguments { quiet: true, ..a.clone() };
    let mut session = Session::default();
    let begun = Instant::now();
    for frame in first..=last {
        if !a.quiet && std::io::stderr().is_terminal() {
            eprint!("\rframe {frame} of {first} to {last} ");
        }
        let path = folder.join(format!("{frame:04}.png"));
        // The first frame tells its notes and passes; the others are like it.
        let own = if frame == first { a } else { &quiet };
        one(own, f64::from(frame) / a.fps, Some(&path), &mut session)?;
    }
    if !a.quiet {
        let count = last - first + 1;
        let seconds = begun.elapsed().as_secs_f64();
        print_out(&format!("wrote {count} frames to {} in {seconds:.1} s\n", folder.display()))?;
    }
    Ok(())
}
