//! What does light make of the proxies? VF §3.1.

use super::{Gather, Proxies, VisibilityFilter};
use crate::backend::{Backend, BackendError};
use crate::error::SettingsError;
use crate::technique::{Inspection, Job, World, light_map};
use glam::Vec4;
use twinlight_kernels::passes::elements::{GatherParams, GridParams, LightParams, LobeParams, Voxel};
use twinlight_kernels::passes::gather::GATHER_EMISSION;
use twinlight_kernels::passes::light::LIGHTS_PER_WORD;

/// The proxies as lights. They change with the lights.
pub struct Lit<B: Backend> {
    /// Radiance of each proxy's front and back, with the side's openness in w; lobes behind, see `add_lobes`.
    pub radiance: B::Buffer<Vec4>,
    /// What each voxel sends out.
    pub voxels: B::Buffer<Voxel>,
    /// Lights whose lobes stand behind the radiance; 0 without gloss.
    pub lights: u32,
}

impl<B: Backend> Lit<B> {
    /// Lights every proxy by all lights, and by rays to the environment and to emissive surfaces where there are any.
    pub fn light(
        backend: &mut B,
        world: &World<B>,
        p: &Proxies<B>,
        settings: &VisibilityFilter,
        job: &Job,
        seen: &mut Inspection<'_>,
    ) -> Result<Self, BackendError> {
        let w = world;
        let sides = 2 * p.count();
        let lights = if w.has_gloss && settings.proxy_gloss { w.light_count } else { 0 };
        let words = word_count(sides, lights)?;
        let mut radiance = backend.alloc("proxy radiance", words as usize)?;
        backend.dark_sides(&p.grid, &p.openness, &mut radiance, sides)?;
        let mut next = backend.alloc("proxy radiance", words as usize)?;
        let mut runs = Vec::new();
        for first_light in (0..w.light_count).step_by(LIGHTS_PER_WORD as usize) {
            let light_count = LIGHTS_PER_WORD.min(w.light_count - first_light);
            let params = LightParams { first_light, light_count, ..Default::default() };
            let visible = if settings.light_map > 0 {
                let lights = first_light..first_light + light_count;
                light_map::visibility(backend, w, &p.surfaces, sides, lights, settings.light_map, p.radius)?
            } else {
                let mut visible = backend.alloc("proxy visibility", sides as usize)?;
                backend.light_visibility(
                    &params,
                    &p.surfaces,
                    &w.lights,
                    &w.nodes,
                    &w.blocks,
                    &w.triangles,
                    &w.materials,
                    &w.texels,
                    &mut visible,
                    sides,
                )?;
                visible
            };
            backend.shade_diffuse(&params, &p.surfaces, &w.lights, &visible, &radiance, &mut next, sides)?;
            std::mem::swap(&mut radiance, &mut next);
            if lights > 0 {
                runs.push((LobeParams { first_light, light_count, lights, sides }, visible));
            }
        }
        if w.has_environment || w.emits {
            let flags = if w.emits { GATHER_EMISSION } else { 0 };
            let params = GatherParams { rays: job.rays, seed: job.seed, flags, ..w.environment };
            backend.gather_direct(
                &params,
                &p.surfaces,
                &w.nodes,
                &w.blocks,
                &w.triangles,
                &w.materials,
                &w.texels,
                &radiance,
                &mut next,
                sides,
            )?;
            std::mem::swap(&mut radiance, &mut next);
        }
        if lights > 0 {
            let mut gloss = backend.alloc("proxy gloss", sides as usize)?;
            let camera = Default::default();
            backend.resolve_gloss(&camera, &p.surfaces, &w.materials, &w.texels, &mut gloss, sides)?;
            for (params, visible) in runs {
                backend.add_lobes(
                    &params,
                    &p.surfaces,
                    &gloss,
                    &w.lights,
                    &visible,
                    &radiance,
                    &mut next,
                    words,
                )?;
                std::mem::swap(&mut radiance, &mut next);
            }
        }
        seen.check(backend, "proxy radiance", &radiance)?;
        let mut voxels = backend.alloc("voxels", p.grid.dims.w as usize)?;
        let grid = GridParams { weighted: u32::from(settings.gather == Gather::Share), lights, ..p.grid };
        backend.sum_voxels(&grid, &p.starts, &p.proxies, &radiance, &mut voxels, p.grid.dims.w)?;
        seen.check(backend, "voxels", &voxels)?;
        Ok(Self { radiance, voxels, lights })
    }
}

/// Words of four for the sides and two for each of their lobes.
fn word_count(sides: u32, lights: u32) -> Result<u32, BackendError> {
    let words = u64::from(sides) * (1 + 2 * u64::from(lights));
    u32::try_from(words).ok().filter(|&w| w <= 1 << 28).ok_or_else(|| {
        BackendError::Settings(SettingsError {
            knob: "proxies",
            reason: format!(
                "{sides} sides that mirror {lights} lights need {words} words, over {}; lower proxies or turn proxy-gloss off",
                1u32 << 28
            ),
        })
    })
}
