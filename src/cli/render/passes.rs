//! `twinlight render` by a technique of passes, on either backend.

use super::arguments::{Only, RenderArguments, Technique};
use super::{Outcome, name};
use crate::backend::{Backend, Cpu, Gpu};
use crate::cli::options::ArithmeticChoice;
use crate::cli::{Failure, table};
use crate::plan::{self, Effect, Plan, Request};
use crate::renderer::{Counts, Frame, Renderer};
use crate::scene::{Scene, bvh::Bvh};
use crate::technique::visibility_filter;
use crate::technique::{Job, LightPart, Rendered, View};
use serde_json::json;

/// A renderer that outlives a picture.
pub(super) enum Running {
    Cpu(Box<Renderer<Cpu>>),
    Gpu(Box<Renderer<Gpu>>),
}

/// What the options ask of a technique.
pub(super) fn request(a: &RenderArguments, technique: Technique, view: &View) -> Result<Request, Failure> {
    let technique = match technique {
        Technique::VisibilityFilter => plan::Technique::VisibilityFilter(a.knobs.visibility_filter()),
        Technique::VoxelCones => plan::Technique::VoxelCones(a.knobs.voxel_cones()),
        Technique::SoftGi => plan::Technique::SoftGi(a.knobs.soft_gi()),
        Technique::LayeredRsm => plan::Technique::LayeredRsm(a.knobs.layered_rsm()),
        Technique::AmbientOcclusion => plan::Technique::AmbientOcclusion,
        Technique::Direct => plan::Technique::Direct,
        Technique::Auto | Technique::Reference => {
            return Err(Failure::Request(format!("--technique {}: it has no passes", name(technique))));
        }
    };
    let job = Job {
        rays: a.samples,
        seed: a.seed,
        falloff: a.falloff,
        reach: a.reach,
        light: a.only.light(),
        upsampling: a.upsampling.kind(),
        dumps: a.dump.clone(),
        check_finite: a.check_finite,
    };
    let effects = a.effects.as_ref().map(|names| names.iter().map(|n| of_name(n)).collect()).transpose()?;
    Ok(Request {
        emissive: a.scene.look.emissive,
        effects,
        quality: a.quality,
        ..Request::new(technique, *view, job)
    })
}

fn of_name(name: &str) -> Result<Effect, Failure> {
    Effect::of_name(name).ok_or_else(|| {
        let all: Vec<_> = Effect::ALL.iter().map(|e| e.name()).collect();
        Failure::Request(format!("--effects {name}: there are {}", all.join(", ")))
    })
}

impl Only {
    pub(super) fn light(self) -> LightPart {
        match self {
            Self::All => LightPart::All,
            Self::Direct => LightPart::Direct,
            Self::Indirect => LightPart::Indirect,
        }
    }
}

impl Running {
    /// Starts on the machine that the options name.
    fn start(a: &RenderArguments, cpu: Cpu, scene: Scene, tree: Bvh) -> Result<Self, Failure> {
        Ok(if a.machine.is_gpu() {
            let gpu = a.backend.gpu(ArithmeticChoice::Fast)?;
            Self::Gpu(Box::new(Renderer::with_tree(gpu, scene, tree)?))
        } else {
            Self::Cpu(Box::new(Renderer::with_tree(cpu, scene, tree)?))
        })
    }
}

/// Renders a scene with what earlier frames left, and tells what changed since.
pub(super) fn run(
    a: &RenderArguments,
    technique: Technique,
    running: &mut Option<Running>,
    scene: Scene,
    view: &View,
) -> Result<Outcome, Failure> {
    let request = request(a, technique, view)?;
    let mut changes = Vec::new();
    if let Some(running) = running {
        changes = match running {
            Running::Cpu(renderer) => renderer.update(scene)?,
            Running::Gpu(renderer) => renderer.update(scene)?,
        };
    } else {
        let cpu = a.backend.cpu()?;
        let tree = cpu.install(|| crate::cli::options::build_tree(&scene))?;
        *running = Some(Running::start(a, cpu, scene, tree)?);
    }
    match running {
        Some(Running::Cpu(renderer)) => {
            let machine = format!("cpu, {} threads", renderer.backend().threads());
            draw(a, renderer, &request, &machine, changes)
        }
        Some(Running::Gpu(renderer)) => {
            let gpu = renderer.backend();
            let machine = format!("gpu, {}, {:?}", twinlight_gpu::describe(gpu.adapter()), gpu.variant());
            draw(a, renderer, &request, &machine, changes)
        }
        None => Err(Failure::Work("no renderer".into())),
    }
}

fn draw<B: Backend>(
    a: &RenderArguments,
    renderer: &mut Renderer<B>,
    request: &Request,
    machine: &str,
    changes: Vec<plan::Change>,
) -> Result<Outcome, Failure> {
    let plan = match a.budget {
        None => renderer.plan(request).map_err(|e| Failure::Request(e.to_string()))?,
        Some(budget) => {
            let (plan, expected) = renderer.plan_within(request, budget)?;
            if !a.quiet {
                let kept: Vec<_> = plan.effects().iter().map(|e| e.name()).collect();
                let ms = expected.as_secs_f64() * 1e3;
                eprintln!("note: for {ms:.1} ms of passes, by two trials: {}", kept.join(", "));
            }
            plan
        }
    };
    if !a.quiet {
        note_missing(&plan, renderer.scene());
    }
    let Frame { rendered, counts } = renderer.render(&plan)?;
    outcome(a, machine, &plan, rendered, counts, changes)
}

fn outcome(
    a: &RenderArguments,
    machine: &str,
    plan: &Plan,
    rendered: Rendered,
    counts: Counts,
    changes: Vec<plan::Change>,
) -> Result<Outcome, Failure> {
    refuse_non_finite(&rendered)?;
    for name in a.dump.iter().filter(|name| !a.quiet && !rendered.dumps.contains_key(*name)) {
        eprintln!("note: --dump {name}: nothing of the kind was computed for this scene and request");
    }
    let mean = rendered.picture.mean();
    let technique = camel(plan.technique.name());
    let mut text = format!("{technique} on {machine}\n{}", table::passes_text(&rendered.timings));
    text += &counts_text(&counts);
    text += &format!("mean {:.5} {:.5} {:.5}\n", mean.x, mean.y, mean.z);
    if a.check_finite {
        text += &format!("non-finite values: 0 in {} buffers\n", rendered.non_finite.len());
    }
    let json = json!({
        "technique": technique,
        "machine": machine,
        "effects": plan.effects().iter().map(|e| e.name()).collect::<Vec<_>>(),
        "passes": table::passes_json(&rendered.timings),
        "stages": table::stages_json(&rendered.timings),
        "counts": counts_json(&counts),
        "mean": mean.to_array(),
    });
    Ok(Outcome {
        picture: rendered.picture,
        report: text,
        json,
        dumps: rendered.dumps.into_iter().collect(),
        interrupted: false,
        ran: rendered.timings,
        changes,
    })
}

/// `voxel-cones` as `VoxelCones`.
fn camel(name: &str) -> String {
    let word = |w: &str| {
        let mut letters = w.chars();
        letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).collect())
    };
    name.split('-').map(word).collect()
}

/// Says what the technique has nothing to do without.
fn note_missing(plan: &Plan, scene: &Scene) {
    let lights = &scene.lights;
    match plan.technique {
        plan::Technique::LayeredRsm(_) if lights.is_empty() => eprintln!(
            "note: no point, spot or sun light, and layered maps pass on no other; give --point, --spot or --sun"
        ),
        plan::Technique::SoftGi(_) => {
            if !scene.environment.is_lit() {
                eprintln!("note: no light from the surroundings; give --sky, --daylight or --environment");
            }
            if scene.proxies.is_empty() {
                eprintln!("note: the scene has no spherical proxies; give --sphere or --fit-spheres");
            }
        }
        _ => {}
    }
}

/// Fails if some buffer was found not to be finite.
fn refuse_non_finite(rendered: &Rendered) -> Result<(), Failure> {
    let bad: Vec<String> = rendered
        .non_finite
        .iter()
        .filter(|n| n.count > 0)
        .map(|n| format!("{} in {}", n.count, n.buffer))
        .collect();
    if bad.is_empty() {
        return Ok(());
    }
    Err(Failure::Work(format!("non-finite values: {}; please report the scene", bad.join(", "))))
}

fn counts_text(counts: &Counts) -> String {
    let mib = |bytes: u64| bytes as f64 / 1_048_576.0;
    match counts {
        Counts::Nothing => String::new(),
        Counts::VisibilityFilter(c) => proxies_text(c),
        Counts::VoxelCones(c) => {
            format!(
                "{} leaves, {} voxels, {} of them lit, {:.1} MiB\n",
                c.leaves,
                c.voxels,
                c.lit,
                mib(c.bytes)
            )
        }
        Counts::SoftGi(c) => format!(
            "{} proxies, {} receivers, {} pairs of them, shadows to {:.1} radii\n",
            c.proxies, c.receivers, c.pairs, c.shadow_reach
        ),
        Counts::LayeredRsm(c) => format!(
            "{}^3 binary voxels {:.1} MiB, layers of {} lights {:.1} MiB, a map {:.1} MiB\n",
            c.resolution,
            mib(c.voxel_bytes),
            c.lights,
            mib(c.layer_bytes),
            mib(c.map_bytes)
        ),
    }
}

fn proxies_text(c: &visibility_filter::Counts) -> String {
    let mut text =
        format!("{} proxies, {} in overlapped cells, lists of {} voxels\n", c.proxies, c.pairs, c.capacity);
    if c.full_lists > 0 {
        text += &format!(
            "{} lists had no room for {} voxels in all: raise --list-capacity or lower --grid\n",
            c.full_lists, c.dropped
        );
    }
    text
}

fn counts_json(counts: &Counts) -> serde_json::Value {
    match counts {
        Counts::Nothing => serde_json::Value::Null,
        Counts::VisibilityFilter(c) => json!({ "proxies": c.proxies, "pairs": c.pairs,
            "list_capacity": c.capacity, "full_lists": c.full_lists, "dropped_voxels": c.dropped }),
        Counts::VoxelCones(c) => {
            json!({ "leaves": c.leaves, "voxels": c.voxels, "lit": c.lit, "bytes": c.bytes })
        }
        Counts::SoftGi(c) => json!({ "proxies": c.proxies, "receivers": c.receivers, "pairs": c.pairs,
            "shadow_reach": c.shadow_reach }),
        Counts::LayeredRsm(c) => json!({ "resolution": c.resolution, "voxel_bytes": c.voxel_bytes,
            "lights": c.lights, "lights_at_once": c.lights_at_once, "map_bytes": c.map_bytes,
            "layer_bytes": c.layer_bytes }),
    }
}
