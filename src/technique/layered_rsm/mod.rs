//! What do surfaces send to each other, by cones through binary voxels and layered maps of what each light sees?
//! Sugihara, Rauwendaal, Salvi 2014 (LRSM).
//!
//! [`BinaryVoxels`] say where something is, [`LayeredMaps`] what surfaces send; both are cheap enough to be rebuilt
//! for every picture, and may outlive one.

mod frame;
mod maps;
mod settings;
mod voxels;

pub(super) use frame::cone_params;
pub use maps::{LayeredMaps, ReflectiveMap, layered_map, reflect_params, reflective_map};
pub use settings::{LayeredRsm, Moments, Opacity, Weights};
pub use voxels::BinaryVoxels;

use super::gathered::picture;
use super::{Inspection, Job, LightPart, Rendered, View, World, direct};
use crate::backend::{Backend, BackendError};
use std::f32::consts::PI;

/// Buffers that [`Job::dumps`] may name; maps and layers are those of the first light.
pub const DUMPS: [&str; 14] = [
    "albedo",
    "normal",
    "depth",
    "position",
    "gloss",
    "emission",
    "visibility",
    "diffuse",
    "specular",
    "indirect",
    "ao",
    "rsm",
    "layers",
    "shadow",
];

/// How large the structures are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Voxels along each side.
    pub resolution: u32,
    /// Bytes of the voxels with their levels.
    pub voxel_bytes: u64,
    /// Number of lights with layered maps.
    pub lights: u32,
    /// Lights that are gathered together.
    pub lights_at_once: u32,
    /// Bytes of a light's map before it is split; it does not stay.
    pub map_bytes: u64,
    /// Bytes of all lights' layers.
    pub layer_bytes: u64,
}

impl Counts {
    pub(crate) fn of<B: Backend>(voxels: &BinaryVoxels<B>, maps: &Maps<B>, settings: &LayeredRsm) -> Self {
        Self {
            resolution: settings.resolution,
            voxel_bytes: voxels.bytes(),
            lights: maps.groups.iter().map(|g| g.host.len() as u32).sum(),
            lights_at_once: settings.lights_at_once(),
            map_bytes: 16 * u64::from(settings.map) * u64::from(settings.map),
            layer_bytes: maps.groups.iter().map(LayeredMaps::bytes).sum(),
        }
    }
}

/// What surfaces send in the light of all lights: layered maps, in groups that are gathered together.
pub struct Maps<B: Backend> {
    /// The groups, in the order of lights.
    pub groups: Vec<LayeredMaps<B>>,
    /// Units of stored radiance per W/(m² sr).
    pub radiance_scale: f32,
}

impl<B: Backend> Maps<B> {
    /// Makes the maps of all lights.
    pub fn build(backend: &mut B, world: &World<B>, settings: &LayeredRsm) -> Result<Self, BackendError> {
        let radiance_scale = radiance_scale(world);
        let at_once = settings.lights_at_once();
        let mut groups = Vec::new();
        for first in (0..world.light_count).step_by(at_once as usize) {
            let lights = first..world.light_count.min(first + at_once);
            groups.push(LayeredMaps::build(backend, world, settings, lights, radiance_scale)?);
        }
        if groups.is_empty() && (world.has_mirrors && world.has_environment) {
            // Mirrors show the environment.
            groups.push(LayeredMaps::build(backend, world, settings, 0..0, radiance_scale)?);
        }
        Ok(Self { groups, radiance_scale })
    }
}

/// Units of stored radiance: the whole power of the lights over all surfaces, or what a sun makes of them, is about one.
fn radiance_scale<B: Backend>(world: &World<B>) -> f32 {
    let (of_lights, _) = super::voxel_cones::watts(world);
    let typical = of_lights / (PI * world.area.max(1.0e-30) as f32);
    if typical > 0.0 && typical.is_finite() { 1.0 / typical } else { 1.0 }
}

/// Renders direct light and one bounce.
///
/// # Errors
/// Knobs out of range, and what the backend reports.
pub fn render<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    view: &View,
    job: &Job,
    settings: &LayeredRsm,
) -> Result<(Rendered, Counts), BackendError> {
    settings.check(view.width, view.height)?;
    // Without lights there is nothing to gather or to throw shadows; mirrors may show the environment between voxels.
    let lit = world.light_count > 0;
    let gathers = job.light != LightPart::Direct && (lit || world.has_mirrors && world.has_environment);
    let shadows = settings.shadow_cones && lit && job.light != LightPart::Indirect;
    if !gathers && !shadows {
        let mut seen = Inspection::new(job, view.width, view.height);
        let picture = picture(backend, world, None, view, job, &mut seen, |backend, g, seen| {
            direct::band_radiance(backend, world, g, job, seen)
        })?;
        let timings = backend.take_timings()?;
        backend.set_stage("");
        return Ok((seen.finish(picture, timings), Counts::default()));
    }
    backend.set_stage("voxelisation");
    let voxels = BinaryVoxels::build(backend, world, settings)?;
    backend.set_stage("maps");
    let maps = if gathers {
        Maps::build(backend, world, settings)?
    } else {
        Maps { groups: Vec::new(), radiance_scale: 1.0 }
    };
    let counts = Counts::of(&voxels, &maps, settings);
    Ok((render_lit(backend, world, &voxels, &maps, view, job, settings)?, counts))
}

/// Renders with voxels and maps of an earlier picture: nothing is voxelised, no map is made.
///
/// # Errors
/// Knobs out of range, and what the backend reports.
pub fn render_lit<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    voxels: &BinaryVoxels<B>,
    maps: &Maps<B>,
    view: &View,
    job: &Job,
    settings: &LayeredRsm,
) -> Result<Rendered, BackendError> {
    settings.check(view.width, view.height)?;
    let mut seen = Inspection::new(job, view.width, view.height);
    let (groups, scale) = (&maps.groups, maps.radiance_scale);
    frame::draw_maps(backend, world, groups, settings, scale, &mut seen)?;
    let gathered = if groups.is_empty() {
        None
    } else {
        Some(frame::gather(backend, world, voxels, groups, view, job, settings, scale, &mut seen)?)
    };
    let picture = picture(backend, world, gathered.as_ref(), view, job, &mut seen, |backend, g, seen| {
        if settings.shadow_cones {
            frame::soft_direct(backend, world, voxels, g, job, settings, seen)
        } else {
            direct::band_radiance(backend, world, g, job, seen)
        }
    })?;
    let timings = backend.take_timings()?;
    backend.set_stage("");
    Ok(seen.finish(picture, timings))
}
