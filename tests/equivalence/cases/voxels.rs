//! Inputs of the passes that make a pyramid of voxels: the random scenes of `voxelised`.

use super::arrays::scanned;
use super::voxelised::{DEPTH, Voxelised, at};
use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::voxel_cones::build::LEAF_WORDS;

pub(super) fn items(label: &str, items: usize) -> Launch {
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

/// About half of the marks.
fn some_marks(draw: &mut Draw, v: &Voxelised) -> Vec<u32> {
    v.masks.iter().map(|&m| m & draw.word()).collect()
}

pub fn merge_marks(draw: &mut Draw) -> Vec<case::merge_marks> {
    let mut cases = Vec::new();
    for v in Voxelised::all(draw) {
        let marks = some_marks(draw, &v).into_iter().rev().collect();
        let launch = items("all blocks", v.masks.len());
        cases.push(case::merge_marks { launch, params: v.params, blocks: v.blocks, marks });
    }
    cases
}

pub fn carry_leaves(draw: &mut Draw) -> Vec<case::carry_leaves> {
    // The leaves of another scene: some are the standing one's too.
    let [a, b] = Voxelised::all(draw);
    let words = a.params.leaves * LEAF_WORDS;
    vec![case::carry_leaves {
        launch: items("leaves", words as usize),
        params: PyramidParams { child_first: b.params.first, ..a.params },
        points: a.points[0].clone(),
        blocks: b.blocks,
        sums: b.sums,
    }]
}

pub fn update_depths(draw: &mut Draw) -> Vec<case::update_depths> {
    let [a, b] = Voxelised::all(draw);
    let marks = some_marks(draw, &a);
    let mut cases = Vec::new();
    for level in 1..=DEPTH {
        let (params, count) = at(&a.params, &a.firsts, level);
        let children = a.firsts[level as usize - 1] as usize..;
        cases.push(case::update_depths {
            launch: items(&format!("level {level}"), count as usize),
            params,
            points: a.points[level as usize].clone(),
            blocks: a.blocks.clone(),
            children: a.depths[children].to_vec(),
            standing_blocks: b.blocks.clone(),
            standing_depths: b.depths.clone(),
            marks: marks.clone(),
        });
    }
    cases
}
