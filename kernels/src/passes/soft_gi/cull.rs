//! Which proxies reach which receivers? SGI §4.1, by tiles instead of splats.

use super::{SoftParams, SphereProxy};
use crate::geometry::bvh::NO_TRIANGLE;
use crate::math::{dot, max, min};
use crate::passes::Accumulate;
use crate::passes::surface::Surface;
use glam::{Vec3, Vec4};

/// Returns the lower (even `index`) or upper corner of the box around the receivers of tile `index`/2; w is 1, 0 for a
/// tile without any.
#[inline]
pub fn tile_bounds(index: u32, params: &SoftParams, surfaces: &[Surface]) -> Vec4 {
    let tile = index / 2;
    let sign = if index & 1 == 0 { 1.0 } else { -1.0 };
    let row = tile / params.tiles_x;
    let (left, top) = ((tile - row * params.tiles_x) * params.tile, row * params.tile);
    let mut corner = Vec3::splat(1.0e30);
    let mut any = 0.0;
    for k in 0..params.tile * params.tile {
        let (x, y) = (left + k % params.tile, top + k / params.tile);
        if x < params.width && y < params.height {
            let s = &surfaces[(y * params.width + x) as usize];
            if s.triangle != NO_TRIANGLE {
                let p = s.position.truncate() * sign;
                corner = Vec3::new(min(corner.x, p.x), min(corner.y, p.y), min(corner.z, p.z));
                any = 1.0;
            }
        }
    }
    (corner * sign).extend(any)
}

/// Whether a proxy's sphere of influence meets the box of a tile's receivers.
#[inline]
fn reaches(params: &SoftParams, tile: u32, bounds: &[Vec4], proxy: &SphereProxy) -> bool {
    let (lower, upper) = (bounds[(2 * tile) as usize], bounds[(2 * tile + 1) as usize]);
    let centre = proxy.sphere.truncate();
    let nearest = Vec3::new(
        max(min(centre.x, upper.x), lower.x),
        max(min(centre.y, upper.y), lower.y),
        max(min(centre.z, upper.z), lower.z),
    );
    let offset = nearest - centre;
    // A little more, so that rounding does not cut what the smooth weight leaves.
    let reach = proxy.sphere.w * (max(params.shadow_reach, params.light_reach) * 1.001);
    lower.w > 0.0 && dot(offset, offset) <= reach * reach
}

/// Returns how many proxies reach tile `index`.
#[inline]
pub fn tile_counts(index: u32, params: &SoftParams, bounds: &[Vec4], proxies: &[SphereProxy]) -> u32 {
    let mut count = 0;
    for number in 0..params.proxies {
        if reaches(params, index, bounds, &proxies[number as usize]) {
            count += 1;
        }
    }
    count
}

/// Writes the numbers of the proxies that reach tile `index`, in order, from its start on.
#[inline]
pub fn tile_lists(
    index: u32,
    params: &SoftParams,
    bounds: &[Vec4],
    proxies: &[SphereProxy],
    starts: &[u32],
    output: &mut impl Accumulate,
) {
    let mut at = starts[index as usize];
    for number in 0..params.proxies {
        if reaches(params, index, bounds, &proxies[number as usize]) {
            output.or(at, number);
            at += 1;
        }
    }
}

/// The tile of receiver `index`.
#[inline]
pub(super) fn tile_of(index: u32, params: &SoftParams) -> u32 {
    let row = index / params.width;
    (row / params.tile) * params.tiles_x + (index - row * params.width) / params.tile
}
