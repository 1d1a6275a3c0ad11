//! What do a receiver's proxies leave of the surroundings? SGI eq. 4.

use super::receiver::Receiver;
use super::{HYBRID, OPTIMAL_LINEAR, SERIES, SoftParams, SphereProxy};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::clamp;
use crate::passes::evaluate_sh::{ShVector, load, store};
use crate::passes::surface::Surface;
use crate::sh::{self, UNIT};

/// The sum over the receiver's proxies.
#[inline]
fn logarithms<const N: usize, const B: usize>(
    index: u32,
    params: &SoftParams,
    s: &Surface,
    proxies: &[SphereProxy],
    starts: &[u32],
    counts: &[u32],
    lists: &[u32],
    table: &[f32],
) -> ShVector {
    let receiver = Receiver::new(index, params, s, starts, counts);
    let least = sh::influence_key(params.shadow_reach);
    let mut sum = [0.0; N];
    for k in 0..receiver.count {
        let met = receiver.met(params, proxies[receiver.number(k, lists) as usize].sphere);
        let weight = met.weight(least);
        if weight > 0.0 {
            let zonal = sh::log_occlusion::<B>(table, params.entries, met.key);
            let turned = sh::rotate_zonal::<B, N>(&zonal, met.blocker.direction);
            sum = sh::add_scaled(&sum, &turned, weight);
        }
    }
    store(&sum)
}

/// Returns the sum of the logarithms of the visibility past each proxy of receiver `index`.
///
/// `table` is that of [`log_occlusion`](sh::log_occlusion) for `params.order` bands.
#[inline]
pub fn accumulate_occlusion(
    index: u32,
    params: &SoftParams,
    surfaces: &[Surface],
    proxies: &[SphereProxy],
    starts: &[u32],
    counts: &[u32],
    lists: &[u32],
    table: &[f32],
) -> ShVector {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return store(&[0.0; 4]);
    }
    match params.order {
        2 => logarithms::<4, 2>(index, params, s, proxies, starts, counts, lists, table),
        3 => logarithms::<9, 3>(index, params, s, proxies, starts, counts, lists, table),
        4 => logarithms::<16, 4>(index, params, s, proxies, starts, counts, lists, table),
        _ => logarithms::<25, 5>(index, params, s, proxies, starts, counts, lists, table),
    }
}

/// The product over the receiver's proxies, each of which covers `weight` of its cap, in the feasible ball after each.
#[inline]
fn chain<const N: usize, const B: usize>(
    index: u32,
    params: &SoftParams,
    s: &Surface,
    proxies: &[SphereProxy],
    starts: &[u32],
    counts: &[u32],
    lists: &[u32],
) -> ShVector {
    let receiver = Receiver::new(index, params, s, starts, counts);
    let least = sh::influence_key(params.shadow_reach);
    let mut seen = [0.0; N];
    seen[0] = UNIT;
    // Of small proxies √4π − g₀ would have lost its digits.
    let mut covered = 0.0;
    for k in 0..receiver.count {
        let met = receiver.met(params, proxies[receiver.number(k, lists) as usize].sphere);
        let (b, weight) = (met.blocker, met.weight(least));
        if weight > 0.0 {
            let cap = sh::rotate_zonal::<B, N>(&sh::cap::<B>(b.alpha), b.direction);
            let taken = sh::product(&seen, &cap);
            covered += weight * taken[0];
            seen = sh::clamp_to_feasible(&sh::add_scaled(&seen, &taken, -weight));
        }
    }
    let mut out = store(&seen);
    out.c24.w = clamp(covered, 0.0, UNIT);
    out
}

/// Returns the visibility of receiver `index` as the product of that past each of its proxies, in the order of their numbers; w of
/// `c24` is what they cover of the first coefficient. A product for each proxy, and no table: what exponentials of sums stand for.
#[inline]
pub fn multiply_visibility(
    index: u32,
    params: &SoftParams,
    surfaces: &[Surface],
    proxies: &[SphereProxy],
    starts: &[u32],
    counts: &[u32],
    lists: &[u32],
) -> ShVector {
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return store(&[UNIT, 0.0, 0.0, 0.0]);
    }
    match params.order {
        2 => chain::<4, 2>(index, params, s, proxies, starts, counts, lists),
        3 => chain::<9, 3>(index, params, s, proxies, starts, counts, lists),
        4 => chain::<16, 4>(index, params, s, proxies, starts, counts, lists),
        _ => chain::<25, 5>(index, params, s, proxies, starts, counts, lists),
    }
}

/// The visibility of a sum of logarithms; the last number is what is covered of the first coefficient.
#[inline]
fn visibility<const N: usize>(params: &SoftParams, f: &[f32; N], table: &[f32]) -> ShVector {
    let g = if params.exponential == HYBRID {
        sh::hybrid_with_table(f, params.tau, table, params.pairs)
    } else if params.exponential == OPTIMAL_LINEAR {
        sh::clamp_to_feasible(&sh::optimal_linear(f, table, params.pairs))
    } else if params.exponential == SERIES {
        sh::product_series(f, params.terms)
    } else {
        sh::taylor(f, params.tau)
    };
    let covered = if params.exponential == HYBRID { sh::occluded_dc(f, &g, params.tau) } else { UNIT - g[0] };
    let mut out = store(&g);
    out.c24.w = covered;
    out
}

/// Returns the visibility of receiver `index` in order 2; w of `c24` is √4π less its first coefficient.
#[inline]
pub fn exponentiate2(index: u32, params: &SoftParams, logarithms: &[ShVector], table: &[f32]) -> ShVector {
    visibility(params, &load::<4>(&logarithms[index as usize]), table)
}

/// Returns the same in order 3.
#[inline]
pub fn exponentiate3(index: u32, params: &SoftParams, logarithms: &[ShVector], table: &[f32]) -> ShVector {
    visibility(params, &load::<9>(&logarithms[index as usize]), table)
}

/// Returns the same in order 4.
#[inline]
pub fn exponentiate4(index: u32, params: &SoftParams, logarithms: &[ShVector], table: &[f32]) -> ShVector {
    visibility(params, &load::<16>(&logarithms[index as usize]), table)
}

/// Returns the same in order 5.
#[inline]
pub fn exponentiate5(index: u32, params: &SoftParams, logarithms: &[ShVector], table: &[f32]) -> ShVector {
    visibility(params, &load::<25>(&logarithms[index as usize]), table)
}
