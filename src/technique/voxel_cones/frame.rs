//! How does a picture come from lit voxels? VCT §6 and §8.1.

use super::{Lighting, Lit, Pyramid, VoxelCones, drawn};
use crate::backend::{Backend, BackendError};
use crate::picture::Picture;
use crate::technique::cones::tangent;
use crate::technique::gathered::{self, Gathered};
use crate::technique::gbuffer::{GBuffer, bands};
use crate::technique::{Inspection, Job, LightPart, View, World, direct};
use glam::Vec3;
use twinlight_kernels::passes::elements::ConeParams;
use twinlight_kernels::passes::voxel_cones::trace::CONES_SEE_ENVIRONMENT;

/// What the passes that trace cones need to know.
pub(crate) fn cone_params<B: Backend>(
    world: &World<B>,
    p: &Pyramid<B>,
    lit: &Lit<B>,
    settings: &VoxelCones,
) -> ConeParams {
    ConeParams {
        lower: p.params.lower,
        inverse_edge: p.params.inverse_edge,
        environment: world.environment.environment,
        map: world.environment.map,
        depth: p.params.depth,
        radiance_unit: 1.0 / lit.radiance_scale,
        radiance_scale: lit.radiance_scale,
        first: p.params.first,
        lobes: lit.lobes,
        flags: settings.storage.flags(),
        ..settings.cones.params()
    }
}

/// Renders openness by cones.
pub(super) fn render_openness<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    p: &Pyramid<B>,
    view: &View,
    job: &Job,
    settings: &VoxelCones,
    seen: &mut Inspection<'_>,
) -> Result<Picture, BackendError> {
    let mut picture = Picture::new(view.width, view.height);
    let dark = Lit::dark(backend, p)?;
    drawn::draw(backend, p, &dark, view, job, seen)?;
    for band in bands(view) {
        let g = GBuffer::trace(backend, world, view, band.clone(), seen)?;
        backend.set_stage("occlusion");
        let params = occlusion_params(world, p, &dark, job, settings);
        let mut openness = backend.alloc("openness", g.count() as usize)?;
        backend.cone_openness(
            &params,
            &g.surfaces,
            &p.blocks,
            &p.depths,
            &dark.places,
            &dark.radiance,
            &mut openness,
            g.count(),
        )?;
        seen.check(backend, "openness", &openness)?;
        seen.dump(backend, "ao", &openness, band.start, |&v: &f32| Vec3::splat(v))?;
        let values = backend.read_result(&openness)?;
        for (pixel, value) in picture.pixels[band.start as usize..].iter_mut().zip(values) {
            *pixel = Vec3::splat(value);
        }
    }
    Ok(picture)
}

fn occlusion_params<B: Backend>(
    world: &World<B>,
    p: &Pyramid<B>,
    dark: &Lit<B>,
    job: &Job,
    settings: &VoxelCones,
) -> ConeParams {
    let edge = p.params.lower.w;
    ConeParams {
        falloff: job.falloff * edge,
        reach: (job.reach * p.params.inverse_edge).min(1.0e9),
        ..cone_params(world, p, dark, settings)
    }
}

/// Renders a picture: direct light unless only indirect is asked for, and the light of the lit voxels if there are any.
pub(super) fn render<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    lit_voxels: Option<(&Pyramid<B>, &Lighting<B>)>,
    view: &View,
    job: &Job,
    settings: &VoxelCones,
    seen: &mut Inspection<'_>,
) -> Result<Picture, BackendError> {
    let gathered = match lit_voxels {
        Some((p, lit)) => Some(gather(backend, world, p, lit, view, job, settings, seen)?),
        None => None,
    };
    gathered::picture(backend, world, gathered.as_ref(), view, job, seen, |backend, g, seen| {
        direct::band_radiance(backend, world, g, job, seen)
    })
}

fn gather<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    p: &Pyramid<B>,
    lighting: &Lighting<B>,
    view: &View,
    job: &Job,
    settings: &VoxelCones,
    seen: &mut Inspection<'_>,
) -> Result<Gathered<B>, BackendError> {
    let lit = &lighting.reflected;
    backend.set_stage("diffuse");
    let (width, height) = gathered::illumination_size(settings.illumination, view.width, view.height);
    let view = view.resized(width, height);
    let count = view.pixels();
    let g = seen.without_dumps(|seen| GBuffer::trace(backend, world, &view, 0..count, seen))?;
    let params = ConeParams {
        eye: g.params.eye,
        columns: if settings.cones.interleave { width } else { 0 },
        ..cone_params(world, p, lit, settings)
    };
    let mut diffuse = backend.alloc("diffuse light", count as usize)?;
    backend.cone_diffuse(
        &params,
        &g.surfaces,
        &p.blocks,
        &p.depths,
        &lit.places,
        &lit.radiance,
        &mut diffuse,
        count,
    )?;
    if settings.cones.interleave {
        diffuse = gathered::filtered(backend, (width, height), &g.surfaces, &diffuse)?;
    }
    seen.check(backend, "diffuse light", &diffuse)?;
    let mut specular = None;
    if let Some(gloss) = g.gloss.as_ref().filter(|_| world.has_mirrors) {
        backend.set_stage("specular");
        // What mirrors show of the environment and of emissive surfaces is direct light.
        let all = job.light == LightPart::All;
        let lit = lighting.shining.as_ref().filter(|_| all).unwrap_or(lit);
        let params = ConeParams {
            tangent: tangent(settings.cones.specular_half_angle),
            flags: settings.storage.flags()
                | if world.has_environment && all { CONES_SEE_ENVIRONMENT } else { 0 },
            eye: params.eye,
            ..cone_params(world, p, lit, settings)
        };
        let mut light = backend.alloc("specular light", count as usize)?;
        backend.cone_specular(
            &params,
            &g.surfaces,
            gloss,
            &p.blocks,
            &p.depths,
            &lit.places,
            &lit.radiance,
            &world.texels,
            &mut light,
            count,
        )?;
        seen.check(backend, "specular light", &light)?;
        specular = Some(light);
    }
    let gathered = Gathered { width, height, seen: g, diffuse, specular };
    gathered.keep(backend, seen)?;
    Ok(gathered)
}
