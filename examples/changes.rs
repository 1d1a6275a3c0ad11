//! Prints what a picture costs after each kind of change, from the first picture on: the table of `docs/plan.md`.
//!
//! `cargo run --release --example changes [SCENE]`: by each technique on the CPU, 512 × 512. SCENE is `cornell-glossy` if none is given, or a
//! file of the folder `TWINLIGHT_SCENES`.

#[allow(dead_code)]
#[path = "common/tables.rs"]
mod tables;

use tables::{Result, Subject, subjects};
use twinlight::backend::Cpu;
use twinlight::plan::{Change, Request, Technique, stages};
use twinlight::renderer::Renderer;
use twinlight::scene::{Camera, Scene};
use twinlight::technique::{Job, View};

/// The scene after a change.
fn changed(scene: &Scene, change: Change) -> Scene {
    let mut s = scene.clone();
    match change {
        Change::Lights => s.lights.iter_mut().for_each(|l| l.intensity *= 0.9),
        Change::Materials => s.materials[0].base.x *= 0.9,
        Change::Meshes => {
            let count = s.triangles.len();
            for t in &mut s.triangles[count - count / 20 - 1..] {
                for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
                    p.y += 0.01;
                }
            }
        }
        Change::Nothing | Change::Camera => {}
    }
    s
}

fn table(subject: &Subject, technique: &Technique) -> Result<()> {
    let Subject { name, scene, camera } = subject;
    println!("\n{name}, {}:\n\n| after | passes | ms | ran |\n|---|---|---|---|", technique.name());
    let mut renderer = Renderer::new(Cpu::new(None)?, scene.clone())?;
    let mut state = scene.clone();
    let mut from = *camera;
    let mut row = |what: &str, state: &Scene, from: &Camera| -> Result<()> {
        renderer.update(state.clone())?;
        let view = View::new(from, 512, 512)?;
        let plan = renderer.plan(&Request::new(technique.clone(), view, Job::default()))?;
        let timings = renderer.render(&plan)?.rendered.timings;
        let ms: f64 = timings.iter().map(|t| t.nanoseconds * 1e-6).sum::<f64>() + 0.0;
        let ran: Vec<&str> =
            stages(&timings).into_iter().map(|s| if s.is_empty() { "picture" } else { s }).collect();
        println!("| {what} | {} | {ms:.0} | {} |", timings.len(), ran.join(", "));
        Ok(())
    };
    row("nothing was there", &state, &from)?;
    for change in
        [Change::Nothing, Change::Camera, Change::Lights, Change::Materials, Change::Meshes, Change::Meshes]
    {
        state = changed(&state, change);
        if change == Change::Camera {
            from.eye += 0.01 * (from.target - from.eye);
        }
        row(change.name(), &state, &from)?;
    }
    Ok(())
}

fn main() -> Result<()> {
    let wanted = std::env::args().nth(1).unwrap_or_else(|| "cornell-glossy".to_owned());
    let subject = subjects(Some(&wanted))?.into_iter().next().ok_or("no such scene")?;
    for technique in [
        Technique::Direct,
        Technique::VisibilityFilter(Default::default()),
        Technique::VoxelCones(Default::default()),
        Technique::LayeredRsm(Default::default()),
    ] {
        table(&subject, &technique)?;
    }
    Ok(())
}
