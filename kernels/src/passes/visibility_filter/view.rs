//! What do the proxies themselves look like? VF figure 1.

use super::grid::GridParams;
use super::march::{NO_VOXEL, ProxyRay, trace_proxies};
use super::proxy::Proxy;
use crate::math::dot;
use crate::passes::surface::{CameraParams, pixel_direction};
use glam::Vec4;

/// Returns the radiance of the disc that pixel `index` of the band sees, 0 where it sees none; w says which.
///
/// `grid` has one element; `radiance` is that of each proxy's front and back.
#[inline]
pub fn draw_proxies(
    index: u32,
    params: &CameraParams,
    grid: &[GridParams],
    starts: &[u32],
    pairs: &[u32],
    proxies: &[Proxy],
    radiance: &[Vec4],
) -> Vec4 {
    let direction = pixel_direction(index, params);
    let ray = ProxyRay { origin: params.eye.truncate(), direction, side: 0.0 };
    let hit = trace_proxies(&grid[0], starts, pairs, proxies, &ray);
    if hit.proxy == NO_VOXEL {
        return Vec4::ZERO;
    }
    let behind = dot(proxies[hit.proxy as usize].normal.truncate(), direction) > 0.0;
    let side = if behind { 1 } else { 0 };
    radiance[(2 * hit.proxy + side) as usize].truncate().extend(1.0)
}
