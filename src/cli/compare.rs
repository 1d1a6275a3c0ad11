//! `twinlight compare`: do both backends agree, pass by pass?

use super::knobs::Knobs;
use super::options::{ArithmeticChoice, BackendOptions, SceneOptions, build_tree};
use super::{Failure, print_out};
use crate::backend::{Arithmetic, PairBackend};
use crate::plan::{Request, Technique};
use crate::renderer::Renderer;
use crate::report::agreement::Agreement;
use crate::technique::layered_rsm::LayeredRsm;
use crate::technique::{Job, LightPart, View};
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
    let mut renderer = Renderer::with_tree(PairBackend::new(cpu, gpu), scene, tree)?;
    for request in requests(a, &view) {
        let plan = renderer.plan(&request).map_err(|e| Failure::Request(e.to_string()))?;
        renderer.render(&plan)?;
    }
    let agreements = renderer.backend_mut().take_agreements();
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

/// A picture by every technique, and what else has passes of its own.
fn requests(a: &CompareArguments, view: &View) -> Vec<Request> {
    let job = Job { rays: a.samples, seed: a.seed, ..Job::default() };
    let with_discs = Job { dumps: vec!["proxies".into()], ..job.clone() };
    let direct = Job { light: LightPart::Direct, ..job.clone() };
    let soft_shadows = LayeredRsm { shadow_cones: true, ..a.knobs.layered_rsm() };
    let of = |technique, job: &Job| Request {
        emissive: a.scene.look.emissive,
        ..Request::new(technique, *view, job.clone())
    };
    vec![
        of(Technique::Direct, &job),
        of(Technique::VisibilityFilter(a.knobs.visibility_filter()), &with_discs),
        of(Technique::VoxelCones(a.knobs.voxel_cones()), &job),
        of(Technique::SoftGi(a.knobs.soft_gi()), &job),
        of(Technique::LayeredRsm(a.knobs.layered_rsm()), &job),
        of(Technique::LayeredRsm(soft_shadows), &direct),
        of(Technique::AmbientOcclusion, &job),
    ]
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
