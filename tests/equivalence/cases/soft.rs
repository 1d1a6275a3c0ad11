//! Inputs of the passes of soft global illumination: random spheres among the random scenes of `scene`.

use super::arrays::scanned;
use super::scene::{PIXELS, worlds};
use super::visibility::Cells;
use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::Vec4;
use twinlight::technique::soft_gi::{
    ENTRIES, exact_operator_table, log_occlusion_table, optimal_linear_table,
};
use twinlight_kernels::passes;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::soft_gi::{
    AVERAGED, AVERAGED_FIT, EXACT, HYBRID, OPTIMAL_LINEAR, POINT, PRODUCT, SERIES, TAYLOR,
};

/// Receivers in a row and rows: as many as the scenes' pixels.
const SIZE: (u32, u32) = (15, 33);

/// Receivers, proxies, and what the passes make of them on the host.
struct Soft {
    params: SoftParams,
    surfaces: Vec<Surface>,
    proxies: Vec<SphereProxy>,
    bounds: Vec<Vec4>,
    counts: Vec<u32>,
    starts: Vec<u32>,
    lists: Vec<u32>,
    table: Vec<f32>,
    logarithms: Vec<ShVector>,
    light: Vec<ShVector>,
}

fn items(label: &str, items: usize) -> Launch {
    Launch::new(label, items, items as u32)
}

fn vector(draw: &mut Draw) -> ShVector {
    let mut four = || draw.units() * 2.0 - Vec4::ONE;
    let (c0, c4, c8, c12, c16, c20) = (four().abs(), four(), four(), four(), four(), four());
    ShVector { c0, c4, c8, c12, c16, c20, c24: Vec4::new(four().x, 0.0, 0.0, 0.0) }
}

impl Soft {
    fn new(draw: &mut Draw, surfaces: Vec<Surface>, order: u32, exponential: u32, operator: u32) -> Self {
        assert_eq!(SIZE.0 * SIZE.1, PIXELS);
        let proxies: Vec<SphereProxy> = (0..24)
            .map(|i| {
                // Some hold a receiver, some cross its plane, some are small and far.
                let at = surfaces[draw.integer(0, PIXELS - 1) as usize].position.truncate();
                let radius = if i % 8 == 7 { 0.02 } else { draw.uniform(0.1, 0.6) };
                let sphere = (at + draw.point(0.8)).extend(radius);
                SphereProxy { sphere, albedo: draw.units() }
            })
            .collect();
        let params = SoftParams {
            width: SIZE.0,
            height: SIZE.1,
            tile: 8,
            tiles_x: SIZE.0.div_ceil(8),
            proxies: proxies.len() as u32,
            order,
            exponential,
            terms: 5,
            tau: 0.5,
            shadow_reach: 9.0,
            light_reach: 6.0,
            operator,
            entries: ENTRIES,
            operator_entries: ENTRIES,
            parts: 3,
            fade: 0.3,
            ..Default::default()
        };
        let tiles = params.tiles_x * SIZE.1.div_ceil(8);
        let bounds: Vec<Vec4> = (0..2 * tiles).map(|i| passes::tile_bounds(i, &params, &surfaces)).collect();
        let counts: Vec<u32> =
            (0..tiles).map(|i| passes::tile_counts(i, &params, &bounds, &proxies)).collect();
        let starts = scanned(&counts);
        let mut lists = Cells(vec![0; counts.iter().sum::<u32>() as usize]);
        (0..tiles).for_each(|i| passes::tile_lists(i, &params, &bounds, &proxies, &starts, &mut lists));
        assert!(lists.0.len() > 30 && counts.contains(&0) || counts.iter().any(|&c| c < 24));
        let table = log_occlusion_table(order as usize, ENTRIES as usize);
        let mut soft = Self {
            params,
            surfaces,
            proxies,
            bounds,
            counts,
            starts,
            lists: lists.0,
            table,
            logarithms: vec![],
            light: (0..3).map(|_| vector(draw)).collect(),
        };
        let s = &soft;
        let one = |i| {
            passes::accumulate_occlusion(
                i,
                &s.params,
                &s.surfaces,
                &s.proxies,
                &s.starts,
                &s.counts,
                &s.lists,
                &s.table,
            )
        };
        soft.logarithms = (0..PIXELS).map(one).collect();
        let dark = soft.logarithms.iter().filter(|f| f.c0.x < -0.1).count();
        assert!(dark > 40, "{dark} receivers are shadowed");
        soft
    }

    /// Every order, exponential and operator.
    fn all(draw: &mut Draw) -> Vec<Self> {
        let [a, b] = worlds(draw).map(|w| w.surfaces);
        [
            (&a, 2, HYBRID, POINT),
            (&b, 3, TAYLOR, AVERAGED_FIT),
            (&a, 4, HYBRID, AVERAGED),
            (&b, 5, SERIES, EXACT),
            (&b, 4, OPTIMAL_LINEAR, EXACT),
        ]
        .into_iter()
        .map(|(surfaces, order, exponential, operator)| {
            Self::new(draw, surfaces.clone(), order, exponential, operator)
        })
        .collect()
    }

    fn occlusion(&self) -> Vec<ShVector> {
        let p = SoftParams { exponential: HYBRID, ..self.params };
        (0..PIXELS)
            .map(|i| match p.order {
                2 => passes::exponentiate2(i, &p, &self.logarithms, &[]),
                3 => passes::exponentiate3(i, &p, &self.logarithms, &[]),
                4 => passes::exponentiate4(i, &p, &self.logarithms, &[]),
                _ => passes::exponentiate5(i, &p, &self.logarithms, &[]),
            })
            .collect()
    }

    fn label(&self) -> String {
        format!("order {}", self.params.order)
    }
}

pub fn tile_bounds(draw: &mut Draw) -> Vec<case::tile_bounds> {
    let of = |s: Soft| case::tile_bounds {
        launch: items("all tiles", s.bounds.len()),
        params: s.params,
        surfaces: s.surfaces,
    };
    Soft::all(draw).into_iter().take(2).map(of).collect()
}

pub fn tile_counts(draw: &mut Draw) -> Vec<case::tile_counts> {
    let of = |s: Soft| case::tile_counts {
        launch: items("all tiles", s.counts.len()),
        params: s.params,
        bounds: s.bounds,
        proxies: s.proxies,
    };
    Soft::all(draw).into_iter().take(2).map(of).collect()
}

pub fn tile_lists(draw: &mut Draw) -> Vec<case::tile_lists> {
    let of = |s: Soft| case::tile_lists {
        launch: Launch::new("all tiles", s.lists.len(), s.counts.len() as u32),
        params: s.params,
        bounds: s.bounds,
        proxies: s.proxies,
        starts: s.starts,
    };
    Soft::all(draw).into_iter().take(2).map(of).collect()
}

pub fn accumulate_occlusion(draw: &mut Draw) -> Vec<case::accumulate_occlusion> {
    let of = |s: Soft| case::accumulate_occlusion {
        launch: items(&s.label(), PIXELS as usize),
        params: s.params,
        surfaces: s.surfaces,
        proxies: s.proxies,
        starts: s.starts,
        counts: s.counts,
        lists: s.lists,
        table: s.table,
    };
    Soft::all(draw).into_iter().map(of).collect()
}

pub fn multiply_visibility(draw: &mut Draw) -> Vec<case::multiply_visibility> {
    let of = |s: Soft| case::multiply_visibility {
        launch: items(&s.label(), PIXELS as usize),
        params: SoftParams { exponential: PRODUCT, ..s.params },
        surfaces: s.surfaces,
        proxies: s.proxies,
        starts: s.starts,
        counts: s.counts,
        lists: s.lists,
    };
    Soft::all(draw).into_iter().take(4).map(of).collect()
}

macro_rules! exponentials {
    ($($name:ident, $order:literal;)*) => {$(
        pub fn $name(draw: &mut Draw) -> Vec<case::$name> {
            let [a, _] = worlds(draw).map(|w| w.surfaces);
            [(HYBRID, 0.5), (HYBRID, 1.0), (OPTIMAL_LINEAR, 0.5), (SERIES, 0.5), (TAYLOR, 0.5)]
                .into_iter()
                .map(|(exponential, tau)| {
                    let s = Soft::new(draw, a.clone(), $order, exponential, POINT);
                    let table = optimal_linear_table($order);
                    case::$name {
                        launch: items(&format!("exponential {exponential}, τ {tau}"), PIXELS as usize),
                        params: SoftParams { pairs: table.len() as u32 / 2, tau, ..s.params },
                        logarithms: s.logarithms,
                        table,
                    }
                })
                .collect()
        }
    )*};
}

exponentials! {
    exponentiate2, 2;
    exponentiate3, 3;
    exponentiate4, 4;
    exponentiate5, 5;
}

pub fn shade_shadowed(draw: &mut Draw) -> Vec<case::shade_shadowed> {
    let of = |s: Soft| case::shade_shadowed {
        launch: items(&s.label(), PIXELS as usize),
        params: s.params,
        occlusion: s.occlusion(),
        surfaces: s.surfaces,
        light: s.light,
    };
    Soft::all(draw).into_iter().map(of).collect()
}

pub fn accumulate_indirect(draw: &mut Draw) -> Vec<case::accumulate_indirect> {
    let of = |s: Soft| case::accumulate_indirect {
        launch: items(&format!("operator {}", s.params.operator), PIXELS as usize),
        params: s.params,
        surfaces: s.surfaces,
        proxies: s.proxies,
        starts: s.starts,
        counts: s.counts,
        lists: s.lists,
        light: s.light,
        table: exact_operator_table(ENTRIES as usize),
    };
    Soft::all(draw).into_iter().map(of).collect()
}

pub fn combine_soft(draw: &mut Draw) -> Vec<case::combine_soft> {
    let mut vectors = || -> Vec<Vec4> { (0..200).map(|_| draw.units()).collect() };
    let (shadowed, mut reflected) = (vectors(), vectors());
    reflected.iter_mut().step_by(9).for_each(|r| r.w = 0.0);
    [1, 2, 3]
        .into_iter()
        .map(|parts| case::combine_soft {
            launch: items(&format!("parts {parts}"), 200),
            params: SoftParams { parts, ..Default::default() },
            shadowed: shadowed.clone(),
            reflected: reflected.clone(),
        })
        .collect()
}
