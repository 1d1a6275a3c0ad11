//! How does a scene become a pyramid of voxels? VCT §4.

use super::{VoxelCones, Voxelisation};
use crate::backend::{Backend, BackendError, BufferLength};
use crate::error::SettingsError;
use crate::primitives::exclusive_scan;
use crate::technique::World;
use glam::Vec3;
use twinlight_kernels::geometry::lattice::{BLOCK_WORDS, block_count, blocks_along, level_offset};
use twinlight_kernels::passes::elements::{PyramidParams, VoxeliseParams, WordParams};
use twinlight_kernels::passes::voxel_cones::build::{ISOTROPIC, LEAF_WORDS};

/// The most pairs of cells and triangles: 1 GiB, as often as a refinement needs.
const MAX_PAIRS: u64 = 1 << 26;

/// The voxels of a scene. They change with the scene's geometry and materials only.
pub struct Pyramid<B: Backend> {
    /// What the passes over its voxels need to know, for level 0.
    pub params: PyramidParams,
    /// Blocks of all levels, coarse ones first.
    pub blocks: B::Buffer<u32>,
    /// The first voxel of each level, and the number of all voxels.
    pub firsts: Vec<u32>,
    /// Lattice points of each level's voxels, packed.
    pub points: Vec<B::Buffer<u32>>,
    /// Optical depths of all voxels, packed.
    pub depths: B::Buffer<u32>,
    /// What surfaces cover of each leaf.
    pub sums: B::Buffer<u32>,
    /// Pairs of leaves and triangles.
    pub pairs: B::Buffer<u32>,
    /// Number of pairs.
    pub pair_count: u32,
}

/// The pairs of a level of refinement.
struct Pairs<B: Backend> {
    words: B::Buffer<u32>,
    count: u32,
}

impl<B: Backend> Pyramid<B> {
    /// Voxelises the scene and filters it upward.
    pub fn build(backend: &mut B, world: &World<B>, settings: &VoxelCones) -> Result<Self, BackendError> {
        let depth = settings.depth();
        let side = 1u32 << depth;
        let extent =
            world.bounds.size().max_element().max(1.0e-6 * world.bounds.centre().abs().max_element());
        // Cells are centred on lattice points; the scene fills all but the outermost, and its box avoids their borders.
        let edge = extent.max(1.0e-9) / (side as f32 - 2.6);
        let corner = world.bounds.centre() - Vec3::splat(0.5 * side as f32 * edge);
        let thin = settings.voxelisation == Voxelisation::Thin;
        let pairs = refine(backend, world, corner, side as f32 * edge, depth, thin)?;
        let mut params = PyramidParams {
            lower: (corner + Vec3::splat(0.5 * edge)).extend(edge),
            inverse_edge: 1.0 / edge,
            depth,
            flags: if settings.anisotropic { 0 } else { ISOTROPIC },
            thin: u32::from(thin),
            ..Default::default()
        };
        let (blocks, firsts) = blocks(backend, &params, &pairs)?;
        params.first = firsts[0];
        params.leaves = firsts[depth as usize + 1] - firsts[0];
        let mut points = Vec::new();
        for level in 0..=depth {
            let (params, count) = at_level(&params, &firsts, level);
            let mut of_level = backend.alloc("voxel points", count as usize)?;
            backend.voxel_points(&params, &blocks, &mut of_level, count)?;
            points.push(of_level);
        }
        let mut sums = backend.alloc("leaf sums", (params.leaves * LEAF_WORDS) as usize)?;
        let w = world;
        backend.accumulate_leaves(
            &params,
            &pairs.words,
            &blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut sums,
            pairs.count,
        )?;
        let mut depths = backend.alloc("optical depths", firsts[depth as usize + 1] as usize)?;
        let mut children = backend.alloc("leaf depths", params.leaves as usize)?;
        backend.leaf_depths(&params, &sums, &mut children, params.leaves)?;
        place(backend, &children, params.first, &mut depths)?;
        for level in 1..=depth {
            let (params, count) = at_level(&params, &firsts, level);
            let mut of_level = backend.alloc("level depths", count as usize)?;
            backend.filter_depths(
                &params,
                &points[level as usize],
                &blocks,
                &children,
                &mut of_level,
                count,
            )?;
            place(backend, &of_level, params.first, &mut depths)?;
            children = of_level;
        }
        Ok(Self { params, blocks, firsts, points, depths, sums, pairs: pairs.words, pair_count: pairs.count })
    }

    /// The parameters of the passes over a level's voxels, and their number.
    pub fn level(&self, level: u32) -> (PyramidParams, u32) {
        at_level(&self.params, &self.firsts, level)
    }

    /// Number of voxels of all levels.
    pub fn voxels(&self) -> u32 {
        self.firsts[self.params.depth as usize + 1]
    }

    /// Bytes of what stays: blocks, points, depths and leaf sums.
    pub fn bytes(&self) -> u64 {
        let points: usize = self.points.iter().map(BufferLength::element_count).sum();
        let words = self.blocks.element_count()
            + points
            + self.depths.element_count()
            + self.sums.element_count()
            + self.pairs.element_count();
        4 * words as u64
    }
}

/// `firsts[level]` for 0 to depth, then the number of all: coarse levels stand first, the leaves last.
fn at_level(params: &PyramidParams, firsts: &[u32], level: u32) -> (PyramidParams, u32) {
    let depth = params.depth as usize;
    let l = level as usize;
    let end = if l == 0 { firsts[depth + 1] } else { firsts[l - 1] };
    let child_first = if l == 0 { 0 } else { firsts[l - 1] };
    (PyramidParams { level, first: firsts[l], child_first, ..*params }, end - firsts[l])
}

/// Copies words into their place.
pub(super) fn place<B: Backend>(
    backend: &mut B,
    words: &B::Buffer<u32>,
    offset: u32,
    all: &mut B::Buffer<u32>,
) -> Result<(), BackendError> {
    let count = words.element_count() as u32;
    backend.place_words(&WordParams { offset, count, ..Default::default() }, words, all, count)
}

/// Pairs of leaves and triangles, from the whole down.
fn refine<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    corner: Vec3,
    size: f32,
    depth: u32,
    thin: bool,
) -> Result<Pairs<B>, BackendError> {
    let mut params = VoxeliseParams { depth, ..Default::default() };
    let mut count = world.triangle_count;
    let mut words = backend.alloc("pairs", 2 * count as usize)?;
    backend.root_pairs(&params, &mut words, 2 * count)?;
    for level in 1..=depth {
        params.lower = corner.extend((1u32 << level) as f32 / size);
        params.thin = u32::from(thin && level == depth);
        params.pairs = count;
        let mut masks = backend.alloc("child masks", count as usize)?;
        backend.child_masks(&params, &words, &world.triangles, &mut masks, count)?;
        let mut counts = backend.alloc("child counts", count as usize)?;
        backend.mask_counts(&params, &masks, &mut counts, count)?;
        let children: u64 = backend.download(&counts)?.iter().map(|&c| u64::from(c)).sum();
        if children > MAX_PAIRS {
            return Err(BackendError::Settings(SettingsError {
                knob: "resolution",
                reason: format!("{children} pairs of voxels and triangles are over {MAX_PAIRS}; halve it"),
            }));
        }
        let starts = exclusive_scan(backend, &counts, count)?;
        let mut next = backend.alloc("pairs", 2 * children as usize)?;
        backend.child_pairs(&params, &starts, &masks, &words, &mut next, 2 * children as u32)?;
        (words, count) = (next, children as u32);
    }
    Ok(Pairs { words, count })
}

/// Which points of all levels are voxels, and the number of each level's first.
fn blocks<B: Backend>(
    backend: &mut B,
    params: &PyramidParams,
    pairs: &Pairs<B>,
) -> Result<(B::Buffer<u32>, Vec<u32>), BackendError> {
    let depth = params.depth;
    let all = block_count(depth);
    let mut masks = backend.alloc("lattice", 2 * all as usize)?;
    let words = |level: u32| 2 * blocks_along(depth, level).pow(3);
    let mut below = backend.alloc("level lattice", words(0) as usize)?;
    let voxelise = VoxeliseParams { depth, ..Default::default() };
    backend.mark_voxels(&voxelise, &pairs.words, &mut below, pairs.count)?;
    place(backend, &below, 2 * level_offset(depth, 0), &mut masks)?;
    for level in 1..=depth {
        let mut of_level = backend.alloc("level lattice", words(level) as usize)?;
        let params = PyramidParams { level, ..*params };
        backend.parent_masks(&params, &below, &mut of_level, words(level))?;
        place(backend, &of_level, 2 * level_offset(depth, level), &mut masks)?;
        below = of_level;
    }
    let mut counts = backend.alloc("block counts", all as usize)?;
    backend.block_counts(params, &masks, &mut counts, all)?;
    let starts = exclusive_scan(backend, &counts, all)?;
    let mut packed = backend.alloc("blocks", (BLOCK_WORDS * all) as usize)?;
    backend.pack_blocks(params, &masks, &starts, &mut packed, BLOCK_WORDS * all)?;
    let on_host = backend.download(&starts)?;
    let mut firsts: Vec<u32> =
        (0..=depth).map(|level| on_host[level_offset(depth, level) as usize]).collect();
    let last = backend.download(&counts)?.last().copied().unwrap_or(0);
    firsts.push(on_host.last().copied().unwrap_or(0) + last);
    Ok((packed, firsts))
}
