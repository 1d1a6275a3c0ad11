//! Do choices hold what they promise, from cameras that the curves have not seen?

use crate::shaders::root;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// A scene with its lights, the camera that its curves are measured from, and others.
type Subject = (&'static str, &'static [&'static str], [&'static str; 3]);

const SUBJECTS: [Subject; 3] = [
    (
        "cornell-box",
        &[],
        [
            "",
            "--eye=-0.5,0.7,2.8 --target=0.2,0.9,-0.2 --fov=45",
            "--eye=0.8,1.7,0.6 --target=-0.4,0.4,-0.5 --fov=75",
        ],
    ),
    (
        "sponza.glb",
        &["--sun=0.25,-1,0.15:12,11,9.5", "--no-scene-lights"],
        [
            "--eye=-11,1.7,-0.5 --target=8,4.5,0 --fov=60",
            "--eye=3,1.6,0 --target=-10,3,-3 --fov=55",
            "--eye=10,5,0 --target=-6,6,2 --fov=60",
        ],
    ),
    (
        "sibenik.glb",
        &["--point=0,8,0:120,115,100", "--no-scene-lights"],
        [
            "--eye=-14,4,0 --target=10,7,0 --fov=65",
            "--eye=6,2.5,1 --target=-12,6,0 --fov=60",
            "--eye=-6,5,0 --target=8,3,2 --fov=70",
        ],
    ),
];

const WISHES: [[&str; 2]; 4] =
    [["--budget", "200ms"], ["--budget", "1s"], ["--error", "12%"], ["--error", "6%"]];

/// What came of a choice.
struct Row {
    text: String,
    /// Measured over expected: time, error.
    ratios: [f64; 2],
    fits: bool,
}

/// Renders from each camera with each wish, and writes `docs/tradeoff/choices.md`.
pub fn run() -> Result<(), String> {
    let build = Command::new("cargo").args(["build", "--release"]).current_dir(root()).status();
    if !build.is_ok_and(|s| s.success()) {
        return Err("the release build failed".into());
    }
    let temporary = std::env::temp_dir().join(format!("twinlight-choices-{}", std::process::id()));
    std::fs::create_dir_all(&temporary).map_err(|e| e.to_string())?;
    let rows = all(&temporary);
    let _ = std::fs::remove_dir_all(&temporary);
    std::fs::write(root().join("docs/tradeoff/choices.md"), rows?).map_err(|e| e.to_string())
}

fn all(temporary: &Path) -> Result<String, String> {
    let folder = std::env::var_os("TWINLIGHT_SCENES").map_or_else(root, PathBuf::from);
    let mut rows = String::new();
    let (mut off, mut count) = ([0u32; 2], 0u32);
    for (scene, lights, cameras) in SUBJECTS {
        if scene.ends_with(".glb") && !folder.join(scene).is_file() {
            println!("== left out: {scene} is not in the folder TWINLIGHT_SCENES");
            continue;
        }
        for (number, camera) in cameras.iter().enumerate() {
            for wish in WISHES {
                let mut options: Vec<&str> = lights.to_vec();
                options.extend(camera.split_whitespace().chain(wish));
                let row = one(&folder, temporary, scene, &options)?;
                // What does not fit leaves out effects beside, of which nothing was promised.
                if number > 0 && row.fits {
                    count += 1;
                    for (off, ratio) in off.iter_mut().zip(row.ratios) {
                        *off += u32::from(!(0.75..=1.25).contains(&ratio));
                    }
                }
                let seen = if number == 0 { "the curves' own" } else { "another" };
                println!("{}", row.text);
                rows += &format!("| {scene} | {seen} | `{}` | {} |\n", wish.join(" "), row.text);
            }
        }
    }
    Ok(format!(
        "# Choices and what came of them\n\nWritten by `TWINLIGHT_SCENES=… cargo xtask choices`: 512 × 512, CPU backend. The curves of a scene are \
         measured from its first camera. Of {count} choices from other cameras that were expected to fit, time was more than 25 % off in {}, \
         error in {}.\n\n\
         | scene | camera | asked for | chosen | ms expected | measured | ratio | error expected | measured | ratio |\n\
         |---|---|---|---|---|---|---|---|---|---|\n{rows}",
        off[0], off[1]
    ))
}

fn one(folder: &Path, temporary: &Path, scene: &str, options: &[&str]) -> Result<Row, String> {
    let twinlight = root().join("target/release").join(format!("twinlight{}", std::env::consts::EXE_SUFFIX));
    let mut command = Command::new(twinlight);
    command.current_dir(folder).args(["render", scene, "--json"]).args(options);
    command.arg("-o").arg(temporary.join("a.exr")).env("TWINLIGHT_CACHE", temporary);
    let output = command.output().map_err(|e| format!("twinlight: cannot start: {e}"))?;
    let json: Value = serde_json::from_slice(&output.stdout)
        .map_err(|_| String::from_utf8_lossy(&output.stderr).into_owned())?;
    let choice = &json["choice"];
    let of = |key: &str| choice[key].as_f64().unwrap_or(f64::NAN);
    let ratios = ["seconds", "error"].map(|k| of(&format!("measured_{k}")) / of(&format!("expected_{k}")));
    let fits = choice["fits"] == true;
    let text = format!(
        "{} `{}`{} | {:.0} | {:.0} | {:.2} | {:.1} % | {:.1} % | {:.2}",
        json["technique"].as_str().unwrap_or_default(),
        choice["settings"].as_str().unwrap_or_default(),
        if fits { "" } else { ", the nearest" },
        1e3 * of("expected_seconds"),
        1e3 * of("measured_seconds"),
        ratios[0],
        100.0 * of("expected_error"),
        100.0 * of("measured_error"),
        ratios[1],
    );
    Ok(Row { text, ratios, fits })
}
