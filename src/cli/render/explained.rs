//! How is a plan shown?

use crate::plan::{Costs, Plan};
use crate::scene::Scene;
use serde_json::{Value, json};

/// What moves in a scene.
#[derive(Clone, Copy)]
pub(super) struct Motion {
    meshes: bool,
    lights: bool,
}

impl Motion {
    /// What is elsewhere at a second moment.
    pub(super) fn between(before: &Scene, after: &Scene) -> Self {
        Self { meshes: before.triangles != after.triangles, lights: before.lights != after.lights }
    }

    pub(super) fn any(self) -> bool {
        self.meshes || self.lights
    }

    fn text(self) -> &'static str {
        match (self.meshes, self.lights) {
            (true, true) => "meshes and lights move",
            (true, false) => "meshes move",
            (false, true) => "lights move",
            (false, false) => "nothing moves",
        }
    }
}

/// What the scene has, as text.
pub(super) fn census(scene: &Scene, motion: Motion) -> String {
    let c = scene.census();
    let environment = if c.has_environment { "surroundings that shine" } else { "dark surroundings" };
    format!(
        "{}: {} triangles, {} materials; {} point, {} spot and {} sun lights, {environment}; {:.1} % glossy, {:.2} % emissive{}; \
         albedo up to {:.2}, lobes up to {:.2}; {} proxies; {}\n",
        scene.name,
        c.triangles,
        c.materials,
        c.points,
        c.spots,
        c.suns,
        100.0 * c.glossy_share,
        100.0 * c.emissive_share,
        if c.has_masked { ", some with holes" } else { "" },
        c.largest_albedo,
        c.largest_specular,
        c.proxies,
        motion.text()
    )
}

/// All of it as JSON.
pub(super) fn json(scene: &Scene, motion: Motion, plan: &Plan, costs: &Costs, reason: Option<&str>) -> Value {
    let c = scene.census();
    let passes = |list: &[twinlight_kernels::passes::PassTiming]| -> Value {
        list.iter()
            .map(|p| json!({ "stage": p.stage, "pass": p.pass, "items": p.items, "bytes": p.bytes }))
            .collect()
    };
    let effects: Vec<Value> = plan
        .decisions
        .iter()
        .map(|d| {
            json!({ "effect": d.effect.name(), "called": d.called, "why": d.why,
                "bound": d.bound.map(|b| b.share), "bound_of": d.bound.map(|b| b.of) })
        })
        .collect();
    let buffers: Vec<Value> = costs
        .buffers
        .iter()
        .map(|b| json!({ "stage": b.stage, "buffer": b.label, "bytes": b.bytes }))
        .collect();
    let again: Vec<Value> = costs
        .again
        .iter()
        .map(|(change, list)| json!({ "change": change.name(), "passes": passes(list) }))
        .collect();
    json!({
        "scene": { "name": scene.name, "triangles": c.triangles, "materials": c.materials, "points": c.points,
            "spots": c.spots, "suns": c.suns, "environment": c.has_environment, "glossy_share": c.glossy_share,
            "emissive_share": c.emissive_share, "albedo": c.largest_albedo, "lobe": c.largest_specular,
            "proxies": c.proxies, "meshes_move": motion.meshes, "lights_move": motion.lights },
        "technique": plan.technique.name(),
        "auto": reason,
        "effects": effects,
        "passes": passes(&costs.passes),
        "pipelines": costs.pipelines(),
        "buffers": buffers,
        "bytes": costs.bytes(),
        "again": again,
    })
}
