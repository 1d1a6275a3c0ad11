//! How much does light from a direction off the reflection vector count for a glossy surface?

use crate::math::{clamp, div, dot, exp, exp_minus_one, ln_one_plus, max, saturate};
use glam::Vec3;

/// The narrowest σ_θ; narrower lobes count as this one.
pub const MIN_DEVIATION: f32 = 1e-3;

/// 1/√(2π).
const FRAC_1_SQRT_2_PI: f32 = 0.398_942_3;

/// Returns 1 − cos of the angle between two unit vectors, as |a − b|²/2: exact digits for small angles.
///
/// From an f32 cosine the same has 5 % error at 1e-3 rad and none left at 1e-4.
#[inline]
pub fn one_minus_cosine(a: Vec3, b: Vec3) -> f32 {
    let d = a - b;
    0.5 * dot(d, d)
}

/// Returns x = 1 − cosⁿ θ from 1 − cos θ: 0 on the axis, 1 from 90° on.
///
/// Evaluated as −expm1(n·log1p(−(1 − cos θ))): 4e-7 relative. n ≥ 0 (negative and NaN count as 0, where x = 0);
/// negative cosines count as 0: even powers would mirror the lobe, fractional ones give NaN.
#[inline]
pub fn lobe_offset(one_minus_cosine: f32, exponent: f32) -> f32 {
    let exponent = clamp(exponent, 0.0, 1e18);
    let gap = saturate(one_minus_cosine);
    if exponent <= 0.0 {
        return 0.0;
    }
    if gap >= 1.0 {
        return 1.0;
    }
    -exp_minus_one(exponent * ln_one_plus(-gap))
}

/// Returns exp(−x²/(2σ²)) with x = 1 − cosⁿ θ: the weight of VF eq. 7 without its constant, in (0, 1].
///
/// For sums that are divided by the sum of weights, where the constant cancels and would overflow as σ → 0. σ is
/// clamped to [1e-3, 1e18] (1e-3 for NaN), the exponent to ≥ −87, so the weight never vanishes. It does not at 90° and
/// behind either: exp(−1/(2σ²)) is 0.004 at σ = 0.3 but 0.61 at σ = 1, so multiply by a facing test for σ > 0.3.
/// 1e-6 + 4e-7·x²/(2σ²) relative: 1e-5 down to weights of 1e-10.
#[inline]
pub fn specular_falloff(one_minus_cosine: f32, exponent: f32, deviation: f32) -> f32 {
    let q = div(lobe_offset(one_minus_cosine, exponent), clamp(deviation, MIN_DEVIATION, 1e18));
    exp(max(-0.5 * (q * q), -87.0))
}

/// Returns the weight of VF eq. 7: exp(−x²/(2σ²))/(σ√(2π)), in (0, 1/(σ√(2π))]. Ranges as [`specular_falloff`].
#[inline]
pub fn specular_weight(one_minus_cosine: f32, exponent: f32, deviation: f32) -> f32 {
    let peak = div(FRAC_1_SQRT_2_PI, clamp(deviation, MIN_DEVIATION, 1e18));
    peak * specular_falloff(one_minus_cosine, exponent, deviation)
}
