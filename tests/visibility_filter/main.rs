//! Does the visibility filter do what its parts promise, and does its light agree with the path tracer's?

#[path = "../support/mod.rs"]
mod support;

mod gather;
mod lists;
mod march;
mod pictures;
mod proxies;
mod robust;
mod voxels;

use support::tree;
use twinlight::backend::{Backend, Cpu};
use twinlight::picture::Picture;
use twinlight::scene::Scene;
use twinlight::technique::visibility_filter::{self, Counts, Lit, Proxies, VisibilityFilter};
use twinlight::technique::{Inspection, Job, LightPart, Rendered, View, World};
use twinlight_kernels::passes::elements::GridParams;
use twinlight_kernels::sampling::hash::{hash, unit_float};

fn cpu() -> Cpu {
    Cpu::new(Some(2)).unwrap()
}

/// A scene's buffers, its proxies, and what light makes of them.
struct Built {
    cpu: Cpu,
    world: World<Cpu>,
    proxies: Proxies<Cpu>,
    lit: Lit<Cpu>,
}

/// The grid of discs, and its lists on the host.
struct Discs {
    grid: GridParams,
    starts: Vec<u32>,
    pairs: Vec<u32>,
}

impl Built {
    fn new(scene: &Scene, settings: &VisibilityFilter) -> Self {
        let mut cpu = cpu();
        let world = World::upload(&mut cpu, scene, &tree(scene), false).unwrap();
        let proxies = Proxies::build(&mut cpu, &world, settings, 1, true).unwrap();
        let job = Job::default();
        let mut seen = Inspection::new(&job, 1, 1);
        let lit = Lit::light(&mut cpu, &world, &proxies, settings, &job, &mut seen).unwrap();
        Self { cpu, world, proxies, lit }
    }

    fn discs(&self) -> Discs {
        let c = self.proxies.cells.as_ref().unwrap();
        Discs { grid: c.grid, starts: self.cpu.download(&c.starts), pairs: self.cpu.download(&c.pairs) }
    }
}

/// Only indirect light.
fn indirect_job() -> Job {
    Job { light: LightPart::Indirect, ..Job::default() }
}

fn render_on<B: Backend>(
    backend: &mut B,
    scene: &Scene,
    view: &View,
    job: &Job,
    settings: &VisibilityFilter,
) -> (Rendered, Counts) {
    let world = World::upload(backend, scene, &tree(scene), false).unwrap();
    visibility_filter::render(backend, &world, view, job, settings).unwrap()
}

fn indirect(scene: &Scene, view: &View, settings: &VisibilityFilter) -> Picture {
    render_on(&mut cpu(), scene, view, &indirect_job(), settings).0.picture
}

/// Random numbers in [0, 1), the same in every run.
struct Random(u32);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9E37_79B9);
        unit_float(hash(self.0))
    }

    fn within(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.next()
    }

    fn point(&mut self, half: f32) -> glam::Vec3 {
        glam::Vec3::new(self.within(-half, half), self.within(-half, half), self.within(-half, half))
    }

    fn direction(&mut self) -> glam::Vec3 {
        loop {
            let p = self.point(1.0);
            if (0.01..1.0).contains(&p.length_squared()) {
                return p.normalize();
            }
        }
    }
}
