//! How does the scene look in the light that comes straight from its sources?
//!
//! Point, spot and sun lights with hard shadows by one shadow ray each; the environment and emissive surfaces by
//! cosine-distributed rays.

use super::gbuffer::{GBuffer, bands};
use super::{Inspection, Job, Rendered, View, World};
use crate::backend::{Backend, BackendError};
use crate::picture::Picture;
use glam::{UVec4, Vec3, Vec4};
use twinlight_kernels::passes::elements::{GatherParams, LightParams};
use twinlight_kernels::passes::gather::GATHER_EMISSION;
use twinlight_kernels::passes::light::LIGHTS_PER_WORD;

/// Buffers that [`Job::dumps`] may name.
pub const DUMPS: [&str; 7] = ["albedo", "normal", "depth", "position", "gloss", "emission", "visibility"];

/// Renders the scene's direct light, with emission and background.
pub fn render<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    view: &View,
    job: &Job,
) -> Result<Rendered, BackendError> {
    let mut seen = Inspection::new(job, view.width, view.height);
    let mut picture = Picture::new(view.width, view.height);
    for band in bands(view) {
        let g = GBuffer::trace(backend, world, view, band.clone(), &mut seen)?;
        let radiance = band_radiance(backend, world, &g, job, &mut seen)?;
        let values = backend.read_result(&radiance)?;
        for (pixel, value) in picture.pixels[band.start as usize..].iter_mut().zip(values) {
            *pixel = value.truncate();
        }
    }
    let timings = backend.take_timings()?;
    Ok(seen.finish(picture, timings))
}

/// The outgoing radiance of a band in direct light, pass by pass onto the sum so far.
pub(super) fn band_radiance<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    g: &GBuffer<B>,
    job: &Job,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<Vec4>, BackendError> {
    radiance(backend, world, g, job, world.has_environment, seen)
}

/// The same without what surfaces reflect of the surroundings, for techniques that know better; the background stays.
pub(super) fn band_radiance_without_surroundings<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    g: &GBuffer<B>,
    job: &Job,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<Vec4>, BackendError> {
    radiance(backend, world, g, job, false, seen)
}

fn radiance<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    g: &GBuffer<B>,
    job: &Job,
    surroundings: bool,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<Vec4>, BackendError> {
    let count = g.count();
    let mut sum = backend.alloc("radiance", count as usize)?;
    let mut next = backend.alloc("radiance", count as usize)?;
    let light_count = if world.lights_shine { world.light_count } else { 0 };
    for first_light in (0..light_count).step_by(LIGHTS_PER_WORD as usize) {
        let params = LightParams {
            eye: g.params.eye,
            first_light,
            light_count: LIGHTS_PER_WORD.min(light_count - first_light),
            ..Default::default()
        };
        let visible = visibility(backend, world, g, &params, seen)?;
        backend.shade_diffuse(&params, &g.surfaces, &world.lights, &visible, &sum, &mut next, count)?;
        std::mem::swap(&mut sum, &mut next);
        if let Some(gloss) = &g.gloss {
            backend.shade_specular(
                &params,
                &g.surfaces,
                gloss,
                &world.lights,
                &visible,
                &sum,
                &mut next,
                count,
            )?;
            std::mem::swap(&mut sum, &mut next);
        }
    }
    with_surroundings(backend, world, g, job, sum, surroundings, seen)
}

/// `sum`, the light of point, spot and sun lights, and what surroundings, emission and background add to it.
pub(super) fn with_surroundings<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    g: &GBuffer<B>,
    job: &Job,
    mut sum: B::Buffer<Vec4>,
    surroundings: bool,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<Vec4>, BackendError> {
    let count = g.count();
    let mut next = backend.alloc("radiance", count as usize)?;
    if surroundings || world.emits {
        let dark = GatherParams { environment: Vec4::ZERO, map: UVec4::ZERO, ..world.environment };
        let params = GatherParams {
            rays: job.rays,
            seed: job.seed,
            flags: if world.emits { GATHER_EMISSION } else { 0 },
            first_pixel: g.pixels.start,
            ..if surroundings { world.environment } else { dark }
        };
        let w = world;
        backend.gather_direct(
            &params,
            &g.surfaces,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &sum,
            &mut next,
            count,
        )?;
        std::mem::swap(&mut sum, &mut next);
    }
    if let Some(emission) = &g.emission {
        backend.add_radiance(&Default::default(), &sum, emission, &mut next, count)?;
        std::mem::swap(&mut sum, &mut next);
    }
    if world.has_environment {
        let environment = backend.upload("environment", &[world.environment])?;
        backend.fill_background(
            &g.params,
            &environment,
            &g.surfaces,
            &world.texels,
            &sum,
            &mut next,
            count,
        )?;
        std::mem::swap(&mut sum, &mut next);
    }
    seen.check(backend, "radiance", &sum)?;
    Ok(sum)
}

/// One bit per light and pixel.
fn visibility<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    g: &GBuffer<B>,
    params: &LightParams,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<u32>, BackendError> {
    let w = world;
    let mut visible = backend.alloc("visibility", g.count() as usize)?;
    backend.light_visibility(
        params,
        &g.surfaces,
        &w.lights,
        &w.nodes,
        &w.blocks,
        &w.triangles,
        &w.materials,
        &w.texels,
        &mut visible,
        g.count(),
    )?;
    let lights = params.light_count as f32;
    seen.dump(backend, "visibility", &visible, g.pixels.start, |v: &u32| {
        Vec3::splat(v.count_ones() as f32 / lights)
    })?;
    Ok(visible)
}
