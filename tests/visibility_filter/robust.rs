//! Do odd scenes, sizes and magnitudes give finite, sensible light?

use crate::support::*;
use crate::{cpu, render_on};
use glam::Vec3;
use twinlight::scene::{BUILT_IN, Scene, light};
use twinlight::technique::visibility_filter::{Anchor, Clamp, DUMPS, Gather, VisibilityFilter};
use twinlight::technique::{Job, View};

fn small() -> VisibilityFilter {
    VisibilityFilter { proxies: 4_000, grid: [6; 3], rays: 16, lobe_rays: 4, ..Default::default() }
}

fn checked(s: &Scene, view: &View, settings: &VisibilityFilter) -> Vec3 {
    let job = Job { rays: 4, check_finite: true, ..Job::default() };
    let (rendered, counts) = render_on(&mut cpu(), s, view, &job, settings);
    assert!(rendered.non_finite.len() > 5, "{:?}", rendered.non_finite);
    for n in &rendered.non_finite {
        assert_eq!(n.count, 0, "{}: {} values of {} are not finite ({counts:?})", s.name, n.count, n.buffer);
    }
    rendered.picture.mean()
}

#[test]
fn every_buffer_is_finite_on_every_scene_with_any_knobs() {
    for name in BUILT_IN {
        let mut s = Scene::open(name).unwrap();
        s.lights.push(light::sun(v(0.2, -1.0, 0.1).normalize(), Vec3::ONE));
        let view = view(&s.view(), 40, 30);
        for settings in [
            small(),
            VisibilityFilter { gather: Gather::Sum, clamp: Clamp::None, near_range: Some(1e9), ..small() },
            VisibilityFilter { anchor: Anchor::World, near_range: Some(0.0), trust: 0.0, ..small() },
            VisibilityFilter { proxies: 1, grid: [1; 3], rays: 1, filter: (0, 0), ..small() },
            VisibilityFilter { grid: [1, 90, 2], capacity: Some(1), light_map: 1, overlap: 0.1, ..small() },
        ] {
            assert!(checked(&s, &view, &settings).is_finite());
        }
    }
}

#[test]
fn odd_scenes() {
    let mut lonely = scene();
    lonely.materials.push(grey(0.5));
    lonely.triangles.push(Scene::open("cornell-box").unwrap().triangles[0]);
    lonely.triangles[0].material = 0;
    lonely.lights = vec![light::point(v(0.0, 1.0, 0.0), Vec3::ONE)];
    let mut holes = scene();
    square(&mut holes, 0.0, 1.0, true, masked(0.1));
    holes.lights = lonely.lights.clone();
    let mut dark = Scene::open("cornell-box").unwrap();
    dark.lights.clear();
    let mut far = Scene::open("cornell-box").unwrap();
    for t in &mut far.triangles {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p += v(3e4, -1e4, 2e4).extend(0.0);
        }
    }
    far.lights[0].position += v(3e4, -1e4, 2e4).extend(0.0);
    let camera = camera(v(0.0, 1.0, 3.9), v(0.0, 1.0, 0.0), 40.0);
    for (what, s) in [("one triangle", &lonely), ("holes only", &holes), ("no light", &dark)] {
        let mean = checked(s, &view(&camera, 24, 24), &small());
        assert!(mean.is_finite(), "{what}");
        assert_eq!(what == "one triangle", mean.x > 0.0, "{what}: {mean}");
    }
    let shift = v(3e4, -1e4, 2e4);
    let shifted =
        twinlight::scene::Camera { eye: camera.eye + shift, target: camera.target + shift, ..camera };
    let near = checked(&Scene::open("cornell-box").unwrap(), &view(&camera, 24, 24), &small());
    let mean = checked(&far, &view(&shifted, 24, 24), &small());
    assert!((mean.y / near.y - 1.0).abs() < 0.1, "{mean} far from the origin, {near} near it");
}

#[test]
fn every_dump_is_made_when_asked_for() {
    let s = Scene::open("cornell-glossy").unwrap();
    let view = view(&s.view(), 48, 32);
    let dumps: Vec<String> = DUMPS.iter().filter(|d| **d != "emission").map(|d| d.to_string()).collect();
    let job = Job { dumps: dumps.clone(), ..Job::default() };
    let (rendered, _) = render_on(&mut cpu(), &s, &view, &job, &small());
    let plain = render_on(&mut cpu(), &s, &view, &Job::default(), &small()).0;
    assert!(same_bits(&rendered.picture, &plain.picture), "looking changes nothing");
    assert!(plain.dumps.is_empty());
    for name in dumps {
        let picture = rendered.dumps.get(&name).unwrap_or_else(|| panic!("{name} is missing"));
        let expected =
            if ["diffuse", "specular", "visible-count"].contains(&name.as_str()) { 24 } else { 48 };
        assert_eq!(picture.width, expected, "{name}");
        assert!(picture.mean().max_element() > 0.0, "{name} is black");
    }
}
