//! On which inputs are the passes of the visibility filter timed? The same picture, 20 000 proxies in 10³ voxels.

use super::{COUNT, Case, SIDE, Samples, copy, exclusive_scan, floats, map, vectors, words};
use twinlight::backend::{Backend, Cpu};
use twinlight::technique::World;
use twinlight::technique::light_map::map_params;
use twinlight::technique::visibility_filter::{Cells, Lit, Proxies, VisibilityFilter};
use twinlight::technique::{Inspection, Job};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::visibility_filter::gather_voxels::GATHER_SHARE;
use twinlight_kernels::passes::visibility_filter::list::list_stride;

type Result<T> = std::result::Result<T, Box<dyn std::error::Error>>;

/// Hemisphere rays of a pixel.
const DIFFUSE_RAYS: u32 = 6;
/// Lobe rays of a pixel.
const LOBE_RAYS: u32 = 2;
const RAYS: u32 = DIFFUSE_RAYS + LOBE_RAYS;

/// The picture's way through the visibility filter.
pub struct Filter {
    density: ProxyParams,
    counts: Vec<u32>,
    proxies: Proxies<Cpu>,
    lit: Lit<Cpu>,
    overlaps: Vec<u32>,
    march: MarchParams,
    list: ListParams,
    voxels: Vec<u32>,
    coverage: Vec<f32>,
    sorted: Vec<u32>,
    counted: Vec<u32>,
    lists: Vec<u32>,
    headers: Vec<ListHeader>,
    pub(super) light_map: LightMapParams,
    pub(super) light_map_hits: Vec<Hit>,
}

impl Filter {
    /// Runs every pass once.
    pub fn new(
        cpu: &mut Cpu,
        w: &World<Cpu>,
        camera: &CameraParams,
        surfaces: &<Cpu as Backend>::Buffer<Surface>,
        gloss: &<Cpu as Backend>::Buffer<Vec4>,
    ) -> Result<Self> {
        let settings = VisibilityFilter { proxies: 20_000, grid: [10; 3], ..Default::default() };
        let job = Job { rays: 1, ..Job::default() };
        let proxies = Proxies::build(cpu, w, &settings, 1, true)?;
        let mut seen = Inspection::new(&job, SIDE, SIDE);
        let lit = Lit::light(cpu, w, &proxies, &settings, &job, &mut seen)?;
        let density = ProxyParams {
            density: (f64::from(settings.proxies) / w.area) as f32,
            radius: proxies.radius,
            cells_per_length: 1e4,
            seed: 1,
            triangles: w.triangle_count,
            proxies: proxies.count(),
            ..Default::default()
        };
        let mut counts = cpu.alloc("counts", w.triangle_count as usize)?;
        cpu.proxy_counts(&density, &w.triangles, &mut counts, w.triangle_count)?;
        let mut overlaps = cpu.alloc("overlaps", proxies.count() as usize)?;
        let cells = proxies.cells.as_ref().ok_or("no cells")?;
        cpu.overlap_counts(&cells.grid, &proxies.proxies, &mut overlaps, proxies.count())?;

        let march = MarchParams {
            lower: proxies.grid.lower,
            cell_inverse_size: cells.grid.inverse_size,
            cell_dims: cells.grid.dims,
            voxel_inverse_size: proxies.grid.inverse_size,
            voxel_dims: proxies.grid.dims,
            eye: camera.eye,
            diffuse_rays: DIFFUSE_RAYS,
            lobe_rays: LOBE_RAYS,
            seed: 1,
            ..Default::default()
        };
        let rays = COUNT * RAYS;
        let p = &proxies;
        let mut voxels = cpu.alloc("voxels", rays as usize)?;
        cpu.march_rays(&march, surfaces, gloss, &cells.starts, &cells.pairs, &p.proxies, &mut voxels, rays)?;
        let mut coverage = cpu.alloc("coverage", COUNT as usize)?;
        cpu.lobe_coverage(&march, surfaces, gloss, &voxels, &mut coverage, COUNT)?;
        let list = ListParams {
            width: SIDE,
            height: SIDE,
            diffuse_rays: DIFFUSE_RAYS,
            lobe_rays: LOBE_RAYS,
            half_width: 3,
            half_height: 3,
            capacity: 128,
            max_depth_difference: 0.02,
            min_normal_cosine: 0.9,
            occupied: p.occupied,
            ..Default::default()
        };
        let mut sorted = cpu.alloc("sorted", rays as usize)?;
        cpu.sort_rays(&list, &voxels, &mut sorted, rays)?;
        let mut counted = cpu.alloc("counted", (COUNT * (RAYS + 1)) as usize)?;
        cpu.count_rays(&list, &sorted, &mut counted, COUNT)?;
        let mut lists = cpu.alloc("lists", (COUNT * list_stride(list.capacity)) as usize)?;
        cpu.filter_lists(&list, surfaces, &counted, &mut lists, COUNT)?;
        let mut headers = cpu.alloc("headers", COUNT as usize)?;
        cpu.list_headers(&list, surfaces, &coverage, &mut headers, COUNT)?;

        let light_map = map_params(&w.host_lights[0], &w.bounds, SIDE, p.radius);
        let mut hits = cpu.alloc("light map", COUNT as usize)?;
        let (tris, mats) = (&w.triangles, &w.materials);
        cpu.trace_light_map(&light_map, &w.nodes, &w.blocks, tris, mats, &w.texels, &mut hits, COUNT)?;
        Ok(Self {
            density,
            counts: copy(&counts),
            overlaps: copy(&overlaps),
            march,
            list,
            voxels: copy(&voxels),
            coverage: copy(&coverage),
            sorted: copy(&sorted),
            counted: copy(&counted),
            lists: copy(&lists),
            headers: copy(&headers),
            light_map,
            light_map_hits: copy(&hits),
            lit,
            proxies,
        })
    }

    /// Built with them in [`Filter::new`].
    fn cells(&self) -> &Cells<Cpu> {
        self.proxies.cells.as_ref().expect("built with cells")
    }

    fn proxies(&self) -> Vec<Proxy> {
        copy(&self.proxies.proxies)
    }
}

pub fn proxy_counts(s: &Samples) -> Case<ProxyParams, (Vec<Triangle>,)> {
    let params = s.filter.density;
    map(params, (s.triangles(),), params.triangles)
}

type MakeProxies = (Vec<u32>, Vec<Triangle>, Vec<Material>, Vec<u32>);

pub fn make_proxies(s: &Samples) -> Case<ProxyParams, MakeProxies> {
    let (materials, texels) = s.materials();
    let params = ProxyParams { proxies: s.filter.counts.iter().sum(), ..s.filter.density };
    let starts = exclusive_scan(&s.filter.counts);
    map(params, (starts, s.triangles(), materials, texels), params.proxies)
}

type OfProxies = (Vec<Proxy>, Vec<Triangle>, Vec<Material>, Vec<u32>);

pub fn proxy_surfaces(s: &Samples) -> Case<ProxyParams, OfProxies> {
    let (materials, texels) = s.materials();
    map(
        s.filter.density,
        (s.filter.proxies(), s.triangles(), materials, texels),
        2 * s.filter.density.proxies,
    )
}

pub fn proxy_keys(s: &Samples) -> Case<GridParams, (Vec<Proxy>,)> {
    map(s.filter.proxies.grid, (s.filter.proxies(),), 2 * s.filter.proxies.count())
}

pub fn reorder_proxies(s: &Samples) -> Case<GridParams, (Vec<u32>, Vec<Proxy>)> {
    let count = s.filter.proxies.count();
    let backwards = (0..count).rev().flat_map(|i| [0, i]).collect();
    map(s.filter.proxies.grid, (backwards, s.filter.proxies()), count)
}

pub fn cell_starts(s: &Samples) -> Case<GridParams, (Vec<u32>,)> {
    let cells = s.filter.cells();
    map(cells.grid, (copy(&cells.pairs),), cells.grid.dims.w + 1)
}

pub fn overlap_counts(s: &Samples) -> Case<GridParams, (Vec<Proxy>,)> {
    map(s.filter.cells().grid, (s.filter.proxies(),), s.filter.proxies.count())
}

pub fn overlap_pairs(s: &Samples) -> Case<GridParams, (Vec<u32>, Vec<Proxy>)> {
    let cells = s.filter.cells().grid;
    map(cells, (exclusive_scan(&s.filter.overlaps), s.filter.proxies()), 2 * cells.pairs)
}

pub fn dark_sides(_: &Samples) -> Case<GridParams, (Vec<f32>,)> {
    map(GridParams::default(), (floats(COUNT),), COUNT)
}

type AddLobes = (Vec<Surface>, Vec<Vec4>, Vec<Light>, Vec<u32>, Vec<Vec4>);

pub fn add_lobes(s: &Samples) -> Case<LobeParams, AddLobes> {
    let lights = copy(&s.world.lights);
    let count = lights.len() as u32;
    let params = LobeParams { light_count: count, lights: count, sides: COUNT, ..Default::default() };
    let words = COUNT * (1 + 2 * count);
    map(params, (copy(&s.surfaces), copy(&s.gloss), lights, vec![!0; COUNT as usize], vectors(words)), words)
}

pub fn sum_voxels(s: &Samples) -> Case<GridParams, (Vec<u32>, Vec<Proxy>, Vec<Vec4>)> {
    let (p, lit) = (&s.filter.proxies, &s.filter.lit);
    let params = GridParams { lights: lit.lights, ..p.grid };
    map(params, (copy(&p.starts), s.filter.proxies(), copy(&lit.radiance)), p.grid.dims.w)
}

type MarchRays = (Vec<Surface>, Vec<Vec4>, Vec<u32>, Vec<u32>, Vec<Proxy>);

pub fn march_rays(s: &Samples) -> Case<MarchParams, MarchRays> {
    let cells = s.filter.cells();
    let surfaces = (copy(&s.surfaces), copy(&s.gloss));
    let inputs = (surfaces.0, surfaces.1, copy(&cells.starts), copy(&cells.pairs), s.filter.proxies());
    map(s.filter.march, inputs, COUNT * RAYS)
}

type TraceRays =
    (Vec<Surface>, Vec<Vec4>, Vec<BvhNode>, Vec<TriangleBlock>, Vec<Triangle>, Vec<Material>, Vec<u32>);

pub fn trace_rays(s: &Samples) -> Case<MarchParams, TraceRays> {
    let ((nodes, blocks), (materials, texels)) = (s.tree(), s.materials());
    let inputs = (copy(&s.surfaces), copy(&s.gloss), nodes, blocks, s.triangles(), materials, texels);
    map(s.filter.march, inputs, COUNT * RAYS)
}

pub fn lobe_coverage(s: &Samples) -> Case<MarchParams, (Vec<Surface>, Vec<Vec4>, Vec<u32>)> {
    map(s.filter.march, (copy(&s.surfaces), copy(&s.gloss), s.filter.voxels.clone()), COUNT)
}

pub fn sort_rays(s: &Samples) -> Case<ListParams, (Vec<u32>,)> {
    map(s.filter.list, (s.filter.voxels.clone(),), COUNT * RAYS)
}

pub fn count_rays(s: &Samples) -> Case<ListParams, (Vec<u32>,)> {
    let inputs = (s.filter.sorted.clone(),);
    Case { params: s.filter.list, inputs, outputs: COUNT * (RAYS + 1), items: COUNT }
}

pub fn filter_lists(s: &Samples) -> Case<ListParams, (Vec<Surface>, Vec<u32>)> {
    let inputs = (copy(&s.surfaces), s.filter.counted.clone());
    Case { params: s.filter.list, inputs, outputs: s.filter.lists.len() as u32, items: COUNT }
}

pub fn list_headers(s: &Samples) -> Case<ListParams, (Vec<Surface>, Vec<f32>)> {
    map(s.filter.list, (copy(&s.surfaces), s.filter.coverage.clone()), COUNT)
}

fn gather_params(s: &Samples) -> GatherVoxelsParams {
    GatherVoxelsParams {
        eye: s.camera.eye,
        width: SIDE,
        coarse_width: SIDE,
        coarse_height: SIDE,
        scale_x: 1.0,
        scale_y: 1.0,
        near_range: 1.0,
        depth_deviation: 0.01,
        normal_deviation: 0.1,
        capacity: s.filter.list.capacity,
        flags: GATHER_SHARE,
        trust: 2.0,
        disc_radius: s.filter.proxies.radius,
        lights: s.filter.lit.lights,
        sides: 2 * s.filter.proxies.count(),
        ..Default::default()
    }
}

type GatherDiffuse = (Vec<Surface>, Vec<ListHeader>, Vec<u32>, Vec<Voxel>, Vec<Proxy>, Vec<Vec4>);

pub fn gather_diffuse(s: &Samples) -> Case<GatherVoxelsParams, GatherDiffuse> {
    let (f, lit) = (&s.filter, &s.filter.lit);
    let lists = (f.headers.clone(), f.lists.clone());
    let light = (copy(&lit.voxels), f.proxies(), copy(&lit.radiance));
    map(gather_params(s), (copy(&s.surfaces), lists.0, lists.1, light.0, light.1, light.2), COUNT)
}

type GatherSpecular = (Vec<Surface>, Vec<Vec4>, Vec<ListHeader>, Vec<u32>, Vec<Voxel>, Vec<Proxy>, Vec<Vec4>);

pub fn gather_specular(s: &Samples) -> Case<GatherVoxelsParams, GatherSpecular> {
    let Case { params, inputs: (surfaces, headers, lists, voxels, proxies, radiance), .. } =
        gather_diffuse(s);
    map(params, (surfaces, copy(&s.gloss), headers, lists, voxels, proxies, radiance), COUNT)
}

type DrawProxies = (Vec<GridParams>, Vec<u32>, Vec<u32>, Vec<Proxy>, Vec<Vec4>);

pub fn draw_proxies(s: &Samples) -> Case<CameraParams, DrawProxies> {
    let cells = s.filter.cells();
    let pairs = (copy(&cells.starts), copy(&cells.pairs));
    let inputs = (vec![cells.grid], pairs.0, pairs.1, s.filter.proxies(), copy(&s.filter.lit.radiance));
    map(s.camera, inputs, COUNT)
}

pub fn upsample(s: &Samples) -> Case<UpsampleParams, (Vec<Surface>, Vec<Surface>, Vec<Vec4>)> {
    let params = UpsampleParams {
        width: SIDE,
        coarse_width: SIDE,
        coarse_height: SIDE,
        scale_x: 0.5,
        scale_y: 0.5,
        ..Default::default()
    };
    map(params, (copy(&s.surfaces), copy(&s.surfaces), vectors(COUNT)), COUNT)
}

pub fn filter_interleaved(s: &Samples) -> Case<InterleavedParams, (Vec<Surface>, Vec<Vec4>)> {
    let params = InterleavedParams { columns: SIDE, rows: SIDE, ..Default::default() };
    map(params, (copy(&s.surfaces), vectors(COUNT)), COUNT)
}

type TraceLightMap = (Vec<BvhNode>, Vec<TriangleBlock>, Vec<Triangle>, Vec<Material>, Vec<u32>);

pub fn trace_light_map(s: &Samples) -> Case<LightMapParams, TraceLightMap> {
    let ((nodes, blocks), (materials, texels)) = (s.tree(), s.materials());
    map(s.filter.light_map, (nodes, blocks, s.triangles(), materials, texels), COUNT)
}

pub fn light_map_visibility(s: &Samples) -> Case<LightMapParams, (Vec<Surface>, Vec<Hit>, Vec<u32>)> {
    let inputs = (copy(&s.surfaces), s.filter.light_map_hits.clone(), words(COUNT));
    map(s.filter.light_map, inputs, COUNT)
}

pub fn add_diffuse_reflection(s: &Samples) -> Case<AddParams, (Vec<Surface>, Vec<Vec4>, Vec<Vec4>)> {
    map(AddParams::default(), (copy(&s.surfaces), vectors(COUNT), vectors(COUNT)), COUNT)
}

pub fn add_specular_reflection(s: &Samples) -> Case<AddParams, (Vec<Vec4>, Vec<Vec4>, Vec<Vec4>)> {
    map(AddParams::default(), (copy(&s.gloss), vectors(COUNT), vectors(COUNT)), COUNT)
}
