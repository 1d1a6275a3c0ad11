//! In which order is what tried, and what becomes of it?

use super::measure::{Measured, Right, Subject, interrupted};
use super::pictures::exposure;
use super::record::{Point, Record, Reference, SceneRecord};
use super::sweep::{self, Needs, SWEEPS, Trial};
use super::{Folder, Pictures, TradeoffArguments, attribution, page, plot};
use crate::cli::devices::probe_json;
use crate::cli::{Failure, print_out};
use crate::picture::{Picture, write_whole};
use crate::report::machine::processor;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// What a run has at hand.
pub(super) struct Session<'a> {
    pub(super) a: &'a TradeoffArguments,
    pub(super) folder: Folder,
    pub(super) stop: Arc<AtomicBool>,
    bar: ProgressBar,
    begun: Instant,
}

pub(super) fn run(a: &TradeoffArguments, output: &Path) -> Result<(), Failure> {
    let gpu = a.machine.is_gpu();
    let mut subjects = Vec::new();
    for text in &a.scenes {
        subjects.push(Subject::open(scene_words(a, text), &a.backend, gpu)?);
    }
    check_techniques(a)?;
    let fresh = fresh_record(a, &subjects, gpu)?;
    let folder = Folder::make(output)?;
    if a.restart {
        folder.forget_parts();
    }
    let old = if a.restart { None } else { Record::open(&folder.record())? };
    let mut record = match old {
        Some(old) if old.same_request(&fresh) => Record { runs: old.runs + 1, ..old },
        Some(_) => {
            return Err(Failure::Request(format!(
                "{} has the report of another request, or the scene has changed; give --restart or another folder",
                output.display()
            )));
        }
        None => fresh,
    };
    let stop = Arc::new(AtomicBool::new(false));
    let seen = stop.clone();
    // Without a handler an interruption ends the command; what is measured is in the folder all the same.
    let _ = ctrlc::set_handler(move || seen.store(true, Ordering::Relaxed));
    let bar = if a.quiet { ProgressBar::hidden() } else { ProgressBar::new(0) };
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}, {eta} left") {
        bar.set_style(style);
    }
    let session = Session { a, folder, stop, bar, begun: Instant::now() };
    let mut result = Ok(());
    for (i, subject) in subjects.iter_mut().enumerate() {
        subject.stop = session.stop.clone();
        result = session.scene(subject, &mut record, i);
        if result.is_err() {
            break;
        }
    }
    session.bar.finish_and_clear();
    session.finish(&record)?;
    result
}

/// The words of a scene's command line: what it has of its own comes last, and wins.
fn scene_words(a: &TradeoffArguments, text: &str) -> Vec<String> {
    let (name, own) = text.find(" --").map_or((text, ""), |at| text.split_at(at));
    let (width, height) = a.look.size;
    let mut words = vec![name.trim().to_owned()];
    if (width, height) != (512, 512) {
        words.push(format!("--size={width}x{height}"));
    }
    words.extend(a.look.words());
    words.extend(own.split_whitespace().map(str::to_owned));
    words
}

fn check_techniques(a: &TradeoffArguments) -> Result<(), Failure> {
    for name in a.techniques.iter().flatten() {
        if name != "reference" && !SWEEPS.iter().any(|s| s.technique == name) {
            let known: Vec<_> = SWEEPS.iter().map(|s| s.technique).collect();
            return Err(Failure::Request(format!(
                "--techniques {name}: there are {} and reference",
                known.join(", ")
            )));
        }
    }
    Ok(())
}

fn fresh_record(a: &TradeoffArguments, subjects: &[Subject], gpu: bool) -> Result<Record, Failure> {
    let cpu = processor();
    let (machine, probe) = if gpu {
        let mut gpu = a.backend.gpu(crate::cli::options::ArithmeticChoice::Fast)?;
        let probe = gpu.run_probe()?;
        let machine = format!("gpu, {}; path tracer on {cpu}", twinlight_gpu::describe(gpu.adapter()));
        (machine, Some(probe_json(&probe)))
    } else {
        (format!("cpu, {cpu}, {} threads", a.backend.cpu()?.threads()), None)
    };
    let mut scenes: Vec<SceneRecord> = Vec::new();
    for s in subjects {
        let (width, height) = (s.view.width, s.view.height);
        let compared = (width / a.block, height / a.block);
        if compared.0 == 0 || compared.1 == 0 {
            return Err(Failure::Request(format!(
                "--block {}: the picture is smaller than a block",
                a.block
            )));
        }
        let mut name = s.scene.name.clone();
        while scenes.iter().any(|other| other.name == name) {
            name.push('+');
        }
        // Where only surroundings shine, most light is straight.
        let indirect = !s.scene.lights.is_empty() && technique_names(a, s).any(|t| t != "soft-gi");
        scenes.push(SceneRecord {
            name,
            view: quoted(&s.words[1..]),
            credit: a.credit.clone(),
            fingerprint: format!("{:016x}", s.scene.fingerprint()),
            size: (width, height),
            compared,
            reference: None,
            axis: if indirect { "indirect" } else { "all" }.into(),
            points: Vec::new(),
            attribution: Vec::new(),
        });
    }
    let command = command_text(a);
    Ok(Record { command, version: env!("CARGO_PKG_VERSION").into(), machine, probe, runs: 1, scenes })
}

/// Words as a shell takes them.
fn quoted(words: &[String]) -> String {
    let word = |w: &String| {
        if w.contains(|c: char| c.is_whitespace() || "\"'$&;|<>()*?`\\".contains(c)) {
            format!("'{}'", w.replace('\'', "'\\''"))
        } else {
            w.clone()
        }
    };
    words.iter().map(word).collect::<Vec<_>>().join(" ")
}

/// The command that makes the same report.
fn command_text(a: &TradeoffArguments) -> String {
    let mut words = vec!["twinlight tradeoff".to_owned()];
    words.extend(a.scenes.iter().map(|s| quoted(std::slice::from_ref(s))));
    let (width, height) = a.look.size;
    words.push(format!("--size {width}x{height}"));
    words.extend(a.look.words());
    if a.machine.is_gpu() {
        words.push("--backend gpu".into());
    }
    words.extend(a.backend.words());
    if let Some(techniques) = &a.techniques {
        words.push(format!("--techniques {}", techniques.join(",")));
    }
    if a.steps_only {
        words.push("--steps-only".into());
    }
    words.push(format!("--samples {} --repeats {} --block {}", a.samples, a.repeats, a.block));
    words.join(" ")
}

/// The techniques to try in a scene.
fn technique_names<'a>(a: &'a TradeoffArguments, s: &Subject) -> impl Iterator<Item = &'a str> + use<'a> {
    let census = s.scene.census();
    let soft = !s.scene.proxies.is_empty() && census.has_environment;
    let gathers = !s.scene.lights.is_empty() || census.has_environment || s.emissive;
    let lit = !s.scene.lights.is_empty();
    let usual = SWEEPS.iter().map(|s| s.technique).chain(["reference"]).filter(move |t| match *t {
        "soft-gi" => soft,
        "layered-rsm" => lit,
        "reference" => true,
        _ => gathers,
    });
    let named = a.techniques.iter().flatten().map(String::as_str);
    let all: Vec<&str> = if a.techniques.is_some() { named.collect() } else { usual.collect() };
    all.into_iter()
}

impl Session<'_> {
    /// All trials of a scene: defaults, steps and the path tracer; then one knob after the other, in turns of the techniques.
    fn trials(&self, s: &Subject) -> (Vec<Trial>, Vec<Trial>) {
        let size = (s.view.width, s.view.height);
        let names: Vec<&str> = technique_names(self.a, s).collect();
        let sweeps: Vec<_> = SWEEPS.iter().filter(|x| names.contains(&x.technique)).collect();
        let gloss = s.scene.census().has_gloss;
        let fitted = s.words.iter().any(|w| w.starts_with("--fit-spheres"));
        let has = |needs: Needs| match needs {
            Needs::Nothing => true,
            Needs::Gloss => gloss,
            Needs::Fitted => fitted,
            Needs::Gpu => self.a.machine.is_gpu(),
        };
        let mut first: Vec<Trial> = sweeps.iter().flat_map(|x| x.steps(size)).collect();
        if names.contains(&"reference") {
            first.extend(sweep::baseline(size));
        }
        let mut queues: Vec<_> = sweeps.iter().map(|x| x.single(size, has).into_iter()).collect();
        let mut single = Vec::new();
        let longest = queues.iter().map(ExactSizeIterator::len).max().filter(|_| !self.a.steps_only);
        for _ in 0..longest.unwrap_or(0) {
            single.extend(queues.iter_mut().filter_map(Iterator::next));
        }
        (first, single)
    }

    fn scene(&self, subject: &mut Subject, record: &mut Record, index: usize) -> Result<(), Failure> {
        let (first, single) = self.trials(subject);
        let name = record.scenes[index].name.clone();
        self.bar.set_length((first.len() + single.len()) as u64);
        self.bar.set_position(0);
        self.bar.set_message(format!("{name}: reference"));
        let right = self.reference(subject, record, index)?;
        // Another version may have marked other points.
        record.scenes[index].mark_front();
        record.save(&self.folder.record())?;
        self.all(&first, subject, record, index, &right)?;
        if !self.a.no_attribution {
            self.bar.set_message(format!("{name}: stages"));
            attribution::attribute(self, subject, record, index, &right)?;
        }
        self.all(&single, subject, record, index, &right)?;
        let left = first.iter().chain(&single).any(|t| !record.scenes[index].has(t));
        if self.late() && left && !self.a.quiet {
            eprintln!("note: the time limit is over; the same command goes on from here");
        }
        Ok(())
    }

    /// Measures what is not measured yet.
    fn all(
        &self,
        trials: &[Trial],
        subject: &mut Subject,
        record: &mut Record,
        index: usize,
        right: &Right,
    ) -> Result<(), Failure> {
        let name = record.scenes[index].name.clone();
        let coarse = right.averaged(self.a.block);
        for trial in trials {
            self.bar.inc(1);
            if record.scenes[index].has(trial) {
                continue;
            }
            if self.stop.load(Ordering::Relaxed) {
                return Err(self.interrupted());
            }
            if self.late() {
                break;
            }
            self.bar.set_message(format!("{name}: {} {}", trial.technique, trial.settings()));
            let Some(measured) = self.measure(subject, trial)? else { continue };
            let scene = &mut record.scenes[index];
            let id = scene.points.iter().map(|p| p.id + 1).max().unwrap_or(0);
            scene.points.push(self.point(subject, trial, id, &measured, (right, &coarse), record.runs));
            scene.mark_front();
            self.keep_pictures(&scene.name, id, &measured, right)?;
            record.save(&self.folder.record())?;
        }
        Ok(())
    }

    pub(super) fn interrupted(&self) -> Failure {
        Failure::Work(format!(
            "interrupted; {} holds what was measured, and the same command goes on from there",
            self.folder.path.display()
        ))
    }

    pub(super) fn late(&self) -> bool {
        self.a.time_limit.is_some_and(|limit| self.begun.elapsed() > limit)
    }

    /// Keeps what is known so far.
    pub(super) fn save(&self, record: &Record) -> Result<(), Failure> {
        record.save(&self.folder.record())
    }

    fn measure(&self, subject: &mut Subject, trial: &Trial) -> Result<Option<Measured>, Failure> {
        let result = if trial.technique == "reference" {
            subject.measure_paths(trial.value.parse().unwrap_or(1), self.a.repeats)
        } else {
            subject.measure(trial, self.a.repeats)
        };
        self.usable(trial, result)
    }

    /// Measures for the error alone.
    pub(super) fn measure_once(
        &self,
        subject: &mut Subject,
        trial: &Trial,
    ) -> Result<Option<Measured>, Failure> {
        let result = subject.measure(trial, 0);
        self.usable(trial, result)
    }

    /// A setting that this scene, size or device does not allow is no point; the others are tried all the same.
    fn usable(&self, trial: &Trial, result: Result<Measured, Failure>) -> Result<Option<Measured>, Failure> {
        if self.stop.load(Ordering::Relaxed) {
            return Err(self.interrupted());
        }
        match result {
            Ok(measured) => Ok(Some(measured)),
            Err(Failure::Request(why) | Failure::Work(why)) => {
                if !self.a.quiet {
                    eprintln!("note: left out {} {}: {why}", trial.technique, trial.settings());
                }
                Ok(None)
            }
        }
    }

    fn point(
        &self,
        subject: &Subject,
        trial: &Trial,
        id: usize,
        m: &Measured,
        (right, coarse): (&Right, &Right),
        run: u32,
    ) -> Point {
        let side = self.a.block;
        let mut words = vec!["twinlight".to_owned(), "render".to_owned()];
        words.extend(subject.line(trial));
        if self.a.machine.is_gpu() && trial.technique != "reference" {
            words.push("--backend=gpu".into());
        }
        words.extend(self.a.backend.words());
        Point {
            id,
            technique: trial.technique.into(),
            knob: trial.knob.into(),
            value: trial.value.clone(),
            settings: trial.settings(),
            command: quoted(&words),
            seconds: m.seconds,
            wall: m.wall,
            camera: m.camera,
            bytes: m.bytes,
            indirect: m.indirect.as_ref().and_then(|p| coarse.indirect.errors(&p.averaged(side))),
            all: coarse.all.errors(&m.all.averaged(side)),
            flip: right.all.flip(&m.all),
            flip_indirect: m.indirect.as_ref().and_then(|p| right.indirect.flip(p)),
            pareto: false,
            run,
        }
    }

    /// Traces the reference in two halves, or reads what an earlier run traced.
    fn reference(&self, subject: &Subject, record: &mut Record, index: usize) -> Result<Right, Failure> {
        let name = record.scenes[index].name.clone();
        let part = |half: u32, of: &str| self.folder.part(&name, &format!("reference.{half}.{of}.exr"));
        if record.scenes[index].reference.is_some() {
            let open = |half: u32, of: &str| Picture::open_exr(&part(half, of)).ok();
            let kept = (|| {
                let halves = |of: &str| crate::report::halves::Halves::new(open(1, of)?, open(2, of)?);
                Some(Right { indirect: halves("indirect")?, all: halves("all")? })
            })();
            if let Some(right) = kept {
                return Ok(right);
            }
        }
        let samples = self.a.samples / 2;
        let begun = Instant::now();
        let mut halves = Vec::new();
        for half in [1, 2] {
            let progress = |done: u32| {
                let share = 50 * (half - 1) + 50 * done / samples.max(1);
                self.bar.set_message(format!("{name}: reference {share} %"));
            };
            let traced = subject.trace(samples, half, true, &self.stop, progress)?;
            if traced.samples < samples {
                return Err(self.interrupted());
            }
            traced.indirect.save(&part(half, "indirect"), 0.0)?;
            traced.all().save(&part(half, "all"), 0.0)?;
            halves.push(traced);
        }
        let right = Right::new(&halves[0], &halves[1]).ok_or_else(interrupted)?;
        let coarse = right.averaged(self.a.block);
        record.scenes[index].reference = Some(Reference {
            samples: 2 * samples,
            bounces: "1".into(),
            seconds: begun.elapsed().as_secs_f64(),
            noise_indirect: coarse.indirect.noise(),
            noise_all: coarse.all.noise(),
        });
        if self.a.pictures != Pictures::None {
            for (of, halves) in [("indirect", &right.indirect), ("all", &right.all)] {
                let picture = halves.mean();
                self.keep(&name, &format!("reference.{of}"), picture, exposure(picture))?;
            }
        }
        Ok(right)
    }

    /// Writes what people look at, and drops pictures that were not asked for.
    fn finish(&self, record: &Record) -> Result<(), Failure> {
        let path = &self.folder.path;
        record.save(&self.folder.record())?;
        write_whole(&path.join("tradeoff.csv"), record.csv().as_bytes())?;
        for scene in &record.scenes {
            if self.a.pictures != Pictures::All {
                let front = self.a.pictures == Pictures::Front;
                for p in scene.points.iter().filter(|p| !front || !p.pareto && !p.knob.is_empty()) {
                    for kind in ["all", "indirect", "error"] {
                        let _ = std::fs::remove_file(
                            self.folder.picture(&scene.name, &format!("{}.{kind}", p.id)),
                        );
                    }
                }
            }
            for up in plot::Up::ALL {
                let drawn = plot::draw(scene, up).map_err(|e| Failure::Work(format!("cannot draw: {e}")))?;
                if let Some(svg) = drawn {
                    write_whole(&path.join(format!("{}-{}.svg", scene.name, up.name())), svg.as_bytes())?;
                }
            }
        }
        write_whole(
            &path.join("index.html"),
            page::page(record, &self.folder, self.a.pictures != Pictures::None)?.as_bytes(),
        )?;
        if self.a.json {
            let text = serde_json::to_string(record).map_err(|e| Failure::Work(e.to_string()))?;
            return print_out(&format!("{text}\n"));
        }
        if self.a.quiet { Ok(()) } else { print_out(&record.summary(path)) }
    }
}
