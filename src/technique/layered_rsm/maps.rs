//! What does each light see, in layers? LRSM §4.

use super::{LayeredRsm, Weights};
use crate::backend::{Backend, BackendError, BufferLength};
use crate::scene::Bounds;
use crate::technique::World;
use crate::technique::light_map::map_params;
use crate::technique::voxelised::place;
use glam::Vec3;
use std::ops::Range;
use twinlight_kernels::passes::elements::{LayeredMap, LightMapParams, ReflectParams, ReflectiveTexel};
use twinlight_kernels::passes::layered_rsm::layers::{farthest_squared, texels_before};
use twinlight_kernels::passes::layered_rsm::lookup::WEIGH_OPACITY;
use twinlight_kernels::passes::layered_rsm::texel::texel_words;
use twinlight_kernels::passes::light_map::{PROJECT_OCTAHEDRON, PROJECT_PARALLEL};

/// Layered maps of several lights, as lookups read them.
pub struct LayeredMaps<B: Backend> {
    /// One for each light.
    pub maps: B::Buffer<LayeredMap>,
    /// Their layers, level after level.
    pub layers: B::Buffer<u32>,
    /// The maps on the host.
    pub host: Vec<LayeredMap>,
}

/// A light's reflective shadow map before it is split.
pub struct ReflectiveMap<B: Backend> {
    /// Texels, row-major.
    pub texels: B::Buffer<ReflectiveTexel>,
    /// How it lies over the scene.
    pub params: LightMapParams,
}

/// The depths, along a light's rays, between which a box lies.
fn depths(map: &LightMapParams, bounds: &Bounds) -> (f32, f32) {
    let origin = map.origin.truncate();
    let corner = |i: u32| {
        let pick = |bit: u32, low: f32, high: f32| if i >> bit & 1 == 0 { low } else { high };
        let (l, h) = (bounds.min, bounds.max);
        Vec3::new(pick(0, l.x, h.x), pick(1, l.y, h.y), pick(2, l.z, h.z))
    };
    if map.projection == PROJECT_PARALLEL {
        let along = |i: u32| (corner(i) - origin).dot(map.forward.truncate());
        let (first, rest) = (along(0), 1..8);
        return rest.map(along).fold((first, first), |(low, high), d| (low.min(d), high.max(d)));
    }
    let near = origin.clamp(bounds.min, bounds.max).distance(origin);
    (near, (0..8).map(|i| corner(i).distance(origin)).fold(near, f32::max))
}

/// Returns the layers of a light's map whose first word among all is `first`, ready to be looked up.
pub fn layered_map(map: &LightMapParams, bounds: &Bounds, settings: &LayeredRsm, first: u32) -> LayeredMap {
    let (near, far) = depths(map, bounds);
    let thickness = (far - near).max(1.0e-6 * far.abs()).max(1.0e-9) / settings.depth_layers as f32;
    let levels = settings.levels();
    LayeredMap {
        origin: map.origin,
        right: map.right,
        down: map.down,
        forward: map.forward,
        projection: map.projection,
        size: settings.map / 2,
        level: levels,
        first,
        depth_layers: settings.depth_layers,
        normal_layers: settings.normal_layers,
        format: settings.format(),
        flags: if settings.weights == Weights::Opacity { WEIGH_OPACITY } else { 0 },
        // Shadows are told with twice the mean width of an octahedron's texel.
        texel: if map.projection == PROJECT_OCTAHEDRON { map.texel } else { 2.0 * map.texel },
        near,
        thickness,
        overlap: settings.overlap * thickness,
        window: settings.window,
        footprint: settings.footprint,
        least_level: settings.least_level.min(levels as f32 - 1.0),
        deviation: settings.least_deviation(),
    }
}

/// How the texels of a light's map are told to its layers: as radiance where that is filtered, else as flux.
pub fn reflect_params(map: &LayeredMap, light: u32, radiance_scale: f32) -> ReflectParams {
    let parallel = map.projection == PROJECT_PARALLEL;
    ReflectParams {
        light,
        radiance_scale,
        flux: u32::from(map.flags & WEIGH_OPACITY == 0),
        inverse_squared: if parallel { 0.0 } else { 1.0 / farthest_squared(map) },
    }
}

/// Traces the map of the light that `reflect` names, of `size` × `size` texels, and finds what each texel reflects.
pub fn reflective_map<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    size: u32,
    reflect: &ReflectParams,
) -> Result<ReflectiveMap<B>, BackendError> {
    let w = world;
    let params = map_params(&w.host_lights[reflect.light as usize], &w.bounds, size, 0.0);
    let count = size * size;
    let mut hits = backend.alloc("light map", count as usize)?;
    backend.trace_light_map(
        &params,
        &w.nodes,
        &w.blocks,
        &w.triangles,
        &w.materials,
        &w.texels,
        &mut hits,
        count,
    )?;
    let mut texels = backend.alloc("reflective map", count as usize)?;
    backend.reflect_light(
        reflect,
        &hits,
        &w.triangles,
        &w.materials,
        &w.texels,
        &w.lights,
        &mut texels,
        count,
    )?;
    Ok(ReflectiveMap { texels, params })
}

impl<B: Backend> LayeredMaps<B> {
    /// Makes the layered maps of some lights, all in one buffer.
    pub fn build(
        backend: &mut B,
        world: &World<B>,
        settings: &LayeredRsm,
        lights: Range<u32>,
        radiance_scale: f32,
    ) -> Result<Self, BackendError> {
        let words = settings.words_per_light();
        let mut layers = backend.alloc("layered maps", (words * lights.len().max(1) as u32) as usize)?;
        let mut host = Vec::new();
        for (number, light) in lights.enumerate() {
            let params = map_params(&world.host_lights[light as usize], &world.bounds, settings.map, 0.0);
            let own = layered_map(&params, &world.bounds, settings, words * number as u32);
            let reflect = reflect_params(&own, light, radiance_scale);
            let map = reflective_map(backend, world, settings.map, &reflect)?;
            split(backend, &own, &map.texels, &mut layers)?;
            host.push(own);
        }
        // All levels are made: the layers do not depend on how they are looked up.
        let levels = settings.most_level.map_or(u32::MAX, |most| most + 1);
        host.iter_mut().for_each(|map: &mut LayeredMap| map.level = map.level.min(levels));
        let none = [LayeredMap::default()];
        let maps = backend.upload("maps", if host.is_empty() { &none } else { &host[..] })?;
        Ok(Self { maps, layers, host })
    }

    /// Bytes of the layers.
    pub fn bytes(&self) -> u64 {
        4 * self.layers.element_count() as u64
    }
}

/// Splits a map into layers and filters them, level by level.
fn split<B: Backend>(
    backend: &mut B,
    map: &LayeredMap,
    texels: &B::Buffer<ReflectiveTexel>,
    layers: &mut B::Buffer<u32>,
) -> Result<(), BackendError> {
    let count = map.depth_layers * map.normal_layers;
    let words = texel_words(map.format);
    let of_level = |level: u32| count * (map.size >> level) * (map.size >> level);
    let mut level = backend.alloc("layers", (words * of_level(0)) as usize)?;
    backend.split_layers(&LayeredMap { level: 0, ..*map }, texels, &mut level, of_level(0))?;
    place(backend, &level, map.first, layers)?;
    for number in 1..map.level {
        let mut next = backend.alloc("layers", (words * of_level(number)) as usize)?;
        backend.shrink_layers(&LayeredMap { level: number, ..*map }, &level, &mut next, of_level(number))?;
        place(backend, &next, map.first + words * count * texels_before(map.size, number), layers)?;
        level = next;
    }
    Ok(())
}
