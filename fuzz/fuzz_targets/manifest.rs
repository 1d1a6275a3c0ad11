#![no_main]

#[path = "../../xtask/src/manifest.rs"]
#[allow(dead_code)]
mod manifest;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| manifest::try_bytes(bytes));
