//! What is the right answer? A path tracer over the same tree and materials, without bias.
//!
//! CPU only. Next-event estimation to lights without extent; the environment and emissive surfaces are found by
//! scattered rays. Nothing is clamped; with [`Bounces::All`] paths end by Russian roulette, which keeps the mean.

mod path;
pub mod stages;

use super::View;
use super::world::{environment_params, texels_with_environment};
use crate::picture::Picture;
use crate::scene::{Scene, bvh::Bvh};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};
use twinlight_kernels::passes::elements::{CameraParams, GatherParams};

/// How far light is followed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Bounces {
    /// This many reflections between the first surface and the light's first: 0 is direct light.
    Count(u32),
    /// Until Russian roulette ends the path.
    All,
}

/// Settings of the path tracer.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Reflections beyond direct light.
    pub bounces: Bounces,
    /// Paths per pixel; the error falls with the root of their number, the time grows with it.
    pub samples: u32,
    /// Seed of all random numbers.
    pub seed: u32,
    /// Let emissive surfaces emit.
    pub emissive: bool,
    /// Filter over the whole pixel; otherwise every path goes through the pixel's centre, as the techniques do.
    pub pixel_filter: bool,
}

impl Default for Reference {
    fn default() -> Self {
        Self { bounces: Bounces::Count(1), samples: 64, seed: 1, emissive: false, pixel_filter: true }
    }
}

/// Radiance of one pixel: what came straight from a source (or is one), and what came by other surfaces.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Estimate {
    pub(crate) direct: DVec3,
    pub(crate) indirect: DVec3,
}

/// Sums over the paths of one pixel.
#[derive(Clone, Copy, Debug, Default)]
struct PixelSum {
    direct: DVec3,
    indirect: DVec3,
    direct_squared: f64,
    indirect_squared: f64,
    all_squared: f64,
}

/// The mean of a picture and how far it may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Statistics {
    /// Mean colour over the picture.
    pub mean: DVec3,
    /// Standard error of the mean's luminance-like average (r + g + b)/3, from the spread of the paths of each pixel.
    pub standard_error: f64,
    /// Root mean square over pixels of the standard error of a pixel's average.
    pub pixel_standard_error: f64,
}

/// A converged, or interrupted, reference.
#[derive(Debug)]
pub struct ReferenceResult {
    /// Light straight from the sources, emission and background.
    pub direct: Picture,
    /// Light by way of other surfaces.
    pub indirect: Picture,
    /// Paths per pixel that are in the pictures.
    pub samples: u32,
    /// Statistics of direct, indirect and both together.
    pub statistics: [Statistics; 3],
}

impl ReferenceResult {
    /// Direct plus indirect light.
    pub fn all(&self) -> Picture {
        let mut picture = self.direct.clone();
        for (sum, indirect) in picture.pixels.iter_mut().zip(&self.indirect.pixels) {
            *sum += *indirect;
        }
        picture
    }
}

/// What paths are traced through.
pub(crate) struct Setting<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) tree: &'a Bvh,
    pub(crate) texels: Vec<u32>,
    pub(crate) environment: GatherParams,
    pub(crate) has_environment: bool,
    pub(crate) settings: &'a Reference,
    pub(crate) camera: CameraParams,
}

/// What paths of a picture are traced through.
pub(crate) fn setting<'a>(
    scene: &'a Scene,
    tree: &'a Bvh,
    view: &View,
    settings: &'a Reference,
) -> Setting<'a> {
    Setting {
        scene,
        tree,
        texels: texels_with_environment(scene),
        environment: environment_params(&scene.environment, scene.texels.len() as u32),
        has_environment: scene.census().has_environment,
        settings,
        camera: view.params(0),
    }
}

/// Paths per pixel between two looks at progress and interruption.
const CHUNK: u32 = 8;

/// Traces the picture on the current rayon pool.
///
/// `progress` is told after every few paths how many per pixel are done. When `stop` becomes true the result holds
/// the paths finished so far, possibly none.
pub fn render(
    scene: &Scene,
    tree: &Bvh,
    view: &View,
    settings: &Reference,
    stop: &AtomicBool,
    progress: impl Fn(u32),
) -> ReferenceResult {
    let setting = setting(scene, tree, view, settings);
    let mut sums = vec![PixelSum::default(); view.pixels() as usize];
    let mut done = 0;
    while done < settings.samples && !stop.load(Ordering::Relaxed) {
        let chunk = CHUNK.min(settings.samples - done);
        let before = sums.clone();
        sums.par_iter_mut().enumerate().with_min_len(16).for_each(|(pixel, sum)| {
            if stop.load(Ordering::Relaxed) {
                return;
            }
            for sample in done..done + chunk {
                sum.add(path::trace(&setting, pixel as u32, sample));
            }
        });
        if stop.load(Ordering::Relaxed) {
            // Some pixels lack this chunk: keep what all have.
            sums = before;
            break;
        }
        done += chunk;
        progress(done);
    }
    finish(view, &sums, done)
}

impl PixelSum {
    fn add(&mut self, e: Estimate) {
        let grey = |c: DVec3| (c.x + c.y + c.z) / 3.0;
        self.direct += e.direct;
        self.indirect += e.indirect;
        self.direct_squared += grey(e.direct).powi(2);
        self.indirect_squared += grey(e.indirect).powi(2);
        self.all_squared += grey(e.direct + e.indirect).powi(2);
    }
}

fn finish(view: &View, sums: &[PixelSum], samples: u32) -> ReferenceResult {
    let scale = 1.0 / f64::from(samples.max(1));
    let picture = |of: &dyn Fn(&PixelSum) -> DVec3| Picture {
        width: view.width,
        height: view.height,
        pixels: sums.iter().map(|s| (of(s) * scale).as_vec3()).collect::<Vec<Vec3>>(),
    };
    let statistics = [
        statistics(sums, samples, |s| (s.direct, s.direct_squared)),
        statistics(sums, samples, |s| (s.indirect, s.indirect_squared)),
        statistics(sums, samples, |s| (s.direct + s.indirect, s.all_squared)),
    ];
    ReferenceResult {
        direct: picture(&|s| s.direct),
        indirect: picture(&|s| s.indirect),
        samples,
        statistics,
    }
}

/// Mean and standard errors from each pixel's sum and sum of squares.
fn statistics(sums: &[PixelSum], samples: u32, of: impl Fn(&PixelSum) -> (DVec3, f64)) -> Statistics {
    let n = f64::from(samples.max(1));
    let mut mean = DVec3::ZERO;
    let mut variance = 0.0;
    for s in sums {
        let (sum, squared) = of(s);
        mean += sum / n;
        let average = (sum.x + sum.y + sum.z) / (3.0 * n);
        // Of the pixel's mean; unknown (counted as 0) for a single path.
        variance += ((squared / n - average * average).max(0.0)) / (n - 1.0).max(1.0);
    }
    let pixels = sums.len().max(1) as f64;
    Statistics {
        mean: mean / pixels,
        standard_error: variance.sqrt() / pixels,
        pixel_standard_error: (variance / pixels).sqrt(),
    }
}
