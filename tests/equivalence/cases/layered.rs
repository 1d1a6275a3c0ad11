//! Inputs of the passes of layered reflective shadow maps: the random scenes of `voxelised`, with maps of three lights.

use super::scene::{launch, previous};
use super::voxelised::{DEPTH, Voxelised, map, scatter};
use super::voxels::items;
use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::Vec3;
use twinlight::scene::Bounds;
use twinlight::technique::layered_rsm::{LayeredRsm, Moments, Weights, layered_map, reflect_params};
use twinlight::technique::light_map::map_params;
use twinlight_kernels::passes;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::layered_rsm::layers::texels_before;
use twinlight_kernels::passes::layered_rsm::texel::{MOMENTS_FLOAT, texel_words};
use twinlight_kernels::passes::layered_rsm::voxels::{level_word, voxel_words};
use twinlight_kernels::passes::voxel_cones::trace::CONES_MEAN_OPACITY;

/// Texels along a side of a light's map.
const MAP: u32 = 32;

/// A light's map, split.
struct Light {
    reflect: ReflectParams,
    hits: Vec<Hit>,
    reflected: Vec<ReflectiveTexel>,
    map: LayeredMap,
    /// Words of each level.
    levels: Vec<Vec<u32>>,
}

/// A scene's binary voxels and layered maps, on the host.
struct Layered {
    v: Voxelised,
    mean: u32,
    /// Words of each level.
    levels: Vec<Vec<u32>>,
    lights: Vec<Light>,
}

impl Light {
    fn new(v: &Voxelised, settings: &LayeredRsm, number: u32, first: u32) -> Self {
        let w = &v.world;
        let bounds = Bounds::of(&w.triangles);
        let light = map_params(&w.lights[number as usize], &bounds, MAP, 0.0);
        let hits = map(MAP * MAP, |i| {
            passes::trace_light_map(i, &light, &w.nodes, &w.blocks, &w.triangles, &w.materials, &w.texels)
        });
        let own = layered_map(&light, &bounds, settings, first);
        let reflect = reflect_params(&own, number, 0.5);
        let reflected: Vec<ReflectiveTexel> = map(MAP * MAP, |i| {
            passes::reflect_light(i, &reflect, &hits, &w.triangles, &w.materials, &w.texels, &w.lights)
        });
        let texels = |level: u32| settings.layers() * (own.size >> level) * (own.size >> level);
        let words = texel_words(own.format);
        let mut levels = vec![scatter(words * texels(0), texels(0), |i, out| {
            passes::split_layers(i, &own, &reflected, out);
        })];
        for level in 1..own.level {
            let params = LayeredMap { level, ..own };
            let below = &levels[level as usize - 1];
            levels.push(scatter(words * texels(level), texels(level), |i, out| {
                passes::shrink_layers(i, &params, below, out);
            }));
        }
        let before = words * settings.layers() * texels_before(own.size, own.level - 1);
        assert_eq!(levels.iter().map(Vec::len).sum::<usize>() as u32, before + words * settings.layers());
        Self { reflect, hits, reflected, map: own, levels }
    }
}

impl Layered {
    fn new(v: Voxelised, settings: &LayeredRsm, mean: u32) -> Self {
        let w = &v.world;
        let bits = scatter(level_word(DEPTH, 1), v.pairs.len() as u32 / 2, |i, out| {
            passes::mark_bits(i, &v.params, &v.pairs, &w.triangles, &w.materials, &w.texels, out);
        });
        let mut levels = vec![bits];
        for level in 1..=DEPTH {
            let params = ShrinkParams { depth: DEPTH, level, mean, ..Default::default() };
            let end = if level == DEPTH { voxel_words(DEPTH) } else { level_word(DEPTH, level + 1) };
            let below = &levels[level as usize - 1];
            levels.push(map(end - level_word(DEPTH, level), |i| passes::shrink_voxels(i, &params, below)));
        }
        let words = settings.words_per_light();
        // A point, a spot and a sun.
        let lights = (0..3).map(|i| Light::new(&v, settings, i, words * i)).collect();
        Self { v, mean, levels, lights }
    }

    /// Covered voxels with the default maps, and mean ones with everything as published.
    fn all(draw: &mut Draw) -> [Self; 2] {
        let [a, b] = Voxelised::all(draw);
        let usual = LayeredRsm { map: MAP, ..Default::default() };
        let published = LayeredRsm {
            depth_layers: 3,
            moments: Moments::Unorm16,
            overlap: 0.3,
            weights: Weights::Opacity,
            least_level: 0.7,
            ..usual.clone()
        };
        [Self::new(a, &usual, 0), Self::new(b, &published, 1)]
    }

    /// With moments as floats.
    fn floats(draw: &mut Draw) -> Self {
        let [a, _] = Voxelised::all(draw);
        let settings = LayeredRsm { map: MAP, moments: Moments::Float, overlap: 0.2, ..Default::default() };
        Self::new(a, &settings, 0)
    }

    fn voxels(&self) -> Vec<u32> {
        self.levels.concat()
    }

    fn maps(&self) -> Vec<LayeredMap> {
        self.lights.iter().map(|l| l.map).collect()
    }

    fn layers(&self) -> Vec<u32> {
        self.lights.iter().flat_map(|l| l.levels.concat()).collect()
    }

    fn cones(&self) -> ConeParams {
        let edge = self.v.params.lower.w;
        ConeParams {
            lower: (self.v.params.lower.truncate() - Vec3::splat(0.5 * edge)).extend(edge),
            maps: 3,
            lobes: 0,
            flags: if self.mean != 0 { CONES_MEAN_OPACITY } else { self.v.cones().flags },
            ..self.v.cones()
        }
    }
}

pub fn mark_bits(draw: &mut Draw) -> Vec<case::mark_bits> {
    Voxelised::all(draw)
        .map(|v| case::mark_bits {
            launch: Launch::new("all pairs", level_word(DEPTH, 1) as usize, v.pairs.len() as u32 / 2),
            params: v.params,
            pairs: v.pairs,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
        })
        .into()
}

pub fn shrink_voxels(draw: &mut Draw) -> Vec<case::shrink_voxels> {
    let mut cases = Vec::new();
    for l in Layered::all(draw) {
        for level in 1..=DEPTH {
            cases.push(case::shrink_voxels {
                launch: items(&format!("level {level}"), l.levels[level as usize].len()),
                params: ShrinkParams { depth: DEPTH, level, mean: l.mean, ..Default::default() },
                below: l.levels[level as usize - 1].clone(),
            });
        }
    }
    cases
}

pub fn reflect_light(draw: &mut Draw) -> Vec<case::reflect_light> {
    let mut cases = Vec::new();
    for l in Layered::all(draw) {
        for light in l.lights {
            cases.push(case::reflect_light {
                launch: items("a map", (MAP * MAP) as usize),
                params: light.reflect,
                hits: light.hits,
                triangles: l.v.world.triangles.clone(),
                materials: l.v.world.materials.clone(),
                texels: l.v.world.texels.clone(),
                lights: l.v.world.lights.clone(),
            });
        }
    }
    cases
}

/// A launch over the texels of a level; words of floats are compared in strict mode only.
fn texels(light: &Light, level: usize) -> Launch {
    let words = light.levels[level].len();
    let items = words as u32 / texel_words(light.map.format);
    let launch = Launch::new(format!("level {level}"), words, items);
    if light.map.format == MOMENTS_FLOAT { launch.strict_only() } else { launch }
}

pub fn split_layers(draw: &mut Draw) -> Vec<case::split_layers> {
    let lights = |l: Layered| l.lights;
    let all: Vec<Light> =
        Layered::all(draw).into_iter().chain([Layered::floats(draw)]).flat_map(lights).collect();
    let make = |light: Light| case::split_layers {
        launch: texels(&light, 0),
        params: LayeredMap { level: 0, ..light.map },
        reflected: light.reflected,
    };
    all.into_iter().map(make).collect()
}

pub fn shrink_layers(draw: &mut Draw) -> Vec<case::shrink_layers> {
    let mut cases = Vec::new();
    for l in Layered::all(draw).into_iter().chain([Layered::floats(draw)]) {
        for light in l.lights {
            for level in 1..light.levels.len() {
                cases.push(case::shrink_layers {
                    launch: texels(&light, level),
                    params: LayeredMap { level: level as u32, ..light.map },
                    below: light.levels[level - 1].clone(),
                });
            }
        }
    }
    cases
}

pub fn layered_diffuse(draw: &mut Draw) -> Vec<case::layered_diffuse> {
    let all = Layered::all(draw).into_iter().chain([Layered::floats(draw)]);
    all.map(|l| case::layered_diffuse {
        launch: launch("pixels"),
        params: l.cones(),
        voxels: l.voxels(),
        maps: l.maps(),
        layers: l.layers(),
        surfaces: l.v.world.surfaces,
    })
    .collect()
}

pub fn layered_specular(draw: &mut Draw) -> Vec<case::layered_specular> {
    Layered::all(draw)
        .map(|l| case::layered_specular {
            launch: launch("pixels"),
            params: l.cones(),
            voxels: l.voxels(),
            maps: l.maps(),
            layers: l.layers(),
            gloss: l.v.world.gloss(),
            surfaces: l.v.world.surfaces,
            texels: l.v.world.texels,
        })
        .into()
}

pub fn shadow_cone(draw: &mut Draw) -> Vec<case::shadow_cone> {
    let mut cases = Vec::new();
    for l in Layered::all(draw) {
        for (light, extent) in [(0, 0.3), (1, 0.0), (2, 0.05)] {
            cases.push(case::shadow_cone {
                launch: launch("pixels"),
                params: ConeParams { light, extent, maps: 0, ..l.cones() },
                voxels: l.voxels(),
                surfaces: l.v.world.surfaces.clone(),
                lights: l.v.world.lights.clone(),
            });
        }
    }
    cases
}

pub fn shade_soft_diffuse(draw: &mut Draw) -> Vec<case::shade_soft_diffuse> {
    let [l, _] = Voxelised::all(draw);
    let previous = previous(draw);
    vec![case::shade_soft_diffuse {
        launch: launch("a spot"),
        params: LightParams { first_light: 1, light_count: 1, ..l.world.light_params(0) },
        visible: previous.iter().map(|_| draw.unit()).collect(),
        surfaces: l.world.surfaces,
        lights: l.world.lights,
        previous,
    }]
}

pub fn shade_soft_specular(draw: &mut Draw) -> Vec<case::shade_soft_specular> {
    let [l, _] = Voxelised::all(draw);
    let previous = previous(draw);
    vec![case::shade_soft_specular {
        launch: launch("a spot"),
        params: LightParams { first_light: 1, light_count: 1, ..l.world.light_params(0) },
        visible: previous.iter().map(|_| draw.unit()).collect(),
        gloss: l.world.gloss(),
        surfaces: l.world.surfaces,
        lights: l.world.lights,
        previous,
    }]
}
