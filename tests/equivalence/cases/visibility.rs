//! Inputs of the passes over lists of visible voxels: rays from random surfaces to the proxies of `proxies`.

use super::proxies::Proxied;
use super::scene::{FIRST, PIXELS, WIDTH, launch, previous, worlds};
use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::Vec4;
use twinlight_kernels::passes;
use twinlight_kernels::passes::Accumulate;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::upsample::{BILATERAL, BILINEAR, NEAREST};
use twinlight_kernels::passes::visibility_filter::gather_voxels::{
    CLAMP_DISC, CLAMP_NONE, CLAMP_RADIUS, GATHER_SHARE,
};
use twinlight_kernels::passes::visibility_filter::list::list_stride;
use twinlight_kernels::passes::visibility_filter::march::WORLD_ANCHORED;

/// Rows of the coarse picture: whole ones of the scene's pixels.
const ROWS: u32 = PIXELS / WIDTH;
const COARSE: u32 = WIDTH * ROWS;
const DIFFUSE_RAYS: u32 = 9;
const LOBE_RAYS: u32 = 4;
const RAYS: u32 = DIFFUSE_RAYS + LOBE_RAYS;

/// Cells that a scatter pass run on the host writes to.
pub(super) struct Cells(pub(super) Vec<u32>);

impl Accumulate for Cells {
    fn add(&mut self, index: u32, value: u32) {
        self.0[index as usize] = self.0[index as usize].wrapping_add(value);
    }
    fn or(&mut self, index: u32, value: u32) {
        self.0[index as usize] |= value;
    }
    fn min(&mut self, index: u32, value: u32) {
        self.0[index as usize] = self.0[index as usize].min(value);
    }
    fn max(&mut self, index: u32, value: u32) {
        self.0[index as usize] = self.0[index as usize].max(value);
    }
}

/// A coarse picture's way to its lists, on the host.
struct Coarse {
    p: Proxied,
    gloss: Vec<Vec4>,
    march: MarchParams,
    voxels: Vec<u32>,
    coverage: Vec<f32>,
    list: ListParams,
    sorted: Vec<u32>,
    counted: Vec<u32>,
    lists: Vec<u32>,
    headers: Vec<ListHeader>,
}

impl Coarse {
    fn new(draw: &mut Draw, p: Proxied, flags: u32, capacity: u32) -> Self {
        let surfaces = &p.world.surfaces;
        let gloss = p.world.gloss();
        let march = MarchParams {
            lower: p.grid.lower,
            cell_inverse_size: p.cells.inverse_size,
            cell_dims: p.cells.dims,
            voxel_inverse_size: p.grid.inverse_size,
            voxel_dims: p.grid.dims,
            eye: p.world.camera.eye,
            diffuse_rays: DIFFUSE_RAYS,
            lobe_rays: LOBE_RAYS,
            seed: draw.word(),
            flags,
            cells_per_length: 3.0,
            ..Default::default()
        };
        let one = |i| passes::march_rays(i, &march, surfaces, &gloss, &p.pair_starts, &p.pairs, &p.proxies);
        let voxels: Vec<u32> = (0..COARSE * RAYS).map(one).collect();
        let met = voxels.iter().filter(|&&v| v != u32::MAX).count();
        assert!(met > voxels.len() / 12 && met < voxels.len(), "{met} rays of {} meet proxies", voxels.len());
        let one = |i| passes::lobe_coverage(i, &march, surfaces, &gloss, &voxels);
        let coverage: Vec<f32> = (0..COARSE).map(one).collect();
        let list = ListParams {
            width: WIDTH,
            height: ROWS,
            diffuse_rays: DIFFUSE_RAYS,
            lobe_rays: LOBE_RAYS,
            half_width: 3,
            half_height: 2,
            capacity,
            max_depth_difference: 0.05,
            min_normal_cosine: 0.8,
            occupied: 60,
            ..Default::default()
        };
        let mut sorted = Cells(vec![0; (COARSE * RAYS) as usize]);
        (0..COARSE * RAYS).for_each(|i| passes::sort_rays(i, &list, &voxels, &mut sorted));
        let mut counted = Cells(vec![0; (COARSE * (RAYS + 1)) as usize]);
        (0..COARSE).for_each(|i| passes::count_rays(i, &list, &sorted.0, &mut counted));
        let mut lists = Cells(vec![0; (COARSE * list_stride(capacity)) as usize]);
        (0..COARSE).for_each(|i| passes::filter_lists(i, &list, surfaces, &counted.0, &mut lists));
        let one = |i| passes::list_headers(i, &list, surfaces, &coverage);
        let headers = (0..COARSE).map(one).collect();
        let (sorted, counted, lists) = (sorted.0, counted.0, lists.0);
        Self { gloss, march, voxels, coverage, list, sorted, counted, lists, headers, p }
    }

    /// Directions by pixel and roomy lists; directions by place and lists that are too small.
    fn all(draw: &mut Draw) -> [Self; 2] {
        let [a, b] = Proxied::all(draw);
        let all = [Self::new(draw, a, 0, 60), Self::new(draw, b, WORLD_ANCHORED, 7)];
        let dropped =
            |c: &Self| c.lists.chunks_exact(list_stride(c.list.capacity) as usize).map(|l| l[2]).sum::<u32>();
        assert!(dropped(&all[0]) == 0 && dropped(&all[1]) > 0, "lists are not both roomy and tight");
        all
    }

    fn rays(&self) -> Launch {
        Launch::new(format!("flags {}", self.march.flags), (COARSE * RAYS) as usize, COARSE * RAYS)
    }

    fn pixels(&self) -> Launch {
        Launch::new(format!("lists of {}", self.list.capacity), COARSE as usize, COARSE)
    }
}

pub fn march_rays(draw: &mut Draw) -> Vec<case::march_rays> {
    Coarse::all(draw)
        .map(|c| case::march_rays {
            launch: c.rays(),
            params: c.march,
            surfaces: c.p.world.surfaces,
            gloss: c.gloss,
            starts: c.p.pair_starts,
            pairs: c.p.pairs,
            proxies: c.p.proxies,
        })
        .into()
}

pub fn trace_rays(draw: &mut Draw) -> Vec<case::trace_rays> {
    Coarse::all(draw)
        .map(|c| case::trace_rays {
            launch: c.rays(),
            params: c.march,
            surfaces: c.p.world.surfaces,
            gloss: c.gloss,
            nodes: c.p.world.nodes,
            blocks: c.p.world.blocks,
            triangles: c.p.world.triangles,
            materials: c.p.world.materials,
            texels: c.p.world.texels,
        })
        .into()
}

pub fn lobe_coverage(draw: &mut Draw) -> Vec<case::lobe_coverage> {
    Coarse::all(draw)
        .map(|c| case::lobe_coverage {
            launch: c.pixels(),
            params: c.march,
            surfaces: c.p.world.surfaces,
            gloss: c.gloss,
            voxels: c.voxels,
        })
        .into()
}

pub fn sort_rays(draw: &mut Draw) -> Vec<case::sort_rays> {
    Coarse::all(draw).map(|c| case::sort_rays { launch: c.rays(), params: c.list, voxels: c.voxels }).into()
}

pub fn count_rays(draw: &mut Draw) -> Vec<case::count_rays> {
    Coarse::all(draw)
        .map(|c| case::count_rays {
            launch: Launch::new("all rays", (COARSE * (RAYS + 1)) as usize, COARSE),
            params: c.list,
            sorted: c.sorted,
        })
        .into()
}

pub fn filter_lists(draw: &mut Draw) -> Vec<case::filter_lists> {
    Coarse::all(draw)
        .map(|c| case::filter_lists {
            launch: Launch::new(
                format!("lists of {}", c.list.capacity),
                (COARSE * list_stride(c.list.capacity)) as usize,
                COARSE,
            ),
            params: c.list,
            surfaces: c.p.world.surfaces,
            counted: c.counted,
        })
        .into()
}

pub fn list_headers(draw: &mut Draw) -> Vec<case::list_headers> {
    Coarse::all(draw)
        .map(|c| case::list_headers {
            launch: c.pixels(),
            params: c.list,
            surfaces: c.p.world.surfaces,
            coverage: c.coverage,
        })
        .into()
}

/// Pixels that read the coarse ones with an offset, as if the picture were 1.7 times as wide.
fn gather_params(c: &Coarse, flags: u32, clamp: u32, specular_deviation: f32) -> GatherVoxelsParams {
    GatherVoxelsParams {
        eye: c.p.world.camera.eye,
        width: WIDTH,
        first_pixel: FIRST,
        coarse_width: WIDTH,
        coarse_height: ROWS,
        scale_x: 0.9,
        scale_y: 1.1,
        near_range: 1.5,
        trust: 2.0,
        disc_radius: 0.35,
        // With and without lobes.
        lights: if clamp == CLAMP_NONE || specular_deviation > 0.0 { 0 } else { c.p.grid.lights },
        sides: c.p.lobes.sides,
        depth_deviation: 0.02,
        normal_deviation: 0.1,
        specular_deviation,
        capacity: c.list.capacity,
        flags,
        clamp,
        ..Default::default()
    }
}

pub fn gather_diffuse(draw: &mut Draw) -> Vec<case::gather_diffuse> {
    let mut cases = Vec::new();
    for c in Coarse::all(draw) {
        for (flags, clamp) in [(GATHER_SHARE, CLAMP_DISC), (0, CLAMP_RADIUS), (0, CLAMP_NONE)] {
            cases.push(case::gather_diffuse {
                launch: launch(&format!("flags {flags}, clamp {clamp}")),
                params: gather_params(&c, flags, clamp, 0.0),
                surfaces: c.p.world.surfaces.clone(),
                headers: c.headers.clone(),
                lists: c.lists.clone(),
                voxels: c.p.voxels(),
                proxies: c.p.proxies.clone(),
                radiance: c.p.radiance.clone(),
            });
        }
    }
    cases
}

pub fn gather_specular(draw: &mut Draw) -> Vec<case::gather_specular> {
    let mut cases = Vec::new();
    for c in Coarse::all(draw) {
        for (deviation, specular_exponent) in [(0.0, 0.0), (0.2, 0.0), (0.2, 12.0)] {
            let params = gather_params(&c, 0, CLAMP_DISC, deviation);
            cases.push(case::gather_specular {
                launch: launch(&format!("deviation {deviation}, exponent {specular_exponent}")),
                params: GatherVoxelsParams { specular_exponent, ..params },
                surfaces: c.p.world.surfaces.clone(),
                gloss: c.gloss.clone(),
                headers: c.headers.clone(),
                lists: c.lists.clone(),
                voxels: c.p.voxels(),
                proxies: c.p.proxies.clone(),
                radiance: c.p.radiance.clone(),
            });
        }
    }
    cases
}

pub fn upsample(draw: &mut Draw) -> Vec<case::upsample> {
    let [fine, coarse] = worlds(draw);
    let params = UpsampleParams {
        width: WIDTH,
        first_pixel: FIRST,
        coarse_width: WIDTH,
        coarse_height: ROWS,
        scale_x: 0.9,
        scale_y: 1.1,
        ..Default::default()
    };
    let filters = [("by depth and normal", BILATERAL), ("by place", BILINEAR), ("from the nearest", NEAREST)];
    let of = |(name, filter): (&str, u32)| case::upsample {
        launch: launch(&format!("a band of pixels {name}")),
        params: UpsampleParams { filter, ..params },
        surfaces: fine.surfaces.clone(),
        coarse_surfaces: coarse.surfaces.clone(),
        values: previous(draw),
    };
    filters.map(of).into()
}

pub fn filter_interleaved(draw: &mut Draw) -> Vec<case::filter_interleaved> {
    let [near, _] = worlds(draw);
    // Half of the pixels lie on a plane of their own: their neighbours count.
    let mut surfaces = near.surfaces;
    let count = surfaces.len() as u32;
    for i in 0..count {
        if i % WIDTH > WIDTH / 2 {
            let s = &mut surfaces[i as usize];
            s.position = Vec4::new((i % WIDTH) as f32, (i / WIDTH) as f32, 2.0, s.position.w);
            s.normal = Vec4::new(0.0, 0.0, 1.0, s.normal.w);
            s.triangle = i;
        }
    }
    let params = InterleavedParams { columns: WIDTH, rows: count / WIDTH, ..Default::default() };
    vec![case::filter_interleaved {
        launch: launch("planes and others"),
        params,
        surfaces,
        values: previous(draw),
    }]
}
