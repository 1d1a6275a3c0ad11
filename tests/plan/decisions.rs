//! Does a plan decide as the scene and the request ask, and say why?

use crate::{request, techniques};
use glam::Vec3;
use twinlight::backend::Cpu;
use twinlight::plan::{Effect, Plan, Request, Technique, choose};
use twinlight::renderer::Renderer;
use twinlight::scene::{Environment, Scene};
use twinlight::technique::LightPart;

fn plan(scene: &Scene, technique: &Technique, change: impl Fn(&mut Request)) -> Plan {
    let mut request = request(scene, technique, false, LightPart::All);
    change(&mut request);
    Plan::new(scene, &request).unwrap()
}

#[test]
fn effects_follow_from_the_scene_and_the_request() {
    let (plain, glossy) = (Scene::open("cornell-box").unwrap(), Scene::open("cornell-glossy").unwrap());
    let cones = &techniques()[5];
    let all = plan(&glossy, cones, |r| r.emissive = true);
    use Effect::*;
    assert_eq!(all.effects(), [Lights, Emission, Gloss, Bounce, SpecularBounce, FurtherBounces]);
    assert_eq!(plan(&plain, cones, |_| ()).effects(), [Lights, Bounce, FurtherBounces]);
    assert_eq!(plan(&plain, cones, |r| r.job.light = LightPart::Direct).effects(), [Lights]);
    assert_eq!(
        plan(&plain, cones, |r| r.job.light = LightPart::Indirect).effects(),
        [Bounce, FurtherBounces]
    );
    let asked = plan(&glossy, cones, |r| r.effects = Some(vec![Lights, Bounce]));
    assert_eq!(asked.effects(), [Lights, Bounce]);
    assert!(asked.text().contains("not among the effects asked for"));
    let Technique::VoxelCones(settings) = &asked.technique else { panic!() };
    assert_eq!(settings.bounces, 1, "knobs follow the effects");
    let straight = plan(&glossy, cones, |r| r.effects = Some(vec![Lights]));
    assert_eq!(straight.job.light, LightPart::Direct);
    let bounce = plan(&glossy, cones, |r| r.effects = Some(vec![Bounce]));
    assert_eq!(bounce.job.light, LightPart::Indirect);
    for d in all.decisions.iter().chain(&asked.decisions) {
        assert!(!d.why.is_empty() && (!d.called || d.bound.is_none()), "{d:?}");
    }
}

#[test]
fn quality_leaves_out_what_can_add_little() {
    let mut scene = Scene::open("cornell-box").unwrap();
    for m in &mut scene.materials {
        m.base = Vec3::splat(0.1).extend(1.0);
    }
    let cones = &techniques()[5];
    let further = 0.01 / 0.9;
    let at = |quality: f64| plan(&scene, cones, |r| r.quality = quality);
    assert!(at(0.0).calls(Effect::FurtherBounces));
    let left = at(0.02);
    assert!(!left.calls(Effect::FurtherBounces) && left.calls(Effect::Bounce));
    let bound = left.decisions.iter().find(|d| d.effect == Effect::FurtherBounces).unwrap().bound.unwrap();
    assert!((bound.share - further).abs() < 1e-6, "{bound}");
    assert!(!at(0.11).calls(Effect::Bounce));
    let mut bad = request(&scene, cones, false, LightPart::All);
    bad.quality = f64::NAN;
    assert!(Plan::new(&scene, &bad).unwrap_err().to_string().contains("quality"));
}

#[test]
fn auto_follows_from_the_census() {
    let of = |s: &Scene, light, moving| choose(&s.census(), light, false, moving).0;
    let (plain, spheres) = (Scene::open("cornell-box").unwrap(), Scene::open("spheres").unwrap());
    assert_eq!(of(&plain, LightPart::All, false), "visibility-filter");
    assert_eq!(of(&plain, LightPart::All, true), "layered-rsm");
    assert_eq!(of(&plain, LightPart::Direct, false), "direct");
    assert_eq!(of(&spheres, LightPart::All, false), "soft-gi");
    let mut sky = Scene { lights: Vec::new(), ..plain.clone() };
    assert_eq!(of(&sky, LightPart::All, false), "direct");
    sky.environment = Environment::Constant(Vec3::ONE);
    assert_eq!(of(&sky, LightPart::All, false), "voxel-cones");
}

#[test]
fn a_budget_leaves_out_effects_until_it_fits() {
    let scene = Scene::open("cornell-glossy").unwrap();
    let request = request(&scene, &techniques()[5], false, LightPart::All);
    let mut renderer = Renderer::new(Cpu::new(Some(2)).unwrap(), scene).unwrap();
    let within = |r: &mut Renderer<Cpu>, seconds: f64| {
        r.plan_within(&request, std::time::Duration::from_secs_f64(seconds)).unwrap()
    };
    let (roomy, expected) = within(&mut renderer, 1e4);
    assert!(roomy.calls(Effect::FurtherBounces) && expected.as_nanos() > 0);
    let (tight, _) = within(&mut renderer, 1e-9);
    assert_eq!(tight.effects(), [Effect::Lights], "nothing more can be left out");
    assert_eq!(renderer.plan(&request).unwrap(), roomy);
}
