//! Which approximation of a technique costs how much error?

use super::measure::{Right, Subject};
use super::record::{Attribution, Record};
use super::run::Session;
use super::sweep::{STAGES, Stage, Trial};
use crate::backend::Cpu;
use crate::cli::Failure;
use crate::cli::render::request_of;
use crate::plan::Technique;
use crate::report::halves::Errors;
use crate::technique::World;
use crate::technique::reference::stages::{Exact, Stages};
use std::sync::atomic::Ordering;

/// Directions from each pixel's centre, of either of two sets.
const DIRECTIONS: u32 = 32;

/// What rays stand for: what becomes exact, its name, and what stands in its place.
type ByRays = (Exact, &'static str, &'static str);

const CONES: &str = "set of cones";
const BY_RAYS: [ByRays; 4] = [
    (Exact::Nothing, CONES, "cones in any direction, at every pixel"),
    (Exact::Visibility, "visibility", "rays to the triangles; what they meet sends what cones find there"),
    (Exact::Radiance, "radiance of what is met", "that of what rays meet; cones say whether"),
    (Exact::Both, "visibility and radiance", "rays alone: what pixel centres leave"),
];

/// A stage in some way made exact.
enum Way {
    Settings(&'static Stage),
    Rays(ByRays),
}

impl Way {
    fn name(&self) -> &'static str {
        match self {
            Self::Settings(stage) => stage.name,
            Self::Rays((_, name, _)) => name,
        }
    }
}

/// Replaces a stage at a time by its exact counterpart, for all techniques whose defaults are in the record.
pub(super) fn attribute(
    session: &Session<'_>,
    subject: &mut Subject,
    record: &mut Record,
    index: usize,
    right: &Right,
) -> Result<(), Failure> {
    let coarse = right.averaged(session.a.block);
    let scene = &record.scenes[index];
    let defaults = scene.points.iter().filter(|p| p.knob.is_empty());
    let bases: Vec<_> = defaults.filter_map(|p| Some((p.technique.clone(), scene.error(p)?))).collect();
    let gloss = subject.scene.census().has_gloss;
    // Rays know lights without extent, and diffuse surfaces.
    let rays = scene.axis == "indirect" && !gloss && !subject.splits();
    for (technique, base) in bases {
        let settings = STAGES.iter().filter(|s| s.technique == technique && !(gloss && s.diffuse));
        let ways = settings.map(Way::Settings);
        let ways = ways.chain(BY_RAYS.into_iter().filter(|_| rays).map(Way::Rays));
        let mut stages = None;
        for way in ways {
            let attribution = &record.scenes[index].attribution;
            let found = |name: &str| attribution.iter().find(|x| x.technique == technique && x.stage == name);
            if found(way.name()).is_some() {
                continue;
            }
            if session.stop.load(Ordering::Relaxed) {
                return Err(session.interrupted());
            }
            if session.late() {
                return Ok(());
            }
            let row = match way {
                Way::Settings(stage) => by_settings(session, subject, record, index, &coarse, stage, base)?,
                Way::Rays(way) => {
                    if stages.is_none() {
                        stages = taken_apart(subject, &technique)?;
                    }
                    let Some((cpu, stages)) = &stages else { break };
                    // Directions at every pixel are a change of their own: what they leave comes before.
                    let before = found(CONES).map_or(base, |x| x.relative_rmse);
                    let (scene, tree, view) = (&subject.scene, &subject.tree, &subject.view);
                    let of = |seed| stages.render(scene, tree, view, way.0, DIRECTIONS, seed);
                    let (one, other) = cpu.install(|| (of(101), of(202)));
                    let side = session.a.block;
                    let errors = coarse.indirect.errors_of_two(&one.averaged(side), &other.averaged(side));
                    errors.map(|e| row(&technique, (way.1, way.2), String::new(), before, e))
                }
            };
            let all = &mut record.scenes[index].attribution;
            all.extend(row);
            all.sort_by_key(|x| STAGES.iter().position(|s| s.technique == x.technique));
            session.save(record)?;
        }
    }
    Ok(())
}

fn row(
    technique: &str,
    (stage, exact): (&str, &str),
    settings: String,
    before: f64,
    e: Errors,
) -> Attribution {
    let after = e.told();
    Attribution {
        technique: technique.into(),
        stage: stage.into(),
        exact: exact.into(),
        settings,
        before,
        relative_rmse: e.relative_rmse,
        resolution: e.resolution,
        mean_ratio: e.mean_ratio,
        share: (before > 0.0).then(|| 1.0 - (after / before).powi(2)),
    }
}

fn by_settings(
    session: &Session<'_>,
    subject: &mut Subject,
    record: &Record,
    index: usize,
    coarse: &Right,
    stage: &Stage,
    before: f64,
) -> Result<Option<Attribution>, Failure> {
    let scene = &record.scenes[index];
    let trial = stage.trial(scene.size);
    let Some(measured) = session.measure_once(subject, &trial)? else { return Ok(None) };
    let all = scene.axis == "all";
    let picture = if all { Some(measured.all) } else { measured.indirect };
    let right = if all { &coarse.all } else { &coarse.indirect };
    let errors = picture.and_then(|p| right.errors(&p.averaged(session.a.block)));
    let what = (stage.name, stage.exact);
    Ok(errors.map(|e| row(stage.technique, what, trial.settings(), before, e)))
}

/// A technique of cones, to be taken apart; `None` for others.
fn taken_apart(subject: &Subject, technique: &str) -> Result<Option<(Cpu, Stages)>, Failure> {
    let known = super::sweep::SWEEPS.iter().find(|s| s.technique == technique);
    let Some(technique) = known.map(|s| s.technique) else { return Ok(None) };
    if !matches!(technique, "voxel-cones" | "layered-rsm") {
        return Ok(None);
    }
    let trial = Trial { technique, knob: "", value: String::new(), words: Vec::new() };
    let request = request_of(&subject.arguments(&trial)?, &subject.view)?;
    let mut cpu = subject.cpu()?;
    let world = World::upload(&mut cpu, &subject.scene, &subject.tree, subject.emissive)?;
    let stages = match &request.technique {
        Technique::VoxelCones(s) => Stages::voxel_cones(&mut cpu, &world, s)?,
        Technique::LayeredRsm(s) => Stages::layered_rsm(&mut cpu, &world, s)?,
        _ => return Ok(None),
    };
    Ok(Some((cpu, stages)))
}
