//! Which triangles lie in which voxels of a lattice over the scene? VCT §4.2.

use super::World;
use crate::backend::{Backend, BackendError, BufferLength};
use crate::error::SettingsError;
use crate::primitives::exclusive_scan;
use crate::scene::Bounds;
use glam::Vec3;
use std::ops::Range;
use twinlight_kernels::passes::elements::{PyramidParams, VoxeliseParams, WordParams};

/// The most pairs of cells and triangles: 1 GiB, as often as a refinement needs.
const MAX_PAIRS: u64 = 1 << 26;

/// Pairs of voxels and triangles.
pub(super) struct Pairs<B: Backend> {
    /// The voxel, then the triangle.
    pub words: B::Buffer<u32>,
    /// Number of pairs.
    pub count: u32,
}

/// A lattice of 2^depth cells along each side over a box; `thin` keeps the thinnest set of voxels without holes.
pub(super) fn lattice(bounds: &Bounds, depth: u32, thin: bool) -> PyramidParams {
    let side = 1u32 << depth;
    let extent = bounds.size().max_element().max(1.0e-6 * bounds.centre().abs().max_element());
    // Cells are centred on lattice points; the scene fills all but the outermost, and its box avoids their borders.
    let edge = extent.max(1.0e-9) / (side as f32 - 2.6);
    let corner = bounds.centre() - Vec3::splat(0.5 * side as f32 * edge);
    PyramidParams {
        lower: (corner + Vec3::splat(0.5 * edge)).extend(edge),
        inverse_edge: 1.0 / edge,
        depth,
        thin: u32::from(thin),
        ..Default::default()
    }
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
pub(super) fn refine<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    lattice: &PyramidParams,
    triangles: Range<u32>,
) -> Result<Pairs<B>, BackendError> {
    let (depth, edge) = (lattice.depth, lattice.lower.w);
    let corner = lattice.lower.truncate() - Vec3::splat(0.5 * edge);
    let size = (1u32 << depth) as f32 * edge;
    let mut params = VoxeliseParams { depth, first: triangles.start, ..Default::default() };
    let mut count = triangles.len() as u32;
    let mut words = backend.alloc("pairs", 2 * count as usize)?;
    backend.root_pairs(&params, &mut words, 2 * count)?;
    for level in 1..=depth {
        params.lower = corner.extend((1u32 << level) as f32 / size);
        params.thin = u32::from(lattice.thin != 0 && level == depth);
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
