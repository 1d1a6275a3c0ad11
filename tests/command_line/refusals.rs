//! Wrong requests end with code 2, failed work with code 1, each with one line that says why; nothing is left behind.

use crate::{command, file, finish, listing, run, without_drivers};
use std::path::Path;

/// A folder with broken scenes, and a folder in it with the name of a picture.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let whole = file::binary();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    write("truncated.glb", &whole[..whole.len() - 20]);
    write("header.glb", &whole[..10]);
    write("malformed.glb", &[&whole[..20], b"{ not json", &whole[30..]].concat());
    write("empty.glb", b"");
    write("text.gltf", b"hello");
    write("text.hdr", b"hello");
    std::fs::create_dir(folder.path().join("folder.png")).unwrap();
    std::fs::create_dir(folder.path().join("b.normal.png")).unwrap();
    folder
}

/// Runs a command that must fail, and checks all that holds for every failure; returns its error line.
fn refused(folder: &Path, code: i32, arguments: &[&str]) -> String {
    let before = listing(folder);
    let ran = run(folder, arguments);
    assert_eq!(ran.code, Some(code), "{arguments:?}: {}", ran.err);
    assert_eq!(ran.out, "", "{arguments:?} printed to standard output");
    assert!(listing(folder) == before, "{arguments:?} changed the folder: {:?}", listing(folder).keys());
    assert_eq!(ran.errors().len(), 1, "{arguments:?}: {}", ran.err);
    let first = ran.err.lines().find(|l| !l.starts_with("note:")).unwrap_or_default();
    assert!(
        first.starts_with("error: ") && first.len() > 20 && first.len() < 600,
        "{arguments:?}: {first:?}"
    );
    ran.err
}

/// Failures that this command finds itself: exactly one line.
fn refused_in_a_line(folder: &Path, code: i32, arguments: &[&str], word: &str) {
    let err = refused(folder, code, arguments);
    let rest = err.lines().filter(|l| !l.starts_with("note:")).count();
    assert_eq!(rest, 1, "{arguments:?}: {err}");
    assert!(err.contains(word), "{arguments:?}: {word:?} is not in {err}");
}

#[test]
fn scenes_that_cannot_be_opened() {
    let folder = folder();
    let table = [
        ("no-such-scene", "cornell-box"),
        ("missing.glb", "missing.glb"),
        ("missing.gltf", "missing.gltf"),
        ("truncated.glb", "truncated.glb"),
        ("header.glb", "header.glb"),
        ("malformed.glb", "malformed.glb"),
        ("empty.glb", "empty.glb"),
        ("text.gltf", "text.gltf"),
        ("folder.png", "folder.png"),
        ("", "no scene"),
        ("two\nlines", "no scene"),
    ];
    for (scene, word) in table {
        for subcommand in ["render", "compare"] {
            refused_in_a_line(folder.path(), 2, &[subcommand, scene], word);
        }
    }
}

#[test]
fn values_of_options_that_make_no_sense() {
    let folder = folder();
    let table = [
        ("--fov 0", "angle of view"),
        ("--fov 180", "angle of view"),
        ("--fov -5", "angle of view"),
        ("--fov NaN", "angle of view"),
        ("--fov inf", "angle of view"),
        ("--eye 0,1,0 --target 0,1,0", "same point"),
        ("--eye 0,1,3 --target 0,1,0 --up 0,0,1", "parallel"),
        ("--up 0,0,0", "length 0"),
        ("--eye 0,1", "--eye"),
        ("--eye 0,1,nan", "--eye"),
        ("--point 0,0,0", "--point"),
        ("--point 0,0,0:1,1", "--point"),
        ("--point 0,0,0:1,1,-1", "negative"),
        ("--point 0,0,inf:1,1,1", "finite"),
        ("--spot 0,0,0:0,0,0:1,1,1:30", "length 0"),
        ("--spot 0,0,0:0,1,0:1,1,1:30,40", "angles"),
        ("--spot 0,0,0:0,1,0:1,1,1:0", "angles"),
        ("--spot 0,0,0:0,1,0:1,1,1", "--spot"),
        ("--sun 0,0,0:1,1,1", "length 0"),
        ("--sun 0,1,0", "--sun"),
        ("--sky 1", "--sky"),
        ("--sky -1,0,0", "negative"),
        ("--sky a,b,c", "not a number"),
        ("--environment missing.hdr", "missing.hdr"),
        ("--environment text.hdr", "text.hdr"),
        ("--environment text.gltf", ".hdr"),
        ("--albedo 2", "--albedo"),
        ("--albedo nan", "--albedo"),
        ("--threads 0", "--threads"),
        ("--exposure nan", "--exposure"),
        ("--exposure 1000", "--exposure"),
        ("--reach 0", "--reach"),
        ("--falloff -1", "--falloff"),
        ("--falloff nan", "--falloff"),
        ("--output missing/a.png", "folder"),
        ("--output a.jpg", ".exr"),
        ("--output a", ".exr"),
        ("--output .png", ".exr"),
        ("--output folder.png", "folder"),
        ("--output b.png --dump normal", "b.normal.png"),
        ("--dump nonsense", "albedo"),
        ("--dump albedo,nonsense", "nonsense"),
        ("--technique reference --dump albedo", "indirect"),
        ("--technique direct --only indirect", "reference"),
        ("--only indirect --no-scene-lights", "reference"),
        ("--technique visibility-filter --proxies 0", "--proxies"),
        ("--technique visibility-filter --proxies 99999999", "--proxies"),
        ("--technique visibility-filter --grid 0", "--grid"),
        ("--grid 4000", "--grid"),
        ("--technique visibility-filter --rays 0", "--rays"),
        ("--technique visibility-filter --rays 4095 --marching 1024x1024", "--rays"),
        ("--technique visibility-filter --marching 2048x2048", "--marching"),
        ("--technique visibility-filter --near-range nan", "--near-range"),
        ("--technique visibility-filter --overlap -1", "--overlap"),
        ("--technique visibility-filter --specular-deviation 2", "--specular-deviation"),
        ("--technique visibility-filter --specular-exponent 8", "--specular-deviation"),
        ("--technique visibility-filter --list-capacity 0", "--list-capacity"),
        ("--technique visibility-filter --preset paper-teapot", "paper-cornell"),
        ("--technique visibility-filter --dump nonsense", "proxies"),
        ("--technique voxel-cones --resolution 100", "--resolution"),
        ("--technique voxel-cones --cones 64 --step 0.1", "rounds"),
        ("--technique voxel-cones --dump voxels@99", "levels are 0 to 7"),
        ("--technique voxel-cones --dump albedo@1", "voxels"),
        ("--technique voxel-cones --preset teapot", "paper-sponza"),
        ("--technique voxel-cones --preset paper-sibenik", "paper-ao-10"),
        ("--technique voxel-cones --occlusion --dump lobes", "no light"),
        ("--technique voxel-cones --rsm 64", "layered reflective shadow maps"),
        ("--technique direct --cones 6", "options of cones"),
        ("--technique direct --illumination 8x8", "--illumination"),
        ("--technique direct --preset paper-sponza", "has none"),
        ("--technique layered-rsm --rsm 100", "--rsm"),
        ("--technique layered-rsm --rsm 4096 --depth-layers 8 --normal-layers 8", "MiB"),
        ("--technique layered-rsm --depth-layers 9", "--depth-layers"),
        ("--technique layered-rsm --window 0", "--window"),
        ("--technique layered-rsm --least-level 3 --most-level 1", "--most-level"),
        ("--technique layered-rsm --sun-angle 90", "--sun-angle"),
        ("--technique layered-rsm --voxel-bounces 2", "voxel cones"),
        ("--technique layered-rsm --preset teapot", "paper-sibenik"),
        ("--technique layered-rsm --dump nonsense", "rsm"),
        ("--technique soft-gi --order 6", "--order"),
        ("--technique soft-gi --tau 1.5", "--tau"),
        ("--technique soft-gi --receiver-scale 3", "--receiver-scale"),
        ("--technique soft-gi --log-entries 8", "--log-entries"),
        ("--technique direct --upsampling nearest", "--upsampling"),
        ("--technique soft-gi --self-shadow-fade 0", "--self-shadow-fade"),
        ("--technique soft-gi --preset teapot", "paper"),
        ("--technique soft-gi --dump nonsense", "xi"),
        ("--order 3", "soft global illumination"),
        ("--sphere 0,1,0", "--sphere"),
        ("--sphere 0,1,0:0", "radius"),
        ("--fit-spheres 0", "--fit-spheres"),
        ("--fit-spheres 5000", "--fit-spheres"),
        ("--daylight 0,-1,0", "horizon"),
        ("--daylight 0,1,0:99", "turbidity"),
        ("--frames 0..1 --fps 0", "--fps"),
        ("--frames 0..1 --json", "--json"),
        ("--frames 0..1 --output text.hdr", "folder"),
        ("--frames 0..1 --output a%04d%d.png", "pattern"),
        ("--frames 0..1 --output a%x.png", "pattern"),
        ("--frames 0..1 --output a%d.bmp", ".png"),
        ("--frames 0..1 --budget 5ms", "--effects"),
        ("--technique reference --quality 0.5", "--quality"),
        ("--technique reference --effects lights", "--effects"),
        ("--orbit 3", "--frames"),
        ("--shard 1/2", "--frames"),
        ("--resume", "--frames"),
        ("--technique voxel-cones --effects bounce,glow", "further-bounces"),
        ("--technique voxel-cones --quality 2", "quality"),
        ("--technique direct --proxies 5", "visibility filter"),
        ("--technique reference --gather sum", "visibility filter"),
        ("--against missing.exr", "missing.exr"),
        ("--against text.hdr", ".exr"),
        ("--technique ambient-occlusion --only indirect", "--only"),
        ("--technique reference --backend gpu", "CPU"),
    ];
    for (options, word) in table {
        let arguments: Vec<&str> =
            ["render", "cornell-box", "--size", "16x16"].into_iter().chain(options.split(' ')).collect();
        refused_in_a_line(folder.path(), 2, &arguments, word);
    }
}

#[test]
fn options_that_are_not_understood() {
    let folder = folder();
    let table = [
        "--size 0x5",
        "--size 5x0",
        "--size 99999x99999",
        "--size 20000x20000",
        "--size abc",
        "--size 5",
        "--size 5x",
        "--size -5x5",
        "--size 5x5x5",
        "--samples 0",
        "--samples -1",
        "--samples x",
        "--seed -1",
        "--seed x",
        "--threads x",
        "--bounces -1",
        "--bounces some",
        "--bounces 5000",
        "--technique nonsense",
        "--backend tpu",
        "--arithmetic sloppy",
        "--only some",
        "--grid 5x5",
        "--grid x",
        "--filter 4",
        "--filter 11",
        "--gather some",
        "--frames 3..1",
        "--frames 1",
        "--frames 0..3 --shard 0/2",
        "--frames 0..3 --shard 3/2",
        "--budget 0ms",
        "--budget fast",
        "--operator some",
        "--daylight 0,1,0 --sky 1,1,1",
        "--clamp some",
        "--meet discs",
        "--marching 0x4",
        "--proxies -1",
        "--sky 1,1,1 --environment a.hdr",
        "--nonsense",
        "--albedo x",
        "more",
    ];
    for options in table {
        let arguments: Vec<&str> = ["render", "cornell-box"].into_iter().chain(options.split(' ')).collect();
        refused(folder.path(), 2, &arguments);
    }
    refused(folder.path(), 2, &["render"]);
    refused(folder.path(), 2, &["paint", "cornell-box"]);
    refused(folder.path(), 2, &["compare", "cornell-box", "--samples", "0"]);
    refused(folder.path(), 2, &["devices", "cornell-box"]);
}

#[test]
fn work_that_fails() {
    let folder = folder();
    let small = |more: &[&'static str]| [&["render", "cornell-box", "--size", "16x16"], more].concat();
    let adapter = small(&["--backend", "gpu", "--adapter", "no-such-adapter"]);
    refused_in_a_line(folder.path(), 1, &adapter, "no-such-adapter");
    refused_in_a_line(
        folder.path(),
        1,
        &["compare", "cornell-box", "--adapter", "no-such-adapter"],
        "adapter",
    );
    if cfg!(target_os = "linux") {
        // Nobody, not even root, makes files there.
        refused_in_a_line(folder.path(), 1, &small(&["-o", "/proc/x.png"]), "/proc/x.png");
        refused_in_a_line(
            folder.path(),
            1,
            &small(&["-o", "/proc/x.exr", "--technique", "reference"]),
            "/proc/x.exr",
        );
    }
    // A file name that is too long for the file system.
    let long = format!("{}.png", "a".repeat(300));
    let before = listing(folder.path());
    let ran = run(folder.path(), &["render", "cornell-box", "--size", "16x16", "-o", &long]);
    assert_eq!((ran.code, ran.errors().len()), (Some(1), 1), "{}", ran.err);
    assert!(listing(folder.path()) == before);
}

#[test]
fn without_a_driver_the_gpu_is_refused_with_advice() {
    let folder = folder();
    let before = listing(folder.path());
    for arguments in
        [&["render", "cornell-box", "--size", "16x16", "--backend", "gpu"][..], &["compare", "cornell-box"]]
    {
        let ran = finish(without_drivers(command(folder.path(), arguments)));
        assert_eq!((ran.code, ran.errors().len(), ran.out.as_str()), (Some(1), 1, ""), "{}", ran.err);
        for word in ["no GPU adapter", "install", "CPU"] {
            assert!(ran.errors()[0].contains(word), "{}", ran.err);
        }
        assert!(listing(folder.path()) == before);
    }
    // Where either will do, the CPU does.
    let auto = ["render", "cornell-box", "--size", "16x16", "--backend", "auto", "--json", "-o", "a.png"];
    let ran = finish(without_drivers(command(folder.path(), &auto)));
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(ran.json()["machine"].as_str().unwrap().starts_with("cpu"));
}

#[test]
fn the_checks_would_notice() {
    let folder = folder();
    let ok = ["render", "cornell-box", "--size", "4x4"];
    let noticed = |code: i32, arguments: &[&str]| {
        std::panic::catch_unwind(|| refused(folder.path(), code, arguments)).is_err()
    };
    assert!(noticed(2, &ok), "a command that succeeds");
    assert!(noticed(1, &["render", "cornell-box", "--fov", "0"]), "another code");
    assert!(!noticed(2, &["render", "cornell-box", "--fov", "0"]));
}
