//! Which voxels do the coarse pixels around a pixel see, and with which weights? VF eq. 5.

use super::gather_voxels::GatherVoxelsParams;
use super::list::{LIST_HEADER, ListHeader, list_stride};
use crate::gaussian::gathering_weights;
use crate::math::{div, dot, max};
use crate::passes::surface::Surface;
use crate::passes::upsample::{Footprint, footprint};
use glam::Vec3;

/// The lists of four coarse pixels, merged.
pub(super) struct Lists {
    at: [u32; 4],
    end: [u32; 4],
    /// Weight of one listed voxel.
    weight: [f32; 4],
    /// Weight of one ray that met it.
    per_ray: [f32; 4],
    /// Rays that the counts are out of, weighted.
    pub(super) rays: f32,
    /// The share of them that met anything.
    pub(super) met: f32,
}

/// A voxel that some of the lists name.
pub(super) struct Member {
    pub(super) voxel: u32,
    /// Sum of the weights of the lists that name it.
    pub(super) weight: f32,
    /// Sum of the weights of the rays that met it.
    pub(super) share: f32,
}

/// No voxel is left.
pub(super) const DONE: u32 = 0xFFFF_FFFF;

impl Lists {
    #[inline]
    pub(super) fn new(
        params: &GatherVoxelsParams,
        cells: &Footprint,
        weights: &[f32; 4],
        lists: &[u32],
    ) -> Self {
        let stride = list_stride(params.capacity);
        let mut all =
            Self { at: [0; 4], end: [0; 4], weight: [0.0; 4], per_ray: [0.0; 4], rays: 0.0, met: 0.0 };
        for k in 0..4 {
            let first = cells.pixels[k] * stride;
            let (rays, kept, dropped) =
                (lists[first as usize], lists[(first + 1) as usize], lists[(first + 2) as usize]);
            let met = lists[(first + 3) as usize];
            if weights[k] > 0.0 {
                all.at[k] = first + LIST_HEADER;
                all.end[k] = first + LIST_HEADER + 2 * kept;
                // The voxels that are kept stand for those without room.
                all.weight[k] = if dropped == 0 {
                    weights[k]
                } else {
                    weights[k] * div((kept + dropped) as f32, max(kept as f32, 1.0))
                };
                all.per_ray[k] = div(weights[k], max(rays as f32, 1.0));
                all.rays += weights[k] * (rays as f32);
                all.met += all.per_ray[k] * (met as f32);
            }
        }
        all
    }

    /// Takes the lowest voxel that is left.
    #[inline]
    pub(super) fn take(&mut self, lists: &[u32]) -> Member {
        let mut lowest = DONE;
        for k in 0..4 {
            if self.at[k] < self.end[k] {
                let voxel = lists[self.at[k] as usize] - 1;
                lowest = if voxel < lowest { voxel } else { lowest };
            }
        }
        let mut member = Member { voxel: lowest, weight: 0.0, share: 0.0 };
        for k in 0..4 {
            if self.at[k] < self.end[k] && lists[self.at[k] as usize] - 1 == lowest {
                member.weight += self.weight[k];
                member.share += self.per_ray[k] * (lists[(self.at[k] + 1) as usize] as f32);
                self.at[k] += 2;
            }
        }
        member
    }
}

/// Weights of the four coarse pixels, VF eq. 5 w_G·w_l over their sum; all 0 where none has a surface.
#[inline]
pub(super) fn weights(
    params: &GatherVoxelsParams,
    cells: &Footprint,
    s: &Surface,
    headers: &[ListHeader],
) -> [f32; 4] {
    let mut distance = [0.0; 4];
    let mut normal = [Vec3::ZERO; 4];
    for k in 0..4 {
        let h = &headers[cells.pixels[k] as usize];
        if h.position.w >= 0.0 {
            distance[k] = dot(h.position.truncate() - s.position.truncate(), s.normal.truncate());
            normal[k] = h.normal.truncate();
        }
    }
    let deviation = params.depth_deviation * s.position.w;
    gathering_weights(
        &cells.bilinear,
        &distance,
        &normal,
        s.normal.truncate(),
        deviation,
        params.normal_deviation,
    )
}

/// The coarse pixels around pixel `index`.
#[inline]
pub(super) fn cells(index: u32, params: &GatherVoxelsParams) -> Footprint {
    let pixel = params.first_pixel + index;
    footprint(
        pixel % params.width,
        pixel / params.width,
        params.scale_x,
        params.scale_y,
        params.coarse_width,
        params.coarse_height,
    )
}
