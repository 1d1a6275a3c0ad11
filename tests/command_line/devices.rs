//! `devices` and `compare`, with and without a GPU.

use crate::{command, finish, run, succeed, support, without_drivers};

#[test]
fn devices_are_listed_or_missed_clearly() {
    let folder = tempfile::tempdir().unwrap();
    let ran = finish(without_drivers(command(folder.path(), &["devices"])));
    assert_eq!((ran.code, ran.err.as_str()), (Some(0), ""));
    assert_eq!(ran.out.lines().count(), 1, "{}", ran.out);
    assert!(ran.out.starts_with("no GPU adapter") && ran.out.contains("install"), "{}", ran.out);
    let ran = finish(without_drivers(command(folder.path(), &["devices", "--json"])));
    assert_eq!((ran.code, ran.json()["adapters"].as_array().unwrap().len()), (Some(0), 0));

    let text = succeed(folder.path(), &["devices"]).out;
    let json = succeed(folder.path(), &["devices", "--json"]).json();
    let adapters = json["adapters"].as_array().unwrap();
    for adapter in adapters {
        assert!(text.contains(adapter["name"].as_str().unwrap()), "{text}");
        assert!(adapter["buffer_bytes"].as_u64().unwrap() > 0 && adapter["probe"].is_object(), "{adapter}");
    }
    assert_eq!(text.contains("strict arithmetic: "), !adapters.is_empty(), "{text}");
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none());
}

#[test]
fn every_pass_is_exact_on_the_cornell_box() {
    if support::strict_gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let options =
        ["compare", "cornell-box", "--size", "64x64", "--samples", "4", "--emissive", "--sky", "0.1,0.2,0.3"];
    let json = succeed(folder.path(), &[&options[..], &["--json"]].concat()).json();
    let passes = json["passes"].as_array().unwrap();
    assert!(passes.len() >= 8, "{json}");
    for pass in passes {
        assert_eq!((&pass["holds"], &pass["different"]), (&true.into(), &0.into()), "{pass}");
        assert!(pass["elements"].as_u64().unwrap() > 0, "{pass}");
    }
    let of = |name: &str| passes.iter().filter(|p| p["pass"] == name).count();
    assert_eq!(
        (of("fill_background"), of("ambient_openness") >= 2, of("draw_proxies")),
        (6, true, 1),
        "{json}"
    );
    assert!(["shrink_layers", "layered_diffuse", "shadow_cone"].iter().all(|p| of(p) >= 1));
    assert!(["child_pairs", "inject_photons", "filter_radiance", "cone_diffuse"].iter().all(|p| of(p) >= 1));
    assert!(
        ["overlap_pairs", "trace_rays", "filter_lists", "gather_diffuse", "upsample"]
            .iter()
            .all(|p| of(p) >= 1),
        "{json}"
    );
    // As a table; rays that meet discs are a pass in the place of those that meet triangles.
    let text = succeed(folder.path(), &[&options[..], &["--meet", "proxies"]].concat()).out;
    assert_eq!(text.lines().filter(|l| l.ends_with(" yes")).count(), passes.len(), "{text}");
    assert!(text.contains("march_rays") && !text.contains(" NO"), "{text}");
    let fast = run(folder.path(), &[&options[..], &["--arithmetic", "fast", "--json"]].concat());
    assert!(matches!(fast.code, Some(0)), "{}", fast.err);
    assert_eq!(fast.json()["arithmetic"], "Fast");
    assert!(std::fs::read_dir(folder.path()).unwrap().next().is_none());
}

#[test]
fn render_on_the_gpu_writes_the_picture_of_the_cpu() {
    if support::strict_gpu().is_none() {
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let render = |name: &str, more: &[&str]| {
        let base = ["render", "cornell-glossy", "--size", "64x48", "-o", name, "--quiet"];
        succeed(folder.path(), &[&base[..], more].concat());
        std::fs::read(folder.path().join(name)).unwrap()
    };
    let cpu = render("cpu.exr", &[]);
    assert!(cpu == render("gpu.exr", &["--backend", "gpu", "--arithmetic", "strict"]));
    assert!(cpu != render("other.exr", &["--fov", "38"]), "negative control: another angle of view");
    let fast = render("fast.exr", &["--backend", "gpu"]);
    // Compressed: nearly the same bits take nearly the same bytes.
    assert!(fast.len().abs_diff(cpu.len()) < cpu.len() / 20, "{} and {}", fast.len(), cpu.len());
}
