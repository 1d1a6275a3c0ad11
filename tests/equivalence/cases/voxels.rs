//! Inputs of the passes over a pyramid of voxels: the random scenes of `voxelised`.

use super::arrays::scanned;
use super::scene::launch;
use super::voxelised::{DEPTH, MAP, Voxelised, at};
use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::voxel_cones::inject::RADIANCE_WORDS;

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
