//! No light comes through closed walls or along their edges.

use crate::support::*;
use crate::{direct_light, openness};
use glam::Vec3;
use twinlight::scene::{Environment, Scene, light};
use twinlight::technique::gbuffer::GBuffer;
use twinlight::technique::reference::Bounces;
use twinlight::technique::{Inspection, Job, World};

/// Glaring light from everywhere outside of a room of half size `reach`.
fn glare(s: &mut Scene, centre: Vec3, reach: f32) {
    s.environment = Environment::Constant(Vec3::splat(1e3));
    s.lights.clear();
    for direction in [Vec3::X, Vec3::Y, Vec3::Z, Vec3::ONE.normalize(), v(-0.6, 0.64, 0.48)] {
        for direction in [direction, -direction] {
            s.lights.push(light::sun(direction, Vec3::splat(1e3)));
            s.lights.push(light::point(centre + direction * reach, Vec3::splat(1e5)));
        }
    }
}

#[test]
fn a_sealed_room_is_dark_wherever_one_looks() {
    for (turn, half) in
        [(0.0, Vec3::ONE), (0.2, v(1.0, 0.6, 1.7)), (1.1, v(30.0, 4.0, 11.0)), (2.5, v(0.01, 0.02, 0.03))]
    {
        let mut s = scene();
        room(&mut s, half, turn, grey(0.9));
        glare(&mut s, Vec3::ZERO, 3.0 * half.max_element());
        for target in [Vec3::ONE, -Vec3::ONE, v(1.0, -0.3, 0.2)] {
            let view = view(&camera(half * 0.1, half * target, 120.0), 120, 90);
            let picture = direct_light(&s, &view, &Job { rays: 16, ..Job::default() }, false);
            let lit = picture.pixels.iter().filter(|p| **p != Vec3::ZERO).count();
            assert_eq!(lit, 0, "turn {turn}, half {half}, towards {target}");
            let reference = trace(&s, &view, &settings(Bounces::Count(2), 2)).all();
            let lit = reference.pixels.iter().filter(|p| **p != Vec3::ZERO).count();
            assert_eq!(lit, 0, "reference: turn {turn}, half {half}, towards {target}");
        }
        s.triangles.pop();
        let view = view(&camera(half * 0.1, half, 120.0), 120, 90);
        let picture = direct_light(&s, &view, &Job { rays: 16, ..Job::default() }, false);
        assert!(picture.mean().x > 1.0, "negative control: a missing triangle");
    }
}

/// The Cornell box with its front closed, and glare outside.
fn closed_cornell() -> Scene {
    let mut s = Scene::open("cornell-box").unwrap();
    quad(&mut s, [v(-1.0, 0.0, 1.0), v(-1.0, 2.0, 1.0), v(1.0, 2.0, 1.0), v(1.0, 0.0, 1.0)], grey(0.7));
    glare(&mut s, v(0.0, 1.0, 0.0), 4.0);
    s
}

#[test]
fn a_closed_cornell_box_is_dark_to_its_edges() {
    let s = closed_cornell();
    for (eye, target) in [
        (v(0.0, 1.0, 0.97), v(0.0, 1.0, 0.0)),
        (v(0.9, 1.9, -0.9), v(-1.0, 0.0, 1.0)),
        (v(0.02, 0.02, 0.9), v(-1.0, 0.0, -1.0)),
    ] {
        let view = view(&camera(eye, target, 100.0), 400, 300);
        for picture in [
            direct_light(&s, &view, &Job { rays: 8, ..Job::default() }, false),
            openness(&s, &view, &Job { rays: 8, ..Job::default() }),
        ] {
            let lit: Vec<_> =
                (0..picture.pixels.len()).filter(|i| picture.pixels[*i] != Vec3::ZERO).collect();
            assert!(lit.is_empty(), "{} pixels from {eye}, first {:?}", lit.len(), &lit[..lit.len().min(5)]);
        }
    }
}

/// Openness of pixels within 10 mm of an edge between two walls of the open Cornell box, and their number.
fn edge_openness(with_back_wall: bool) -> (f32, usize) {
    let mut s = Scene::open("cornell-box").unwrap();
    s.triangles.truncate(10); // walls only
    if !with_back_wall {
        s.triangles.drain(4..6);
    }
    let view = view(&camera(v(0.0, 1.0, 0.3), v(0.0, 0.0, -1.0), 60.0), 600, 600);
    let job = Job { rays: 64, ..Job::default() };
    let picture = openness(&s, &view, &job);
    let mut cpu = twinlight::backend::Cpu::new(Some(2)).unwrap();
    let w = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
    let mut seen = Inspection::new(&job, view.width, view.height);
    let g = GBuffer::trace(&mut cpu, &w, &view, 0..view.pixels(), &mut seen).unwrap();
    let (mut most, mut count) = (0.0f32, 0);
    for (p, surface) in picture.pixels.iter().zip(g.surfaces.as_slice()) {
        let p0 = surface.position;
        if p0.w < 0.0 {
            continue;
        }
        let walls = [1.0 - p0.x.abs(), p0.y, 2.0 - p0.y, p0.z + 1.0];
        if walls.iter().filter(|d| **d < 0.01).count() >= 2 {
            most = most.max(p.x);
            count += 1;
        }
    }
    (most, count)
}

#[test]
fn edges_of_the_open_cornell_box_do_not_shine() {
    let (most, count) = edge_openness(true);
    println!("{count} pixels near an edge, the most open {most}");
    assert!(count > 500, "{count}");
    // One wall leaves half of the sky, and the room hides most of that; through the wall there would be all of a half.
    assert!(most < 0.3, "{most}");
    let open = edge_openness(false).0;
    assert!(open > 0.45, "negative control: without its back wall {open}");
}
