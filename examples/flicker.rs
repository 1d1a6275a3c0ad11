//! Prints how much indirect light flickers while the camera moves slowly: the table of `docs/visibility-filter.md`.
//!
//! `cargo run --release --example flicker [FRAMES [MILLIMETRES]]`. Between frames the eye moves by 5 mm or as said. Flicker is the mean absolute
//! difference of neighbouring frames over the mean of the picture; the path tracer's, with the same random numbers in
//! every frame, says how much of it is the motion itself (and, an upper bound, its remaining noise).

use glam::Vec3;
use std::sync::atomic::AtomicBool;
use twinlight::backend::Cpu;
use twinlight::picture::Picture;
use twinlight::scene::{Camera, Scene, bvh::Bvh};
use twinlight::technique::reference::{self, Reference};
use twinlight::technique::visibility_filter::{self, Anchor, Lit, Proxies, VisibilityFilter};
use twinlight::technique::{Inspection, Job, LightPart, View, World};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const SIDE: u32 = 256;

/// Mean absolute difference of neighbouring frames over the mean.
fn flicker(frames: &[Picture]) -> f64 {
    let difference = |w: &[Picture]| -> f64 {
        let pairs = w[0].pixels.iter().zip(&w[1].pixels);
        pairs.map(|(a, b)| f64::from((*a - *b).abs().element_sum())).sum::<f64>()
    };
    let whole: f64 = frames[0].pixels.iter().map(|p| f64::from(p.element_sum())).sum();
    frames.windows(2).map(difference).sum::<f64>() / (frames.len() - 1) as f64 / whole
}

fn main() -> Result<()> {
    let frames: u32 = std::env::args().nth(1).map_or(Ok(8), |text| text.parse())?;
    let step: f32 = std::env::args().nth(2).map_or(Ok(5.0), |text| text.parse())?;
    let scene = Scene::open("cornell-box")?;
    let tree = Bvh::build(&scene.triangles, &scene.materials)?;
    let still = scene.view();
    let views: Vec<View> = (0..frames.max(2))
        .map(|i| {
            let step = Vec3::X * (1e-3 * step * i as f32);
            View::new(&Camera { eye: still.eye + step, target: still.target + step, ..still }, SIDE, SIDE)
        })
        .collect::<std::result::Result<_, _>>()?;
    println!("| {} frames of {SIDE} × {SIDE}, {step} mm apart | flicker |\n|---|---|", views.len());
    for samples in [256, 1024] {
        let settings = Reference { samples, pixel_filter: false, ..Default::default() };
        let stop = AtomicBool::new(false);
        let pictures: Vec<Picture> = views
            .iter()
            .map(|v| reference::render(&scene, &tree, v, &settings, &stop, |_| ()).indirect)
            .collect();
        println!("| path tracer, {samples} paths | {:.2} % |", 100.0 * flicker(&pictures));
    }
    let mut cpu = Cpu::new(None)?;
    let world = World::upload(&mut cpu, &scene, &tree, false)?;
    let job = Job { light: LightPart::Indirect, ..Job::default() };
    for (what, rays, filter) in
        [("64 rays, 7 × 7", 64, 3), ("16 rays, 7 × 7", 16, 3), ("64 rays, unfiltered", 64, 0)]
    {
        for anchor in [Anchor::Pixel, Anchor::World] {
            let settings = VisibilityFilter { anchor, rays, filter: (filter, filter), ..Default::default() };
            let proxies = Proxies::build(&mut cpu, &world, &settings, 1, false)?;
            let mut seen = Inspection::new(&job, SIDE, SIDE);
            let lit = Lit::light(&mut cpu, &world, &proxies, &settings, &job, &mut seen)?;
            let mut pictures = Vec::new();
            for view in &views {
                let lit_proxies = Some((&proxies, &lit));
                let frame = visibility_filter::frame::render(
                    &mut cpu,
                    &world,
                    lit_proxies,
                    None,
                    view,
                    &job,
                    &settings,
                    &mut seen,
                )?;
                pictures.push(frame.picture);
            }
            println!("| {what}, {anchor:?} | {:.2} % |", 100.0 * flicker(&pictures));
        }
    }
    Ok(())
}
