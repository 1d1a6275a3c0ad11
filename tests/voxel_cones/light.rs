//! Is brightness kept: from level to level, at any resolution, behind walls, between walls of two colours?

use crate::support::*;
use crate::{cpu, indirect, render_on};
use glam::{Vec3, Vec4};
use twinlight::picture::Picture;
use twinlight::scene::{Environment, Scene, light};
use twinlight::technique::reference::Bounces;
use twinlight::technique::voxel_cones::{Lighting, Pyramid, VoxelCones, Voxelisation};
use twinlight::technique::{Cones, Job, LightPart, World};
use twinlight_kernels::geometry::lattice::unpack_point;
use twinlight_kernels::passes::scene::Material;
use twinlight_kernels::passes::voxel_cones::storage::unpack_radiance;

fn at(resolution: u32) -> VoxelCones {
    VoxelCones { resolution, ..Default::default() }
}

#[test]
fn a_white_box_is_as_bright_at_any_resolution() {
    // A closed box of albedo 1 around a lamp: what arrives in one bounce is known from the path tracer.
    let mut s = scene();
    room(&mut s, v(1.0, 1.0, 1.0), 0.0, grey(1.0));
    s.lights = vec![light::point(v(0.1, 0.2, -0.1), Vec3::splat(3.0))];
    let view = view(&camera(v(0.0, 0.0, 0.9), v(0.0, -0.3, -1.0), 70.0), 24, 24);
    let right = trace(&s, &view, &settings_of(2048)).indirect.mean().y;
    let mut means = Vec::new();
    for resolution in [16, 64, 128, 256, 512] {
        let settings = VoxelCones { light_map: 2048, ..at(resolution) };
        let mean = indirect(&s, &view, &settings, false).mean().y / right;
        println!("{resolution}³: {mean:.4} of the path tracer's");
        means.push(mean);
    }
    // Cones miss a little where walls meet; what counts is that it does not depend on the resolution.
    for mean in &means {
        assert!((mean / means[2] - 1.0).abs() < 0.05, "brightness drifts: {means:?}");
        assert!((mean - 1.0).abs() < 0.1, "{mean} of the right brightness");
    }
}

#[test]
fn a_furnace_glows_as_it_should() {
    // Every wall emits 1 and has an albedo of 1: one bounce adds 1 everywhere.
    let mut s = scene();
    room(&mut s, v(1.0, 1.0, 1.0), 0.0, emitter(1.0, 1.0));
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
    let view = view(&camera(v(0.0, 0.0, 0.9), v(0.0, -0.3, -1.0), 70.0), 24, 24);
    let mut means = Vec::new();
    for resolution in [32, 64, 128] {
        let settings = VoxelCones { bounce_cones: 16, ..at(resolution) };
        let mean = indirect(&s, &view, &settings, true).mean().y;
        println!("{resolution}³: {mean:.4}");
        assert!((mean - 1.0).abs() < 0.2, "a furnace of radiance 1 adds {mean}");
        means.push(mean);
    }
    assert!((means[0] / means[2] - 1.0).abs() < 0.05, "{means:?}");
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
        base: Vec4::new(r, g, 0.0, 1.0),
        ..grey(0.0)
    };
    let side = |x: f32, flip: bool| {
        let mut p = [v(x, -1.0, 1.0), v(x, -1.0, -1.0), v(x, 1.0, -1.0), v(x, 1.0, 1.0)];
        if flip {
            p.swap(1, 3);
        }
        p
    };
    // Red faces +x, green faces −x, two leaves behind it, each with its own lamp.
    quad(&mut s, side(0.0, false), colour(1.0, 0.0));
    quad(&mut s, side(-0.09, true), colour(0.0, 1.0));
    quad(&mut s, side(1.0, true), grey(1.0));
    s.lights = vec![light::point(v(0.5, 0.0, 0.0), Vec3::ONE), light::point(v(-0.6, 0.0, 0.0), Vec3::ONE)];
    let view = view(&camera(v(0.5, 0.0, 0.0), v(1.0, 0.0, 0.0), 60.0), 16, 16);
    let mean = indirect(
        &s,
        &view,
        &VoxelCones { anisotropic, cones: Cones { count: 6, ..Cones::default() }, ..at(64) },
        false,
    )
    .mean();
    assert!(mean.x > 0.02, "the red wall lights the receiver: {mean}");
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
fn emissive_surfaces_shine_directly_and_once_more() {
    // A floor under a large lamp, with a wall beside it: the lamp's light is direct, the wall's is not.
    let mut s = scene();
    square(&mut s, 0.0, 1.0, true, grey(0.5));
    square(&mut s, 1.0, 1.0, false, emitter(0.0, 1.0));
    quad(&mut s, [v(-1.0, 0.0, -1.0), v(1.0, 0.0, -1.0), v(1.0, 1.0, -1.0), v(-1.0, 1.0, -1.0)], grey(0.8));
    let view = view(&camera(v(0.0, 0.4, 1.9), v(0.0, 0.0, 0.0), 40.0), 24, 24);
    let settings = VoxelCones {
        cones: Cones { count: 32, ..Cones::default() },
        bounce_cones: 16,
        illumination: Some((24, 24)),
        ..at(64)
    };
    let lit = |part, emissive| {
        let job = Job { rays: 256, light: part, ..Job::default() };
        render_on(&mut cpu(), &s, &view, &job, &settings, emissive).0.picture.mean().y
    };
    let (direct, indirect) = (lit(LightPart::Direct, true), lit(LightPart::Indirect, true));
    let all = lit(LightPart::All, true);
    let of_paths = twinlight::technique::reference::Reference {
        emissive: true,
        ..crate::support::settings(Bounces::Count(1), 4096)
    };
    let right = trace(&s, &view, &of_paths);
    let (right_direct, right_indirect) = (right.direct.mean().y, right.indirect.mean().y);
    println!("direct {direct:.4} for {right_direct:.4}, indirect {indirect:.4} for {right_indirect:.4}");
    assert!((direct / right_direct - 1.0).abs() < 0.03);
    assert!((indirect / right_indirect - 1.0).abs() < 0.2, "{indirect} for {right_indirect}");
    assert!((all - direct - indirect).abs() < 1e-3 * all, "{all} is not {direct} + {indirect}");
    assert!(lit(LightPart::Indirect, false) == 0.0, "negative control: nothing shines unless it may");
}

#[test]
fn a_dim_light_is_not_lost_beside_a_strong_one() {
    // Two closed rooms, one lamp in each: what do the dim one's leaves hold?
    let held = |strong: f32| {
        let mut s = scene();
        let mut one = scene();
        room(&mut one, v(0.5, 0.5, 0.5), 0.0, grey(0.8));
        for offset in [-1.0f32, 1.0] {
            for t in &one.triangles {
                let mut moved = *t;
                for p in [&mut moved.p0, &mut moved.p1, &mut moved.p2] {
                    p.x += offset;
                }
                s.triangles.push(moved);
            }
        }
        s.materials = one.materials;
        s.lights = vec![light::point(v(-1.0, 0.3, 0.0), Vec3::ONE)];
        if strong > 0.0 {
            s.lights.push(light::point(v(1.0, 0.3, 0.0), Vec3::splat(strong)));
        }
        let mut cpu = cpu();
        let world = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
        let p = Pyramid::build(&mut cpu, &world, &at(64)).unwrap();
        let lit = Lighting::new(&mut cpu, &world, &p, &at(64)).unwrap().reflected;
        let (places, radiance) = (cpu.download(&lit.places), cpu.download(&lit.radiance));
        let points = cpu.download(&p.points[0]);
        let dim = points.iter().enumerate().filter(|(_, point)| unpack_point(**point).x < 31);
        let held = dim.filter_map(|(leaf, _)| places[p.params.first as usize + leaf].checked_sub(1));
        let words = held.flat_map(|place| &radiance[6 * place as usize..][..6]);
        words.map(|&w| f64::from(unpack_radiance(w).y)).sum::<f64>() / f64::from(lit.radiance_scale)
    };
    let (alone, beside) = (held(0.0), held(1.0e5));
    println!("alone {alone:.1}, beside a light 10⁵ times as strong {beside:.1}");
    assert!((beside / alone - 1.0).abs() < 0.02, "{beside} for {alone}");
}

#[test]
fn a_small_sun_in_an_environment_map_is_not_missed() {
    // One bright texel of 64 × 32: cones that look up along their axis only would see it or not.
    let mut s = scene();
    square(&mut s, 0.0, 1.0, true, grey(0.5));
    quad(&mut s, [v(-1.0, 0.0, -1.0), v(1.0, 0.0, -1.0), v(1.0, 1.5, -1.0), v(-1.0, 1.5, -1.0)], grey(0.8));
    let view = view(&camera(v(0.0, 0.6, 2.4), v(0.0, 0.3, 0.0), 45.0), 24, 24);
    let mut ratios = Vec::new();
    for (column, row) in [(28u32, 6u32), (29, 7), (31, 5), (33, 8), (35, 4), (36, 9)] {
        let mut data = vec![Vec4::splat(0.1); 64 * 32];
        // u = 0 looks along −z … column 0 and 63 face the wall's front.
        let column = (column + 32) % 64;
        data[(row * 64 + column) as usize] = Vec4::splat(200.0);
        let map = twinlight::scene::EnvironmentMap { width: 64, height: 32, data };
        s.environment = Environment::Map(map);
        let settings = VoxelCones { bounce_cones: 16, ..at(64) };
        let got = indirect(&s, &view, &settings, false).mean().y;
        let of_paths = settings_of(2048);
        let right = trace(&s, &view, &of_paths).indirect.mean().y;
        println!("texel {column}, {row}: {got:.4} for {right:.4}");
        ratios.push(got / right);
    }
    let mean = ratios.iter().sum::<f32>() / ratios.len() as f32;
    assert!((mean - 1.0).abs() < 0.25, "{mean}: {ratios:?}");
    assert!(ratios.iter().all(|r| (0.4..2.0).contains(r)), "{ratios:?}");
}

fn settings_of(samples: u32) -> twinlight::technique::reference::Reference {
    twinlight::technique::reference::Reference {
        emissive: false,
        ..crate::support::settings(Bounces::Count(1), samples)
    }
}

#[test]
fn what_emits_sends_as_much_however_it_is_voxelised() {
    // Voxels under the diagonal have two of its triangles: counted fully each, they would send twice as much.
    let mut s = scene();
    room(&mut s, v(1.0, 1.0, 1.0), 0.0, grey(0.5));
    let emitter = Material { emission: Vec3::splat(2.0).extend(0.0), ..grey(0.0) };
    square(&mut s, 0.9, 0.4, false, emitter);
    let view = view(&camera(v(0.0, 0.0, 0.9), v(0.0, -0.2, 0.0), 60.0), 16, 16);
    let mean = |voxelisation| {
        let settings = VoxelCones { voxelisation, resolution: 32, bounce_cones: 16, ..Default::default() };
        indirect(&s, &view, &settings, true).mean().y
    };
    let (area, thin) = (mean(Voxelisation::Area), mean(Voxelisation::Thin));
    println!("by area {area:.4}, thin {thin:.4}");
    assert!(area > 0.0 && (thin / area - 1.0).abs() < 0.25, "{area}, {thin}");
}
