//! How are the elementary functions built so that every backend rounds alike?
//!
//! Only add, subtract, multiply, comparisons, conversions and integer operations, in one fixed order.
//! The polynomials are minimax fits over the reduced interval; the hex constants are their exact bits.

// Constants are written with the digits that they are derived from; the golden bits hold them.
#![allow(clippy::excessive_precision)]

mod basics;
mod division;
mod error_function;
mod exponential;
mod logarithm;
mod power;
mod root;
mod trigonometry;

pub use basics::{
    MIN_POSITIVE, abs, clamp, copy_sign, exp2_integer, floor, is_finite, is_nan, max, min, min_u32, saturate,
    to_i32, to_u32,
};
pub use division::{div_software, two_product, two_sum};
pub use error_function::erf;
pub use exponential::{exp, exp_minus_one, exp2};
pub use logarithm::{ln, ln_one_plus, log2};
pub use power::{pow, pow_fast, powi};
pub use root::{rsqrt, sqrt, sqrt_software};
pub use trigonometry::{acos, atan2, sin_cos, sin_cos_turn};

/// The f32 with these bits, for polynomial tables.
const fn f(bits: u32) -> f32 {
    f32::from_bits(bits)
}
