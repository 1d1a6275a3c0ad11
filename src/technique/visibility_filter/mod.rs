//! What do surfaces send to each other, by point proxies and filtered visibility? Chen et al. 2014 (VF).
//!
//! [`Proxies`] stand for the scene, [`Lit`] for what light makes of them; both outlive a picture. For a picture,
//! coarse pixels find the voxels that they see ([`lists`]), and finer ones gather their light ([`frame`]).

pub mod frame;
pub mod lists;
mod lit;
mod proxies;
mod settings;

pub use lists::Lists;
pub use lit::Lit;
pub use proxies::{Cells, Proxies};
pub use settings::{
    Anchor, Clamp, Gather, MAX_PIXELS, MAX_PROXIES, MAX_RAYS, MAX_VOXELS, Visibility, VisibilityFilter,
};

use super::{Inspection, Job, LightPart, Rendered, View, World};
use crate::backend::{Backend, BackendError};

/// Buffers that [`Job::dumps`] may name.
pub const DUMPS: [&str; 13] = [
    "albedo",
    "normal",
    "depth",
    "position",
    "gloss",
    "emission",
    "visibility",
    "proxies",
    "voxels",
    "visible-count",
    "diffuse",
    "specular",
    "indirect",
];

/// What happened that a picture does not show.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Proxies on the scene.
    pub proxies: u32,
    /// Proxies times the cells that each disc reaches into; 0 where no ray meets discs.
    pub pairs: u32,
    /// Voxels that a list has room for.
    pub capacity: u32,
    /// Coarse pixels whose list was too small.
    pub full_lists: u32,
    /// Voxels that found no room, in all lists.
    pub dropped: u64,
}

/// Renders direct light and one bounce of indirect light.
///
/// # Errors
/// Knobs out of range, and what the backend reports.
pub fn render<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    view: &View,
    job: &Job,
    settings: &VisibilityFilter,
) -> Result<(Rendered, Counts), BackendError> {
    settings.check(view.width, view.height)?;
    let mut seen = Inspection::new(job, view.width, view.height);
    let mut lit_proxies = None;
    if job.light != LightPart::Direct {
        backend.set_stage("voxelisation");
        let discs = settings.visibility == Visibility::Proxies || seen.wants("proxies");
        let proxies = Proxies::build(backend, world, settings, job.seed, discs)?;
        backend.set_stage("lighting");
        let lit = Lit::light(backend, world, &proxies, settings, job, &mut seen)?;
        lit_proxies = Some((proxies, lit));
    }
    let borrowed = lit_proxies.as_ref().map(|(proxies, lit)| (proxies, lit));
    let (rendered, counts, _) = finish(backend, world, borrowed, None, view, job, settings, seen)?;
    Ok((rendered, counts))
}

/// Renders with proxies and light of an earlier picture: nothing is made or lit again. With the lists of an earlier picture of this
/// view nothing is marched either; those of this one are returned.
///
/// # Errors
/// Knobs out of range, and what the backend reports.
pub fn render_lit<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    (proxies, lit): (&Proxies<B>, &Lit<B>),
    known: Option<Lists<B>>,
    view: &View,
    job: &Job,
    settings: &VisibilityFilter,
) -> Result<(Rendered, Counts, Option<Lists<B>>), BackendError> {
    settings.check(view.width, view.height)?;
    let seen = Inspection::new(job, view.width, view.height);
    finish(backend, world, Some((proxies, lit)), known, view, job, settings, seen)
}

fn finish<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    lit_proxies: Option<(&Proxies<B>, &Lit<B>)>,
    known: Option<Lists<B>>,
    view: &View,
    job: &Job,
    settings: &VisibilityFilter,
    mut seen: Inspection<'_>,
) -> Result<(Rendered, Counts, Option<Lists<B>>), BackendError> {
    let frame = frame::render(backend, world, lit_proxies, known, view, job, settings, &mut seen)?;
    let timings = backend.take_timings()?;
    backend.set_stage("");
    let counts = match (&frame.lists, lit_proxies) {
        (Some(lists), Some((proxies, _))) => lists.count(backend, proxies)?,
        _ => Counts::default(),
    };
    Ok((seen.finish(frame.picture, timings), counts, frame.lists))
}
