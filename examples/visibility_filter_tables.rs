//! Prints how the knobs of the visibility filter trade error for time: the tables of `docs/visibility-filter.md`.
//!
//! `cargo run --release --example visibility_filter_tables [SAMPLES [SCENE]]`. Pictures of 512 × 512 are averaged to 128 × 128 and
//! compared with the path tracer's indirect light (one bounce, SAMPLES paths for each of these pixels, 8192 if none are
//! given). Scenes from files are taken from the folder `TWINLIGHT_SCENES`, and left out where it has none.

use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use twinlight::backend::Cpu;
use twinlight::picture::Picture;
use twinlight::report::error::picture_error;
use twinlight::scene::{Camera, Scene, bvh::Bvh, light};
use twinlight::technique::reference::{self, Reference};
use twinlight::technique::visibility_filter::{self, Clamp, Gather, Visibility, VisibilityFilter};
use twinlight::technique::{Job, LightPart, View, World};

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

const SIDE: u32 = 512;
const COARSE: u32 = 128;

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

/// A scene, how it is looked at, and the settings that its table starts from.
struct Subject {
    name: &'static str,
    scene: Scene,
    camera: Camera,
    settings: VisibilityFilter,
}

fn subjects() -> Result<Vec<Subject>> {
    let settings = VisibilityFilter::default();
    let mut all = Vec::new();
    for name in ["cornell-box", "cornell-glossy"] {
        let scene = Scene::open(name)?;
        let camera = scene.view();
        all.push(Subject { name, scene, camera, settings: settings.clone() });
    }
    let camera = |eye: [f32; 3], target: [f32; 3], fov| Camera {
        eye: eye.into(),
        target: target.into(),
        up: glam::Vec3::Y,
        fov,
    };
    let low = camera([0.0, 0.8, 3.2], [0.0, 0.8, 0.0], 36.0);
    let files = [
        (
            "cornell-glossy.glb",
            low,
            light::parse_spot("-0.6,1.5,0.6:0.9,-1.2,-0.7:4,4,4:35")?,
            settings.clone(),
        ),
        (
            "cornell-original.glb",
            camera([0.0, 1.0, 3.4], [0.0, 1.0, 0.0], 39.0),
            light::parse_point("0,1.8,0:2,2,2")?,
            settings.clone(),
        ),
        (
            "sponza.glb",
            camera([-11.0, 1.7, -0.5], [8.0, 4.5, 0.0], 60.0),
            light::parse_sun("0.25,-1,0.15:12,11,9.5")?,
            VisibilityFilter { proxies: 170_000, grid: [32; 3], ..settings },
        ),
    ];
    let folder = std::env::var_os("TWINLIGHT_SCENES").map(PathBuf::from).unwrap_or_default();
    for (name, camera, lamp, settings) in files {
        let path = folder.join(name);
        if !path.is_file() {
            eprintln!("left out: {name} is not in the folder TWINLIGHT_SCENES");
            continue;
        }
        let mut scene = Scene::open(&path.display().to_string())?;
        scene.lights = vec![lamp];
        all.push(Subject { name, scene, camera, settings });
    }
    Ok(all)
}

/// Averages blocks of pixels.
fn averaged(picture: &Picture) -> Picture {
    let step = SIDE / COARSE;
    let mut small = Picture::new(COARSE, COARSE);
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let (x, y) = (i as u32 % SIDE / step, i as u32 / SIDE / step);
        small.pixels[(y * COARSE + x) as usize] += *pixel / (step * step) as f32;
    }
    small
}

fn main() -> Result<()> {
    let samples = std::env::args().nth(1).map_or(Ok(8192), |text| text.parse())?;
    let only = std::env::args().nth(2);
    for subject in subjects()? {
        let Subject { name, scene, camera, settings } = subject;
        if only.as_deref().is_some_and(|o| o != name) {
            continue;
        }
        let tree = Bvh::build(&scene.triangles, &scene.materials)?;
        let view = View::new(&camera, COARSE, COARSE)?;
        let right = Reference { samples, ..Default::default() };
        let right = reference::render(&scene, &tree, &view, &right, &AtomicBool::new(false), |_| ());
        let s = right.statistics[1];
        let noise = 3.0 * s.pixel_standard_error / s.mean.element_sum();
        println!(
            "\n{name}: mean indirect radiance {:.5}, reference noise {:.1} %\n",
            s.mean.y,
            100.0 * noise
        );
        println!("| {name} | relative RMSE | mean ratio | ms |\n|---|---|---|---|");
        let view = View::new(&camera, SIDE, SIDE)?;
        let mut cpu = Cpu::new(None)?;
        let world = World::upload(&mut cpu, &scene, &tree, false)?;
        let job = Job { light: LightPart::Indirect, ..Job::default() };
        for (what, change) in CHANGES {
            let mut settings = settings.clone();
            change(&mut settings);
            let (rendered, _) = visibility_filter::render(&mut cpu, &world, &view, &job, &settings)?;
            let error = picture_error(&averaged(&rendered.picture), &right.indirect).ok_or("sizes differ")?;
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
