//! How does a picture come from lit proxies? VF §3.3.

use super::lists::Lists;
use super::{Clamp, Gather, Lit, Proxies, VisibilityFilter};
use crate::backend::{Backend, BackendError};
use crate::picture::Picture;
use crate::technique::gathered::Gathered;
use crate::technique::gbuffer::{GBuffer, bands};
use crate::technique::{Inspection, Job, LightPart, View, World, direct};
use glam::{Vec3, Vec4};
use twinlight_kernels::passes::elements::{GatherVoxelsParams, Surface};
use twinlight_kernels::passes::visibility_filter::gather_voxels::{
    CLAMP_DISC, CLAMP_NONE, CLAMP_RADIUS, GATHER_SHARE,
};
use twinlight_kernels::sampling::hash::{hash, unit_float};
use twinlight_kernels::sampling::voxel_hash::{encode, voxel_of};

/// A picture and the lists that it was gathered from.
pub struct Frame<B: Backend> {
    /// The picture.
    pub picture: Picture,
    /// Which voxels its coarse pixels saw; none without indirect light.
    pub lists: Option<Lists<B>>,
}

/// Renders a picture: direct light unless only indirect is asked for, and the light of the lit proxies if there are any. Lists of an
/// earlier picture of this view stand for those that would be made.
pub fn render<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    lit_proxies: Option<(&Proxies<B>, &Lit<B>)>,
    known: Option<Lists<B>>,
    view: &View,
    job: &Job,
    settings: &VisibilityFilter,
    seen: &mut Inspection<'_>,
) -> Result<Frame<B>, BackendError> {
    let mut picture = Picture::new(view.width, view.height);
    let (mut gathered, mut lists) = (None, None);
    if let Some((p, lit)) = lit_proxies {
        let made = match known {
            Some(lists) => lists,
            None => Lists::make(backend, world, p, view, job, settings, seen)?,
        };
        gathered = Some(gather(backend, world, p, lit, &made, view, settings, seen)?);
        lists = Some(made);
    }
    for band in bands(view) {
        backend.set_stage("direct");
        let g = GBuffer::trace(backend, world, view, band.clone(), seen)?;
        let count = g.count() as usize;
        let mut sum = if job.light == LightPart::Indirect {
            backend.alloc("radiance", count)?
        } else {
            direct::band_radiance(backend, world, &g, job, seen)?
        };
        if let Some(gathered) = &gathered {
            backend.set_stage("upsampling");
            if seen.wants("indirect") {
                let nothing = backend.alloc("radiance", count)?;
                let indirect = gathered.add_to(backend, view, &g, job.upsampling, nothing)?;
                seen.dump(backend, "indirect", &indirect, band.start, |v: &Vec4| v.truncate())?;
            }
            sum = gathered.add_to(backend, view, &g, job.upsampling, sum)?;
            seen.check(backend, "radiance", &sum)?;
        }
        if let Some((p, lit)) = lit_proxies {
            dump_voxels(backend, p, lit, &g, seen)?;
        }
        let values = backend.read_result(&sum)?;
        for (pixel, value) in picture.pixels[band.start as usize..].iter_mut().zip(values) {
            *pixel = value.truncate();
        }
    }
    Ok(Frame { picture, lists })
}

fn gather<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    p: &Proxies<B>,
    lit: &Lit<B>,
    lists: &Lists<B>,
    view: &View,
    settings: &VisibilityFilter,
    seen: &mut Inspection<'_>,
) -> Result<Gathered<B>, BackendError> {
    backend.set_stage("illumination");
    let (width, height) = settings.illumination_size(view.width, view.height);
    let view = view.resized(width, height);
    let count = view.pixels();
    let g = seen.without_dumps(|seen| GBuffer::trace(backend, world, &view, 0..count, seen))?;
    let edge = p.grid.inverse_size.truncate().recip();
    let params = GatherVoxelsParams {
        eye: g.params.eye,
        width,
        first_pixel: 0,
        coarse_width: lists.width,
        coarse_height: lists.height,
        scale_x: lists.width as f32 / width as f32,
        scale_y: lists.height as f32 / height as f32,
        near_range: settings.near_range.unwrap_or(edge.length()),
        depth_deviation: settings.depth_deviation,
        normal_deviation: settings.normal_deviation,
        specular_deviation: settings.specular_deviation,
        specular_exponent: settings.specular_exponent.unwrap_or(0.0),
        capacity: lists.capacity,
        flags: if settings.gather == Gather::Share { GATHER_SHARE } else { 0 },
        trust: settings.trust,
        disc_radius: p.radius,
        lights: lit.lights,
        sides: 2 * p.count(),
        clamp: match settings.clamp {
            Clamp::Disc => CLAMP_DISC,
            Clamp::Radius => CLAMP_RADIUS,
            Clamp::None => CLAMP_NONE,
        },
        ..Default::default()
    };
    let mut diffuse = backend.alloc("diffuse light", count as usize)?;
    backend.gather_diffuse(
        &params,
        &g.surfaces,
        &lists.headers,
        &lists.lists,
        &lit.voxels,
        &p.proxies,
        &lit.radiance,
        &mut diffuse,
        count,
    )?;
    seen.check(backend, "diffuse light", &diffuse)?;
    let mut specular = None;
    if let Some(gloss) = g.gloss.as_ref().filter(|_| world.has_mirrors && settings.lobe_rays > 0) {
        let mut light = backend.alloc("specular light", count as usize)?;
        backend.gather_specular(
            &params,
            &g.surfaces,
            gloss,
            &lists.headers,
            &lists.lists,
            &lit.voxels,
            &p.proxies,
            &lit.radiance,
            &mut light,
            count,
        )?;
        seen.check(backend, "specular light", &light)?;
        if seen.wants("specular") {
            let light = backend.read_result(&light)?;
            seen.keep("specular", || picture(width, height, &light, Vec4::truncate));
        }
        specular = Some(light);
    }
    if seen.wants("diffuse") || seen.wants("visible-count") {
        let light = backend.read_result(&diffuse)?;
        seen.keep("diffuse", || picture(width, height, &light, Vec4::truncate));
        let most = light.iter().fold(1.0f32, |most, v| most.max(v.w));
        seen.keep("visible-count", || picture(width, height, &light, |v| Vec3::splat(v.w / most)));
    }
    Ok(Gathered { width, height, seen: g, diffuse, specular })
}

fn picture(width: u32, height: u32, values: &[Vec4], colour: impl Fn(Vec4) -> Vec3) -> Picture {
    Picture { width, height, pixels: values.iter().map(|&v| colour(v)).collect() }
}

/// Pictures of the discs and of the voxels, if asked for.
fn dump_voxels<B: Backend>(
    backend: &mut B,
    p: &Proxies<B>,
    lit: &Lit<B>,
    g: &GBuffer<B>,
    seen: &mut Inspection<'_>,
) -> Result<(), BackendError> {
    if let Some(cells) = p.cells.as_ref().filter(|_| seen.wants("proxies")) {
        let grid = backend.upload("cells", &[cells.grid])?;
        let mut discs = backend.alloc("discs", g.count() as usize)?;
        backend.draw_proxies(
            &g.params,
            &grid,
            &cells.starts,
            &cells.pairs,
            &p.proxies,
            &lit.radiance,
            &mut discs,
            g.count(),
        )?;
        seen.dump(backend, "proxies", &discs, g.pixels.start, |v: &Vec4| v.truncate())?;
    }
    let grid = p.grid;
    seen.dump(backend, "voxels", &g.surfaces, g.pixels.start, |s: &Surface| {
        if s.position.w < 0.0 {
            return Vec3::ZERO;
        }
        let dims = grid.dims.truncate();
        let voxel =
            voxel_of(s.position.truncate(), grid.lower.truncate(), grid.inverse_size.truncate(), dims);
        let word = hash(encode(voxel, dims));
        Vec3::new(unit_float(word), unit_float(hash(word)), unit_float(hash(word ^ 1)))
    })
}
