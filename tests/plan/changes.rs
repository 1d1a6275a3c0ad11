//! Are frames after a change those that are rendered from nothing, and does only run what the change calls for?

use crate::support::{same_bits, strict_gpu, v};
use crate::{request, techniques};
use glam::Vec3;
use twinlight::backend::{Backend, Cpu};
use twinlight::plan::{Change, Request, Technique};
use twinlight::renderer::Renderer;
use twinlight::scene::{Camera, Environment, Scene, light};
use twinlight::technique::{LightPart, View};

/// A scene after each of some changes, and from where it is seen.
fn states() -> Vec<(&'static [Change], Scene, Camera)> {
    let mut scene = Scene::open("cornell-glossy").unwrap();
    scene.environment = Environment::Constant(Vec3::splat(0.1));
    let camera = scene.view();
    let aside = Camera { eye: camera.eye + v(0.1, 0.05, 0.0), ..camera };
    let mut lit = scene.clone();
    lit.lights[0].position += v(0.1, 0.0, 0.1).extend(0.0);
    let mut moved = lit.clone();
    let count = moved.triangles.len();
    for t in &mut moved.triangles[count - 4..] {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p += v(0.03, 0.0, 0.02).extend(0.0);
        }
    }
    let mut again = moved.clone();
    for t in &mut again.triangles[count - 4..] {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p += v(0.0, 0.0, 0.03).extend(0.0);
        }
    }
    let mut painted = again.clone();
    painted.materials[0].base *= 0.5;
    let mut sky = painted.clone();
    sky.environment = Environment::Constant(Vec3::new(0.3, 0.1, 0.2));
    let mut more = sky.clone();
    more.lights.push(light::point(v(0.0, 1.5, 0.3), Vec3::splat(0.5)));
    vec![
        (&[], scene.clone(), camera),
        (&[], scene, aside),
        (&[Change::Lights], lit, aside),
        (&[Change::Meshes], moved, aside),
        (&[Change::Meshes], again, aside),
        (&[Change::Materials], painted, aside),
        (&[Change::Lights], sky, camera),
        (&[Change::Lights], more, camera),
    ]
}

/// Renders the states one after the other, and each from nothing.
fn compare<B: Backend>(mut backend: impl FnMut() -> B, technique: &Technique) {
    let states = states();
    let mut renderer = Renderer::new(backend(), states[0].1.clone()).unwrap();
    let mut before = None;
    for (number, (changes, scene, camera)) in states.iter().enumerate() {
        let what = format!("{} {number} {changes:?}", technique.name());
        let view = View::new(camera, 24, 20).unwrap();
        let request = Request { view, ..request(scene, technique, false, LightPart::All) };
        assert_eq!(renderer.update(scene.clone()).unwrap(), *changes, "{what}");
        let plan = renderer.plan(&request).unwrap();
        let kept = renderer.render(&plan).unwrap().rendered;
        let anew = Renderer::new(backend(), scene.clone()).unwrap().render(&plan).unwrap().rendered;
        assert!(same_bits(&kept.picture, &anew.picture), "{what}: not as from nothing");
        // Each change is seen, or the comparison would say nothing.
        let differs = before.as_ref().is_none_or(|b| !same_bits(b, &kept.picture));
        let occlusion = matches!(technique, Technique::AmbientOcclusion)
            || matches!(technique, Technique::VoxelCones(s) if s.occlusion);
        let proxies_alone = matches!(technique, Technique::SoftGi(_));
        assert!(differs || occlusion || proxies_alone, "{what}: nothing changed");
        let ran = |stage: &str| kept.timings.iter().any(|t| t.stage == stage);
        if number > 0 && !changes.contains(&Change::Meshes) && !changes.contains(&Change::Materials) {
            assert!(!ran("voxelisation"), "{what}: voxelised again");
            if changes.is_empty() {
                assert!(!ran("injection") && !ran("lighting") && !ran("maps"), "{what}: lit again");
            } else if !occlusion && !matches!(technique, Technique::SoftGi(_)) && number == 2 {
                assert!(kept.timings.iter().all(|t| t.pass != "trace_primary"), "{what}: seen again");
            }
        }
        // Nothing changed: nothing runs.
        let still = renderer.render(&plan).unwrap().rendered;
        assert!(still.timings.is_empty() && same_bits(&still.picture, &kept.picture), "{what}");
        before = Some(kept.picture);
    }
}

#[test]
fn frames_after_changes_are_those_from_nothing() {
    for technique in techniques() {
        compare(|| Cpu::new(Some(2)).unwrap(), &technique);
    }
}

#[test]
fn the_strict_gpus_frames_are_too() {
    if strict_gpu().is_none() {
        return;
    }
    for technique in techniques().into_iter().step_by(2) {
        compare(|| strict_gpu().unwrap(), &technique);
    }
}

#[test]
fn meshes_that_move_alone_are_voxelised_alone() {
    let still = Scene::open("cornell-glossy").unwrap();
    let count = still.triangles.len();
    let technique = &techniques()[4];
    let mut renderer = Renderer::new(Cpu::new(Some(2)).unwrap(), still.clone()).unwrap();
    let mut pairs = Vec::new();
    for frame in 0..4 {
        let mut triangles = still.triangles[count - 4..].to_vec();
        for t in &mut triangles {
            for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
                p.x += 0.02 * frame as f32;
            }
        }
        renderer.set_triangles(count - 4, &triangles).unwrap();
        let plan = renderer.plan(&request(&still, technique, false, LightPart::All)).unwrap();
        let kept = renderer.render(&plan).unwrap().rendered;
        let scene = renderer.scene().clone();
        let anew = Renderer::new(Cpu::new(Some(2)).unwrap(), scene).unwrap().render(&plan).unwrap().rendered;
        assert!(same_bits(&kept.picture, &anew.picture), "frame {frame}");
        pairs.push(kept.timings.iter().filter(|t| t.pass == "root_pairs").map(|t| t.items).sum::<u32>());
    }
    // All; all but those that move, and those; those alone from then on.
    let (all, own) = (2 * count as u32, 8);
    assert_eq!(pairs, [all, all, own, own], "two words for each triangle");
}

#[test]
fn notifications_reach_the_picture() {
    let scene = Scene::open("cornell-box").unwrap();
    let request = request(&scene, &techniques()[4], false, LightPart::All);
    let mut renderer = Renderer::new(Cpu::new(Some(2)).unwrap(), scene.clone()).unwrap();
    let mut before = renderer.render(&renderer.plan(&request).unwrap()).unwrap().rendered.picture;
    let mut lights = scene.lights.clone();
    lights[0].intensity *= 0.5;
    renderer.set_lights(&lights).unwrap();
    let mut materials = scene.materials.clone();
    materials[0].base *= 0.5;
    let mut moved = scene.triangles[2];
    moved.p0.y += 0.05;
    for step in 0..4 {
        match step {
            0 => {}
            1 => renderer.set_materials(&materials).unwrap(),
            2 => renderer.set_triangles(2, &[moved]).unwrap(),
            _ => renderer.set_environment(Environment::Constant(Vec3::ONE)).unwrap(),
        }
        let plan = renderer.plan(&request).unwrap();
        let now = renderer.render(&plan).unwrap().rendered.picture;
        assert!(!same_bits(&before, &now), "step {step} is not seen");
        let anew = Renderer::new(Cpu::new(Some(2)).unwrap(), renderer.scene().clone())
            .unwrap()
            .render(&plan)
            .unwrap();
        assert!(same_bits(&now, &anew.rendered.picture), "step {step}");
        before = now;
    }
}
