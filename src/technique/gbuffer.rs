//! Which surface does each pixel of a band see?

use super::world::KeptGBuffer;
use super::{Inspection, View, World};
use crate::backend::{Backend, BackendError};
use glam::{Vec3, Vec4};
use std::ops::Range;
use std::rc::Rc;
use twinlight_kernels::passes::elements::{CameraParams, Surface};

/// Pixels of a band: pictures of any size fit into the smallest binding that devices allow.
pub const BAND_PIXELS: u32 = 1 << 20;
/// Pixels of all G-buffers that a world keeps, at most: about half a gigabyte.
const MAX_KEPT: u64 = 1 << 22;

/// The buffers that describe what a band of pixels sees.
pub struct GBuffer<B: Backend> {
    /// The camera and the band.
    pub params: CameraParams,
    /// The band's pixels, row-major.
    pub pixels: Range<u32>,
    /// Surfaces.
    pub surfaces: B::Buffer<Surface>,
    /// Specular colour and exponent; only where the scene has gloss.
    pub gloss: Option<B::Buffer<Vec4>>,
    /// Emitted radiance; only where surfaces emit.
    pub emission: Option<B::Buffer<Vec4>>,
}

/// The bands of a picture.
pub fn bands(view: &View) -> impl Iterator<Item = Range<u32>> + use<> {
    let all = view.pixels();
    (0..all.div_ceil(BAND_PIXELS)).map(move |b| b * BAND_PIXELS..all.min((b + 1) * BAND_PIXELS))
}

impl<B: Backend> GBuffer<B> {
    /// Traces the primary rays of a band and resolves its surfaces, unless the world has kept what came of it.
    pub fn trace(
        backend: &mut B,
        world: &World<B>,
        view: &View,
        pixels: Range<u32>,
        seen: &mut Inspection<'_>,
    ) -> Result<Rc<Self>, BackendError> {
        let same = |k: &&KeptGBuffer<B>| k.view == *view && k.pixels == pixels;
        let known =
            world.kept.borrow().as_ref().and_then(|kept| kept.iter().find(same).map(|k| k.gbuffer.clone()));
        if let Some(known) = known.filter(|_| !seen.looks()) {
            return Ok(known);
        }
        let made = Rc::new(Self::make(backend, world, view, pixels.clone(), seen)?);
        if let Some(kept) = world.kept.borrow_mut().as_mut() {
            let count: u64 = kept.iter().map(|k| k.pixels.len() as u64).sum();
            if count + pixels.len() as u64 <= MAX_KEPT {
                kept.push(KeptGBuffer { view: *view, pixels, gbuffer: made.clone() });
            }
        }
        Ok(made)
    }

    fn make(
        backend: &mut B,
        world: &World<B>,
        view: &View,
        pixels: Range<u32>,
        seen: &mut Inspection<'_>,
    ) -> Result<Self, BackendError> {
        let params = view.params(pixels.start);
        let count = pixels.len() as u32;
        let w = world;
        let mut hits = backend.alloc("hits", count as usize)?;
        backend.trace_primary(
            &params,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut hits,
            count,
        )?;
        seen.check(backend, "hits", &hits)?;
        let mut surfaces = backend.alloc("surfaces", count as usize)?;
        backend.resolve_surfaces(
            &params,
            &hits,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut surfaces,
            count,
        )?;
        seen.check(backend, "surfaces", &surfaces)?;
        let first = pixels.start;
        seen.dump(backend, "albedo", &surfaces, first, |s: &Surface| s.diffuse.truncate())?;
        seen.dump(backend, "normal", &surfaces, first, |s: &Surface| {
            s.normal.truncate() * 0.5 + Vec3::splat(0.5)
        })?;
        seen.dump(backend, "depth", &surfaces, first, |s: &Surface| Vec3::splat(s.position.w.max(0.0)))?;
        seen.dump(backend, "position", &surfaces, first, |s: &Surface| s.position.truncate())?;
        let mut g = Self { params, pixels, surfaces, gloss: None, emission: None };
        g.resolve_optional(backend, world, seen)?;
        Ok(g)
    }

    /// The buffers that only some scenes call for.
    fn resolve_optional(
        &mut self,
        backend: &mut B,
        world: &World<B>,
        seen: &mut Inspection<'_>,
    ) -> Result<(), BackendError> {
        let count = self.count();
        let first = self.pixels.start;
        if world.has_gloss {
            let mut gloss = backend.alloc("gloss", count as usize)?;
            backend.resolve_gloss(
                &self.params,
                &self.surfaces,
                &world.materials,
                &world.texels,
                &mut gloss,
                count,
            )?;
            seen.check(backend, "gloss", &gloss)?;
            seen.dump(backend, "gloss", &gloss, first, |g: &Vec4| g.truncate())?;
            self.gloss = Some(gloss);
        }
        if world.emits {
            let mut emission = backend.alloc("emission", count as usize)?;
            backend.resolve_emission(
                &self.params,
                &self.surfaces,
                &world.materials,
                &world.texels,
                &mut emission,
                count,
            )?;
            seen.check(backend, "emission", &emission)?;
            seen.dump(backend, "emission", &emission, first, |e: &Vec4| e.truncate())?;
            self.emission = Some(emission);
        }
        Ok(())
    }

    /// Number of pixels of the band.
    pub fn count(&self) -> u32 {
        self.pixels.len() as u32
    }
}
