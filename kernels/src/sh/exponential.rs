//! What visibility do many blockers leave whose logarithms were added up?
//!
//! exp*(f) = exp(M_f) 1. All forms here isolate the DC part, exp*(f) = e^(f₀/√4π) exp*(f̂), and bound the result by
//! [`clamp_to_feasible`]: without it 256 blockers at one place give 200 times the whole sky.

use super::basis::{UNIT, is_finite};
use super::product::{product, square};
use crate::math::{clamp, div, exp, exp_minus_one, floor, max, sqrt, to_u32};

/// 1/√(4π).
const FRAC_1_UNIT: f32 = 0.282_094_8;

/// Most halvings; a vector of norm above τ·2¹² is shortened to it.
pub const MAX_HALVINGS: u32 = 12;

/// The largest norm without DC for which [`hybrid`] needs no table.
pub const SMALL_NORM: f32 = 0.5;

/// Coefficients beyond this are moved to it, so that the norm stays finite.
const MAX_COEFFICIENT: f32 = 1e15;

/// Spacing of the optimal-linear table.
const TABLE_STEPS_PER_UNIT: f32 = 20.0;

/// Returns the norm of the coefficients after the first.
#[inline]
pub fn norm_without_dc<const N: usize>(f: &[f32; N]) -> f32 {
    let mut sum = 0.0;
    for i in 1..N {
        sum += f[i] * f[i];
    }
    sqrt(sum)
}

/// Returns g moved into the ball that holds every projection of a function with values in [0, 1].
///
/// 0 ≤ g₀ ≤ √4π and Σ_{i≥1} g_i² ≤ g₀(√4π − g₀), because ∫V² ≤ ∫V; the identity on such projections. A g that is not
/// finite gives 0.
#[inline]
pub fn clamp_to_feasible<const N: usize>(g: &[f32; N]) -> [f32; N] {
    let mut out = [0.0; N];
    if !is_finite(g) {
        return out;
    }
    let dc = clamp(g[0], 0.0, UNIT);
    let limit = dc * (UNIT - dc);
    let mut energy = 0.0;
    for i in 1..N {
        let c = clamp(g[i], -MAX_COEFFICIENT, MAX_COEFFICIENT);
        out[i] = c;
        energy += c * c;
    }
    out[0] = dc;
    if energy > limit {
        // Two roots: the quotient of the squares could underflow.
        let scale = if limit >= f32::MIN_POSITIVE { div(sqrt(limit), sqrt(energy)) } else { 0.0 };
        for i in 1..N {
            out[i] *= scale;
        }
    }
    out
}

/// Returns the visibility exp*(f) by the hybrid of scaling and optimal linear exponential, in the feasible ball.
///
/// f is halved p times until its norm without DC is at most `tau`, exponentiated as a(x) 1 + b(x) f̂, and squared p
/// times. `tau` in [1/16, 0.5] (clamped): 0.5 is at the noise floor of the band limit up to 16 overlapping blockers,
/// 0.25 pays above. Orders 2 to 5. f = 0 gives 1; an f that is not finite counts as fully blocked and gives 0.
/// About 1.2e-7·2^p of √4π against float64: 5e-6 up to p = 5, 1e-4 for p up to 9. SGI §3.
#[inline]
pub fn hybrid<const N: usize>(f: &[f32; N], tau: f32) -> [f32; N] {
    let (h, x, p) = scale_down(f, clamp(tau, 0.0625, SMALL_NORM));
    let (a, b) = small_coefficients::<N>(x);
    square_up(&linear(&h, a, b), p, is_finite(f))
}

/// Returns the same as [`hybrid`] for any `tau` in [1/16, 16]: beyond 0.5 with a and b from a table.
///
/// `table` holds `entries` pairs (a, b) at x = 0, 0.05, 0.1, …, clamped at the end.
#[inline]
pub fn hybrid_with_table<const N: usize>(f: &[f32; N], tau: f32, table: &[f32], entries: u32) -> [f32; N] {
    let (h, x, p) = scale_down(f, clamp(tau, 0.0625, 16.0));
    let (a, b) = coefficients::<N>(x, table, entries);
    square_up(&linear(&h, a, b), p, is_finite(f))
}

/// Returns the optimal linear exponential without squaring *or clamp*: e^(f₀/√4π)(a(x) 1 + b(x) f̂), x = |f̂|.
///
/// Cheapest, and 0.1 off (RMS) from 8 overlapping blockers on. `table` as in [`hybrid_with_table`]. f that is not finite
/// gives 0.
#[inline]
pub fn optimal_linear<const N: usize>(f: &[f32; N], table: &[f32], entries: u32) -> [f32; N] {
    if !is_finite(f) {
        return [0.0; N];
    }
    let (a, b) = coefficients::<N>(norm_without_dc(&bounded(f)), table, entries);
    linear(&bounded(f), a, b)
}

/// Returns the visibility exp*(f) by scaling and the series 1 + f̂ + f̂f̂/2, in the feasible ball: no table.
///
/// `tau` in [1/16, 1]: at 1 it costs what [`hybrid`] costs at 0.5 and is nearer to the exact exponential.
#[inline]
pub fn taylor<const N: usize>(f: &[f32; N], tau: f32) -> [f32; N] {
    let (h, _, p) = scale_down(f, clamp(tau, 0.0625, 1.0));
    let mut rest = h;
    rest[0] = 0.0;
    let second = square(&rest);
    let e = dc_factor(h[0]);
    let mut g = [0.0; N];
    for i in 0..N {
        g[i] = e * (rest[i] + 0.5 * second[i]);
    }
    g[0] = e * (UNIT + 0.5 * second[0]);
    square_up(&g, p, is_finite(f))
}

/// Returns the visibility exp*(f) by the first `terms` terms of the product series, in the feasible ball.
///
/// Σ f̂^k/k! for k < `terms` (1 to 16, clamped), with `terms` − 2 products. Diverges for many blockers: nine terms are
/// 0.34 off (RMS) at 32.
#[inline]
pub fn product_series<const N: usize>(f: &[f32; N], terms: u32) -> [f32; N] {
    let mut rest = bounded(f);
    let e = dc_factor(rest[0]);
    rest[0] = 0.0;
    let mut power = [0.0; N];
    power[0] = UNIT;
    let mut sum = power;
    let terms = if terms > 16 { 16 } else { terms };
    for k in 1..terms {
        let inverse = div(1.0, k as f32);
        power = if k == 1 { rest } else { product(&power, &rest) };
        for i in 0..N {
            power[i] *= inverse;
            sum[i] += power[i];
        }
    }
    for i in 0..N {
        sum[i] *= e;
    }
    square_up(&sum, 0, is_finite(f))
}

/// Returns √4π − g₀ for g = [`hybrid`]`(f, tau)`, or with a table and any `tau` (small norms have none of it): what all blockers cover,
/// without cancellation for small ones.
///
/// 3e-6 relative for one blocker of α ≤ 0.2 up to order 4, 7e-6 in order 5, where the difference has lost up to 8e-4. SGI eq. 12 divides by it.
#[inline]
pub fn occluded_dc<const N: usize>(f: &[f32; N], g: &[f32; N], tau: f32) -> f32 {
    let (h, x, p) = scale_down(f, clamp(tau, 0.0625, SMALL_NORM));
    let precise = {
        let (excess, _) = small_excess::<N>(x);
        UNIT * (-exp_minus_one(clamp(h[0] * FRAC_1_UNIT, -100.0, 20.0)) - dc_factor(h[0]) * excess)
    };
    if p == 0 && is_finite(f) { clamp(precise, 0.0, UNIT) } else { clamp(UNIT - g[0], 0.0, UNIT) }
}

/// f with every coefficient finite and at most 1e15.
#[inline]
fn bounded<const N: usize>(f: &[f32; N]) -> [f32; N] {
    let mut out = [0.0; N];
    for i in 0..N {
        out[i] = clamp(f[i], -MAX_COEFFICIENT, MAX_COEFFICIENT);
    }
    out
}

/// (f·2^−p, its norm without DC, p) with the smallest p that brings the norm to `tau` or less.
#[inline]
fn scale_down<const N: usize>(f: &[f32; N], tau: f32) -> ([f32; N], f32, u32) {
    let mut h = bounded(f);
    let mut x = norm_without_dc(&h);
    let mut p = 0;
    let mut scale = 1.0;
    for _ in 0..MAX_HALVINGS {
        if x > tau {
            x *= 0.5;
            scale *= 0.5;
            p += 1;
        }
    }
    for i in 0..N {
        h[i] *= scale;
    }
    if x > tau {
        let shorten = div(tau, x);
        for i in 1..N {
            h[i] *= shorten;
        }
        x = tau;
    }
    (h, x, p)
}

/// g squared p times, moved into the feasible ball before the first and after every square; 0 unless `valid`.
#[inline]
fn square_up<const N: usize>(g: &[f32; N], p: u32, valid: bool) -> [f32; N] {
    if !valid {
        return [0.0; N];
    }
    let mut g = clamp_to_feasible(g);
    for _ in 0..p {
        g = clamp_to_feasible(&square(&g));
    }
    g
}

/// e^(f₀/√4π), at most e²⁰: visibility has f₀ ≤ 0, and the clamp makes 1 of anything larger.
#[inline]
fn dc_factor(dc: f32) -> f32 {
    exp(clamp(dc * FRAC_1_UNIT, -100.0, 20.0))
}

/// e^(h₀/√4π)(a 1 + b ĥ).
#[inline]
fn linear<const N: usize>(h: &[f32; N], a: f32, b: f32) -> [f32; N] {
    let e = dc_factor(h[0]);
    let scale = e * b;
    let mut g = [0.0; N];
    for i in 1..N {
        g[i] = scale * h[i];
    }
    g[0] = e * (a * UNIT);
    g
}

/// (a, b) of the optimal linear exponential at any norm x: polynomials up to 0.5, the table beyond.
#[inline]
fn coefficients<const N: usize>(x: f32, table: &[f32], entries: u32) -> (f32, f32) {
    if x <= SMALL_NORM || entries < 2 || (table.len() as u32) < 2 * entries {
        return small_coefficients::<N>(if x < SMALL_NORM { x } else { SMALL_NORM });
    }
    let position = clamp(x * TABLE_STEPS_PER_UNIT, 0.0, (entries - 1) as f32);
    let nearest = to_u32(floor(position));
    let entry = if nearest < entries - 2 { nearest } else { entries - 2 };
    let fraction = position - entry as f32;
    let start = 2 * entry as usize;
    (
        table[start] + fraction * (table[start + 2] - table[start]),
        table[start + 1] + fraction * (table[start + 3] - table[start + 1]),
    )
}

/// (a, b) for x ≤ 0.5.
#[inline]
fn small_coefficients<const N: usize>(x: f32) -> (f32, f32) {
    let (a, b) = small_excess::<N>(x);
    (1.0 + a, 1.0 + b)
}

/// (a − 1, b − 1) for x ≤ 0.5: a = 1 + x²(1/(8π) + x(c₃ + x c₄)), b = 1 + x(b₁ + x(b₂ + x b₃)).
///
/// Fitted to the family of single caps, to 3e-6 and 4e-5; order 2 is exact up to x⁶: a = cosh(x/√4π), b = sinh/….
#[inline]
fn small_excess<const N: usize>(x: f32) -> (f32, f32) {
    const { assert!(N == 4 || N == 9 || N == 16 || N == 25) };
    let (c3, c4, b1, b2, b3) = if const { N == 4 } {
        (0.0, 2.638_573e-4, 0.0, 0.013_262_912, 0.0)
    } else if const { N == 9 } {
        (-0.004165, 0.000319, -0.156730, 0.017518, 0.002318)
    } else if const { N == 16 } {
        (-0.006951, 0.000425, -0.260291, 0.018923, 0.017607)
    } else {
        (-0.009653, 0.000931, -0.360671, 0.038317, 0.031593)
    };
    let x = max(x, 0.0);
    ((x * x) * (0.039_788_734 + x * (c3 + x * c4)), x * (b1 + x * (b2 + x * b3)))
}
