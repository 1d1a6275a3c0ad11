//! How far apart are two runs of the report?

use crate::report::scenes;
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::Path;

/// The scenes and points of a folder such as `docs/tradeoff/cpu`, by scene and by technique with settings.
type Points = BTreeMap<String, BTreeMap<String, Value>>;

/// Prints for each scene how many points both runs measured, how many errors differ, and the ratios of times.
pub fn run(one: &Path, other: &Path) -> Result<(), String> {
    print!("{}", table(&points(one)?, &points(other)?)?);
    Ok(())
}

fn points(folder: &Path) -> Result<Points, String> {
    let mut all = Points::new();
    for (_, scene) in scenes(folder)? {
        let own = all.entry(scene["name"].as_str().unwrap_or_default().to_owned()).or_default();
        for point in scene["points"].as_array().into_iter().flatten() {
            own.insert(format!("{} {}", point["technique"], point["settings"]), point.clone());
        }
    }
    Ok(all)
}

/// Whether two runs say the same of a point but for its times; 1e-12 is what a record loses that is written and read again.
fn alike(one: &Value, other: &Value) -> bool {
    let paths = ["indirect", "all"].map(|light| ["relative_rmse", "mean_ratio"].map(|of| (light, of)));
    let pairs = paths.iter().flatten().map(|&(light, of)| (&one[light][of], &other[light][of]));
    pairs.chain([(&one["flip"], &other["flip"])]).all(|(a, b)| match (a.as_f64(), b.as_f64()) {
        (Some(a), Some(b)) => (a - b).abs() <= 1e-12 * a.abs(),
        _ => a == b,
    })
}

fn table(one: &Points, other: &Points) -> Result<String, String> {
    let mut text = "| scene | points in both | errors that differ | time, other over one: median | 5 % | 95 % | least | most |\n\
                    |---|---|---|---|---|---|---|---|\n"
        .to_owned();
    let mut any = false;
    for (scene, points) in one {
        let Some(others) = other.get(scene) else { continue };
        let pairs: Vec<_> = points.iter().filter_map(|(key, p)| Some((p, others.get(key)?))).collect();
        let differ = pairs.iter().filter(|(p, q)| !alike(p, q)).count();
        let seconds = |p: &Value| p["seconds"]["median"].as_f64();
        let mut ratios: Vec<f64> =
            pairs.iter().filter_map(|(p, q)| Some(seconds(q)? / seconds(p)?)).collect();
        ratios.sort_by(f64::total_cmp);
        let Some(last) = ratios.len().checked_sub(1) else { continue };
        any = true;
        let at = |share: f64| ratios[(share * last as f64).round() as usize];
        text += &format!("| {scene} | {} | {differ} |", pairs.len());
        for share in [0.5, 0.05, 0.95, 0.0, 1.0] {
            text += &format!(" {:.2} |", at(share));
        }
        text += "\n";
    }
    if any { Ok(text) } else { Err("the two runs have no point in common".into()) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn what_differs_is_counted() {
        let point = |error: f64, seconds: f64| json!({"indirect": {"relative_rmse": error}, "seconds": {"median": seconds}});
        let run = |points: &[(&str, Value)]| {
            let own = points.iter().map(|(key, p)| ((*key).to_owned(), p.clone())).collect();
            Points::from([("box".to_owned(), own)])
        };
        let one = run(&[("a", point(0.1, 1.0)), ("b", point(0.2, 2.0)), ("c", point(0.3, 1.0))]);
        let same = run(&[("a", point(0.1, 2.0)), ("b", point(0.2, 2.0)), ("d", point(0.3, 1.0))]);
        assert!(table(&one, &same).unwrap().contains("| box | 2 | 0 | 2.00 | 1.00 | 2.00 | 1.00 | 2.00 |"));
        let other = run(&[("a", point(0.1, 1.0)), ("b", point(0.25, 2.0))]);
        assert!(table(&one, &other).unwrap().contains("| box | 2 | 1 | 1.00 |"));
        assert!(table(&one, &run(&[("d", point(0.1, 1.0))])).is_err());
    }
}
