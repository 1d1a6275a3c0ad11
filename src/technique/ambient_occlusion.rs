//! How open is each surface to its surroundings?

use super::gbuffer::{GBuffer, bands};
use super::{Inspection, Job, Rendered, View, World};
use crate::backend::{Backend, BackendError};
use crate::picture::Picture;
use glam::Vec3;
use twinlight_kernels::passes::elements::GatherParams;

/// Buffers that [`Job::dumps`] may name.
pub const DUMPS: [&str; 6] = ["albedo", "normal", "depth", "position", "gloss", "emission"];

/// Renders the cosine-weighted openness, 1 where nothing occludes, by rays: the reference for faster ways.
///
/// The standard error of a pixel with openness p is √(p(1 − p)/rays) at most.
pub fn render<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    view: &View,
    job: &Job,
) -> Result<Rendered, BackendError> {
    let mut seen = Inspection::new(job, view.width, view.height);
    let mut picture = Picture::new(view.width, view.height);
    let w = world;
    for band in bands(view) {
        let g = GBuffer::trace(backend, world, view, band.clone(), &mut seen)?;
        let params = GatherParams {
            rays: job.rays,
            seed: job.seed,
            falloff: job.falloff,
            reach: job.reach,
            first_pixel: band.start,
            ..Default::default()
        };
        let mut openness = backend.alloc("openness", g.count() as usize)?;
        backend.ambient_openness(
            &params,
            &g.surfaces,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut openness,
            g.count(),
        )?;
        seen.check(backend, "openness", &openness)?;
        let values = backend.read_result(&openness)?;
        for (pixel, value) in picture.pixels[band.start as usize..].iter_mut().zip(values) {
            *pixel = Vec3::splat(value);
        }
    }
    let timings = backend.take_timings()?;
    Ok(seen.finish(picture, timings))
}
