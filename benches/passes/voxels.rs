//! On which inputs are the passes of voxel cone tracing timed? The same scene in 64³ voxels, the same picture.

use super::{COUNT, Case, SIDE, Samples, copy, exclusive_scan, map, words};
use glam::Vec4;
use twinlight::backend::Cpu;
use twinlight::technique::World;
use twinlight::technique::voxel_cones::{Lighting, Lit, Pyramid, VoxelCones};
use twinlight_kernels::geometry::lattice::{BLOCK_WORDS, block_count, blocks_along, level_offset};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::voxel_cones::build::LEAF_WORDS;
use twinlight_kernels::passes::voxel_cones::inject::{POWER_WORDS, RADIANCE_WORDS};
use twinlight_kernels::passes::voxel_cones::lobes::{LOBE_POWER_WORDS, LOBE_WORDS};

type Words = Vec<u32>;
type OfTriangles = (Words, Words, Vec<Triangle>, Vec<Material>, Words);

/// The scene's voxels, and what light makes of them.
pub struct Voxels {
    pyramid: Pyramid<Cpu>,
    /// The same in half as many voxels along each axis: pairs to refine.
    coarse: Pyramid<Cpu>,
    lit: Lit<Cpu>,
    /// Marks of all levels, two words for each block.
    masks: Words,
}

impl Voxels {
    /// Runs the technique up to its light.
    pub fn new(cpu: &mut Cpu, w: &World<Cpu>) -> Result<Self, Box<dyn std::error::Error>> {
        let settings = VoxelCones { resolution: 64, light_map: SIDE, ..Default::default() };
        let pyramid = Pyramid::build(cpu, w, &settings)?;
        let coarse = Pyramid::build(cpu, w, &VoxelCones { resolution: 32, ..settings.clone() })?;
        let lit = Lighting::new(cpu, w, &pyramid, &settings)?.reflected;
        let blocks: Words = copy(&pyramid.blocks);
        let masks = blocks.chunks_exact(BLOCK_WORDS as usize).flat_map(|b| [b[0], b[1]]).collect();
        Ok(Self { pyramid, coarse, lit, masks })
    }

    fn params(&self, level: u32) -> (PyramidParams, u32) {
        let (params, count) = self.pyramid.level(level);
        (PyramidParams { power_scale: 1.0, radiance_scale: 1.0, ..params }, count)
    }

    /// Pairs of voxels and triangles.
    pub fn pairs(&self) -> (PyramidParams, Words) {
        (self.params(0).0, copy(&self.pyramid.pairs))
    }

    fn blocks(&self) -> Words {
        copy(&self.pyramid.blocks)
    }

    fn counts(&self) -> Words {
        self.masks.chunks_exact(2).map(|m| m[0].count_ones() + m[1].count_ones()).collect()
    }

    /// Marks of one level.
    fn level_masks(&self, level: u32) -> Words {
        let depth = self.pyramid.params.depth;
        let first = 2 * level_offset(depth, level) as usize;
        self.masks[first..first + 2 * blocks_along(depth, level).pow(3) as usize].to_vec()
    }

    /// Places of one level's voxels.
    fn places(&self, level: u32) -> Words {
        let (params, count) = self.params(level);
        copy(&self.lit.places)[params.first as usize..(params.first + count) as usize].to_vec()
    }

    /// Lit voxels of a level.
    fn lit_list(&self, level: u32) -> Words {
        let places = self.places(level);
        (0..places.len() as u32).filter(|&i| places[i as usize] > 0).collect()
    }

    fn cones(&self, s: &Samples) -> ConeParams {
        let p = &self.pyramid.params;
        ConeParams {
            lower: p.lower,
            eye: s.camera.eye,
            inverse_edge: p.inverse_edge,
            depth: p.depth,
            cones: 6,
            width: 0.5,
            step: 0.5,
            start: 1.0,
            clearance: 2.0,
            cutoff: 0.01,
            reach: 1.0e9,
            radiance_unit: 1.0,
            radiance_scale: 1.0,
            first: p.first,
            ..Default::default()
        }
    }

    /// Blocks, depths, places and radiance.
    fn structure(&self) -> (Words, Words, Words, Words) {
        let p = &self.pyramid;
        (copy(&p.blocks), copy(&p.depths), copy(&self.lit.places), copy(&self.lit.radiance))
    }

    /// Radiance of all leaves.
    fn leaf_words(&self) -> Words {
        words(self.pyramid.params.leaves * RADIANCE_WORDS)
    }
}

fn refinement(v: &Voxels) -> VoxeliseParams {
    let p = &v.coarse.params;
    let edge = 0.5 * p.lower.w;
    VoxeliseParams {
        lower: (p.lower.truncate() - glam::Vec3::splat(edge)).extend(1.0 / edge),
        pairs: v.coarse.pair_count,
        depth: p.depth + 1,
        ..Default::default()
    }
}

pub fn root_pairs(s: &Samples) -> Case<VoxeliseParams, ()> {
    map(VoxeliseParams::default(), (), 2 * s.world.triangle_count)
}

pub fn child_masks(s: &Samples) -> Case<VoxeliseParams, (Words, Vec<Triangle>)> {
    let v = &s.voxels;
    map(refinement(v), (copy(&v.coarse.pairs), s.triangles()), v.coarse.pair_count)
}

/// Masks of one to four children.
fn child_words(count: u32) -> Words {
    words(count).into_iter().map(|w| (w & 0x71) | 1).collect()
}

pub fn mask_counts(s: &Samples) -> Case<VoxeliseParams, (Words,)> {
    let count = s.voxels.coarse.pair_count;
    map(refinement(&s.voxels), (child_words(count),), count)
}

pub fn child_pairs(s: &Samples) -> Case<VoxeliseParams, (Words, Words, Words)> {
    let v = &s.voxels;
    let masks = child_words(v.coarse.pair_count);
    let counts: Words = masks.iter().map(|m| m.count_ones()).collect();
    let items = 2 * counts.iter().sum::<u32>();
    map(refinement(v), (exclusive_scan(&counts), masks, copy(&v.coarse.pairs)), items)
}

pub fn mark_voxels(s: &Samples) -> Case<VoxeliseParams, (Words,)> {
    let p = &s.voxels.pyramid;
    let params = VoxeliseParams { depth: p.params.depth, ..Default::default() };
    let outputs = s.voxels.level_masks(0).len() as u32;
    Case { params, inputs: (copy(&p.pairs),), outputs, items: p.pair_count }
}

pub fn place_words(_: &Samples) -> Case<WordParams, (Words,)> {
    map(WordParams { count: COUNT, ..Default::default() }, (words(COUNT),), COUNT)
}

pub fn parent_masks(s: &Samples) -> Case<PyramidParams, (Words,)> {
    let items = s.voxels.level_masks(1).len() as u32;
    map(s.voxels.params(1).0, (s.voxels.level_masks(0),), items)
}

pub fn block_counts(s: &Samples) -> Case<PyramidParams, (Words,)> {
    let blocks = block_count(s.voxels.pyramid.params.depth);
    map(s.voxels.params(0).0, (s.voxels.masks.clone(),), blocks)
}

pub fn pack_blocks(s: &Samples) -> Case<PyramidParams, (Words, Words)> {
    let v = &s.voxels;
    let items = BLOCK_WORDS * block_count(v.pyramid.params.depth);
    map(v.params(0).0, (v.masks.clone(), exclusive_scan(&v.counts())), items)
}

pub fn voxel_points(s: &Samples) -> Case<PyramidParams, (Words,)> {
    let (params, count) = s.voxels.params(0);
    map(params, (s.voxels.blocks(),), count)
}

fn of_pairs(s: &Samples) -> OfTriangles {
    let (materials, texels) = s.materials();
    (copy(&s.voxels.pyramid.pairs), s.voxels.blocks(), s.triangles(), materials, texels)
}

pub fn accumulate_leaves(s: &Samples) -> Case<PyramidParams, OfTriangles> {
    let (params, leaves) = s.voxels.params(0);
    let items = s.voxels.pyramid.pair_count;
    Case { params, inputs: of_pairs(s), outputs: leaves * LEAF_WORDS, items }
}

pub fn leaf_depths(s: &Samples) -> Case<PyramidParams, (Words,)> {
    let (params, leaves) = s.voxels.params(0);
    map(params, (copy(&s.voxels.pyramid.sums),), leaves)
}

pub fn filter_depths(s: &Samples) -> Case<PyramidParams, (Words, Words, Words)> {
    let v = &s.voxels;
    let (params, count) = v.params(1);
    let leaves = copy(&v.pyramid.depths)[v.pyramid.params.first as usize..].to_vec();
    map(params, (copy(&v.pyramid.points[1]), v.blocks(), leaves), count)
}

fn photons(s: &Samples) -> PhotonParams {
    let (p, light) = (&s.voxels.pyramid.params, &s.filter.light_map);
    PhotonParams {
        lower: p.lower,
        inverse_edge: p.inverse_edge,
        depth: p.depth,
        first: p.first,
        light: 0,
        projection: light.projection,
        size: light.size,
        spread: light.right.truncate().length(),
        scale: 1.0e4,
    }
}

pub fn mark_lit(s: &Samples) -> Case<PhotonParams, (Vec<Hit>, Vec<Triangle>, Words)> {
    let inputs = (s.filter.light_map_hits.clone(), s.triangles(), s.voxels.blocks());
    Case { params: photons(s), inputs, outputs: s.voxels.pyramid.params.leaves, items: COUNT }
}

type InjectPhotons = (Vec<Hit>, Vec<Triangle>, Vec<Material>, Words, Vec<Light>, Words, Words);

/// Every leaf is lit.
fn all_places(s: &Samples) -> Words {
    (1..=s.voxels.pyramid.params.leaves).collect()
}

pub fn inject_photons(s: &Samples) -> Case<PhotonParams, InjectPhotons> {
    let (materials, texels) = s.materials();
    let lights = copy(&s.world.lights);
    let hits = s.filter.light_map_hits.clone();
    let inputs = (hits, s.triangles(), materials, texels, lights, s.voxels.blocks(), all_places(s));
    let outputs = s.voxels.pyramid.params.leaves * POWER_WORDS;
    Case { params: photons(s), inputs, outputs, items: COUNT }
}

pub fn mark_emissive(s: &Samples) -> Case<PyramidParams, OfTriangles> {
    let (params, leaves) = s.voxels.params(0);
    Case { params, inputs: of_pairs(s), outputs: leaves, items: s.voxels.pyramid.pair_count }
}

type InjectEmission = (Words, Words, Vec<Triangle>, Vec<Material>, Words, Words);

pub fn inject_emission(s: &Samples) -> Case<PyramidParams, InjectEmission> {
    let (params, leaves) = s.voxels.params(0);
    let (pairs, blocks, triangles, materials, texels) = of_pairs(s);
    let inputs = (pairs, blocks, triangles, materials, texels, all_places(s));
    Case { params, inputs, outputs: leaves * POWER_WORDS, items: s.voxels.pyramid.pair_count }
}

pub fn lit_places(s: &Samples) -> Case<PyramidParams, (Words, Words)> {
    let (params, leaves) = s.voxels.params(0);
    let flags: Words = words(leaves).into_iter().map(|w| w & 1).collect();
    let starts = exclusive_scan(&flags);
    map(params, (flags, starts), leaves)
}

pub fn lit_radiance(s: &Samples) -> Case<PyramidParams, (Words, Words, Words)> {
    let (params, leaves) = s.voxels.params(0);
    let inputs = ((0..leaves).collect(), copy(&s.voxels.pyramid.sums), words(leaves * POWER_WORDS));
    map(params, inputs, leaves * RADIANCE_WORDS)
}

pub fn mark_lit_parents(s: &Samples) -> Case<PyramidParams, (Words, Words, Words)> {
    let v = &s.voxels;
    let (params, count) = v.params(1);
    let lit = v.lit_list(0);
    let items = lit.len() as u32;
    Case { params, inputs: (lit, copy(&v.pyramid.points[0]), v.blocks()), outputs: count, items }
}

type FilterRadiance = (Words, Words, Words, Words, Words, Words);

pub fn filter_radiance(s: &Samples) -> Case<PyramidParams, FilterRadiance> {
    let v = &s.voxels;
    let (params, _) = v.params(1);
    let lit = v.lit_list(1);
    let items = lit.len() as u32;
    let (blocks, depths, _, radiance) = v.structure();
    let inputs = (lit, copy(&v.pyramid.points[1]), blocks, depths, v.places(0), radiance);
    Case { params, inputs, outputs: items * RADIANCE_WORDS, items }
}

type Cones = (Vec<Surface>, Words, Words, Words, Words);

fn cone_inputs(s: &Samples) -> Cones {
    let (blocks, depths, places, radiance) = s.voxels.structure();
    (copy(&s.surfaces), blocks, depths, places, radiance)
}

pub fn cone_openness(s: &Samples) -> Case<ConeParams, Cones> {
    map(s.voxels.cones(s), cone_inputs(s), COUNT)
}

pub fn cone_diffuse(s: &Samples) -> Case<ConeParams, Cones> {
    map(s.voxels.cones(s), cone_inputs(s), COUNT)
}

type Specular = (Vec<Surface>, Vec<Vec4>, Words, Words, Words, Words, Words);

pub fn cone_specular(s: &Samples) -> Case<ConeParams, Specular> {
    let (surfaces, blocks, depths, places, radiance) = cone_inputs(s);
    let texels = s.materials().1;
    let inputs = (surfaces, copy(&s.gloss), blocks, depths, places, radiance, texels);
    map(s.voxels.cones(s), inputs, COUNT)
}

type Bounce = (Words, Words, Words, Words, Words, Words, Words);

pub fn bounce_radiance(s: &Samples) -> Case<ConeParams, Bounce> {
    let v = &s.voxels;
    let (blocks, depths, places, radiance) = v.structure();
    let (points, sums) = (copy(&v.pyramid.points[0]), copy(&v.pyramid.sums));
    let inputs = (points, sums, blocks, depths, places, radiance, s.materials().1);
    map(v.cones(s), inputs, v.pyramid.params.leaves * RADIANCE_WORDS)
}

pub fn add_bounce(s: &Samples) -> Case<ConeParams, (Words, Words, Words)> {
    let v = &s.voxels;
    let (_, _, places, radiance) = v.structure();
    let bounced = v.leaf_words();
    let items = bounced.len() as u32;
    map(v.cones(s), (places, radiance, bounced), items)
}

pub fn mark_bright(s: &Samples) -> Case<PyramidParams, (Words, Words, Words)> {
    let (params, leaves) = s.voxels.params(0);
    let (_, _, places, radiance) = s.voxels.structure();
    map(params, (s.voxels.leaf_words(), places, radiance), leaves)
}

pub fn keep_lit(s: &Samples) -> Case<PyramidParams, (Words, Words)> {
    let lit = s.voxels.lit_list(0);
    let items = lit.len() as u32 * RADIANCE_WORDS;
    map(s.voxels.params(0).0, (lit, s.voxels.leaf_words()), items)
}

pub fn inject_lobes(s: &Samples) -> Case<PhotonParams, InjectPhotons> {
    let outputs = s.voxels.pyramid.params.leaves * LOBE_POWER_WORDS;
    Case { outputs, ..inject_photons(s) }
}

pub fn lit_lobes(s: &Samples) -> Case<PyramidParams, (Words, Words, Words)> {
    let (params, leaves) = s.voxels.params(0);
    let power = words(leaves * LOBE_POWER_WORDS);
    let inputs = ((0..leaves).collect(), copy(&s.voxels.pyramid.sums), power);
    Case { params, inputs, outputs: leaves * LOBE_WORDS, items: leaves }
}

pub fn filter_lobes(s: &Samples) -> Case<PyramidParams, FilterRadiance> {
    let Case { params, inputs, items, .. } = filter_radiance(s);
    let (lit, points, blocks, depths, children, radiance) = inputs;
    // As many words for each child, of other things: what is timed are the look-ups.
    Case {
        params,
        inputs: (lit, points, blocks, depths, children, radiance),
        outputs: items * LOBE_WORDS,
        items,
    }
}

pub fn keep_lobes(s: &Samples) -> Case<PyramidParams, (Words, Words, Words)> {
    let v = &s.voxels;
    let lit = v.lit_list(0);
    let items = lit.len() as u32 * LOBE_WORDS;
    let (_, _, places, radiance) = v.structure();
    map(v.params(0).0, (lit, places, radiance), items)
}

pub fn merge_marks(s: &Samples) -> Case<PyramidParams, (Words, Words)> {
    let v = &s.voxels;
    map(v.params(0).0, (v.blocks(), v.masks.clone()), v.masks.len() as u32)
}

pub fn carry_leaves(s: &Samples) -> Case<PyramidParams, (Words, Words, Words)> {
    let p = &s.voxels.pyramid;
    let params = PyramidParams { child_first: p.params.first, ..p.params };
    let inputs = (copy(&p.points[0]), s.voxels.blocks(), copy(&p.sums));
    map(params, inputs, p.params.leaves * LEAF_WORDS)
}

type UpdateDepths = (Words, Words, Words, Words, Words, Words);

pub fn update_depths(s: &Samples) -> Case<PyramidParams, UpdateDepths> {
    let v = &s.voxels;
    let Case { params, inputs: (points, blocks, children), items, .. } = filter_depths(s);
    // A tenth of the voxels moves.
    let some = words(v.masks.len() as u32).into_iter().map(|w| w & (w >> 7) & (w >> 13));
    let marks = v.masks.iter().zip(some).map(|(m, s)| m & s).collect();
    let standing = (v.blocks(), copy(&v.pyramid.depths));
    map(params, (points, blocks, children, standing.0, standing.1, marks), items)
}

type DrawVoxels = (Vec<VoxelViewParams>, Words, Words, Words, Words);

pub fn draw_voxels(s: &Samples) -> Case<CameraParams, DrawVoxels> {
    let v = &s.voxels;
    let (blocks, depths, places, radiance) = v.structure();
    let p = &v.pyramid.params;
    let view = VoxelViewParams {
        lower: p.lower,
        inverse_edge: p.inverse_edge,
        depth: p.depth,
        radiance_unit: 1.0,
        ..Default::default()
    };
    map(s.camera, (vec![view], blocks, depths, places, radiance), COUNT)
}
