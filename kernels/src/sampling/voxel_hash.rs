//! Which number does a voxel have, and in which voxel is a point?

use crate::math::{floor, to_u32};
use glam::{UVec3, Vec3};

/// Returns z·Dx·Dy + y·Dx + x, the number of a voxel of a grid with `dims` voxels (VF eq. 1).
///
/// Injective for voxels of the grid if [`fits_u32`]; at most 1625³ voxels.
#[inline]
pub fn encode(voxel: UVec3, dims: UVec3) -> u32 {
    voxel.z.wrapping_mul(dims.y).wrapping_add(voxel.y).wrapping_mul(dims.x).wrapping_add(voxel.x)
}

/// Returns the voxel with this number, the inverse of [`encode`]; a `dims` of 0 counts as 1.
#[inline]
pub fn decode(number: u32, dims: UVec3) -> UVec3 {
    let width = if dims.x == 0 { 1 } else { dims.x };
    let height = if dims.y == 0 { 1 } else { dims.y };
    let row = number / width;
    let layer = row / height;
    UVec3::new(number - row * width, row - layer * height, layer)
}

/// Returns whether every voxel of the grid has a number of its own: Dx·Dy·Dz ≤ 2³² − 1. For the host.
#[cfg(not(target_arch = "spirv"))]
#[inline]
pub fn fits_u32(dims: UVec3) -> bool {
    // A product of two cannot overflow u64, and is 0 only for grids without voxels.
    let plane = u64::from(dims.x) * u64::from(dims.y);
    plane == 0 || dims.z == 0 || plane <= u64::from(u32::MAX) / u64::from(dims.z)
}

/// Returns the voxel that holds a point; points outside count to the nearest voxel of the grid.
///
/// `inverse_size` is 1/(voxel edge), rounded once by the host. Borders belong to the voxel above, the
/// grid's upper border to the last voxel. NaN counts as the lower border; `dims` of 0 gives voxel 0. Exact
/// below 2²⁴ voxels per axis.
#[inline]
pub fn voxel_of(point: Vec3, lower: Vec3, inverse_size: Vec3, dims: UVec3) -> UVec3 {
    let p = (point - lower) * inverse_size;
    UVec3::new(cell_of(p.x, dims.x), cell_of(p.y, dims.y), cell_of(p.z, dims.z))
}

#[inline]
fn cell_of(x: f32, count: u32) -> u32 {
    // Floor first: a cast truncates −0.5 to 0, which only the clamp happens to want.
    let cell = to_u32(floor(x));
    if count == 0 {
        0
    } else if cell < count {
        cell
    } else {
        count - 1
    }
}
