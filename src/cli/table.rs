//! How are results shown to people and to scripts?

use serde_json::{Value, json};
use twinlight_kernels::passes::PassTiming;

/// One line of the table of passes: all runs of one pass.
struct Row {
    stage: &'static str,
    pass: &'static str,
    runs: u32,
    items: u64,
    milliseconds: f64,
    bytes: u64,
}

fn rows(timings: &[PassTiming]) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for t in timings {
        let at = rows.iter().position(|r| (r.stage, r.pass) == (t.stage, t.pass)).unwrap_or_else(|| {
            rows.push(Row { stage: t.stage, pass: t.pass, runs: 0, items: 0, milliseconds: 0.0, bytes: 0 });
            rows.len() - 1
        });
        rows[at].runs += 1;
        rows[at].items += u64::from(t.items);
        rows[at].milliseconds += t.nanoseconds * 1e-6;
        rows[at].bytes = rows[at].bytes.max(t.bytes);
    }
    rows
}

/// Milliseconds of each stage, in order of appearance; passes outside of any count to none.
fn stages(timings: &[PassTiming]) -> Vec<(&'static str, f64)> {
    let mut stages: Vec<(&'static str, f64)> = Vec::new();
    for t in timings.iter().filter(|t| !t.stage.is_empty()) {
        let at = stages.iter().position(|s| s.0 == t.stage).unwrap_or_else(|| {
            stages.push((t.stage, 0.0));
            stages.len() - 1
        });
        stages[at].1 += t.nanoseconds * 1e-6;
    }
    stages
}

/// Milliseconds of each stage as JSON.
pub(crate) fn stages_json(timings: &[PassTiming]) -> Value {
    let ms = |ms: f64| if ms.is_nan() { Value::Null } else { json!(ms) };
    stages(timings).iter().map(|(stage, time)| json!({ "stage": stage, "ms": ms(*time) })).collect()
}

/// The table of passes: pass, runs, items, milliseconds, bytes bound; with a line of its own before each stage.
pub(crate) fn passes_text(timings: &[PassTiming]) -> String {
    let rows = rows(timings);
    let stages = stages(timings);
    let mut text = format!("{:<24} {:>5} {:>12} {:>10} {:>14}\n", "pass", "runs", "items", "ms", "bytes");
    let milliseconds = |ms: f64| if ms.is_nan() { "-".to_owned() } else { format!("{ms:.3}") };
    let mut stage = "";
    for r in &rows {
        if r.stage != stage {
            stage = r.stage;
            let time = stages.iter().find(|s| s.0 == stage).map_or(0.0, |s| s.1);
            text += &format!("{stage:<24} {:>5} {:>12} {:>10}\n", "", "", milliseconds(time));
        }
        text += &format!(
            "{:<24} {:>5} {:>12} {:>10} {:>14}\n",
            format!("{}{}", if r.stage.is_empty() { "" } else { "  " }, r.pass),
            r.runs,
            r.items,
            milliseconds(r.milliseconds),
            r.bytes
        );
    }
    let total: f64 = rows.iter().map(|r| r.milliseconds).sum();
    text += &format!("{:<24} {:>5} {:>12} {:>10}\n", "all", "", "", milliseconds(total));
    text
}

/// The table of passes as JSON.
pub(crate) fn passes_json(timings: &[PassTiming]) -> Value {
    rows(timings)
        .iter()
        .map(|r| {
            let ms = if r.milliseconds.is_nan() { Value::Null } else { json!(r.milliseconds) };
            json!({ "stage": r.stage, "pass": r.pass, "runs": r.runs, "items": r.items, "ms": ms, "bytes": r.bytes })
        })
        .collect()
}

/// A field of a table of commas.
pub(crate) fn csv_field(text: &str) -> String {
    if text.contains([',', '"', '\n']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.to_owned()
    }
}
