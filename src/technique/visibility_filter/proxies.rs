//! How does a scene become proxies in voxels? VF §3.1.

use super::VisibilityFilter;
use crate::backend::{Backend, BackendError};
use crate::primitives::{exclusive_scan, sort_pairs};
use crate::technique::World;
use glam::{UVec3, Vec3};
use twinlight_kernels::passes::elements::{GatherParams, GridParams, Proxy, ProxyParams, Surface};

/// Proxies of a scene, in voxels. They change with the scene's geometry only.
pub struct Proxies<B: Backend> {
    /// The voxels.
    pub grid: GridParams,
    /// The finer grid that rays walk through; only where discs are met or drawn.
    pub cells: Option<Cells<B>>,
    /// Proxies in the order of the voxel of their centre.
    pub proxies: B::Buffer<Proxy>,
    /// Where each voxel's proxies begin, with one element more.
    pub starts: B::Buffer<u32>,
    /// Each proxy's front and back.
    pub surfaces: B::Buffer<Surface>,
    /// How open each front and back is within a voxel's diagonal: of surfaces behind each other in one voxel, one is
    /// seen and the others are not.
    pub openness: B::Buffer<f32>,
    /// Radius of the discs, metres.
    pub radius: f32,
    /// Voxels with a proxy's centre in them: what a ray can meet.
    pub occupied: u32,
}

/// Which discs reach into which cell of a finer grid.
pub struct Cells<B: Backend> {
    /// The grid.
    pub grid: GridParams,
    /// Pairs (cell, proxy) of all cells that discs overlap, sorted.
    pub pairs: B::Buffer<u32>,
    /// Where each cell's pairs begin, with one element more.
    pub starts: B::Buffer<u32>,
}

/// The most cells for rays to walk through: 16 MiB of starts.
const MAX_CELLS: u64 = 1 << 22;

/// Rays that tell how open a side of a proxy is.
const OPENNESS_RAYS: u32 = 16;

/// The grid of `dims` voxels around a scene, a little larger than its box.
fn grid(bounds: &crate::scene::Bounds, dims: [u32; 3]) -> GridParams {
    let size = bounds.size();
    let margin = (1.0e-3 * size.max_element()).max(1.0e-6 * bounds.centre().abs().max_element()).max(1.0e-9);
    let dims = UVec3::from_array(dims);
    let edge = (size + Vec3::splat(2.0 * margin)) / dims.as_vec3();
    GridParams {
        lower: (bounds.centre() - 0.5 * size - Vec3::splat(margin)).extend(0.0),
        inverse_size: edge.recip().extend(0.0),
        dims: dims.extend(dims.element_product()),
        ..Default::default()
    }
}

/// Cells for rays to walk through: three radii wide, so that a ray tests a few dozen discs however many there are.
fn cells(bounds: &crate::scene::Bounds, radius: f32) -> GridParams {
    let mut edge = (3.0 * radius).max(1.0e-3 * bounds.size().max_element()).max(1.0e-12);
    loop {
        let dims = (bounds.size() / edge).ceil().max(Vec3::ONE).as_dvec3();
        if dims.element_product() <= MAX_CELLS as f64 {
            return grid(bounds, dims.as_uvec3().to_array());
        }
        edge *= 1.25;
    }
}

/// The element behind the last of an exclusive scan.
fn total<B: Backend>(
    backend: &mut B,
    scanned: &B::Buffer<u32>,
    counts: &B::Buffer<u32>,
) -> Result<u32, BackendError> {
    let last = backend.download(scanned)?.last().copied().unwrap_or(0);
    Ok(last + backend.download(counts)?.last().copied().unwrap_or(0))
}

/// Bits of the largest cell's number.
fn key_bits(grid: &GridParams) -> u32 {
    32 - grid.dims.w.leading_zeros()
}

impl<B: Backend> Cells<B> {
    fn build(
        backend: &mut B,
        mut grid: GridParams,
        proxies: &B::Buffer<Proxy>,
        count: u32,
    ) -> Result<Self, BackendError> {
        grid.proxies = count;
        let mut overlaps = backend.alloc("overlap counts", count as usize)?;
        backend.overlap_counts(&grid, proxies, &mut overlaps, count)?;
        let overlap_starts = exclusive_scan(backend, &overlaps, count)?;
        grid.pairs = total(backend, &overlap_starts, &overlaps)?;
        let mut pairs = backend.alloc("overlap pairs", 2 * grid.pairs as usize)?;
        backend.overlap_pairs(&grid, &overlap_starts, proxies, &mut pairs, 2 * grid.pairs)?;
        let pairs = sort_pairs(backend, pairs, key_bits(&grid))?;
        let mut starts = backend.alloc("pair starts", grid.dims.w as usize + 1)?;
        backend.cell_starts(&grid, &pairs, &mut starts, grid.dims.w + 1)?;
        Ok(Self { grid, pairs, starts })
    }
}

impl<B: Backend> Proxies<B> {
    /// Makes the proxies and sorts them; `with_cells` if their discs are to be met or drawn.
    pub fn build(
        backend: &mut B,
        world: &World<B>,
        settings: &VisibilityFilter,
        seed: u32,
        with_cells: bool,
    ) -> Result<Self, BackendError> {
        let density = f64::from(settings.proxies) / world.area.max(1.0e-30);
        let radius = (f64::from(settings.overlap) / (std::f64::consts::PI * density)).sqrt() as f32;
        let extent = world.bounds.size().max_element().max(1.0e-30);
        let mut params = ProxyParams {
            density: density as f32,
            radius,
            // 2²⁰ cells: about what the digits of a position tell apart.
            cells_per_length: 1_048_576.0 / extent,
            seed,
            triangles: world.triangle_count,
            ..Default::default()
        };
        let w = world;
        let mut counts = backend.alloc("proxy counts", w.triangle_count as usize)?;
        backend.proxy_counts(&params, &w.triangles, &mut counts, w.triangle_count)?;
        let starts = exclusive_scan(backend, &counts, w.triangle_count)?;
        let count = total(backend, &starts, &counts)?;
        params.proxies = count;
        let mut made = backend.alloc("proxies", count as usize)?;
        backend.make_proxies(&params, &starts, &w.triangles, &w.materials, &w.texels, &mut made, count)?;

        let mut grid = grid(&w.bounds, settings.grid);
        (grid.proxies, grid.pairs) = (count, count);
        let mut keys = backend.alloc("proxy keys", 2 * count as usize)?;
        backend.proxy_keys(&grid, &made, &mut keys, 2 * count)?;
        let order = sort_pairs(backend, keys, key_bits(&grid))?;
        let mut proxies = backend.alloc("proxies", count as usize)?;
        backend.reorder_proxies(&grid, &order, &made, &mut proxies, count)?;
        let mut starts = backend.alloc("voxel starts", grid.dims.w as usize + 1)?;
        backend.cell_starts(&grid, &order, &mut starts, grid.dims.w + 1)?;
        let mut surfaces = backend.alloc("proxy surfaces", 2 * count as usize)?;
        backend.proxy_surfaces(
            &params,
            &proxies,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut surfaces,
            2 * count,
        )?;

        let cells = if with_cells {
            Some(Cells::build(backend, cells(&w.bounds, radius), &proxies, count)?)
        } else {
            None
        };
        let occupied = backend.download(&starts)?.windows(2).filter(|w| w[0] < w[1]).count() as u32;
        let reach = grid.inverse_size.truncate().recip().length();
        let open = GatherParams { rays: OPENNESS_RAYS, seed, reach, ..Default::default() };
        let mut openness = backend.alloc("openness", 2 * count as usize)?;
        backend.ambient_openness(
            &open,
            &surfaces,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut openness,
            2 * count,
        )?;
        Ok(Self { grid, cells, proxies, starts, surfaces, openness, radius, occupied })
    }

    /// Number of proxies.
    pub fn count(&self) -> u32 {
        self.grid.proxies
    }
}
