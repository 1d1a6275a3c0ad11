//! What of a picture outlives it, and which change ends that?

use super::Counts;
use crate::backend::{Backend, BackendError};
use crate::plan::{Plan, Technique};
use crate::scene::Bounds;
use crate::technique::layered_rsm::{self, BinaryVoxels, LayeredRsm, Maps};
use crate::technique::visibility_filter::{self, Lists, Lit, Proxies, Visibility, VisibilityFilter};
use crate::technique::voxel_cones::{self, Lighting, Pyramid, VoxelCones};
use crate::technique::{Inspection, LightPart, Rendered, View, World};
use std::ops::Range;

/// What decides how structures are made.
#[derive(PartialEq)]
struct Key {
    technique: Technique,
    seed: u32,
    rays: u32,
    /// Techniques leave out what a part of the light does not need.
    light: LightPart,
}

/// Voxels of what does not move.
struct Fixed<B: Backend> {
    pyramid: Pyramid<B>,
    moving: Range<u32>,
    bounds: Bounds,
}

/// Structures of the technique that ran last.
pub(super) struct Kept<B: Backend> {
    key: Option<Key>,
    proxies: Option<Proxies<B>>,
    lit: Option<Lit<B>>,
    /// Which voxels a view's pixels see.
    lists: Option<(View, Lists<B>)>,
    fixed: Option<Fixed<B>>,
    pyramid: Option<Pyramid<B>>,
    lighting: Option<Lighting<B>>,
    voxels: Option<BinaryVoxels<B>>,
    maps: Option<Maps<B>>,
    /// What has moved since a structure was first made.
    moved: Option<Range<u32>>,
}

impl<B: Backend> Default for Kept<B> {
    fn default() -> Self {
        Self {
            key: None,
            proxies: None,
            lit: None,
            lists: None,
            fixed: None,
            pyramid: None,
            lighting: None,
            voxels: None,
            maps: None,
            moved: None,
        }
    }
}

impl<B: Backend> Kept<B> {
    /// Lights or surroundings are others.
    pub(super) fn lights_changed(&mut self) {
        (self.lit, self.lighting, self.maps) = (None, None, None);
    }

    /// The view is another.
    pub(super) fn seen_from_elsewhere(&mut self) {
        self.lists = None;
    }

    /// Triangles are elsewhere.
    pub(super) fn meshes_moved(&mut self, range: Range<u32>) {
        self.lights_changed();
        (self.proxies, self.lists, self.pyramid, self.voxels) = (None, None, None, None);
        let moved = self.moved.take().unwrap_or(range.clone());
        self.moved = Some(moved.start.min(range.start)..moved.end.max(range.end));
    }

    /// Forgets what was made for another plan.
    fn begin(&mut self, plan: &Plan) {
        let key = Some(Key {
            technique: plan.technique.clone(),
            seed: plan.job.seed,
            rays: plan.job.rays,
            light: plan.job.light,
        });
        if self.key != key {
            *self = Self { key, ..Self::default() };
        }
    }

    pub(super) fn visibility_filter(
        &mut self,
        backend: &mut B,
        world: &World<B>,
        plan: &Plan,
        settings: &VisibilityFilter,
    ) -> Result<(Rendered, Counts), BackendError> {
        self.begin(plan);
        let (view, job) = (&plan.view, &plan.job);
        let proxies = match &mut self.proxies {
            Some(proxies) => proxies,
            none => {
                backend.set_stage("voxelisation");
                let discs = settings.visibility == Visibility::Proxies;
                none.insert(Proxies::build(backend, world, settings, job.seed, discs)?)
            }
        };
        let lit = match &mut self.lit {
            Some(lit) => lit,
            none => {
                backend.set_stage("lighting");
                let mut seen = Inspection::new(job, view.width, view.height);
                none.insert(Lit::light(backend, world, proxies, settings, job, &mut seen)?)
            }
        };
        let known = self.lists.take().filter(|(of, _)| of == view).map(|(_, lists)| lists);
        let (rendered, counts, lists) =
            visibility_filter::render_lit(backend, world, (proxies, lit), known, view, job, settings)?;
        self.lists = lists.map(|lists| (*view, lists));
        Ok((rendered, Counts::VisibilityFilter(counts)))
    }

    /// The voxels of all triangles; if some move and the others do not, those are voxelised alone.
    fn build_pyramid(
        &mut self,
        backend: &mut B,
        world: &World<B>,
        settings: &VoxelCones,
    ) -> Result<Pyramid<B>, BackendError> {
        let all = world.triangle_count;
        let Some(moved) = self.moved.clone() else { return Pyramid::build(backend, world, settings) };
        let reusable = |f: &Fixed<B>| {
            f.bounds == world.bounds && f.moving.start <= moved.start && moved.end <= f.moving.end
        };
        let fixed = match self.fixed.take().filter(reusable) {
            Some(fixed) => fixed,
            None => {
                let still = if moved.start == 0 { moved.end..all } else { 0..moved.start };
                let one_piece = moved.start == 0 || moved.end == all;
                if !one_piece || still.len() < moved.len() {
                    return Pyramid::build(backend, world, settings);
                }
                let pyramid = Pyramid::build_part(backend, world, settings, &world.bounds, still)?;
                Fixed { pyramid, moving: moved, bounds: world.bounds }
            }
        };
        let fixed = self.fixed.insert(fixed);
        fixed.pyramid.with_moving(backend, world, fixed.moving.clone())
    }

    pub(super) fn voxel_cones(
        &mut self,
        backend: &mut B,
        world: &World<B>,
        plan: &Plan,
        settings: &VoxelCones,
    ) -> Result<(Rendered, Counts), BackendError> {
        self.begin(plan);
        let (view, job) = (&plan.view, &plan.job);
        let pyramid = match self.pyramid.take() {
            Some(pyramid) => pyramid,
            None => {
                backend.set_stage("voxelisation");
                self.build_pyramid(backend, world, settings)?
            }
        };
        let pyramid = self.pyramid.insert(pyramid);
        if settings.occlusion {
            let rendered = voxel_cones::render_openness(backend, world, pyramid, view, job, settings)?;
            return Ok((rendered, Counts::VoxelCones(voxel_cones::Counts::of(pyramid, None))));
        }
        let lighting = match &mut self.lighting {
            Some(lighting) => lighting,
            none => none.insert(Lighting::new(backend, world, pyramid, settings)?),
        };
        let counts = voxel_cones::Counts::of(pyramid, Some(lighting));
        let rendered = voxel_cones::render_lit(backend, world, pyramid, lighting, view, job, settings)?;
        Ok((rendered, Counts::VoxelCones(counts)))
    }

    pub(super) fn layered_rsm(
        &mut self,
        backend: &mut B,
        world: &World<B>,
        plan: &Plan,
        settings: &LayeredRsm,
    ) -> Result<(Rendered, Counts), BackendError> {
        self.begin(plan);
        let voxels = match &mut self.voxels {
            Some(voxels) => voxels,
            none => {
                backend.set_stage("voxelisation");
                none.insert(BinaryVoxels::build(backend, world, settings)?)
            }
        };
        let maps = match &mut self.maps {
            Some(maps) => maps,
            none => {
                backend.set_stage("maps");
                none.insert(if plan.gathers() {
                    Maps::build(backend, world, settings)?
                } else {
                    Maps { groups: Vec::new(), radiance_scale: 1.0 }
                })
            }
        };
        let counts = layered_rsm::Counts::of(voxels, maps, settings);
        let (view, job) = (&plan.view, &plan.job);
        let rendered = layered_rsm::render_lit(backend, world, voxels, maps, view, job, settings)?;
        Ok((rendered, Counts::LayeredRsm(counts)))
    }
}
