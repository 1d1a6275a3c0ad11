//! Does a pass stay finite, in range and bounded whatever floats its inputs hold?
//!
//! The inputs of the comparison, in which one float in eight is replaced. Finite ones of every class must give finite outputs on all
//! backends; with any bit pattern nothing may panic, hang or write elsewhere, and the strict GPU must still give the CPU's bits. Counts,
//! indices and trees stay as they are: they are the caller's word.

use crate::body::{Case, Launch, outputs};
use crate::cases;
use crate::common::draw::Draw;
use crate::common::gpu::{announce, shared};
use bytemuck::cast_slice_mut;
use twinlight::backend::{BufferElement, Cpu};
use twinlight::report::agreement::compare_elements;
use twinlight::scene::MAX_VALUE;
use twinlight_gpu::Variant;
use twinlight_kernels::layout::WordKind;
use twinlight_kernels::passes::{self, PassInfo, info};

/// Passes whose offsets another pass counted from the same floats: they are counted anew in tests of their own below.
const COUNTED: [&str; 2] = ["overlap_pairs", "tile_lists"];

/// The largest magnitude of a pass's inputs that must give finite outputs; `None` where outputs are those of IEEE 754: too large a result is
/// infinite, a meaningless one NaN.
fn domain(pass: &PassInfo) -> Option<f32> {
    match pass.name {
        // See `elementary` of the kernels' own tests; vectors are tried over their whole range.
        "evaluate_elementary" | "evaluate_vector" => None,
        // Sums of voxels belong together: no light without area. With those as they are: a test of its own below.
        "gather_diffuse" => None,
        // Products of up to seven inputs.
        name if name.starts_with("evaluate_sh") => Some(1e4),
        // Products of albedo, light and coefficients, of which scenes have one that is large.
        "accumulate_indirect" | "add_specular_reflection" | "shade_soft_specular" => Some(1e9),
        _ => Some(MAX_VALUE),
    }
}

/// Which floats are put into the inputs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Floats {
    /// Of every finite class, subnormals too, up to a magnitude.
    Finite(f32),
    /// Infinities, NaN with any payload, zeros, and magnitudes whose products devices do not flush.
    Any,
}

impl Floats {
    fn draw(self, draw: &mut Draw) -> f32 {
        const CLASSES: [u32; 16] = [
            0x0000_0000, // 0
            0x8000_0000, // −0
            0x0000_0001, // the least
            0x8000_0001,
            0x007F_FFFF, // the largest subnormal
            0x807F_FFFF,
            0x0080_0000, // the least normal
            0x3F7F_FFFF, // 1 and its neighbours
            0x3F80_0000,
            0x3F80_0001,
            0x7F80_0000, // infinities
            0xFF80_0000,
            0x7F80_0001, // NaN: signalling, quiet, with payloads
            0x7FC0_0000,
            0xFFFF_FFFF,
            0xFF80_4321,
        ];
        loop {
            let bits = match draw.integer(0, 4) {
                0 | 1 => CLASSES[draw.integer(0, CLASSES.len() as u32) as usize],
                // Subnormal.
                2 if draw.rarely(4) => draw.word() & 0x807F_FFFF,
                _ => draw.word(),
            };
            let value = f32::from_bits(bits);
            let taken = match self {
                Self::Finite(largest) => value.abs() <= largest,
                Self::Any => value == 0.0 || !value.is_finite() || (1e-6..1e6).contains(&value.abs()),
            };
            if taken {
                return value;
            }
        }
    }
}

/// Puts floats of all kinds into an input; returns how many.
pub fn spoil<T: BufferElement>(values: &mut [T], floats: Floats, draw: &mut Draw) -> usize {
    let words = size_of::<T>() / 4;
    if T::NAME == "BvhNode" {
        return 0;
    }
    let flat: &mut [u32] = cast_slice_mut(values);
    let mut count = 0;
    for field in T::FIELDS.iter().filter(|f| f.kind == WordKind::Float) {
        for word in field.offset as usize / 4..(field.offset / 4 + field.words) as usize {
            for at in (word..flat.len()).step_by(words) {
                if draw.rarely(8) {
                    flat[at] = floats.draw(draw).to_bits();
                    count += 1;
                }
            }
        }
    }
    count
}

/// Floats of an output that are not finite, and the first of them.
fn non_finite<T: BufferElement>(values: &[T]) -> (usize, Option<usize>) {
    let words = size_of::<T>() / 4;
    let (mut count, mut first) = (0, None);
    for field in T::FIELDS.iter().filter(|f| f.kind == WordKind::Float) {
        let own = (field.offset / 4) as usize..(field.offset / 4 + field.words) as usize;
        for (i, value) in values.iter().enumerate() {
            let flat: &[f32] = bytemuck::cast_slice(std::slice::from_ref(value));
            let bad = flat[..words][own.clone()].iter().filter(|x| !x.is_finite()).count();
            count += bad;
            if bad > 0 && first.is_none() {
                first = Some(i);
            }
        }
    }
    (count, first)
}

/// Runs a pass over spoiled inputs on all backends.
pub fn check<C: Case>(pass: &'static PassInfo, cases: impl Fn(&mut Draw) -> Vec<C>, draw: &mut Draw) {
    if COUNTED.contains(&pass.name) {
        return;
    }
    let mut spoiled = 0;
    if let Some(largest) = domain(pass) {
        for mut case in cases(draw) {
            spoiled += case.spoil(Floats::Finite(largest), draw);
            check_finite(pass, &case);
        }
    }
    for mut case in cases(draw) {
        spoiled += case.spoil(Floats::Any, draw);
        check_survival(pass, &case);
    }
    println!("{}: {spoiled} floats replaced", pass.name);
    // Nothing was tried only where there is nothing to replace.
    let none = pass
        .inputs
        .iter()
        .all(|i| i.element == "BvhNode" || i.fields.iter().all(|f| f.kind != WordKind::Float));
    assert_eq!(spoiled == 0, none, "{}", pass.name);
}

#[test]
fn pairs_of_any_discs() {
    let mut draw = Draw::new("pairs of any discs");
    for floats in [Floats::Finite(MAX_VALUE), Floats::Any] {
        for mut case in cases::overlap_pairs(&mut draw) {
            assert!(case.spoil(floats, &mut draw) > 0);
            let (params, proxies) = (case.params, &case.proxies);
            let counts: Vec<u32> =
                (0..params.proxies).map(|i| passes::overlap_counts(i, &params, proxies)).collect();
            case.starts = cases::scanned(&counts);
            case.params.pairs = counts.iter().sum();
            let words = 2 * case.params.pairs;
            case.launch = Launch::new("all pairs", words as usize, words);
            // Some discs reach everywhere, some nowhere.
            assert!(counts.contains(&0) && counts.iter().any(|&n| n > 8));
            check_as(&info::overlap_pairs, &case, floats);
        }
    }
}

#[test]
fn lists_of_any_spheres() {
    let mut draw = Draw::new("lists of any spheres");
    for floats in [Floats::Finite(MAX_VALUE), Floats::Any] {
        for mut case in cases::tile_lists(&mut draw) {
            assert!(case.spoil(floats, &mut draw) > 0);
            let tiles = case.launch.items;
            let count = |i| passes::tile_counts(i, &case.params, &case.bounds, &case.proxies);
            let counts: Vec<u32> = (0..tiles).map(count).collect();
            case.starts = cases::scanned(&counts);
            let all: u32 = counts.iter().sum();
            assert!(all > 0);
            case.launch = Launch::new("all tiles", all as usize, tiles);
            check_as(&info::tile_lists, &case, floats);
        }
    }
}

/// Voxels' sums, shares of openness and lobes belong together as passes before leave them; all else may be any finite float.
#[test]
fn light_on_any_surfaces_from_any_proxies() {
    let mut draw = Draw::new("light on any surfaces");
    for mut case in cases::gather_diffuse(&mut draw) {
        let (voxels, radiance, sides) =
            (case.voxels.clone(), case.radiance.clone(), case.params.sides as usize);
        assert!(case.spoil(Floats::Finite(MAX_VALUE), &mut draw) > 0);
        case.voxels = voxels;
        for (i, (own, whole)) in case.radiance.iter_mut().zip(&radiance).enumerate() {
            *own = if i < sides { own.truncate().extend(whole.w) } else { *whole };
        }
        assert!(case.radiance != radiance);
        check_finite(&info::gather_diffuse, &case);
    }
}

/// Finite floats, of which some are subnormal and may be flushed, must break nothing; others must give the CPU's bits too.
fn check_as<C: Case>(pass: &'static PassInfo, case: &C, floats: Floats) {
    match floats {
        Floats::Finite(_) => check_finite(pass, case),
        Floats::Any => check_survival(pass, case),
    }
}

/// All outputs of all backends are finite.
fn check_finite<C: Case>(pass: &'static PassInfo, case: &C) {
    let label = &case.launch().label;
    let mut cpu = Cpu::new(Some(2)).expect("two threads");
    let (bad, first) = non_finite(&outputs(pass, case, &mut cpu));
    assert_eq!(bad, 0, "{}, {label}: not finite, first element {first:?}", pass.name);
    let Some(mut shared) = shared() else { return };
    for variant in shared.strict_variants().into_iter().chain([Variant::Fast]) {
        shared.gpu.set_variant(variant);
        let (bad, first) = non_finite(&outputs(pass, case, &mut shared.gpu));
        assert_eq!(bad, 0, "{}, {label} ({variant:?}): not finite, first element {first:?}", pass.name);
    }
}

/// Nothing breaks, and strict modules give the CPU's bits.
fn check_survival<C: Case>(pass: &'static PassInfo, case: &C) {
    let mut cpu = Cpu::new(Some(2)).expect("two threads");
    let expected = outputs(pass, case, &mut cpu);
    let Some(mut shared) = shared() else { return };
    for variant in shared.strict_variants() {
        shared.gpu.set_variant(variant);
        let got = outputs(pass, case, &mut shared.gpu);
        if !shared.probe.specials {
            announce("SKIPPED: the bits of NaN and infinities, which this device does not keep apart");
            continue;
        }
        let a = compare_elements(pass, &expected, &got);
        let (label, first) = (&case.launch().label, a.first.as_deref().unwrap_or_default());
        assert!(a.is_exact(), "{}, {label} ({variant:?}): {} differ: {first}", pass.name, a.different);
    }
    shared.gpu.set_variant(Variant::Fast);
    outputs(pass, case, &mut shared.gpu);
}

#[test]
fn the_check_sees_what_is_not_finite() {
    let good = [glam::Vec4::ONE, glam::Vec4::splat(3e38)];
    assert_eq!(non_finite(&good), (0, None));
    assert_eq!(
        non_finite(&[glam::Vec4::ONE, glam::Vec4::new(0.0, f32::NAN, f32::INFINITY, 0.0)]),
        (2, Some(1))
    );
    let mut draw = Draw::new("classes");
    let mut values = vec![1.0f32; 4000];
    assert!((300..700).contains(&spoil(&mut values, Floats::Finite(1e18), &mut draw)));
    assert!(values.iter().all(|x| x.abs() <= 1e18) && values.iter().any(|x| x.is_subnormal()));
    spoil(&mut values, Floats::Any, &mut draw);
    assert!(values.iter().any(|x| x.is_nan()) && values.contains(&f32::NEG_INFINITY));
    assert_eq!(spoil(&mut [7u32; 100], Floats::Any, &mut draw), 0);
    assert_eq!(
        spoil(&mut [twinlight_kernels::geometry::bvh::BvhNode::default(); 100], Floats::Any, &mut draw),
        0
    );
}
