//! Does the report hold every kernel, and does it see a wrong one?

use super::case::{Head, NATIVE, Row, Unit};
use super::device::Devices;
use super::elementary::{Function, functions};
use super::listed::{EXCLUDED, ROWS};
use super::report::{self, Machine};
use super::truth::{self, Algebra};
use super::{Settings, cases, check, measure, run};
use crate::cli::Failure;
use crate::cli::options::{ArithmeticChoice, BackendOptions};
use crate::technique::soft_gi::logarithm;
use std::collections::BTreeSet;
use std::path::Path;
use twinlight_kernels::math;
use twinlight_kernels::passes::elementary::function;

fn small() -> Settings {
    Settings {
        numbers: 2048,
        vectors: 64,
        sets: 16,
        batches: 1,
        batch_ns: 0.0,
        gpu_items: 4096,
        gpu_run_ns: 0.0,
        gpu_runs: 1,
    }
}

fn exp(kernel: fn(f32) -> f32) -> Function {
    let head = Head::strict("exp", "-10 to 10", Unit::Ulp).stated(0.96);
    Function::one(head, function::EXP, |r| (r.range(-10.0, 10.0), 0.0), |x, _| x.exp(), kernel)
}

/// e^x with its second coefficient off by a 256th.
fn wrong_exp(x: f32) -> f32 {
    let n = (x * std::f32::consts::LOG2_E).round();
    let r = f64::from(x) - f64::from(n) * std::f64::consts::LN_2;
    let q = [1.0, 1.0, 0.5 + 1.0 / 512.0, 1.0 / 6.0, 1.0 / 24.0, 1.0 / 120.0, 1.0 / 720.0, 1.0 / 5040.0];
    (q.iter().rev().fold(0.0, |sum, c| sum * r + c) * f64::from(n).exp2()) as f32
}

fn rows_of(function: Function, devices: &mut Devices) -> Vec<Row> {
    let settings = small();
    match measure(&[function.case(&settings)], &settings, devices, true) {
        Ok(rows) => rows,
        Err(Failure::Work(e) | Failure::Request(e)) => panic!("{e}"),
    }
}

#[test]
fn every_elementary_function_is_there() {
    let mut ids: Vec<u32> = functions().iter().map(|f| f.id).collect();
    ids.sort_unstable();
    ids.dedup();
    // What follows are probes of plain arithmetic.
    assert_eq!(ids, (function::EXP2..=function::FLOOR).collect::<Vec<_>>());
}

#[test]
fn a_wrong_kernel_is_above_its_bound() {
    let mut none = Devices::default();
    let right = rows_of(exp(math::exp), &mut none);
    assert!(right[0].within() && right[0].errors.max > 0.3 && check(&right).is_ok());
    let wrong = rows_of(exp(wrong_exp), &mut none);
    assert!(!wrong[0].within() && wrong[0].errors.max > 100.0, "{:?}", wrong[0].errors);
    assert!(wrong[0].errors.mean < wrong[0].errors.max);
    assert!(matches!(check(&wrong), Err(Failure::Work(e)) if e.starts_with("exp (strict, -10 to 10): ")));
}

#[test]
fn a_gpu_with_other_bits_is_a_failure() {
    let mut devices = Devices::open(None).ok().unwrap_or_default();
    if devices.strict(false).is_none() {
        assert!(std::env::var_os("TWINLIGHT_REQUIRE_GPU").is_none(), "{:?}", devices.notes);
        eprintln!("SKIPPED: {}; `cargo xtask test` gets a software driver", devices.notes.join(" "));
        return;
    }
    let right = rows_of(exp(math::exp), &mut devices);
    let device = right[0].device.unwrap();
    assert!(device.compared && device.fast.is_some() && check(&right).is_ok());
    let wrong = rows_of(exp(wrong_exp), &mut devices);
    assert!(wrong[0].mismatch.as_ref().unwrap().contains("the CPU gives"));
    assert!(matches!(check(&wrong), Err(Failure::Work(e)) if e.contains("strict results differ at")));
}

/// The errors in the table of the documentation, by function.
fn documented(name: &str) -> f64 {
    let text = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/docs/numerics.md")).unwrap();
    let table = text.split("## Elementary functions").nth(1).unwrap();
    let cells: Vec<&str> = table.split(['|', '\n']).map(str::trim).collect();
    let at = cells.iter().position(|c| c.split([',', '(']).any(|n| n.trim() == format!("`{name}`"))).unwrap();
    cells[at + 1].split(' ').next().unwrap().parse().unwrap()
}

#[test]
fn strict_kernels_stay_within_what_is_documented() {
    let settings = small();
    let Ok(rows) = measure(&cases(&settings), &settings, &mut Devices::default(), true) else { panic!() };
    assert!(rows.len() > 350 && check(&rows).is_ok(), "{}", rows.len());
    assert!(rows.iter().all(|r| r.errors.max.is_finite() && r.cpu_ns > 0.0 && r.device.is_none()));
    assert!(rows.iter().filter(|r| r.cost.is_some()).count() >= 70);
    for f in functions().into_iter().filter(|f| !matches!(f.id, function::POW_FAST | function::FLOOR)) {
        let name = match f.id {
            function::SIN_TURN | function::COS_TURN => "sin_cos_turn",
            function::SIN | function::COS => "sin_cos",
            _ => f.head.kernel,
        };
        let (ours, theirs) = (f.head.stated.unwrap(), documented(name));
        assert!((ours - theirs).abs() <= 0.02, "{name}: {ours} here, {theirs} in docs/numerics.md");
    }
    // Nearer to the truth with more terms, more halvings, more entries.
    let mean = |variant: &str| rows.iter().find(|r| r.head.variant == variant).unwrap().errors.mean;
    for pair in [
        ["order 3, series, 9 terms", "order 3, series, 3 terms"],
        ["order 4, hybrid, τ 0.125", "order 4, hybrid, τ 0.5"],
        ["order 4, Taylor, τ 0.5", "order 4, Taylor, τ 1"],
        ["order 4, 256 entries", "order 4, 16 entries"],
        ["exact, 128 entries", "exact, 16 entries"],
        ["exact, 16 entries", "averaged"],
    ] {
        assert!(mean(pair[0]) < 0.5 * mean(pair[1]), "{pair:?}");
    }
}

/// The names after `pub fn` in a folder's files, with the files; those that macros make are of other functions.
fn public_functions(folder: &Path, root: &Path, found: &mut BTreeSet<(String, String)>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            public_functions(&path, root, found);
            continue;
        }
        let file = path.strip_prefix(root).unwrap().to_str().unwrap().replace('\\', "/");
        let text = std::fs::read_to_string(&path).unwrap();
        for rest in text.lines().filter_map(|l| l.trim_start().strip_prefix("pub ")) {
            let rest = ["const ", "unsafe "].iter().fold(rest, |r, word| r.strip_prefix(word).unwrap_or(r));
            if let Some(rest) = rest.strip_prefix("fn ") {
                let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap();
                found.extend((!name.is_empty()).then(|| (file.clone(), name.to_owned())));
            }
        }
    }
}

#[test]
fn every_kernel_has_a_row_or_a_reason() {
    // The scan sees a new kernel.
    let (folder, mut planted) = (tempfile::tempdir().unwrap(), BTreeSet::new());
    let text = "fn a() {}\n    pub const fn planted<const N: usize>() {}\n    pub fn $name() {}\n";
    std::fs::write(folder.path().join("new.rs"), text).unwrap();
    public_functions(folder.path(), folder.path(), &mut planted);
    assert_eq!(planted.into_iter().collect::<Vec<_>>(), [("new.rs".to_owned(), "planted".to_owned())]);
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/kernels/src"));
    let mut found = BTreeSet::new();
    for folder in ["cone", "gaussian", "geometry", "math", "sampling", "sh"] {
        public_functions(&root.join(folder), root, &mut found);
    }
    assert!(found.len() > 150, "{} functions", found.len());
    let rows: BTreeSet<&str> = cases(&small()).iter().map(|case| case.head().kernel).collect();
    let mut listed = BTreeSet::new();
    for (file, functions) in ROWS {
        for (name, row) in *functions {
            assert!(rows.contains(row), "no row \"{row}\" for {file} {name}");
            assert!(listed.insert(((*file).to_owned(), (*name).to_owned())), "{file} {name} twice");
        }
    }
    for (file, functions, reason) in EXCLUDED {
        assert!(!reason.is_empty());
        for name in *functions {
            assert!(listed.insert(((*file).to_owned(), (*name).to_owned())), "{file} {name} twice");
        }
    }
    let missing: Vec<_> = found.difference(&listed).collect();
    let gone: Vec<_> = listed.difference(&found).collect();
    assert!(
        missing.is_empty() && gone.is_empty(),
        "not in listed.rs: {missing:?}; no longer there: {gone:?}"
    );
}

#[test]
fn files_hold_every_row() {
    let folder = tempfile::tempdir().unwrap();
    let rows = rows_of(exp(math::exp).other(NATIVE, |x, _| x.exp()), &mut Devices::default());
    let machine =
        Machine { processor: "a processor".into(), adapter: None, probe: None, notes: vec!["a note".into()] };
    assert!(report::prepare(&folder.path().join("made")).is_ok());
    assert!(report::write(&folder.path().join("made"), &machine, &rows).is_ok());
    let read = |name: &str| std::fs::read_to_string(folder.path().join("made").join(name)).unwrap();
    let json: serde_json::Value = serde_json::from_str(&read("kernels.json")).unwrap();
    let listed = json["rows"].as_array().unwrap();
    assert_eq!((listed.len(), &listed[1]["variant"]), (2, &"native".into()));
    assert!(listed[0]["max_error"].as_f64().unwrap() > 0.3 && listed[0]["gpu_fast_ns"].is_null());
    assert!(listed[0]["cpu_strict_over_native"].as_f64().unwrap() > 0.0);
    let csv = read("kernels.csv");
    assert_eq!(csv.lines().count(), 3);
    assert!(csv.starts_with("kernel,variant,domain,max_error"), "{csv}");
    let columns = csv.lines().map(|l| l.split(',').count()).collect::<Vec<_>>();
    assert!(columns.iter().all(|n| *n == columns[0]), "{columns:?}");
    let markdown = read("kernels.md");
    assert!(markdown.contains("Measured on a processor; no GPU adapter.") && markdown.contains("a note"));
    assert_eq!(markdown.lines().filter(|l| l.starts_with("| exp |")).count(), 2);
    assert_eq!(std::fs::read_dir(folder.path().join("made")).unwrap().count(), 3);
    let text = report::text(&machine, &rows);
    assert!(
        text.lines().filter(|l| l.starts_with("exp ")).count() == 2 && text.ends_with("a note\n"),
        "{text}"
    );
}

#[test]
fn options_that_do_nothing_are_refused() {
    for (arithmetic, threads) in [(Some(ArithmeticChoice::Fast), None), (None, Some(2))] {
        let backend = BackendOptions { adapter: None, arithmetic, threads };
        assert!(matches!(run(&backend, None, true, true), Err(Failure::Request(_))));
    }
    let backend = BackendOptions { adapter: Some("no such adapter".into()), arithmetic: None, threads: None };
    assert!(
        matches!(run(&backend, None, true, true), Err(Failure::Work(e)) if e.contains("no such adapter"))
    );
}

#[test]
fn truths_are_true() {
    assert!((truth::erf(1.0) - 0.842_700_792_949_714_9).abs() < 1e-15);
    assert!((truth::erf(-3.0) + 0.999_977_909_503_001_4).abs() < 1e-15);
    assert_eq!(truth::sin_cos_turn(-0.75), (1.0, 0.0));
    assert_eq!(truth::ulp(1.0 + f32::EPSILON, 1.0, 0.0), 1.0);
    assert!((truth::clamped_cosine(1) - (std::f64::consts::PI / 3.0).sqrt()).abs() < 1e-14);
    // Of a far sphere the mean cosine over the half that is seen is 2/3, of one that touches all of it is one point.
    for (alpha, cosine) in [(1e-9, 2.0 / 3.0), (1.0, 1.0)] {
        let band = (0.75 / std::f64::consts::PI).sqrt();
        assert!((truth::averaged_operator(alpha)[1] + cosine * band).abs() < 1e-8, "{alpha}");
    }
    // A sphere of radiance 1 is a cap.
    let mut even = [0.0; 9];
    even[0] = truth::unit();
    let sent = truth::sent(0.5, &even);
    assert!([0, 2, 6].iter().enumerate().all(|(l, i)| (sent[*i] - truth::cap(l, 0.5)).abs() < 1e-12));
    for order in 2..=5 {
        let algebra = Algebra::new(order);
        let mut one = vec![0.0; order * order];
        one[0] = truth::unit();
        let some: Vec<f64> = (0..order * order).map(|i| (i as f64 * 0.7).sin()).collect();
        let same = algebra.product(&one, &some);
        assert!(same.iter().zip(&some).all(|(a, b)| (a - b).abs() < 1e-13));
        // Of a small cap the exponential of the logarithm is the visibility; the logarithm is other code's.
        let (u, alpha) = (1.0 - 0.96f64.sqrt(), 0.2);
        let mut log = vec![0.0; order * order];
        logarithm(order, u).iter().enumerate().for_each(|(l, c)| log[l * l + l] = *c);
        let visible = algebra.exponential(&log);
        for l in 0..order {
            let want = if l == 0 { truth::unit() } else { 0.0 } - truth::cap(l, alpha);
            assert!((visible[l * l + l] - want).abs() < 1e-4, "order {order}, band {l}");
        }
    }
}
