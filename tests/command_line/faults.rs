//! What is left when the disk is full, memory runs out, or the command is killed while it writes? Limits of the shell stand in for each.
#![cfg(target_os = "linux")]

use crate::{Ran, command, finish, listing};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use twinlight::picture::Picture;

/// Runs the command under what a shell sets up first.
fn limited(folder: &Path, limits: &str, arguments: &[&str]) -> Ran {
    let own = command(folder, &[]);
    let mut shell = Command::new("sh");
    shell.args(["-c", &format!("{limits}; exec \"$0\" \"$@\"")]).arg(own.get_program()).args(arguments);
    shell.current_dir(folder).stdin(Stdio::null()).env("XDG_RUNTIME_DIR", std::env::temp_dir());
    finish(shell)
}

/// One line, code 1, nothing new in the folder.
fn fails(folder: &Path, limits: &str, arguments: &[&str], words: &[&str]) {
    let before = listing(folder);
    let ran = limited(folder, limits, arguments);
    assert_eq!((ran.code, ran.errors().len()), (Some(1), 1), "{arguments:?} with {limits}: {}", ran.err);
    for word in words {
        assert!(ran.errors()[0].contains(word), "{word:?} is not in {}", ran.err);
    }
    assert!(!ran.err.contains("stack backtrace"), "{}", ran.err);
    let after = listing(folder);
    assert!(after == before, "{arguments:?} with {limits} left {:?}", after.keys());
}

const RENDER: [&str; 6] = ["render", "cornell-box", "--technique", "direct", "--size", "256x256"];

#[test]
fn a_full_disk_leaves_what_was_there() {
    let folder = tempfile::tempdir().unwrap();
    // Files of at most 8 blocks of 512 bytes; the signal is ignored, so that writing fails as on a full disk.
    let full = "trap '' XFSZ; ulimit -f 8";
    std::fs::write(folder.path().join("old.exr"), b"old").unwrap();
    for output in ["new.png", "new.exr", "old.exr"] {
        fails(folder.path(), full, &[&RENDER[..], &["-o", output]].concat(), &[output, "space"]);
    }
    let dumps = [&RENDER[..], &["-o", "a.exr", "--dump", "albedo,normal"]].concat();
    fails(folder.path(), full, &dumps, &["space"]);
    let frames = [&RENDER[..], &["--frames", "0..2", "-o", "a%d.exr"]].concat();
    fails(folder.path(), full, &frames, &["space"]);
    let reference = ["render", "cornell-box", "--technique", "reference", "--samples", "1", "-o", "a.exr"];
    fails(folder.path(), full, &reference, &["space"]);
    // Negative control: without the limit it is written.
    let ran = limited(folder.path(), "true", &[&RENDER[..], &["-o", "old.exr"]].concat());
    assert_eq!(ran.code, Some(0), "{}", ran.err);
    assert!(Picture::open_exr(&folder.path().join("old.exr")).is_ok());
}

#[test]
fn without_memory_there_is_one_line() {
    let folder = tempfile::tempdir().unwrap();
    // A picture that needs gigabytes, in half a gigabyte of addresses.
    let large = ["render", "cornell-box", "--technique", "direct", "--size", "8192x8192", "--threads", "2"];
    fails(folder.path(), "ulimit -v 500000", &large, &["memory", "smaller"]);
    let voxels = [
        "render",
        "cornell-box",
        "--technique",
        "visibility-filter",
        "--proxies",
        "4194304",
        "--threads",
        "2",
    ];
    fails(folder.path(), "ulimit -v 500000", &voxels, &["memory", "smaller"]);
}

#[test]
fn without_device_memory_there_is_one_line() {
    // Only of a software device the memory is that of the process.
    let adapters = twinlight_gpu::adapters();
    let soft =
        |a: &twinlight_gpu::wgpu::Adapter| a.get_info().device_type == twinlight_gpu::wgpu::DeviceType::Cpu;
    if adapters.is_empty() || !adapters.iter().all(soft) {
        eprintln!("skipped: device memory cannot be limited here");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let size = ["render", "cornell-box", "--technique", "direct", "--size", "4096x4096", "--threads", "2"];
    let arguments = [&size[..], &["--backend", "gpu", "--quiet"]].concat();
    fails(folder.path(), "ulimit -v 1500000", &arguments, &["device memory", "smaller"]);
}

#[test]
fn a_killed_command_leaves_whole_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let render = |fov: &str| {
        let size = ["render", "cornell-box", "--technique", "direct", "--size", "1024x768", "--quiet"];
        let mut c = command(folder.path(), &[&size[..], &["-o", "a.exr", "--fov", fov]].concat());
        c.stdout(Stdio::null()).stderr(Stdio::null());
        c
    };
    assert!(render("40").status().unwrap().success());
    let old = std::fs::read(&path).unwrap();
    assert!(render("50").status().unwrap().success());
    let new = std::fs::read(&path).unwrap();
    assert!(old != new);
    std::fs::write(&path, &old).unwrap();
    // Killed as soon as the file beside it is there: most often while it is written.
    let mut hits = 0;
    for _ in 0..8 {
        let mut child = render("50").spawn().unwrap();
        let start = std::time::Instant::now();
        let writes = || listing_names(folder.path()).iter().any(|name| name.ends_with(".part"));
        while !writes() && child.try_wait().unwrap().is_none() && start.elapsed() < Duration::from_secs(60) {}
        let _ = child.kill();
        let _ = child.wait();
        let left = std::fs::read(&path).unwrap();
        assert!(left == old || left == new, "half a file");
        hits += u32::from(left == old);
        for name in listing_names(folder.path()).iter().filter(|name| name.ends_with(".part")) {
            std::fs::remove_file(folder.path().join(name)).unwrap();
        }
        std::fs::write(&path, &old).unwrap();
    }
    assert!(hits > 0, "never killed before the end");
}

fn listing_names(folder: &Path) -> Vec<String> {
    let names = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name());
    names.map(|name| name.to_string_lossy().into_owned()).collect()
}
