//! Which approximation of a technique costs how much error?

use super::measure::{Right, Subject};
use super::record::{Attribution, SceneRecord};
use super::run::Session;
use super::sweep::{STAGES, Trial};
use crate::backend::Cpu;
use crate::cli::Failure;
use crate::cli::render::request_of;
use crate::plan::Technique;
use crate::report::halves::Errors;
use crate::technique::World;
use crate::technique::reference::stages::{Exact, Stages};
use std::sync::atomic::Ordering;

/// Directions from each pixel's centre, of either of two sets.
const DIRECTIONS: u32 = 16;

/// What cones leave out, taken away by rays: what becomes exact, and what stands in its place.
const BY_RAYS: [(Exact, &str, &str); 3] = [
    (Exact::Nothing, "set of cones", "cones in any number of directions"),
    (Exact::Visibility, "visibility", "rays to the triangles; what they meet sends what cones find there"),
    (Exact::Radiance, "radiance of what is met", "that of what rays meet; cones say whether"),
];

/// Replaces a stage at a time by its exact counterpart, for all techniques whose defaults are in the record.
pub(super) fn attribute(
    session: &Session<'_>,
    subject: &mut Subject,
    scene: &mut SceneRecord,
    right: &Right,
) -> Result<(), Failure> {
    let coarse = right.averaged(session.a.block);
    let right = if scene.axis == "all" { &coarse.all } else { &coarse.indirect };
    let bases: Vec<_> = scene
        .points
        .iter()
        .filter(|p| p.knob.is_empty())
        .filter_map(|p| Some((p.technique.clone(), scene.error(p)?)))
        .collect();
    let mut out = Vec::new();
    for (technique, before) in bases {
        let known = |name: &str| {
            let same = |x: &&Attribution| x.technique == technique && x.stage == name;
            scene.attribution.iter().find(same).cloned()
        };
        let row = |stage: &str, exact: &str, settings: String, e: Errors| Attribution {
            technique: technique.clone(),
            stage: stage.into(),
            exact: exact.into(),
            settings,
            before,
            relative_rmse: e.relative_rmse,
            mean_ratio: e.mean_ratio,
            share: 1.0 - (e.relative_rmse / before).powi(2),
        };
        for stage in STAGES.iter().filter(|s| s.technique == technique) {
            if let Some(known) = known(stage.name) {
                out.push(known);
                continue;
            }
            if session.stop.load(Ordering::Relaxed) {
                return Err(session.interrupted());
            }
            let trial = stage.trial(scene.size);
            if session.late() {
                continue;
            }
            let measured = match session.measure_once(subject, &trial) {
                Err(Failure::Request(_)) => continue,
                other => other?,
            };
            let picture = if scene.axis == "all" { Some(measured.all) } else { measured.indirect };
            let Some(picture) = picture.map(|p| p.averaged(session.a.block)) else { continue };
            out.extend(right.errors(&picture).map(|e| row(stage.name, stage.exact, trial.settings(), e)));
        }
        let rays = scene.axis == "indirect" && !subject.scene.census().has_gloss;
        if !rays || known(BY_RAYS[0].1).is_some() {
            out.extend(BY_RAYS.iter().filter_map(|(_, name, _)| known(name)));
            continue;
        }
        for (exact, name, instead) in BY_RAYS {
            if session.late() {
                continue;
            }
            let Some((one, other)) = by_rays(subject, &technique, exact)? else { break };
            let (one, other) = (one.averaged(session.a.block), other.averaged(session.a.block));
            out.extend(right.errors_of_two(&one, &other).map(|e| row(name, instead, String::new(), e)));
        }
    }
    scene.attribution = out;
    Ok(())
}

/// Two pictures of independent directions; `None` for techniques without cones.
fn by_rays(
    subject: &Subject,
    technique: &str,
    exact: Exact,
) -> Result<Option<(crate::picture::Picture, crate::picture::Picture)>, Failure> {
    let known = super::sweep::SWEEPS.iter().find(|s| s.technique == technique);
    let Some(technique) = known.map(|s| s.technique) else { return Ok(None) };
    let trial = Trial { technique, knob: "", value: String::new(), words: Vec::new() };
    let request = request_of(&subject.arguments(&trial)?, &subject.view)?;
    let mut cpu = Cpu::new(None)?;
    let world = World::upload(&mut cpu, &subject.scene, &subject.tree, subject.emissive)?;
    let stages = match &request.technique {
        Technique::VoxelCones(s) => Stages::voxel_cones(&mut cpu, &world, s)?,
        Technique::LayeredRsm(s) => Stages::layered_rsm(&mut cpu, &world, s)?,
        _ => return Ok(None),
    };
    let (scene, tree, view) = (&subject.scene, &subject.tree, &subject.view);
    let of = |seed| stages.render(scene, tree, view, exact, DIRECTIONS, seed);
    Ok(Some(cpu.install(|| (of(101), of(202)))))
}
