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

impl Manifest {
    /// Reads the text of a manifest.
    ///
    /// # Errors
    /// One line: not JSON of this form, names that are no file names, hashes that are none, workgroups of nothing.
    pub fn parse(text: &str) -> Result<Self, String> {
        let manifest: Self = serde_json::from_str(text).map_err(|e| e.to_string())?;
        let is_hash = |text: &str| text.len() == 64 && text.bytes().all(|b| b.is_ascii_hexdigit());
        let is_name = |text: &str| {
            let allowed = |b: u8| b.is_ascii_lowercase() || b.is_ascii_digit() || b == b'_' || b == b'-';
            !text.is_empty() && text.len() < 100 && text.bytes().all(allowed)
        };
        if !is_hash(&manifest.sources) {
            return Err(format!("sources {:?} is no sha256", shortened(&manifest.sources)));
        }
        for (variant, modules) in &manifest.modules {
            for (name, module) in modules {
                let what = format!("module {:?}/{:?}", shortened(variant), shortened(name));
                if !is_name(variant) || !is_name(name) {
                    return Err(format!("{what} is no name of a file"));
                }
                if !is_hash(&module.sha256) {
                    return Err(format!("{what}: sha256 {:?} is none", shortened(&module.sha256)));
                }
                if module.workgroup.iter().any(|&n| n == 0 || n > 1024) {
                    return Err(format!("{what}: a workgroup of {:?}", module.workgroup));
                }
            }
        }
        Ok(manifest)
    }
}

fn shortened(text: &str) -> String {
    text.chars().take(100).collect()
}

/// Reads bytes as a manifest: what is understood is written and read as the same.
#[cfg(any(test, fuzzing))]
pub fn try_bytes(bytes: &[u8]) {
    match Manifest::parse(&String::from_utf8_lossy(bytes)) {
        Ok(manifest) => {
            let text = serde_json::to_string(&manifest).expect("a manifest has a text");
            assert_eq!(Manifest::parse(&text).as_ref(), Ok(&manifest));
        }
        Err(reason) => assert!(!reason.is_empty() && !reason.contains('\n'), "{reason:?}"),
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn committed() -> String {
        std::fs::read_to_string(crate::shaders::committed().join("manifest.json")).unwrap()
    }

    #[test]
    fn changed_manifests_are_refused_or_understood() {
        let whole = committed();
        let start: String = whole.chars().take(1500).collect();
        for at in (0..start.len()).step_by(3) {
            for with in ["", "\"", "{", "0", "\u{7f}", "../", "1e999", "[[[["] {
                let mut text = whole.clone();
                text.replace_range(at..at + 1, with);
                try_bytes(text.as_bytes());
            }
            try_bytes(&whole.as_bytes()[..at]);
        }
        try_bytes(&[0xFF, 0xFE, b'{']);
    }

    #[test]
    fn what_is_no_manifest_is_refused() {
        let whole = committed();
        assert!(Manifest::parse(&whole).is_ok());
        let module = whole.find("\"add_bounce\"").expect("a pass of that name");
        let with = |old: &str, new: &str| {
            let text = format!("{}{}", &whole[..module], whole[module..].replacen(old, new, 1));
            assert_ne!(text, whole);
            Manifest::parse(&text).expect_err(new)
        };
        assert!(with("add_bounce", "../add_bounce").contains("no name of a file"));
        assert!(with("\"sha256\": \"", "\"sha256\": \"x").contains("sha256"));
        assert!(Manifest::parse("").is_err() && Manifest::parse("{}").is_err());
    }

    #[test]
    fn the_corpus_of_the_fuzzer_is_replayed() {
        let folder = crate::shaders::root().join("fuzz/corpus/manifest");
        let files: Vec<_> = std::fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect();
        assert!(files.len() > 10, "{} files", files.len());
        files.iter().for_each(|file| try_bytes(&std::fs::read(file).unwrap()));
    }
}
