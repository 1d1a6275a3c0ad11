//! What a successful `render` writes and prints.

use crate::support::relative;
use crate::{listing, run, succeed};
use std::path::Path;
use twinlight::picture::Picture;

const SMALL: [&str; 4] = ["render", "cornell-box", "--size", "64x48"];

fn with<'a>(more: &[&'a str]) -> Vec<&'a str> {
    SMALL.iter().chain(more).copied().collect()
}

fn png(path: &Path) -> image::RgbImage {
    let picture = image::open(path).unwrap();
    assert_eq!(picture.color(), image::ColorType::Rgb8);
    picture.into_rgb8()
}

fn names(folder: &Path) -> Vec<String> {
    listing(folder).into_keys().collect()
}

#[test]
fn a_png_of_the_right_size_and_the_table_of_passes() {
    let folder = tempfile::tempdir().unwrap();
    let ran = succeed(folder.path(), &with(&["-o", "a.png"]));
    assert_eq!(png(&folder.path().join("a.png")).dimensions(), (64, 48));
    assert_eq!(names(folder.path()), ["a.png"]);
    for word in [
        "pass ",
        "trace_primary",
        "resolve_surfaces",
        "light_visibility",
        "shade_diffuse",
        "3072",
        "wrote a.png",
    ] {
        assert!(ran.out.contains(word), "{word:?} is not in {}", ran.out);
    }
    assert!(!ran.out.contains("gather_direct"), "a pass that the scene does not call for ran: {}", ran.out);
    assert!(ran.errors().is_empty());
}

#[test]
fn without_a_name_the_picture_is_called_as_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &SMALL);
    assert_eq!(names(folder.path()), ["cornell-box.png"]);
    std::fs::write(folder.path().join("my scene.glb"), crate::file::binary()).unwrap();
    succeed(folder.path(), &["render", "my scene.glb", "--size", "8x8", "--quiet"]);
    assert_eq!(names(folder.path()), ["cornell-box.png", "my scene.glb", "my scene.png"]);
}

#[test]
fn exr_is_linear_and_png_is_its_srgb_after_exposure() {
    let folder = tempfile::tempdir().unwrap();
    let ran = succeed(folder.path(), &with(&["-o", "a.exr", "--json", "--exposure", "3"]));
    let linear = Picture::open_exr(&folder.path().join("a.exr")).unwrap();
    assert_eq!((linear.width, linear.height), (64, 48));
    let mean = ran.json()["mean"][0].as_f64().unwrap();
    assert!(relative(linear.mean().x, mean) < 1e-6, "exposure must not reach the .exr");
    for exposure in [0.0f32, 1.5, -2.0] {
        succeed(folder.path(), &with(&["-o", "a.png", "--exposure", &exposure.to_string()]));
        let encoded = png(&folder.path().join("a.png"));
        for (byte, linear) in encoded.pixels().zip(&linear.pixels) {
            for (byte, linear) in byte.0.into_iter().zip(linear.to_array()) {
                let x = f64::from(linear * exposure.exp2()).clamp(0.0, 1.0);
                let x = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
                assert!((f64::from(byte) - 255.0 * x).abs() <= 0.51, "{byte} for {linear}");
            }
        }
    }
}

#[test]
fn json_is_one_object_and_quiet_is_silent() {
    let folder = tempfile::tempdir().unwrap();
    let direct = ["--technique", "direct", "--json", "-o", "a.png", "--dump", "albedo,normal,visibility"];
    let json = succeed(folder.path(), &with(&direct)).json();
    assert_eq!(json["technique"], "Direct");
    assert_eq!(json["files"].as_array().unwrap().len(), 4);
    let passes: Vec<_> =
        json["passes"].as_array().unwrap().iter().map(|p| p["pass"].as_str().unwrap()).collect();
    assert!(passes.contains(&"trace_primary") && passes.contains(&"shade_diffuse"), "{passes:?}");
    for file in json["files"].as_array().unwrap() {
        assert_eq!(png(&folder.path().join(file.as_str().unwrap())).dimensions(), (64, 48), "{file}");
    }
    assert_eq!(names(folder.path()), ["a.albedo.png", "a.normal.png", "a.png", "a.visibility.png"]);

    let reference =
        ["--technique", "reference", "--samples", "8", "--json", "--dump", "direct,indirect", "-o", "r.exr"];
    let json = succeed(folder.path(), &with(&reference)).json();
    assert_eq!(json["samples"], 8);
    let open = |name: &str| Picture::open_exr(&folder.path().join(name)).unwrap().mean();
    for (name, file) in [("direct", "r.direct.exr"), ("indirect", "r.indirect.exr"), ("all", "r.exr")] {
        let mean = json[name]["mean"][1].as_f64().unwrap();
        assert!(mean > 0.0 && relative(open(file).y, mean) < 1e-5, "{name}: {mean}");
        assert!(json[name]["standard_error"].as_f64().unwrap() > 0.0);
    }
    let occlusion = ["--technique", "ambient-occlusion", "--json", "-o", "o.exr"];
    let json = succeed(folder.path(), &with(&occlusion)).json();
    assert!(json["passes"].to_string().contains("ambient_openness"), "{json}");

    for technique in ["direct", "reference", "ambient-occlusion", "visibility-filter", "auto"] {
        let ran = succeed(folder.path(), &with(&["--quiet", "--samples", "4", "--technique", technique]));
        assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""), "{technique}");
    }
}

#[test]
fn parts_of_the_light_add_up() {
    let folder = tempfile::tempdir().unwrap();
    let render = |only: &str| {
        let arguments = ["--technique", "reference", "--samples", "8", "--only", only, "-o", "a.exr"];
        succeed(folder.path(), &with(&arguments));
        Picture::open_exr(&folder.path().join("a.exr")).unwrap().mean().y
    };
    let (direct, indirect, all) = (render("direct"), render("indirect"), render("all"));
    assert!(direct > 0.0 && indirect > 0.0);
    assert!(relative(direct + indirect, f64::from(all)) < 1e-5);
}

#[test]
fn options_change_what_they_should() {
    let folder = tempfile::tempdir().unwrap();
    let mean = |more: &[&str]| {
        let technique: &[&str] = if more.contains(&"--technique") { &[] } else { &["--technique", "direct"] };
        let all = with(&[&["--json", "-o", "a.exr", "--samples", "4"], technique, more].concat());
        let json = succeed(folder.path(), &all).json();
        [0, 1, 2].map(|i| json["mean"][i].as_f64().unwrap() as f32)
    };
    let base = mean(&[]);
    assert_eq!(mean(&["--no-scene-lights"]), [0.0; 3]);
    let twice = mean(&["--no-scene-lights", "--point", "0,1.8,0:4,4,4"]);
    assert!(relative(twice[1], 2.0 * f64::from(base[1])) < 1e-5, "{twice:?} and {base:?}");
    assert!(mean(&["--emissive"])[1] > base[1]);
    assert!(mean(&["--sky", "0.1,0.1,0.1"])[2] > base[2]);
    let grey = mean(&["--albedo", "0.5"]);
    assert!(grey[0] == grey[1] && relative(mean(&["--albedo", "0.25"])[0], 0.5 * f64::from(grey[0])) < 1e-5);
    assert_eq!(mean(&["--albedo", "0"]), [0.0; 3]);
    for option in ["--eye=0.5,1,3", "--target=0.5,1,0", "--fov=60", "--up=1,1,0"] {
        assert_ne!(mean(&[option]), base, "{option}");
    }
    for option in [["--threads", "1"], ["--threads", "3"], ["--backend", "cpu"], ["--seed", "9"]] {
        assert_eq!(mean(&option), base, "{option:?}");
    }
    let occlusion = |seed: &str| mean(&["--technique", "ambient-occlusion", "--seed", seed]);
    assert_ne!(occlusion("1"), occlusion("2"));
    let far = mean(&["--technique", "ambient-occlusion", "--reach", "0.1"]);
    assert!(far[0] > occlusion("1")[0]);
    succeed(folder.path(), &with(&["--check-finite"]));
}

#[test]
fn the_visibility_filter_shows_its_stages_counts_and_error() {
    let folder = tempfile::tempdir().unwrap();
    fn filter<'a>(more: &[&'a str]) -> Vec<&'a str> {
        with(&[&["--technique", "visibility-filter"], more].concat())
    }
    let ran = succeed(folder.path(), &filter(&["-o", "a.exr", "--only", "indirect"]));
    for word in ["voxelisation", "  trace_rays", "illumination", "proxies", "wrote a.exr"] {
        assert!(ran.out.contains(word), "{word:?} is not in {}", ran.out);
    }
    let again = ["-o", "b.exr", "--only", "indirect", "--against", "a.exr", "--json"];
    let json = succeed(folder.path(), &filter(&again)).json();
    assert_eq!(
        (json["relative_rmse"].as_f64(), json["mean_ratio"].as_f64()),
        (Some(0.0), Some(1.0)),
        "{json}"
    );
    let stages: Vec<&str> =
        json["stages"].as_array().unwrap().iter().map(|s| s["stage"].as_str().unwrap()).collect();
    assert_eq!(
        stages,
        ["voxelisation", "lighting", "marching", "filter", "illumination", "direct", "upsampling"]
    );
    assert!(
        json["counts"]["proxies"].as_u64().unwrap() > 50_000 && json["counts"]["full_lists"] == 0,
        "{json}"
    );
    let tight = ["-o", "b.exr", "--only", "indirect", "--against", "a.exr", "--list-capacity", "9"];
    let ran = succeed(folder.path(), &filter(&tight));
    assert!(ran.out.contains("had no room") && ran.out.contains("relative RMSE"), "{}", ran.out);
    // A preset, changed by an option beside it.
    let preset = ["--preset", "paper-cornell", "--grid", "5x4x3", "--dump", "proxies,voxels", "--json"];
    let json = succeed(folder.path(), &filter(&[&preset[..], &["-o", "c.png"]].concat())).json();
    let proxies = json["counts"]["proxies"].as_u64().unwrap();
    assert!((23_000..25_000).contains(&proxies) && json["counts"]["list_capacity"].as_u64().unwrap() <= 60);
    assert!(json["passes"].to_string().contains("trace_light_map"), "the paper's light map: {json}");
    assert!(names(folder.path()).contains(&"c.proxies.png".to_owned()));
    // All of the light is direct and indirect light.
    let mean = |only: &str| {
        let json = succeed(folder.path(), &filter(&["-o", "d.exr", "--only", only, "--json"])).json();
        json["mean"][1].as_f64().unwrap()
    };
    let (all, direct, indirect) = (mean("all"), mean("direct"), mean("indirect"));
    assert!((all - direct - indirect).abs() < 1e-5 * all && indirect > 0.1 * direct);
}

#[test]
fn auto_passes_light_on_where_there_is_a_lamp() {
    let folder = tempfile::tempdir().unwrap();
    let ran = succeed(folder.path(), &SMALL);
    assert!(
        ran.err.contains("auto chose visibility-filter") && ran.out.contains("gather_diffuse"),
        "{}",
        ran.err
    );
    let ran = succeed(folder.path(), &["render", "spheres", "--size", "16x16", "--samples", "2"]);
    assert!(ran.err.contains("auto chose soft-gi"), "{}", ran.err);
}

#[test]
fn an_old_picture_is_replaced_or_left_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.png");
    std::fs::write(&path, "old").unwrap();
    assert_eq!(run(folder.path(), &with(&["-o", "a.png", "--fov", "200"])).code, Some(2));
    assert_eq!(std::fs::read(&path).unwrap(), b"old");
    succeed(folder.path(), &with(&["-o", "a.png"]));
    assert_eq!(png(&path).dimensions(), (64, 48));
    assert_eq!(names(folder.path()), ["a.png"]);
}

#[test]
fn frames_are_numbered_pictures_that_move() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["render", "spheres", "--technique", "soft-gi", "--size", "48x32", "--fps", "5"];
    let ran = succeed(folder.path(), &[&arguments[..], &["--frames", "2..4", "-o", "walk"]].concat());
    assert!(ran.out.contains("wrote 3 frames to walk"), "{}", ran.out);
    let bytes = |n: u32| std::fs::read(folder.path().join(format!("walk/{n:04}.png"))).unwrap();
    assert!(bytes(2) != bytes(3) && bytes(3) != bytes(4));
    assert_eq!(std::fs::read_dir(folder.path().join("walk")).unwrap().count(), 3);
    // A frame is what the same command makes of that moment alone.
    succeed(folder.path(), &[&arguments[..], &["--frames", "3..3", "-o", "one", "--quiet"]].concat());
    assert_eq!(std::fs::read(folder.path().join("one/0003.png")).unwrap(), bytes(3));
}

#[test]
fn soft_gi_tells_what_it_did_and_what_it_lacks() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["render", "spheres", "--technique", "soft-gi", "--size", "64x48"];
    let dumps = ["--dump", "log-occlusion,occlusion,shadowed,indirect,xi", "-o", "a.png", "--json"];
    let json = succeed(folder.path(), &[&arguments[..], &dumps].concat()).json();
    assert_eq!(json["counts"]["proxies"], 40);
    assert_eq!(json["files"].as_array().unwrap().len(), 6, "{json}");
    let stages: Vec<_> =
        json["stages"].as_array().unwrap().iter().map(|s| s["stage"].as_str().unwrap().to_owned()).collect();
    for stage in ["receivers", "culling", "occlusion", "exponential", "shading", "indirect", "upsampling"] {
        assert!(stages.iter().any(|s| s == stage), "{stage} is not in {stages:?}");
    }
    let cornell = ["render", "cornell-box", "--technique", "soft-gi", "--size", "16x16", "-o", "b.png"];
    let ran = succeed(folder.path(), &cornell);
    assert!(ran.err.contains("--environment") && ran.err.contains("--sphere"), "{}", ran.err);
    let fitted = [&cornell[..], &["--sky", "1,1,1", "--fit-spheres", "8"]].concat();
    let ran = succeed(folder.path(), &fitted);
    assert!(ran.err.contains("8 spheres fitted") && !ran.err.contains("give --sphere"), "{}", ran.err);
}

#[test]
fn voxels_of_any_level_are_drawn() {
    let folder = tempfile::tempdir().unwrap();
    let dumps =
        ["--dump", "voxels,voxels@2,occlusion@1,lobes", "--technique", "voxel-cones", "--resolution", "16"];
    let arguments = ["render", "cornell-glossy", "--size", "32x32", "-o", "a.exr", "--photons", "128"];
    succeed(folder.path(), &[&arguments[..], &dumps].concat());
    let mean = |name: &str| Picture::open_exr(&folder.path().join(name)).unwrap().mean().y;
    assert!(mean("a.voxels.exr") > 0.0 && mean("a.voxels@2.exr") > 0.0);
    assert!((0.2..1.0).contains(&mean("a.occlusion@1.exr")), "{}", mean("a.occlusion@1.exr"));
    assert!(mean("a.lobes.exr") != 0.0);
}

#[test]
fn layered_maps_tell_their_bytes_and_show_their_buffers() {
    let folder = tempfile::tempdir().unwrap();
    let base =
        ["render", "cornell-glossy", "--technique", "layered-rsm", "--size", "32x24", "--resolution", "32"];
    let knobs =
        ["--rsm", "64", "--light-radius", "0.05", "--dump", "rsm,layers,shadow,ao", "-o", "a.exr", "--json"];
    let json = succeed(folder.path(), &[&base[..], &knobs].concat()).json();
    let bytes = |what: &str| json["counts"][what].as_u64().unwrap();
    assert_eq!(bytes("voxel_bytes"), 4 * (32 * 32 * 32 / 32 + (16 * 16 * 16 + 512 + 64 + 8) / 2 + 1));
    assert_eq!((bytes("lights"), bytes("map_bytes")), (1, 16 * 64 * 64), "{json}");
    let picture = |name: &str| Picture::open_exr(&folder.path().join(name)).unwrap();
    assert_eq!((picture("a.rsm.exr").width, picture("a.layers.exr").width), (64, 4 * 32));
    assert!((0.2..1.0).contains(&picture("a.shadow.exr").mean().y));
    assert!((0.05..1.0).contains(&picture("a.ao.exr").mean().y));
    let stages: Vec<_> =
        json["stages"].as_array().unwrap().iter().map(|s| s["stage"].as_str().unwrap()).collect();
    assert!(stages.contains(&"shadows") && stages.contains(&"maps"), "{stages:?}");
    // Hard shadows again, by an option beside the radius.
    let rays =
        [&base[..], &["--light-radius", "0.05", "--shadow-cones", "false", "-o", "b.exr", "--json"]].concat();
    let json = succeed(folder.path(), &rays).json();
    assert!(json["stages"].as_array().unwrap().iter().all(|s| s["stage"] != "shadows"), "{json}");
    let dark = ["render", "cornell-box", "--technique", "layered-rsm", "--no-scene-lights", "--size", "8x8"];
    let ran = succeed(folder.path(), &[&dark[..], &["-o", "c.exr"]].concat());
    assert!(ran.err.contains("no point, spot or sun light"), "{}", ran.err);
}
