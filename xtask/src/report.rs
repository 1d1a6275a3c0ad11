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

const SUBJECTS: [Subject; 4] = [
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
];

/// Measures everything again, on the CPU or the GPU, and writes `docs/tradeoff` and the README's table.
pub fn report(gpu: bool, kernels: bool, limit: Option<&str>) -> Result<(), String> {
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
        command.current_dir(&folder).args([
            "tradeoff",
            s.scene,
            "--size",
            "256x256",
            "--pictures",
            s.pictures,
        ]);
        command.args(["--credit", s.credit, "-o"]).arg(out.join(s.folder));
        if gpu {
            command.args(["--backend", "gpu"]);
        }
        command.args(limit.map(|l| ["--time-limit", l]).into_iter().flatten());
        run(command)?;
    }
    if kernels {
        let mut command = Command::new(&twinlight);
        command.args(["tradeoff", "--kernels", "-o"]).arg(&out);
        run(command)?;
    }
    write_readme()
}

fn run(mut command: Command) -> Result<(), String> {
    let status = command.status().map_err(|e| format!("twinlight: cannot start: {e}"))?;
    if status.success() { Ok(()) } else { Err("twinlight tradeoff failed: see above".into()) }
}

const BEGIN: &str = "<!-- from docs/tradeoff by cargo xtask report -->\n";
const END: &str = "<!-- end -->";

/// Puts the table into the README.
pub fn write_readme() -> Result<(), String> {
    let path = root().join("README.md");
    let readme = std::fs::read_to_string(&path).map_err(|e| e.to_string())?;
    let table = table(&root().join("docs/tradeoff/cpu"))?;
    std::fs::write(&path, with_table(&readme, &table)?).map_err(|e| e.to_string())
}

fn with_table(readme: &str, table: &str) -> Result<String, String> {
    let missing = || "README.md has lost the marks of the table".to_owned();
    let (before, rest) = readme.split_once(BEGIN).ok_or_else(missing)?;
    let (_, after) = rest.split_once(END).ok_or_else(missing)?;
    Ok(format!("{before}{BEGIN}{table}{END}{after}"))
}

/// For each scene of the folder: each technique's defaults, and what nothing else beats.
fn table(folder: &Path) -> Result<String, String> {
    let mut text = String::new();
    for s in &SUBJECTS {
        let path = folder.join(s.folder).join("tradeoff.json");
        let Ok(bytes) = std::fs::read(&path) else { continue };
        let record: Value = serde_json::from_slice(&bytes).map_err(|e| format!("{}: {e}", path.display()))?;
        for scene in record["scenes"].as_array().into_iter().flatten() {
            text += &scene_rows(scene);
        }
    }
    Ok(text)
}

fn scene_rows(scene: &Value) -> String {
    let axis = scene["axis"].as_str().unwrap_or("indirect");
    let light = if axis == "all" { "all light" } else { "indirect light" };
    let mut rows: Vec<&Value> = scene["points"].as_array().into_iter().flatten().collect();
    rows.retain(|p| p["knob"] == "" || p["pareto"] == true || p["settings"] == "--samples 16");
    rows.sort_by(|a, b| seconds(a).total_cmp(&seconds(b)));
    let mut text = format!(
        "\n| {}, {light} | relative RMSE | mean ratio | ms | front |\n|---|---|---|---|---|\n",
        scene["name"].as_str().unwrap_or_default()
    );
    for p in rows {
        let technique = p["technique"].as_str().unwrap_or_default();
        let settings = match p["settings"].as_str().unwrap_or_default() {
            "" => "defaults".to_owned(),
            s => format!("`{s}`"),
        };
        let name = if technique == "reference" { "path tracer" } else { technique };
        let errors = &p[axis];
        let number = |key: &str| errors[key].as_f64().unwrap_or(f64::NAN);
        text += &format!(
            "| {name}, {settings} | {:.1} % | {:.3} | {:.0} | {} |\n",
            100.0 * number("relative_rmse"),
            number("mean_ratio"),
            1e3 * seconds(p),
            if p["pareto"] == true { "●" } else { "" }
        );
    }
    text + "\n"
}

fn seconds(point: &Value) -> f64 {
    point["seconds"]["median"].as_f64().unwrap_or(f64::NAN)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_readmes_table_is_that_of_the_data() {
        let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
        let table = table(&root().join("docs/tradeoff/cpu")).unwrap();
        assert!(table.contains("voxel-cones") && table.contains("path tracer"), "{table}");
        assert!(with_table(&readme, &table).unwrap() == readme, "run cargo xtask report --table");
        // Negative control: another number is another table.
        let other = table.replacen(" % ", "1 % ", 1);
        assert_ne!(with_table(&readme, &other).unwrap(), readme);
    }
}
