//! Does any change of one thing in a good file break the reader, or make a scene that kernels cannot bear?

#[path = "../../fuzz/bodies.rs"]
mod bodies;

use crate::file::generator;
use std::panic::catch_unwind;
use std::path::{Path, PathBuf};
use twinlight::scene::Scene;

#[test]
fn every_change_of_one_thing_is_refused_or_rendered() {
    let files = generator::all();
    assert!(files.len() > 5_000, "{}", files.len());
    let results = on_two_threads(files.len(), |i| {
        let (what, bytes) = &files[i];
        let survived = catch_unwind(|| bodies::gltf(bytes)).is_ok();
        let read = survived && Scene::from_gltf(bytes.clone(), Path::new("a.glb"), 0.25).is_ok();
        (what, read, survived, bodies::technique_of(bytes))
    });
    let broken: Vec<_> = results.iter().filter(|r| !r.2).map(|r| r.0).collect();
    assert!(broken.is_empty(), "{} files break it: {:?}", broken.len(), &broken[..broken.len().min(20)]);
    let rendered = |technique| results.iter().filter(|r| r.1 && r.3 == technique).count();
    let by_technique: Vec<usize> = (0..bodies::TECHNIQUES).map(rendered).collect();
    assert!(by_technique.iter().all(|&n| n > 100), "{by_technique:?}");
    let refused = results.iter().filter(|r| !r.1).count();
    println!("{} files: {refused} refused, {} rendered", files.len(), files.len() - refused);
    assert!(refused > 1_000 && files.len() - refused > 500, "{refused}");
}

#[test]
fn the_file_that_is_right_is_read_whole() {
    let bytes = generator::right();
    let scene = Scene::from_gltf(bytes.clone(), Path::new("a.glb"), 0.25).unwrap();
    assert_eq!((scene.triangles.len(), scene.lights.len(), scene.proxies.len()), (3, 3, 1), "{scene:?}");
    assert!(scene.camera.is_some() && scene.materials.len() == 3 && scene.texels.len() == 4);
    bodies::gltf(&bytes);
    // What the checks would say to a scene that is none.
    let mut bad = scene.clone();
    bad.triangles[0].material = 99;
    assert!(catch_unwind(|| bodies::check_scene(&bad)).is_err());
    let mut bad = scene;
    bad.lights[0].intensity.x = f32::NAN;
    assert!(catch_unwind(|| bodies::check_scene(&bad)).is_err());
}

/// Results by number. Not on rayon's threads: while they wait for the kernels' they would begin another file on the same stack.
fn on_two_threads<T: Send>(count: usize, work: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let part = |from: usize| (from..count).step_by(2).map(&work).collect::<Vec<T>>();
    std::thread::scope(|scope| {
        let other = scope.spawn(|| part(1));
        let mut all = part(0);
        all.extend(other.join().unwrap());
        all
    })
}

/// What fuzzing has kept of a kind; more are made from them.
fn corpus(kind: &str) -> Vec<Vec<u8>> {
    let folder: PathBuf = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/corpus").join(kind);
    let mut names: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|e| e.unwrap().path()).collect();
    names.sort();
    assert!(names.len() > 10, "{} files in {}", names.len(), folder.display());
    names.iter().map(|name| std::fs::read(name).unwrap()).collect()
}

/// Each file of a corpus, and changes of it: bytes replaced, left out, doubled, exchanged with those of another.
fn replay(kind: &str, changes: usize, body: fn(&[u8])) {
    let files = corpus(kind);
    let results = on_two_threads(files.len(), |file| {
        let mut state = 0x9E37_79B9_7F4A_7C15u64 ^ file as u64;
        let mut draw = move |limit: usize| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as usize % limit.max(1)
        };
        let mut all = vec![files[file].clone()];
        for _ in 0..changes {
            let mut bytes = files[file].clone();
            for _ in 0..=draw(3) {
                let at = draw(bytes.len());
                let end = (at + 1 + draw(8)).min(bytes.len());
                let other = &files[draw(files.len())];
                let from = draw(other.len());
                let part = other[from..(from + 1 + draw(16)).min(other.len())].to_vec();
                match draw(4) {
                    0 if at < bytes.len() => bytes[at] = draw(256) as u8,
                    1 => drop(bytes.drain(at..end)),
                    2 => drop(bytes.splice(at..at, part)),
                    _ => drop(bytes.splice(at..end, part)),
                }
            }
            all.push(bytes);
        }
        (file, all.iter().all(|bytes| catch_unwind(|| body(bytes)).is_ok()))
    });
    let broken: Vec<usize> = results.into_iter().filter(|r| !r.1).map(|r| r.0).collect();
    assert!(broken.is_empty(), "{kind}: files {broken:?} or changes of them break it");
    println!("{kind}: {} files and {changes} changes of each", files.len());
}

#[test]
fn the_corpora_of_the_fuzzers_are_replayed() {
    replay("gltf", 20, bodies::gltf);
    replay("environment", 20, bodies::environment);
    replay("options", 20, bodies::options);
}

#[cfg(unix)]
#[test]
fn what_has_no_end_is_not_read() {
    let folder = tempfile::tempdir().unwrap();
    let refused = |path: &Path, word: &str| {
        let text = Scene::open(path.to_str().unwrap()).expect_err("refused").to_string();
        assert!(text.contains(word) && !text.contains('\n'), "{text}");
    };
    let link = folder.path().join("zeros.glb");
    std::os::unix::fs::symlink("/dev/zero", &link).unwrap();
    refused(&link, "device");
    let scene = folder.path().join("a.gltf");
    let text = r#"{"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{}], "buffers": [{"uri": "/dev/zero", "byteLength": 12}]}"#;
    std::fs::write(&scene, text).unwrap();
    refused(&scene, "device");
    // Without a block on the disk.
    let large = folder.path().join("large.glb");
    std::fs::File::create(&large).unwrap().set_len(5 << 30).unwrap();
    refused(&large, "5368709120 bytes are more than");
    refused(folder.path(), "no scene");
}
