//! Where does the picture go, what is it measured against, and what is printed?

use super::{Outcome, RenderArguments};
use crate::cli::{Failure, print_out};
use crate::picture::{Format, Picture};
use crate::report::error::picture_error;
use crate::technique::View;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Makes sure that the picture can be written, before the work begins.
pub(super) fn check_output(output: &Path) -> Result<(), Failure> {
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

/// Reads the picture that the error is measured against.
pub(super) fn open_reference(path: &Path, view: &View) -> Result<Picture, Failure> {
    let refuse = |reason: String| Failure::Request(format!("--against {}: {reason}", path.display()));
    let picture =
        Picture::open_exr(path).map_err(|e| refuse(format!("{e}; give an .exr of linear radiance")))?;
    if (picture.width, picture.height) != (view.width, view.height) {
        return Err(refuse(format!(
            "it has {}x{} pixels, the picture {}x{}; render both at one size",
            picture.width, picture.height, view.width, view.height
        )));
    }
    Ok(picture)
}

pub(super) fn note_error(outcome: &mut Outcome, reference: &Picture) {
    let Some(error) = picture_error(&outcome.picture, reference) else { return };
    outcome.report +=
        &format!("relative RMSE {:.2} %, mean ratio {:.4}\n", 100.0 * error.relative_rmse, error.mean_ratio);
    outcome.json["relative_rmse"] = json!(error.relative_rmse);
    outcome.json["mean_ratio"] = json!(error.mean_ratio);
}

/// The file of a buffer's picture, beside the output: `a.png` has `a.normal.png`.
pub(super) fn dump_path(output: &Path, name: &str) -> PathBuf {
    let stem = output.file_stem().unwrap_or_default().to_string_lossy();
    let extension = output.extension().unwrap_or_default().to_string_lossy();
    output.with_file_name(format!("{stem}.{name}.{extension}"))
}

/// Writes the picture and its dumps; returns the files' names.
pub(super) fn write(a: &RenderArguments, output: &Path, outcome: &Outcome) -> Result<Vec<String>, Failure> {
    let mut names = vec![output.display().to_string()];
    outcome.picture.save(output, a.exposure)?;
    for (name, picture) in &outcome.dumps {
        let path = dump_path(output, name);
        picture.save(&path, 0.0)?;
        names.push(path.display().to_string());
    }
    Ok(names)
}

pub(super) fn report(a: &RenderArguments, outcome: &Outcome, written: &[String]) -> Result<(), Failure> {
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
