//! Are the committed SPIR-V modules those of the pass list, built from these sources, and fit for strict arithmetic?
//!
//! The words are read by a parser of this test's own, so that a fault of the build step's parser shows.

use serde_json::Value;
use sha2::{Digest, Sha256};
use std::collections::{BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use twinlight_gpu::{Variant, module};
use twinlight_kernels::passes::PASSES;

const VARIANTS: [(Variant, &str); 3] =
    [(Variant::Strict, "strict"), (Variant::StrictNative, "strict-native"), (Variant::Fast, "fast")];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("the crate lies in the workspace").to_path_buf()
}

fn manifest() -> Value {
    let path = root().join("backend-gpu/spirv/manifest.json");
    let text = std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    serde_json::from_str(&text).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn hex(bytes: impl AsRef<[u8]>) -> String {
    bytes.as_ref().iter().map(|b| format!("{b:02x}")).collect()
}

#[test]
fn every_pass_has_its_module_in_every_variant_and_nothing_else_is_there() {
    let manifest = manifest();
    let names: BTreeSet<String> = PASSES.iter().map(|p| p.name.to_owned()).collect();
    for (variant, folder) in VARIANTS {
        let listed = manifest["modules"][folder].as_object().expect("a variant");
        assert_eq!(listed.keys().cloned().collect::<BTreeSet<_>>(), names, "manifest, {folder}");
        let files: BTreeSet<String> = std::fs::read_dir(root().join("backend-gpu/spirv").join(folder))
            .expect("the variant's folder")
            .map(|e| e.unwrap().file_name().into_string().unwrap())
            .collect();
        assert_eq!(files, names.iter().map(|n| format!("{n}.spv")).collect(), "files, {folder}");
        for pass in PASSES {
            let bytes = module(variant, pass.name).expect("a module");
            let entry = &listed[pass.name];
            let place = format!("{folder}/{}", pass.name);
            assert_eq!(entry["sha256"], hex(Sha256::digest(bytes)), "{place}: not the file of the manifest");
            assert_eq!(entry["entry"], pass.name, "{place}");
            assert_eq!(entry["workgroup"], serde_json::json!([64, 1, 1]), "{place}");
            let mut bindings = vec!["0 uniform".to_owned()];
            bindings.extend(
                pass.inputs
                    .iter()
                    .chain([&pass.output])
                    .map(|b| format!("{} {}: {}", b.binding, b.name, b.element)),
            );
            assert_eq!(entry["bindings"], serde_json::json!(bindings), "{place}");
            let words = words(bytes);
            assert_eq!(entry_points(&words), [pass.name], "{place}");
            let expected: BTreeSet<u32> = (0..=pass.inputs.len() as u32 + 1).collect();
            let bound = binding_numbers(&words);
            assert!(bound.is_subset(&expected), "{place}: binds {bound:?}, expected {expected:?}");
            assert!(bound.contains(&0) && bound.contains(&pass.output.binding), "{place}: binds {bound:?}");
        }
    }
    assert_eq!(module(Variant::Fast, "no such pass"), None);
}

#[test]
fn the_modules_are_built_from_these_sources() {
    let mut files = Vec::new();
    collect(&root().join("kernels/src"), &mut files);
    collect(&root().join("backend-gpu/shaders/src"), &mut files);
    for file in ["kernels/Cargo.toml", "backend-gpu/shaders/Cargo.toml", "backend-gpu/shaders/Cargo.lock"] {
        files.push(root().join(file));
    }
    files.sort();
    let mut hash = Sha256::new();
    for file in files {
        let name = file.strip_prefix(root()).unwrap().to_string_lossy().replace('\\', "/");
        hash.update(name.as_bytes());
        hash.update([0]);
        hash.update(std::fs::read(&file).unwrap());
        hash.update([0]);
    }
    assert_eq!(
        manifest()["sources"],
        hex(hash.finalize()),
        "the SPIR-V modules are older than the sources: run `cargo xtask shaders build`"
    );
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

#[test]
fn strict_modules_forbid_contraction_everywhere_and_fast_ones_would_be_caught() {
    let mut operations = 0;
    for pass in PASSES {
        for variant in [Variant::Strict, Variant::StrictNative] {
            let words = words(module(variant, pass.name).unwrap());
            let counted = float_operations(&words);
            assert_eq!(counted.undecorated, 0, "{variant:?} {}: may be contracted", pass.name);
            operations += counted.all;
            if variant == Variant::Strict {
                assert_eq!(counted.divisions, 0, "{}: divides natively", pass.name);
            }
        }
    }
    assert!(operations > 10_000, "only {operations} float operations seen: is the parser blind?");
    // Planted fault: a module that nobody decorated.
    let plain = float_operations(&words(module(Variant::Fast, "evaluate_elementary").unwrap()));
    assert!(plain.undecorated > 100 && plain.undecorated == plain.all, "{plain:?}");
    // Planted fault: one decoration less in a decorated module.
    let good = words(module(Variant::Strict, "add_radiance").unwrap());
    let mut bad = good.clone();
    let (at, _, _) = instructions(&good)
        .into_iter()
        .find(|&(at, opcode, _)| opcode == DECORATE && good[at + 2] == NO_CONTRACTION)
        .expect("a decoration");
    bad[at + 1] = good[3] - 1;
    assert!(float_operations(&bad).undecorated > 0, "a missing decoration passes");
}

const ENTRY_POINT: u32 = 15;
const DECORATE: u32 = 71;
const BINDING: u32 = 33;
const NO_CONTRACTION: u32 = 42;
const DIVIDE: u32 = 136;

fn words(bytes: &[u8]) -> Vec<u32> {
    assert_eq!(bytes.len() % 4, 0);
    bytes.chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
}

/// Place, opcode and length of each instruction.
fn instructions(words: &[u32]) -> Vec<(usize, u32, usize)> {
    assert_eq!(words[0], 0x0723_0203, "not SPIR-V");
    let mut all = Vec::new();
    let mut rest = 5;
    while rest < words.len() {
        let length = words[rest] as usize >> 16;
        assert!(length > 0 && rest + length <= words.len(), "word {rest}");
        all.push((rest, words[rest] & 0xFFFF, length));
        rest += length;
    }
    all
}

fn entry_points(words: &[u32]) -> Vec<String> {
    let name = |at: usize, length: usize| {
        let bytes: Vec<u8> = words[at + 3..at + length].iter().flat_map(|w| w.to_le_bytes()).collect();
        String::from_utf8(bytes.into_iter().take_while(|&b| b != 0).collect()).unwrap()
    };
    instructions(words).iter().filter(|i| i.1 == ENTRY_POINT).map(|&(at, _, n)| name(at, n)).collect()
}

fn binding_numbers(words: &[u32]) -> BTreeSet<u32> {
    let decorations = instructions(words).into_iter().filter(|i| i.1 == DECORATE);
    decorations.filter(|&(at, _, _)| words[at + 2] == BINDING).map(|(at, _, _)| words[at + 3]).collect()
}

#[derive(Debug)]
struct Counted {
    all: usize,
    undecorated: usize,
    divisions: usize,
}

/// Counts the operations that a compiler may contract or reorder.
fn float_operations(words: &[u32]) -> Counted {
    // FNegate, FAdd, FSub, FMul, FDiv, FRem, FMod, and the products of vectors and matrices up to Dot.
    let is_float = |opcode: u32| matches!(opcode, 127 | 129 | 131 | 133 | 136 | 140 | 141 | 142..=148);
    let all = instructions(words);
    let decorated: HashSet<u32> = all
        .iter()
        .filter(|&&(at, opcode, _)| opcode == DECORATE && words[at + 2] == NO_CONTRACTION)
        .map(|&(at, _, _)| words[at + 1])
        .collect();
    let operations: Vec<_> = all.iter().filter(|i| is_float(i.1)).collect();
    Counted {
        all: operations.len(),
        undecorated: operations.iter().filter(|i| !decorated.contains(&words[i.0 + 2])).count(),
        divisions: operations.iter().filter(|i| i.1 == DIVIDE).count(),
    }
}
