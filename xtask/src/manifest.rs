//! What was each committed SPIR-V module built from?

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// `backend-gpu/spirv/manifest.json`.
#[derive(Serialize, Deserialize, PartialEq, Debug)]
pub struct Manifest {
    /// rust-gpu version that compiled the modules.
    pub rust_gpu: String,
    /// `rustc --version` of the compiler.
    pub rustc: String,
    /// SPIR-V target.
    pub target: String,
    /// sha256 over the sources that decide the modules; see [`source_hash`].
    pub sources: String,
    /// Module by variant, then by pass.
    pub modules: BTreeMap<String, BTreeMap<String, Module>>,
}

/// One module of the manifest.
#[derive(Serialize, Deserialize, PartialEq, Debug)]
pub struct Module {
    /// sha256 of the file `VARIANT/PASS.spv`.
    pub sha256: String,
    /// Entry point.
    pub entry: String,
    /// Workgroup size.
    pub workgroup: [u32; 3],
    /// What binds where: `0 uniform`, then `1 positions: Vec4`, ….
    pub bindings: Vec<String>,
}

/// The sha256 of some bytes in hexadecimal.
#[cfg(feature = "shaders")]
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|b| format!("{b:02x}")).collect()
}

/// The sha256 over the sources of the kernels and of the shader crate, names and contents, in order of name.
pub fn source_hash(root: &Path) -> std::io::Result<String> {
    let mut files = Vec::new();
    for folder in ["kernels/src", "backend-gpu/shaders/src"] {
        collect(&root.join(folder), &mut files)?;
    }
    for file in ["kernels/Cargo.toml", "backend-gpu/shaders/Cargo.toml", "backend-gpu/shaders/Cargo.lock"] {
        files.push(root.join(file));
    }
    files.sort();
    let mut hash = Sha256::new();
    for file in files {
        let name = file.strip_prefix(root).unwrap_or(&file).to_string_lossy().replace('\\', "/");
        hash.update(name.as_bytes());
        hash.update([0]);
        hash.update(std::fs::read(&file)?);
        hash.update([0]);
    }
    Ok(hash.finalize().iter().map(|b| format!("{b:02x}")).collect())
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
    Ok(())
}
