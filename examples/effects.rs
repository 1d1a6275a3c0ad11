//! Prints which effects scenes call for and what the backend counts for them: the table of scenes and effects of `docs/plan.md`.
//!
//! `cargo run --release --example effects`: 128 × 128 on the CPU, the built-in scenes and those of the folder `TWINLIGHT_SCENES`. Each effect that
//! is called for is left out once; the row tells by how much passes, kinds of passes, buffers and bytes fall.

#[allow(dead_code)]
#[path = "common/tables.rs"]
mod tables;

use tables::{Result, Subject, subjects};
use twinlight::backend::{Backend, Cpu};
use twinlight::plan::{Effect, Request, Technique};
use twinlight::renderer::Renderer;
use twinlight::scene::Scene;
use twinlight::technique::{Job, View};

/// Passes, kinds of passes, buffers and bytes that the backend counts for a picture.
fn counted(scene: &Scene, request: &Request) -> Result<([u64; 4], Vec<Effect>)> {
    let mut cpu = Cpu::new(None)?;
    Backend::log_allocations(&mut cpu, true);
    let mut renderer = Renderer::new(cpu, scene.clone())?;
    let plan = renderer.plan(request)?;
    let timings = renderer.render(&plan)?.rendered.timings;
    let mut kinds: Vec<&str> = timings.iter().map(|t| t.pass).collect();
    kinds.sort_unstable();
    kinds.dedup();
    let buffers = Backend::take_allocations(renderer.backend_mut());
    let bytes = buffers.iter().map(|b| b.bytes).sum();
    Ok(([timings.len() as u64, kinds.len() as u64, buffers.len() as u64, bytes], plan.effects()))
}

fn rows(subject: &Subject, technique: &Technique) -> Result<()> {
    let view = View::new(&subject.camera, 128, 128)?;
    let request = Request {
        emissive: true,
        ..Request::new(technique.clone(), view, Job { rays: 1, ..Job::default() })
    };
    let (all, called) = counted(&subject.scene, &request)?;
    let of = |c: [u64; 4]| format!("{} | {} | {} | {:.1}", c[0], c[1], c[2], c[3] as f64 * 1e-6);
    let (name, by) = (subject.name, technique.name());
    let list: Vec<&str> = called.iter().map(|e| e.name()).collect();
    println!("| {name}, {by}: {} | {} |", list.join(", "), of(all));
    for &effect in &called {
        let kept = called.iter().copied().filter(|&e| e != effect).collect();
        let (less, _) = counted(&subject.scene, &Request { effects: Some(kept), ..request.clone() })?;
        println!("| without {} | {} |", effect.name(), of(less));
    }
    Ok(())
}

fn main() -> Result<()> {
    println!("| | passes | kinds | buffers | MB |\n|---|---|---|---|---|");
    let mut all = subjects(None)?;
    let scene = Scene::open("spheres")?;
    let camera = scene.view();
    all.push(Subject { name: "spheres", scene, camera });
    for subject in &all {
        let soft = subject.scene.lights.is_empty();
        let cones = Technique::VoxelCones(Default::default());
        rows(subject, &if soft { Technique::SoftGi(Default::default()) } else { cones })?;
    }
    Ok(())
}
