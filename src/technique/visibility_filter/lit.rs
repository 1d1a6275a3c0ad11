//! What does light make of the proxies? VF §3.1.

use super::{Gather, Proxies, VisibilityFilter};
use crate::backend::{Backend, BackendError};
use crate::technique::{Inspection, Job, World, light_map};
use glam::Vec4;
use twinlight_kernels::passes::elements::{GatherParams, GridParams, LightParams, Voxel};
use twinlight_kernels::passes::gather::GATHER_EMISSION;
use twinlight_kernels::passes::light::LIGHTS_PER_WORD;

/// The proxies as lights. They change with the lights.
pub struct Lit<B: Backend> {
    /// Radiance of each proxy's front and back.
    pub radiance: B::Buffer<Vec4>,
    /// What each voxel sends out.
    pub voxels: B::Buffer<Voxel>,
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
        let mut radiance = backend.alloc("proxy radiance", sides as usize)?;
        backend.dark_sides(&p.grid, &p.openness, &mut radiance, sides)?;
        let mut next = backend.alloc("proxy radiance", sides as usize)?;
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
        seen.check(backend, "proxy radiance", &radiance)?;
        let mut voxels = backend.alloc("voxels", p.grid.dims.w as usize)?;
        let grid = GridParams { weighted: u32::from(settings.gather == Gather::Share), ..p.grid };
        backend.sum_voxels(&grid, &p.starts, &p.proxies, &radiance, &mut voxels, p.grid.dims.w)?;
        seen.check(backend, "voxels", &voxels)?;
        Ok(Self { radiance, voxels })
    }
}
