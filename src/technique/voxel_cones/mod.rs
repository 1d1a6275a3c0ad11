//! What do surfaces send to each other, by cones through filtered voxels? Crassin et al. 2011 (VCT).
//!
//! A [`Pyramid`] stands for the scene, [`Lighting`] for what light makes of it; both outlive a picture.

mod drawn;
mod frame;
mod inject;
mod lit;
mod pyramid;
mod settings;

pub use drawn::{VOXEL_VIEWS, voxel_view};
pub(super) use frame::cone_params;
pub(super) use inject::watts;
pub use lit::{Lighting, Lit};
pub use pyramid::Pyramid;
pub(super) use settings::check_resolution;
pub use settings::{RadianceStorage, VoxelCones, Voxelisation};

use super::{Inspection, Job, LightPart, Rendered, View, World};
use crate::backend::{Backend, BackendError};
use crate::picture::Picture;

/// Buffers that [`Job::dumps`] may name; [`VOXEL_VIEWS`] with a level too.
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
    "voxels",
    "occlusion",
    "lobes",
];

/// How large the structure is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Voxels of the finest level.
    pub leaves: u32,
    /// Voxels of all levels.
    pub voxels: u32,
    /// Voxels of all levels that send light.
    pub lit: u32,
    /// Bytes of the structure and of its radiance.
    pub bytes: u64,
}

impl Counts {
    pub(crate) fn of<B: Backend>(pyramid: &Pyramid<B>, lighting: Option<&Lighting<B>>) -> Self {
        let (lit, bytes) = lighting.map_or((0, 0), Lighting::size);
        let (leaves, voxels) = (pyramid.params.leaves, pyramid.voxels());
        Self { leaves, voxels, lit, bytes: pyramid.bytes() + bytes }
    }
}

/// Renders direct light and indirect light by cones, or openness.
///
/// # Errors
/// Knobs out of range, and what the backend reports.
pub fn render<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    view: &View,
    job: &Job,
    settings: &VoxelCones,
) -> Result<(Rendered, Counts), BackendError> {
    settings.check(view.width, view.height)?;
    if !settings.occlusion && job.light == LightPart::Direct {
        let mut seen = Inspection::new(job, view.width, view.height);
        let picture = frame::render(backend, world, None, view, job, settings, &mut seen)?;
        return Ok((finish(backend, seen, picture)?, Counts::default()));
    }
    backend.set_stage("voxelisation");
    let pyramid = Pyramid::build(backend, world, settings)?;
    if settings.occlusion {
        let rendered = render_openness(backend, world, &pyramid, view, job, settings)?;
        return Ok((rendered, Counts::of(&pyramid, None)));
    }
    let lighting = Lighting::new(backend, world, &pyramid, settings)?;
    let rendered = render_lit(backend, world, &pyramid, &lighting, view, job, settings)?;
    Ok((rendered, Counts::of(&pyramid, Some(&lighting))))
}

/// Renders with voxels and light of an earlier picture: nothing is voxelised or injected.
///
/// # Errors
/// Knobs out of range, and what the backend reports.
pub fn render_lit<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    pyramid: &Pyramid<B>,
    lighting: &Lighting<B>,
    view: &View,
    job: &Job,
    settings: &VoxelCones,
) -> Result<Rendered, BackendError> {
    settings.check(view.width, view.height)?;
    let mut seen = Inspection::new(job, view.width, view.height);
    drawn::draw(backend, pyramid, &lighting.reflected, view, job, &mut seen)?;
    let picture = frame::render(backend, world, Some((pyramid, lighting)), view, job, settings, &mut seen)?;
    finish(backend, seen, picture)
}

/// Renders openness with voxels of an earlier picture.
///
/// # Errors
/// Knobs out of range, and what the backend reports.
pub fn render_openness<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    pyramid: &Pyramid<B>,
    view: &View,
    job: &Job,
    settings: &VoxelCones,
) -> Result<Rendered, BackendError> {
    settings.check(view.width, view.height)?;
    let mut seen = Inspection::new(job, view.width, view.height);
    let picture = frame::render_openness(backend, world, pyramid, view, job, settings, &mut seen)?;
    finish(backend, seen, picture)
}

fn finish<B: Backend>(
    backend: &mut B,
    seen: Inspection<'_>,
    picture: Picture,
) -> Result<Rendered, BackendError> {
    let timings = backend.take_timings()?;
    backend.set_stage("");
    Ok(seen.finish(picture, timings))
}
