//! What does light make of the voxels? VCT §8.2.

use super::pyramid::{Pyramid, place};
use super::{VoxelCones, frame};
use crate::backend::{Backend, BackendError};
use crate::primitives::exclusive_scan;
use crate::technique::light_map::map_params;
use crate::technique::{Inspection, World};
use std::f32::consts::PI;
use twinlight_kernels::passes::elements::{Hit, Light, PhotonParams, PyramidParams};
use twinlight_kernels::passes::scene::{LIGHT_SPOT, LIGHT_SUN};
use twinlight_kernels::passes::voxel_cones::inject::{POWER_WORDS, RADIANCE_WORDS};

/// Radiance of the lit voxels. It changes with the lights.
pub struct Lit<B: Backend> {
    /// The number, plus one, of each lit voxel of all levels; 0 for dark ones.
    pub places: B::Buffer<u32>,
    /// Radiance of the lit voxels in six directions, packed.
    pub radiance: B::Buffer<u32>,
    /// Number of lit voxels.
    pub count: u32,
    /// Units of stored radiance per W/(m² sr).
    pub radiance_scale: f32,
}

/// The lit voxels of a level.
struct Level<B: Backend> {
    lit: B::Buffer<u32>,
    places: B::Buffer<u32>,
    count: u32,
    first: u32,
}

/// The power of a light on the scene, at most, in watts of its strongest colour.
fn power(light: &Light, radius: f32) -> f32 {
    let strength = light.intensity.truncate().max_element();
    match light.kind {
        LIGHT_SUN => strength * (2.0 * radius) * (2.0 * radius),
        LIGHT_SPOT => strength * 2.0 * PI * (1.0 - light.outer.cos()).max(1.0e-6),
        _ => strength * 4.0 * PI,
    }
}

impl<B: Backend> Lit<B> {
    /// No lit voxel.
    pub fn dark(backend: &mut B, p: &Pyramid<B>) -> Result<Self, BackendError> {
        Ok(Self {
            places: backend.alloc("lit places", p.voxels() as usize)?,
            radiance: backend.alloc("radiance", 1)?,
            count: 0,
            radiance_scale: 1.0,
        })
    }

    /// Injects photons of all lights and emission, lets the environment in, and adds bounces beyond the first.
    pub fn light(
        backend: &mut B,
        world: &World<B>,
        p: &Pyramid<B>,
        settings: &VoxelCones,
        seen: &mut Inspection<'_>,
    ) -> Result<Self, BackendError> {
        backend.set_stage("injection");
        let emitted = if world.emits { PI * world.area as f32 * world.largest_emission } else { 0.0 };
        let radius = 0.505 * world.bounds.size().length().max(1.0e-6);
        let watts = world.host_lights.iter().map(|l| power(l, radius)).sum::<f32>() + emitted;
        // Typical radiance: all power over all surfaces, or the environment's.
        let typical = (watts / (PI * world.area.max(1.0e-30) as f32)).max(world.mean_environment);
        let usable = typical > 0.0 && typical.is_finite();
        let params = PyramidParams {
            // Not even all of the power in one place overflows.
            power_scale: if watts > 0.0 { 2.0e9 / watts } else { 0.0 },
            radiance_scale: if usable { 1.0 / typical } else { 1.0 },
            ..p.params
        };
        let mut lit = Self::dark(backend, p)?;
        lit.radiance_scale = params.radiance_scale;
        if watts > 0.0 {
            lit = photons(backend, world, p, &params, settings)?;
        }
        if world.has_environment || settings.bounces > 1 {
            lit = lit.with_bounces(backend, world, p, &params, settings)?;
        }
        let _ = seen;
        Ok(lit)
    }

    /// Light from the environment, and bounces beyond the first.
    fn with_bounces(
        self,
        backend: &mut B,
        world: &World<B>,
        p: &Pyramid<B>,
        params: &PyramidParams,
        settings: &VoxelCones,
    ) -> Result<Self, BackendError> {
        let mut direct = self;
        if world.has_environment {
            let dark = Self { radiance_scale: params.radiance_scale, ..Self::dark(backend, p)? };
            direct = dark.bounced(backend, world, p, params, settings, &direct, true)?;
        }
        let mut all: Option<Self> = None;
        for _ in 1..settings.bounces {
            let from = all.as_ref().unwrap_or(&direct);
            all = Some(from.bounced(backend, world, p, params, settings, &direct, false)?);
        }
        Ok(all.unwrap_or(direct))
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
        cones.lit_by_environment = u32::from(environment);
        let words = params.leaves * RADIANCE_WORDS;
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
        let mut sum = backend.alloc("leaf radiance", words as usize)?;
        backend.add_bounce(&cones, &direct.places, &direct.radiance, &bounced, &mut sum, words)?;
        let mut flags = backend.alloc("lit leaves", params.leaves as usize)?;
        backend.mark_bright(params, &sum, &mut flags, params.leaves)?;
        let leaves = Level::new(backend, params, &flags, params.leaves, 0)?;
        let mut own = backend.alloc("lit radiance", (leaves.count.max(1) * RADIANCE_WORDS) as usize)?;
        backend.keep_lit(params, &leaves.lit, &sum, &mut own, leaves.count * RADIANCE_WORDS)?;
        filtered(backend, p, params, leaves, own)
    }
}

impl<B: Backend> Level<B> {
    /// Lists the flagged voxels of a level of `voxels`; `first` lit ones stand before them.
    fn new(
        backend: &mut B,
        params: &PyramidParams,
        flags: &B::Buffer<u32>,
        voxels: u32,
        first: u32,
    ) -> Result<Self, BackendError> {
        let starts = exclusive_scan(backend, flags, voxels)?;
        let (lit, count) = crate::primitives::compact(backend, flags, voxels)?;
        let mut places = backend.alloc("level places", voxels as usize)?;
        backend.lit_places(
            &PyramidParams { first_lit: first, ..*params },
            flags,
            &starts,
            &mut places,
            voxels,
        )?;
        Ok(Self { lit, places, count, first })
    }
}

/// Photons of all lights, and what surfaces emit.
fn photons<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    p: &Pyramid<B>,
    params: &PyramidParams,
    settings: &VoxelCones,
) -> Result<Lit<B>, BackendError> {
    let w = world;
    let size = settings.light_map;
    let texels = size * size;
    let mut flags = backend.alloc("lit leaves", params.leaves as usize)?;
    let mut maps: Vec<(PhotonParams, B::Buffer<Hit>)> = Vec::new();
    for (number, light) in w.host_lights.iter().enumerate() {
        let map = map_params(light, &w.bounds, size, 0.0);
        let mut hits = backend.alloc("light map", texels as usize)?;
        backend.trace_light_map(
            &map,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut hits,
            texels,
        )?;
        let photon = PhotonParams {
            lower: params.lower,
            inverse_edge: params.inverse_edge,
            depth: params.depth,
            first: params.first,
            light: number as u32,
            projection: map.projection,
            size,
            spread: map.right.truncate().length(),
            scale: params.power_scale,
        };
        backend.mark_lit(&photon, &hits, &w.triangles, &p.blocks, &mut flags, texels)?;
        maps.push((photon, hits));
    }
    let (tris, mats) = (&w.triangles, &w.materials);
    if w.emits {
        backend.mark_emissive(
            params,
            &p.pairs,
            &p.blocks,
            tris,
            mats,
            &w.texels,
            &mut flags,
            p.pair_count,
        )?;
    }
    let leaves = Level::new(backend, params, &flags, params.leaves, 0)?;
    let mut power = backend.alloc("lit power", (leaves.count.max(1) * POWER_WORDS) as usize)?;
    for (photon, hits) in &maps {
        backend.inject_photons(
            photon,
            hits,
            tris,
            mats,
            &w.texels,
            &w.lights,
            &p.blocks,
            &leaves.places,
            &mut power,
            texels,
        )?;
    }
    if w.emits {
        backend.inject_emission(
            params,
            &p.pairs,
            &p.blocks,
            tris,
            mats,
            &w.texels,
            &leaves.places,
            &mut power,
            p.pair_count,
        )?;
    }
    let words = leaves.count * RADIANCE_WORDS;
    let mut own = backend.alloc("lit radiance", words.max(1) as usize)?;
    backend.lit_radiance(params, &leaves.lit, &p.sums, &power, &mut own, words)?;
    filtered(backend, p, params, leaves, own)
}

/// All levels from the lit leaves upward.
fn filtered<B: Backend>(
    backend: &mut B,
    p: &Pyramid<B>,
    params: &PyramidParams,
    leaves: Level<B>,
    leaf_radiance: B::Buffer<u32>,
) -> Result<Lit<B>, BackendError> {
    backend.set_stage("filtering");
    let at = |level: u32| {
        let (own, voxels) = p.level(level);
        let scales = (params.power_scale, params.radiance_scale);
        (PyramidParams { power_scale: scales.0, radiance_scale: scales.1, ..own }, voxels)
    };
    let mut levels = vec![leaves];
    for level in 1..=params.depth {
        let (own, voxels) = at(level);
        let below = &levels[level as usize - 1];
        let mut flags = backend.alloc("lit voxels", voxels as usize)?;
        backend.mark_lit_parents(
            &own,
            &below.lit,
            &p.points[level as usize - 1],
            &p.blocks,
            &mut flags,
            below.count,
        )?;
        let first = below.first + below.count;
        levels.push(Level::new(backend, &own, &flags, voxels, first)?);
    }
    let count = levels.last().map_or(0, |l| l.first + l.count);
    let mut places = backend.alloc("lit places", p.voxels() as usize)?;
    let mut radiance = backend.alloc("radiance", (count.max(1) * RADIANCE_WORDS) as usize)?;
    let mut below = leaf_radiance;
    for (level, own) in levels.iter().enumerate() {
        let (base, _) = at(level as u32);
        if level > 0 {
            let children = &levels[level - 1];
            let words = own.count.max(1) * RADIANCE_WORDS;
            let mut next = backend.alloc("level radiance", words as usize)?;
            let base = PyramidParams { child_first_lit: children.first, ..base };
            backend.filter_radiance(
                &base,
                &own.lit,
                &p.points[level],
                &p.blocks,
                &p.depths,
                &children.places,
                &below,
                &mut next,
                own.count,
            )?;
            below = next;
        }
        place(backend, &own.places, base.first, &mut places)?;
        if own.count > 0 {
            place(backend, &below, own.first * RADIANCE_WORDS, &mut radiance)?;
        }
    }
    Ok(Lit { places, radiance, count, radiance_scale: params.radiance_scale })
}
