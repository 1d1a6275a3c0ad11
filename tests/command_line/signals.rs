//! Interrupted commands, and readers that go away.

use crate::{command, listing};
use std::io::Read;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use twinlight::picture::Picture;

/// Interrupts a command as Ctrl-C does, and returns its code and standard error.
fn interrupt(mut child: Child) -> (Option<i32>, String) {
    let sent = Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(sent.success());
    let start = Instant::now();
    let mut status = None;
    while status.is_none() {
        if start.elapsed() > Duration::from_secs(20) {
            // It must not outlive the test.
            let _ = child.kill();
            panic!("still running 20 s after the interruption; are interruptions ignored here, as by nohup?");
        }
        std::thread::sleep(Duration::from_millis(10));
        status = child.try_wait().unwrap();
    }
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    (status.and_then(|s| s.code()), err)
}

/// Waits until a process catches SIGINT: on a busy machine it may take its time to start.
fn wait_for_handler(process: u32) {
    let catches = || {
        let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
        let mask = status.lines().find_map(|l| l.strip_prefix("SigCgt:"))?.trim().to_owned();
        // Signal 2 is bit 1.
        Some(u64::from_str_radix(&mask, 16).ok()? & 2 != 0)
    };
    let start = Instant::now();
    while catches() != Some(true) && start.elapsed() < Duration::from_secs(10) {
        std::thread::sleep(Duration::from_millis(20));
        if !Path::new("/proc/self/status").exists() {
            return std::thread::sleep(Duration::from_millis(1500));
        }
    }
}

#[cfg(unix)]
#[test]
fn an_interrupted_reference_keeps_what_was_done() {
    let folder = tempfile::tempdir().unwrap();
    let start = |size: &str, samples: &str, lights: usize| {
        let base = ["render", "cornell-box", "--technique", "reference", "--bounces", "all", "-o", "a.exr"];
        let mut command = command(folder.path(), &base);
        command.args(["--size", size, "--samples", samples]).stdout(Stdio::null()).stderr(Stdio::piped());
        for _ in 0..lights {
            command.args(["--point", "0.1,1.7,0.1:1,1,1"]);
        }
        let child = command.spawn().unwrap();
        wait_for_handler(child.id());
        std::thread::sleep(Duration::from_millis(500));
        child
    };
    // So many shadow rays that the first paths take minutes.
    let (code, err) = interrupt(start("1024x1024", "8", 100));
    assert_eq!(code, Some(1), "{err}");
    assert!(
        err.lines().any(|l| l.starts_with("error: interrupted") && l.contains("nothing was written")),
        "{err}"
    );
    assert!(listing(folder.path()).is_empty());

    let (code, err) = interrupt(start("32x24", "16000000", 0));
    assert_eq!(code, Some(1), "{err}");
    assert!(err.lines().any(|l| l.starts_with("error: interrupted") && l.contains("a.exr")), "{err}");
    let picture = Picture::open_exr(&folder.path().join("a.exr")).unwrap();
    assert_eq!((picture.width, picture.height), (32, 24));
    assert!(picture.mean().min_element() > 0.01 && picture.mean().is_finite());
    assert_eq!(listing(folder.path()).len(), 1);
}

#[cfg(unix)]
#[test]
fn an_interrupted_technique_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["render", "cornell-box", "--technique", "ambient-occlusion", "--size", "2000x2000"];
    let mut command = command(folder.path(), &arguments);
    let child =
        command.args(["--samples", "10000"]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(500));
    let (code, err) = interrupt(child);
    assert_ne!(code, Some(0), "{err}");
    assert!(!err.contains("panicked") && listing(folder.path()).is_empty(), "{err}");
}

#[cfg(unix)]
#[test]
fn an_interrupted_report_goes_on_later() {
    let folder = tempfile::tempdir().unwrap();
    let base =
        ["tradeoff", "spheres", "--size", "64x48", "--techniques", "soft-gi", "--samples", "16", "-o", "out"];
    let mut first = command(folder.path(), &[&base[..], &["--repeats", "200"]].concat());
    let child = first.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let record = folder.path().join("out/tradeoff.json");
    let read = || serde_json::from_slice::<serde_json::Value>(&std::fs::read(&record).ok()?).ok();
    let points = || read().map_or(0, |r| r["scenes"][0]["points"].as_array().map_or(0, Vec::len));
    let start = Instant::now();
    while points() < 2 && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let (code, err) = interrupt(child);
    assert_eq!(code, Some(1), "{err}");
    assert!(err.lines().any(|l| l.starts_with("error: interrupted") && l.contains("goes on")), "{err}");
    let done = points();
    assert!(done >= 2 && folder.path().join("out/index.html").is_file(), "{done}");
    let kept = read().unwrap()["scenes"][0]["points"][0].clone();
    // Another number of repeats is another request; the same one goes on.
    let other = crate::run(folder.path(), &base);
    assert_eq!(other.code, Some(2), "{}", other.err);
    crate::succeed(folder.path(), &[&base[..], &["--repeats", "200", "--time-limit", "0.001s"]].concat());
    let after = read().unwrap();
    assert_eq!((points(), &after["scenes"][0]["points"][0], &after["runs"]), (done, &kept, &2.into()));
}

#[test]
fn a_reader_that_went_away_is_no_failure() {
    let folder = tempfile::tempdir().unwrap();
    let commands: [&[&str]; 4] = [
        &["render", "cornell-box", "--size", "16x16"],
        &["render", "cornell-box", "--size", "16x16", "--json"],
        &["devices"],
        &["--help"],
    ];
    for arguments in commands {
        let mut child =
            command(folder.path(), arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        let err = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(0), "{arguments:?}: {err}");
        assert!(!err.contains("panicked"), "{arguments:?}: {err}");
    }
    assert_eq!(listing(folder.path()).len(), 1, "the picture is written all the same");
}
