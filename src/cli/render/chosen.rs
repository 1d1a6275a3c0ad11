//! Which settings fit into a time, or an error? By curves measured on this machine.
//!
//! A scene's curves are measured once: each technique's steps from quick to good, from three cameras, at two sizes. Time is taken
//! to be a part that every picture has and a part for each pixel; error is that of averages over blocks, which tell
//! much the same at every size. They are kept in the user's cache, and say for other cameras and sizes which step to try first; two
//! small trials of that step from where the picture is seen tell what to expect.

use super::arguments::{Only, RenderArguments, Technique, parse_line};
use super::{Knobs, Outcome, check_request, name, passes};
use crate::cli::Failure;
use crate::cli::tradeoff::{Subject, Trial, steps_of};
use crate::picture::{Picture, write_whole};
use crate::report::halves::Halves;
use crate::report::machine::processor;
use crate::scene::Scene;
use crate::technique::View;
use crate::technique::reference::ReferenceResult;
use clap::ValueEnum;
use glam::{Quat, Vec3};
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Deserialize, Serialize};
use serde_json::json;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Pixels of the longer side for curves: of pictures for errors and of the smaller ones for the time without pixels.
const SIDES: [u32; 2] = [160, 64];
/// Blocks along the longer side, about: what is compared.
const BLOCKS: f64 = 48.0;
/// Turns of the camera, degrees.
const TURNS: [f32; 3] = [0.0, 20.0, -20.0];
/// Paths of a reference, about.
const PATHS: f64 = 1.5e6;
/// Steps whose small picture takes longer, in seconds, are no choice.
const TOO_LONG: f64 = 1.5;
/// Steps that are tried from where the picture is seen.
const TRIES: usize = 4;

/// A step with what it costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Measured {
    technique: String,
    /// Its number among the technique's steps.
    step: usize,
    /// Seconds of a frame without pixels, and for each pixel.
    fixed: f64,
    per_pixel: f64,
    /// Relative RMSE, root mean square over the cameras.
    error: f64,
}

/// The curves of a scene on a machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Curves {
    key: String,
    steps: Vec<Measured>,
}

/// The settings that were chosen.
pub(super) struct Choice {
    pub technique: Technique,
    pub knobs: Knobs,
    pub settings: String,
    pub seconds: f64,
    pub error: f64,
    /// Whether that is within what was asked for.
    pub fits: bool,
}

/// Techniques that may be chosen in a scene.
fn techniques(a: &RenderArguments, scene: &Scene) -> Result<Vec<Technique>, Failure> {
    let has = steps_of(&name(a.technique), (64, 64)).is_some();
    if a.technique != Technique::Auto {
        return if has {
            Ok(vec![a.technique])
        } else {
            Err(Failure::Request(format!(
                "--error: --technique {} has no steps to choose from",
                name(a.technique)
            )))
        };
    }
    let census = scene.census();
    if !scene.proxies.is_empty() && census.has_environment && scene.lights.is_empty() {
        return Ok(vec![Technique::SoftGi]);
    }
    let mut all = vec![Technique::VisibilityFilter, Technique::VoxelCones];
    if !scene.lights.is_empty() && !census.has_environment {
        all.push(Technique::LayeredRsm);
    }
    Ok(all)
}

/// What a step is expected to cost at a number of pixels, and how far off it is.
#[derive(Clone, Copy)]
struct Expected {
    seconds: f64,
    error: f64,
}

impl Measured {
    fn expected(&self, pixels: f64) -> Expected {
        Expected { seconds: self.fixed + self.per_pixel * pixels, error: self.error }
    }
}

/// How far an expectation is beyond what is asked for: 1 or less is within.
fn excess(a: &RenderArguments, e: Expected) -> f64 {
    let time = a.budget.map_or(0.0, |b| e.seconds / b.as_secs_f64());
    time.max(a.error.map_or(0.0, |limit| e.error / limit))
}

/// Chooses by the curves, which are measured if they are not known; `None` for a budget where nothing is lit.
pub(super) fn choose(a: &RenderArguments, scene: &Scene, view: &View) -> Result<Option<Choice>, Failure> {
    let techniques = techniques(a, scene)?;
    let mut trials = Trials::new(a, scene, view)?;
    let Some(right) = trials.reference(0.0)? else {
        if a.error.is_none() {
            return Ok(None);
        }
        return Err(Failure::Work("nothing is lit here, so no error can be told; leave out --error".into()));
    };
    let mut steps = curves(a, scene, view, &techniques)?.steps;
    // Gathering at all pixels has a limit, which small pictures keep.
    let size = (view.width, view.height);
    steps.retain(|m| trial_of(&m.technique, m.step, view).is_ok_and(|t| of_trial(a, &t, size).is_ok()));
    let pixels = f64::from(view.pixels());
    // Within a time the best comes first, within an error the quickest; behind them what comes nearest.
    let rank = |m: &Measured| {
        let e = m.expected(pixels);
        let excess = excess(a, e);
        let wish = if a.error.is_some() { e.seconds } else { e.error };
        (excess > 1.0, if excess > 1.0 { excess } else { wish })
    };
    steps.sort_by(|x, y| {
        let (x, y) = (rank(x), rank(y));
        x.0.cmp(&y.0).then(x.1.total_cmp(&y.1))
    });
    let mut best: Option<(f64, &Measured, Expected)> = None;
    for step in steps.iter().take(TRIES) {
        let Some(here) = trials.measure(&step.technique, step.step, 0.0, &right)? else { continue };
        let expected = here.expected(pixels);
        let excess = excess(a, expected);
        if best.as_ref().is_none_or(|b| excess < b.0) {
            best = Some((excess, step, expected));
        }
        if excess <= 1.0 {
            break;
        }
    }
    let Some((excess, step, expected)) = best else {
        return Err(Failure::Work(
            "no setting could be measured for this scene; give --technique and its knobs".into(),
        ));
    };
    let trial = trial_of(&step.technique, step.step, view)?;
    let RenderArguments { knobs, technique, .. } = of_trial(a, &trial, size)?;
    let Expected { seconds, error } = expected;
    Ok(Some(Choice { technique, knobs, settings: trial.settings(), seconds, error, fits: excess <= 1.0 }))
}

/// What is asked for with a step's knobs at a picture's size, if that size allows them.
fn of_trial(a: &RenderArguments, trial: &Trial, size: (u32, u32)) -> Result<RenderArguments, Failure> {
    let mut line = vec![a.scene.scene.clone()];
    line.extend(trial.words.iter().cloned());
    let knobs = parse_line(&line)?.knobs;
    let technique = Technique::from_str(trial.technique, false).map_err(Failure::Work)?;
    let mut own = RenderArguments { knobs, technique, dump: Vec::new(), ..a.clone() };
    own.scene.look.size = size;
    check_request(&own, technique)?;
    Ok(own)
}

/// Blocks of a picture, of which the reference is traced.
fn blocks(view: &View) -> View {
    let scale = BLOCKS / f64::from(view.width.max(view.height));
    let of = |x: u32| ((f64::from(x) * scale).round() as u32).clamp(1, x);
    view.resized(of(view.width), of(view.height))
}

/// The light of the blocks in two halves.
fn reference(a: &RenderArguments, subject: &mut Subject) -> Result<Option<Halves>, Failure> {
    let whole = subject.view;
    subject.view = blocks(&whole);
    let samples = (0.5 * PATHS / f64::from(subject.view.pixels())).clamp(8.0, 4096.0) as u32;
    let halves: Result<_, Failure> = (|| {
        let one = subject.trace(samples, 11, &AtomicBool::new(false), |_| ())?;
        Ok((one, subject.trace(samples, 12, &AtomicBool::new(false), |_| ())?))
    })();
    subject.view = whole;
    let (one, other) = halves?;
    let part = |r: ReferenceResult| match a.only {
        Only::All => r.all(),
        Only::Direct => r.direct,
        Only::Indirect => r.indirect,
    };
    Ok(Halves::new(part(one), part(other)))
}

/// How far a picture's blocks are from a reference of them; `None` where that cannot be told.
fn error_of(picture: &Picture, right: &Halves) -> Option<f64> {
    let (width, height) = (right.mean().width, right.mean().height);
    right.errors(&picture.shrunk(width, height)).map(|e| e.relative_rmse)
}

/// How far a picture is from a reference of the same view; `None` where that cannot be told.
pub(super) fn measured_error(
    a: &RenderArguments,
    scene: Scene,
    view: &View,
    picture: &Picture,
) -> Result<Option<f64>, Failure> {
    let emissive = a.scene.look.emissive;
    let mut subject = Subject::of(Vec::new(), scene, *view, emissive, &a.backend, false)?;
    let right = reference(a, &mut subject)?;
    Ok(right.and_then(|r| error_of(picture, &r)))
}

fn curves(
    a: &RenderArguments,
    scene: &Scene,
    view: &View,
    techniques: &[Technique],
) -> Result<Curves, Failure> {
    let key = key(a, scene, techniques)?;
    let file = file(&key);
    let known = file.as_ref().and_then(|f| std::fs::read(f).ok());
    let known: Option<Curves> = known.and_then(|bytes| serde_json::from_slice(&bytes).ok());
    if let Some(known) = known.filter(|k| k.key == key && !k.steps.is_empty() && !a.recalibrate) {
        return Ok(known);
    }
    let curves = Curves { steps: calibrate(a, scene, view, techniques)?, key };
    if let Some(file) = file.filter(|_| !curves.steps.is_empty()) {
        let text = serde_json::to_string_pretty(&curves).map_err(|e| Failure::Work(e.to_string()))?;
        let kept = file.parent().map_or(Ok(()), std::fs::create_dir_all).is_ok()
            && write_whole(&file, text.as_bytes()).is_ok();
        if !a.quiet {
            match kept {
                true => eprintln!("note: curves kept in {}", file.display()),
                false => eprintln!(
                    "note: curves cannot be kept in {}; they will be measured again",
                    file.display()
                ),
            }
        }
    }
    Ok(curves)
}

/// What the curves depend on: all but camera and size.
fn key(a: &RenderArguments, scene: &Scene, techniques: &[Technique]) -> Result<String, Failure> {
    let machine = if a.machine.is_gpu() {
        let gpu = a.backend.gpu(crate::cli::options::ArithmeticChoice::Fast)?;
        format!("{} {:?}", twinlight_gpu::describe(gpu.adapter()), gpu.variant())
    } else {
        format!("{}, {} threads", processor(), a.backend.cpu()?.threads())
    };
    let names: Vec<_> = techniques.iter().map(|&t| name(t)).collect();
    let mut hasher = DefaultHasher::new();
    for name in &names {
        let steps = steps_of(name, (512, 512)).unwrap_or_default();
        steps.iter().map(Trial::settings).collect::<Vec<_>>().hash(&mut hasher);
    }
    Ok(format!(
        "{} {} {:016x} {:?} emissive {} {} rays, {:?} upsampling, {} {:016x} on {machine}",
        env!("CARGO_PKG_VERSION"),
        scene.name,
        scene.fingerprint(),
        a.only,
        a.scene.look.emissive,
        a.samples,
        a.upsampling,
        names.join(","),
        hasher.finish(),
    ))
}

/// Where curves are kept: `TWINLIGHT_CACHE`, or the user's folder for such things.
fn file(key: &str) -> Option<PathBuf> {
    use etcetera::BaseStrategy;
    let own = std::env::var_os("TWINLIGHT_CACHE").filter(|p| !p.is_empty()).map(PathBuf::from);
    let usual = || etcetera::choose_base_strategy().ok().map(|s| s.cache_dir().join("twinlight"));
    let mut hasher = DefaultHasher::new();
    key.hash(&mut hasher);
    Some(own.or_else(usual)?.join(format!("curves-{:016x}.json", hasher.finish())))
}

/// Small pictures of a scene.
struct Trials<'a> {
    a: &'a RenderArguments,
    subject: Subject,
    /// Views of the sizes of [`SIDES`].
    views: [View; 2],
}

impl<'a> Trials<'a> {
    fn new(a: &'a RenderArguments, scene: &Scene, view: &View) -> Result<Self, Failure> {
        let longer = f64::from(view.width.max(view.height));
        let views = SIDES.map(|side| {
            let of = |x: u32| ((f64::from(x) * f64::from(side) / longer / 4.0).round() as u32).max(2) * 4;
            view.resized(of(view.width), of(view.height))
        });
        let words = vec![a.scene.scene.clone()];
        let emissive = a.scene.look.emissive;
        let subject = Subject::of(words, scene.clone(), views[0], emissive, &a.backend, a.machine.is_gpu())?;
        Ok(Self { a, subject, views })
    }

    /// The light from the turned camera; `None` where there is none.
    fn reference(&mut self, turn: f32) -> Result<Option<Halves>, Failure> {
        self.subject.view = turned(&self.views[0], turn);
        Ok(reference(self.a, &mut self.subject)?.filter(|r| r.mean().mean().max_element() > 0.0))
    }

    /// What a step costs from the turned camera; `None` where it takes too long, or no error can be told.
    fn measure(
        &mut self,
        technique: &str,
        step: usize,
        turn: f32,
        right: &Halves,
    ) -> Result<Option<Measured>, Failure> {
        let mut at = |view: &View| {
            let view = turned(view, turn);
            let own = of_trial(self.a, &trial_of(technique, step, &view)?, (view.width, view.height))?;
            self.subject.measure_briefly(&passes::request(&own, own.technique, &view)?)
        };
        let small = at(&self.views[1])?.seconds.median;
        if small > TOO_LONG {
            return Ok(None);
        }
        let large = at(&self.views[0])?;
        let [many, few] = self.views.map(|v| f64::from(v.pixels()));
        let per_pixel = ((large.seconds.median - small) / (many - few)).max(0.0);
        let fixed = (large.seconds.median - per_pixel * many).max(0.0);
        Ok(error_of(&large.all, right).map(|error| Measured {
            technique: technique.to_owned(),
            step,
            fixed,
            per_pixel,
            error,
        }))
    }
}

/// Measures all steps from all cameras.
fn calibrate(
    a: &RenderArguments,
    scene: &Scene,
    view: &View,
    techniques: &[Technique],
) -> Result<Vec<Measured>, Failure> {
    let mut trials = Trials::new(a, scene, view)?;
    let mut steps = Vec::new();
    for &technique in techniques {
        let count = steps_of(&name(technique), (64, 64)).map_or(0, |s| s.len());
        steps.extend((0..count).map(|step| (name(technique), step)));
    }
    if !a.quiet {
        eprintln!("note: measuring what accuracy costs in this scene on this machine, once");
    }
    let bar =
        if a.quiet { ProgressBar::hidden() } else { ProgressBar::new((steps.len() * TURNS.len()) as u64) };
    if let Ok(style) = ProgressStyle::with_template("{bar:30} {pos}/{len} {msg}, {eta} left") {
        bar.set_style(style);
    }
    let mut found: Vec<Vec<Measured>> = vec![Vec::new(); steps.len()];
    for turn in TURNS {
        let Some(right) = trials.reference(turn)? else { continue };
        for ((technique, step), all) in steps.iter().zip(&mut found) {
            bar.inc(1);
            bar.set_message(format!("{technique} {}", step + 1));
            all.extend(trials.measure(technique, *step, turn, &right)?);
        }
    }
    bar.finish_and_clear();
    let mean =
        |all: &[Measured], of: fn(&Measured) -> f64| all.iter().map(of).sum::<f64>() / all.len() as f64;
    Ok(found
        .iter()
        .filter_map(|all| {
            let first = all.first()?;
            Some(Measured {
                fixed: mean(all, |m| m.fixed),
                per_pixel: mean(all, |m| m.per_pixel),
                error: mean(all, |m| m.error * m.error).sqrt(),
                ..first.clone()
            })
        })
        .collect())
}

fn trial_of(technique: &str, step: usize, view: &View) -> Result<Trial, Failure> {
    let steps = steps_of(technique, (view.width, view.height));
    steps.and_then(|s| s.get(step).cloned()).ok_or_else(|| Failure::Work("no such step".into()))
}

/// The view turned about the vertical through the eye.
fn turned(view: &View, degrees: f32) -> View {
    let mut view = *view;
    let turn = Quat::from_axis_angle(Vec3::Y, degrees.to_radians());
    let frame = &mut view.frame;
    (frame.right, frame.up, frame.forward) = (turn * frame.right, turn * frame.up, turn * frame.forward);
    view
}

impl Choice {
    /// What is promised.
    pub(super) fn text(&self) -> String {
        let settings = if self.settings.is_empty() { "its defaults" } else { &self.settings };
        format!(
            "{}, {settings}: {:.1} ms and {:.1} % expected",
            name(self.technique),
            1e3 * self.seconds,
            100.0 * self.error
        )
    }

    /// Says beside what was promised what was measured.
    pub(super) fn report(&self, outcome: &mut Outcome, error: Option<f64>) {
        let seconds: f64 = outcome.ran.iter().map(|t| t.nanoseconds * 1e-9).sum();
        let (predicted, measured) = (100.0 * self.error, error.map(|e| 100.0 * e));
        outcome.report += &format!(
            "time: {:.1} ms expected, {:.1} ms measured; error: {predicted:.1} % expected, {} measured\n",
            1e3 * self.seconds,
            1e3 * seconds,
            measured.map_or_else(|| "none".into(), |e| format!("{e:.1} %")),
        );
        outcome.json["choice"] = json!({
            "settings": self.settings,
            "fits": self.fits,
            "expected_seconds": self.seconds,
            "expected_error": self.error,
            "measured_seconds": if seconds.is_finite() { Some(seconds) } else { None },
            "measured_error": error,
        });
    }
}
