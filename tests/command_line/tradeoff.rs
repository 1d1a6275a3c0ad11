//! `tradeoff`, and settings chosen by what it measures.

use crate::{command, finish, listing, run, succeed};
use serde_json::Value;
use std::path::Path;
use std::process::Command;
use twinlight::picture::Picture;
use twinlight::report::halves::Halves;

/// A report that takes little: the spheres by soft-gi's steps, and the path tracer.
const SMALL: [&str; 11] = [
    "tradeoff",
    "spheres",
    "--size",
    "32x24",
    "--steps-only",
    "--techniques",
    "soft-gi,reference",
    "--samples",
    "16",
    "--repeats",
    "1",
];

fn report(folder: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(folder.join("out/tradeoff.json")).unwrap()).unwrap()
}

fn points(record: &Value) -> &Vec<Value> {
    record["scenes"][0]["points"].as_array().unwrap()
}

#[test]
fn a_report_has_all_its_parts_and_goes_on_where_it_was() {
    let folder = tempfile::tempdir().unwrap();
    let options = [&SMALL[..], &["-o", "out"]].concat();
    let ran = succeed(folder.path(), &options);
    assert!(ran.out.contains("what no other setting beats") && ran.out.contains("index.html"), "{}", ran.out);
    let first = report(folder.path());
    let all = points(&first);
    // Defaults and four steps; eight numbers of paths.
    assert_eq!(all.len(), 5 + 8);
    for p in all {
        let e = &p["all"];
        let ratio = e["mean_ratio"].as_f64().unwrap();
        assert!(p["seconds"]["median"].as_f64().unwrap() > 0.0 && (ratio - 1.0).abs() < 0.3, "{p}");
        assert!(e["relative_rmse"].as_f64().unwrap() < 1.5 && p["flip"].as_f64().unwrap() < 0.9, "{p}");
        assert!(p["technique"] == "reference" || p["bytes"].as_u64().unwrap() > 1000, "{p}");
    }
    let front: Vec<_> = all.iter().filter(|p| p["pareto"] == true).collect();
    assert!(!front.is_empty() && front.iter().all(|p| p["technique"] == "soft-gi"));
    // More paths, less error.
    let error = |settings: &str| {
        let p = all.iter().find(|p| p["settings"] == settings).unwrap();
        p["all"]["relative_rmse"].as_f64().unwrap()
    };
    assert!(error("--samples 128") < 0.5 * error("--samples 1"));
    let csv = std::fs::read_to_string(folder.path().join("out/tradeoff.csv")).unwrap();
    let columns = csv.lines().next().unwrap().split(',').count();
    assert_eq!(csv.lines().count(), 1 + all.len());
    assert!(csv.lines().all(|l| l.split(',').count() == columns), "{csv}");
    let stages = first["scenes"][0]["attribution"].as_array().unwrap();
    assert!(stages.iter().any(|s| s["stage"] == "order of harmonics"), "{stages:?}");
    let svg = std::fs::read_to_string(folder.path().join("out/spheres-all.svg")).unwrap();
    assert!(svg.contains("soft-gi") && svg.contains("path tracer") && svg.ends_with("</svg>\n"), "{svg}");
    let page = std::fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    assert!(!page.contains("/*DATA*/") && page.contains("data:image/jpeg;base64,"));

    // The same command measures nothing again; the errors of another run are the same.
    succeed(folder.path(), &options);
    let second = report(folder.path());
    assert_eq!((second["runs"].as_u64(), points(&second)), (Some(2), all));
    succeed(folder.path(), &[&options[..], &["--restart"]].concat());
    let third = report(folder.path());
    let errors = |record: &Value| {
        points(record).iter().map(|p| (p["all"].clone(), p["flip"].clone())).collect::<Vec<_>>()
    };
    assert_eq!((third["runs"].as_u64(), errors(&third)), (Some(1), errors(&first)));
    let other = run(folder.path(), &[&options[..], &["--albedo", "0.5"]].concat());
    assert!(other.code == Some(2) && other.err.contains("--restart"), "{}", other.err);
}

#[test]
fn the_command_of_a_point_renders_its_picture() {
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &[&SMALL[..], &["--no-attribution", "--pictures", "none", "-o", "out"]].concat());
    let record = report(folder.path());
    let point =
        points(&record).iter().find(|p| p["settings"].as_str().unwrap().contains("--order 2")).unwrap();
    let words: Vec<&str> = point["command"].as_str().unwrap().split(' ').skip(1).collect();
    succeed(folder.path(), &[&words[..], &["-o", "a.exr"]].concat());
    succeed(
        folder.path(),
        &["render", "spheres", "--size", "32x24", "--technique", "soft-gi", "-o", "b.exr"],
    );
    let half = |n: u32| {
        let name = format!("out/parts/spheres.reference.{n}.all.exr");
        Picture::open_exr(&folder.path().join(name)).unwrap()
    };
    let right = Halves::new(half(1), half(2)).unwrap().averaged(4);
    let errors = |name: &str| {
        let picture = Picture::open_exr(&folder.path().join(name)).unwrap();
        serde_json::to_value(right.errors(&picture.averaged(4)).unwrap()).unwrap()
    };
    let close =
        |a: &Value, b: &Value, key: &str| (a[key].as_f64().unwrap() - b[key].as_f64().unwrap()).abs() < 1e-9;
    for key in ["relative_rmse", "mean_ratio", "p50", "max", "resolution"] {
        assert!(close(&errors("a.exr"), &point["all"], key), "{key}: {} {point}", errors("a.exr"));
    }
    // Negative control: other settings have another error.
    assert!(!close(&errors("b.exr"), &point["all"], "relative_rmse"));
    assert!(
        std::fs::read_dir(folder.path().join("out/parts"))
            .unwrap()
            .all(|f| { !f.unwrap().file_name().to_string_lossy().ends_with(".jpg") })
    );
}

#[test]
fn requests_that_make_no_report() {
    let folder = tempfile::tempdir().unwrap();
    let table = [
        (vec!["tradeoff"], 2, "SCENE"),
        (vec!["tradeoff", "spheres"], 2, "--output"),
        (vec!["tradeoff", "no-such.glb", "-o", "out"], 2, "no-such.glb"),
        (vec!["tradeoff", "spheres --nonsense", "-o", "out"], 2, "--nonsense"),
        (vec!["tradeoff", "spheres", "--techniques", "magic", "-o", "out"], 2, "voxel-cones"),
        (vec!["tradeoff", "spheres", "--size", "2x2", "-o", "out"], 2, "--block"),
        (vec!["tradeoff", "spheres", "--time-limit", "soon", "-o", "out"], 2, "90s"),
        (vec!["tradeoff", "spheres", "--kernels"], 2, "cannot be used"),
    ];
    for (arguments, code, word) in table {
        let ran = run(folder.path(), &arguments);
        assert!(
            ran.code == Some(code) && ran.err.contains(word),
            "{arguments:?}: {:?} {}",
            ran.code,
            ran.err
        );
        assert!(listing(folder.path()).is_empty(), "{arguments:?} left something");
    }
    std::fs::create_dir(folder.path().join("out")).unwrap();
    std::fs::write(folder.path().join("out/tradeoff.json"), "{").unwrap();
    let ran = run(folder.path(), &[&SMALL[..], &["-o", "out"]].concat());
    assert!(ran.code == Some(2) && ran.err.contains("--restart"), "{}", ran.err);
    let quick = ["-o", "out", "--restart", "--no-attribution", "--time-limit", "0.001s"];
    succeed(folder.path(), &[&SMALL[..], &quick].concat());
    std::fs::write(folder.path().join("file"), "").unwrap();
    let ran = run(folder.path(), &[&SMALL[..], &["-o", "file"]].concat());
    assert!(ran.code == Some(2) && ran.err.contains("another folder"), "{}", ran.err);
}

#[test]
fn the_page_opens_in_a_browser_without_errors() {
    let browser = ["chromium", "chromium-browser", "google-chrome"]
        .into_iter()
        .find(|name| Command::new(name).arg("--version").output().is_ok_and(|o| o.status.success()));
    let Some(browser) = browser else {
        eprintln!("skipped: no Chromium here; install one (Debian: chromium) to test the page");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    succeed(folder.path(), &[&SMALL[..], &["-o", "out"]].concat());
    let page = std::fs::read_to_string(folder.path().join("out/index.html")).unwrap();
    // With a fault planted, to see that it would show.
    std::fs::write(
        folder.path().join("bad.html"),
        page.replace("const report = {", "const report = {},x=[].a.b;({"),
    )
    .unwrap();
    std::fs::write(folder.path().join("worse.html"), page.replace("\"scenes\":[", "\"rooms\":[")).unwrap();
    let open = |name: &str| {
        let output = Command::new(browser)
            .args(["--headless=new", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=3000"])
            .args(["--enable-logging=stderr", "--dump-dom"])
            // A path from the root stands for itself.
            .arg(format!("file://{}#scene=0&point=2", folder.path().join(name).display()))
            .output()
            .unwrap();
        let dom = String::from_utf8_lossy(&output.stdout).into_owned();
        let console = String::from_utf8_lossy(&output.stderr).lines().any(|l| l.contains("CONSOLE"));
        (dom.contains("data-state=\"ready\""), console)
    };
    assert_eq!(open("out/index.html"), (true, false));
    assert!(!open("bad.html").0 && !open("worse.html").0);
    // The pages that the project shows.
    for scene in ["cornell-box", "sponza", "sibenik", "spheres"] {
        let page = format!("{}/docs/tradeoff/cpu/{scene}/index.html", env!("CARGO_MANIFEST_DIR"));
        assert_eq!(open(&page), (true, false), "{scene}");
    }
}

#[test]
fn settings_are_chosen_by_measured_curves() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let render = |options: &[&str]| {
        let base = ["render", "spheres", "--size", "64x48", "--json", "-o", "a.exr"];
        let mut command = command(folder.path(), &[&base[..], options].concat());
        command.env("TWINLIGHT_CACHE", &cache);
        finish(command)
    };
    let measured = "measuring what accuracy costs";
    let first = render(&["--error", "300%"]);
    assert!(first.code == Some(0) && first.err.contains(measured), "{}", first.err);
    let choice = &first.json()["choice"];
    assert_eq!(choice["fits"], true);
    for key in ["expected_seconds", "expected_error", "measured_seconds", "measured_error"] {
        assert!(choice[key].as_f64().unwrap() > 0.0, "{key} {choice}");
    }
    let of = |key: &str| choice[key].as_f64().unwrap();
    assert!((0.5..2.0).contains(&(of("measured_error") / of("expected_error"))), "{choice}");
    // Known now; what cannot be is told, and what comes nearest is done.
    let strict = render(&["--error", "0.001%"]);
    assert!(!strict.err.contains(measured) && strict.err.contains("comes nearest"), "{}", strict.err);
    let best = strict.json()["choice"]["expected_error"].as_f64().unwrap();
    assert!(best <= choice["expected_error"].as_f64().unwrap());
    let good = render(&["--budget", "10s", "--technique", "soft-gi"]);
    assert!(!good.err.contains(measured) && good.json()["choice"]["fits"] == true, "{}", good.err);
    assert!(
        good.json()["choice"]["expected_error"].as_f64().unwrap()
            <= choice["expected_error"].as_f64().unwrap()
    );
    assert!(render(&["--error", "300%", "--recalibrate"]).err.contains(measured));
    // Curves that cannot be read are measured again.
    for file in std::fs::read_dir(&cache).unwrap() {
        std::fs::write(file.unwrap().path(), "{").unwrap();
    }
    assert!(render(&["--error", "300%"]).err.contains(measured));
    for (options, word) in [
        (&["--error", "5"][..], "5%"),
        (&["--error", "5%", "--technique", "reference"], "--samples"),
        (&["--error", "5%", "--technique", "soft-gi", "--order", "3"], "knobs"),
        (&["--error", "5%", "--frames", "0..1"], "--effects"),
        (&["--error", "5%", "--technique", "direct"], "steps"),
        (&["--error", "5%", "--effects", "bounce"], "--effects"),
    ] {
        let ran = render(options);
        assert!(ran.code == Some(2) && ran.err.contains(word), "{options:?}: {}", ran.err);
    }
}
