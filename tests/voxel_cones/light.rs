//! Is brightness kept: from level to level, at any resolution, behind walls, between walls of two colours?

use crate::support::*;
use crate::{cpu, indirect, render_on};
use glam::{Vec3, Vec4};
use twinlight::picture::Picture;
use twinlight::scene::{Environment, Scene, light};
use twinlight::technique::reference::Bounces;
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{Job, LightPart};

fn at(resolution: u32) -> VoxelCones {
    VoxelCones { resolution, ..Default::default() }
}

#[test]
fn a_white_box_is_as_bright_at_any_resolution() {
    let mut s = scene();
    room(&mut s, v(1.0, 1.0, 1.0), 0.0, emitter(0.0, 1.0));
    // A room's front faces are outside or inside: make both emit.
    let inner: Vec<_> = s
        .triangles
        .iter()
        .map(|t| twinlight_kernels::passes::elements::Triangle {
            p1: t.p2,
            p2: t.p1,
            n0: -t.n0,
            n1: -t.n1,
            n2: -t.n2,
            ..*t
        })
        .collect();
    s.triangles.extend(inner);
    for m in &mut s.materials {
        m.base = Vec4::ONE;
    }
    let view = view(&camera(v(0.0, 0.0, 0.9), v(0.0, -0.3, -1.0), 70.0), 24, 24);
    let mut means = Vec::new();
    for resolution in [16, 32, 64, 128, 256] {
        for cones in [6, 16] {
            let mean = indirect(&s, &view, &VoxelCones { cones, ..at(resolution) }, true).mean().y;
            println!("{resolution}³, {cones} cones: {mean:.4}");
            means.push(mean);
        }
    }
    // Cones miss a little where walls meet; what counts is that it does not depend on the resolution.
    for one in means.chunks_exact(2).flat_map(|m| [(m[0], means[4]), (m[1], means[5])]) {
        assert!((one.0 / one.1 - 1.0).abs() < 0.05, "brightness drifts: {} and {}", one.0, one.1);
        assert!((one.0 - 1.0).abs() < 0.1, "a furnace of radiance 1 gives {}", one.0);
    }
}

/// A closed dark room with walls `thickness` thick in a lit one.
fn sealed(thickness: f32) -> Scene {
    let mut s = scene();
    room(&mut s, v(2.0, 2.0, 2.0), 0.0, grey(0.8));
    room(&mut s, v(0.8, 0.8, 0.8), 0.0, grey(0.8));
    if thickness > 0.0 {
        room(&mut s, Vec3::splat(0.8 + thickness), 0.0, grey(0.8));
    }
    s.lights = vec![light::point(v(0.0, 1.6, 0.0), Vec3::splat(5.0))];
    s
}

#[test]
fn a_sealed_room_is_dark() {
    let inside = view(&camera(v(0.0, 0.0, 0.7), v(0.0, -0.2, -1.0), 80.0), 24, 24);
    let outside = view(&camera(v(0.0, 1.7, 1.7), v(0.0, 0.0, -1.9), 80.0), 24, 24);
    let voxel = 4.0 / 61.4;
    for voxels in [0.0, 1.0, 2.0] {
        let s = sealed(voxels * voxel);
        let leak =
            indirect(&s, &inside, &at(64), false).mean().y / indirect(&s, &outside, &at(64), false).mean().y;
        println!("walls {voxels} voxels thick: {:.3} % of the light outside", 100.0 * leak);
        assert!(leak < [0.06, 0.03, 0.02][voxels as usize], "{voxels}: {leak}");
    }
}

/// Light from the wall between a red and a green room, as the red room sees it: the share that is green.
fn green_share(anisotropic: bool) -> f32 {
    let mut s = scene();
    let colour = |r: f32, g: f32| twinlight_kernels::passes::elements::Material {
        emission: Vec4::new(r, g, 0.0, 0.0),
        ..grey(0.0)
    };
    let side = |x: f32, flip: bool| {
        let mut p = [v(x, -1.0, 1.0), v(x, -1.0, -1.0), v(x, 1.0, -1.0), v(x, 1.0, 1.0)];
        if flip {
            p.swap(1, 3);
        }
        p
    };
    // Red faces +x, green faces −x, two leaves behind it.
    quad(&mut s, side(0.0, false), colour(1.0, 0.0));
    quad(&mut s, side(-0.09, true), colour(0.0, 1.0));
    quad(&mut s, side(1.0, true), grey(1.0));
    let facing = s.triangles[0].n0.x;
    assert!(facing > 0.5, "the red wall faces the receiver: {facing}");
    let view = view(&camera(v(0.5, 0.0, 0.0), v(1.0, 0.0, 0.0), 60.0), 16, 16);
    let mean = indirect(&s, &view, &VoxelCones { anisotropic, cones: 6, ..at(64) }, true).mean();
    assert!(mean.x > 0.05, "the red wall lights the receiver: {mean}");
    mean.y / mean.x
}

#[test]
fn walls_of_two_colours_do_not_mix() {
    let (directional, mixed) = (green_share(true), green_share(false));
    println!("green seen from the red side: {directional:.4}, with one value for all directions {mixed:.4}");
    assert!(directional < 0.02, "{directional}");
    assert!(mixed > 0.1, "negative control: {mixed}");
}

#[test]
fn magnitudes_do_not_matter() {
    let s = Scene::open("cornell-box").unwrap();
    let camera_of = |k: f32| {
        let c = s.view();
        camera(c.eye * k, c.target * k, c.fov)
    };
    let base = indirect(&s, &view(&camera_of(1.0), 24, 24), &at(32), false);
    for (size, power) in [(1e-3f32, 1.0f32), (1e3, 1.0), (1.0, 1e-6), (1.0, 1e6)] {
        let mut other = s.clone();
        for t in &mut other.triangles {
            for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
                *p = (p.truncate() * size).extend(p.w);
            }
        }
        for l in &mut other.lights {
            l.position = (l.position.truncate() * size).extend(0.0);
            l.intensity *= power * size * size;
        }
        let got = indirect(&other, &view(&camera_of(size), 24, 24), &at(32), false).mean().y / power;
        let off = got / base.mean().y - 1.0;
        println!("size × {size:e}, power × {power:e}: {:.2} % off", 100.0 * off);
        assert!(off.abs() < 0.02, "{off}");
    }
}

fn reference(s: &Scene, bounces: u32, samples: u32, side: u32) -> Picture {
    let view = view(&s.view(), side, side);
    let settings = twinlight::technique::reference::Reference {
        emissive: false,
        ..settings(Bounces::Count(bounces), samples)
    };
    trace(s, &view, &settings).indirect
}

#[test]
fn a_second_bounce_adds_what_it_should() {
    let s = Scene::open("cornell-box").unwrap();
    let view = view(&s.view(), 48, 48);
    let right = reference(&s, 2, 1024, 48).mean().y / reference(&s, 1, 1024, 48).mean().y;
    let mean =
        |bounces| indirect(&s, &view, &VoxelCones { bounces, bounce_cones: 16, ..at(64) }, false).mean().y;
    let (one, two, eight, nine) = (mean(1), mean(2), mean(8), mean(9));
    println!(
        "two bounces over one: {:.3}, path tracer {right:.3}; gain of the ninth {:.4}",
        two / one,
        nine / eight
    );
    assert!(((two / one) / right - 1.0).abs() < 0.1, "{} for {right}", two / one);
    assert!(nine >= eight && nine / eight < 1.01, "bounces do not converge: {eight}, {nine}");
}

#[test]
fn the_sky_lights_voxels() {
    let mut s = Scene::open("cornell-box").unwrap();
    s.lights.clear();
    s.environment = Environment::Constant(Vec3::new(0.5, 0.7, 1.0));
    let view = view(&s.view(), 48, 48);
    let got = indirect(&s, &view, &VoxelCones { bounce_cones: 16, ..at(64) }, false).mean();
    let right = reference(&s, 1, 1024, 48).mean();
    println!("sky: {got} for {right}");
    assert!((got / right - Vec3::ONE).abs().max_element() < 0.25, "{got} for {right}");
    let dark = Scene { environment: Environment::None, ..s };
    let job = Job { light: LightPart::Indirect, ..Job::default() };
    let (rendered, counts) = render_on(&mut cpu(), &dark, &view, &job, &at(32), false);
    assert!(rendered.picture.mean() == Vec3::ZERO && counts.lit == 0);
}

#[test]
fn emissive_surfaces_count_once() {
    // A floor under a large lamp.
    let mut s = scene();
    square(&mut s, 0.0, 1.0, true, grey(0.5));
    square(&mut s, 1.0, 1.0, false, emitter(0.0, 1.0));
    let view = view(&camera(v(0.0, 0.5, 1.9), v(0.0, 0.0, 0.0), 20.0), 24, 24);
    let settings = VoxelCones { cones: 48, illumination: Some((24, 24)), ..at(128) };
    let job = Job { rays: 256, ..Job::default() };
    let all = render_on(&mut cpu(), &s, &view, &job, &settings, true).0.picture.mean().y;
    let rays = Job { light: LightPart::Direct, ..job };
    let right = render_on(&mut cpu(), &s, &view, &rays, &settings, true).0.picture.mean().y;
    println!("a lamp by cones {all:.4}, by rays {right:.4}");
    assert!((all / right - 1.0).abs() < 0.25, "{all} for {right}: light is counted twice or lost");
}
