//! `explain`, effects and budgets, and frames in parts.

use crate::{run, succeed};
use std::path::Path;

#[test]
fn explain_tells_what_render_then_does() {
    let folder = tempfile::tempdir().unwrap();
    let options =
        ["cornell-glossy", "--technique", "voxel-cones", "--size", "32x24", "--resolution", "16", "--json"];
    let plan = succeed(folder.path(), &[&["explain"][..], &options].concat()).json();
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none(), "explain writes nothing");
    let ran = succeed(folder.path(), &[&["render"][..], &options, &["-o", "a.exr"]].concat()).json();
    let runs = |json: &serde_json::Value| json["passes"].as_array().unwrap().len();
    let total: u64 = ran["passes"].as_array().unwrap().iter().map(|p| p["runs"].as_u64().unwrap()).sum();
    assert_eq!(runs(&plan) as u64, total);
    let called: Vec<_> = plan["effects"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|e| e["called"] == true)
        .map(|e| &e["effect"])
        .collect();
    assert_eq!(called, ran["effects"].as_array().unwrap().iter().collect::<Vec<_>>());
    let again = |what: &str| {
        let rows = plan["again"].as_array().unwrap();
        rows.iter().find(|r| r["change"] == what).unwrap()["passes"].as_array().unwrap().len()
    };
    assert_eq!((again("nothing"), again("meshes")), (0, runs(&plan)));
    assert!(again("camera") < again("lights") && again("lights") < again("meshes"), "{plan}");
    assert!(
        plan["bytes"].as_u64().unwrap() > 100_000 && plan["scene"]["glossy_share"].as_f64().unwrap() > 0.1
    );
    let text = succeed(folder.path(), &["explain", "spheres"]).out;
    for word in ["auto chose soft-gi", "proxy-bounce", "bytes in all", "runs again", "meshes move"] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn effects_and_budgets_leave_passes_out() {
    let folder = tempfile::tempdir().unwrap();
    let base =
        ["render", "cornell-glossy", "--technique", "voxel-cones", "--size", "32x24", "--resolution", "16"];
    let passes = |options: &[&str]| {
        let ran = succeed(folder.path(), &[&base[..], options, &["-o", "a.exr", "--json"]].concat());
        let json = ran.json();
        let names: Vec<String> = json["passes"]
            .as_array()
            .unwrap()
            .iter()
            .map(|p| p["pass"].as_str().unwrap().to_owned())
            .collect();
        (names, ran.err)
    };
    let (all, _) = passes(&[]);
    assert!(["cone_specular", "cone_diffuse", "shade_specular"].iter().all(|p| all.iter().any(|x| x == p)));
    let (some, _) = passes(&["--effects", "lights,bounce"]);
    assert!(
        some.iter().any(|p| p == "cone_diffuse") && !some.iter().any(|p| p.contains("specular")),
        "{some:?}"
    );
    let (tight, err) = passes(&["--budget", "0.0001ms"]);
    assert!(err.contains("two trials: lights") && !tight.iter().any(|p| p == "cone_diffuse"), "{err}");
}

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    std::fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

#[test]
fn frames_come_in_parts_with_the_same_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let base = [
        "render",
        "spheres",
        "--technique",
        "soft-gi",
        "--size",
        "24x16",
        "--fps",
        "5",
        "--orbit",
        "10",
        "--frames",
        "1..6",
    ];
    let ran = succeed(folder.path(), &[&base[..], &["-o", "all/%03d.exr"]].concat());
    assert!(ran.out.contains("wrote 6 frames to all") && ran.out.contains("camera, meshes"), "{}", ran.out);
    for part in ["1/4", "2/4", "3/4", "4/4"] {
        succeed(folder.path(), &[&base[..], &["-o", "parts/%03d.exr", "--shard", part, "--quiet"]].concat());
    }
    for frame in 1..=6 {
        let name = format!("{frame:03}.exr");
        assert_eq!(
            bytes(&folder.path().join("all"), &name),
            bytes(&folder.path().join("parts"), &name),
            "{name}"
        );
    }
    assert_ne!(bytes(&folder.path().join("all"), "001.exr"), bytes(&folder.path().join("all"), "002.exr"));
    // Frames that are there stay; one that is missing is made again.
    let whole = bytes(folder.path(), "all/004.exr");
    std::fs::remove_file(folder.path().join("all/004.exr")).unwrap();
    std::fs::write(folder.path().join("all/002.exr"), "mine").unwrap();
    let ran = succeed(folder.path(), &[&base[..], &["-o", "all/%03d.exr", "--resume"]].concat());
    assert!(ran.out.contains("wrote 1 frames to all") && ran.out.contains("5 were there"), "{}", ran.out);
    assert_eq!(
        (bytes(folder.path(), "all/004.exr"), bytes(folder.path(), "all/002.exr")),
        (whole, b"mine".to_vec())
    );
}

#[test]
fn a_still_scene_costs_nothing_again() {
    let folder = tempfile::tempdir().unwrap();
    let base =
        ["render", "cornell-box", "--technique", "voxel-cones", "--size", "24x16", "--resolution", "16"];
    let ran = run(folder.path(), &[&base[..], &["--frames", "0..2", "-o", "still"]].concat());
    let table = ran.out.lines().skip_while(|l| !l.trim_start().starts_with("frame")).skip(1);
    let rows: Vec<&str> = table.take(3).collect();
    let passes = |row: &str| row.split_whitespace().nth(2).unwrap().parse::<u32>().unwrap();
    assert!(passes(rows[0]) > 50 && passes(rows[1]) == 0 && passes(rows[2]) == 0, "{}", ran.out);
}
