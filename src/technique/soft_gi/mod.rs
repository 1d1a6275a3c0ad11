//! How do spherical proxies shadow and light surfaces under soft surroundings? Sloan et al. 2007 (SGI).
//!
//! Proxies alone shadow the light of the surroundings and reflect it; surfaces receive both. Point, spot and sun lights and
//! emissive surfaces shine as in direct light, shadowed by triangles.

mod settings;
mod surroundings;
mod table;

pub use settings::{Exponential, MAX_RECEIVERS, Operator, SoftGi};
pub use surroundings::Surroundings;
pub use table::{ENTRIES, exact_operator_table, log_occlusion_table, optimal_linear_table};
pub(crate) use table::{gauss_legendre, logarithm};

use super::gathered::{Gathered, picture};
use super::gbuffer::GBuffer;
use super::{Inspection, Job, LightPart, Rendered, View, World, direct};
use crate::backend::{Backend, BackendError};
use crate::error::SettingsError;
use crate::picture::Picture;
use crate::primitives::exclusive_scan;
use crate::scene::MAX_PROXIES;
use glam::{Vec3, Vec4};
use twinlight_kernels::passes::elements::{ShVector, SoftParams, SphereProxy};
use twinlight_kernels::passes::soft_gi;
use twinlight_kernels::sh::{SMALL_NORM, UNIT};

/// Buffers that [`Job::dumps`] may name.
pub const DUMPS: [&str; 13] = [
    "albedo",
    "normal",
    "depth",
    "position",
    "gloss",
    "emission",
    "visibility",
    "log-occlusion",
    "occlusion",
    "shadowed",
    "indirect",
    "xi",
    "proxies-per-tile",
];

/// Receivers along a side of a tile.
const TILE: u32 = 8;

/// How much there is to do.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// Number of proxies.
    pub proxies: u32,
    /// Pairs of receivers and proxies that their tiles list.
    pub pairs: u64,
    /// Number of receivers.
    pub receivers: u32,
    /// η of shadows.
    pub shadow_reach: f32,
}

/// Proxies by tile.
struct Tiles<B: Backend> {
    counts: B::Buffer<u32>,
    starts: B::Buffer<u32>,
    lists: B::Buffer<u32>,
}

/// Renders direct light, and what the surroundings give past proxies and by way of them.
///
/// # Errors
/// Knobs out of range, and what the backend reports.
pub fn render<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    surroundings: &Surroundings,
    view: &View,
    job: &Job,
    settings: &SoftGi,
) -> Result<(Rendered, Counts), BackendError> {
    settings.check(view.width, view.height)?;
    let proxies = surroundings.proxies.len();
    if proxies > MAX_PROXIES {
        let reason = format!("{proxies} proxies are over {MAX_PROXIES}");
        return Err(BackendError::Settings(SettingsError { knob: "proxies", reason }));
    }
    let mut seen = Inspection::new(job, view.width, view.height);
    // In the dark, or asked for what proxies alone would send, there is nothing to do without them.
    let (mut gathered, mut counts) = (None, Counts::default());
    if world.has_environment && (proxies > 0 || job.light != LightPart::Indirect) {
        let (light, counted) = gather(backend, world, surroundings, view, job, settings, &mut seen)?;
        (gathered, counts) = (Some(light), counted);
    }
    let picture = picture(backend, world, gathered.as_ref(), view, job, &mut seen, |backend, g, seen| {
        direct::band_radiance_without_surroundings(backend, world, g, job, seen)
    })?;
    let timings = backend.take_timings()?;
    backend.set_stage("");
    Ok((seen.finish(picture, timings), counts))
}

fn params(surroundings: &Surroundings, job: &Job, settings: &SoftGi, width: u32, height: u32) -> SoftParams {
    SoftParams {
        width,
        height,
        tile: TILE,
        tiles_x: width.div_ceil(TILE),
        proxies: surroundings.proxies.len() as u32,
        order: settings.order,
        exponential: match settings.exponential {
            Exponential::Hybrid => soft_gi::HYBRID,
            Exponential::OptimalLinear => soft_gi::OPTIMAL_LINEAR,
            Exponential::Series => soft_gi::SERIES,
            Exponential::Taylor => soft_gi::TAYLOR,
            Exponential::Product => soft_gi::PRODUCT,
        },
        terms: settings.terms,
        tau: settings.tau,
        shadow_reach: surroundings.shadow_reach(settings),
        light_reach: settings.light_reach,
        operator: match settings.operator {
            Operator::Point => soft_gi::POINT,
            Operator::AveragedFit => soft_gi::AVERAGED_FIT,
            Operator::Averaged => soft_gi::AVERAGED,
            Operator::Exact => soft_gi::EXACT,
        },
        entries: settings.entries,
        fade: settings.fade,
        parts: match job.light {
            LightPart::All if surroundings.proxies.is_empty() => soft_gi::SHADOWED,
            LightPart::All => soft_gi::SHADOWED | soft_gi::REFLECTED,
            LightPart::Direct => soft_gi::SHADOWED,
            LightPart::Indirect => soft_gi::REFLECTED,
        },
        ..Default::default()
    }
}

/// Which proxies reach which tiles.
fn cull<B: Backend>(
    backend: &mut B,
    params: &SoftParams,
    g: &GBuffer<B>,
    proxies: &B::Buffer<SphereProxy>,
) -> Result<Tiles<B>, BackendError> {
    let tiles = params.tiles_x * params.height.div_ceil(TILE);
    let mut bounds = backend.alloc("tile bounds", 2 * tiles as usize)?;
    backend.tile_bounds(params, &g.surfaces, &mut bounds, 2 * tiles)?;
    let mut counts = backend.alloc("tile counts", tiles as usize)?;
    backend.tile_counts(params, &bounds, proxies, &mut counts, tiles)?;
    let starts = exclusive_scan(backend, &counts, tiles)?;
    let total: u64 = backend.download(&counts)?.iter().map(|&c| u64::from(c)).sum();
    if total > MAX_PAIRS {
        return Err(BackendError::Settings(SettingsError {
            knob: "shadow-reach",
            reason: format!(
                "{total} proxies in all tiles together are over {MAX_PAIRS}; lower it and --light-reach"
            ),
        }));
    }
    let mut lists = backend.alloc("tile lists", (total as usize).max(1))?;
    backend.tile_lists(params, &bounds, proxies, &starts, &mut lists, tiles)?;
    Ok(Tiles { counts, starts, lists })
}

/// The most proxies in all tiles together.
const MAX_PAIRS: u64 = 1 << 26;

/// Light at the receivers.
fn gather<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    surroundings: &Surroundings,
    view: &View,
    job: &Job,
    settings: &SoftGi,
    seen: &mut Inspection<'_>,
) -> Result<(Gathered<B>, Counts), BackendError> {
    backend.set_stage("receivers");
    let (width, height) = settings.receivers(view.width, view.height);
    let coarse = view.resized(width, height);
    let count = coarse.pixels();
    let g = seen.without_dumps(|seen| GBuffer::trace(backend, world, &coarse, 0..count, seen))?;
    let mut params = params(surroundings, job, settings, width, height);
    let none = [SphereProxy::default()];
    let proxies = if surroundings.proxies.is_empty() { &none[..] } else { &surroundings.proxies };
    let proxies = backend.upload("proxies", proxies)?;
    backend.set_stage("culling");
    let tiles = cull(backend, &params, &g, &proxies)?;
    let on_host = backend.read_result(&tiles.counts)?;
    let pairs = listed_pairs(&params, &on_host);
    let keep = |seen: &mut Inspection<'_>, name: &str, pixels: &dyn Fn(usize) -> Vec3| {
        seen.keep(name, || Picture { width, height, pixels: (0..count as usize).map(pixels).collect() });
    };
    keep(seen, "proxies-per-tile", &|i| {
        let (x, y) = (i as u32 % width / TILE, i as u32 / width / TILE);
        Vec3::splat(on_host[(y * params.tiles_x + x) as usize] as f32 / params.proxies.max(1) as f32)
    });
    let occlusion = occlusion(backend, &mut params, &g, &proxies, &tiles, &keep, seen)?;
    backend.set_stage("shading");
    let light = backend.upload("light", &surroundings.light())?;
    let mut shadowed = backend.alloc("shadowed light", count as usize)?;
    backend.shade_shadowed(&params, &g.surfaces, &occlusion, &light, &mut shadowed, count)?;
    seen.check(backend, "shadowed light", &shadowed)?;
    if seen.wants("shadowed") {
        let past = backend.read_result(&shadowed)?;
        keep(seen, "shadowed", &|i| past[i].truncate());
    }
    let mut diffuse = shadowed;
    if params.parts & soft_gi::REFLECTED != 0 {
        backend.set_stage("indirect");
        let reflected = reflected(backend, surroundings, &mut params, &g, &proxies, &tiles, settings, seen)?;
        let mut both = backend.alloc("diffuse light", count as usize)?;
        backend.combine_soft(&params, &diffuse, &reflected, &mut both, count)?;
        if seen.wants("indirect") || seen.wants("xi") {
            let past = backend.read_result(&diffuse)?;
            let sent: Vec<Vec4> = backend.read_result(&reflected)?;
            let share = |i: usize| soft_gi::shade::overlap_share(past[i].w, sent[i].w);
            keep(seen, "indirect", &|i| sent[i].truncate().max(Vec3::ZERO) * share(i) / std::f32::consts::PI);
            keep(seen, "xi", &|i| Vec3::splat(share(i)));
        }
        diffuse = both;
    }
    let counts =
        Counts { proxies: params.proxies, pairs, receivers: count, shadow_reach: params.shadow_reach };
    let gathered = Gathered { width, height, seen: g, diffuse, specular: None };
    Ok((gathered, counts))
}

/// What proxies reflect to each receiver.
fn reflected<B: Backend>(
    backend: &mut B,
    surroundings: &Surroundings,
    params: &mut SoftParams,
    g: &GBuffer<B>,
    proxies: &B::Buffer<SphereProxy>,
    tiles: &Tiles<B>,
    settings: &SoftGi,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<Vec4>, BackendError> {
    let count = g.count();
    let irradiance = backend.upload("irradiance", &surroundings.irradiance())?;
    let exact = settings.operator == Operator::Exact;
    let table = if exact { exact_operator_table(ENTRIES as usize) } else { vec![0.0] };
    params.operator_entries = if exact { ENTRIES } else { 0 };
    let table = backend.upload("exact operator", &table)?;
    let mut reflected = backend.alloc("reflected light", count as usize)?;
    backend.accumulate_indirect(
        params,
        &g.surfaces,
        proxies,
        &tiles.starts,
        &tiles.counts,
        &tiles.lists,
        &irradiance,
        &table,
        &mut reflected,
        count,
    )?;
    seen.check(backend, "reflected light", &reflected)?;
    Ok(reflected)
}

/// Pairs of receivers and the proxies of their tiles.
fn listed_pairs(params: &SoftParams, counts: &[u32]) -> u64 {
    let side = |at: u32, all: u32| u64::from((all - at * TILE).min(TILE));
    counts
        .iter()
        .enumerate()
        .map(|(tile, &count)| {
            let (x, y) = (tile as u32 % params.tiles_x, tile as u32 / params.tiles_x);
            u64::from(count) * side(x, params.width) * side(y, params.height)
        })
        .sum()
}

/// Keeps a picture of the receivers, if it was asked for.
type Keep<'a> = dyn Fn(&mut Inspection<'_>, &str, &dyn Fn(usize) -> Vec3) + 'a;

/// What proxies leave of the surroundings at each receiver.
fn occlusion<B: Backend>(
    backend: &mut B,
    params: &mut SoftParams,
    g: &GBuffer<B>,
    proxies: &B::Buffer<SphereProxy>,
    tiles: &Tiles<B>,
    keep: &Keep<'_>,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<ShVector>, BackendError> {
    backend.set_stage("occlusion");
    let count = g.count();
    let mut occlusion = backend.alloc("occlusion", count as usize)?;
    let Tiles { starts, counts, lists } = tiles;
    if params.exponential == soft_gi::PRODUCT {
        backend.multiply_visibility(
            params,
            &g.surfaces,
            proxies,
            starts,
            counts,
            lists,
            &mut occlusion,
            count,
        )?;
    } else {
        let logarithms = logarithms(backend, params, g, proxies, tiles, keep, seen)?;
        backend.set_stage("exponential");
        let table = backend.upload("linear exponential's table", &linear_table(params))?;
        match params.order {
            2 => backend.exponentiate2(params, &logarithms, &table, &mut occlusion, count)?,
            3 => backend.exponentiate3(params, &logarithms, &table, &mut occlusion, count)?,
            4 => backend.exponentiate4(params, &logarithms, &table, &mut occlusion, count)?,
            _ => backend.exponentiate5(params, &logarithms, &table, &mut occlusion, count)?,
        }
    }
    seen.check(backend, "occlusion", &occlusion)?;
    if seen.wants("occlusion") {
        let values: Vec<ShVector> = backend.read_result(&occlusion)?;
        keep(seen, "occlusion", &|i| Vec3::splat(values[i].c0.x / UNIT));
    }
    Ok(occlusion)
}

/// The sum of the logarithms of what each proxy leaves.
fn logarithms<B: Backend>(
    backend: &mut B,
    params: &SoftParams,
    g: &GBuffer<B>,
    proxies: &B::Buffer<SphereProxy>,
    tiles: &Tiles<B>,
    keep: &Keep<'_>,
    seen: &mut Inspection<'_>,
) -> Result<B::Buffer<ShVector>, BackendError> {
    let table = log_occlusion_table(params.order as usize, params.entries as usize);
    let table = backend.upload("logarithms' table", &table)?;
    let count = g.count();
    let mut logarithms = backend.alloc("log occlusion", count as usize)?;
    let Tiles { starts, counts, lists } = tiles;
    backend.accumulate_occlusion(
        params,
        &g.surfaces,
        proxies,
        starts,
        counts,
        lists,
        &table,
        &mut logarithms,
        count,
    )?;
    seen.check(backend, "log occlusion", &logarithms)?;
    if seen.wants("log-occlusion") {
        let values: Vec<ShVector> = backend.read_result(&logarithms)?;
        keep(seen, "log-occlusion", &|i| Vec3::splat(-values[i].c0.x / UNIT));
    }
    Ok(logarithms)
}

/// The table of the linear exponential, where norms reach beyond what has polynomials; tells `params` how long it is.
fn linear_table(params: &mut SoftParams) -> Vec<f32> {
    let beyond = params.exponential == soft_gi::HYBRID && params.tau > SMALL_NORM;
    if !beyond && params.exponential != soft_gi::OPTIMAL_LINEAR {
        params.pairs = 0;
        return vec![0.0];
    }
    let table = optimal_linear_table(params.order as usize);
    params.pairs = table.len() as u32 / 2;
    table
}
