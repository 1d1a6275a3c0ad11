//! After a thousand frames with changes, is memory flat and the picture that of a scene rendered from nothing?
//!
//! A binary with one test: others beside it would take memory too.

#[path = "support/mod.rs"]
mod support;

use glam::{EulerRot, Mat3, Vec3};
use peak_alloc::PeakAlloc;
use support::same_bits;
use twinlight::backend::Cpu;
use twinlight::plan::{Request, Technique};
use twinlight::renderer::Renderer;
use twinlight::scene::{Camera, Scene};
use twinlight::technique::layered_rsm::LayeredRsm;
use twinlight::technique::soft_gi::SoftGi;
use twinlight::technique::visibility_filter::VisibilityFilter;
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{Job, View};

/// Frames of voxel cones, which keep the most from frame to frame, and of the others.
const FRAMES: [u32; 2] = [1000, 250];

/// The scene at a frame: the lamp circles, now and then the last mesh turns or a wall is painted.
fn state(start: &Scene, frame: u32) -> Scene {
    let mut s = start.clone();
    let (sin, cos) = (frame as f32 * 0.1).sin_cos();
    if let Some(lamp) = s.lights.first_mut() {
        lamp.position += (Vec3::new(cos, 0.0, sin) * 0.15).extend(0.0);
    }
    let count = s.triangles.len();
    for p in &mut s.proxies {
        p.centre += Vec3::new(cos, 0.0, sin) * 0.05;
    }
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

/// Counts what is allocated and not yet given back: pages of the process would hide leaks in what earlier frames left free.
#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

fn techniques() -> [Technique; 5] {
    [
        Technique::SoftGi(SoftGi { order: 3, receiver_scale: 4, ..Default::default() }),
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
    ]
}

/// Renders frame after frame; returns by how many KiB the last quarter is above the second, and checks the last picture.
fn run(technique: &Technique, frames: u32, mut after: impl FnMut()) -> f32 {
    let soft = matches!(technique, Technique::SoftGi(_));
    let start = Scene::open(if soft { "spheres" } else { "cornell-glossy" }).unwrap();
    let request = |frame: u32| {
        let c = start.view();
        let aside = Vec3::new(0.1 * (frame as f32 * 0.05).sin(), 0.0, 0.0);
        let view = View::new(&Camera { eye: c.eye + aside, ..c }, 24, 24).unwrap();
        Request::new(technique.clone(), view, Job { rays: 4, ..Job::default() })
    };
    let mut renderer = Renderer::new(Cpu::new(Some(2)).unwrap(), start.clone()).unwrap();
    let mut memory = Vec::new();
    let mut last = None;
    for frame in 0..frames {
        renderer.update(state(&start, frame)).unwrap();
        // Every third frame asks again for what was there.
        let plan = renderer.plan(&request(frame - frame % 3)).unwrap();
        last = Some((plan.clone(), renderer.render(&plan).unwrap().rendered.picture));
        memory.push(HEAP.current_usage_as_kb());
        after();
    }
    let (plan, picture) = last.unwrap();
    let mut anew = Renderer::new(Cpu::new(Some(2)).unwrap(), state(&start, frames - 1)).unwrap();
    let right = anew.render(&plan).unwrap().rendered.picture;
    assert!(same_bits(&picture, &right), "{}: frames drift", technique.name());
    let most = |part: &[f32]| part.iter().copied().fold(0.0, f32::max);
    let quarter = memory.len() / 4;
    most(&memory[3 * quarter..]) - most(&memory[quarter..2 * quarter])
}

/// KiB; what a turned mesh's tree takes more at one angle than at another is less.
const BOUND: f32 = 64.0;

#[test]
fn a_thousand_frames_leave_nothing_behind() {
    for technique in techniques() {
        let frames = if matches!(technique, Technique::VoxelCones(_)) { FRAMES[0] } else { FRAMES[1] };
        let more = run(&technique, frames, || ());
        println!(
            "{}: {frames} frames, {more:.1} KiB more in the last quarter than in the second",
            technique.name()
        );
        assert!(more < BOUND, "{}: memory grows by {more} KiB", technique.name());
    }
    // A planted fault: a frame that leaves 1 KiB behind.
    let more = run(&Technique::Direct, FRAMES[1], || {
        std::mem::forget(std::hint::black_box(vec![1u8; 1 << 10]));
    });
    println!("with a leak: {more:.1} KiB more");
    assert!(more > BOUND, "a leak is not seen: {more}");
}
