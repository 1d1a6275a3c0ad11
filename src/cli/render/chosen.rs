//! Which settings fit into a time, or an error? By curves measured on this machine.
//!
//! A scene's curves are measured once and kept in the user's cache: each technique's steps from quick to good, from three cameras, at two small
//! sizes. They say for other cameras and sizes which step to try first; trials of that step from where the picture is seen, at about two thirds and
//! a quarter of its sides, tell what to expect.

use super::arguments::{RenderArguments, Technique};
use super::curves::{Expected, Measured, Trials, curves, error_of, of_trial, reference, trial_of};
use super::{Knobs, Outcome, name};
use crate::cli::Failure;
use crate::cli::tradeoff::{Subject, steps_of};
use crate::picture::Picture;
use crate::scene::Scene;
use crate::technique::View;
use serde_json::json;

/// Steps that are tried from where the picture is seen.
const TRIES: usize = 4;

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

/// How far an expectation is beyond what is asked for: 1 or less is within.
fn excess(a: &RenderArguments, e: Expected) -> f64 {
    let time = a.budget.map_or(0.0, |b| e.seconds / b.as_secs_f64());
    time.max(a.error.map_or(0.0, |limit| e.error / limit))
}

/// Chooses by the curves, which are measured if they are not known; `None` for a budget where nothing is lit.
pub(super) fn choose(a: &RenderArguments, scene: &Scene, view: &View) -> Result<Option<Choice>, Failure> {
    let techniques = techniques(a, scene)?;
    let mut trials = Trials::before(a, scene, view)?;
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
    // Within a time the best comes first, within an error the quickest; behind them what comes nearest.
    let rank = |m: &Measured| {
        let e = m.expected(view);
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
        let expected = here.expected(view);
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
