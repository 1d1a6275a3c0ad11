//! What does light make of the voxels? VCT §8.2.

use super::pyramid::Pyramid;
use super::{VoxelCones, frame, inject};
use crate::backend::{Backend, BackendError, BufferLength};
use crate::primitives::listed;
use crate::technique::World;
use crate::technique::voxelised::place;
use std::f32::consts::PI;
use twinlight_kernels::passes::elements::PyramidParams;
use twinlight_kernels::passes::voxel_cones::build::ISOTROPIC;
use twinlight_kernels::passes::voxel_cones::inject::RADIANCE_WORDS;
use twinlight_kernels::passes::voxel_cones::lobes::LOBE_WORDS;
use twinlight_kernels::passes::voxel_cones::storage::{storage_of, words_of};
use twinlight_kernels::passes::voxel_cones::trace::{CONES_ISOTROPIC, CONES_SEE_ENVIRONMENT};

/// Radiance of the lit voxels. It changes with the lights.
pub struct Lit<B: Backend> {
    /// The number, plus one, of each lit voxel of all levels; 0 for dark ones.
    pub places: B::Buffer<u32>,
    /// Radiance of the lit voxels in six directions, packed; then their lobes, if there are any.
    pub radiance: B::Buffer<u32>,
    /// Words before the lobes; 0 where there are none.
    pub lobes: u32,
    /// Number of lit voxels.
    pub count: u32,
    /// Units of stored radiance per W/(m² sr).
    pub radiance_scale: f32,
}

/// What voxels send.
pub struct Lighting<B: Backend> {
    /// What they reflect of lights, emissive surfaces and the environment.
    pub reflected: Lit<B>,
    /// That and what they emit, where something does: what mirrors show.
    pub shining: Option<Lit<B>>,
}

/// Words of a lit voxel's radiance.
pub(super) fn words_of_voxel(params: &PyramidParams) -> u32 {
    RADIANCE_WORDS * words_of(storage_of(params.flags))
}

/// The lit voxels of a level.
pub(super) struct Level<B: Backend> {
    /// Their numbers in the level.
    pub lit: B::Buffer<u32>,
    /// Their numbers among all lit voxels, plus one, for each voxel of the level.
    pub places: B::Buffer<u32>,
    pub count: u32,
    /// Lit voxels before them.
    first: u32,
}

/// The lit leaves with what they send.
pub(super) struct Leaves<B: Backend> {
    pub level: Level<B>,
    pub radiance: B::Buffer<u32>,
    pub lobes: Option<B::Buffer<u32>>,
}

impl<B: Backend> Level<B> {
    /// Lists the flagged voxels of a level of `voxels`; `first` lit ones stand before them.
    pub(super) fn new(
        backend: &mut B,
        params: &PyramidParams,
        flags: &B::Buffer<u32>,
        voxels: u32,
        first: u32,
    ) -> Result<Self, BackendError> {
        let (lit, starts, count) = listed(backend, flags, voxels)?;
        let mut places = backend.alloc("level places", voxels as usize)?;
        let params = PyramidParams { first_lit: first, ..*params };
        backend.lit_places(&params, flags, &starts, &mut places, voxels)?;
        Ok(Self { lit, places, count, first })
    }
}

impl<B: Backend> Lighting<B> {
    /// Injects photons of all lights, lets emissive surfaces and the environment shine on the leaves, and adds bounces
    /// beyond the first.
    pub fn new(
        backend: &mut B,
        world: &World<B>,
        p: &Pyramid<B>,
        settings: &VoxelCones,
    ) -> Result<Self, BackendError> {
        backend.set_stage("injection");
        let (of_lights, of_emission) = inject::watts(world);
        let watts = of_lights + of_emission;
        // Typical radiance: all power over all surfaces, or the environment's.
        let typical = (watts / (PI * world.area.max(1.0e-30) as f32)).max(world.mean_environment);
        let usable = typical > 0.0 && typical.is_finite();
        let params = PyramidParams {
            power_scale: inject::scale_of(of_lights),
            radiance_scale: if usable { 1.0 / typical } else { 1.0 },
            ..p.params
        };
        let mut reflected = Lit { radiance_scale: params.radiance_scale, ..Lit::dark(backend, p)? };
        if of_lights > 0.0 {
            reflected = inject::photons(backend, world, p, &params, settings)?;
        }
        let mut emitted = None;
        if of_emission > 0.0 {
            let params = PyramidParams { power_scale: inject::scale_of(of_emission), ..params };
            let shining = inject::emission(backend, world, p, &params)?;
            reflected = shining.bounced(backend, world, p, &params, settings, &reflected, false)?;
            emitted = Some(shining);
        }
        if world.has_environment {
            let dark = Lit { radiance_scale: params.radiance_scale, ..Lit::dark(backend, p)? };
            reflected = dark.bounced(backend, world, p, &params, settings, &reflected, true)?;
        }
        let mut all: Option<Lit<B>> = None;
        for _ in 1..settings.bounces {
            let from = all.as_ref().unwrap_or(&reflected);
            all = Some(from.bounced(backend, world, p, &params, settings, &reflected, false)?);
        }
        let reflected = all.unwrap_or(reflected);
        let shining = match emitted {
            Some(emitted) if world.has_mirrors => {
                let nothing =
                    backend.alloc("leaf radiance", (params.leaves * words_of_voxel(&params)) as usize)?;
                let emitted = emitted.plus(backend, world, p, settings, &nothing)?;
                let sum = reflected.plus(backend, world, p, settings, &emitted)?;
                Some(relit(backend, p, &params, &sum, &reflected)?)
            }
            _ => None,
        };
        Ok(Self { reflected, shining })
    }

    /// Number of lit voxels, and bytes of all.
    pub fn size(&self) -> (u32, u64) {
        let words = |l: &Lit<B>| l.places.element_count() + l.radiance.element_count();
        let all = words(&self.reflected) + self.shining.as_ref().map_or(0, words);
        (self.reflected.count, 4 * all as u64)
    }
}

impl<B: Backend> Lit<B> {
    /// No lit voxel.
    pub fn dark(backend: &mut B, p: &Pyramid<B>) -> Result<Self, BackendError> {
        Ok(Self {
            places: backend.alloc("lit places", p.voxels() as usize)?,
            radiance: backend.alloc("radiance", 1)?,
            lobes: 0,
            count: 0,
            radiance_scale: 1.0,
        })
    }

    /// `direct`, plus what every leaf reflects of this light, or of the environment.
    fn bounced(
        &self,
        backend: &mut B,
        world: &World<B>,
        p: &Pyramid<B>,
        params: &PyramidParams,
        settings: &VoxelCones,
        direct: &Self,
        environment: bool,
    ) -> Result<Self, BackendError> {
        backend.set_stage("bounces");
        let mut cones = frame::cone_params(world, p, self, settings);
        cones.cones = settings.bounce_cones;
        cones.flags |= if environment { CONES_SEE_ENVIRONMENT } else { 0 };
        let words = params.leaves * words_of_voxel(params);
        let mut bounced = backend.alloc("bounced radiance", words as usize)?;
        backend.bounce_radiance(
            &cones,
            &p.points[0],
            &p.sums,
            &p.blocks,
            &p.depths,
            &self.places,
            &self.radiance,
            &world.texels,
            &mut bounced,
            words,
        )?;
        let sum = direct.plus(backend, world, p, settings, &bounced)?;
        relit(backend, p, params, &sum, direct)
    }

    /// The radiance of all leaves: what lit ones send, and `more`.
    fn plus(
        &self,
        backend: &mut B,
        world: &World<B>,
        p: &Pyramid<B>,
        settings: &VoxelCones,
        more: &B::Buffer<u32>,
    ) -> Result<B::Buffer<u32>, BackendError> {
        let mut cones = frame::cone_params(world, p, self, settings);
        cones.flags |= if p.params.flags & ISOTROPIC != 0 { CONES_ISOTROPIC } else { 0 };
        let words = p.params.leaves * words_of_voxel(&p.params);
        let mut sum = backend.alloc("leaf radiance", words as usize)?;
        backend.add_bounce(&cones, &self.places, &self.radiance, more, &mut sum, words)?;
        Ok(sum)
    }
}

/// Lit voxels of all levels from the radiance of all leaves, with the lobes of `direct`.
fn relit<B: Backend>(
    backend: &mut B,
    p: &Pyramid<B>,
    params: &PyramidParams,
    all: &B::Buffer<u32>,
    direct: &Lit<B>,
) -> Result<Lit<B>, BackendError> {
    let mut flags = backend.alloc("lit leaves", params.leaves as usize)?;
    let own = PyramidParams { lobes: direct.lobes, ..*params };
    backend.mark_bright(&own, all, &direct.places, &direct.radiance, &mut flags, params.leaves)?;
    let level = Level::new(backend, params, &flags, params.leaves, 0)?;
    let words = words_of_voxel(params);
    let mut radiance = backend.alloc("lit radiance", (level.count.max(1) * words) as usize)?;
    backend.keep_lit(params, &level.lit, all, &mut radiance, level.count * words)?;
    let mut lobes = None;
    if direct.lobes > 0 {
        let params = PyramidParams { lobes: direct.lobes, ..*params };
        let mut kept = backend.alloc("lobes", (level.count.max(1) * LOBE_WORDS) as usize)?;
        let words = level.count * LOBE_WORDS;
        backend.keep_lobes(&params, &level.lit, &direct.places, &direct.radiance, &mut kept, words)?;
        lobes = Some(kept);
    }
    filtered(backend, p, params, Leaves { level, radiance, lobes })
}

/// All levels from the lit leaves upward.
pub(super) fn filtered<B: Backend>(
    backend: &mut B,
    p: &Pyramid<B>,
    params: &PyramidParams,
    leaves: Leaves<B>,
) -> Result<Lit<B>, BackendError> {
    backend.set_stage("filtering");
    let at = |level: u32| {
        let (own, voxels) = p.level(level);
        let scales = (params.power_scale, params.radiance_scale);
        (PyramidParams { power_scale: scales.0, radiance_scale: scales.1, ..own }, voxels)
    };
    let mut levels = vec![leaves.level];
    for level in 1..=params.depth {
        let (own, voxels) = at(level);
        let below = &levels[level as usize - 1];
        let mut flags = backend.alloc("lit voxels", voxels as usize)?;
        let points = &p.points[level as usize - 1];
        backend.mark_lit_parents(&own, &below.lit, points, &p.blocks, &mut flags, below.count)?;
        let first = below.first + below.count;
        levels.push(Level::new(backend, &own, &flags, voxels, first)?);
    }
    let count = levels.last().map_or(0, |l| l.first + l.count);
    let voxel_words = words_of_voxel(params);
    let lobes = if leaves.lobes.is_some() { count * voxel_words } else { 0 };
    let words = count * voxel_words + if lobes > 0 { count * LOBE_WORDS } else { 0 };
    let mut places = backend.alloc("lit places", p.voxels() as usize)?;
    let mut radiance = backend.alloc("radiance", words.max(1) as usize)?;
    let (mut below, mut lobes_below) = (leaves.radiance, leaves.lobes);
    for (level, own) in levels.iter().enumerate() {
        let (base, _) = at(level as u32);
        if level > 0 {
            let children = &levels[level - 1];
            let base = PyramidParams { child_first_lit: children.first, ..base };
            let (points, blocks, depths) = (&p.points[level], &p.blocks, &p.depths);
            let count = own.count.max(1) as usize;
            let mut next = backend.alloc("level radiance", count * voxel_words as usize)?;
            let lit = &own.lit;
            backend.filter_radiance(
                &base,
                lit,
                points,
                blocks,
                depths,
                &children.places,
                &below,
                &mut next,
                own.count,
            )?;
            below = next;
            if let Some(lobes) = &mut lobes_below {
                let mut next = backend.alloc("level lobes", count * LOBE_WORDS as usize)?;
                backend.filter_lobes(
                    &base,
                    lit,
                    points,
                    blocks,
                    depths,
                    &children.places,
                    lobes,
                    &mut next,
                    own.count,
                )?;
                *lobes = next;
            }
        }
        place(backend, &own.places, base.first, &mut places)?;
        if own.count > 0 {
            place(backend, &below, own.first * voxel_words, &mut radiance)?;
            if let Some(own_lobes) = &lobes_below {
                place(backend, own_lobes, lobes + own.first * LOBE_WORDS, &mut radiance)?;
            }
        }
    }
    Ok(Lit { places, radiance, lobes, count, radiance_scale: params.radiance_scale })
}
