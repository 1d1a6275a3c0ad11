//! What do the voxels of a level look like from the camera?

use super::{Lit, Pyramid};
use crate::backend::{Backend, BackendError};
use crate::technique::gbuffer::bands;
use crate::technique::{Inspection, Job, View};
use glam::{Vec3, Vec4};
use twinlight_kernels::passes::elements::VoxelViewParams;
use twinlight_kernels::passes::voxel_cones::storage::storage_of;
use twinlight_kernels::passes::voxel_cones::view::{VIEW_LOBES, VIEW_RADIANCE};

/// Dumps that show voxels; `@` and a level after the name draws the voxels of that level, 0 without.
///
/// `voxels` is their radiance toward the eye, `occlusion` their opacity, `lobes` the mean normal of what they mirror.
pub const VOXEL_VIEWS: [&str; 3] = ["voxels", "occlusion", "lobes"];

/// Splits the name of a dump of voxels into the name without level, and the level; none for another dump.
pub fn voxel_view(dump: &str) -> Option<(&'static str, u32)> {
    let (name, level) = match dump.split_once('@') {
        Some((name, level)) => (name, level.parse().ok()?),
        None => (dump, 0),
    };
    VOXEL_VIEWS.iter().find(|&&v| v == name).map(|&v| (v, level))
}

/// Draws the dumps of voxels that the job asks for.
pub(super) fn draw<B: Backend>(
    backend: &mut B,
    p: &Pyramid<B>,
    lit: &Lit<B>,
    view: &View,
    job: &Job,
    seen: &mut Inspection<'_>,
) -> Result<(), BackendError> {
    for dump in &job.dumps {
        let Some((name, level)) = voxel_view(dump).filter(|v| v.1 <= p.params.depth) else { continue };
        backend.set_stage("pictures of voxels");
        let params = VoxelViewParams {
            lower: p.params.lower,
            inverse_edge: p.params.inverse_edge,
            depth: p.params.depth,
            level,
            what: if name == "lobes" { VIEW_LOBES } else { VIEW_RADIANCE },
            lobes: lit.lobes,
            radiance_unit: 1.0 / lit.radiance_scale,
            storage: storage_of(p.params.flags),
            ..Default::default()
        };
        let params = backend.upload("voxel view", &[params])?;
        for band in bands(view) {
            let count = band.len() as u32;
            let mut drawn = backend.alloc("drawn voxels", count as usize)?;
            backend.draw_voxels(
                &view.params(band.start),
                &params,
                &p.blocks,
                &p.depths,
                &lit.places,
                &lit.radiance,
                &mut drawn,
                count,
            )?;
            seen.dump(backend, dump, &drawn, band.start, |v: &Vec4| {
                if name == "occlusion" { Vec3::splat(v.w) } else { v.truncate() }
            })?;
        }
    }
    Ok(())
}
