//! Is every elementary function finite where its true value is, over bit patterns of all classes?

// Oracles may use what kernels may not.
#![allow(clippy::disallowed_methods, clippy::neg_cmp_op_on_partial_ord, clippy::zero_divided_by_zero)]

use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use twinlight_kernels::math::strict;

/// A function of two numbers, the true value, and what else it promises.
type Function = (&'static str, fn(f32, f32) -> f32, fn(f64, f64) -> f64);

/// Outside their domains functions give what their documentation says; see [`documented`].
fn functions() -> Vec<Function> {
    vec![
        ("exp2", |x, _| strict::exp2(x), |x, _| x.exp2()),
        ("exp", |x, _| strict::exp(x), |x, _| x.exp()),
        ("exp_minus_one", |x, _| strict::exp_minus_one(x), |x, _| x.exp_m1()),
        ("log2", |x, _| strict::log2(x), |x, _| x.log2()),
        ("ln", |x, _| strict::ln(x), |x, _| x.ln()),
        ("ln_one_plus", |x, _| strict::ln_one_plus(x), |x, _| x.ln_1p()),
        ("sin_turn", |x, _| strict::sin_cos_turn(x).0, |x, _| (x * std::f64::consts::TAU).sin()),
        ("cos_turn", |x, _| strict::sin_cos_turn(x).1, |x, _| (x * std::f64::consts::TAU).cos()),
        ("sin", |x, _| strict::sin_cos(x).0, |x, _| x.sin()),
        ("cos", |x, _| strict::sin_cos(x).1, |x, _| x.cos()),
        ("acos", |x, _| strict::acos(x), |x, _| x.clamp(-1.0, 1.0).acos()),
        ("erf", |x, _| strict::erf(x), |_, _| 1.0),
        ("atan2", strict::atan2, f64::atan2),
        ("pow", strict::pow, f64::powf),
        ("pow_fast", strict::pow_fast, f64::powf),
        ("rsqrt", |x, _| strict::rsqrt(x), |x, _| x.sqrt().recip()),
        ("sqrt", |x, _| strict::sqrt(x), |x, _| x.sqrt()),
        ("quotient", strict::div_software, |x, y| x / y),
    ]
}

/// Results where the true value is none, infinite, or beyond f32.
fn documented(name: &str, x: f32, y: f32, got: f32) -> bool {
    match name {
        // Their largest argument is the largest finite value, or a NaN has none.
        "sin_turn" | "cos_turn" | "sin" | "cos" | "acos" | "atan2" | "rsqrt" => got.is_finite(),
        // 2⁻¹²⁶ stands for what is not above 0.
        "log2" | "ln" if x < f32::MIN_POSITIVE => got.is_finite() && got < -80.0,
        "log2" | "ln" => x.is_nan() && got.is_nan() || x.is_infinite() && got > 80.0,
        "ln_one_plus" if x <= -1.0 => {
            got.is_finite() && got < -10.0 || got.is_nan() || got == f32::NEG_INFINITY
        }
        "sqrt" => got.is_nan() && !(x >= 0.0) || got == x || x.abs() < f32::MIN_POSITIVE && got < 1.1e-19,
        // Operands below 2⁻¹²⁶ count as 0.
        "quotient" => !got.is_finite() || got == 0.0 || got.abs() > 3.39e38,
        "pow" | "pow_fast" => !got.is_nan() || !x.is_finite() || !y.is_finite() || x < 0.0,
        _ => x.is_nan() && got.is_nan() || !got.is_nan(),
    }
}

fn check((name, function, truth): &Function, x: f32, y: f32) -> Result<(), TestCaseError> {
    let y = if matches!(*name, "atan2" | "pow" | "pow_fast" | "quotient") { y } else { 1.0 };
    let got = function(x, y);
    let right = truth(f64::from(x), f64::from(y));
    let small = |v: f32| v != 0.0 && v.abs() < f32::MIN_POSITIVE;
    // The largest error of any of them is far below a thousandth.
    let within = right.abs() < 0.999 * f64::from(f32::MAX);
    let usual = within && x.is_finite() && y.is_finite() && !small(x) && !small(y);
    let fine = match *name {
        "log2" | "ln" if !(x >= f32::MIN_POSITIVE) => documented(name, x, y, got),
        "quotient" if y == 0.0 => documented(name, x, y, got),
        "pow" | "pow_fast" if !(x >= f32::MIN_POSITIVE) => documented(name, x, y, got),
        _ if usual => got.is_finite(),
        _ => documented(name, x, y, got),
    };
    prop_assert!(fine, "{name}({x:e} {:#010x}, {y:e}) = {got:e}, truly {right:e}", x.to_bits());
    Ok(())
}

/// Any bit pattern; the classes that are rare among them often.
fn any_float() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => any::<u32>().prop_map(f32::from_bits),
        2 => any::<u32>().prop_map(|bits| f32::from_bits(bits & 0x807F_FFFF)),
        2 => (0x3F00_0000u32..0x4200_0000, any::<bool>()).prop_map(|(b, s)| f32::from_bits(b | u32::from(s) << 31)),
        1 => proptest::sample::select(vec![
            0.0, -0.0, 1.0, -1.0, f32::MIN_POSITIVE, f32::MAX, f32::MIN, f32::INFINITY, f32::NEG_INFINITY, f32::NAN,
            f32::from_bits(0xFFC1_2345), f32::from_bits(1), f32::from_bits(0x8000_0001), 88.722_84, -87.4, 128.0,
        ]),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300_000, failure_persistence: None, rng_seed: RngSeed::Fixed(20_261_126), ..ProptestConfig::default() })]
    #[test]
    fn all_classes_give_finite_or_documented_results(x in any_float(), y in any_float()) {
        for function in &functions() {
            check(function, x, y)?;
        }
    }
}

#[test]
fn the_check_objects_to_naive_forms() {
    let naive: [Function; 3] = [
        ("acos", |x, _| x.acos(), |x, _| x.clamp(-1.0, 1.0).acos()),
        ("rsqrt", |x, _| 1.0 / x.sqrt(), |x, _| x.sqrt().recip()),
        ("exp_minus_one", |x, _| (x as f64).exp().powi(2) as f32, |x, _| x.exp_m1()),
    ];
    let inputs: [(f32, f32); 3] = [(1.000_001, 0.0), (0.0, 0.0), (80.0, 0.0)];
    for (function, (x, y)) in naive.iter().zip(inputs) {
        assert!(check(function, x, y).is_err(), "{}", function.0);
    }
}
