//! Renders a scene's direct light with the library: `cargo run --release --example direct_light -- SCENE OUT.png`.

use std::error::Error;
use std::path::Path;
use twinlight::backend::Cpu;
use twinlight::scene::{Scene, bvh::Bvh};
use twinlight::technique::{Job, View, World, direct};

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let scene = Scene::open(&arguments.next().unwrap_or_else(|| "cornell-glossy".into()))?;
    let output = arguments.next().unwrap_or_else(|| "direct_light.png".into());
    let tree = Bvh::build(&scene.triangles, &scene.materials)?;
    let view = View::new(&scene.view(), 512, 512)?;
    let mut backend = Cpu::new(None)?;
    let world = World::upload(&mut backend, &scene, &tree, false)?;
    let rendered = direct::render(&mut backend, &world, &view, &Job::default())?;
    rendered.picture.save(Path::new(&output), 0.0)?;
    for timing in rendered.timings {
        println!("{:<20} {:>8.2} ms", timing.pass, timing.nanoseconds * 1e-6);
    }
    println!("wrote {output}");
    Ok(())
}
