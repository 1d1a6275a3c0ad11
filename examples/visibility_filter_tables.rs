//! Prints how the knobs of the visibility filter trade error for time: the tables of `docs/visibility-filter.md`.
//!
//! `cargo run --release --example visibility_filter_tables [SAMPLES [SCENE]]`. Pictures of 512 × 512 are averaged to 128 × 128 and
//! compared with the path tracer's indirect light (one bounce, SAMPLES paths for each of these pixels, 8192 if none are
//! given). Scenes from files are taken from the folder `TWINLIGHT_SCENES`, and left out where it has none.

#[path = "common/tables.rs"]
mod tables;

use tables::{Result, SIDE, Subject, error, reference, subjects};
use twinlight::backend::Cpu;
use twinlight::scene::bvh::Bvh;
use twinlight::technique::visibility_filter::{self, Clamp, Gather, Visibility, VisibilityFilter};
use twinlight::technique::{Job, LightPart, View, World};

/// What a line of the table changes.
type Change = (&'static str, fn(&mut VisibilityFilter));

const CHANGES: [Change; 25] = [
    ("as it is", |_| ()),
    ("high: rays 256, proxies × 4, marching 256²", |s| {
        (s.rays, s.proxies, s.marching) = (256, 4 * s.proxies, Some((256, 256)));
    }),
    ("rays 4", |s| s.rays = 4),
    ("rays 16", |s| s.rays = 16),
    ("rays 256", |s| s.rays = 256),
    ("proxies / 16", |s| s.proxies /= 16),
    ("proxies / 4", |s| s.proxies /= 4),
    ("proxies × 4", |s| s.proxies *= 4),
    ("meet discs", |s| s.visibility = Visibility::Proxies),
    ("meet discs, overlap 2", |s| (s.visibility, s.overlap) = (Visibility::Proxies, 2.0)),
    ("proxies throw no gloss", |s| s.proxy_gloss = false),
    ("marching 32²", |s| s.marching = Some((32, 32))),
    ("marching 64²", |s| s.marching = Some((64, 64))),
    ("marching 256²", |s| s.marching = Some((256, 256))),
    ("grid / 2", |s| s.grid = s.grid.map(|n| n / 2)),
    ("grid × 2", |s| s.grid = s.grid.map(|n| n * 2)),
    ("filter 1 × 1", |s| s.filter = (0, 0)),
    ("filter 3 × 3", |s| s.filter = (1, 1)),
    ("R = 0: sums only", |s| s.near_range = Some(0.0)),
    ("R = ∞: proxies only", |s| s.near_range = Some(1e9)),
    ("trust 0: rays alone", |s| s.trust = 0.0),
    ("gather sum, as published", |s| s.gather = Gather::Sum),
    ("gather sum, rays 256", |s| (s.gather, s.rays) = (Gather::Sum, 256)),
    ("gather sum, clamp none", |s| (s.gather, s.clamp) = (Gather::Sum, Clamp::None)),
    ("illumination 512²", |s| s.illumination = Some((SIDE, SIDE))),
];

fn main() -> Result<()> {
    let samples = std::env::args().nth(1).map_or(Ok(8192), |text| text.parse())?;
    for subject in subjects(std::env::args().nth(2).as_deref())? {
        let right = reference(&subject, 1, samples)?;
        let Subject { name, scene, camera } = subject;
        println!("| {name} | relative RMSE | mean ratio | ms |\n|---|---|---|---|");
        let tree = Bvh::build(&scene.triangles, &scene.materials)?;
        let view = View::new(&camera, SIDE, SIDE)?;
        let mut cpu = Cpu::new(None)?;
        let world = World::upload(&mut cpu, &scene, &tree, false)?;
        let job = Job { light: LightPart::Indirect, ..Job::default() };
        for (what, change) in CHANGES {
            let mut settings = VisibilityFilter::default();
            if name == "sponza.glb" {
                (settings.proxies, settings.grid) = (170_000, [32; 3]);
            }
            change(&mut settings);
            let (rendered, _) = visibility_filter::render(&mut cpu, &world, &view, &job, &settings)?;
            let error = error(&rendered.picture, &right)?;
            let time: f64 = rendered.timings.iter().map(|t| t.nanoseconds * 1e-6).sum();
            println!(
                "| {what} | {:.1} % | {:.3} | {time:.0} |",
                100.0 * error.relative_rmse,
                error.mean_ratio
            );
        }
    }
    Ok(())
}
