//! What does each step of CI run?

use crate::shaders::{self, root};
use std::process::Command;

fn cargo(arguments: &[&str]) -> Command {
    let mut command = Command::new("cargo");
    command.args(arguments).current_dir(root());
    command
}

fn check(mut command: Command, what: &str) -> Result<(), String> {
    println!("== {what}");
    let status = command.status().map_err(|e| format!("{what}: cannot start: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{what} failed: see above")) }
}

/// Runs every test of the workspace, with a Vulkan driver where one can be had.
pub fn test(rest: &[String]) -> Result<(), String> {
    software_vulkan();
    let mut command = cargo(&["test", "--workspace"]);
    command.args(rest);
    check(command, "tests")
}

/// Makes sure that some Vulkan driver is there; says how to get one where it cannot install it.
fn software_vulkan() {
    if vulkan_driver() {
        return;
    }
    let installable = cfg!(target_os = "linux")
        && Command::new("apt-get").arg("--version").output().is_ok()
        && Command::new("id").arg("-u").output().is_ok_and(|o| o.stdout.starts_with(b"0\n"));
    if installable {
        println!("== no Vulkan driver: installing Debian's software driver (mesa-vulkan-drivers)");
        let _ = Command::new("apt-get").args(["update", "-qq"]).status();
        let _ = Command::new("apt-get")
            .args(["install", "-y", "-qq", "mesa-vulkan-drivers", "libvulkan1"])
            .env("DEBIAN_FRONTEND", "noninteractive")
            .status();
    }
    if !vulkan_driver() {
        println!(
            "== no Vulkan driver: GPU tests will be skipped. To run them without a GPU install Mesa's lavapipe:\n\
             ==   Debian, Ubuntu: sudo apt-get install mesa-vulkan-drivers libvulkan1\n\
             ==   Fedora: sudo dnf install mesa-vulkan-drivers vulkan-loader\n\
             ==   Arch: sudo pacman -S vulkan-swrast vulkan-icd-loader"
        );
    }
}

fn vulkan_driver() -> bool {
    if !cfg!(target_os = "linux") {
        return true;
    }
    let listed = |folder: &str| {
        std::fs::read_dir(folder)
            .is_ok_and(|mut d| d.any(|e| e.is_ok_and(|e| e.path().extension().is_some_and(|x| x == "json"))))
    };
    let driver = std::env::var_os("VK_DRIVER_FILES").is_some()
        || std::env::var_os("VK_ICD_FILENAMES").is_some()
        || listed("/usr/share/vulkan/icd.d")
        || listed("/etc/vulkan/icd.d");
    let loader = Command::new("ldconfig")
        .arg("-p")
        .output()
        .map_or(true, |o| String::from_utf8_lossy(&o.stdout).contains("libvulkan.so.1"));
    driver && loader
}

/// Checks the formatting of both workspaces.
pub fn fmt() -> Result<(), String> {
    check(cargo(&["fmt", "--all", "--check"]), "formatting")?;
    check(
        cargo(&["fmt", "--manifest-path", "backend-gpu/shaders/Cargo.toml", "--check"]),
        "formatting of the shaders",
    )?;
    check(cargo(&["fmt", "--manifest-path", "fuzz/Cargo.toml", "--check"]), "formatting of the fuzz targets")
}

/// Compiles the fuzz targets, as a crate that depends on this one and resolves its dependencies itself.
pub fn check_fuzz_targets() -> Result<(), String> {
    let mut command =
        cargo(&["check", "--manifest-path", "fuzz/Cargo.toml", "--target-dir", "target/fuzz", "--locked"]);
    command.env("RUSTFLAGS", "--cfg fuzzing");
    check(command, "fuzz targets")
}

/// Runs clippy over everything.
pub fn clippy() -> Result<(), String> {
    check(cargo(&["clippy", "--workspace", "--all-targets", "--", "-D", "warnings"]), "clippy")
}

/// Builds the documentation.
pub fn doc() -> Result<(), String> {
    let mut command = cargo(&["doc", "--workspace", "--no-deps"]);
    command.env("RUSTDOCFLAGS", "-D warnings");
    check(command, "documentation")
}

/// Runs each fuzz target for a while; what it finds of interest stays in `target/fuzz-corpus`, what breaks it in `fuzz/artifacts`.
pub fn fuzz(seconds: u32) -> Result<(), String> {
    let have = cargo(&["+nightly", "fuzz", "--version"]).output().is_ok_and(|o| o.status.success());
    if !have {
        return Err("fuzzing needs `rustup toolchain install nightly` and `cargo install cargo-fuzz`".into());
    }
    for target in ["gltf", "environment", "options", "manifest"] {
        let found = format!("target/fuzz-corpus/{target}");
        std::fs::create_dir_all(root().join(&found)).map_err(|e| format!("{found}: {e}"))?;
        let seeds = format!("fuzz/corpus/{target}");
        let limit = format!("-max_total_time={seconds}");
        // The largest pictures that are read take half a minute under the sanitizer.
        let memory = ["-rss_limit_mb=6144", "-malloc_limit_mb=6144", "-timeout=60"];
        let mut command = cargo(&["+nightly", "fuzz", "run", "-O", target, &found, &seeds, "--", &limit]);
        command.args(memory);
        check(command, &format!("fuzzing {target}"))?;
    }
    Ok(())
}

/// Runs every step.
pub fn ci() -> Result<(), String> {
    test(&[])?;
    shaders::run(shaders::Action::Check)?;
    fmt()?;
    clippy()?;
    check_fuzz_targets()?;
    doc()
}
