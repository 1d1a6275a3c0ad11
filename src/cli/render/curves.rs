//! What do a technique's steps cost in a scene, and how far off are they? Measured on this machine, and kept.
//!
//! Time is taken to be a part that every picture has and a part for each pixel; the squared error of averages over blocks, a part that stays and
//! a part that falls with the number of pixels.

use super::arguments::{Only, RenderArguments, Technique, parse_line};
use super::{check_request, name, passes};
use crate::cli::Failure;
use crate::cli::tradeoff::{Subject, Trial, steps_of};
use crate::picture::{Picture, write_whole};
use crate::report::halves::Halves;
use crate::report::machine::processor;
use crate::scene::Scene;
use crate::technique::View;
use clap::ValueEnum;
use glam::{Quat, Vec3};
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Deserialize, Serialize};
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Pixels of the longer side for curves: of pictures for errors and of the smaller ones for the time without pixels.
const SIDES: [u32; 2] = [160, 64];
/// Blocks along the longer side, about: what is compared.
const BLOCKS: f64 = 48.0;
/// Turns of the camera, degrees.
const TURNS: [f32; 3] = [0.0, 20.0, -20.0];
/// Paths of a reference, about, for errors down to this; smaller ones need more, by the square, up to this many times as many.
const PATHS: f64 = 1.5e6;
const PATHS_TELL: f64 = 0.12;
const MORE_PATHS: f64 = 8.0;
/// Steps whose small picture takes longer, in seconds, are no choice.
const TOO_LONG: f64 = 1.5;

/// A step with what it costs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Measured {
    pub technique: String,
    /// Its number among the technique's steps.
    pub step: usize,
    /// Seconds of a frame without pixels, and for each pixel.
    fixed: f64,
    per_pixel: f64,
    /// Relative RMSE at the larger size and at the smaller, root mean square over the cameras.
    errors: [f64; 2],
    /// The longer sides of these sizes, pixels.
    sides: [f64; 2],
}

/// The curves of a scene on a machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Curves {
    key: String,
    pub steps: Vec<Measured>,
}

/// What a step is expected to cost, and how far off it is.
#[derive(Clone, Copy)]
pub(super) struct Expected {
    pub seconds: f64,
    pub error: f64,
}

impl Measured {
    /// For a picture of this size.
    pub(super) fn expected(&self, view: &View) -> Expected {
        let [fine, coarse] = self.errors.map(|e| e * e);
        let [large, small, own] =
            [self.sides[0], self.sides[1], f64::from(view.width.max(view.height))].map(|side| side.powi(-2));
        let slope = if small > large { ((coarse - fine) / (small - large)).max(0.0) } else { 0.0 };
        // Two sizes do not tell that it falls faster than the area of a pixel.
        let squared = (fine + slope * (own - large)).max(fine * (own / large).min(1.0));
        Expected { seconds: self.fixed + self.per_pixel * f64::from(view.pixels()), error: squared.sqrt() }
    }
}

/// What is asked for with a step's knobs at a picture's size, if that size allows them.
pub(super) fn of_trial(
    a: &RenderArguments,
    trial: &Trial,
    size: (u32, u32),
) -> Result<RenderArguments, Failure> {
    let mut line = vec![a.scene.scene.clone()];
    line.extend(trial.words.iter().cloned());
    let knobs = parse_line(&line)?.knobs;
    let technique = Technique::from_str(trial.technique, false).map_err(Failure::Work)?;
    let mut own = RenderArguments { knobs, technique, dump: Vec::new(), ..a.clone() };
    own.scene.look.size = size;
    check_request(&own, technique)?;
    Ok(own)
}

/// Blocks of a picture: what is compared.
fn blocks(view: &View) -> View {
    let scale = BLOCKS / f64::from(view.width.max(view.height));
    let of = |x: u32| ((f64::from(x) * scale).round() as u32).clamp(1, x);
    view.resized(of(view.width), of(view.height))
}

/// The light of the blocks in two halves. Techniques see centres of pixels and so do the paths: what a pixel's centre leaves out, no setting
/// brings back. Of pictures with more pixels than paths, blocks have so many centres that they make up the whole.
pub(super) fn reference(a: &RenderArguments, subject: &mut Subject) -> Result<Option<Halves>, Failure> {
    let whole = subject.view;
    let blocks = blocks(&whole);
    let more = a.error.map_or(2.0, |limit| (PATHS_TELL / limit).powi(2).clamp(1.0, MORE_PATHS));
    let paths = |view: &View| 0.5 * more * PATHS / f64::from(view.pixels());
    let centres = paths(&whole) >= 1.0;
    subject.view = if centres { whole } else { blocks };
    let samples = paths(&subject.view).round().clamp(1.0, 4096.0) as u32;
    let half = |seed| {
        let paths = subject.trace(samples, seed, !centres, &AtomicBool::new(false), |_| ())?;
        let light = match a.only {
            Only::All => paths.all(),
            Only::Direct => paths.direct,
            Only::Indirect => paths.indirect,
        };
        Ok::<_, Failure>(light.shrunk(blocks.width, blocks.height))
    };
    let halves = half(11).and_then(|one| Ok((one, half(12)?)));
    subject.view = whole;
    let (one, other) = halves?;
    Ok(Halves::new(one, other).filter(|r| r.mean().mean().max_element() > 0.0))
}

/// How far a picture's blocks are from a reference of them, or what is the least that this tells; `None` where nothing can be told.
pub(super) fn error_of(picture: &Picture, right: &Halves) -> Option<f64> {
    let (width, height) = (right.mean().width, right.mean().height);
    right.errors(&picture.shrunk(width, height)).map(|e| e.relative_rmse.max(e.resolution))
}

/// A scene's curves, measured if they are not known.
pub(super) fn curves(
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
        "{} {} {:016x} {:?} through centres, emissive {} {} rays, {:?} upsampling, {} {:016x} on {machine}",
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

/// Smaller pictures of a scene.
pub(super) struct Trials<'a> {
    a: &'a RenderArguments,
    subject: Subject,
    /// The larger one, and the smaller.
    views: [View; 2],
    /// Whether a frame before warms up.
    warm: bool,
}

impl<'a> Trials<'a> {
    /// From where a picture is seen, at about two thirds and a quarter of its sides: to tell what to expect of it.
    pub(super) fn before(a: &'a RenderArguments, scene: &Scene, view: &View) -> Result<Self, Failure> {
        let longer = view.width.max(view.height);
        let side = |sixteenths: u32, least: u32| (longer / 16 * sixteenths).max(least.min(longer));
        Self::new(a, scene, view, [side(11, SIDES[0]), side(4, SIDES[1])], true)
    }

    fn new(
        a: &'a RenderArguments,
        scene: &Scene,
        view: &View,
        sides: [u32; 2],
        warm: bool,
    ) -> Result<Self, Failure> {
        let longer = f64::from(view.width.max(view.height));
        let views = sides.map(|side| {
            let of = |x: u32| ((f64::from(x) * f64::from(side) / longer / 4.0).round() as u32).max(2) * 4;
            view.resized(of(view.width), of(view.height))
        });
        let words = vec![a.scene.scene.clone()];
        let emissive = a.scene.look.emissive;
        let subject = Subject::of(words, scene.clone(), views[0], emissive, &a.backend, a.machine.is_gpu())?;
        Ok(Self { a, subject, views, warm })
    }

    /// The light from the turned camera, at both sizes; `None` where there is none.
    pub(super) fn reference(&mut self, turn: f32) -> Result<Option<[Halves; 2]>, Failure> {
        let mut at = |view: &View| {
            self.subject.view = turned(view, turn);
            reference(self.a, &mut self.subject)
        };
        let [large, small] = &self.views;
        Ok(at(large)?.zip(at(small)?).map(|(large, small)| [large, small]))
    }

    /// What a step costs from the turned camera; `None` where it takes too long, or no error can be told.
    pub(super) fn measure(
        &mut self,
        technique: &str,
        step: usize,
        turn: f32,
        right: &[Halves; 2],
    ) -> Result<Option<Measured>, Failure> {
        let mut at = |view: &View| {
            let view = turned(view, turn);
            let own = of_trial(self.a, &trial_of(technique, step, &view)?, (view.width, view.height))?;
            self.subject.measure_briefly(&passes::request(&own, own.technique, &view)?, self.warm)
        };
        let small = at(&self.views[1])?;
        if small.seconds.median > TOO_LONG {
            return Ok(None);
        }
        let large = at(&self.views[0])?;
        let (Some(error), Some(coarse)) = (error_of(&large.all, &right[0]), error_of(&small.all, &right[1]))
        else {
            return Ok(None);
        };
        let [many, few] = self.views.map(|v| f64::from(v.pixels()));
        let (more, less) = (large.seconds.median, small.seconds.median);
        let slope = if many > few { (more - less) / (many - few) } else { 0.0 };
        // No part can be less than nothing.
        let per_pixel = slope.min(more / many).max(0.0);
        Ok(Some(Measured {
            technique: technique.to_owned(),
            step,
            fixed: more - per_pixel * many,
            per_pixel,
            errors: [error, coarse],
            sides: self.views.map(|v| f64::from(v.width.max(v.height))),
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
    let mut trials = Trials::new(a, scene, view, SIDES, false)?;
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
                errors: [
                    mean(all, |m| m.errors[0] * m.errors[0]).sqrt(),
                    mean(all, |m| m.errors[1] * m.errors[1]).sqrt(),
                ],
                ..first.clone()
            })
        })
        .collect())
}

/// A step of a technique, for pictures of this size.
pub(super) fn trial_of(technique: &str, step: usize, view: &View) -> Result<Trial, Failure> {
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
