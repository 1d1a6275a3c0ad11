//! What does a trial cost, and what does it give?

use super::record::Spread;
use super::sweep::Trial;
use crate::backend::{Backend, Cpu, Gpu};
use crate::cli::Failure;
use crate::cli::options::{ArithmeticChoice, BackendOptions, build_tree};
use crate::cli::render::{RenderArguments, parse_line, request_of};
use crate::picture::Picture;
use crate::plan::{Change, Plan, Request, Technique};
use crate::renderer::Renderer;
use crate::report::halves::Halves;
use crate::scene::{Scene, bvh::Bvh};
use crate::technique::reference::{self, Bounces, Reference, ReferenceResult};
use crate::technique::{LightPart, View};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

/// How often a frame is measured.
#[derive(Clone, Copy)]
struct Repeats {
    /// Frames after the one that warms up; where none, that one counts.
    most: u32,
    /// No more once these seconds are over.
    until: f64,
}

/// Seconds after which a trial is not repeated again.
const LONG: f64 = 40.0;
/// Short frames, of which other work on the machine slows down some, are measured several times; long ones are middles in themselves.
const BRIEFLY: Repeats = Repeats { most: 9, until: 0.6 };

/// What a trial gave.
pub(crate) struct Measured {
    pub seconds: Spread,
    pub wall: f64,
    pub camera: Option<f64>,
    pub bytes: u64,
    pub indirect: Option<Picture>,
    pub all: Picture,
}

/// A scene as it is looked at, with all that trials share.
pub(crate) struct Subject {
    /// The scene and its options, as words of a command line.
    pub words: Vec<String>,
    pub scene: Scene,
    pub tree: Bvh,
    pub view: View,
    pub emissive: bool,
    backend: BackendOptions,
    gpu: bool,
    /// Becomes true when the user interrupts.
    pub stop: Arc<AtomicBool>,
    /// Renderers that trials use again: of the CPU, of the GPU in fast arithmetic and in strict.
    cpu: Option<Renderer<Cpu>>,
    fast: Option<Renderer<Gpu>>,
    strict: Option<Renderer<Gpu>>,
}

impl Subject {
    /// Opens a scene.
    pub(crate) fn open(words: Vec<String>, backend: &BackendOptions, gpu: bool) -> Result<Self, Failure> {
        let a = parse_line(&words)?;
        let (scene, view) = a.scene.open()?;
        Self::of(words, scene, view, a.scene.look.emissive, backend, gpu)
    }

    /// A scene that is open.
    pub(crate) fn of(
        words: Vec<String>,
        scene: Scene,
        view: View,
        emissive: bool,
        backend: &BackendOptions,
        gpu: bool,
    ) -> Result<Self, Failure> {
        let tree = build_tree(&scene)?;
        let (backend, stop, cpu, fast, strict) = (backend.clone(), Arc::default(), None, None, None);
        Ok(Self { words, scene, tree, view, emissive, backend, gpu, stop, cpu, fast, strict })
    }

    /// The command line of a trial.
    pub(crate) fn line(&self, trial: &Trial) -> Vec<String> {
        let mut words = self.words.clone();
        words.extend(["--technique".to_owned(), trial.technique.to_owned()]);
        words.extend(trial.words.iter().cloned());
        words
    }

    /// What makes light of the scene that the techniques do not split the same way when parts are asked for.
    pub(crate) fn splits(&self) -> bool {
        let census = self.scene.census();
        census.has_environment || (self.emissive && census.has_emission)
    }

    /// The arguments of a trial.
    pub(crate) fn arguments(&self, trial: &Trial) -> Result<RenderArguments, Failure> {
        parse_line(&self.line(trial))
    }

    /// Measures a trial of a technique of passes.
    pub(crate) fn measure(&mut self, trial: &Trial, repeats: u32) -> Result<Measured, Failure> {
        let a = self.arguments(trial)?;
        let request = request_of(&a, &self.view)?;
        let parts = if self.splits() { Parts::Rendered } else { Parts::Subtracted };
        let repeats = Repeats { most: repeats, until: LONG };
        if a.scene.look.fit_spheres.is_some() || trial.words.iter().any(|w| w == "--fit-spheres") {
            // Another scene: with other proxies.
            let (scene, view) = a.scene.open()?;
            let request = Request { view, ..request };
            let mut other =
                Self::of(self.words.clone(), scene, view, self.emissive, &self.backend, self.gpu)?;
            other.stop = self.stop.clone();
            return other.measure_request(&request, a.arithmetic(), parts, repeats);
        }
        self.measure_request(&request, a.arithmetic(), parts, repeats)
    }

    fn measure_request(
        &mut self,
        request: &Request,
        arithmetic: Option<ArithmeticChoice>,
        part: Parts,
        repeats: Repeats,
    ) -> Result<Measured, Failure> {
        let (scene, tree) = (&self.scene, &self.tree);
        if !self.gpu {
            if self.cpu.is_none() {
                let cpu = Cpu::new(self.backend.threads)?;
                self.cpu = Some(Renderer::with_tree(cpu, scene.clone(), tree.clone())?);
            }
            return self.cpu.as_mut().map_or_else(lost, |r| measure(r, request, part, repeats, &self.stop));
        }
        let strict = arithmetic.or(self.backend.arithmetic) == Some(ArithmeticChoice::Strict);
        let place = if strict { &mut self.strict } else { &mut self.fast };
        if place.is_none() {
            let choice = if strict { ArithmeticChoice::Strict } else { ArithmeticChoice::Fast };
            let gpu = BackendOptions { arithmetic: Some(choice), ..self.backend.clone() }.gpu(choice)?;
            *place = Some(Renderer::with_tree(gpu, scene.clone(), tree.clone())?);
        }
        place.as_mut().map_or_else(lost, |r| measure(r, request, part, repeats, &self.stop))
    }

    /// Measures one frame, or several after one that warms up; a GPU's are always warm.
    pub(crate) fn measure_briefly(&mut self, request: &Request, warm: bool) -> Result<Measured, Failure> {
        let repeats = if warm { BRIEFLY } else { Repeats { most: u32::from(self.gpu), ..BRIEFLY } };
        self.measure_request(request, None, Parts::Whole, repeats)
    }

    /// The CPU backend with the threads that were asked for.
    pub(crate) fn cpu(&self) -> Result<Cpu, Failure> {
        Ok(Cpu::new(self.backend.threads)?)
    }

    /// Traces paths on the CPU: through whole pixels with a filter, or their centres, as the techniques see them.
    pub(crate) fn trace(
        &self,
        samples: u32,
        seed: u32,
        pixel_filter: bool,
        stop: &AtomicBool,
        progress: impl Fn(u32) + Send,
    ) -> Result<ReferenceResult, Failure> {
        let settings =
            Reference { bounces: Bounces::Count(1), samples, seed, emissive: self.emissive, pixel_filter };
        let cpu = self.cpu()?;
        let (scene, tree, view) = (&self.scene, &self.tree, &self.view);
        Ok(cpu.install(|| reference::render(scene, tree, view, &settings, stop, progress)))
    }

    /// Measures the path tracer: its paths go through whole pixels.
    pub(crate) fn measure_paths(&self, samples: u32, repeats: u32) -> Result<Measured, Failure> {
        let stop = &*self.stop;
        let mut times = Vec::new();
        // One path warms up.
        let mut result = self.trace(1, 999, true, stop, |_| ())?;
        for seed in 0..repeats.max(1) {
            let begun = Instant::now();
            result = self.trace(samples, 1000 + seed, true, stop, |_| ())?;
            times.push(begun.elapsed().as_secs_f64());
            if stop.load(Ordering::Relaxed) || times.iter().sum::<f64>() > LONG {
                break;
            }
        }
        if result.samples != samples {
            return Err(interrupted());
        }
        finite(&result.all(), "reference")?;
        let seconds = Spread::of(times);
        let (all, indirect) = (result.all(), Some(result.indirect));
        Ok(Measured { seconds, wall: seconds.median, camera: None, bytes: 0, indirect, all })
    }
}

/// A reference in two halves, of indirect and of all light.
pub(crate) struct Right {
    pub indirect: Halves,
    pub all: Halves,
}

impl Right {
    /// From two results of different seeds.
    pub(crate) fn new(one: &ReferenceResult, other: &ReferenceResult) -> Option<Self> {
        let indirect = Halves::new(one.indirect.clone(), other.indirect.clone())?;
        Some(Self { indirect, all: Halves::new(one.all(), other.all())? })
    }

    /// Blocks of pixels averaged.
    pub(crate) fn averaged(&self, side: u32) -> Self {
        Self { indirect: self.indirect.averaged(side), all: self.all.averaged(side) }
    }
}

fn lost<T>() -> Result<T, Failure> {
    Err(Failure::Work("no renderer".into()))
}

/// Refuses pictures that are none.
fn finite(picture: &Picture, technique: &str) -> Result<(), Failure> {
    if picture.pixels.iter().all(|p| p.is_finite()) {
        return Ok(());
    }
    Err(Failure::Work(format!("{technique}: pixels that are not finite; please report the scene")))
}

pub(crate) fn interrupted() -> Failure {
    Failure::Work("interrupted".into())
}

/// How indirect light is told from all light.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Parts {
    /// It is not.
    Whole,
    /// A picture of its own.
    Rendered,
    /// What direct light leaves.
    Subtracted,
}

/// Seconds of a frame's passes, or of the wall where the device tells nothing of its passes; those of the wall; the picture.
fn passes<B: Backend>(renderer: &mut Renderer<B>, plan: &Plan) -> Result<(f64, f64, Picture), Failure> {
    let begun = Instant::now();
    let frame = renderer.render(plan)?;
    let wall = begun.elapsed().as_secs_f64();
    let sum: f64 = frame.rendered.timings.iter().map(|t| t.nanoseconds * 1e-9).sum();
    Ok((if sum.is_finite() { sum } else { wall }, wall, frame.rendered.picture))
}

fn measure<B: Backend>(
    renderer: &mut Renderer<B>,
    request: &Request,
    parts: Parts,
    repeats: Repeats,
    stop: &AtomicBool,
) -> Result<Measured, Failure> {
    let plan = renderer.plan(request).map_err(|e| Failure::Request(e.to_string()))?;
    // The first frame warms up: pipelines are made, pages touched.
    renderer.forget();
    renderer.backend_mut().log_allocations(true);
    let warm = passes(renderer, &plan);
    let bytes = renderer.backend_mut().take_allocations().iter().map(|a| a.bytes).sum();
    renderer.backend_mut().log_allocations(false);
    let (seconds, wall, all) = warm?;
    // Where nothing is repeated it counts all the same.
    let (mut times, mut walls) =
        if repeats.most > 0 { (vec![], vec![]) } else { (vec![seconds], vec![wall]) };
    for _ in 0..repeats.most {
        if stop.load(Ordering::Relaxed) {
            return Err(interrupted());
        }
        renderer.forget();
        let (seconds, wall, _) = passes(renderer, &plan)?;
        times.push(seconds);
        walls.push(wall);
        if walls.iter().sum::<f64>() > repeats.until {
            break;
        }
    }
    let mut camera = None;
    if repeats.most > 0 && parts != Parts::Whole {
        renderer.touch(Change::Camera)?;
        camera = Some(passes(renderer, &plan)?.0);
    }
    let split = parts != Parts::Whole && plan.gathers();
    let indirect = if split { Some(indirect(renderer, request, parts, &all)?) } else { None };
    finite(&all, plan.technique.name())?;
    let wall = Spread::of(walls).median;
    Ok(Measured { seconds: Spread::of(times), wall, camera, bytes, indirect, all })
}

fn indirect<B: Backend>(
    renderer: &mut Renderer<B>,
    request: &Request,
    parts: Parts,
    all: &Picture,
) -> Result<Picture, Failure> {
    let mut request = request.clone();
    request.job.light = if parts == Parts::Rendered { LightPart::Indirect } else { LightPart::Direct };
    if parts == Parts::Subtracted {
        // Straight light is the same for all knobs of a technique.
        request.technique = Technique::Direct;
    }
    let plan = renderer.plan(&request).map_err(|e| Failure::Request(e.to_string()))?;
    let mut picture = renderer.render(&plan)?.rendered.picture;
    if parts == Parts::Subtracted {
        for (part, &whole) in picture.pixels.iter_mut().zip(&all.pixels) {
            *part = whole - *part;
        }
    }
    Ok(picture)
}
