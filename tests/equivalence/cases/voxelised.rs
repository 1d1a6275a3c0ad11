//! How does a random scene become 16³ voxels on the host, kernel by kernel? What the cases of `voxels` start from.

use super::arrays::scanned;
use super::scene::{World, worlds};
use super::visibility::Cells;
use crate::body::Launch;
use crate::common::draw::Draw;
use glam::{Vec3, Vec4};
use twinlight::scene::Bounds;
use twinlight::technique::light_map::map_params;
use twinlight_kernels::geometry::lattice::{BLOCK_WORDS, block_count, blocks_along, level_offset};
use twinlight_kernels::passes;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::voxel_cones::build::{ISOTROPIC, LEAF_WORDS};
use twinlight_kernels::passes::voxel_cones::inject::{POWER_WORDS, RADIANCE_WORDS};
use twinlight_kernels::passes::voxel_cones::lobes::{LOBE_POWER_WORDS, LOBE_WORDS};
use twinlight_kernels::passes::voxel_cones::storage::{
    FIXED, FLOAT, HALF, STORAGE_SHIFT, storage_of, words_of,
};

pub(super) const DEPTH: u32 = 4;
/// Texels along a side of the photons' map.
pub(super) const MAP: u32 = 40;

/// One level of refinement.
pub(super) struct Refined {
    pub(super) params: VoxeliseParams,
    pub(super) pairs: Vec<u32>,
    pub(super) masks: Vec<u32>,
    pub(super) counts: Vec<u32>,
}

/// A scene's way into voxels, on the host.
pub(super) struct Voxelised {
    pub(super) world: World,
    pub(super) refined: Vec<Refined>,
    pub(super) pairs: Vec<u32>,
    pub(super) params: PyramidParams,
    pub(super) level_masks: Vec<Vec<u32>>,
    pub(super) masks: Vec<u32>,
    pub(super) counts: Vec<u32>,
    pub(super) blocks: Vec<u32>,
    pub(super) firsts: Vec<u32>,
    pub(super) points: Vec<Vec<u32>>,
    pub(super) sums: Vec<u32>,
    pub(super) depths: Vec<u32>,
    pub(super) photons: PhotonParams,
    pub(super) hits: Vec<Hit>,
    pub(super) flags: Vec<u32>,
    pub(super) places: Vec<u32>,
    pub(super) lit: Vec<u32>,
    pub(super) power: Vec<u32>,
    pub(super) radiance: Vec<u32>,
    pub(super) lobe_power: Vec<u32>,
    pub(super) lobes: Vec<u32>,
}

pub(super) fn scatter(len: u32, items: u32, mut item: impl FnMut(u32, &mut Cells)) -> Vec<u32> {
    let mut cells = Cells(vec![0; len as usize]);
    (0..items).for_each(|i| item(i, &mut cells));
    cells.0
}

pub(super) fn map<T>(items: u32, item: impl FnMut(u32) -> T) -> Vec<T> {
    (0..items).map(item).collect()
}

impl Voxelised {
    fn new(draw: &mut Draw, world: World, flags: u32, thin: u32) -> Self {
        let w = &world;
        let bounds = Bounds::of(&w.triangles);
        let side = 1u32 << DEPTH;
        let edge = bounds.size().max_element() / (side as f32 - 2.6);
        let corner = bounds.centre() - Vec3::splat(0.5 * side as f32 * edge);
        let (mut refined, mut pairs) = (Vec::new(), Vec::new());
        let triangles = w.triangles.len() as u32;
        let mut voxelise = VoxeliseParams { depth: DEPTH, pairs: triangles, ..Default::default() };
        pairs.extend((0..2 * triangles).map(|i| passes::root_pairs(i, &voxelise)));
        for level in 1..=DEPTH {
            let count = pairs.len() as u32 / 2;
            voxelise.lower = corner.extend((1u32 << level) as f32 / (side as f32 * edge));
            (voxelise.pairs, voxelise.thin) = (count, if level == DEPTH { thin } else { 0 });
            let masks = map(count, |i| passes::child_masks(i, &voxelise, &pairs, &w.triangles));
            let counts = map(count, |i| passes::mask_counts(i, &voxelise, &masks));
            let starts = scanned(&counts);
            let next = map(2 * counts.iter().sum::<u32>(), |i| {
                passes::child_pairs(i, &voxelise, &starts, &masks, &pairs)
            });
            refined.push(Refined { params: voxelise, pairs, masks, counts });
            pairs = next;
        }
        let count = pairs.len() as u32 / 2;
        let mut params = PyramidParams {
            lower: (corner + Vec3::splat(0.5 * edge)).extend(edge),
            inverse_edge: 1.0 / edge,
            depth: DEPTH,
            flags,
            thin,
            ..Default::default()
        };
        let words = |level: u32| 2 * blocks_along(DEPTH, level).pow(3);
        let first = scatter(words(0), count, |i, out| passes::mark_voxels(i, &voxelise, &pairs, out));
        let mut level_masks = vec![first];
        for level in 1..=DEPTH {
            let params = PyramidParams { level, ..params };
            let below = &level_masks[level as usize - 1];
            level_masks.push(map(words(level), |i| passes::parent_masks(i, &params, below)));
        }
        let masks: Vec<u32> = level_masks.iter().rev().flatten().copied().collect();
        let all = block_count(DEPTH);
        let counts = map(all, |i| passes::block_counts(i, &params, &masks));
        let starts = scanned(&counts);
        let blocks = map(BLOCK_WORDS * all, |i| passes::pack_blocks(i, &params, &masks, &starts));
        let mut firsts: Vec<u32> =
            (0..=DEPTH).map(|level| starts[level_offset(DEPTH, level) as usize]).collect();
        firsts.push(counts.iter().sum());
        params.first = firsts[0];
        params.leaves = firsts[DEPTH as usize + 1] - firsts[0];
        let points: Vec<Vec<u32>> = (0..=DEPTH)
            .map(|level| {
                let (params, count) = at(&params, &firsts, level);
                map(count, |i| passes::voxel_points(i, &params, &blocks))
            })
            .collect();
        let sums = scatter(params.leaves * LEAF_WORDS, count, |i, out| {
            passes::accumulate_leaves(
                i,
                &params,
                &pairs,
                &blocks,
                &w.triangles,
                &w.materials,
                &w.texels,
                out,
            );
        });
        let mut levels = vec![map(params.leaves, |i| passes::leaf_depths(i, &params, &sums))];
        for level in 1..=DEPTH {
            let (params, count) = at(&params, &firsts, level);
            let below = &levels[level as usize - 1];
            let own =
                map(count, |i| passes::filter_depths(i, &params, &points[level as usize], &blocks, below));
            levels.push(own);
        }
        let depths: Vec<u32> = levels.into_iter().rev().flatten().collect();
        let number = draw.word() % w.lights.len() as u32;
        let light = map_params(&w.lights[number as usize], &bounds, MAP, 0.0);
        let hits = map(MAP * MAP, |i| {
            passes::trace_light_map(i, &light, &w.nodes, &w.blocks, &w.triangles, &w.materials, &w.texels)
        });
        (params.power_scale, params.radiance_scale) = (1.0e4, 0.5);
        let photons = PhotonParams {
            lower: params.lower,
            inverse_edge: params.inverse_edge,
            depth: DEPTH,
            first: params.first,
            light: number,
            projection: light.projection,
            size: MAP,
            spread: light.right.truncate().length(),
            scale: params.power_scale,
        };
        let mut cells = Cells(scatter(params.leaves, MAP * MAP, |i, out| {
            passes::mark_lit(i, &photons, &hits, &w.triangles, &blocks, out);
        }));
        (0..count).for_each(|i| {
            passes::mark_emissive(
                i,
                &params,
                &pairs,
                &blocks,
                &w.triangles,
                &w.materials,
                &w.texels,
                &mut cells,
            );
        });
        let flags = cells.0;
        let starts = scanned(&flags);
        let places = map(params.leaves, |i| passes::lit_places(i, &params, &flags, &starts));
        let lit: Vec<u32> = (0..params.leaves).filter(|&i| flags[i as usize] != 0).collect();
        assert!(lit.len() > 20, "{} lit leaves of {}", lit.len(), params.leaves);
        let power = scatter(lit.len() as u32 * POWER_WORDS, MAP * MAP, |i, out| {
            passes::inject_photons(
                i,
                &photons,
                &hits,
                &w.triangles,
                &w.materials,
                &w.texels,
                &w.lights,
                &blocks,
                &places,
                out,
            );
        });
        let lobe_power = scatter(lit.len() as u32 * LOBE_POWER_WORDS, MAP * MAP, |i, out| {
            passes::inject_lobes(
                i,
                &photons,
                &hits,
                &w.triangles,
                &w.materials,
                &w.texels,
                &w.lights,
                &blocks,
                &places,
                out,
            );
        });
        let count = lit.len() as u32;
        let lobes = scatter(count * LOBE_WORDS, count, |i, out| {
            passes::lit_lobes(i, &params, &lit, &sums, &lobe_power, out);
        });
        let words = lit.len() as u32 * RADIANCE_WORDS * words_of(storage_of(params.flags));
        let radiance = map(words, |i| passes::lit_radiance(i, &params, &lit, &sums, &power));
        Self {
            refined,
            pairs,
            params,
            level_masks,
            masks,
            counts,
            blocks,
            firsts,
            points,
            sums,
            depths,
            photons,
            hits,
            flags,
            places,
            lit,
            power,
            radiance,
            lobe_power,
            lobes,
            world,
        }
    }

    /// Directional voxels by area, and directionless thin ones.
    pub(super) fn all(draw: &mut Draw) -> [Self; 2] {
        let [a, b] = worlds(draw);
        [Self::new(draw, a, 0, 0), Self::new(draw, b, ISOTROPIC, 1)]
    }

    /// The same, and more in other storages of radiance.
    pub(super) fn stored(draw: &mut Draw) -> Vec<Self> {
        let mut all: Vec<Self> = Self::all(draw).into();
        for flags in [HALF << STORAGE_SHIFT, FLOAT << STORAGE_SHIFT | ISOTROPIC, FIXED << STORAGE_SHIFT] {
            let [world, _] = worlds(draw);
            all.push(Self::new(draw, world, flags, 0));
        }
        all
    }

    /// The launch of a pass that makes radiance: words of floats are not compared in fast mode, where the last bits differ.
    pub(super) fn stored_as(&self, launch: Launch) -> Launch {
        match storage_of(self.params.flags) {
            HALF | FLOAT => launch.strict_only(),
            _ => launch,
        }
    }

    /// Words of a lit voxel's radiance.
    pub(super) fn voxel_words(&self) -> u32 {
        RADIANCE_WORDS * words_of(storage_of(self.params.flags))
    }

    /// Numbers of lit voxels of all levels; those above the leaves are dark.
    pub(super) fn all_places(&self) -> Vec<u32> {
        let mut all = vec![0; self.params.first as usize];
        all.extend(&self.places);
        all
    }

    /// Radiance of the lit leaves, then their lobes.
    pub(super) fn radiance_and_lobes(&self) -> Vec<u32> {
        [&self.radiance[..], &self.lobes[..]].concat()
    }

    pub(super) fn cones(&self) -> ConeParams {
        let directional = self.params.flags & ISOTROPIC == 0;
        ConeParams {
            lower: self.params.lower,
            eye: self.world.camera.eye,
            environment: Vec4::new(0.4, 0.5, 0.6, 0.0),
            inverse_edge: self.params.inverse_edge,
            depth: DEPTH,
            cones: if directional { 6 } else { 3 },
            tangent: if directional { 0.0 } else { 0.3 },
            width: 0.7,
            step: 0.8,
            start: 1.0,
            clearance: 2.0,
            cutoff: 0.01,
            falloff: 0.1,
            reach: 40.0,
            radiance_unit: 2.0,
            radiance_scale: 0.5,
            flags: if directional { 1 } else { 3 } | self.params.flags & !ISOTROPIC,
            lobes: self.radiance.len() as u32,
            first: self.params.first,
            ..Default::default()
        }
    }
}

/// The parameters of a level, and its number of voxels.
pub(super) fn at(params: &PyramidParams, firsts: &[u32], level: u32) -> (PyramidParams, u32) {
    let l = level as usize;
    let end = if l == 0 { firsts[DEPTH as usize + 1] } else { firsts[l - 1] };
    let child_first = if l == 0 { 0 } else { firsts[l - 1] };
    (PyramidParams { level, first: firsts[l], child_first, ..*params }, end - firsts[l])
}
