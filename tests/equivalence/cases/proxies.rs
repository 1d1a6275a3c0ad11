//! Inputs of the passes over point proxies, voxels and light maps: the random scenes of `scene`.

use super::arrays::scanned;
use super::scene::{World, launch, previous, worlds};
use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::{UVec4, Vec3, Vec4};
use twinlight::scene::Bounds;
use twinlight::technique::light_map::map_params;
use twinlight_kernels::passes;
use twinlight_kernels::passes::elements::*;

/// Voxels along each axis.
pub(super) const DIMS: [u32; 3] = [5, 4, 3];

/// A scene and its proxies in voxels, made on the host one kernel at a time.
pub(super) struct Proxied {
    pub(super) world: World,
    pub(super) params: ProxyParams,
    pub(super) grid: GridParams,
    pub(super) cells: GridParams,
    pub(super) triangle_starts: Vec<u32>,
    pub(super) unsorted: Vec<Proxy>,
    pub(super) order: Vec<u32>,
    pub(super) proxies: Vec<Proxy>,
    pub(super) starts: Vec<u32>,
    pub(super) overlap_starts: Vec<u32>,
    pub(super) pairs: Vec<u32>,
    pub(super) pair_starts: Vec<u32>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) gloss: Vec<Vec4>,
    pub(super) visible: Vec<u32>,
    pub(super) lobes: LobeParams,
    /// The sides' radiance, and the lobes behind.
    pub(super) radiance: Vec<Vec4>,
}

/// The exclusive scan and the sum.
fn scan(counts: &[u32]) -> (Vec<u32>, u32) {
    (scanned(counts), counts.iter().sum())
}

/// Pairs in order of keys.
fn sorted(pairs: &[u32]) -> Vec<u32> {
    let mut all: Vec<[u32; 2]> = pairs.chunks_exact(2).map(|p| [p[0], p[1]]).collect();
    all.sort_by_key(|p| p[0]);
    all.concat()
}

impl Proxied {
    pub(super) fn new(draw: &mut Draw, world: World) -> Self {
        let triangles = world.triangles.len() as u32;
        let mut params = ProxyParams {
            density: 12.0,
            radius: 0.35,
            cells_per_length: 1e5,
            seed: draw.word(),
            triangles,
            ..Default::default()
        };
        let counts: Vec<u32> =
            (0..triangles).map(|i| passes::proxy_counts(i, &params, &world.triangles)).collect();
        let (triangle_starts, count) = scan(&counts);
        params.proxies = count;
        let (tris, mats, texels) = (&world.triangles, &world.materials, &world.texels);
        let make = |i| passes::make_proxies(i, &params, &triangle_starts, tris, mats, texels);
        let unsorted: Vec<Proxy> = (0..count).map(make).collect();
        let bounds = Bounds::of(tris);
        let grid = GridParams {
            lower: (bounds.min - Vec3::splat(0.01)).extend(0.0),
            inverse_size: (glam::UVec3::from_array(DIMS).as_vec3() / (bounds.size() + Vec3::splat(0.02)))
                .extend(0.0),
            dims: UVec4::new(DIMS[0], DIMS[1], DIMS[2], DIMS.iter().product()),
            proxies: count,
            pairs: count,
            weighted: 1,
            lights: world.lights.len() as u32,
        };
        let keys: Vec<u32> = (0..2 * count).map(|i| passes::proxy_keys(i, &grid, &unsorted)).collect();
        let order = sorted(&keys);
        let proxies: Vec<Proxy> =
            (0..count).map(|i| passes::reorder_proxies(i, &grid, &order, &unsorted)).collect();
        let starts = (0..=grid.dims.w).map(|i| passes::cell_starts(i, &grid, &order)).collect();
        let dims = UVec4::new(2 * DIMS[0], 2 * DIMS[1], 2 * DIMS[2], 8 * grid.dims.w);
        let mut cells = GridParams { dims, inverse_size: grid.inverse_size * 2.0, ..grid };
        let overlaps: Vec<u32> = (0..count).map(|i| passes::overlap_counts(i, &cells, &proxies)).collect();
        let (overlap_starts, pairs) = scan(&overlaps);
        cells.pairs = pairs;
        let pair = |i| passes::overlap_pairs(i, &cells, &overlap_starts, &proxies);
        let pairs = sorted(&(0..2 * pairs).map(pair).collect::<Vec<u32>>());
        let pair_starts = (0..=dims.w).map(|i| passes::cell_starts(i, &cells, &pairs)).collect();
        let holes = proxies.iter().filter(|p| p.position.w == 0.0).count();
        assert!(count > 100 && holes > 0 && holes < count as usize / 2, "{count} proxies, {holes} in holes");
        let sides = 2 * count;
        let mut radiance: Vec<Vec4> = (0..sides)
            .map(|_| if draw.rarely(3) { Vec4::W } else { draw.units().truncate().extend(draw.unit()) })
            .collect();
        radiance.resize((sides * (1 + 2 * grid.lights)) as usize, Vec4::ZERO);
        let surface = |i| passes::proxy_surfaces(i, &params, &proxies, tris, mats, texels);
        let surfaces: Vec<Surface> = (0..sides).map(surface).collect();
        let gloss: Vec<Vec4> = (0..sides)
            .map(|i| passes::resolve_gloss(i, &CameraParams::default(), &surfaces, mats, texels))
            .collect();
        let visible: Vec<u32> = (0..sides).map(|_| draw.word()).collect();
        let lobes = LobeParams { first_light: 0, light_count: grid.lights, lights: grid.lights, sides };
        let one = |i| passes::add_lobes(i, &lobes, &surfaces, &gloss, &world.lights, &visible, &radiance);
        radiance = (0..radiance.len() as u32).map(one).collect();
        Self {
            world,
            params,
            grid,
            cells,
            triangle_starts,
            unsorted,
            order,
            proxies,
            starts,
            overlap_starts,
            pairs,
            pair_starts,
            surfaces,
            gloss,
            visible,
            lobes,
            radiance,
        }
    }

    pub(super) fn all(draw: &mut Draw) -> [Self; 2] {
        let worlds = worlds(draw);
        worlds.map(|w| Self::new(draw, w))
    }

    fn of_proxies(&self, label: &str, per_proxy: u32) -> Launch {
        let items = per_proxy * self.params.proxies;
        Launch::new(label, items as usize, items)
    }

    pub(super) fn voxels(&self) -> Vec<Voxel> {
        let one = |i| passes::sum_voxels(i, &self.grid, &self.starts, &self.proxies, &self.radiance);
        (0..self.grid.dims.w).map(one).collect()
    }
}

pub fn proxy_counts(draw: &mut Draw) -> Vec<case::proxy_counts> {
    Proxied::all(draw)
        .map(|p| case::proxy_counts {
            launch: Launch::new("a scene", p.params.triangles as usize, p.params.triangles),
            params: p.params,
            triangles: p.world.triangles,
        })
        .into()
}

pub fn make_proxies(draw: &mut Draw) -> Vec<case::make_proxies> {
    Proxied::all(draw)
        .map(|p| case::make_proxies {
            launch: p.of_proxies("a scene", 1),
            params: p.params,
            starts: p.triangle_starts,
            triangles: p.world.triangles,
            materials: p.world.materials,
            texels: p.world.texels,
        })
        .into()
}

pub fn proxy_surfaces(draw: &mut Draw) -> Vec<case::proxy_surfaces> {
    Proxied::all(draw)
        .map(|p| case::proxy_surfaces {
            launch: p.of_proxies("both sides", 2),
            params: p.params,
            proxies: p.proxies,
            triangles: p.world.triangles,
            materials: p.world.materials,
            texels: p.world.texels,
        })
        .into()
}

pub fn proxy_keys(draw: &mut Draw) -> Vec<case::proxy_keys> {
    Proxied::all(draw)
        .map(|p| case::proxy_keys {
            launch: p.of_proxies("unsorted", 2),
            params: p.grid,
            proxies: p.unsorted,
        })
        .into()
}

pub fn reorder_proxies(draw: &mut Draw) -> Vec<case::reorder_proxies> {
    Proxied::all(draw)
        .map(|p| case::reorder_proxies {
            launch: p.of_proxies("by voxel", 1),
            params: p.grid,
            pairs: p.order,
            proxies: p.unsorted,
        })
        .into()
}

pub fn cell_starts(draw: &mut Draw) -> Vec<case::cell_starts> {
    Proxied::all(draw)
        .map(|p| {
            let cells = p.cells.dims.w + 1;
            case::cell_starts {
                launch: Launch::new("overlapped cells", cells as usize, cells),
                params: p.cells,
                pairs: p.pairs,
            }
        })
        .into()
}

pub fn overlap_counts(draw: &mut Draw) -> Vec<case::overlap_counts> {
    Proxied::all(draw)
        .map(|p| case::overlap_counts {
            launch: p.of_proxies("by voxel", 1),
            params: p.cells,
            proxies: p.proxies,
        })
        .into()
}

pub fn overlap_pairs(draw: &mut Draw) -> Vec<case::overlap_pairs> {
    Proxied::all(draw)
        .map(|p| case::overlap_pairs {
            launch: Launch::new("all pairs", 2 * p.cells.pairs as usize, 2 * p.cells.pairs),
            params: p.cells,
            starts: p.overlap_starts,
            proxies: p.proxies,
        })
        .into()
}

pub fn dark_sides(draw: &mut Draw) -> Vec<case::dark_sides> {
    let openness: Vec<f32> = (0..500).map(|_| draw.unit()).collect();
    let launch = Launch::new("500 sides", 500, 499);
    vec![case::dark_sides { params: GridParams::default(), launch, openness }]
}

/// All lights at once, and the last of them on its own.
pub fn add_lobes(draw: &mut Draw) -> Vec<case::add_lobes> {
    Proxied::all(draw)
        .into_iter()
        .enumerate()
        .map(|(i, p)| {
            let words = p.radiance.len();
            let lobes = p.radiance[p.lobes.sides as usize..].iter().skip(1).step_by(2);
            let lit = lobes.filter(|v| v.x > 0.0).count();
            assert!(lit > 20, "{lit} lobes are lit");
            let first_light = if i == 0 { 0 } else { p.lobes.lights - 1 };
            case::add_lobes {
                launch: Launch::new(format!("from light {first_light}"), words, words as u32),
                params: LobeParams { first_light, light_count: p.lobes.lights - first_light, ..p.lobes },
                surfaces: p.surfaces,
                gloss: p.gloss,
                lights: p.world.lights,
                visibility: p.visible,
                previous: previous(draw).into_iter().cycle().take(words).collect(),
            }
        })
        .collect()
}

pub fn sum_voxels(draw: &mut Draw) -> Vec<case::sum_voxels> {
    let mut weighted = 0;
    Proxied::all(draw)
        .map(|p| {
            weighted = 1 - weighted;
            case::sum_voxels {
                launch: Launch::new(format!("weighted: {weighted}"), p.grid.dims.w as usize, p.grid.dims.w),
                params: GridParams { weighted, ..p.grid },
                starts: p.starts,
                proxies: p.proxies,
                radiance: p.radiance,
            }
        })
        .into()
}

pub fn draw_proxies(draw: &mut Draw) -> Vec<case::draw_proxies> {
    Proxied::all(draw)
        .map(|p| case::draw_proxies {
            launch: launch("a band of pixels"),
            params: p.world.camera,
            grid: vec![p.cells],
            starts: p.pair_starts,
            pairs: p.pairs,
            proxies: p.proxies,
            radiance: p.radiance,
        })
        .into()
}

/// The maps of a point, a spot and a sun.
fn maps(world: &World) -> Vec<LightMapParams> {
    let bounds = Bounds::of(&world.triangles);
    let lights = world.lights.iter().take(3).enumerate();
    lights
        .map(|(i, light)| LightMapParams { light: 9 * i as u32, ..map_params(light, &bounds, 24, 0.05) })
        .collect()
}

fn map_hits(world: &World, params: &LightMapParams) -> Vec<Hit> {
    let w = world;
    let one =
        |i| passes::trace_light_map(i, params, &w.nodes, &w.blocks, &w.triangles, &w.materials, &w.texels);
    (0..params.size * params.size).map(one).collect()
}

pub fn trace_light_map(draw: &mut Draw) -> Vec<case::trace_light_map> {
    let [w, _] = worlds(draw);
    maps(&w)
        .into_iter()
        .map(|params| case::trace_light_map {
            launch: Launch::new(format!("projection {}", params.projection), 24 * 24, 24 * 24),
            params,
            nodes: w.nodes.clone(),
            blocks: w.blocks.clone(),
            triangles: w.triangles.clone(),
            materials: w.materials.clone(),
            texels: w.texels.clone(),
        })
        .collect()
}

pub fn light_map_visibility(draw: &mut Draw) -> Vec<case::light_map_visibility> {
    let [w, _] = worlds(draw);
    let words: Vec<u32> = w.surfaces.iter().map(|_| draw.word()).collect();
    maps(&w)
        .into_iter()
        .map(|params| case::light_map_visibility {
            launch: launch(&format!("projection {}", params.projection)),
            hits: map_hits(&w, &params),
            params,
            surfaces: w.surfaces.clone(),
            previous: words.clone(),
        })
        .collect()
}

pub fn add_diffuse_reflection(draw: &mut Draw) -> Vec<case::add_diffuse_reflection> {
    let [w, _] = worlds(draw);
    vec![case::add_diffuse_reflection {
        launch: launch("a band of pixels"),
        params: AddParams::default(),
        surfaces: w.surfaces,
        light: previous(draw),
        previous: previous(draw),
    }]
}

pub fn add_specular_reflection(draw: &mut Draw) -> Vec<case::add_specular_reflection> {
    let [w, _] = worlds(draw);
    vec![case::add_specular_reflection {
        launch: launch("a band of pixels"),
        params: AddParams::default(),
        gloss: w.gloss(),
        light: previous(draw),
        previous: previous(draw),
    }]
}
