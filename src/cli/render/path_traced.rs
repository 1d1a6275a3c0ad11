//! `twinlight render --technique reference`.

use super::Outcome;
use super::arguments::{Only, RenderArguments};
use crate::cli::Failure;
use crate::picture::Picture;
use crate::scene::{Scene, bvh::Bvh};
use crate::technique::View;
use crate::technique::reference::{self, Reference, ReferenceResult};
use serde_json::json;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

pub(super) fn run(a: &RenderArguments, scene: &Scene, tree: &Bvh, view: &View) -> Result<Outcome, Failure> {
    let settings = Reference {
        bounces: a.bounces,
        samples: a.samples,
        seed: a.seed,
        emissive: a.scene.look.emissive,
        pixel_filter: !a.pixel_centre,
    };
    let stop = Arc::new(AtomicBool::new(false));
    let seen = stop.clone();
    // Without a handler an interruption simply ends the command: nothing is written then.
    let _ = ctrlc::set_handler(move || seen.store(true, Ordering::Relaxed));
    let bar = if a.quiet {
        indicatif::ProgressBar::hidden()
    } else {
        indicatif::ProgressBar::new(u64::from(a.samples))
    };
    if let Ok(style) =
        indicatif::ProgressStyle::with_template("{bar:40} {pos}/{len} paths per pixel, {eta} left")
    {
        bar.set_style(style);
    }
    let start = std::time::Instant::now();
    let result =
        reference::render(scene, tree, view, &settings, &stop, |done| bar.set_position(u64::from(done)));
    bar.finish_and_clear();
    if result.samples == 0 {
        return Err(Failure::Work(
            "interrupted before the first paths were done; nothing was written".into(),
        ));
    }
    if a.check_finite {
        let bad = |p: &Picture| p.pixels.iter().filter(|c| !c.is_finite()).count();
        let (direct, indirect) = (bad(&result.direct), bad(&result.indirect));
        if direct + indirect > 0 {
            return Err(Failure::Work(format!(
                "non-finite pixels: {direct} in direct, {indirect} in indirect; please report the scene"
            )));
        }
    }
    Ok(reference_outcome(a, result, start.elapsed().as_secs_f64(), stop.load(Ordering::Relaxed)))
}

fn reference_outcome(
    a: &RenderArguments,
    result: ReferenceResult,
    seconds: f64,
    interrupted: bool,
) -> Outcome {
    let mut text = format!("Reference on cpu: {} paths per pixel in {seconds:.2} s\n", result.samples);
    text += "light      mean r       mean g       mean b   standard error   pixel standard error\n";
    let mut json = json!({ "technique": "Reference", "samples": result.samples, "seconds": seconds });
    for (name, s) in ["direct", "indirect", "all"].iter().zip(&result.statistics) {
        text += &format!(
            "{name:<8} {:>12.6} {:>12.6} {:>12.6} {:>12.6} {:>12.6}\n",
            s.mean.x, s.mean.y, s.mean.z, s.standard_error, s.pixel_standard_error
        );
        json[name] = json!({
            "mean": s.mean.to_array(),
            "standard_error": s.standard_error,
            "pixel_standard_error": s.pixel_standard_error,
        });
    }
    let picture = match a.only {
        Only::Direct => result.direct.clone(),
        Only::Indirect => result.indirect.clone(),
        Only::All => result.all(),
    };
    let mut dumps = Vec::new();
    for name in &a.dump {
        let dump = if name == "direct" { result.direct.clone() } else { result.indirect.clone() };
        dumps.push((name.clone(), dump));
    }
    let (ran, changes) = (Vec::new(), Vec::new());
    Outcome { picture, report: text, json, dumps, interrupted, ran, changes }
}
