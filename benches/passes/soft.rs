//! On which inputs are the passes of soft global illumination timed? The scene's forty spheres, a receiver for each pixel.

use super::{COUNT, Case, SIDE, Samples, copy, exclusive_scan, map, vectors};
use glam::Vec4;
use twinlight::backend::{Backend, Cpu};
use twinlight::scene::Scene;
use twinlight::technique::soft_gi::{
    ENTRIES, Surroundings, exact_operator_table, log_occlusion_table, optimal_linear_table,
};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::soft_gi::AVERAGED;

/// The proxies, and which tiles they reach.
pub struct Soft {
    params: SoftParams,
    surroundings: Surroundings,
    bounds: Vec<Vec4>,
    counts: Vec<u32>,
}

impl Soft {
    /// Culls the scene's proxies.
    pub fn new(
        cpu: &mut Cpu,
        scene: &Scene,
        surfaces: &<Cpu as Backend>::Buffer<Surface>,
    ) -> Result<Self, Box<dyn std::error::Error>> {
        let surroundings = Surroundings::new(scene);
        let tiles = SIDE.div_ceil(8);
        let params = SoftParams {
            width: SIDE,
            height: SIDE,
            tile: 8,
            tiles_x: tiles,
            proxies: surroundings.proxies.len() as u32,
            order: 4,
            terms: 9,
            tau: 0.5,
            shadow_reach: 15.0,
            light_reach: 10.0,
            operator: AVERAGED,
            entries: ENTRIES,
            operator_entries: ENTRIES,
            parts: 3,
            fade: 0.5,
            ..Default::default()
        };
        let all = tiles * tiles;
        let mut bounds = cpu.alloc("bounds", 2 * all as usize)?;
        cpu.tile_bounds(&params, surfaces, &mut bounds, 2 * all)?;
        let proxies = cpu.upload("proxies", &surroundings.proxies)?;
        let mut counts = cpu.alloc("counts", all as usize)?;
        cpu.tile_counts(&params, &bounds, &proxies, &mut counts, all)?;
        Ok(Self { params, bounds: copy(&bounds), counts: copy(&counts), surroundings })
    }

    fn tiles(&self) -> u32 {
        self.counts.len() as u32
    }

    fn total(&self) -> u32 {
        self.counts.iter().sum()
    }

    /// The numbers of the proxies of each tile; which ones does not matter for the time.
    fn lists(&self) -> Vec<u32> {
        self.counts.iter().flat_map(|&count| 0..count).collect()
    }

    fn vectors(&self) -> Vec<ShVector> {
        let small = |v: Vec4| v * 0.3 - Vec4::splat(0.3);
        let v = vectors(7 * COUNT);
        let of = |c: &[Vec4]| ShVector {
            c0: small(c[0]),
            c4: small(c[1]),
            c8: small(c[2]),
            c12: small(c[3]),
            c16: small(c[4]),
            c20: small(c[5]),
            c24: Vec4::new(small(c[6]).x, 0.0, 0.0, 0.0),
        };
        v.chunks_exact(7).map(of).collect()
    }
}

pub fn tile_bounds(s: &Samples) -> Case<SoftParams, (Vec<Surface>,)> {
    map(s.soft.params, (copy(&s.surfaces),), 2 * s.soft.tiles())
}

pub fn tile_counts(s: &Samples) -> Case<SoftParams, (Vec<Vec4>, Vec<SphereProxy>)> {
    map(s.soft.params, (s.soft.bounds.clone(), s.soft.surroundings.proxies.clone()), s.soft.tiles())
}

pub fn tile_lists(s: &Samples) -> Case<SoftParams, (Vec<Vec4>, Vec<SphereProxy>, Vec<u32>)> {
    let soft = &s.soft;
    let starts = exclusive_scan(&soft.counts);
    let inputs = (soft.bounds.clone(), soft.surroundings.proxies.clone(), starts);
    Case { params: soft.params, inputs, outputs: soft.total(), items: soft.tiles() }
}

type Occlusion = (Vec<Surface>, Vec<SphereProxy>, Vec<u32>, Vec<u32>, Vec<u32>, Vec<f32>);

pub fn accumulate_occlusion(s: &Samples) -> Case<SoftParams, Occlusion> {
    let soft = &s.soft;
    let (proxies, starts) = (soft.surroundings.proxies.clone(), exclusive_scan(&soft.counts));
    let table = log_occlusion_table(4, ENTRIES as usize);
    let inputs = (copy(&s.surfaces), proxies, starts, soft.counts.clone(), soft.lists(), table);
    map(soft.params, inputs, COUNT)
}

type Factors = (Vec<Surface>, Vec<SphereProxy>, Vec<u32>, Vec<u32>, Vec<u32>);

pub fn multiply_visibility(s: &Samples) -> Case<SoftParams, Factors> {
    let Case { params, inputs, .. } = accumulate_occlusion(s);
    let (surfaces, proxies, starts, counts, lists, _) = inputs;
    map(params, (surfaces, proxies, starts, counts, lists), COUNT)
}

macro_rules! exponentials {
    ($($name:ident, $order:literal;)*) => {$(
        pub fn $name(s: &Samples) -> Case<SoftParams, (Vec<ShVector>, Vec<f32>)> {
            let params = SoftParams { order: $order, ..s.soft.params };
            map(params, (s.soft.vectors(), optimal_linear_table($order)), COUNT)
        }
    )*};
}

exponentials! {
    exponentiate2, 2;
    exponentiate3, 3;
    exponentiate4, 4;
    exponentiate5, 5;
}

pub fn shade_shadowed(s: &Samples) -> Case<SoftParams, (Vec<Surface>, Vec<ShVector>, Vec<ShVector>)> {
    let vectors = s.soft.vectors();
    let light = vectors[..3].to_vec();
    map(s.soft.params, (copy(&s.surfaces), vectors, light), COUNT)
}

type Indirect = (Vec<Surface>, Vec<SphereProxy>, Vec<u32>, Vec<u32>, Vec<u32>, Vec<ShVector>, Vec<f32>);

pub fn accumulate_indirect(s: &Samples) -> Case<SoftParams, Indirect> {
    let Case { params, inputs, .. } = accumulate_occlusion(s);
    let (surfaces, proxies, starts, counts, lists, _) = inputs;
    let light = s.soft.vectors()[..3].to_vec();
    let table = exact_operator_table(ENTRIES as usize);
    map(params, (surfaces, proxies, starts, counts, lists, light, table), COUNT)
}

pub fn combine_soft(s: &Samples) -> Case<SoftParams, (Vec<Vec4>, Vec<Vec4>)> {
    map(s.soft.params, (vectors(COUNT), vectors(COUNT)), COUNT)
}
