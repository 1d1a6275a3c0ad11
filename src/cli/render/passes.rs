//! `twinlight render` by a technique of passes, on either backend.

use super::{Machine, Only, Outcome, RenderArguments, Technique};
use crate::backend::{Backend, Cpu, Gpu};
use crate::cli::options::ArithmeticChoice;
use crate::cli::{Failure, table};
use crate::scene::{Scene, bvh::Bvh};
use crate::technique::visibility_filter::Counts;
use crate::technique::{
    Job, LightPart, Rendered, View, World, ambient_occlusion, direct, layered_rsm, soft_gi,
    visibility_filter, voxel_cones,
};
use serde_json::json;

pub(super) fn run(
    a: &RenderArguments,
    technique: Technique,
    mut cpu: Cpu,
    opened: &mut Option<Gpu>,
    scene: &Scene,
    tree: &Bvh,
    view: &View,
) -> Result<Outcome, Failure> {
    let gpu = match a.machine {
        Machine::Cpu => false,
        Machine::Gpu => true,
        Machine::Auto => {
            use twinlight_gpu::wgpu::DeviceType;
            twinlight_gpu::adapters().iter().any(|x| {
                matches!(x.get_info().device_type, DeviceType::DiscreteGpu | DeviceType::IntegratedGpu)
            })
        }
    };
    if gpu {
        let gpu = match opened {
            Some(gpu) => gpu,
            None => opened.insert(a.backend.gpu(ArithmeticChoice::Fast)?),
        };
        let name = format!("gpu, {}, {:?}", twinlight_gpu::describe(gpu.adapter()), gpu.variant());
        draw(a, technique, gpu, scene, tree, view, &name)
    } else {
        let name = format!("cpu, {} threads", cpu.threads());
        draw(a, technique, &mut cpu, scene, tree, view, &name)
    }
}

fn draw<B: Backend>(
    a: &RenderArguments,
    technique: Technique,
    backend: &mut B,
    scene: &Scene,
    tree: &Bvh,
    view: &View,
    machine: &str,
) -> Result<Outcome, Failure> {
    let world = World::upload(backend, scene, tree, a.scene.emissive)?;
    let job = Job {
        rays: a.samples,
        seed: a.seed,
        falloff: a.falloff,
        reach: a.reach,
        light: match a.only {
            Only::All => LightPart::All,
            Only::Direct => LightPart::Direct,
            Only::Indirect => LightPart::Indirect,
        },
        dumps: a.dump.clone(),
        check_finite: a.check_finite,
    };
    let rendered: Rendered;
    let (mut counts, mut counts_line) = (serde_json::Value::Null, String::new());
    match technique {
        Technique::AmbientOcclusion => rendered = ambient_occlusion::render(backend, &world, view, &job)?,
        Technique::VisibilityFilter => {
            let settings = a.knobs.visibility_filter();
            let (picture, counted) = visibility_filter::render(backend, &world, view, &job, &settings)?;
            rendered = picture;
            (counts, counts_line) = (counts_json(&counted), counts_text(&counted));
        }
        Technique::VoxelCones => {
            let settings = a.knobs.voxel_cones();
            let (picture, counted) = voxel_cones::render(backend, &world, view, &job, &settings)?;
            rendered = picture;
            (counts, counts_line) = (voxels_json(&counted), voxels_text(&counted));
        }
        Technique::LayeredRsm => {
            let settings = a.knobs.layered_rsm();
            if !a.quiet && world.light_count == 0 {
                eprintln!(
                    "note: no point, spot or sun light, and layered maps pass on no other; give --point, --spot or --sun"
                );
            }
            let (picture, c) = layered_rsm::render(backend, &world, view, &job, &settings)?;
            rendered = picture;
            counts = json!({ "resolution": c.resolution, "voxel_bytes": c.voxel_bytes, "lights": c.lights,
                "lights_at_once": c.lights_at_once, "map_bytes": c.map_bytes, "layer_bytes": c.layer_bytes });
            let mib = |bytes: u64| bytes as f64 / 1_048_576.0;
            counts_line = format!(
                "{}^3 binary voxels {:.1} MiB, layers of {} lights {:.1} MiB, a map {:.1} MiB\n",
                c.resolution,
                mib(c.voxel_bytes),
                c.lights,
                mib(c.layer_bytes),
                mib(c.map_bytes)
            );
        }
        Technique::SoftGi => {
            let around = soft_gi::Surroundings::new(scene);
            note_missing(a, &world, &around);
            let settings = a.knobs.soft_gi();
            let (picture, c) = soft_gi::render(backend, &world, &around, view, &job, &settings)?;
            rendered = picture;
            counts = json!({ "proxies": c.proxies, "receivers": c.receivers, "pairs": c.pairs, "shadow_reach": c.shadow_reach });
            counts_line = format!(
                "{} proxies, {} receivers, {} pairs of them, shadows to {:.1} radii\n",
                c.proxies, c.receivers, c.pairs, c.shadow_reach
            );
        }
        _ => rendered = direct::render(backend, &world, view, &job)?,
    }
    refuse_non_finite(&rendered)?;
    for name in a.dump.iter().filter(|name| !a.quiet && !rendered.dumps.contains_key(*name)) {
        eprintln!("note: --dump {name}: nothing of the kind was computed for this scene and request");
    }
    let mean = rendered.picture.mean();
    let mut text = format!("{technique:?} on {machine}\n{}", table::passes_text(&rendered.timings));
    text += &counts_line;
    text += &format!("mean {:.5} {:.5} {:.5}\n", mean.x, mean.y, mean.z);
    if a.check_finite {
        text += &format!("non-finite values: 0 in {} buffers\n", rendered.non_finite.len());
    }
    let json = json!({
        "technique": format!("{technique:?}"),
        "machine": machine,
        "passes": table::passes_json(&rendered.timings),
        "stages": table::stages_json(&rendered.timings),
        "counts": counts,
        "mean": mean.to_array(),
    });
    Ok(Outcome {
        picture: rendered.picture,
        report: text,
        json,
        dumps: rendered.dumps.into_iter().collect(),
        interrupted: false,
    })
}

/// Says what soft global illumination has nothing to do without.
fn note_missing<B: Backend>(a: &RenderArguments, world: &World<B>, around: &soft_gi::Surroundings) {
    if a.quiet {
        return;
    }
    if !world.has_environment {
        eprintln!("note: no light from the surroundings; give --sky, --daylight or --environment");
    }
    if around.proxies.is_empty() {
        eprintln!("note: the scene has no spherical proxies; give --sphere or --fit-spheres");
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

fn counts_text(c: &Counts) -> String {
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

fn voxels_text(c: &voxel_cones::Counts) -> String {
    format!(
        "{} leaves, {} voxels, {} of them lit, {:.1} MiB\n",
        c.leaves,
        c.voxels,
        c.lit,
        c.bytes as f64 / 1_048_576.0
    )
}

fn voxels_json(c: &voxel_cones::Counts) -> serde_json::Value {
    json!({ "leaves": c.leaves, "voxels": c.voxels, "lit": c.lit, "bytes": c.bytes })
}

fn counts_json(c: &Counts) -> serde_json::Value {
    json!({ "proxies": c.proxies, "pairs": c.pairs, "list_capacity": c.capacity,
        "full_lists": c.full_lists, "dropped_voxels": c.dropped })
}
