//! How does a picture come from binary voxels and layered maps? LRSM §3 and §6.

use super::maps::reflective_map;
use super::{BinaryVoxels, LayeredMaps, LayeredRsm, Opacity};
use crate::backend::{Backend, BackendError};
use crate::picture::Picture;
use crate::technique::cones::tangent;
use crate::technique::gathered::{self, Gathered, illumination_size};
use crate::technique::gbuffer::GBuffer;
use crate::technique::{Inspection, Job, LightPart, View, World, direct};
use glam::Vec4;
use twinlight_kernels::passes::elements::{ConeParams, LightParams, ReflectParams};
use twinlight_kernels::passes::layered_rsm::texel::{texel_words, unpack_texel};
use twinlight_kernels::passes::scene::LIGHT_SUN;
use twinlight_kernels::passes::voxel_cones::storage::unpack_radiance;
use twinlight_kernels::passes::voxel_cones::trace::{CONES_MEAN_OPACITY, CONES_SEE_ENVIRONMENT};

/// What the passes that trace cones need to know.
pub(crate) fn cone_params<B: Backend>(
    world: &World<B>,
    voxels: &BinaryVoxels<B>,
    settings: &LayeredRsm,
    radiance_scale: f32,
) -> ConeParams {
    ConeParams {
        lower: voxels.lower,
        inverse_edge: 1.0 / voxels.lower.w,
        environment: world.environment.environment,
        map: world.environment.map,
        depth: voxels.depth,
        flags: if settings.opacity == Opacity::Mean { CONES_MEAN_OPACITY } else { 0 },
        radiance_unit: 1.0 / radiance_scale,
        radiance_scale,
        ..settings.cones.params()
    }
}

/// Light that cones gather from the maps of all lights, a group of them after the other.
pub(super) fn gather<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    voxels: &BinaryVoxels<B>,
    groups: &[LayeredMaps<B>],
    view: &View,
    job: &Job,
    settings: &LayeredRsm,
    radiance_scale: f32,
    seen: &mut Inspection<'_>,
) -> Result<Gathered<B>, BackendError> {
    backend.set_stage("diffuse");
    let (width, height) = illumination_size(settings.illumination, view.width, view.height);
    let view = view.resized(width, height);
    let count = view.pixels();
    let g = seen.without_dumps(|seen| GBuffer::trace(backend, world, &view, 0..count, seen))?;
    let interleave = settings.cones.interleave;
    let columns = if interleave { width } else { 0 };
    let all =
        ConeParams { eye: g.params.eye, columns, ..cone_params(world, voxels, settings, radiance_scale) };
    let mut diffuse: Option<B::Buffer<Vec4>> = None;
    let mut specular: Option<B::Buffer<Vec4>> = None;
    for (number, group) in groups.iter().enumerate() {
        backend.set_stage("diffuse");
        let params = ConeParams { maps: group.host.len() as u32, ..all };
        let (maps, layers) = (&group.maps, &group.layers);
        if !group.host.is_empty() {
            let mut light = backend.alloc("diffuse light", count as usize)?;
            backend.layered_diffuse(&params, &g.surfaces, &voxels.words, maps, layers, &mut light, count)?;
            seen.check(backend, "diffuse light", &light)?;
            diffuse = Some(sum(backend, diffuse, light, count)?);
        }
        if let Some(gloss) = g.gloss.as_ref().filter(|_| world.has_mirrors) {
            backend.set_stage("specular");
            // What mirrors show of the environment is direct light, and there once.
            let environment = world.has_environment && job.light == LightPart::All && number == 0;
            let params = ConeParams {
                tangent: tangent(settings.cones.specular_half_angle),
                flags: params.flags | if environment { CONES_SEE_ENVIRONMENT } else { 0 },
                ..params
            };
            let mut light = backend.alloc("specular light", count as usize)?;
            backend.layered_specular(
                &params,
                &g.surfaces,
                gloss,
                &voxels.words,
                maps,
                layers,
                &world.texels,
                &mut light,
                count,
            )?;
            seen.check(backend, "specular light", &light)?;
            specular = Some(sum(backend, specular, light, count)?);
        }
    }
    backend.set_stage("diffuse");
    let diffuse = match diffuse {
        Some(diffuse) if interleave => gathered::filtered(backend, (width, height), &g.surfaces, &diffuse)?,
        Some(diffuse) => diffuse,
        None => backend.alloc("diffuse light", count as usize)?,
    };
    let gathered = Gathered { width, height, seen: g, diffuse, specular };
    gathered.keep(backend, seen)?;
    Ok(gathered)
}

/// Adds light, if there was any before.
fn sum<B: Backend>(
    backend: &mut B,
    before: Option<B::Buffer<Vec4>>,
    light: B::Buffer<Vec4>,
    count: u32,
) -> Result<B::Buffer<Vec4>, BackendError> {
    let Some(before) = before else { return Ok(light) };
    let mut all = backend.alloc("light", count as usize)?;
    backend.add_radiance(&Default::default(), &before, &light, &mut all, count)?;
    Ok(all)
}

/// Direct light of a band with shadows by cones.
pub(super) fn soft_direct<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    voxels: &BinaryVoxels<B>,
    g: &GBuffer<B>,
    job: &Job,
    settings: &LayeredRsm,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<Vec4>, BackendError> {
    backend.set_stage("shadows");
    let count = g.count();
    let mut sum = backend.alloc("radiance", count as usize)?;
    let mut next = backend.alloc("radiance", count as usize)?;
    let mut shown = vec![0.0; if seen.wants("shadow") { count as usize } else { 0 }];
    for light in 0..world.light_count {
        let sun = world.host_lights[light as usize].kind == LIGHT_SUN;
        let extent = if sun { settings.sun_angle.to_radians().tan() } else { settings.light_radius };
        let params = ConeParams { light, extent, ..cone_params(world, voxels, settings, 1.0) };
        let mut visible = backend.alloc("shadow", count as usize)?;
        backend.shadow_cone(&params, &g.surfaces, &world.lights, &voxels.words, &mut visible, count)?;
        seen.check(backend, "shadow", &visible)?;
        if !shown.is_empty() {
            let values = backend.read_result(&visible)?;
            shown.iter_mut().zip(values).for_each(|(sum, v)| *sum += v / world.light_count as f32);
        }
        let params =
            LightParams { eye: g.params.eye, first_light: light, light_count: 1, ..Default::default() };
        let lights = &world.lights;
        backend.shade_soft_diffuse(&params, &g.surfaces, lights, &visible, &sum, &mut next, count)?;
        std::mem::swap(&mut sum, &mut next);
        if let Some(gloss) = &g.gloss {
            backend.shade_soft_specular(
                &params,
                &g.surfaces,
                gloss,
                lights,
                &visible,
                &sum,
                &mut next,
                count,
            )?;
            std::mem::swap(&mut sum, &mut next);
        }
    }
    seen.keep_band("shadow", g.pixels.start, &shown);
    backend.set_stage("direct");
    direct::with_surroundings(backend, world, g, job, sum, world.has_environment, seen)
}

/// Pictures of the first light's map and of the finest level of its layers side by side, near ones first, if they are asked for.
pub(super) fn draw_maps<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    groups: &[LayeredMaps<B>],
    settings: &LayeredRsm,
    radiance_scale: f32,
    seen: &mut Inspection<'_>,
) -> Result<(), BackendError> {
    if seen.wants("rsm") && world.light_count > 0 {
        let map = reflective_map(
            backend,
            world,
            settings.map,
            &ReflectParams { radiance_scale, ..Default::default() },
        )?;
        let texels = backend.read_result(&map.texels)?;
        seen.keep("rsm", || Picture {
            width: settings.map,
            height: settings.map,
            pixels: texels.iter().map(|t| unpack_radiance(t.radiance) / radiance_scale).collect(),
        });
    }
    if let (true, Some(group)) = (seen.wants("layers"), groups.first()) {
        let words = backend.read_result(&group.layers)?;
        let (side, layers) = (settings.map / 2, settings.layers());
        let stride = texel_words(settings.format());
        let mut picture = Picture::new(side * layers, side);
        for layer in 0..layers {
            for texel in 0..side * side {
                let at = stride * (layer * side * side + texel);
                let colour = unpack_texel(settings.format(), &words, at).reflected / radiance_scale;
                let pixel = texel / side * side * layers + layer * side + texel % side;
                picture.pixels[pixel as usize] = colour;
            }
        }
        seen.keep("layers", || picture);
    }
    Ok(())
}
