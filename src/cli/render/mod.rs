//! `twinlight render`: one picture, or one for each frame; and `twinlight explain`: what would run, and why.

mod arguments;
mod chosen;
mod curves;
mod explained;
mod frames;
mod output;
mod passes;
mod path_traced;

pub(crate) use arguments::{Machine, RenderArguments, parse_line};

use super::knobs::{Knobs, Of};
use super::options::{ArithmeticChoice, Kept, build_tree};
use super::{Failure, print_out};
use crate::picture::Picture;
use crate::plan::{Change, Plan, Request, choose};
use crate::scene::Scene;
use crate::technique::{ambient_occlusion, direct, layered_rsm, soft_gi, visibility_filter, voxel_cones};
use arguments::{Only, Technique, UpsamplingChoice};
use clap::ValueEnum;
use output::{check_output, dump_path, note_error, open_reference, report, write};
use std::path::{Path, PathBuf};
use twinlight_kernels::passes::PassTiming;

/// What a technique made, ready to be written.
struct Outcome {
    picture: Picture,
    report: String,
    json: serde_json::Value,
    dumps: Vec<(String, Picture)>,
    interrupted: bool,
    /// The passes that ran; none for the reference.
    ran: Vec<PassTiming>,
    /// What had changed since the frame before.
    changes: Vec<Change>,
}

/// What the options ask of their technique.
pub(crate) fn request_of(a: &RenderArguments, view: &crate::technique::View) -> Result<Request, Failure> {
    check_request(a, a.technique)?;
    passes::request(a, a.technique, view)
}

impl RenderArguments {
    /// `--arithmetic`.
    pub(crate) fn arithmetic(&self) -> Option<ArithmeticChoice> {
        self.backend.arithmetic
    }
}

pub(crate) fn run(a: &RenderArguments) -> Result<(), Failure> {
    if !a.exposure.is_finite() || a.exposure.abs() > 100.0 {
        return Err(Failure::Request("--exposure: give stops from -100 to 100".into()));
    }
    if !(a.falloff >= 0.0 && a.falloff <= 1.0e18 && a.reach > 0.0 && a.reach <= 1.0e30) {
        return Err(Failure::Request(
            "--falloff must be from 0 to 1e18, --reach from above 0 to 1e30".into(),
        ));
    }
    if a.technique != Technique::Auto {
        check_request(a, a.technique)?;
    }
    match a.frames {
        Some(frames) => frames::run(a, frames),
        None if a.orbit.is_some() || a.resume || a.shard.is_some() => {
            Err(Failure::Request("--orbit, --resume and --shard: for frames; give --frames A..B".into()))
        }
        None => one(a, Moment::default(), a.output.as_deref(), &mut Session::default()).map(|_| ()),
    }
}

/// Prints the plan of a picture, and what follows from it.
pub(crate) fn explain(a: &RenderArguments) -> Result<(), Failure> {
    if a.budget.is_some() || a.error.is_some() {
        return Err(Failure::Request(
            "--budget and --error: they take trials, and explain renders nothing; leave it out".into(),
        ));
    }
    let mut kept = Kept::default();
    let (scene, view) = a.scene.open_at(0.0, 0.0, &mut kept)?;
    let (next, _) = a.scene.open_at(1.0 / 25.0, 0.0, &mut kept)?;
    let motion = explained::Motion::between(&scene, &next);
    let (technique, reason) = chosen(a, &scene, a.frames.is_some() && motion.any());
    check_request(a, technique)?;
    let request = passes::request(a, technique, &view)?;
    let tree = build_tree(&scene)?;
    let plan = Plan::new(&scene, &request).map_err(|e| Failure::Request(e.to_string()))?;
    let costs = crate::renderer::costs(&scene, &tree, &plan)?;
    if a.json {
        return print_out(&format!("{}\n", explained::json(&scene, motion, &plan, &costs, reason)));
    }
    let auto = reason.map_or_else(String::new, |why| format!("auto chose {}: {why}\n", name(technique)));
    print_out(&format!("{auto}{}\n{}{}", explained::census(&scene, motion), plan.text(), costs.text()))
}

/// What frames share.
#[derive(Default)]
struct Session {
    kept: Kept,
    running: Option<passes::Running>,
    /// Whether meshes or lights move.
    moving: bool,
}

/// When, and how far the camera has turned.
#[derive(Clone, Copy, Default)]
struct Moment {
    seconds: f64,
    degrees: f64,
}

/// Renders the scene at a moment; returns the passes that ran and what had changed.
fn one(
    a: &RenderArguments,
    moment: Moment,
    output: Option<&Path>,
    session: &mut Session,
) -> Result<(Vec<PassTiming>, Vec<Change>), Failure> {
    let (scene, view) = a.scene.open_at(moment.seconds, moment.degrees, &mut session.kept)?;
    let (technique, reason) = chosen(a, &scene, session.moving);
    check_request(a, technique)?;
    let wants = wanted(a)?;
    let output = output.map_or_else(|| PathBuf::from(format!("{}.png", scene.name)), Path::to_owned);
    for path in std::iter::once(output.clone()).chain(a.dump.iter().map(|name| dump_path(&output, name))) {
        check_output(&path)?;
    }
    if !a.quiet {
        for warning in &scene.warnings {
            eprintln!("note: {warning}");
        }
        if let Some(why) = reason.filter(|_| !wants) {
            eprintln!("note: auto chose {}: {why}", name(technique));
        }
    }
    let choice = if wants { chosen::choose(a, &scene, &view)? } else { None };
    let own;
    let (a, technique) = match &choice {
        Some(choice) => {
            note_choice(a, choice);
            // What does not fit leaves out effects beside.
            let budget = a.budget.filter(|_| !choice.fits);
            own = RenderArguments { knobs: choice.knobs.clone(), budget, error: None, ..a.clone() };
            check_request(&own, choice.technique)?;
            (&own, choice.technique)
        }
        None => (a, technique),
    };
    let copy = choice.as_ref().map(|_| scene.clone());
    let reference = a.against.as_deref().map(|path| open_reference(path, &view)).transpose()?;
    let mut outcome = match technique {
        Technique::Reference => {
            let cpu = a.backend.cpu()?;
            cpu.install(|| path_traced::run(a, &scene, &build_tree(&scene)?, &view))
        }
        _ => passes::run(a, technique, &mut session.running, scene, &view),
    }?;
    if let Some(reference) = reference {
        note_error(&mut outcome, &reference);
    }
    if let (Some(choice), Some(scene)) = (&choice, copy) {
        let error = chosen::measured_error(a, scene, &view, &outcome.picture)?;
        choice.report(&mut outcome, error);
    }
    let written = write(a, &output, &outcome)?;
    report(a, &outcome, &written)?;
    if outcome.interrupted {
        return Err(Failure::Work(format!("interrupted; {} holds what was done", output.display())));
    }
    Ok((outcome.ran, outcome.changes))
}

/// Whether settings are to be chosen.
fn wanted(a: &RenderArguments) -> Result<bool, Failure> {
    let own = a.knobs != Knobs::default();
    if a.error.is_some() && own {
        return Err(Failure::Request(
            "--error: it chooses the knobs; leave them out, or leave out --error".into(),
        ));
    }
    if (a.error.is_some() || a.budget.is_some()) && matches!(a.technique, Technique::Reference) {
        return Err(Failure::Request(
            "--budget and --error: for techniques of passes; give --samples".into(),
        ));
    }
    let steps = a.technique == Technique::Auto
        || crate::cli::tradeoff::steps_of(&name(a.technique), (1, 1)).is_some();
    let all = a.only != Only::Direct && a.effects.is_none() && a.quality == 0.0;
    if a.error.is_some() && !all {
        return Err(Failure::Request(
            "--error: curves are of all effects; leave out --effects, --quality and --only direct".into(),
        ));
    }
    Ok(a.error.is_some() || a.budget.is_some() && !own && steps && all)
}

fn note_choice(a: &RenderArguments, choice: &chosen::Choice) {
    if a.quiet {
        return;
    }
    if !choice.fits {
        eprintln!("note: no setting is expected to do that; this comes nearest");
    }
    eprintln!("note: chose {}", choice.text());
}

/// The technique that is asked for, or the one that suits the scene, with the reason.
fn chosen(a: &RenderArguments, scene: &Scene, moving: bool) -> (Technique, Option<&'static str>) {
    if a.technique != Technique::Auto {
        return (a.technique, None);
    }
    let (chosen, why) = choose(&scene.census(), a.only.light(), a.scene.look.emissive, moving);
    (Technique::from_str(chosen, false).unwrap_or(Technique::Direct), Some(why))
}

/// The technique's name as an option.
fn name(technique: Technique) -> String {
    technique.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
}

/// Refuses what the technique cannot do, before any work.
fn check_request(a: &RenderArguments, technique: Technique) -> Result<(), Failure> {
    if technique == Technique::Direct && a.only == Only::Indirect {
        return Err(Failure::Request(
            "--technique direct has no indirect light; try --technique reference".into(),
        ));
    }
    if technique == Technique::AmbientOcclusion && a.only != Only::All {
        return Err(Failure::Request(
            "--only: ambient occlusion is not light; leave it out or choose another technique".into(),
        ));
    }
    if technique == Technique::Reference && (a.effects.is_some() || a.quality > 0.0 || a.budget.is_some()) {
        return Err(Failure::Request(
            "--effects, --quality and --budget do nothing for --technique reference; leave them out".into(),
        ));
    }
    if technique == Technique::Reference && a.machine == Machine::Gpu {
        return Err(Failure::Request(
            "--technique reference runs on the CPU; leave out --backend gpu".into(),
        ));
    }
    let of: &[Of] = match technique {
        Technique::VisibilityFilter => &[Of::VisibilityFilter],
        Technique::VoxelCones => &[Of::VoxelCones],
        Technique::SoftGi => &[Of::SoftGi],
        Technique::LayeredRsm => &[Of::LayeredRsm],
        _ => &[],
    };
    a.knobs.check(of, &name(technique))?;
    if a.upsampling != UpsamplingChoice::Bilateral && of.is_empty() {
        return Err(Failure::Request(format!(
            "--upsampling does nothing for --technique {}; leave it out",
            name(technique)
        )));
    }
    let (width, height) = a.scene.look.size;
    match technique {
        Technique::VisibilityFilter => a.knobs.visibility_filter().check(width, height),
        Technique::VoxelCones => a.knobs.voxel_cones().check(width, height),
        Technique::SoftGi => a.knobs.soft_gi().check(width, height),
        Technique::LayeredRsm => a.knobs.layered_rsm().check(width, height),
        _ => Ok(()),
    }
    .map_err(|e| Failure::Request(e.to_string()))?;
    check_dumps(a, technique)
}

/// Refuses buffers that the technique does not have.
fn check_dumps(a: &RenderArguments, technique: Technique) -> Result<(), Failure> {
    if technique == Technique::VoxelCones {
        let settings = a.knobs.voxel_cones();
        for dump in &a.dump {
            let Some((_, level)) = voxel_cones::voxel_view(dump) else { continue };
            let depth = settings.depth();
            if level > depth {
                return Err(Failure::Request(format!("--dump {dump}: levels are 0 to {depth} here")));
            }
            if settings.occlusion && !dump.starts_with("occlusion") {
                return Err(Failure::Request(format!(
                    "--dump {dump}: with --occlusion voxels have no light"
                )));
            }
        }
        if settings.occlusion && a.only != Only::All {
            return Err(Failure::Request("--only: occlusion is not light; leave it out".into()));
        }
    }
    let known: &[&str] = match technique {
        Technique::Reference => &["direct", "indirect"],
        Technique::AmbientOcclusion => &ambient_occlusion::DUMPS,
        Technique::VisibilityFilter => &visibility_filter::DUMPS,
        Technique::VoxelCones => &voxel_cones::DUMPS,
        Technique::SoftGi => &soft_gi::DUMPS,
        Technique::LayeredRsm => &layered_rsm::DUMPS,
        _ => &direct::DUMPS,
    };
    for name in &a.dump {
        let of_voxels = technique == Technique::VoxelCones && voxel_cones::voxel_view(name).is_some();
        if !known.contains(&name.as_str()) && !of_voxels {
            return Err(Failure::Request(format!("--dump {name}: this technique has {}", known.join(", "))));
        }
    }
    Ok(())
}
