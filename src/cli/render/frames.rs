//! `twinlight render --frames`: one picture for each moment of an animation.

use super::{Moment, RenderArguments, Session, one};
use crate::cli::{Failure, print_out};
use crate::plan::stages;
use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// Where the frames go.
struct Files {
    folder: PathBuf,
    before: String,
    digits: usize,
    after: String,
}

impl Files {
    /// A pattern such as `out/%04d.png`, or a folder.
    fn of(a: &RenderArguments) -> Result<Self, Failure> {
        let output = a.output.clone().unwrap_or_else(|| {
            let stem = PathBuf::from(&a.scene.scene);
            PathBuf::from(stem.file_stem().unwrap_or_default())
        });
        let name = output.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if let Some((before, rest)) = name.split_once('%') {
            let pattern = rest.split_once('d').and_then(|(digits, after)| {
                let digits = if digits.is_empty() { 1 } else { digits.parse().ok().filter(|&d| d <= 9)? };
                Some((digits, after.to_owned()))
            });
            let Some((digits, after)) = pattern.filter(|(_, after)| !after.contains('%')) else {
                return Err(Failure::Request(format!(
                    "--output {}: a pattern has one %d or %04d and an extension",
                    output.display()
                )));
            };
            let folder = output.parent().map(Path::to_owned).unwrap_or_default();
            return Ok(Self { folder, before: before.to_owned(), digits, after });
        }
        if output.is_file() || output.extension().is_some() && !output.is_dir() {
            return Err(Failure::Request(format!(
                "--output {}: with --frames this is a folder, or a pattern such as out/%04d.png",
                output.display()
            )));
        }
        Ok(Self { folder: output, before: String::new(), digits: 4, after: ".png".into() })
    }

    fn path(&self, frame: u32) -> PathBuf {
        self.folder.join(format!("{}{frame:0width$}{}", self.before, self.after, width = self.digits))
    }
}

/// Renders frames `first` to `last`, or those of a part of them.
pub(super) fn run(a: &RenderArguments, (first, last): (u32, u32)) -> Result<(), Failure> {
    if !(a.fps > 0.0 && a.fps <= 1.0e6) {
        return Err(Failure::Request(format!("--fps {}: give a number from above 0 to 1e6", a.fps)));
    }
    if !a.orbit.unwrap_or(0.0).is_finite() {
        return Err(Failure::Request("--orbit: give degrees".into()));
    }
    if a.against.is_some() {
        return Err(Failure::Request("--against: for one picture; leave out --frames".into()));
    }
    if a.budget.is_some() || a.error.is_some() {
        return Err(Failure::Request(
            "--budget and --error: trials differ from run to run, and frames would too; find knobs and effects with one picture, and give them and --effects"
                .into(),
        ));
    }
    if a.json {
        return Err(Failure::Request("--json: for one picture; leave out --frames".into()));
    }
    let files = Files::of(a)?;
    crate::picture::Format::of(&files.path(first)).map_err(Failure::from)?;
    if !files.folder.as_os_str().is_empty() {
        std::fs::create_dir_all(&files.folder).map_err(|e| {
            let folder = files.folder.display();
            Failure::Work(format!("cannot make the folder {folder}: {e}; give another with -o"))
        })?;
    }
    let moment = |frame: u32| Moment {
        seconds: f64::from(frame) / a.fps,
        degrees: f64::from(frame - first) * a.orbit.unwrap_or(0.0),
    };
    let mut session = Session::default();
    // What the first frame chooses all frames keep, whichever part of them is rendered.
    let (scene, _) = a.scene.open_at(moment(first).seconds, 0.0, &mut session.kept)?;
    if last > first {
        let (next, _) = a.scene.open_at(moment(first + 1).seconds, 0.0, &mut session.kept)?;
        session.moving = super::explained::Motion::between(&scene, &next).any();
    }
    let (part, parts) = a.shard.unwrap_or((1, 1));
    let mine: Vec<u32> = (first..=last).filter(|frame| (frame - first) % parts == part - 1).collect();
    let todo: Vec<u32> = mine.iter().copied().filter(|&f| !(a.resume && files.path(f).is_file())).collect();
    let begun = Instant::now();
    let table = render_all(a, &files, &todo, moment, &mut session)?;
    if !a.quiet {
        let seconds = begun.elapsed().as_secs_f64();
        let there = mine.len() - todo.len();
        let there = if there > 0 { format!(", {there} were there") } else { String::new() };
        let to =
            if files.folder.as_os_str().is_empty() { ".".into() } else { files.folder.display().to_string() };
        print_out(&format!("{table}wrote {} frames to {to} in {seconds:.1} s{there}\n", todo.len()))?;
    }
    Ok(())
}

/// Renders frames one after the other; returns the table of what ran again.
fn render_all(
    a: &RenderArguments,
    files: &Files,
    todo: &[u32],
    moment: impl Fn(u32) -> Moment,
    session: &mut Session,
) -> Result<String, Failure> {
    let mut table = format!("{:>6} {:>8} {:>6} {:<24} ran\n", "frame", "ms", "passes", "changed");
    let quiet = RenderArguments { quiet: true, ..a.clone() };
    for (number, &frame) in todo.iter().enumerate() {
        if !a.quiet && std::io::stderr().is_terminal() {
            eprint!("\rframe {frame}, {} of {} ", number + 1, todo.len());
        }
        // The first frame tells its notes and passes; the table tells of the others.
        let own = if number == 0 { a } else { &quiet };
        let begun = Instant::now();
        let (ran, changes) = one(own, moment(frame), Some(&files.path(frame)), session)?;
        let ms = begun.elapsed().as_secs_f64() * 1e3;
        let mut changed: Vec<&str> = changes.iter().map(|c| c.name()).collect();
        if number > 0 && a.orbit.is_some_and(|d| d != 0.0) {
            changed.insert(0, "camera");
        }
        let changed = if number == 0 { "everything".into() } else { changed.join(", ") };
        let ran_stages: Vec<&str> =
            stages(&ran).into_iter().map(|s| if s.is_empty() { "picture" } else { s }).collect();
        table += &format!("{frame:>6} {ms:>8.1} {:>6} {changed:<24} {}\n", ran.len(), ran_stages.join(", "));
    }
    Ok(table)
}
