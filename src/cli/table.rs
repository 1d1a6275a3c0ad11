//! How are results shown to people and to scripts?

use serde_json::{Value, json};
use twinlight_kernels::passes::PassTiming;

/// One line of the table of passes: all runs of one pass.
struct Row {
    pass: &'static str,
    runs: u32,
    items: u64,
    milliseconds: f64,
    bytes: u64,
}

fn rows(timings: &[PassTiming]) -> Vec<Row> {
    let mut rows: Vec<Row> = Vec::new();
    for t in timings {
        let at = rows.iter().position(|r| r.pass == t.pass).unwrap_or_else(|| {
            rows.push(Row { pass: t.pass, runs: 0, items: 0, milliseconds: 0.0, bytes: 0 });
            rows.len() - 1
        });
        rows[at].runs += 1;
        rows[at].items += u64::from(t.items);
        rows[at].milliseconds += t.nanoseconds * 1e-6;
        rows[at].bytes = rows[at].bytes.max(t.bytes);
    }
    rows
}

/// The table of passes: pass, runs, items, milliseconds, bytes bound.
pub(crate) fn passes_text(timings: &[PassTiming]) -> String {
    let rows = rows(timings);
    let mut text = format!("{:<20} {:>5} {:>12} {:>10} {:>14}\n", "pass", "runs", "items", "ms", "bytes");
    let milliseconds = |ms: f64| if ms.is_nan() { "-".to_owned() } else { format!("{ms:.3}") };
    for r in &rows {
        text += &format!(
            "{:<20} {:>5} {:>12} {:>10} {:>14}\n",
            r.pass,
            r.runs,
            r.items,
            milliseconds(r.milliseconds),
            r.bytes
        );
    }
    let total: f64 = rows.iter().map(|r| r.milliseconds).sum();
    text += &format!("{:<20} {:>5} {:>12} {:>10}\n", "all", "", "", milliseconds(total));
    text
}

/// The table of passes as JSON.
pub(crate) fn passes_json(timings: &[PassTiming]) -> Value {
    rows(timings)
        .iter()
        .map(|r| {
            let ms = if r.milliseconds.is_nan() { Value::Null } else { json!(r.milliseconds) };
            json!({ "pass": r.pass, "runs": r.runs, "items": r.items, "ms": ms, "bytes": r.bytes })
        })
        .collect()
}
