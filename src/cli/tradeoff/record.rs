//! What is known of the trials so far, and how is it kept?
//!
//! `tradeoff.json` is whole after every trial: who is interrupted goes on from it.

use super::sweep::Trial;
use crate::cli::Failure;
use crate::cli::table::csv_field as field;
use crate::picture::write_whole;
use crate::report::halves::Errors;
use crate::report::pareto::pareto_front;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// A repeated measurement.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Spread {
    pub median: f64,
    pub least: f64,
    pub most: f64,
    pub repeats: usize,
}

impl Spread {
    /// Of values that were measured one after the other.
    pub(crate) fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        let at = |i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        let (half, repeats) = (values.len() / 2, values.len());
        let median = if repeats % 2 == 1 { at(half) } else { 0.5 * (at(half.wrapping_sub(1)) + at(half)) };
        Self { median, least: at(0), most: at(repeats.wrapping_sub(1)), repeats }
    }
}

/// A trial with what was measured.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point {
    pub id: usize,
    pub technique: String,
    pub knob: String,
    pub value: String,
    pub settings: String,
    pub command: String,
    /// Of all passes of a frame from nothing; of the path tracer, of all paths.
    pub seconds: Spread,
    /// The same by the clock on the wall.
    pub wall: f64,
    /// Of the passes of a frame after a change of the camera alone.
    pub camera: Option<f64>,
    /// Of the buffers that a frame makes.
    pub bytes: u64,
    pub indirect: Option<Errors>,
    pub all: Option<Errors>,
    /// Mean HDR-FLIP of the picture at its own pixels.
    pub flip: Option<f64>,
    /// The same of its indirect light alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub flip_indirect: Option<f64>,
    pub pareto: bool,
    /// The run, of those that made the report, that measured it: times of different runs compare less well.
    pub run: u32,
}

/// The reference of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Reference {
    pub samples: u32,
    pub bounces: String,
    pub seconds: f64,
    pub noise_indirect: f64,
    pub noise_all: f64,
}

/// What a stage costs in error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Attribution {
    pub technique: String,
    pub stage: String,
    /// What stands in its place.
    pub exact: String,
    pub settings: String,
    /// Of indirect light, with the stage as it is and with its exact counterpart.
    pub before: f64,
    pub relative_rmse: f64,
    /// Errors below this cannot be told from none.
    #[serde(default)]
    pub resolution: f64,
    pub mean_ratio: f64,
    /// Share of the squared error that goes, at least.
    pub share: Option<f64>,
}

/// All of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SceneRecord {
    pub name: String,
    pub view: String,
    pub credit: String,
    /// What the scene is made of, in short.
    #[serde(default)]
    pub fingerprint: String,
    pub size: (u32, u32),
    pub compared: (u32, u32),
    pub reference: Option<Reference>,
    /// Which light the front is about.
    pub axis: String,
    pub points: Vec<Point>,
    pub attribution: Vec<Attribution>,
}

/// The report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Record {
    pub command: String,
    pub version: String,
    pub machine: String,
    /// What the probe found out of the GPU, as `twinlight devices --json` prints it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub probe: Option<serde_json::Value>,
    /// How often it was begun or taken up again.
    pub runs: u32,
    pub scenes: Vec<SceneRecord>,
}

impl SceneRecord {
    /// The error that the front is about, as far as it can be told.
    pub(crate) fn error(&self, p: &Point) -> Option<f64> {
        let errors = if self.axis == "all" { p.all } else { p.indirect };
        errors.map(|e| e.told())
    }

    /// Whether this trial is measured already.
    pub(crate) fn has(&self, trial: &Trial) -> bool {
        self.points.iter().any(|p| p.technique == trial.technique && p.settings == trial.settings())
    }

    /// Marks the points that no other beats in time and error: among techniques, without the path tracer.
    pub(crate) fn mark_front(&mut self) {
        let place = |p: &Point| match self.error(p) {
            Some(error) if p.technique != "reference" => (p.seconds.median, error),
            _ => (f64::NAN, f64::NAN),
        };
        let places: Vec<_> = self.points.iter().map(place).collect();
        for (point, front) in self.points.iter_mut().zip(pareto_front(&places)) {
            point.pareto = front;
        }
    }
}

impl Record {
    /// Reads an earlier run's record; `None` where there is none.
    pub(crate) fn open(path: &Path) -> Result<Option<Self>, Failure> {
        let bytes = match std::fs::read(path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(Failure::Work(format!("cannot read {}: {e}", path.display()))),
        };
        serde_json::from_slice(&bytes).map(Some).map_err(|e| {
            Failure::Request(format!(
                "{} is no report of this version ({e}); give --restart or another folder",
                path.display()
            ))
        })
    }

    /// Whether `other` asks for the same.
    pub(crate) fn same_request(&self, other: &Self) -> bool {
        let of = |r: &Self| {
            let of =
                |s: &SceneRecord| (s.name.clone(), s.view.clone(), s.size, s.compared, s.fingerprint.clone());
            let scenes = r.scenes.iter().map(of);
            (r.command.clone(), r.version.clone(), r.machine.clone(), scenes.collect::<Vec<_>>())
        };
        of(self) == of(other)
    }

    /// Writes it, whole.
    pub(crate) fn save(&self, path: &Path) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(self).map_err(|e| Failure::Work(e.to_string()))?;
        Ok(write_whole(path, format!("{text}\n").as_bytes())?)
    }

    /// The fronts, as a table.
    pub(crate) fn summary(&self, path: &Path) -> String {
        let mut text = String::new();
        for scene in &self.scenes {
            text += &format!("{}: what no other setting beats, {} light\n", scene.name, scene.axis);
            text += &format!("{:<18} {:>10} {:>8} {:>7}  settings\n", "technique", "ms", "RMSE", "ratio");
            let mut front: Vec<_> = scene.points.iter().filter(|p| p.pareto).collect();
            front.sort_by(|a, b| a.seconds.median.total_cmp(&b.seconds.median));
            for p in front {
                let errors = if scene.axis == "all" { p.all } else { p.indirect };
                let Some(e) = errors else { continue };
                text += &format!(
                    "{:<18} {:>10.1} {:>6} % {:>7.3}  {}\n",
                    p.technique,
                    1e3 * p.seconds.median,
                    format!("{}{:.1}", e.below(), 100.0 * e.told()),
                    e.mean_ratio,
                    p.settings
                );
            }
        }
        for scene in self.scenes.iter().filter(|s| !s.attribution.is_empty()) {
            text += &format!("{}: a stage at a time by its exact counterpart\n", scene.name);
            text += &format!(
                "{:<18} {:<24} {:>8} {:>8} {:>7}  instead\n",
                "technique", "stage", "before", "RMSE", "share"
            );
            for a in &scene.attribution {
                text += &format!(
                    "{:<18} {:<24} {:>6.1} % {:>6.1} % {:>5.0} %  {}\n",
                    a.technique,
                    a.stage,
                    100.0 * a.before,
                    100.0 * a.relative_rmse.max(a.resolution),
                    100.0 * a.share.unwrap_or(f64::NAN),
                    a.exact
                );
            }
        }
        text + &format!("wrote {}\n", path.join("index.html").display())
    }

    /// A line for each point.
    pub(crate) fn csv(&self) -> String {
        let mut text = "scene,technique,knob,value,settings,seconds,least,most,repeats,wall,camera,bytes,\
            indirect_rmse,indirect_ratio,indirect_p50,indirect_p99,indirect_max,all_rmse,all_ratio,all_p50,\
            all_p99,all_max,flip,flip_indirect,pareto,run\n"
            .to_owned();
        for s in &self.scenes {
            for p in &s.points {
                let t = &p.seconds;
                text += &format!(
                    "{},{},{},{},{},{:.6},{:.6},{:.6},{},{:.6},{},{}",
                    field(&s.name),
                    p.technique,
                    p.knob,
                    field(&p.value),
                    field(&p.settings),
                    t.median,
                    t.least,
                    t.most,
                    t.repeats,
                    p.wall,
                    p.camera.map_or_else(String::new, |x| format!("{x:.6}")),
                    p.bytes
                );
                for errors in [p.indirect, p.all] {
                    text += &match errors {
                        Some(e) => format!(
                            ",{:.6},{:.6},{:.6},{:.6},{:.6}",
                            e.relative_rmse, e.mean_ratio, e.p50, e.p99, e.max
                        ),
                        None => ",,,,,".to_owned(),
                    };
                }
                for flip in [p.flip, p.flip_indirect] {
                    text += &flip.map_or_else(|| ",".to_owned(), |x| format!(",{x:.6}"));
                }
                text += &format!(",{},{}\n", p.pareto, p.run);
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spreads_have_medians() {
        assert_eq!(
            Spread::of(vec![3.0, 1.0, 2.0]),
            Spread { median: 2.0, least: 1.0, most: 3.0, repeats: 3 }
        );
        assert_eq!(Spread::of(vec![4.0, 1.0, 2.0, 3.0]).median, 2.5);
        assert!(Spread::of(Vec::new()).median.is_nan());
    }
}
