//! What must hold whatever bytes are read? Shared by the fuzz targets and the replay of their corpora.

use std::path::Path;
use twinlight::backend::Cpu;
use twinlight::plan::{Request, Technique};
use twinlight::renderer::Renderer;
use twinlight::scene::{EnvironmentMap, MAX_VALUE, Scene, light};
use twinlight::technique::layered_rsm::LayeredRsm;
use twinlight::technique::soft_gi::SoftGi;
use twinlight::technique::visibility_filter::VisibilityFilter;
use twinlight::technique::voxel_cones::VoxelCones;
use twinlight::technique::{Job, View};

/// Techniques that render what can be read.
pub const TECHNIQUES: usize = 6;
/// The least size of scene that is not rendered.
const MANY: usize = 300;

/// Messages are one line that says something.
fn check_message(text: &str) {
    assert!(text.len() > 10 && text.len() < 2000, "{} bytes: {text}", text.len());
    assert!(!text.contains('\n'), "{text}");
}

/// Reads bytes as a glTF file; what can be read can be rendered.
pub fn gltf(bytes: &[u8]) {
    let scene = match Scene::from_gltf(bytes.to_vec(), Path::new("/nonexistent/fuzz.glb"), 0.25) {
        Ok(scene) => scene,
        Err(e) => return check_message(&e.to_string()),
    };
    check_scene(&scene);
    if scene.triangles.len() < MANY {
        render(scene, technique_of(bytes));
    }
}

fn in_range(v: glam::Vec3) -> bool {
    v.to_array().iter().all(|x| x.abs() <= MAX_VALUE)
}

/// What every scene promises to the kernels.
pub fn check_scene(scene: &Scene) {
    assert!(!scene.triangles.is_empty());
    for t in &scene.triangles {
        assert!((t.material as usize) < scene.materials.len(), "material {}", t.material);
        for p in [t.p0, t.p1, t.p2, t.n0, t.n1, t.n2] {
            assert!(p.is_finite() && in_range(p.truncate()), "{t:?}");
        }
    }
    for m in &scene.materials {
        let texels = scene.texels.len() as u64 / 2;
        for (first, size) in [
            (m.base_texture, m.base_size),
            (m.rough_texture, m.rough_size),
            (m.emission_texture, m.emission_size),
        ] {
            let count = u64::from(size & 0xFFFF) * u64::from(size >> 16);
            assert!(count == 0 || u64::from(first) + count <= texels, "{m:?} of {texels} texels");
        }
        assert!(in_range(m.base.truncate()) && in_range(m.emission.truncate()), "{m:?}");
        assert!(m.base.w.is_finite() && m.roughness.is_finite() && m.metallic.is_finite(), "{m:?}");
    }
    for l in &scene.lights {
        let vectors = [l.position, l.intensity, l.direction].map(|v| v.truncate());
        assert!(vectors.into_iter().all(in_range) && l.intensity.min_element() >= 0.0, "{l:?}");
    }
    for p in &scene.proxies {
        assert!(in_range(p.centre) && p.radius > 0.0 && p.radius <= MAX_VALUE, "{p:?}");
    }
    for text in &scene.warnings {
        check_message(text);
    }
}

/// Which technique renders a file: any of them, by its bytes.
pub fn technique_of(bytes: &[u8]) -> usize {
    bytes.iter().map(|&b| usize::from(b)).sum::<usize>() % TECHNIQUES
}

/// Renders a few pixels by one of the techniques: what comes is finite, or an error of one line.
fn render(scene: Scene, choice: usize) {
    let technique = match choice {
        0 => Technique::Direct,
        1 => Technique::VisibilityFilter(VisibilityFilter {
            proxies: 200,
            grid: [4; 3],
            rays: 4,
            lobe_rays: 2,
            light_map: 16,
            ..VisibilityFilter::default()
        }),
        2 => Technique::VoxelCones(VoxelCones { resolution: 16, light_map: 16, ..VoxelCones::default() }),
        3 => Technique::AmbientOcclusion,
        4 => Technique::SoftGi(SoftGi::default()),
        _ => Technique::LayeredRsm(LayeredRsm { resolution: 16, map: 16, ..LayeredRsm::default() }),
    };
    let job = Job { rays: 2, check_finite: true, ..Job::default() };
    let done: Result<(), Box<dyn std::error::Error>> = (|| {
        let view = View::new(&scene.view(), 4, 4)?;
        let mut renderer = Renderer::new(Cpu::new(Some(1))?, scene)?;
        let plan = renderer.plan(&Request::new(technique, view, job))?;
        check_message(&plan.text().replace('\n', " ").chars().take(500).collect::<String>());
        let frame = renderer.render(&plan)?;
        for n in &frame.rendered.non_finite {
            assert_eq!(n.count, 0, "{} values of {} are not finite", n.count, n.buffer);
        }
        assert!(frame.rendered.picture.pixels.iter().all(|p| p.is_finite()));
        Ok(())
    })();
    if let Err(e) = done {
        check_message(&e.to_string());
    }
}

/// Reads bytes as an environment map: the first says which format.
pub fn environment(bytes: &[u8]) {
    let Some((&kind, rest)) = bytes.split_first() else { return };
    let format = if kind % 2 == 0 { image::ImageFormat::Hdr } else { image::ImageFormat::OpenExr };
    match EnvironmentMap::decode(rest, format) {
        Ok(map) => {
            assert_eq!(map.data.len() as u64, u64::from(map.width) * u64::from(map.height));
            assert!(map.data.iter().all(|t| t.is_finite() && t.min_element() >= 0.0));
            for direction in [glam::Vec3::X, glam::Vec3::NEG_Y, glam::Vec3::ONE, glam::Vec3::ZERO] {
                assert!(map.radiance(direction).is_finite(), "{direction}");
            }
        }
        Err(reason) => assert!(!reason.is_empty() && !reason.contains('\n'), "{reason}"),
    }
}

/// Reads text as what a command line says of a scene: the whole line, and each word as each description.
pub fn options(bytes: &[u8]) {
    let text = String::from_utf8_lossy(bytes);
    let words: Vec<String> = text.split(' ').map(str::to_owned).collect();
    if let Err(reason) = twinlight::cli::understands(&words) {
        check_message(&reason);
    }
    for word in words.iter().map(String::as_str) {
        let lights = [light::parse_point(word), light::parse_spot(word), light::parse_sun(word)];
        for result in lights {
            match result {
                Ok(l) => assert!(l.position.is_finite() && l.intensity.min_element() >= 0.0, "{l:?}"),
                Err(e) => check_message(&e.to_string()),
            }
        }
        for result in [light::parse_sky(word), light::parse_daylight(word)] {
            match result {
                Ok(sky) => assert!(sky.radiance(glam::Vec3::Y).is_finite(), "{word}"),
                Err(e) => check_message(&e.to_string()),
            }
        }
        match light::parse_sphere(word) {
            Ok((centre, radius, _)) => assert!(centre.is_finite() && radius > 0.0 && radius.is_finite()),
            Err(e) => check_message(&e.to_string()),
        }
        if let Err(e) = light::parse_vector("--eye", word) {
            check_message(&e.to_string());
        }
    }
}
