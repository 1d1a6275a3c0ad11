//! Are the committed SPIR-V modules those that the sources give?
//!
//! Compiling them needs rust-gpu: the official nightly through rustup, or a toolchain named by
//! `RUST_GPU_TOOLCHAIN` (for `cargo +NAME`) and `RUST_GPU_BACKEND` (its `librustc_codegen_spirv.so`).

use crate::manifest::{Manifest, source_hash};
use clap::Subcommand;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The nightly that rust-gpu 0.10 asks for.
const NIGHTLY: &str = "nightly-2026-07-03";

#[derive(Subcommand, Clone, Copy)]
pub enum Action {
    /// Compile every module and write it with its manifest
    Build,
    /// Compile every module and compare with the committed bytes
    Check,
    /// Compare only the hash of the sources with the manifest; needs no rust-gpu
    Fresh,
}

/// The folder of the workspace.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("xtask lies in the workspace").to_path_buf()
}

/// The committed modules.
pub fn committed() -> PathBuf {
    root().join("backend-gpu/spirv")
}

pub fn run(action: Action) -> Result<(), String> {
    if let Action::Fresh = action {
        return fresh();
    }
    #[cfg(feature = "shaders")]
    {
        compile::run(action)
    }
    #[cfg(not(feature = "shaders"))]
    {
        with_rust_gpu(action)
    }
}

/// Compares the manifest's source hash with the sources.
fn fresh() -> Result<(), String> {
    let manifest = read_manifest(&committed())?;
    let sources = source_hash(&root()).map_err(|e| format!("cannot hash the sources: {e}"))?;
    if manifest.sources == sources {
        println!("the SPIR-V modules were built from these sources");
        Ok(())
    } else {
        Err("the SPIR-V modules are older than the sources: run `cargo xtask shaders build`".into())
    }
}

pub fn read_manifest(folder: &Path) -> Result<Manifest, String> {
    let path = folder.join("manifest.json");
    let text = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
    Manifest::parse(&text).map_err(|e| format!("{}: {e}", path.display()))
}

/// Runs this command again, built with what compiles shaders.
#[cfg_attr(feature = "shaders", allow(dead_code))]
fn with_rust_gpu(action: Action) -> Result<(), String> {
    let custom = std::env::var_os("RUST_GPU_TOOLCHAIN").is_some();
    if custom && std::env::var_os("RUST_GPU_BACKEND").is_none() {
        return Err(
            "RUST_GPU_TOOLCHAIN is set: set RUST_GPU_BACKEND to its librustc_codegen_spirv.so too".into()
        );
    }
    let mut command = Command::new("cargo");
    if !custom {
        let have = Command::new("rustup").args(["run", NIGHTLY, "rustc", "--version"]).output();
        if !have.is_ok_and(|o| o.status.success()) {
            return Err(format!(
                "rust-gpu needs its nightly: run `rustup toolchain install {NIGHTLY} -c rust-src,rustc-dev,llvm-tools`"
            ));
        }
        command.arg(format!("+{NIGHTLY}"));
    }
    let word = match action {
        Action::Build => "build",
        Action::Check => "check",
        Action::Fresh => "fresh",
    };
    let status = command
        .args(["run", "--quiet", "--release", "--package", "xtask", "--target-dir"])
        .arg(root().join("target/xtask-shaders"))
        .args(["--features", if custom { "shaders" } else { "shaders-nightly" }, "--", "shaders", word])
        // Set by the outer cargo: they would make the inner one use the outer's toolchain.
        .env_remove("RUSTUP_TOOLCHAIN")
        .env_remove("CARGO")
        .current_dir(root())
        .status()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    if status.success() { Ok(()) } else { Err("the shader build failed: see above".into()) }
}

#[cfg(feature = "shaders")]
mod compile {
    use super::*;
    use crate::manifest::{Module, sha256};
    use crate::{composites, spirv};
    use spirv_builder::{ModuleResult, SpirvBuilder, SpirvMetadata};
    use std::collections::BTreeMap;
    use std::sync::atomic::{AtomicUsize, Ordering};

    const TARGET: &str = "spirv-unknown-vulkan1.2";
    const RUST_GPU: &str = "0.10.0";
    /// The feature of the shader crate for each variant, and whether and how it is strict.
    const VARIANTS: [&str; 3] = ["strict", "strict-native", "fast"];
    /// What the compiler takes for the shader crate, and some to spare.
    const COMPILER_BYTES: u64 = 9 << 30;

    pub fn run(action: Action) -> Result<(), String> {
        match action {
            Action::Build => {
                let scratch = tempfile::tempdir_in(root().join("backend-gpu")).map_err(|e| e.to_string())?;
                build(scratch.path())?;
                let target = committed();
                let _ = std::fs::remove_dir_all(&target);
                std::fs::rename(scratch.path(), &target).map_err(|e| format!("{}: {e}", target.display()))?;
                println!("wrote {}", target.display());
                Ok(())
            }
            Action::Check => {
                let scratch = tempfile::tempdir().map_err(|e| e.to_string())?;
                build(scratch.path())?;
                compare(&committed(), scratch.path())
            }
            Action::Fresh => super::fresh(),
        }
    }

    fn build(out: &Path) -> Result<(), String> {
        let mut modules = BTreeMap::new();
        for (variant, compiled) in VARIANTS.into_iter().zip(compile_all()?) {
            let folder = out.join(variant);
            std::fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
            let mut entries = BTreeMap::new();
            for (entry, path) in compiled {
                let module = finish(variant, &entry, &path)?;
                let file = folder.join(format!("{entry}.spv"));
                std::fs::write(&file, &module).map_err(|e| format!("{}: {e}", file.display()))?;
                validate(&file)?;
                let description = describe(&entry, &module)?;
                entries.insert(entry, description);
            }
            println!("{variant}: {} modules", entries.len());
            modules.insert(variant.to_owned(), entries);
        }
        let manifest = Manifest {
            rust_gpu: RUST_GPU.into(),
            rustc: rustc_version(),
            target: TARGET.into(),
            sources: source_hash(&root()).map_err(|e| format!("cannot hash the sources: {e}"))?,
            modules,
        };
        let text = serde_json::to_string_pretty(&manifest).map_err(|e| e.to_string())?;
        std::fs::write(out.join("manifest.json"), text + "\n").map_err(|e| e.to_string())
    }

    /// The modules of all variants, two compiled at once where there is memory for it.
    fn compile_all() -> Result<Vec<BTreeMap<String, PathBuf>>, String> {
        let at_once = if available_memory().is_some_and(|bytes| bytes > 2 * COMPILER_BYTES) { 2 } else { 1 };
        let next = AtomicUsize::new(0);
        let take = || {
            let mut taken = Vec::new();
            loop {
                let i = next.fetch_add(1, Ordering::Relaxed);
                let Some(variant) = VARIANTS.get(i) else { return taken };
                taken.push((i, compile(variant)));
            }
        };
        let mut all: Vec<_> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..at_once).map(|_| scope.spawn(take)).collect();
            threads.into_iter().flat_map(|t| t.join().expect("a compiling thread panicked")).collect()
        });
        all.sort_by_key(|(i, _)| *i);
        all.into_iter().map(|(_, modules)| modules).collect()
    }

    /// Bytes of memory that programs may still take, where the system tells.
    fn available_memory() -> Option<u64> {
        let text = std::fs::read_to_string("/proc/meminfo").ok()?;
        let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
        Some(line.trim().trim_end_matches(" kB").parse::<u64>().ok()? << 10)
    }

    fn compile(variant: &str) -> Result<BTreeMap<String, PathBuf>, String> {
        let mut builder = SpirvBuilder::new(root().join("backend-gpu/shaders"), TARGET);
        builder.multimodule = true;
        builder.spirv_metadata = SpirvMetadata::None;
        builder.deny_warnings = true;
        if variant != "fast" {
            // spirv-opt factors a·b + a·c and merges constants, which rounds differently: NoContraction, added
            // afterwards, would come too late.
            builder.extra_args = vec!["--no-spirv-opt".into()];
        }
        builder.shader_crate_features.features = vec![variant.to_owned()];
        builder.target_dir_path = Some(root().join("target/shaders").join(variant));
        if let Some(backend) = std::env::var_os("RUST_GPU_BACKEND") {
            builder.rustc_codegen_spirv_location = Some(backend.into());
        }
        builder.toolchain_overwrite =
            Some(std::env::var("RUST_GPU_TOOLCHAIN").unwrap_or_else(|_| NIGHTLY.to_owned()));
        match builder.build().map_err(|e| format!("{variant}: {e}"))?.module {
            ModuleResult::MultiModule(modules) => Ok(modules),
            ModuleResult::SingleModule(_) => Err("the compiler wrote one module for all entry points".into()),
        }
    }

    /// Reads a module, forbids contraction in the strict variants, and refuses what devices round differently.
    fn finish(variant: &str, entry: &str, path: &Path) -> Result<Vec<u8>, String> {
        let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let words: Vec<u32> =
            bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect();
        if variant == "fast" {
            return match composites::structs_of_pointers(&words)? {
                0 => Ok(bytes),
                count => Err(format!("fast/{entry}: {count} structs of pointers, on which drivers crash")),
            };
        }
        let words = spirv::strip_debug(&words).map_err(|e| format!("{entry}: {e}"))?;
        let words = composites::dissolve(&words).map_err(|e| format!("{entry}: {e}"))?;
        let words = spirv::forbid_contraction(&words).map_err(|e| format!("{entry}: {e}"))?;
        let inexact =
            spirv::inexact(&words, variant == "strict-native").map_err(|e| format!("{entry}: {e}"))?;
        if !inexact.is_empty() {
            return Err(format!("{variant}/{entry} is not reproducible: {}", inexact.join(", ")));
        }
        if spirv::undecorated(&words)? != 0 {
            return Err(format!("{variant}/{entry}: float operations without NoContraction"));
        }
        Ok(words.iter().flat_map(|w| w.to_le_bytes()).collect())
    }

    /// Runs spirv-val where it is installed.
    fn validate(file: &Path) -> Result<(), String> {
        match Command::new("spirv-val").args(["--target-env", "vulkan1.2"]).arg(file).output() {
            Ok(output) if output.status.success() => Ok(()),
            Ok(output) => {
                Err(format!("{}: {}", file.display(), String::from_utf8_lossy(&output.stderr).trim()))
            }
            Err(_) if std::env::var_os("TWINLIGHT_REQUIRE_GPU").is_none() => Ok(()),
            Err(e) => Err(format!("spirv-val: {e} (Debian: apt-get install spirv-tools)")),
        }
    }

    fn describe(entry: &str, module: &[u8]) -> Result<Module, String> {
        let pass = twinlight_kernels::passes::PASSES
            .iter()
            .find(|p| p.name == entry)
            .ok_or_else(|| format!("entry point {entry} is not in the pass list"))?;
        let mut bindings = vec!["0 uniform".to_owned()];
        for b in pass.inputs.iter().chain([&pass.output]) {
            bindings.push(format!("{} {}: {}", b.binding, b.name, b.element));
        }
        Ok(Module { sha256: sha256(module), entry: entry.into(), workgroup: [64, 1, 1], bindings })
    }

    fn rustc_version() -> String {
        let toolchain = std::env::var("RUST_GPU_TOOLCHAIN").unwrap_or_else(|_| NIGHTLY.to_owned());
        Command::new("rustup")
            .args(["run", &toolchain, "rustc", "--version"])
            .output()
            .map(|o| String::from_utf8_lossy(&o.stdout).trim().to_owned())
            .unwrap_or_default()
    }

    fn compare(committed: &Path, rebuilt: &Path) -> Result<(), String> {
        let (old, new) = (read_manifest(committed)?, read_manifest(rebuilt)?);
        let mut differing = Vec::new();
        for variant in VARIANTS {
            let empty = BTreeMap::new();
            let (a, b) =
                (old.modules.get(variant).unwrap_or(&empty), new.modules.get(variant).unwrap_or(&empty));
            let names: std::collections::BTreeSet<_> = a.keys().chain(b.keys()).collect();
            for name in names {
                let file = format!("{variant}/{name}.spv");
                let bytes = |folder: &Path| std::fs::read(folder.join(&file)).ok();
                if a.get(name) != b.get(name) || bytes(committed) != bytes(rebuilt) {
                    differing.push(file);
                }
            }
        }
        if differing.is_empty() && old.sources == new.sources {
            println!("a rebuild gives the committed bytes ({} and {})", old.rustc, new.rustc);
            return Ok(());
        }
        Err(format!(
            "a rebuild differs from the committed SPIR-V: {} (built by {}; here {}). Run `cargo xtask shaders build`",
            if differing.is_empty() { "only the sources' hash".into() } else { differing.join(", ") },
            old.rustc,
            new.rustc
        ))
    }
}
