//! Are a plan's passes, pipelines, buffers and bytes those that the backend counts, and none of an effect that is not called for?

use crate::{request, scenes, techniques};
use twinlight::backend::{Allocation, Backend, Cpu, Gpu, GpuOptions};
use twinlight::plan::{Costs, Effect, Plan, Technique};
use twinlight::renderer::Renderer;
use twinlight::scene::Scene;
use twinlight::technique::LightPart;
use twinlight_kernels::passes::PassTiming;

/// What a backend counts while it renders a plan's picture.
struct Counted {
    passes: Vec<(&'static str, &'static str, u32, u64)>,
    buffers: Vec<Allocation>,
}

fn names(list: &[PassTiming]) -> Vec<(&'static str, &'static str, u32, u64)> {
    list.iter().map(|t| (t.stage, t.pass, t.items, t.bytes)).collect()
}

/// Renders on a backend that counts; returns it too.
fn counted<B: Backend>(mut backend: B, scene: &Scene, plan: &Plan) -> (Counted, B::Buffer<u32>, Renderer<B>) {
    backend.log_allocations(true);
    let mut renderer = Renderer::new(backend, scene.clone()).unwrap();
    let passes = names(&renderer.render(plan).unwrap().rendered.timings);
    let buffers = renderer.backend_mut().take_allocations();
    let probe = renderer.backend_mut().alloc("probe", 1).unwrap();
    (Counted { passes, buffers }, probe, renderer)
}

fn assert_same(what: &str, costs: &Costs, counted: &Counted) {
    let planned = names(&costs.passes);
    for (i, (a, b)) in planned.iter().zip(&counted.passes).enumerate() {
        assert_eq!(a, b, "{what}: pass {i}");
    }
    assert_eq!(planned.len(), counted.passes.len(), "{what}: passes");
    for (i, (a, b)) in costs.buffers.iter().zip(&counted.buffers).enumerate() {
        assert_eq!(a, b, "{what}: buffer {i}");
    }
    assert_eq!(costs.buffers.len(), counted.buffers.len(), "{what}: buffers");
}

/// Passes and buffers that exist for an effect alone.
fn own(effect: Effect) -> (&'static [&'static str], &'static [&'static str]) {
    match effect {
        Effect::Lights => (&["light_visibility", "shade_diffuse", "shade_specular"], &["visibility"]),
        Effect::SoftShadows => (&["shadow_cone", "shade_soft_diffuse", "shade_soft_specular"], &["shadow"]),
        Effect::Environment => (&["fill_background"], &["environment"]),
        Effect::Emission => (&["resolve_emission", "mark_emissive", "inject_emission"], &["emission"]),
        Effect::Gloss => (
            &[
                "resolve_gloss",
                "shade_specular",
                "shade_soft_specular",
                "add_lobes",
                "inject_lobes",
                "filter_lobes",
            ],
            &["gloss", "proxy gloss", "lobes"],
        ),
        Effect::Bounce => (
            &[
                "cone_diffuse",
                "gather_diffuse",
                "layered_diffuse",
                "inject_photons",
                "filter_lists",
                "split_layers",
            ],
            &["lists"],
        ),
        Effect::SpecularBounce => (
            &[
                "cone_specular",
                "layered_specular",
                "gather_specular",
                "lobe_coverage",
                "add_specular_reflection",
            ],
            &["specular light"],
        ),
        Effect::FurtherBounces => (&["add_bounce"], &[]),
        Effect::ProxyShadows => (&["accumulate_occlusion"], &[]),
        Effect::ProxyBounce => {
            (&["accumulate_indirect", "combine_soft"], &["exact operator", "reflected light"])
        }
        Effect::Occlusion => (&["cone_openness"], &[]),
    }
}

/// Whether something else that is called for needs what mostly belongs to an effect.
fn shared(effect: Effect, plan: &Plan) -> bool {
    let soft_gi = matches!(plan.technique, Technique::SoftGi(_));
    let filter = matches!(plan.technique, Technique::VisibilityFilter(_));
    match effect {
        // Proxies are lit too.
        Effect::Lights => filter && plan.gathers(),
        // The surroundings stay behind what soft-gi lights; there proxies are lit too.
        Effect::Environment => {
            soft_gi && (plan.calls(Effect::ProxyShadows) || plan.calls(Effect::ProxyBounce))
        }
        // Their light is spread over voxels as a bounce is.
        Effect::FurtherBounces => plan.calls(Effect::Emission) || plan.calls(Effect::Environment),
        // What hides a part of a proxy's light is told by what they shadow.
        Effect::ProxyShadows => plan.calls(Effect::ProxyBounce),
        _ => false,
    }
}

#[test]
fn what_is_planned_is_what_runs() {
    // One device for all: drivers do not open hundreds.
    let mut gpu = Gpu::new(&GpuOptions::default()).ok();
    assert!(gpu.is_some() || crate::support::strict_gpu().is_none());
    for scene in scenes() {
        for (number, technique) in techniques().iter().enumerate() {
            for (emissive, light) in [
                (false, LightPart::All),
                (true, LightPart::All),
                (false, LightPart::Direct),
                (true, LightPart::Indirect),
            ] {
                let request = request(&scene, technique, emissive, light);
                let what =
                    format!("{}, {} {number}, {light:?}, emissive {emissive}", scene.name, technique.name());
                let plan = Plan::new(&scene, &request).unwrap();
                let costs = twinlight::renderer::costs(&scene, &crate::support::tree(&scene), &plan).unwrap();
                let (on_cpu, ..) = counted(Cpu::new(Some(2)).unwrap(), &scene, &plan);
                assert_same(&what, &costs, &on_cpu);
                for effect in Effect::ALL.into_iter().filter(|&e| !plan.calls(e)) {
                    let (passes, buffers) = own(effect);
                    for p in &on_cpu.passes {
                        let for_it = passes.contains(&p.1) && !shared(effect, &plan);
                        assert!(!for_it, "{what}: {} ran without {}", p.1, effect.name());
                    }
                    let stand_ins = ["no gloss", "lobe coverage"];
                    for b in &on_cpu.buffers {
                        // What must be bound and is not read has one element.
                        let bare =
                            !plan.calls(Effect::SpecularBounce) && stand_ins.contains(&b.label.as_str());
                        assert!(!bare || b.bytes <= 16, "{what}: {b:?}");
                        let for_it = buffers.contains(&b.label.as_str()) && !shared(effect, &plan);
                        assert!(!for_it, "{what}: {b:?} without {}", effect.name());
                    }
                }
                // Pipelines are the GPU's alone: one request for each scene and technique.
                if let Some(mut device) = gpu.take_if(|_| !emissive && light == LightPart::All) {
                    device.forget_pipelines();
                    let (on_gpu, _, renderer) = counted(device, &scene, &plan);
                    assert_eq!(renderer.backend().pipeline_names(), costs.pipelines(), "{what}");
                    // Rounding decides about a voxel here and there in fast arithmetic: names alone.
                    let name = |p: &(&'static str, &'static str, u32, u64)| (p.0, p.1);
                    let planned: Vec<_> = names(&costs.passes).iter().map(name).collect();
                    assert_eq!(on_gpu.passes.iter().map(name).collect::<Vec<_>>(), planned, "{what}");
                    gpu = Some(renderer.into_backend());
                }
            }
        }
    }
}

/// Planted faults: the comparison above finds a pass, a buffer, a byte more or less.
#[test]
#[should_panic(expected = "buffer")]
fn a_byte_more_would_be_found() {
    let scene = Scene::open("cornell-box").unwrap();
    let request = request(&scene, &Technique::Direct, false, LightPart::All);
    let plan = Plan::new(&scene, &request).unwrap();
    let mut costs = twinlight::renderer::costs(&scene, &crate::support::tree(&scene), &plan).unwrap();
    costs.buffers[3].bytes += 1;
    assert_same("planted", &costs, &counted(Cpu::new(Some(1)).unwrap(), &scene, &plan).0);
}

#[test]
#[should_panic(expected = "passes")]
fn a_pass_less_would_be_found() {
    let scene = Scene::open("cornell-box").unwrap();
    let request = request(&scene, &Technique::Direct, false, LightPart::All);
    let plan = Plan::new(&scene, &request).unwrap();
    let mut costs = twinlight::renderer::costs(&scene, &crate::support::tree(&scene), &plan).unwrap();
    costs.passes.pop();
    assert_same("planted", &costs, &counted(Cpu::new(Some(1)).unwrap(), &scene, &plan).0);
}

#[test]
fn only_what_sizes_follow_from_is_computed() {
    let scene = Scene::open("cornell-glossy").unwrap();
    for technique in techniques() {
        let plan = Plan::new(&scene, &request(&scene, &technique, false, LightPart::All)).unwrap();
        let costs = twinlight::renderer::costs(&scene, &crate::support::tree(&scene), &plan).unwrap();
        for costly in
            ["cone_diffuse", "layered_diffuse", "gather_diffuse", "light_visibility", "ambient_openness"]
        {
            assert!(!costs.computed.contains(&costly), "{}: {costly} was computed", technique.name());
        }
        let knows = matches!(technique, Technique::VoxelCones(_)) == costs.computed.contains(&"block_counts");
        assert!(knows, "{}: {:?}", technique.name(), costs.computed);
    }
}

/// What is read back is what it was when the pass ran, whatever was written since, and passes that nobody asks for do not run.
#[test]
fn the_recorder_computes_as_the_backend_would() {
    use twinlight::backend::Recorder;
    use twinlight_kernels::passes::elements::EvaluateParams;
    fn work<B: Backend>(b: &mut B) -> [Vec<u32>; 2] {
        let params =
            twinlight_kernels::passes::elements::WordParams { offset: 0, count: 2, ..Default::default() };
        let mut from = b.upload("from", &[5u32, 6]).unwrap();
        let mut first = b.alloc("first", 2).unwrap();
        b.place_words(&params, &from, &mut first, 2).unwrap();
        b.write(&mut from, &[7, 8]).unwrap();
        let mut second = b.alloc("second", 2).unwrap();
        b.place_words(&params, &from, &mut second, 2).unwrap();
        b.place_words(&params, &first, &mut second, 2).unwrap();
        b.clear(&mut from).unwrap();
        let unread = b.upload("unread", &[glam::Vec4::ONE]).unwrap();
        let mut out = b.alloc("out", 1).unwrap();
        b.evaluate_vector(
            &EvaluateParams { function: 0, count: 1, ..Default::default() },
            &unread,
            &unread,
            &mut out,
            1,
        )
        .unwrap();
        // The later one first: what it follows from must not be run twice, nor too late.
        let second = b.download(&second).unwrap();
        [b.download(&first).unwrap(), second]
    }
    let right = work(&mut Cpu::new(Some(1)).unwrap());
    let mut recorder = Recorder::new(Cpu::new(Some(1)).unwrap());
    assert_eq!(work(&mut recorder), right);
    assert_eq!(right, [vec![5, 6], vec![5 | 7, 6 | 8]]);
    assert_eq!(recorder.computed(), ["place_words"; 3]);
    assert_eq!(recorder.take_timings().unwrap().len(), 4, "all are noted");
}
