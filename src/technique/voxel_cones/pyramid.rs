//! How does a scene become a pyramid of voxels? VCT §4.

use super::{VoxelCones, Voxelisation};
use crate::backend::{Backend, BackendError, BufferLength};
use crate::primitives::exclusive_scan;
use crate::scene::Bounds;
use crate::technique::World;
use crate::technique::voxelised::{Pairs, lattice, place, refine};
use glam::Vec3;
use std::ops::Range;
use twinlight_kernels::geometry::lattice::{BLOCK_WORDS, block_count, blocks_along, level_offset};
use twinlight_kernels::passes::elements::{PyramidParams, VoxeliseParams};
use twinlight_kernels::passes::voxel_cones::build::{ISOTROPIC, LEAF_WORDS};

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

/// Which points of all levels are voxels, how they are found and where they lie.
struct Structure<B: Backend> {
    params: PyramidParams,
    blocks: B::Buffer<u32>,
    firsts: Vec<u32>,
    points: Vec<B::Buffer<u32>>,
}

impl<B: Backend> Pyramid<B> {
    /// Voxelises the scene and filters it upward.
    pub fn build(backend: &mut B, world: &World<B>, settings: &VoxelCones) -> Result<Self, BackendError> {
        Self::build_part(backend, world, settings, &world.bounds, 0..world.triangle_count)
    }

    /// Voxelises some of a world's triangles, in a lattice over `bounds`; what lies outside is left out.
    pub fn build_part(
        backend: &mut B,
        world: &World<B>,
        settings: &VoxelCones,
        bounds: &Bounds,
        triangles: Range<u32>,
    ) -> Result<Self, BackendError> {
        let params = PyramidParams {
            flags: settings.storage.flags() | if settings.anisotropic { 0 } else { ISOTROPIC },
            ..lattice(bounds, settings.depth(), settings.voxelisation == Voxelisation::Thin)
        };
        let pairs = refine(backend, world, &params, triangles)?;
        let marks = marks(backend, &params, &pairs)?;
        let s = Structure::new(backend, &params, &marks)?;
        let mut sums = backend.alloc("leaf sums", (s.params.leaves * LEAF_WORDS) as usize)?;
        accumulate(backend, world, &s, &pairs, &mut sums)?;
        Self::filtered(backend, s, sums, pairs, |backend, params, s, children, output, count| {
            let points = &s.points[params.level as usize];
            backend.filter_depths(params, points, &s.blocks, children, output, count)
        })
    }

    /// Whether a box lies within the lattice; of what does not, the part outside is left out.
    pub fn holds(&self, bounds: &Bounds) -> bool {
        let (edge, side) = (self.params.lower.w, (1u32 << self.params.depth) as f32);
        let corner = self.params.lower.truncate() - Vec3::splat(0.5 * edge);
        bounds.min.cmpge(corner).all() && bounds.max.cmple(corner + Vec3::splat(side * edge)).all()
    }

    /// The pyramid of what this one holds and of further triangles: those of moving meshes, where they are now.
    ///
    /// This one is read only, frame after frame. The result is what voxelising all at once would give, bit for bit, but only
    /// the moving triangles are voxelised and only voxels above them are filtered. VCT §4.2.2.
    pub fn with_moving(
        &self,
        backend: &mut B,
        world: &World<B>,
        moving: Range<u32>,
    ) -> Result<Self, BackendError> {
        let base = PyramidParams { first: 0, leaves: 0, ..self.params };
        let added = refine(backend, world, &base, moving)?;
        let marks = marks(backend, &base, &added)?;
        let words = marks.element_count();
        let mut merged = backend.alloc("lattice", words)?;
        backend.merge_marks(&base, &self.blocks, &marks, &mut merged, words as u32)?;
        let s = Structure::new(backend, &base, &merged)?;
        let leaf_words = s.params.leaves * LEAF_WORDS;
        let mut sums = backend.alloc("leaf sums", leaf_words as usize)?;
        let params = PyramidParams { child_first: self.params.first, ..s.params };
        backend.carry_leaves(&params, &s.points[0], &self.blocks, &self.sums, &mut sums, leaf_words)?;
        accumulate(backend, world, &s, &added, &mut sums)?;
        let count = self.pair_count + added.count;
        let mut pairs = Pairs { words: backend.alloc("pairs", 2 * count as usize)?, count };
        place(backend, &self.pairs, 0, &mut pairs.words)?;
        place(backend, &added.words, 2 * self.pair_count, &mut pairs.words)?;
        Self::filtered(backend, s, sums, pairs, |backend, params, s, children, output, count| {
            backend.update_depths(
                params,
                &s.points[params.level as usize],
                &s.blocks,
                children,
                &self.blocks,
                &self.depths,
                &marks,
                output,
                count,
            )
        })
    }

    /// Optical depths from the leaves' sums upward; `filter` makes those of a level from those of the level below.
    fn filtered(
        backend: &mut B,
        s: Structure<B>,
        sums: B::Buffer<u32>,
        pairs: Pairs<B>,
        filter: impl Fn(
            &mut B,
            &PyramidParams,
            &Structure<B>,
            &B::Buffer<u32>,
            &mut B::Buffer<u32>,
            u32,
        ) -> Result<(), BackendError>,
    ) -> Result<Self, BackendError> {
        let depth = s.params.depth;
        let mut depths = backend.alloc("optical depths", s.firsts[depth as usize + 1] as usize)?;
        let mut children = backend.alloc("leaf depths", s.params.leaves as usize)?;
        backend.leaf_depths(&s.params, &sums, &mut children, s.params.leaves)?;
        place(backend, &children, s.params.first, &mut depths)?;
        for level in 1..=depth {
            let (params, count) = at_level(&s.params, &s.firsts, level);
            let mut of_level = backend.alloc("level depths", count as usize)?;
            filter(backend, &params, &s, &children, &mut of_level, count)?;
            place(backend, &of_level, params.first, &mut depths)?;
            children = of_level;
        }
        let Structure { params, blocks, firsts, points } = s;
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

/// Which points of all levels pairs of leaves and triangles make voxels, two words for each block.
fn marks<B: Backend>(
    backend: &mut B,
    params: &PyramidParams,
    pairs: &Pairs<B>,
) -> Result<B::Buffer<u32>, BackendError> {
    let depth = params.depth;
    let mut marks = backend.alloc("lattice", 2 * block_count(depth) as usize)?;
    let words = |level: u32| 2 * blocks_along(depth, level).pow(3);
    let mut below = backend.alloc("level lattice", words(0) as usize)?;
    let voxelise = VoxeliseParams { depth, ..Default::default() };
    backend.mark_voxels(&voxelise, &pairs.words, &mut below, pairs.count)?;
    place(backend, &below, 2 * level_offset(depth, 0), &mut marks)?;
    for level in 1..=depth {
        let mut of_level = backend.alloc("level lattice", words(level) as usize)?;
        let params = PyramidParams { level, ..*params };
        backend.parent_masks(&params, &below, &mut of_level, words(level))?;
        place(backend, &of_level, 2 * level_offset(depth, level), &mut marks)?;
        below = of_level;
    }
    Ok(marks)
}

impl<B: Backend> Structure<B> {
    fn new(backend: &mut B, params: &PyramidParams, marks: &B::Buffer<u32>) -> Result<Self, BackendError> {
        let depth = params.depth;
        let all = block_count(depth);
        let mut counts = backend.alloc("block counts", all as usize)?;
        backend.block_counts(params, marks, &mut counts, all)?;
        let starts = exclusive_scan(backend, &counts, all)?;
        let mut blocks = backend.alloc("blocks", (BLOCK_WORDS * all) as usize)?;
        backend.pack_blocks(params, marks, &starts, &mut blocks, BLOCK_WORDS * all)?;
        let on_host = backend.download(&starts)?;
        let mut firsts: Vec<u32> =
            (0..=depth).map(|level| on_host[level_offset(depth, level) as usize]).collect();
        let last = backend.download(&counts)?.last().copied().unwrap_or(0);
        firsts.push(on_host.last().copied().unwrap_or(0) + last);
        let leaves = firsts[depth as usize + 1] - firsts[0];
        let params = PyramidParams { first: firsts[0], leaves, ..*params };
        let mut points = Vec::new();
        for level in 0..=depth {
            let (params, count) = at_level(&params, &firsts, level);
            let mut of_level = backend.alloc("voxel points", count as usize)?;
            backend.voxel_points(&params, &blocks, &mut of_level, count)?;
            points.push(of_level);
        }
        Ok(Self { params, blocks, firsts, points })
    }
}

/// Adds what pairs' triangles cover of their leaves.
fn accumulate<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    s: &Structure<B>,
    pairs: &Pairs<B>,
    sums: &mut B::Buffer<u32>,
) -> Result<(), BackendError> {
    let (triangles, materials) = (&world.triangles, &world.materials);
    let texels = &world.texels;
    backend.accumulate_leaves(
        &s.params,
        &pairs.words,
        &s.blocks,
        triangles,
        materials,
        texels,
        sums,
        pairs.count,
    )
}
