//! `twinlight compare`: do both backends agree, pass by pass?

use super::knobs::Knobs;
use super::options::{ArithmeticChoice, BackendOptions, SceneOptions, build_tree};
use super::{Failure, print_out};
use crate::backend::{Arithmetic, PairBackend};
use crate::report::agreement::Agreement;
use crate::technique::layered_rsm::{self, LayeredRsm};
use crate::technique::{
    Job, LightPart, World, ambient_occlusion, direct, soft_gi, visibility_filter, voxel_cones,
};
use clap::Args;
use serde_json::json;

#[derive(Args)]
pub(crate) struct CompareArguments {
    #[command(flatten)]
    scene: SceneOptions,
    #[command(flatten)]
    backend: BackendOptions,
    #[command(flatten)]
    knobs: Knobs,
    /// Rays per pixel for the sky, emissive surfaces and occlusion
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u32).range(1..=65_536))]
    samples: u32,
    /// Seed of random numbers
    #[arg(long, default_value_t = 1)]
    seed: u32,
    /// Print the table as one JSON object
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(a: &CompareArguments) -> Result<(), Failure> {
    a.knobs.check_all()?;
    let (scene, view) = a.scene.open()?;
    let cpu = a.backend.cpu()?;
    let tree = cpu.install(|| build_tree(&scene))?;
    let gpu = a.backend.gpu(ArithmeticChoice::Strict)?;
    let strict = a.backend.arithmetic != Some(ArithmeticChoice::Fast);
    let name = twinlight_gpu::describe(gpu.adapter());
    let mode = if strict { Arithmetic::Strict } else { Arithmetic::Fast };
    let variant = gpu.variant();
    let mut pair = PairBackend::new(cpu, gpu);
    let world = World::upload(&mut pair, &scene, &tree, a.scene.emissive)?;
    let job = Job { rays: a.samples, seed: a.seed, ..Job::default() };
    direct::render(&mut pair, &world, &view, &job)?;
    let with_discs = Job { dumps: vec!["proxies".into()], ..job.clone() };
    visibility_filter::render(&mut pair, &world, &view, &with_discs, &a.knobs.visibility_filter())?;
    voxel_cones::render(&mut pair, &world, &view, &job, &a.knobs.voxel_cones())?;
    let around = soft_gi::Surroundings::new(&scene);
    soft_gi::render(&mut pair, &world, &around, &view, &job, &a.knobs.soft_gi())?;
    let layered = a.knobs.layered_rsm();
    layered_rsm::render(&mut pair, &world, &view, &job, &layered)?;
    let soft_shadows = LayeredRsm { shadow_cones: true, ..layered };
    let direct_only = Job { light: LightPart::Direct, ..job.clone() };
    layered_rsm::render(&mut pair, &world, &view, &direct_only, &soft_shadows)?;
    ambient_occlusion::render(&mut pair, &world, &view, &job)?;
    let agreements = pair.take_agreements();
    let holds = |x: &Agreement| if strict { x.is_exact() } else { x.is_tolerable() };
    if a.json {
        let rows: Vec<_> = agreements
            .iter()
            .map(|x| {
                json!({ "pass": x.pass, "elements": x.elements, "different": x.different, "beyond": x.beyond,
                    "max_ulp": finite(x.max_ulp), "max_relative": finite(x.max_relative), "holds": holds(x) })
            })
            .collect();
        print_out(&format!(
            "{}\n",
            json!({ "adapter": name, "arithmetic": format!("{mode:?}"), "passes": rows })
        ))?;
    } else {
        print_out(&text(&agreements, &format!("cpu against {name}, {variant:?}\n"), holds))?;
    }
    match agreements.iter().find(|x| !holds(x)) {
        None => Ok(()),
        Some(x) => Err(Failure::Work(format!(
            "pass {} differs beyond {}: {}",
            x.pass,
            if strict { "equal bits" } else { "its tolerance" },
            x.first.clone().unwrap_or_default()
        ))),
    }
}

/// A number as JSON can hold it.
fn finite(x: f64) -> serde_json::Value {
    if x.is_finite() { json!(x) } else { json!("infinite") }
}

fn text(agreements: &[Agreement], head: &str, holds: impl Fn(&Agreement) -> bool) -> String {
    let mut text = head.to_owned();
    text += &format!(
        "{:<20} {:>10} {:>10} {:>10} {:>10} {:>12} {:>6}\n",
        "pass", "elements", "different", "beyond", "max ULP", "max relative", "holds"
    );
    for x in agreements {
        text += &format!(
            "{:<20} {:>10} {:>10} {:>10} {:>10} {:>12.3e} {:>6}\n",
            x.pass,
            x.elements,
            x.different,
            x.beyond,
            x.max_ulp,
            x.max_relative,
            if holds(x) { "yes" } else { "NO" }
        );
    }
    text
}
