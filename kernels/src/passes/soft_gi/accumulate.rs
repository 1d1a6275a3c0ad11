//! What do a receiver's proxies leave of the surroundings? SGI eq. 4.

use super::cull::tile_of;
use super::{HYBRID, OPTIMAL_LINEAR, SERIES, SoftParams, SphereProxy};
use crate::geometry::bvh::NO_TRIANGLE;
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
    let tile = tile_of(index, params);
    let (first, count) = (starts[tile as usize], counts[tile as usize]);
    let (p, n) = (s.position.truncate(), s.normal.truncate());
    let least = sh::influence_key(params.shadow_reach);
    let mut sum = [0.0; N];
    for k in 0..count {
        let sphere = proxies[lists[(first + k) as usize] as usize].sphere;
        let b = sh::blocker(sphere.truncate(), sphere.w, p, n, params.fade);
        let u = sh::occlusion_key(b.alpha);
        let weight = b.weight * sh::influence_weight(u, least, 2.0);
        if weight > 0.0 {
            let zonal = sh::log_occlusion::<B>(table, params.entries, u);
            let turned = sh::rotate_zonal::<B, N>(&zonal, b.direction);
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

/// The visibility of a sum of logarithms; the last number is what is covered of the first coefficient.
#[inline]
fn visibility<const N: usize>(params: &SoftParams, f: &[f32; N], table: &[f32]) -> ShVector {
    let g = if params.exponential == HYBRID {
        sh::hybrid(f, params.tau)
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
