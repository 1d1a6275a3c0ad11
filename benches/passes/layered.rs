//! On which inputs are the passes of layered reflective shadow maps timed? The same scene in 64³ voxels, a map of 256².

use super::{COUNT, Case, SIDE, Samples, copy, floats, map, vectors};
use glam::Vec4;
use twinlight::backend::Cpu;
use twinlight::technique::World;
use twinlight::technique::layered_rsm::{
    BinaryVoxels, LayeredMaps, LayeredRsm, ReflectiveMap, reflective_map,
};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::layered_rsm::layers::texels_before;
use twinlight_kernels::passes::layered_rsm::texel::texel_words;
use twinlight_kernels::passes::layered_rsm::voxels::level_word;

type Words = Vec<u32>;

/// The scene's binary voxels, and what its light sees.
pub struct Layered {
    voxels: BinaryVoxels<Cpu>,
    map: ReflectiveMap<Cpu>,
    maps: LayeredMaps<Cpu>,
}

impl Layered {
    /// Runs the technique up to its maps.
    pub fn new(cpu: &mut Cpu, w: &World<Cpu>) -> Result<Self, Box<dyn std::error::Error>> {
        let settings = LayeredRsm { resolution: 64, map: SIDE, ..Default::default() };
        Ok(Self {
            voxels: BinaryVoxels::build(cpu, w, &settings)?,
            map: reflective_map(cpu, w, SIDE, &ReflectParams { radiance_scale: 1.0, ..Default::default() })?,
            maps: LayeredMaps::build(cpu, w, &settings, 0..1, 1.0)?,
        })
    }

    fn one(&self) -> LayeredMap {
        self.maps.host[0]
    }

    fn cones(&self, s: &Samples) -> ConeParams {
        ConeParams {
            lower: self.voxels.lower,
            eye: s.camera.eye,
            inverse_edge: 1.0 / self.voxels.lower.w,
            depth: self.voxels.depth,
            cones: 6,
            width: 0.5,
            step: 0.5,
            start: 1.0,
            clearance: 2.0,
            cutoff: 0.01,
            reach: 1.0e9,
            radiance_unit: 1.0,
            radiance_scale: 1.0,
            maps: 1,
            extent: 0.1,
            ..Default::default()
        }
    }
}

pub fn mark_bits(s: &Samples) -> Case<PyramidParams, (Words, Vec<Triangle>, Vec<Material>, Words)> {
    let (params, pairs) = s.voxels.pairs();
    let (materials, texels) = s.materials();
    let items = pairs.len() as u32 / 2;
    let outputs = level_word(params.depth, 1);
    Case { params, inputs: (pairs, s.triangles(), materials, texels), outputs, items }
}

pub fn shrink_voxels(s: &Samples) -> Case<ShrinkParams, (Words,)> {
    let depth = s.layered.voxels.depth;
    let bits = copy(&s.layered.voxels.words)[..level_word(depth, 1) as usize].to_vec();
    let params = ShrinkParams { depth, level: 1, ..Default::default() };
    map(params, (bits,), level_word(depth, 2) - level_word(depth, 1))
}

type ReflectLight = (Vec<Hit>, Vec<Triangle>, Vec<Material>, Words, Vec<Light>);

pub fn reflect_light(s: &Samples) -> Case<ReflectParams, ReflectLight> {
    let (materials, texels) = s.materials();
    let params = ReflectParams { radiance_scale: 1.0, ..Default::default() };
    let hits = s.filter.light_map_hits.clone();
    map(params, (hits, s.triangles(), materials, texels, copy(&s.world.lights)), COUNT)
}

pub fn split_layers(s: &Samples) -> Case<LayeredMap, (Vec<ReflectiveTexel>,)> {
    let params = LayeredMap { level: 0, ..s.layered.one() };
    let items = params.depth_layers * params.normal_layers * params.size * params.size;
    let outputs = items * texel_words(params.format);
    Case { params, inputs: (copy(&s.layered.map.texels),), outputs, items }
}

pub fn shrink_layers(s: &Samples) -> Case<LayeredMap, (Words,)> {
    let params = LayeredMap { level: 1, ..s.layered.one() };
    let layers = params.depth_layers * params.normal_layers;
    let words = texel_words(params.format);
    let below = (texels_before(params.size, 1) * layers * words) as usize;
    let items = layers * (params.size / 2) * (params.size / 2);
    let inputs = (copy(&s.layered.maps.layers)[..below].to_vec(),);
    Case { params, inputs, outputs: items * words, items }
}

type Diffuse = (Vec<Surface>, Words, Vec<LayeredMap>, Words);

pub fn layered_diffuse(s: &Samples) -> Case<ConeParams, Diffuse> {
    let l = &s.layered;
    let inputs = (copy(&s.surfaces), copy(&l.voxels.words), copy(&l.maps.maps), copy(&l.maps.layers));
    map(l.cones(s), inputs, COUNT)
}

type Specular = (Vec<Surface>, Vec<Vec4>, Words, Vec<LayeredMap>, Words, Words);

pub fn layered_specular(s: &Samples) -> Case<ConeParams, Specular> {
    let (surfaces, voxels, maps, layers) = layered_diffuse(s).inputs;
    let inputs = (surfaces, copy(&s.gloss), voxels, maps, layers, s.materials().1);
    map(s.layered.cones(s), inputs, COUNT)
}

pub fn shadow_cone(s: &Samples) -> Case<ConeParams, (Vec<Surface>, Vec<Light>, Words)> {
    let inputs = (copy(&s.surfaces), copy(&s.world.lights), copy(&s.layered.voxels.words));
    map(ConeParams { maps: 0, ..s.layered.cones(s) }, inputs, COUNT)
}

type SoftDiffuse = (Vec<Surface>, Vec<Light>, Vec<f32>, Vec<Vec4>);

pub fn shade_soft_diffuse(s: &Samples) -> Case<LightParams, SoftDiffuse> {
    let inputs = (copy(&s.surfaces), copy(&s.world.lights), floats(COUNT), vectors(COUNT));
    map(s.light, inputs, COUNT)
}

type SoftSpecular = (Vec<Surface>, Vec<Vec4>, Vec<Light>, Vec<f32>, Vec<Vec4>);

pub fn shade_soft_specular(s: &Samples) -> Case<LightParams, SoftSpecular> {
    let (surfaces, lights, visible, previous) = shade_soft_diffuse(s).inputs;
    map(s.light, (surfaces, copy(&s.gloss), lights, visible, previous), COUNT)
}
