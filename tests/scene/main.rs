//! Are scenes read as their files say, and bad ones refused with one clear line?

mod file;
mod malformed;
mod motion;

use file::{File, binary, open_bytes};
use glam::Vec3;
use serde_json::json;
use std::path::{Path, PathBuf};
use twinlight::error::SceneError;
use twinlight::scene::bvh::Bvh;
use twinlight::scene::{BUILT_IN, Scene};
use twinlight_kernels::passes::scene::{LIGHT_POINT, LIGHT_SPOT, LIGHT_SUN, MATERIAL_MASKED};

/// Returns the folder of test scenes: `TWINLIGHT_SCENES`, or `shared/scenes` beside the workspace.
fn scene_folder() -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let folder = std::env::var_os("TWINLIGHT_SCENES").map_or_else(beside, PathBuf::from);
    if folder.is_dir() {
        return Some(folder);
    }
    eprintln!("skipped: no test scenes in {}; set TWINLIGHT_SCENES to their folder", folder.display());
    None
}

#[test]
fn real_scenes_have_the_documented_sizes() {
    let Some(folder) = scene_folder() else { return };
    let box_min = [-1.02, 0.0, -1.04];
    let table = [
        ("sponza", 261_901, 0.005, [-19.21, -1.26, -11.83], [18.00, 14.29, 11.05]),
        ("sibenik", 73_556, 0.005, [-20.14, 0.0, -8.50], [20.14, 30.61, 8.50]),
        ("dragon", 202_522, 0.005, [-1.6, 0.0, -1.6], [1.6, 1.0, 1.6]),
        ("cornell-original", 36, 0.005, box_min, [1.00, 1.99, 0.99]),
        ("cornell-sphere", 2188, 0.005, box_min, [1.00, 1.59, 0.99]),
        ("cornell-glossy", 1112, 0.005, box_min, [1.00, 1.59, 0.99]),
        ("cornell-empty-rg", 12, 0.005, box_min, [1.00, 1.99, 0.99]),
        ("cornell-empty-co", 12, 0.005, box_min, [1.00, 1.99, 0.99]),
    ];
    for (name, triangles, tolerance, min, max) in table {
        let path = folder.join(format!("{name}.glb"));
        if !path.is_file() {
            eprintln!("skipped: {} is not there", path.display());
            continue;
        }
        let scene = Scene::open(path.to_str().unwrap()).unwrap();
        assert_eq!(scene.triangles.len() as u64 + scene.dropped.zero_area, triangles, "{name}");
        assert!(scene.dropped.zero_area <= 1, "{name}: {:?}", scene.dropped);
        let bounds = scene.bounds();
        let off = (bounds.min - Vec3::from(min)).abs().max((bounds.max - Vec3::from(max)).abs());
        assert!(off.max_element() <= tolerance, "{name}: {bounds:?}");
        assert_eq!(scene.name, name);
        let masked = scene.materials.iter().filter(|m| m.flags & MATERIAL_MASKED != 0).count();
        assert_eq!(masked, if name == "sponza" { 3 } else { 0 }, "{name}");
        assert_eq!(scene.census().has_emission, name.starts_with("cornell"), "{name}");
        check(&scene);
    }
}

#[test]
fn built_in_scenes_are_valid() {
    for name in BUILT_IN {
        let scene = Scene::open(name).unwrap();
        assert_eq!(scene.name, name);
        check(&scene);
    }
    assert_eq!(Scene::open("spheres").unwrap().proxies.len(), 40);
}

/// What every scene promises.
fn check(scene: &Scene) {
    for t in &scene.triangles {
        assert!((t.material as usize) < scene.materials.len());
        assert!([t.p0, t.p1, t.p2].iter().all(|p| p.is_finite()));
        assert!([t.n0, t.n1, t.n2].iter().all(|n| (n.truncate().length() - 1.0).abs() < 1e-5));
    }
    for m in &scene.materials {
        for (first, size) in [
            (m.base_texture, m.base_size),
            (m.rough_texture, m.rough_size),
            (m.emission_texture, m.emission_size),
        ] {
            let end = 2 * (u64::from(first) + u64::from(size & 0xFFFF) * u64::from(size >> 16));
            assert!(size == 0 || end <= scene.texels.len() as u64);
        }
    }
    scene.view().frame().unwrap();
    let tree = Bvh::build(&scene.triangles, &scene.materials).unwrap();
    assert!(3 * tree.depth < 64);
}

#[test]
fn a_plain_file_is_read() {
    let scene = File::new().open().unwrap();
    let t = &scene.triangles[0];
    assert_eq!((t.p1.to_array(), t.n1.to_array()), ([1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]));
    assert_eq!(scene.materials[0].roughness, 1.0);
    assert!(scene.lights.is_empty() && scene.camera.is_none() && scene.warnings.is_empty());
}

#[test]
fn transformations_reach_positions_normals_and_winding() {
    // Mirrored and stretched in x, below a parent that moves.
    let scene = File::new()
        .set("/nodes", json!([{"children": [1], "translation": [10.0, 0.0, 0.0]}, {"mesh": 0, "scale": [-2.0, 1.0, 1.0]}]))
        .float(36, 1.0)
        .open()
        .unwrap();
    let t = &scene.triangles[0];
    let p = [t.p0, t.p1, t.p2].map(|p| p.truncate());
    assert_eq!(p, [Vec3::new(10.0, 0.0, 0.0), Vec3::new(10.0, 1.0, 0.0), Vec3::new(8.0, 0.0, 0.0)]);
    assert!((p[1] - p[0]).cross(p[2] - p[0]).z > 0.0, "the front stays the front");
    let expected = Vec3::new(-0.5, 0.0, 1.0).normalize();
    assert!((t.n0.truncate() - expected).length() < 1e-6, "{}", t.n0);
}

#[test]
fn strips_fans_and_missing_normals_are_converted() {
    for (mode, second) in [(5, [1, 3, 2]), (6, [2, 3, 0])] {
        let mut file = File::new().index(3, 3).set("/meshes/0/primitives/0/mode", json!(mode));
        // Four corners of a square; the normals' bytes become the fourth position.
        file = file.float(36, 1.0).float(40, 1.0).float(44, 0.0);
        if mode == 6 {
            file = file
                .float(12, 0.0)
                .float(16, 1.0)
                .float(24, 1.0)
                .float(28, 1.0)
                .float(36, 1.0)
                .float(40, 0.0);
        }
        let scene = file
            .set("/meshes/0/primitives/0/attributes", json!({"POSITION": 0}))
            .set("/accessors/0/count", json!(4))
            .set("/accessors/3/count", json!(4))
            .open()
            .unwrap();
        assert_eq!(scene.triangles.len(), 2, "mode {mode}, second triangle of corners {second:?}");
        let normals: Vec<f32> = scene.triangles.iter().map(|t| t.n0.z).collect();
        assert_eq!(normals[0], normals[1], "both triangles face the same side");
    }
}

#[test]
fn textures_are_linear_and_shared() {
    let mut picture = image::RgbaImage::new(2, 1);
    picture.put_pixel(0, 0, image::Rgba([255, 188, 0, 255]));
    picture.put_pixel(1, 0, image::Rgba([0, 0, 255, 51]));
    let texture = json!({"index": 0});
    let scene = File::new()
        .picture(picture.into())
        .set(
            "/materials/0",
            json!({
                "pbrMetallicRoughness": {"baseColorTexture": texture, "metallicRoughnessTexture": texture},
                "emissiveTexture": texture, "emissiveFactor": [1.0, 0.5, 0.0], "alphaMode": "MASK",
                "extensions": {"KHR_materials_emissive_strength": {"emissiveStrength": 4.0}},
            }),
        )
        .set("/extensionsUsed", json!(["KHR_materials_emissive_strength"]))
        .open()
        .unwrap();
    let m = &scene.materials[0];
    assert_eq!((m.base_size, m.emission_size, m.rough_size), (2 | 1 << 16, 2 | 1 << 16, 2 | 1 << 16));
    assert_eq!((m.base_texture, m.emission_texture, m.rough_texture), (0, 0, 2));
    assert_eq!(scene.texels.len(), 8, "once as colour, once as data");
    assert_eq!(scene.texels[0] & 0xFFFF, 65535);
    assert!(((scene.texels[0] >> 16) as f32 / 65535.0 - 0.5029).abs() < 1e-3);
    assert_eq!(scene.texels[3] >> 16, 51 * 257, "alpha is not decoded");
    assert_eq!(scene.texels[4] >> 16, 188 * 257, "data are not decoded");
    assert_eq!((m.emission.x, m.emission.y, m.flags), (4.0, 2.0, MATERIAL_MASKED));
    let t = &scene.triangles[0];
    assert_eq!((t.p1.w, t.n1.w, t.p2.w, t.n2.w), (1.0, 0.0, 0.0, 1.0));
}

#[test]
fn masks_without_holes_are_dropped_and_blend_is_told() {
    let mask = |alpha: f32| json!({"alphaMode": "MASK", "pbrMetallicRoughness": {"baseColorFactor": [1.0, 1.0, 1.0, alpha]}});
    assert_eq!(File::new().set("/materials/0", mask(1.0)).open().unwrap().materials[0].flags, 0);
    let scene = File::new().set("/materials/0", mask(0.25)).open().unwrap();
    assert_eq!(scene.materials[0].flags, MATERIAL_MASKED);
    let scene = File::new().set("/materials/0", json!({"alphaMode": "BLEND"})).open().unwrap();
    assert!(scene.warnings[0].contains("BLEND"), "{:?}", scene.warnings);
}

#[test]
fn lights_and_the_camera_are_read() {
    let light = |kind: &str| json!({"type": kind, "intensity": 3.0, "color": [1.0, 0.5, 0.0], "spot": {}});
    let scene = File::new()
        .set("/extensionsUsed", json!(["KHR_lights_punctual"]))
        .set("/extensions", json!({"KHR_lights_punctual": {"lights": [light("point"), light("spot"), light("directional")]}}))
        .set("/cameras", json!([{"type": "perspective", "perspective": {"yfov": 1.0, "znear": 0.1}}]))
        .set("/nodes", json!([
            {"mesh": 0, "children": [1, 2, 3]},
            {"extensions": {"KHR_lights_punctual": {"light": 0}}, "translation": [1.0, 2.0, 3.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 1}}, "rotation": [0.0, 1.0, 0.0, 0.0]},
            {"extensions": {"KHR_lights_punctual": {"light": 2}}, "camera": 0, "translation": [0.0, 0.0, 5.0]},
        ]))
        .open()
        .unwrap();
    let kinds: Vec<u32> = scene.lights.iter().map(|l| l.kind).collect();
    assert_eq!(kinds, [LIGHT_POINT, LIGHT_SPOT, LIGHT_SUN]);
    assert_eq!(scene.lights[0].position.to_array(), [1.0, 2.0, 3.0, 0.0]);
    assert_eq!(scene.lights[0].intensity.to_array(), [3.0, 1.5, 0.0, 0.0]);
    assert!((scene.lights[1].direction.z - 1.0).abs() < 1e-6, "turned half around y");
    assert!((scene.lights[1].outer - std::f32::consts::FRAC_PI_4).abs() < 1e-6);
    let camera = scene.camera.unwrap();
    assert_eq!((camera.eye, camera.frame().unwrap().forward), (Vec3::new(0.0, 0.0, 5.0), Vec3::NEG_Z));
    assert!((camera.fov - 57.29578).abs() < 1e-4);
}

#[test]
fn malformed_scenes_give_one_clear_line() {
    let pointer = "/meshes/0/primitives/0";
    let file = File::new;
    let cases: Vec<(&str, &str, Result<Scene, SceneError>)> = vec![
        ("unknown", "cornell-box, cornell-glossy", Scene::open("no-such-scene")),
        ("missing", "cannot read", Scene::open("no-such-file.glb")),
        ("empty name", "no scene", Scene::open("")),
        (
            "NaN position",
            "mesh 0 (part), primitive 0: the position of vertex 1",
            file().float(16, f32::NAN).open(),
        ),
        ("far position", "the position of vertex 0", file().float(0, 2e18).open()),
        ("infinite normal", "the normal of vertex 2", file().float(60, f32::INFINITY).open()),
        ("index", "index 3 is beyond its 3 vertices", file().index(2, 3).open()),
        ("zero area", "1 triangles of no area", file().float(12, 0.0).open()),
        ("points", "1 primitives of points", file().set(&format!("{pointer}/mode"), json!(0)).open()),
        ("no mesh", "no triangles", file().set("/nodes/0", json!({})).open()),
        ("no scene", "has no scene", file().set("/scenes", json!([])).set("/scene", json!(null)).open()),
        ("count", "reach beyond buffer view 0", file().set("/accessors/1/count", json!(1000)).open()),
        ("huge count", "reach beyond", file().set("/accessors/3/count", json!(u64::MAX / 2)).open()),
        ("offset", "reach beyond", file().set("/accessors/3/byteOffset", json!(u64::MAX)).open()),
        ("view", "beyond its buffer", file().set("/bufferViews/0/byteLength", json!(105)).open()),
        ("stride", "stride", file().set("/bufferViews/0/byteStride", json!(4)).open()),
        ("kind", "vectors of 3", file().set("/accessors/1/type", json!("VEC2")).open()),
        ("lengths", "3 positions but 2", file().set("/accessors/1/count", json!(2)).open()),
        (
            "float indices",
            "does not hold indices",
            file().set("/accessors/3/componentType", json!(5126)).open(),
        ),
        ("two indices", "do not make triangles", file().set("/accessors/3/count", json!(2)).open()),
        (
            "position index",
            "accessor 9",
            file().set(&format!("{pointer}/attributes/POSITION"), json!(9)).open(),
        ),
        ("mesh index", "faults", file().set("/nodes/0/mesh", json!(7)).open()),
        ("cycle", "tree", file().set("/nodes/0", json!({"mesh": 0, "children": [0]})).open()),
        ("scale", "not finite", file().set("/nodes/0", json!({"mesh": 0, "scale": [1e39, 1.0, 1.0]})).open()),
        (
            "base64",
            "base64",
            file().set("/buffers", json!([{"byteLength": 104, "uri": "data:x;base64,%%"}])).open(),
        ),
        (
            "short",
            "bytes where",
            file().set("/buffers", json!([{"byteLength": 104, "uri": "data:x;base64,AAAA"}])).open(),
        ),
        (
            "no file",
            "cannot be read",
            file().set("/buffers", json!([{"byteLength": 104, "uri": "none.bin"}])).open(),
        ),
        ("utf-8", "UTF-8", file().set("/buffers", json!([{"byteLength": 104, "uri": "%ff.bin"}])).open()),
        ("no chunk", "no binary chunk", file().set("/buffers", json!([{"byteLength": 104}])).open()),
        ("image", "PNG or JPEG", {
            file()
                .set("/images", json!([{"uri": "data:image/png;base64,AAAA"}]))
                .set("/textures", json!([{"source": 0}]))
                .set("/materials/0/pbrMetallicRoughness/baseColorTexture", json!({"index": 0}))
                .open()
        }),
        ("no image", "neither a buffer view nor a file", {
            file()
                .set("/images", json!([{}]))
                .set("/textures", json!([{"source": 0}]))
                .set("/materials/0/pbrMetallicRoughness/baseColorTexture", json!({"index": 0}))
                .open()
        }),
        ("not glTF", "neither with glTF", open_bytes(b"solid cube", "a.glb")),
        ("no bytes", "neither with glTF", open_bytes(b"", "a.glb")),
        ("magic only", "cut off", open_bytes(b"glTF", "a.glb")),
        ("short length", "header says 3", open_bytes(b"glTF\x02\0\0\0\x03\0\0\0", "a.glb")),
        ("not JSON", "not usable", open_bytes(b"{\"asset\": \n", "a.gltf")),
    ];
    for (name, expected, result) in cases {
        let message = match result {
            Err(error) => error.to_string(),
            Ok(_) => panic!("{name} was accepted"),
        };
        assert!(message.contains(expected), "{name}: {message:?} lacks {expected:?}");
        assert!(!message.contains('\n') && message.len() < 600, "{name}: {message}");
    }
}

#[test]
fn damaged_binaries_never_panic() {
    let whole = binary();
    assert_eq!(open_bytes(&whole, "a.glb").unwrap().triangles.len(), 1, "the undamaged file is good");
    for length in 0..whole.len() {
        assert!(open_bytes(&whole[..length], "a.glb").is_err(), "cut at {length}");
    }
    let mut state = 1u64;
    let mut refused = 0;
    for _ in 0..3000 {
        let mut damaged = whole.clone();
        for _ in 0..3 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let place = (state >> 33) as usize % damaged.len();
            damaged[place] ^= 1 << (state >> 30 & 7);
        }
        refused += u32::from(open_bytes(&damaged, "a.glb").is_err());
    }
    assert!(refused > 1000, "only {refused} of 3000 damaged files were noticed");
}
