//! Does the pass list hold together, and do both backends lay out its elements alike?

mod common;

use common::gpu::shared;
use std::collections::HashSet;
use twinlight::backend::{Backend, Cpu};
use twinlight_gpu::Variant;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::layout_report::{LAYOUT_NAMES, LAYOUT_WORDS};
use twinlight_kernels::passes::{PASSES, PassInfo, Shape, info};

/// What is wrong with the bindings of a pass.
fn fault(pass: &PassInfo) -> Option<String> {
    let numbers: Vec<u32> = pass.inputs.iter().chain([&pass.output]).map(|b| b.binding).collect();
    if numbers != (1..=numbers.len() as u32).collect::<Vec<_>>() {
        return Some(format!("{}: bindings {numbers:?} are not 1, 2, … with the output last", pass.name));
    }
    for b in pass.inputs.iter().chain([&pass.output]) {
        let mut end = 0;
        for field in b.fields {
            if field.offset != end {
                return Some(format!("{}: {} has a gap before {}", pass.name, b.element, field.name));
            }
            end = field.offset + 4 * field.words;
        }
        if end != b.stride {
            return Some(format!(
                "{}: the members of {} cover {end} of {} bytes",
                pass.name, b.element, b.stride
            ));
        }
    }
    if pass.shape == Shape::Scatter && pass.output.element != "u32" {
        return Some(format!("{}: scatters into {}", pass.name, pass.output.element));
    }
    None
}

#[test]
fn bindings_are_contiguous_and_names_unique() {
    let mut names = HashSet::new();
    for pass in PASSES {
        assert_eq!(fault(pass), None);
        assert!(names.insert(pass.name), "{} stands twice in the list", pass.name);
        assert!(pass.params_size > 0 && pass.params_size % 16 == 0, "{}", pass.name);
    }
    // Planted faults: an output before an input, a member too few.
    let mut swapped = info::add_radiance;
    swapped.output.binding = 2;
    assert!(fault(&swapped).is_some());
    let mut short = info::trace_primary;
    short.output.fields = &short.output.fields[..3];
    assert!(fault(&short).is_some());
}

fn reported<B: Backend>(backend: &mut B) -> Vec<u32> {
    let mut words = backend.alloc("words", LAYOUT_WORDS.len()).unwrap();
    backend.report_layout(&LayoutParams::default(), &mut words, LAYOUT_WORDS.len() as u32).unwrap();
    backend.download(&words).unwrap()
}

/// The members whose place differs from the host's.
fn misplaced(words: &[u32]) -> Vec<String> {
    let all = words.iter().zip(LAYOUT_WORDS).zip(LAYOUT_NAMES);
    all.filter(|((got, host), _)| got != host)
        .map(|((got, host), name)| format!("{name}: {got}, on the host {host}"))
        .collect()
}

#[test]
fn elements_are_laid_out_as_on_the_host() {
    assert_eq!(LAYOUT_WORDS.len(), LAYOUT_NAMES.len());
    let on_cpu = reported(&mut Cpu::new(Some(2)).unwrap());
    assert_eq!(misplaced(&on_cpu), [""; 0]);
    // Planted fault: one member moved.
    let mut moved = on_cpu.clone();
    moved[5] += 4;
    assert_eq!(misplaced(&moved).len(), 1);
    // Every struct that a buffer of the list holds is reported.
    for pass in PASSES {
        for b in pass.inputs.iter().chain([&pass.output]) {
            let plain = ["f32", "u32", "Vec4", "UVec4", "Mat4"].iter().any(|p| b.element.ends_with(p));
            assert!(plain || LAYOUT_NAMES.contains(&b.element), "{} is not in layout_report.rs", b.element);
        }
    }
    let Some(mut shared) = shared() else { return };
    for variant in shared.strict_variants().into_iter().chain([Variant::Fast]) {
        shared.gpu.set_variant(variant);
        assert_eq!(misplaced(&reported(&mut shared.gpu)), [""; 0], "{variant:?}");
    }
}
