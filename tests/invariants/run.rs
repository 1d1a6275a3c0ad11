//! After a thousand frames with changes, is memory flat and the picture that of a scene rendered from nothing?

use crate::support::same_bits;
use glam::{EulerRot, Mat3, Vec3};
use twinlight::backend::Cpu;
use twinlight::plan::{Request, Technique};
use twinlight::renderer::Renderer;
use twinlight::scene::{Camera, Scene};
use twinlight::technique::layered_rsm::LayeredRsm;
use twinlight::technique::visibility_filter::VisibilityFilter;
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{Job, View};

/// Frames in all, over the techniques.
const FRAMES: u32 = 1000;

/// The scene at a frame: the lamp circles, now and then a block turns or a wall is painted.
fn state(start: &Scene, frame: u32) -> Scene {
    let mut s = start.clone();
    let (sin, cos) = (frame as f32 * 0.1).sin_cos();
    s.lights[0].position += (Vec3::new(cos, 0.0, sin) * 0.15).extend(0.0);
    let count = s.triangles.len();
    let turn = Mat3::from_euler(EulerRot::YXZ, (frame / 10) as f32 * 0.2, 0.0, 0.0);
    for t in &mut s.triangles[count - 12..] {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p = (turn * p.truncate()).extend(p.w);
        }
        for n in [&mut t.n0, &mut t.n1, &mut t.n2] {
            *n = (turn * n.truncate()).extend(n.w);
        }
    }
    let painted = (frame / 50) as usize % s.materials.len();
    s.materials[painted].base *= Vec3::splat(0.5).extend(1.0);
    s
}

/// Bytes of this process in memory; 0 where the system does not tell.
fn resident() -> u64 {
    let text = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    text.split_whitespace().nth(1).and_then(|n| n.parse::<u64>().ok()).unwrap_or(0) * 4096
}

#[test]
fn a_thousand_frames_leave_nothing_behind() {
    let start = Scene::open("cornell-glossy").unwrap();
    let techniques = [
        Technique::VisibilityFilter(VisibilityFilter {
            proxies: 1000,
            grid: [6; 3],
            rays: 9,
            light_map: 32,
            ..Default::default()
        }),
        Technique::VoxelCones(VoxelCones { resolution: 32, light_map: 64, bounces: 2, ..Default::default() }),
        Technique::LayeredRsm(LayeredRsm { resolution: 32, map: 64, ..Default::default() }),
        Technique::Direct,
    ];
    let share = FRAMES / techniques.len() as u32;
    for technique in techniques {
        let request = |frame: u32| {
            let c = start.view();
            let aside = Vec3::new(0.1 * (frame as f32 * 0.05).sin(), 0.0, 0.0);
            let view = View::new(&Camera { eye: c.eye + aside, ..c }, 24, 24).unwrap();
            Request::new(technique.clone(), view, Job { rays: 4, ..Job::default() })
        };
        let mut renderer = Renderer::new(Cpu::new(Some(2)).unwrap(), start.clone()).unwrap();
        let mut memory = Vec::new();
        let mut last = None;
        for frame in 0..share {
            renderer.update(state(&start, frame)).unwrap();
            // Every third frame asks again for what was there.
            let plan = renderer.plan(&request(frame - frame % 3)).unwrap();
            last = Some((plan.clone(), renderer.render(&plan).unwrap().rendered.picture));
            memory.push(resident());
        }
        let (plan, picture) = last.unwrap();
        let mut anew = Renderer::new(Cpu::new(Some(2)).unwrap(), state(&start, share - 1)).unwrap();
        let right = anew.render(&plan).unwrap().rendered.picture;
        assert!(same_bits(&picture, &right), "{}: frames drift", technique.name());
        let of = |part: &[u64]| part.iter().copied().max().unwrap_or(0) as f64 / f64::from(1 << 20);
        let (middle, end) =
            (of(&memory[share as usize / 4..share as usize / 2]), of(&memory[share as usize * 3 / 4..]));
        println!(
            "{}: {share} frames, {middle:.1} MiB in the second quarter, {end:.1} MiB in the last",
            technique.name()
        );
        // Other tests run beside this one in the same process.
        assert!(end < middle + 64.0, "{}: memory grows from {middle} to {end} MiB", technique.name());
    }
}
