//! Standard errors, threads and interruption.

use crate::support::*;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;
use twinlight::scene::Scene;
use twinlight::technique::View;
use twinlight::technique::reference::{self, Bounces, Reference, ReferenceResult, Statistics};

fn cornell() -> (Scene, View) {
    let s = Scene::open("cornell-glossy").unwrap();
    let view = view(&s.view(), 40, 30);
    (s, view)
}

fn grey_mean(s: &Statistics) -> f64 {
    (s.mean.x + s.mean.y + s.mean.z) / 3.0
}

/// The spread of independent values: root of their sample variance.
fn spread(values: &[f64]) -> f64 {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt()
}

/// Whether the spread of 16 values and their stated standard error agree: χ² of 15 degrees of freedom rarely leaves this.
fn agree(spread: f64, stated: f64) -> bool {
    (0.5..2.0).contains(&(spread / stated))
}

#[test]
fn stated_standard_errors_are_the_spread_over_seeds() {
    // Without gloss: a highlight's rare bright paths would need more seeds for a steady spread.
    let s = Scene::open("cornell-box").unwrap();
    let view = view(&s.view(), 40, 30);
    let base = Reference { pixel_filter: true, ..settings(Bounces::Count(2), 16) };
    let runs: Vec<ReferenceResult> =
        (0..16).map(|seed| trace(&s, &view, &Reference { seed, ..base.clone() })).collect();
    for (i, what) in ["direct", "indirect", "all"].iter().enumerate() {
        let means: Vec<f64> = runs.iter().map(|r| grey_mean(&r.statistics[i])).collect();
        let stated = runs.iter().map(|r| r.statistics[i].standard_error).sum::<f64>() / 16.0;
        println!("{what}: spread {:.6}, stated {stated:.6}", spread(&means));
        assert!(agree(spread(&means), stated), "{what}: {} and {stated}", spread(&means));
        assert!(!agree(spread(&means), 4.0 * stated), "negative control: as if of a single path");
    }
    // Per pixel: root mean square of the spreads over seeds.
    let pictures: Vec<_> = runs.iter().map(ReferenceResult::all).collect();
    let grey = |i: usize, k: usize| f64::from(pictures[k].pixels[i].element_sum()) / 3.0;
    let squares: f64 =
        (0..1200).map(|i| spread(&(0..16).map(|k| grey(i, k)).collect::<Vec<_>>()).powi(2)).sum();
    let stated = runs.iter().map(|r| r.statistics[2].pixel_standard_error).sum::<f64>() / 16.0;
    assert!(agree((squares / 1200.0).sqrt(), stated), "{} and {stated}", (squares / 1200.0).sqrt());
    // The mean over the picture is the statistics' mean.
    let mean = pictures[0].mean().as_dvec3();
    assert!((mean - runs[0].statistics[2].mean).abs().max_element() < 1e-5);
    let four = trace(&s, &view, &Reference { samples: 64, ..base });
    let ratio = runs.iter().map(|r| r.statistics[2].standard_error).sum::<f64>()
        / 16.0
        / four.statistics[2].standard_error;
    assert!((1.6..2.5).contains(&ratio), "four times the paths halve the error: {ratio}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let (s, view) = cornell();
    let run = |threads: usize, seed: u32| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| trace(&s, &view, &Reference { seed, ..settings(Bounces::All, 12) }))
    };
    let one = run(1, 5);
    for threads in [2, 7, 16] {
        let other = run(threads, 5);
        assert!(same_bits(&one.direct, &other.direct) && same_bits(&one.indirect, &other.indirect));
        assert_eq!(one.statistics, other.statistics);
    }
    assert!(!same_bits(&one.all(), &run(2, 6).all()), "negative control: another seed");
}

#[test]
fn an_interruption_keeps_whole_chunks_only() {
    let (s, view) = cornell();
    let tree = tree(&s);
    let settings = |samples| Reference { seed: 3, ..settings(Bounces::Count(2), samples) };
    let before = reference::render(&s, &tree, &view, &settings(64), &AtomicBool::new(true), |_| ());
    assert_eq!(before.samples, 0);
    assert!(before.all().pixels.iter().all(|p| *p == glam::Vec3::ZERO));
    assert!(before.statistics[2].mean == glam::DVec3::ZERO && before.statistics[2].standard_error == 0.0);

    let stop = AtomicBool::new(false);
    let between = reference::render(&s, &tree, &view, &settings(64), &stop, |done| {
        stop.store(done >= 16, Ordering::Relaxed);
    });
    assert_eq!(between.samples, 16);
    let whole = trace(&s, &view, &settings(16));
    assert!(same_bits(&between.all(), &whole.all()) && between.statistics == whole.statistics);

    // At a moment that has nothing to do with chunks.
    let stop = AtomicBool::new(false);
    let during = std::thread::scope(|scope| {
        scope.spawn(|| {
            std::thread::sleep(Duration::from_millis(150));
            stop.store(true, Ordering::Relaxed);
        });
        reference::render(&s, &tree, &view, &settings(1 << 20), &stop, |_| ())
    });
    println!("stopped after {} paths per pixel", during.samples);
    assert!(during.samples < 1 << 20 && during.samples % 8 == 0, "{}", during.samples);
    let whole = trace(&s, &view, &settings(during.samples));
    assert!(same_bits(&during.all(), &whole.all()));
    let more = trace(&s, &view, &settings(during.samples + 8));
    assert!(!same_bits(&during.all(), &more.all()), "negative control: a chunk more");
}
