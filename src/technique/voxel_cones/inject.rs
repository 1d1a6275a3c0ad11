//! What do lights and emissive surfaces leave with the leaves? VCT §8.2.

use super::VoxelCones;
use super::lit::{Leaves, Level, Lit, filtered, words_of_voxel};
use super::pyramid::Pyramid;
use crate::backend::{Backend, BackendError};
use crate::technique::World;
use crate::technique::light_map::map_params;
use std::f32::consts::PI;
use twinlight_kernels::passes::elements::{Hit, Light, PhotonParams, PyramidParams};
use twinlight_kernels::passes::scene::{LIGHT_SPOT, LIGHT_SUN};
use twinlight_kernels::passes::voxel_cones::inject::POWER_WORDS;
use twinlight_kernels::passes::voxel_cones::lobes::{LOBE_POWER_WORDS, LOBE_WORDS};

/// Bytes of photon maps that are kept between marking and injection; beyond, they are traced twice.
const MAPS_KEPT: u64 = 256 << 20;

/// The power of a light on the scene, at most, in watts of its strongest colour.
fn power(light: &Light, radius: f32) -> f32 {
    let strength = light.intensity.truncate().max_element();
    match light.kind {
        LIGHT_SUN => strength * (2.0 * radius) * (2.0 * radius),
        LIGHT_SPOT => strength * 2.0 * PI * (1.0 - light.outer.cos()).max(1.0e-6),
        _ => strength * 4.0 * PI,
    }
}

/// Watts of all lights on the scene, and of what its surfaces emit.
pub(in crate::technique) fn watts<B: Backend>(world: &World<B>) -> (f32, f32) {
    let radius = 0.505 * world.bounds.size().length().max(1.0e-6);
    let lights = world.host_lights.iter().map(|l| power(l, radius)).sum::<f32>();
    (lights, if world.emits { PI * world.area as f32 * world.largest_emission } else { 0.0 })
}

/// Units of power per watt: not even all of the power in one place overflows.
pub(super) fn scale_of(watts: f32) -> f32 {
    if watts > 0.0 { 2.0e9 / watts } else { 0.0 }
}

/// Photons of light `number`, and what each meets.
fn trace<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    params: &PyramidParams,
    number: usize,
    size: u32,
) -> Result<(PhotonParams, B::Buffer<Hit>), BackendError> {
    let w = world;
    let map = map_params(&w.host_lights[number], &w.bounds, size, 0.0);
    let texels = size * size;
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
    let photons = PhotonParams {
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
    Ok((photons, hits))
}

/// What photons of all lights leave.
pub(super) fn photons<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    p: &Pyramid<B>,
    params: &PyramidParams,
    settings: &VoxelCones,
) -> Result<Lit<B>, BackendError> {
    let w = world;
    let texels = settings.light_map * settings.light_map;
    let mut flags = backend.alloc("lit leaves", params.leaves as usize)?;
    let mut kept = Vec::new();
    for number in 0..w.host_lights.len() {
        let traced = trace(backend, world, params, number, settings.light_map)?;
        backend.mark_lit(&traced.0, &traced.1, &w.triangles, &p.blocks, &mut flags, texels)?;
        let fits = (kept.len() as u64 + 1) * u64::from(texels) * size_of::<Hit>() as u64 <= MAPS_KEPT;
        kept.push(fits.then_some(traced));
    }
    let level = Level::new(backend, params, &flags, params.leaves, 0)?;
    let mut power = backend.alloc("lit power", (level.count.max(1) * POWER_WORDS) as usize)?;
    let mut lobes = match w.has_gloss {
        true => Some(backend.alloc("lobe power", (level.count.max(1) * LOBE_POWER_WORDS) as usize)?),
        false => None,
    };
    for (number, traced) in kept.into_iter().enumerate() {
        let (photons, hits) = match traced {
            Some(traced) => traced,
            None => trace(backend, world, params, number, settings.light_map)?,
        };
        let (tris, mats) = (&w.triangles, &w.materials);
        let (blocks, places) = (&p.blocks, &level.places);
        backend.inject_photons(
            &photons, &hits, tris, mats, &w.texels, &w.lights, blocks, places, &mut power, texels,
        )?;
        if let Some(lobes) = &mut lobes {
            backend.inject_lobes(
                &photons, &hits, tris, mats, &w.texels, &w.lights, blocks, places, lobes, texels,
            )?;
        }
    }
    let lobes = match lobes {
        None => None,
        Some(power) => {
            let mut lobes = backend.alloc("lobes", (level.count.max(1) * LOBE_WORDS) as usize)?;
            backend.lit_lobes(params, &level.lit, &p.sums, &power, &mut lobes, level.count)?;
            Some(lobes)
        }
    };
    finished(backend, p, params, level, &power, lobes)
}

/// What surfaces emit.
pub(super) fn emission<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    p: &Pyramid<B>,
    params: &PyramidParams,
) -> Result<Lit<B>, BackendError> {
    let (tris, mats, texels) = (&world.triangles, &world.materials, &world.texels);
    let mut flags = backend.alloc("lit leaves", params.leaves as usize)?;
    backend.mark_emissive(params, &p.pairs, &p.blocks, tris, mats, texels, &mut flags, p.pair_count)?;
    let level = Level::new(backend, params, &flags, params.leaves, 0)?;
    let mut power = backend.alloc("lit power", (level.count.max(1) * POWER_WORDS) as usize)?;
    let places = &level.places;
    backend.inject_emission(
        params,
        &p.pairs,
        &p.blocks,
        tris,
        mats,
        texels,
        places,
        &mut power,
        p.pair_count,
    )?;
    finished(backend, p, params, level, &power, None)
}

/// Radiance from power, then all levels.
fn finished<B: Backend>(
    backend: &mut B,
    p: &Pyramid<B>,
    params: &PyramidParams,
    level: Level<B>,
    power: &B::Buffer<u32>,
    lobes: Option<B::Buffer<u32>>,
) -> Result<Lit<B>, BackendError> {
    let words = level.count * words_of_voxel(params);
    let mut radiance = backend.alloc("lit radiance", words.max(1) as usize)?;
    backend.lit_radiance(params, &level.lit, &p.sums, power, &mut radiance, words)?;
    filtered(backend, p, params, Leaves { level, radiance, lobes })
}
