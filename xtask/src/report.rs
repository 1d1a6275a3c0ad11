//! How is `docs/tradeoff` made, and the table in the README from it?

use crate::shaders::root;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A scene of the report.
struct Subject {
    folder: &'static str,
    /// What `twinlight tradeoff` is told of it.
    scene: &'static str,
    /// The file that it needs, of the folder `TWINLIGHT_SCENES`.
    file: Option<&'static str>,
    /// Pictures may be published, with this line beside them.
    pictures: &'static str,
    credit: &'static str,
}

const SUBJECTS: [Subject; 6] = [
    Subject { folder: "cornell-box", scene: "cornell-box", file: None, pictures: "front", credit: "" },
    Subject {
        folder: "sponza",
        scene: "sponza.glb --eye=-11,1.7,-0.5 --target=8,4.5,0 --fov=60 --sun=0.25,-1,0.15:12,11,9.5 --no-scene-lights",
        file: Some("sponza.glb"),
        pictures: "front",
        credit: "Sponza: © 2010 Frank Meinl, Crytek, after Marko Dabrović's model of 2002; corrections by Morgan McGuire; CC BY 3.0",
    },
    Subject {
        folder: "sibenik",
        scene: "sibenik.glb --eye=-14,4,0 --target=10,7,0 --fov=65 --point=0,8,0:120,115,100 --no-scene-lights",
        file: Some("sibenik.glb"),
        pictures: "none",
        credit: "Sibenik Cathedral: Marko Dabrović (numbers only)",
    },
    Subject { folder: "spheres", scene: "spheres", file: None, pictures: "front", credit: "" },
    Subject { folder: "cornell-glossy", scene: "cornell-glossy", file: None, pictures: "front", credit: "" },
    Subject {
        folder: "dragon",
        scene: "dragon.glb --eye=0.6,1.2,2.4 --target=0,0.45,0 --fov=40 --fit-spheres 64 --daylight 0.5,0.6,0.4 --no-scene-lights",
        file: Some("dragon.glb"),
        pictures: "none",
        credit: "Stanford dragon: Stanford Computer Graphics Laboratory (numbers only)",
    },
];

/// Measures everything again, on the CPU or the GPU, and writes `docs/tradeoff` and the README's table.
pub fn report(gpu: bool, kernels: bool, resume: bool, limit: Option<&str>) -> Result<(), String> {
    let build = Command::new("cargo").args(["build", "--release"]).current_dir(root()).status();
    if !build.is_ok_and(|s| s.success()) {
        return Err("the release build failed".into());
    }
    let twinlight = root().join("target/release").join(format!("twinlight{}", std::env::consts::EXE_SUFFIX));
    let scenes = std::env::var_os("TWINLIGHT_SCENES").map(PathBuf::from);
    let out = root().join("docs/tradeoff").join(if gpu { "gpu" } else { "cpu" });
    for s in &SUBJECTS {
        let folder = scenes.clone().unwrap_or_else(root);
        if let Some(file) = s.file.filter(|f| !folder.join(f).is_file()) {
            println!("== left out: {file} is not in the folder TWINLIGHT_SCENES");
            continue;
        }
        println!("== {}", s.folder);
        let mut command = Command::new(&twinlight);
        command
            .current_dir(&folder)
            .args(["tradeoff", s.scene, "--credit", s.credit, "-o"])
            .arg(out.join(s.folder));
        let size = if gpu { "512x512" } else { "256x256" };
        let pictures = if gpu { "none" } else { s.pictures };
        command.args(["--size", size, "--pictures", pictures]);
        if gpu {
            command.args(["--backend", "gpu", "--repeats", "5"]);
        }
        if !resume {
            command.arg("--restart");
        }
        command.args(limit.map(|l| ["--time-limit", l]).into_iter().flatten());
        run(command)?;
    }
    if kernels {
        let mut command = Command::new(&twinlight);
        command.args(["tradeoff", "--kernels", "-o"]).arg(&out);
        run(command)?;
    }
    write_tables()
}

fn run(mut command: Command) -> Result<(), String> {
    let status = command.status().map_err(|e| format!("twinlight: cannot start: {e}"))?;
    if status.success() { Ok(()) } else { Err("twinlight tradeoff failed: see above".into()) }
}

const BEGIN: &str = "<!-- from docs/tradeoff by cargo xtask report -->\n";
const END: &str = "<!-- end -->";

/// Puts the table into the README, and writes all tables.
pub fn write_tables() -> Result<(), String> {
    let path = root().join("README.md");
    let readme = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
    let table = both_tables()?;
    std::fs::write(&path, with_table(&readme, &table)?).map_err(|e| e.to_string())?;
    std::fs::write(root().join("docs/tradeoff/tables.md"), all_tables()?).map_err(|e| e.to_string())
}

/// The README's tables: of the CPU and of the GPU.
fn both_tables() -> Result<String, String> {
    let of = |machine: &str| table(&root().join("docs/tradeoff").join(machine));
    Ok(of("cpu")? + of("gpu")?.trim_start_matches('\n'))
}

/// Fronts and stages of both machines.
fn all_tables() -> Result<String, String> {
    let mut text = "# What accuracy costs in time: tables\n\nWritten by `cargo xtask report` from the data beside this file.\n".to_owned();
    for (machine, title) in [("cpu", "CPU"), ("gpu", "GPU")] {
        let folder = root().join("docs/tradeoff").join(machine);
        for scene in scenes(&folder)? {
            let (record, scene) = &scene;
            let of = |key: &str| record[key].as_str().unwrap_or_default();
            text += &format!("\n## {title}: {}\n", scene["name"].as_str().unwrap_or_default());
            text += &format!("\n{}; `{}`\n", of("machine"), of("command"));
            let noise = scene["reference"]["noise_indirect"].as_f64().unwrap_or(f64::NAN);
            text += &format!(
                "Noise of the reference's indirect light, not in the errors: {:.1} %.\n",
                100.0 * noise
            );
            text += &scene_rows(scene);
            text += &stage_rows(scene);
        }
    }
    Ok(text)
}

fn stage_rows(scene: &Value) -> String {
    let stages = scene["attribution"].as_array().map_or(&[][..], Vec::as_slice);
    if stages.is_empty() {
        return String::new();
    }
    let mut text =
        "| stage | replaced by | relative RMSE before | after | mean ratio | share of squared error |\n\
                    |---|---|---|---|---|---|\n"
            .to_owned();
    for s in stages {
        let (word, number) =
            (|k: &str| s[k].as_str().unwrap_or_default(), |k: &str| s[k].as_f64().unwrap_or(f64::NAN));
        let (after, least) = (number("relative_rmse"), number("resolution"));
        text += &format!(
            "| {}: {} | {} | {:.1} % | {}{:.1} % | {:.3} | {:.0} % |\n",
            word("technique"),
            word("stage"),
            word("exact"),
            100.0 * number("before"),
            if after < least { "< " } else { "" },
            100.0 * after.max(least),
            number("mean_ratio"),
            100.0 * number("share")
        );
    }
    text + "\n"
}

/// The scenes of a folder with the records that they are in.
pub fn scenes(folder: &Path) -> Result<Vec<(Value, Value)>, String> {
    let mut all = Vec::new();
    for s in &SUBJECTS {
        let path = folder.join(s.folder).join("tradeoff.json");
        let Ok(bytes) = std::fs::read(&path) else { continue };
        let record: Value = serde_json::from_slice(&bytes).map_err(|e| format!("{}: {e}", path.display()))?;
        for scene in record["scenes"].as_array().into_iter().flatten() {
            all.push((record.clone(), scene.clone()));
        }
    }
    Ok(all)
}

fn with_table(readme: &str, table: &str) -> Result<String, String> {
    let missing = || "README.md has lost the marks of the table".to_owned();
    let (before, rest) = readme.split_once(BEGIN).ok_or_else(missing)?;
    let (_, after) = rest.split_once(END).ok_or_else(missing)?;
    Ok(format!("{before}{BEGIN}{table}{END}{after}"))
}

/// Each technique's defaults in each scene of the folder.
fn table(folder: &Path) -> Result<String, String> {
    let mut text = String::new();
    for (i, (record, scene)) in scenes(folder)?.iter().enumerate() {
        if i == 0 {
            let machine = record["machine"].as_str().unwrap_or_default();
            let [width, height] = [0, 1].map(|k| scene["size"][k].as_u64().unwrap_or(0));
            text += &format!(
                "\n{machine}, {width} × {height}:\n\n| scene | technique | relative RMSE | mean ratio | ms | {PATH} |\n"
            );
            text += "|---|---|---|---|---|---|\n";
        }
        let light = if scene["axis"] == "all" { ", all light" } else { "" };
        let head = format!("| {}{light} | ", scene["name"].as_str().unwrap_or_default());
        for row in rows(scene, |p| p["knob"] == "") {
            text += &format!("{head}{} | {} |\n", row.technique, row.figures);
        }
    }
    Ok(text + "\n")
}

const PATH: &str = "path tracer for this error";

/// Each technique's defaults, and what nothing else beats.
fn scene_rows(scene: &Value) -> String {
    let light = if scene["axis"] == "all" { "all light" } else { "indirect light" };
    let mut text = format!(
        "\n| {}, {light} | relative RMSE | mean ratio | ms | {PATH} | front |\n|---|---|---|---|---|---|\n",
        scene["name"].as_str().unwrap_or_default()
    );
    for row in rows(scene, |p| p["knob"] == "" || p["pareto"] == true) {
        let settings =
            if row.settings.is_empty() { "defaults".into() } else { format!("`{}`", row.settings) };
        let front = if row.front { "●" } else { "" };
        text += &format!("| {}, {settings} | {} | {front} |\n", row.technique, row.figures);
    }
    text + "\n"
}

struct Row {
    technique: String,
    settings: String,
    /// Error, ratio, time and that of the path tracer, as columns.
    figures: String,
    front: bool,
}

/// The points of a scene that are asked for, by time.
fn rows(scene: &Value, wanted: impl Fn(&Value) -> bool) -> Vec<Row> {
    let axis = scene["axis"].as_str().unwrap_or("indirect");
    let mut points: Vec<&Value> = scene["points"].as_array().into_iter().flatten().collect();
    // What the reference's noise hides is at most the resolution.
    let raw = |p: &Value| p[axis]["relative_rmse"].as_f64().unwrap_or(f64::NAN);
    let least = |p: &Value| p[axis]["resolution"].as_f64().unwrap_or(0.0);
    let error = |p: &Value| if raw(p) < least(p) { least(p) } else { raw(p) };
    let is_path = |p: &&Value| p["technique"] == "reference";
    let paths: Vec<_> = points.iter().copied().filter(is_path).map(|p| (error(p), seconds(p))).collect();
    points.retain(|p| wanted(p));
    points.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    let row = |p: &Value| Row {
        technique: p["technique"].as_str().unwrap_or_default().to_owned(),
        settings: p["settings"].as_str().unwrap_or_default().to_owned(),
        figures: format!(
            "{}{:.1} % | {:.3} | {:.0} | {}",
            if raw(p) < error(p) { "< " } else { "" },
            100.0 * error(p),
            p[axis]["mean_ratio"].as_f64().unwrap_or(f64::NAN),
            1e3 * seconds(p),
            times(path_seconds(&paths, error(p)), seconds(p), paths.last().is_some_and(|p0| error(p) < p0.0))
        ),
        front: p["pareto"] == true,
    };
    points.into_iter().map(row).collect()
}

/// How many times as long; a star where the path tracer was not measured with so many paths.
fn times(path: Option<f64>, own: f64, beyond: bool) -> String {
    let star = if beyond { "\\*" } else { "" };
    match path.map(|t| t / own) {
        Some(x) if x >= 9.95 => format!("× {x:.0}{star}"),
        Some(x) => format!("× {x:.2}{star}"),
        None => "beyond what was measured".to_owned(),
    }
}

/// The time that the path tracer takes for an error, between its points (error, seconds), and beyond them by the root of the number of paths up
/// to half of the least error.
fn path_seconds(points: &[(f64, f64)], error: f64) -> Option<f64> {
    let least = *points.last()?;
    if error <= least.0 {
        return (error >= 0.5 * least.0).then(|| least.1 * (least.0 / error).powi(2));
    }
    if error >= points[0].0 {
        return Some(points[0].1);
    }
    let pair = points.windows(2).find(|w| w[0].0 >= error && error >= w[1].0)?;
    let share = (pair[0].0 / error).ln() / (pair[0].0 / pair[1].0).ln();
    Some(pair[0].1 * (pair[1].1 / pair[0].1).powf(share))
}

fn seconds(point: &Value) -> f64 {
    point["seconds"]["median"].as_f64().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_tracers_time_lies_between_its_points() {
        let points = [(0.8, 1.0), (0.4, 4.0), (0.2, 16.0)];
        let at = |error| path_seconds(&points, error).unwrap();
        assert!((at(0.4) - 4.0).abs() < 1e-9 && (at(0.4 * 2f64.sqrt()) - 2.0).abs() < 1e-9);
        assert!(at(1.0) == 1.0 && (at(0.1) - 64.0).abs() < 1e-9 && path_seconds(&points, 0.09).is_none());
        assert!(path_seconds(&[], 0.5).is_none() && path_seconds(&points, f64::NAN).is_none());
    }

    #[test]
    fn the_readmes_table_is_that_of_the_data() {
        let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
        let table = both_tables().unwrap();
        assert!(table.contains("| sponza | voxel-cones |"), "{table}");
        assert!(with_table(&readme, &table).unwrap() == readme, "run cargo xtask report --table");
        let tables = std::fs::read_to_string(root().join("docs/tradeoff/tables.md")).unwrap();
        assert!(all_tables().unwrap() == tables, "run cargo xtask report --table");
        // Negative control: another number is another table.
        let other = table.replacen(" % ", "1 % ", 1);
        assert_ne!(with_table(&readme, &other).unwrap(), readme);
    }
}
