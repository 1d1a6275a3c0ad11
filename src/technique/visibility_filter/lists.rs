//! Which voxels does each coarse pixel see? VF §3.1 and §3.2.

use super::{Anchor, Counts, Proxies, Visibility, VisibilityFilter};
use crate::backend::{Backend, BackendError};
use crate::technique::gbuffer::GBuffer;
use crate::technique::{Inspection, Job, View, World};
use twinlight_kernels::passes::elements::{ListHeader, ListParams, MarchParams};
use twinlight_kernels::passes::visibility_filter::list::list_stride;
use twinlight_kernels::passes::visibility_filter::march::WORLD_ANCHORED;

/// The lists of a coarse picture.
pub struct Lists<B: Backend> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Voxels that a list has room for.
    pub capacity: u32,
    /// Positions, normals and lobe coverages.
    pub headers: B::Buffer<ListHeader>,
    /// The lists.
    pub lists: B::Buffer<u32>,
}

impl<B: Backend> Lists<B> {
    /// Marches rays from a coarse G-buffer and filters what they found.
    pub fn make(
        backend: &mut B,
        world: &World<B>,
        p: &Proxies<B>,
        view: &View,
        job: &Job,
        settings: &VisibilityFilter,
        seen: &mut Inspection<'_>,
    ) -> Result<Self, BackendError> {
        backend.set_stage("marching");
        let (width, height) = settings.marching_size(view.width, view.height);
        let view = view.resized(width, height);
        let pixels = view.pixels();
        let g = seen.without_dumps(|seen| GBuffer::trace(backend, world, &view, 0..pixels, seen))?;
        let lobe_rays = if world.has_mirrors { settings.lobe_rays } else { 0 };
        // Never read without lobes, but something must be bound.
        let none = backend.alloc("no gloss", 1)?;
        let gloss = g.gloss.as_ref().unwrap_or(&none);
        let march = MarchParams {
            lower: p.grid.lower,
            cell_inverse_size: p.cells.as_ref().map_or_else(Default::default, |c| c.grid.inverse_size),
            cell_dims: p.cells.as_ref().map_or_else(Default::default, |c| c.grid.dims),
            voxel_inverse_size: p.grid.inverse_size,
            voxel_dims: p.grid.dims,
            eye: g.params.eye,
            diffuse_rays: settings.rays,
            lobe_rays,
            seed: job.seed,
            flags: if settings.anchor == Anchor::World { WORLD_ANCHORED } else { 0 },
            cells_per_length: world_cells(p),
            ..Default::default()
        };
        let rays = pixels * (settings.rays + lobe_rays);
        let mut voxels = backend.alloc("ray voxels", rays as usize)?;
        let w = world;
        match &p.cells {
            Some(cells) if settings.visibility == Visibility::Proxies => backend.march_rays(
                &march,
                &g.surfaces,
                gloss,
                &cells.starts,
                &cells.pairs,
                &p.proxies,
                &mut voxels,
                rays,
            )?,
            _ => backend.trace_rays(
                &march,
                &g.surfaces,
                gloss,
                &w.nodes,
                &w.blocks,
                &w.triangles,
                &w.materials,
                &w.texels,
                &mut voxels,
                rays,
            )?,
        }
        let mut coverage = backend.alloc("lobe coverage", if lobe_rays > 0 { pixels as usize } else { 1 })?;
        if lobe_rays > 0 {
            backend.lobe_coverage(&march, &g.surfaces, gloss, &voxels, &mut coverage, pixels)?;
            seen.check(backend, "lobe coverage", &coverage)?;
        }

        backend.set_stage("filter");
        let occupied = match settings.visibility {
            Visibility::Proxies => p.occupied,
            Visibility::Triangles => p.grid.dims.w,
        };
        let capacity = settings.list_capacity(lobe_rays > 0, occupied);
        let params = ListParams {
            width,
            height,
            diffuse_rays: settings.rays,
            lobe_rays,
            half_width: settings.filter.0,
            half_height: settings.filter.1,
            capacity,
            max_depth_difference: settings.max_depth_difference,
            min_normal_cosine: settings.min_normal_cosine,
            occupied,
            ..Default::default()
        };
        let mut sorted = backend.alloc("sorted rays", rays as usize)?;
        backend.sort_rays(&params, &voxels, &mut sorted, rays)?;
        let words = pixels * (settings.rays + lobe_rays + 1);
        let mut counted = backend.alloc("counted rays", words as usize)?;
        backend.count_rays(&params, &sorted, &mut counted, pixels)?;
        let mut lists = backend.alloc("lists", pixels as usize * list_stride(capacity) as usize)?;
        backend.filter_lists(&params, &g.surfaces, &counted, &mut lists, pixels)?;
        let mut headers = backend.alloc("list headers", pixels as usize)?;
        backend.list_headers(&params, &g.surfaces, &coverage, &mut headers, pixels)?;
        seen.check(backend, "list headers", &headers)?;
        Ok(Self { width, height, capacity, headers, lists })
    }

    /// Counts what found no room; reads the lists back.
    pub fn count(&self, backend: &mut B, p: &Proxies<B>) -> Result<Counts, BackendError> {
        let words = backend.read_result(&self.lists)?;
        let stride = list_stride(self.capacity) as usize;
        let dropped = words.chunks_exact(stride).map(|list| list[2]);
        Ok(Counts {
            proxies: p.count(),
            pairs: p.cells.as_ref().map_or(0, |c| c.grid.pairs),
            capacity: self.capacity,
            full_lists: dropped.clone().filter(|&d| d > 0).count() as u32,
            dropped: dropped.map(u64::from).sum(),
        })
    }
}

/// Cells per metre of the places that choose directions: four voxels wide, since neighbours that share directions err
/// alike and each border is a step.
fn world_cells<B: Backend>(p: &Proxies<B>) -> f32 {
    0.25 * p.grid.inverse_size.truncate().min_element()
}
