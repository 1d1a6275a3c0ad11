//! How does light that was gathered at coarse pixels reach the picture's?

use super::gbuffer::{GBuffer, bands};
use super::{Inspection, Job, LightPart, Upsampling, View, World};
use crate::backend::{Backend, BackendError};
use crate::error::SettingsError;
use crate::picture::Picture;
use glam::{Vec3, Vec4};
use std::rc::Rc;
use twinlight_kernels::passes::elements::{InterleavedParams, Surface, UpsampleParams};

/// The largest number of pixels at which light is gathered.
pub const MAX_PIXELS: u64 = 1 << 20;

/// Half of a picture's sides, or less where that would be too many pixels; or what is asked for.
pub(super) fn illumination_size(asked: Option<(u32, u32)>, width: u32, height: u32) -> (u32, u32) {
    asked.unwrap_or_else(|| {
        let (mut w, mut h) = (width.div_ceil(2), height.div_ceil(2));
        while u64::from(w) * u64::from(h) > MAX_PIXELS {
            (w, h) = (w.div_ceil(2), h.div_ceil(2));
        }
        (w, h)
    })
}

/// Refuses numbers of pixels that cannot be gathered at.
pub(super) fn check_illumination(
    asked: Option<(u32, u32)>,
    width: u32,
    height: u32,
) -> Result<(), SettingsError> {
    let (w, h) = illumination_size(asked, width, height);
    let pixels = u64::from(w) * u64::from(h);
    if pixels == 0 || pixels > MAX_PIXELS {
        let reason = format!("{w}x{h} is not from 1 to {MAX_PIXELS} pixels");
        return Err(SettingsError { knob: "illumination", reason });
    }
    Ok(())
}

/// A picture of direct light, by `direct`, unless only indirect is asked for, and of the gathered light if there is any.
pub(super) fn picture<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    gathered: Option<&Gathered<B>>,
    view: &View,
    job: &Job,
    seen: &mut Inspection<'_>,
    mut direct: impl FnMut(&mut B, &GBuffer<B>, &mut Inspection<'_>) -> Result<B::Buffer<Vec4>, BackendError>,
) -> Result<Picture, BackendError> {
    let mut picture = Picture::new(view.width, view.height);
    // Techniques that know it at their own pixels have kept it.
    let wants_indirect = seen.wants("indirect") && !seen.has("indirect");
    for band in bands(view) {
        backend.set_stage("direct");
        let g = GBuffer::trace(backend, world, view, band.clone(), seen)?;
        let count = g.count() as usize;
        let mut sum = if job.light == LightPart::Indirect {
            backend.alloc("radiance", count)?
        } else {
            direct(backend, &g, seen)?
        };
        if let Some(gathered) = gathered {
            backend.set_stage("upsampling");
            if wants_indirect {
                let nothing = backend.alloc("radiance", count)?;
                let indirect = gathered.add_to(backend, view, &g, job.upsampling, nothing)?;
                seen.dump(backend, "indirect", &indirect, band.start, |v: &Vec4| v.truncate())?;
            }
            sum = gathered.add_to(backend, view, &g, job.upsampling, sum)?;
            seen.check(backend, "radiance", &sum)?;
        }
        let values = backend.read_result(&sum)?;
        for (pixel, value) in picture.pixels[band.start as usize..].iter_mut().zip(values) {
            *pixel = value.truncate();
        }
    }
    Ok(picture)
}

/// What cones gathered that each of 4 × 4 pixels turned another way: the mean over neighbours of about the same plane.
pub(super) fn filtered<B: Backend>(
    backend: &mut B,
    (columns, rows): (u32, u32),
    surfaces: &B::Buffer<Surface>,
    light: &B::Buffer<Vec4>,
) -> Result<B::Buffer<Vec4>, BackendError> {
    let params = InterleavedParams { columns, rows, ..Default::default() };
    let mut means = backend.alloc("diffuse light", (columns * rows) as usize)?;
    backend.filter_interleaved(&params, surfaces, light, &mut means, columns * rows)?;
    Ok(means)
}

/// Light gathered at the illumination's pixels.
pub struct Gathered<B: Backend> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What these pixels see.
    pub seen: Rc<GBuffer<B>>,
    /// Irradiance/π.
    pub diffuse: B::Buffer<Vec4>,
    /// What a specular colour of 1 reflects; only where the scene has gloss.
    pub specular: Option<B::Buffer<Vec4>>,
}

impl<B: Backend> Gathered<B> {
    /// Keeps pictures of the light by cones, if they are asked for: `diffuse`, `specular`, and the openness as `ao`.
    pub(super) fn keep(&self, backend: &mut B, seen: &mut Inspection<'_>) -> Result<(), BackendError> {
        let (width, height) = (self.width, self.height);
        let picture = |light: &[Vec4], colour: fn(Vec4) -> Vec3| Picture {
            width,
            height,
            pixels: light.iter().map(|&v| colour(v)).collect(),
        };
        if seen.wants("diffuse") || seen.wants("ao") {
            let light = backend.read_result(&self.diffuse)?;
            seen.keep("diffuse", || picture(&light, Vec4::truncate));
            seen.keep("ao", || picture(&light, |v| Vec3::splat(v.w)));
        }
        if let Some(specular) = self.specular.as_ref().filter(|_| seen.wants("specular")) {
            let light = backend.read_result(specular)?;
            seen.keep("specular", || picture(&light, Vec4::truncate));
        }
        Ok(())
    }

    /// `sum` plus what the band's surfaces reflect of the gathered light.
    pub fn add_to(
        &self,
        backend: &mut B,
        view: &View,
        g: &GBuffer<B>,
        upsampling: Upsampling,
        mut sum: B::Buffer<Vec4>,
    ) -> Result<B::Buffer<Vec4>, BackendError> {
        let count = g.count();
        let params = UpsampleParams {
            width: view.width,
            first_pixel: g.pixels.start,
            coarse_width: self.width,
            coarse_height: self.height,
            scale_x: self.width as f32 / view.width as f32,
            scale_y: self.height as f32 / view.height as f32,
            filter: upsampling.number(),
            ..Default::default()
        };
        let mut fine = backend.alloc("upsampled light", count as usize)?;
        let mut next = backend.alloc("radiance", count as usize)?;
        backend.upsample(&params, &g.surfaces, &self.seen.surfaces, &self.diffuse, &mut fine, count)?;
        backend.add_diffuse_reflection(&Default::default(), &g.surfaces, &fine, &sum, &mut next, count)?;
        std::mem::swap(&mut sum, &mut next);
        if let (Some(specular), Some(gloss)) = (&self.specular, &g.gloss) {
            backend.upsample(&params, &g.surfaces, &self.seen.surfaces, specular, &mut fine, count)?;
            backend.add_specular_reflection(&Default::default(), gloss, &fine, &sum, &mut next, count)?;
            std::mem::swap(&mut sum, &mut next);
        }
        Ok(sum)
    }
}
