//! How does a scene become binary voxels? LRSM §5.

use super::{LayeredRsm, Opacity};
use crate::backend::{Backend, BackendError, BufferLength};
use crate::technique::World;
use crate::technique::voxelised::{lattice, place, refine};
use glam::{Vec3, Vec4};
use twinlight_kernels::passes::elements::ShrinkParams;
use twinlight_kernels::passes::layered_rsm::voxels::{level_word, voxel_words};

/// A scene's voxels: a bit for each, two bytes for each of the levels above.
pub struct BinaryVoxels<B: Backend> {
    /// Bits, then levels of two bytes a voxel.
    pub words: B::Buffer<u32>,
    /// log₂ of the number along each side.
    pub depth: u32,
    /// Corner of the first voxel in metres; w is the edge of a voxel.
    pub lower: Vec4,
}

impl<B: Backend> BinaryVoxels<B> {
    /// Voxelises the scene and filters it upward.
    pub fn build(backend: &mut B, world: &World<B>, settings: &LayeredRsm) -> Result<Self, BackendError> {
        let depth = settings.depth();
        let params = lattice(&world.bounds, depth, true);
        let pairs = refine(backend, world, &params, 0..world.triangle_count)?;
        let mut level = backend.alloc("voxel bits", level_word(depth, 1) as usize)?;
        backend.mark_bits(
            &params,
            &pairs.words,
            &world.triangles,
            &world.materials,
            &world.texels,
            &mut level,
            pairs.count,
        )?;
        let mut words = backend.alloc("binary voxels", voxel_words(depth) as usize)?;
        place(backend, &level, 0, &mut words)?;
        let mean = u32::from(settings.opacity == Opacity::Mean);
        for number in 1..=depth {
            let end = if number == depth { voxel_words(depth) } else { level_word(depth, number + 1) };
            let count = end - level_word(depth, number);
            let mut next = backend.alloc("voxel level", count as usize)?;
            let params = ShrinkParams { depth, level: number, mean, ..Default::default() };
            backend.shrink_voxels(&params, &level, &mut next, count)?;
            place(backend, &next, level_word(depth, number), &mut words)?;
            level = next;
        }
        let edge = params.lower.w;
        let lower = (params.lower.truncate() - Vec3::splat(0.5 * edge)).extend(edge);
        Ok(Self { words, depth, lower })
    }

    /// Bytes of all levels.
    pub fn bytes(&self) -> u64 {
        4 * self.words.element_count() as u64
    }
}
