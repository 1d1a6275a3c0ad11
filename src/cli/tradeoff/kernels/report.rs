//! How is the report shown, and in which files does it land?

use super::case::Row;
use crate::cli::Failure;
use crate::cli::table::csv_field;
use crate::picture::write_whole;
use serde_json::{Value, json};
use std::path::Path;

/// On which machine.
pub(super) struct Machine {
    pub processor: String,
    pub adapter: Option<String>,
    /// What the probe found out of it.
    pub probe: Option<Value>,
    pub notes: Vec<String>,
}

/// What a column is called: in files, and on screen.
const COLUMNS: [(&str, &str); 18] = [
    ("kernel", "kernel"),
    ("variant", "variant"),
    ("domain", "domain"),
    ("max_error", "max error"),
    ("mean_error", "mean error"),
    ("stated_error", "stated"),
    ("unit", "unit"),
    ("cpu_ns", "CPU ns"),
    ("cpu_strict_over_native", "strict/native"),
    ("gpu_strict_ns", "GPU strict ns"),
    ("gpu_fast_ns", "GPU fast ns"),
    ("gpu_strict_over_fast", "strict/fast"),
    ("gpu_fast_max_error", "GPU fast max"),
    ("gpu_fast_mean_error", "GPU fast mean"),
    ("gpu_items", "GPU items"),
    ("strict_gpu_equals_cpu", "equal bits"),
    ("within_stated", "within stated"),
    ("mismatch", "mismatch"),
];

/// The columns of tables for people: the rest says what went wrong, or is the same everywhere.
const SHOWN: [usize; 14] = [0, 1, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 15, 2];

fn values(row: &Row) -> [Value; 18] {
    let head = &row.head;
    let gpu = row.device.unwrap_or_default();
    let equal = gpu.compared.then(|| row.mismatch.is_none());
    let ratio = gpu.strict_ns.zip(gpu.fast_ns).map(|(strict, fast)| strict / fast);
    [
        json!(head.kernel),
        json!(head.variant),
        json!(head.domain),
        number(row.errors.max),
        number(row.errors.mean),
        json!(head.stated),
        json!(head.unit.name()),
        number(row.cpu_ns),
        json!(row.cost),
        json!(gpu.strict_ns),
        json!(gpu.fast_ns),
        json!(ratio),
        gpu.fast.map_or(Value::Null, |e| number(e.max)),
        gpu.fast.map_or(Value::Null, |e| number(e.mean)),
        row.device.map_or(Value::Null, |d| json!(d.items)),
        json!(equal),
        head.stated.map_or(Value::Null, |_| json!(row.within())),
        json!(row.mismatch),
    ]
}

/// A number as JSON can hold it.
fn number(x: f64) -> Value {
    if x.is_finite() { json!(x) } else { json!("infinite") }
}

/// A value for people: three digits.
fn cell(value: &Value) -> String {
    match value {
        Value::Null => "-".into(),
        Value::Bool(true) => "yes".into(),
        Value::Bool(false) => "NO".into(),
        Value::String(text) => text.clone(),
        other => digits(other.as_f64().unwrap_or(f64::NAN)),
    }
}

fn digits(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if !(0.01..1e5).contains(&a) => format!("{x:.2e}"),
        a => format!("{x:.*}", (2.0 - a.log10().floor()).clamp(0.0, 4.0) as usize),
    }
}

fn header(machine: &Machine) -> String {
    let adapter = machine.adapter.as_deref().unwrap_or("no GPU adapter");
    format!("{}; {adapter}", machine.processor)
}

/// The table for a terminal.
pub(super) fn text(machine: &Machine, rows: &[Row]) -> String {
    let mut lines = vec![SHOWN.map(|i| COLUMNS[i].1.to_owned())];
    for row in rows {
        let values = values(row);
        lines.push(SHOWN.map(|i| cell(&values[i])));
    }
    let widths: Vec<usize> = (0..SHOWN.len())
        .map(|i| lines.iter().map(|l| l[i].chars().count()).max().unwrap_or_default())
        .collect();
    let mut text = format!("{}\n", header(machine));
    for line in &lines {
        for (i, cell) in line.iter().enumerate() {
            let pad = " ".repeat(widths[i] - cell.chars().count());
            let left = SHOWN[i] < 3 || COLUMNS[SHOWN[i]].0 == "unit";
            text += &if left { format!("{cell}{pad}  ") } else { format!("{pad}{cell}  ") };
        }
        text.truncate(text.trim_end().len());
        text.push('\n');
    }
    for note in &machine.notes {
        text += &format!("{note}\n");
    }
    text
}

/// The whole report as one object.
pub(super) fn object(machine: &Machine, rows: &[Row]) -> Value {
    let rows: Vec<Value> = rows
        .iter()
        .map(|row| COLUMNS.iter().zip(values(row)).map(|((name, _), v)| ((*name).to_owned(), v)).collect())
        .collect();
    json!({ "processor": machine.processor, "adapter": machine.adapter, "probe": machine.probe, "notes": machine.notes, "rows": rows })
}

/// Comma-separated values; nothing for what was not measured.
fn csv(rows: &[Row]) -> String {
    let quoted = |v: &Value| match v {
        Value::Null => String::new(),
        Value::String(text) => csv_field(text),
        other => other.to_string(),
    };
    let mut text = COLUMNS.map(|c| c.0).join(",") + "\n";
    for row in rows {
        text += &(values(row).each_ref().map(quoted).join(",") + "\n");
    }
    text
}

const INTRODUCTION: &str = "Errors of each kernel against float64, and nanoseconds per call: on one thread of the CPU \
(loops over inputs that stay in the cache, which the compiler may turn into SIMD; the system's functions it cannot), and \
per item of a GPU pass over up to 2^20 items, memory traffic included. Rows named `native` are the standard library's \
functions; `strict/native` and `strict/fast` are what the same bits everywhere cost. ULP of sines below 2^-10 count as \
those of 2^-10. `equal bits`: whether the strict GPU results are the CPU's. Regenerate with";

/// The table for the documentation.
fn markdown(machine: &Machine, rows: &[Row]) -> String {
    let mut text = format!("# Kernels: accuracy and time\n\n{INTRODUCTION}\n\n");
    text += "```sh\ncargo run --release -- tradeoff --kernels -o DIR\n```\n\n";
    text += &format!("Measured on {}.\n\n", header(machine));
    let line = |cells: &[String]| format!("| {} |\n", cells.join(" | "));
    text += &line(&SHOWN.map(|i| COLUMNS[i].1.to_owned()));
    text += &line(&SHOWN.map(|_| "---".to_owned()));
    for row in rows {
        let values = values(row);
        text += &line(&SHOWN.map(|i| cell(&values[i]).replace('|', "\\|")));
    }
    for note in &machine.notes {
        text += &format!("\n{note}\n");
    }
    text
}

/// Makes the folder, if need be.
pub(super) fn prepare(folder: &Path) -> Result<(), Failure> {
    std::fs::create_dir_all(folder)
        .map_err(|e| Failure::Work(format!("cannot make {}: {e}", folder.display())))
}

/// Writes kernels.json, kernels.csv and kernels.md into the folder.
pub(super) fn write(folder: &Path, machine: &Machine, rows: &[Row]) -> Result<(), Failure> {
    let object = serde_json::to_string_pretty(&object(machine, rows)).unwrap_or_default() + "\n";
    for (name, text) in
        [("kernels.json", object), ("kernels.csv", csv(rows)), ("kernels.md", markdown(machine, rows))]
    {
        write_whole(&folder.join(name), text.as_bytes())?;
    }
    Ok(())
}
