//! Do scan, sort, compaction and reduction give what the standard library gives, on both backends?

mod common;

use common::draw::Draw;
use common::gpu::shared;
use glam::{DVec4, Vec4};
use twinlight::backend::{Backend, Cpu};
use twinlight::primitives::{compact, exclusive_scan, reduce, sort_pairs};
use twinlight_gpu::Variant;

/// Around the blocks' edges, and enough for three levels of the scan.
const SIZES: [usize; 10] = [0, 1, 31, 32, 33, 127, 128, 129, 1000, 100_000];

/// The test bodies, once per backend and variant.
macro_rules! on_every_backend {
    ($($name:ident = $body:ident;)*) => {$(
        #[test]
        fn $name() {
            $body(&mut Cpu::new(Some(2)).unwrap(), &mut Draw::new(stringify!($name)));
            let Some(mut shared) = shared() else { return };
            for variant in shared.strict_variants().into_iter().chain([Variant::Fast]) {
                shared.gpu.set_variant(variant);
                $body(&mut shared.gpu, &mut Draw::new(stringify!($name)));
            }
        }
    )*};
}

on_every_backend! {
    scan_is_the_running_sum_before_each_value = scan;
    sort_is_stable_and_by_key = sort;
    sort_looks_at_the_key_bits_alone = sort_few_bits;
    compaction_keeps_the_flagged_in_order = compaction;
    reduction_is_the_sum = reduction;
}

fn scan<B: Backend>(backend: &mut B, draw: &mut Draw) {
    for size in SIZES {
        let values: Vec<u32> = (0..size).map(|_| draw.word()).collect();
        let buffer = backend.upload("values", &values).unwrap();
        let scanned = exclusive_scan(backend, &buffer, size as u32).unwrap();
        let got = backend.download(&scanned).unwrap();
        let mut sum = 0u32;
        let mut expected = Vec::new();
        for v in &values {
            expected.push(sum);
            sum = sum.wrapping_add(*v);
        }
        assert!(got == expected, "{size} values");
    }
}

/// Keys of three kinds: any, few different, all equal.
fn keys(draw: &mut Draw, size: usize, kind: u32) -> Vec<u32> {
    let key = |draw: &mut Draw| match kind {
        0 => draw.of(&proptest::prelude::any::<u32>()),
        1 => draw.integer(0, 7) << 13,
        _ => 0x8000_0001,
    };
    (0..size).map(|_| key(draw)).collect()
}

fn sorted<B: Backend>(backend: &mut B, keys: &[u32], bits: u32) -> Vec<[u32; 2]> {
    let pairs: Vec<u32> = keys.iter().zip(0..).flat_map(|(&k, i)| [k, i]).collect();
    let buffer = backend.upload("pairs", &pairs).unwrap();
    let sorted = sort_pairs(backend, buffer, bits).unwrap();
    bytemuck::cast_slice(&backend.download(&sorted).unwrap()).to_vec()
}

fn sort<B: Backend>(backend: &mut B, draw: &mut Draw) {
    for size in SIZES {
        for kind in 0..3 {
            let keys = keys(draw, size, kind);
            let got = sorted(backend, &keys, 32);
            let mut expected: Vec<[u32; 2]> = keys.iter().zip(0..).map(|(&k, i)| [k, i]).collect();
            expected.sort_by_key(|pair| pair[0]);
            assert!(got == expected, "{size} keys of kind {kind}");
            // Planted fault: an order that is sorted but not stable.
            if kind == 2 && size > 1 {
                expected.reverse();
                assert!(got != expected, "{size} equal keys in any order pass");
            }
        }
    }
}

fn sort_few_bits<B: Backend>(backend: &mut B, draw: &mut Draw) {
    let keys = keys(draw, 1000, 0);
    let got = sorted(backend, &keys, 8);
    let mut expected: Vec<[u32; 2]> = keys.iter().zip(0..).map(|(&k, i)| [k, i]).collect();
    expected.sort_by_key(|pair| pair[0] & 0xFF);
    assert!(got == expected);
}

fn compaction<B: Backend>(backend: &mut B, draw: &mut Draw) {
    for size in SIZES {
        for kind in 0..3 {
            let flag = |draw: &mut Draw| if kind == 2 { draw.integer(0, 2) } else { kind };
            let flags: Vec<u32> = (0..size).map(|_| flag(draw)).collect();
            let buffer = backend.upload("flags", &flags).unwrap();
            let (indices, count) = compact(backend, &buffer, size as u32).unwrap();
            let expected: Vec<u32> = (0..size as u32).filter(|&i| flags[i as usize] == 1).collect();
            assert_eq!(count as usize, expected.len(), "{size} flags of kind {kind}");
            let got = backend.download(&indices).unwrap();
            assert!(got[..expected.len()] == expected, "{size} flags of kind {kind}");
            assert!(got[expected.len()..].iter().all(|&i| i == 0), "{size} flags: written beyond the count");
        }
    }
}

/// Largest error of a tree of additions over `values`: depth · 2⁻²⁴ · Σ|v|.
fn within_rounding(got: Vec4, values: &[Vec4]) -> bool {
    let truth: DVec4 = values.iter().map(|v| v.as_dvec4()).sum();
    let magnitude: DVec4 = values.iter().map(|v| v.abs().as_dvec4()).sum();
    let depth = (values.len().max(2) as f64).log2().ceil();
    // Negated, so that NaN counts as wrong.
    (0..4).all(|i| (f64::from(got[i]) - truth[i]).abs() <= depth * 2f64.powi(-24) * magnitude[i])
}

fn reduction<B: Backend>(backend: &mut B, draw: &mut Draw) {
    let mut cpu = Cpu::new(Some(1)).unwrap();
    for size in SIZES {
        let values: Vec<Vec4> = (0..size).map(|_| draw.numbers(1e-3, 1e3)).collect();
        let buffer = backend.upload("values", &values).unwrap();
        let got = reduce(backend, &buffer, size as u32).unwrap();
        assert!(within_rounding(got, &values), "{size} vectors: {got}");
        // The same tree on one thread of the CPU: the same bits.
        let buffer = Backend::upload(&mut cpu, "values", &values).unwrap();
        let reference = reduce(&mut cpu, &buffer, size as u32).unwrap();
        assert_eq!(
            got.to_array().map(f32::to_bits),
            reference.to_array().map(f32::to_bits),
            "{size} vectors"
        );
        // Planted fault: the largest number lost.
        let largest = values.iter().fold(0.0, |m: f32, v| m.max(v.abs().max_element()));
        let lost = within_rounding(got - Vec4::splat(largest), &values);
        assert!(!lost || largest == 0.0, "{size} vectors: a lost number passes");
    }
}
