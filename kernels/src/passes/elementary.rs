//! Do the elementary functions give the same bits on this device? Also the start-up probe of a device.

use crate::math;

/// Selects the function that [`evaluate_elementary`] evaluates.
pub mod function {
    #![allow(missing_docs)]
    pub const EXP2: u32 = 0;
    pub const EXP: u32 = 1;
    pub const EXP_MINUS_ONE: u32 = 2;
    pub const LOG2: u32 = 3;
    pub const LN: u32 = 4;
    pub const LN_ONE_PLUS: u32 = 5;
    pub const SIN_TURN: u32 = 6;
    pub const COS_TURN: u32 = 7;
    pub const SIN: u32 = 8;
    pub const COS: u32 = 9;
    pub const ACOS: u32 = 10;
    pub const ATAN2: u32 = 11;
    pub const ERF: u32 = 12;
    pub const POW_FAST: u32 = 13;
    pub const POW: u32 = 14;
    pub const RSQRT: u32 = 15;
    pub const SQRT: u32 = 16;
    pub const DIV: u32 = 17;
    pub const FLOOR: u32 = 18;
    /// (x + y) − x: y unless re-associated away.
    pub const ADD_SUBTRACT: u32 = 19;
    /// x·y + x, two roundings unless contracted.
    pub const MULTIPLY_ADD: u32 = 20;
    /// x·y alone, for denormal results.
    pub const MULTIPLY: u32 = 21;
    /// x truncated to a signed integer and back.
    pub const TO_INTEGER: u32 = 22;
    /// Number of functions.
    pub const COUNT: u32 = 23;
}

gpu_struct! {
    /// Parameters of [`evaluate_elementary`].
    pub struct ElementaryParams {
        /// One of [`function`].
        pub function: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

/// Returns the selected function of x\[index\] and y\[index\]; unary functions ignore y, an unknown selection gives 0.
#[inline]
pub fn evaluate_elementary(index: u32, params: &ElementaryParams, x: &[f32], y: &[f32]) -> f32 {
    let a = x[index as usize];
    let b = y[index as usize];
    match params.function {
        function::EXP2 => math::exp2(a),
        function::EXP => math::exp(a),
        function::EXP_MINUS_ONE => math::exp_minus_one(a),
        function::LOG2 => math::log2(a),
        function::LN => math::ln(a),
        function::LN_ONE_PLUS => math::ln_one_plus(a),
        function::SIN_TURN => math::sin_cos_turn(a).0,
        function::COS_TURN => math::sin_cos_turn(a).1,
        function::SIN => math::sin_cos(a).0,
        function::COS => math::sin_cos(a).1,
        function::ACOS => math::acos(a),
        function::ATAN2 => math::atan2(a, b),
        function::ERF => math::erf(a),
        function::POW_FAST => math::pow_fast(a, b),
        function::POW => math::pow(a, b),
        function::RSQRT => math::rsqrt(a),
        function::SQRT => math::sqrt(a),
        function::DIV => math::div(a, b),
        function::FLOOR => math::floor(a),
        function::ADD_SUBTRACT => (a + b) - a,
        function::MULTIPLY_ADD => a * b + a,
        function::MULTIPLY => a * b,
        function::TO_INTEGER => math::to_i32(a) as f32,
        _ => 0.0,
    }
}
