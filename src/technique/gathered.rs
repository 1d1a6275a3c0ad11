//! How does light that was gathered at coarse pixels reach the picture's?

use super::View;
use super::gbuffer::GBuffer;
use crate::backend::{Backend, BackendError};
use glam::Vec4;
use twinlight_kernels::passes::elements::{Surface, UpsampleParams};

/// Light gathered at the illumination's pixels.
pub struct Gathered<B: Backend> {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// What these pixels see.
    pub surfaces: B::Buffer<Surface>,
    /// Irradiance/π.
    pub diffuse: B::Buffer<Vec4>,
    /// What a specular colour of 1 reflects; only where the scene has gloss.
    pub specular: Option<B::Buffer<Vec4>>,
}

impl<B: Backend> Gathered<B> {
    /// `sum` plus what the band's surfaces reflect of the gathered light.
    pub fn add_to(
        &self,
        backend: &mut B,
        view: &View,
        g: &GBuffer<B>,
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
            ..Default::default()
        };
        let mut fine = backend.alloc("upsampled light", count as usize)?;
        let mut next = backend.alloc("radiance", count as usize)?;
        backend.upsample(&params, &g.surfaces, &self.surfaces, &self.diffuse, &mut fine, count)?;
        backend.add_diffuse_reflection(&Default::default(), &g.surfaces, &fine, &sum, &mut next, count)?;
        std::mem::swap(&mut sum, &mut next);
        if let (Some(specular), Some(gloss)) = (&self.specular, &g.gloss) {
            backend.upsample(&params, &g.surfaces, &self.surfaces, specular, &mut fine, count)?;
            backend.add_specular_reflection(&Default::default(), gloss, &fine, &sum, &mut next, count)?;
            std::mem::swap(&mut sum, &mut next);
        }
        Ok(sum)
    }
}
