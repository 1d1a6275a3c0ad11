//! Inputs of the passes over a pyramid of voxels: the random scenes of `scene` in 16³ voxels.

use super::arrays::scanned;
use super::scene::{World, launch, worlds};
use super::visibility::Cells;
use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::{Vec3, Vec4};
use twinlight::scene::Bounds;
use twinlight::technique::light_map::map_params;
use twinlight_kernels::geometry::lattice::{BLOCK_WORDS, block_count, blocks_along, level_offset};
use twinlight_kernels::passes;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::voxel_cones::build::{ISOTROPIC, LEAF_WORDS};
use twinlight_kernels::passes::voxel_cones::inject::{POWER_WORDS, RADIANCE_WORDS};

const DEPTH: u32 = 4;
/// Texels along a side of the photons' map.
const MAP: u32 = 40;

/// One level of refinement.
struct Refined {
    params: VoxeliseParams,
    pairs: Vec<u32>,
    masks: Vec<u32>,
    counts: Vec<u32>,
}

/// A scene's way into voxels, on the host.
pub(super) struct Voxelised {
    world: World,
    refined: Vec<Refined>,
    pairs: Vec<u32>,
    params: PyramidParams,
    level_masks: Vec<Vec<u32>>,
    masks: Vec<u32>,
    counts: Vec<u32>,
    blocks: Vec<u32>,
    firsts: Vec<u32>,
    points: Vec<Vec<u32>>,
    sums: Vec<u32>,
    depths: Vec<u32>,
    photons: PhotonParams,
    hits: Vec<Hit>,
    flags: Vec<u32>,
    places: Vec<u32>,
    lit: Vec<u32>,
    power: Vec<u32>,
    radiance: Vec<u32>,
}

fn scatter(len: u32, items: u32, mut item: impl FnMut(u32, &mut Cells)) -> Vec<u32> {
    let mut cells = Cells(vec![0; len as usize]);
    (0..items).for_each(|i| item(i, &mut cells));
    cells.0
}

fn map<T>(items: u32, item: impl FnMut(u32) -> T) -> Vec<T> {
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
        let words = lit.len() as u32 * RADIANCE_WORDS;
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
            world,
        }
    }

    /// Directional voxels by area, and directionless thin ones.
    fn all(draw: &mut Draw) -> [Self; 2] {
        let [a, b] = worlds(draw);
        [Self::new(draw, a, 0, 0), Self::new(draw, b, ISOTROPIC, 1)]
    }

    /// Numbers of lit voxels of all levels; those above the leaves are dark.
    fn all_places(&self) -> Vec<u32> {
        let mut all = vec![0; self.params.first as usize];
        all.extend(&self.places);
        all
    }

    fn cones(&self) -> ConeParams {
        ConeParams {
            lower: self.params.lower,
            eye: self.world.camera.eye,
            environment: Vec4::new(0.4, 0.5, 0.6, 0.0),
            inverse_edge: self.params.inverse_edge,
            depth: DEPTH,
            cones: if self.params.flags == 0 { 6 } else { 3 },
            tangent: if self.params.flags == 0 { 0.0 } else { 0.3 },
            width: 0.7,
            step: 0.8,
            start: 1.0,
            clearance: 2.0,
            cutoff: 0.01,
            falloff: 0.1,
            reach: 40.0,
            radiance_unit: 2.0,
            radiance_scale: 0.5,
            lit_by_environment: 1,
            first: self.params.first,
            ..Default::default()
        }
    }
}

/// The parameters of a level, and its number of voxels.
fn at(params: &PyramidParams, firsts: &[u32], level: u32) -> (PyramidParams, u32) {
    let l = level as usize;
    let end = if l == 0 { firsts[DEPTH as usize + 1] } else { firsts[l - 1] };
    let child_first = if l == 0 { 0 } else { firsts[l - 1] };
    (PyramidParams { level, first: firsts[l], child_first, ..*params }, end - firsts[l])
}

fn items(label: &str, items: usize) -> Launch {
    Launch::new(label, items, items as u32)
}

pub fn root_pairs(_: &mut Draw) -> Vec<case::root_pairs> {
    vec![case::root_pairs { launch: items("100 triangles", 200), params: VoxeliseParams::default() }]
}

pub fn child_masks(draw: &mut Draw) -> Vec<case::child_masks> {
    let mut cases = Vec::new();
    for v in Voxelised::all(draw) {
        for r in v.refined {
            cases.push(case::child_masks {
                launch: items("a refinement", r.masks.len()),
                params: r.params,
                pairs: r.pairs,
                triangles: v.world.triangles.clone(),
            });
        }
    }
    cases
}

pub fn mask_counts(draw: &mut Draw) -> Vec<case::mask_counts> {
    let mut masks: Vec<u32> = (0..300).map(|_| draw.word()).collect();
    masks.extend([0, !0, 1, 1 << 31]);
    let params = VoxeliseParams::default();
    vec![case::mask_counts { launch: items("any words", masks.len()), params, masks }]
}

pub fn child_pairs(draw: &mut Draw) -> Vec<case::child_pairs> {
    let mut cases = Vec::new();
    for v in Voxelised::all(draw) {
        for r in v.refined {
            cases.push(case::child_pairs {
                launch: items("a refinement", 2 * r.counts.iter().sum::<u32>() as usize),
                params: r.params,
                starts: scanned(&r.counts),
                masks: r.masks,
                pairs: r.pairs,
            });
        }
    }
    cases
}

pub fn mark_voxels(draw: &mut Draw) -> Vec<case::mark_voxels> {
    Voxelised::all(draw)
        .map(|v| case::mark_voxels {
            launch: Launch::new("all pairs", v.level_masks[0].len(), v.pairs.len() as u32 / 2),
            params: VoxeliseParams { depth: DEPTH, ..Default::default() },
            pairs: v.pairs,
        })
        .into()
}

pub fn place_words(draw: &mut Draw) -> Vec<case::place_words> {
    let words: Vec<u32> = (0..200).map(|_| draw.word()).collect();
    let params = WordParams { offset: 30, count: 150, ..Default::default() };
    vec![case::place_words { launch: Launch::new("fewer than there are", 250, 200), params, words }]
}

pub fn parent_masks(draw: &mut Draw) -> Vec<case::parent_masks> {
    let mut cases = Vec::new();
    for v in Voxelised::all(draw) {
        for level in 1..=DEPTH {
            cases.push(case::parent_masks {
                launch: items(&format!("level {level}"), v.level_masks[level as usize].len()),
                params: PyramidParams { level, ..v.params },
                children: v.level_masks[level as usize - 1].clone(),
            });
        }
    }
    cases
}

pub fn block_counts(draw: &mut Draw) -> Vec<case::block_counts> {
    Voxelised::all(draw)
        .map(|v| case::block_counts {
            launch: items("all blocks", v.counts.len()),
            params: v.params,
            masks: v.masks,
        })
        .into()
}

pub fn pack_blocks(draw: &mut Draw) -> Vec<case::pack_blocks> {
    Voxelised::all(draw)
        .map(|v| case::pack_blocks {
            launch: items("all blocks", v.blocks.len()),
            params: v.params,
            masks: v.masks,
            starts: scanned(&v.counts),
        })
        .into()
}

pub fn voxel_points(draw: &mut Draw) -> Vec<case::voxel_points> {
    let mut cases = Vec::new();
    for v in Voxelised::all(draw) {
        for level in 0..=DEPTH {
            let (params, count) = at(&v.params, &v.firsts, level);
            let launch = items(&format!("level {level}"), count as usize);
            cases.push(case::voxel_points { launch, params, blocks: v.blocks.clone() });
        }
    }
    cases
}

pub fn accumulate_leaves(draw: &mut Draw) -> Vec<case::accumulate_leaves> {
    Voxelised::all(draw)
        .map(|v| case::accumulate_leaves {
            launch: Launch::new("all pairs", v.sums.len(), v.pairs.len() as u32 / 2),
            params: v.params,
            pairs: v.pairs,
            blocks: v.blocks,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
        })
        .into()
}

pub fn leaf_depths(draw: &mut Draw) -> Vec<case::leaf_depths> {
    Voxelised::all(draw)
        .map(|v| case::leaf_depths {
            launch: items("leaves", v.params.leaves as usize),
            params: v.params,
            sums: v.sums,
        })
        .into()
}

pub fn filter_depths(draw: &mut Draw) -> Vec<case::filter_depths> {
    let mut cases = Vec::new();
    for v in Voxelised::all(draw) {
        for level in 1..=DEPTH {
            let (params, count) = at(&v.params, &v.firsts, level);
            let children = v.firsts[level as usize - 1] as usize..;
            cases.push(case::filter_depths {
                launch: items(&format!("level {level}"), count as usize),
                params,
                points: v.points[level as usize].clone(),
                blocks: v.blocks.clone(),
                children: v.depths[children].to_vec(),
            });
        }
    }
    cases
}

pub fn mark_lit(draw: &mut Draw) -> Vec<case::mark_lit> {
    Voxelised::all(draw)
        .map(|v| case::mark_lit {
            launch: Launch::new("a map", v.params.leaves as usize, MAP * MAP),
            params: v.photons,
            hits: v.hits,
            triangles: v.world.triangles,
            blocks: v.blocks,
        })
        .into()
}

pub fn inject_photons(draw: &mut Draw) -> Vec<case::inject_photons> {
    Voxelised::all(draw)
        .map(|v| case::inject_photons {
            launch: Launch::new("a map", v.power.len(), MAP * MAP),
            params: v.photons,
            hits: v.hits,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
            lights: v.world.lights,
            blocks: v.blocks,
            places: v.places,
        })
        .into()
}

pub fn mark_emissive(draw: &mut Draw) -> Vec<case::mark_emissive> {
    Voxelised::all(draw)
        .map(|v| case::mark_emissive {
            launch: Launch::new("all pairs", v.params.leaves as usize, v.pairs.len() as u32 / 2),
            params: v.params,
            pairs: v.pairs,
            blocks: v.blocks,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
        })
        .into()
}

pub fn inject_emission(draw: &mut Draw) -> Vec<case::inject_emission> {
    Voxelised::all(draw)
        .map(|v| case::inject_emission {
            launch: Launch::new("all pairs", v.power.len(), v.pairs.len() as u32 / 2),
            params: v.params,
            pairs: v.pairs,
            blocks: v.blocks,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
            places: v.places,
        })
        .into()
}

pub fn lit_places(draw: &mut Draw) -> Vec<case::lit_places> {
    Voxelised::all(draw)
        .map(|v| case::lit_places {
            launch: items("leaves", v.flags.len()),
            params: PyramidParams { first_lit: 7, ..v.params },
            starts: scanned(&v.flags),
            flags: v.flags,
        })
        .into()
}

pub fn lit_radiance(draw: &mut Draw) -> Vec<case::lit_radiance> {
    Voxelised::all(draw)
        .map(|v| case::lit_radiance {
            launch: items("lit leaves", v.radiance.len()),
            params: v.params,
            lit: v.lit,
            sums: v.sums,
            power: v.power,
        })
        .into()
}

pub fn mark_lit_parents(draw: &mut Draw) -> Vec<case::mark_lit_parents> {
    Voxelised::all(draw)
        .map(|v| {
            let (params, count) = at(&v.params, &v.firsts, 1);
            case::mark_lit_parents {
                launch: Launch::new("level 1", count as usize, v.lit.len() as u32),
                params,
                lit: v.lit,
                points: v.points[0].clone(),
                blocks: v.blocks,
            }
        })
        .into()
}

pub fn filter_radiance(draw: &mut Draw) -> Vec<case::filter_radiance> {
    Voxelised::all(draw)
        .map(|v| {
            let (params, count) = at(&v.params, &v.firsts, 1);
            case::filter_radiance {
                launch: Launch::new("all of level 1", (count * RADIANCE_WORDS) as usize, count),
                params,
                lit: (0..count).collect(),
                points: v.points[1].clone(),
                blocks: v.blocks,
                depths: v.depths,
                children: v.places,
                radiance: v.radiance,
            }
        })
        .into()
}

pub fn cone_openness(draw: &mut Draw) -> Vec<case::cone_openness> {
    Voxelised::all(draw)
        .map(|v| case::cone_openness {
            launch: launch("pixels"),
            params: v.cones(),
            places: v.all_places(),
            surfaces: v.world.surfaces,
            blocks: v.blocks,
            depths: v.depths,
            radiance: v.radiance,
        })
        .into()
}

pub fn cone_diffuse(draw: &mut Draw) -> Vec<case::cone_diffuse> {
    Voxelised::all(draw)
        .map(|v| case::cone_diffuse {
            launch: launch("pixels"),
            params: v.cones(),
            places: v.all_places(),
            surfaces: v.world.surfaces,
            blocks: v.blocks,
            depths: v.depths,
            radiance: v.radiance,
        })
        .into()
}

pub fn cone_specular(draw: &mut Draw) -> Vec<case::cone_specular> {
    Voxelised::all(draw)
        .map(|v| case::cone_specular {
            launch: launch("pixels"),
            params: v.cones(),
            places: v.all_places(),
            gloss: v.world.gloss(),
            surfaces: v.world.surfaces,
            blocks: v.blocks,
            depths: v.depths,
            radiance: v.radiance,
            texels: v.world.texels,
        })
        .into()
}

pub fn bounce_radiance(draw: &mut Draw) -> Vec<case::bounce_radiance> {
    Voxelised::all(draw)
        .map(|v| case::bounce_radiance {
            launch: items("leaves", (v.params.leaves * RADIANCE_WORDS) as usize),
            params: v.cones(),
            places: v.all_places(),
            points: v.points[0].clone(),
            sums: v.sums,
            blocks: v.blocks,
            depths: v.depths,
            radiance: v.radiance,
            texels: v.world.texels,
        })
        .into()
}

/// Words of radiance like those of leaves.
fn bounced(v: &Voxelised) -> Vec<u32> {
    v.radiance.iter().copied().cycle().take((v.params.leaves * RADIANCE_WORDS) as usize).collect()
}

pub fn add_bounce(draw: &mut Draw) -> Vec<case::add_bounce> {
    Voxelised::all(draw)
        .map(|v| case::add_bounce {
            launch: items("leaves", (v.params.leaves * RADIANCE_WORDS) as usize),
            params: v.cones(),
            places: v.all_places(),
            bounced: bounced(&v),
            radiance: v.radiance,
        })
        .into()
}

pub fn mark_bright(draw: &mut Draw) -> Vec<case::mark_bright> {
    Voxelised::all(draw)
        .map(|v| case::mark_bright {
            launch: items("leaves", v.params.leaves as usize),
            params: v.params,
            radiance: bounced(&v),
        })
        .into()
}

pub fn keep_lit(draw: &mut Draw) -> Vec<case::keep_lit> {
    Voxelised::all(draw)
        .map(|v| case::keep_lit {
            launch: items("lit leaves", v.lit.len() * RADIANCE_WORDS as usize),
            params: v.params,
            radiance: bounced(&v),
            lit: v.lit,
        })
        .into()
}
