//! How does one render picture after picture, and pay for what changed alone?
//!
//! ```
//! use twinlight::backend::Cpu;
//! use twinlight::plan::{Plan, Request, Technique};
//! use twinlight::renderer::Renderer;
//! use twinlight::scene::Scene;
//! use twinlight::technique::{Job, View};
//!
//! let scene = Scene::open("cornell-box")?;
//! let view = View::new(&scene.view(), 32, 32)?;
//! let mut renderer = Renderer::new(Cpu::new(None)?, scene)?;
//! let plan = renderer.plan(&Request::new(Technique::VoxelCones(Default::default()), view, Job::default()))?;
//! let first = renderer.render(&plan)?;
//! assert!(first.rendered.picture.mean().x > 0.0);
//! renderer.set_lights(&[])?;
//! let dark = renderer.render(&renderer.plan(&Request::new(Technique::Direct, view, Job::default()))?)?;
//! assert_eq!(dark.rendered.picture.mean().x, 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod budget;
mod kept;

use crate::backend::{Backend, BackendError, Cpu, Recorder};
use crate::error::SettingsError;
use crate::plan::{Change, Costs, Plan, Request, Technique};
use crate::scene::{Environment, Scene, bvh::Bvh};
use crate::technique::{
    Rendered, World, ambient_occlusion, direct, layered_rsm, soft_gi, visibility_filter, voxel_cones,
};
use kept::Kept;
use std::ops::Range;
use twinlight_kernels::passes::elements::{Light, Material, Triangle};

/// Pixels of a picture that is kept for the case that nothing changes, at most: 400 MB.
const MAX_KEPT: u64 = 1 << 25;

/// How much there was to do, of the technique that ran.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Counts {
    /// It counts nothing.
    #[default]
    Nothing,
    /// The visibility filter's.
    VisibilityFilter(visibility_filter::Counts),
    /// Voxel cones'.
    VoxelCones(voxel_cones::Counts),
    /// Soft global illumination's.
    SoftGi(soft_gi::Counts),
    /// Layered reflective shadow maps'.
    LayeredRsm(layered_rsm::Counts),
}

/// A picture.
#[derive(Clone, Debug)]
pub struct Frame {
    /// The picture, and the passes that ran for it: none if nothing had changed.
    pub rendered: Rendered,
    /// How much there was to do.
    pub counts: Counts,
}

/// A scene on a backend, with what earlier pictures left.
pub struct Renderer<B: Backend> {
    backend: B,
    scene: Scene,
    tree: Bvh,
    world: World<B>,
    kept: Kept<B>,
    last: Option<(Plan, Frame)>,
}

impl<B: Backend> Renderer<B> {
    /// Uploads a scene.
    ///
    /// # Errors
    /// A scene that no tree can be built over, and what the backend reports.
    pub fn new(backend: B, scene: Scene) -> Result<Self, BackendError> {
        let tree = Bvh::build(&scene.triangles, &scene.materials)?;
        Self::with_tree(backend, scene, tree)
    }

    /// Uploads a scene whose tree is known.
    ///
    /// # Errors
    /// What the backend reports.
    pub fn with_tree(mut backend: B, scene: Scene, tree: Bvh) -> Result<Self, BackendError> {
        let mut world = World::upload(&mut backend, &scene, &tree, true)?;
        world.keep_gbuffers();
        Ok(Self { backend, scene, tree, world, kept: Kept::default(), last: None })
    }

    /// The backend.
    pub fn backend(&self) -> &B {
        &self.backend
    }

    /// The backend, for what it counts.
    pub fn backend_mut(&mut self) -> &mut B {
        &mut self.backend
    }

    /// Ends, and gives the backend back.
    pub fn into_backend(self) -> B {
        self.backend
    }

    /// The scene as it is now.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Decides what a request calls for in the scene as it is now.
    ///
    /// # Errors
    /// Knobs out of range.
    pub fn plan(&self, request: &Request) -> Result<Plan, SettingsError> {
        Plan::new(&self.scene, request)
    }

    /// Finds the passes and buffers of a plan's picture, and what runs again after each kind of change, without rendering.
    ///
    /// # Errors
    /// What the technique reports for the scene.
    pub fn costs(&self, plan: &Plan) -> Result<Costs, BackendError> {
        costs(&self.scene, &self.tree, plan)
    }

    /// Renders what the plan says. Of what earlier pictures made, all is used that the changes since then left valid.
    ///
    /// # Errors
    /// What the backend reports.
    pub fn render(&mut self, plan: &Plan) -> Result<Frame, BackendError> {
        let looks = plan.job.check_finite || !plan.job.dumps.is_empty();
        if let Some((_, frame)) = self.last.as_ref().filter(|(last, _)| last == plan && !looks) {
            let mut frame = frame.clone();
            frame.rendered.timings.clear();
            return Ok(frame);
        }
        self.last = None;
        if self.world.follow(plan) {
            self.world.keep_gbuffers();
            self.kept = Kept::default();
        }
        self.world.forget_other_views(&plan.view);
        self.backend.take_timings()?;
        self.backend.set_stage("");
        let (rendered, counts) = self.draw(plan, looks)?;
        let frame = Frame { rendered, counts };
        if u64::from(plan.view.pixels()) <= MAX_KEPT {
            self.last = Some((plan.clone(), frame.clone()));
        }
        Ok(frame)
    }

    fn draw(&mut self, plan: &Plan, looks: bool) -> Result<(Rendered, Counts), BackendError> {
        let Self { backend, scene, world, kept, .. } = self;
        let (view, job) = (&plan.view, &plan.job);
        // Who looks into buffers sees all of them made.
        if looks {
            *kept = Kept::default();
            world.keep_gbuffers();
        }
        Ok(match &plan.technique {
            Technique::Direct => (direct::render(backend, world, view, job)?, Counts::Nothing),
            Technique::AmbientOcclusion => {
                (ambient_occlusion::render(backend, world, view, job)?, Counts::Nothing)
            }
            Technique::SoftGi(settings) => {
                let around = soft_gi::Surroundings::new(scene);
                let (rendered, counts) = soft_gi::render(backend, world, &around, view, job, settings)?;
                (rendered, Counts::SoftGi(counts))
            }
            Technique::VisibilityFilter(settings) if looks || !plan.gathers() => {
                let (rendered, counts) = visibility_filter::render(backend, world, view, job, settings)?;
                (rendered, Counts::VisibilityFilter(counts))
            }
            Technique::VoxelCones(settings) if looks || !(plan.gathers() || settings.occlusion) => {
                let (rendered, counts) = voxel_cones::render(backend, world, view, job, settings)?;
                (rendered, Counts::VoxelCones(counts))
            }
            Technique::LayeredRsm(settings) if looks || !(plan.gathers() || settings.shadow_cones) => {
                let (rendered, counts) = layered_rsm::render(backend, world, view, job, settings)?;
                (rendered, Counts::LayeredRsm(counts))
            }
            Technique::VisibilityFilter(settings) => {
                kept.visibility_filter(backend, world, plan, settings)?
            }
            Technique::VoxelCones(settings) => kept.voxel_cones(backend, world, plan, settings)?,
            Technique::LayeredRsm(settings) => kept.layered_rsm(backend, world, plan, settings)?,
        })
    }

    /// Takes over another state of the scene, and tells what changed.
    ///
    /// # Errors
    /// A scene that no tree can be built over, and what the backend reports.
    pub fn update(&mut self, scene: Scene) -> Result<Vec<Change>, BackendError> {
        let mut changes = Vec::new();
        let masks = |s: &Scene| s.materials.iter().map(|m| m.flags).collect::<Vec<_>>();
        let moved = moved(&self.scene.triangles, &scene.triangles);
        let surfaces = self.scene.materials != scene.materials || self.scene.texels != scene.texels;
        let rebuild = moved.is_some() || masks(&self.scene) != masks(&scene);
        let lights = self.scene.lights != scene.lights;
        let environment = self.scene.environment != scene.environment;
        // A scene that cannot be used leaves the one before as it is.
        let tree = if rebuild { Some(Bvh::build(&scene.triangles, &scene.materials)?) } else { None };
        if self.scene.proxies != scene.proxies {
            self.last = None;
            changes.push(Change::Meshes);
        }
        self.scene = scene;
        if let Some(tree) = tree {
            self.tree = tree;
            self.world.set_triangles(&mut self.backend, &self.scene, &self.tree)?;
        }
        if let Some(range) = moved {
            changes.push(Change::Meshes);
            self.kept.meshes_moved(range);
        }
        if surfaces {
            changes.push(Change::Materials);
            self.world.set_materials(&mut self.backend, &self.scene)?;
            self.kept = Kept::default();
        }
        if rebuild || surfaces {
            self.last = None;
            self.world.keep_gbuffers();
        }
        if lights || environment {
            changes.push(Change::Lights);
            self.last = None;
            self.kept.lights_changed();
        }
        if lights {
            self.world.set_lights(&mut self.backend, &self.scene.lights)?;
        }
        if environment && !surfaces {
            self.world.set_surroundings(&mut self.backend, &self.scene)?;
        }
        changes.dedup();
        Ok(changes)
    }

    /// Other lights.
    ///
    /// # Errors
    /// What the backend reports.
    pub fn set_lights(&mut self, lights: &[Light]) -> Result<(), BackendError> {
        self.update(Scene { lights: lights.to_vec(), ..self.scene.clone() }).map(|_| ())
    }

    /// Other surroundings.
    ///
    /// # Errors
    /// What the backend reports.
    pub fn set_environment(&mut self, environment: Environment) -> Result<(), BackendError> {
        self.update(Scene { environment, ..self.scene.clone() }).map(|_| ())
    }

    /// Other materials, as many as before.
    ///
    /// # Errors
    /// What the backend reports.
    pub fn set_materials(&mut self, materials: &[Material]) -> Result<(), BackendError> {
        self.update(Scene { materials: materials.to_vec(), ..self.scene.clone() }).map(|_| ())
    }

    /// Triangles from `first` on are now elsewhere.
    ///
    /// # Errors
    /// What the backend reports, and a scene that no tree can be built over.
    pub fn set_triangles(&mut self, first: usize, triangles: &[Triangle]) -> Result<(), BackendError> {
        let mut scene = self.scene.clone();
        let end = scene.triangles.len().min(first + triangles.len());
        let first = first.min(end);
        scene.triangles[first..end].copy_from_slice(&triangles[..end - first]);
        self.update(scene).map(|_| ())
    }

    /// Forgets all that earlier pictures left: the next one is made from nothing.
    pub fn forget(&mut self) {
        self.last = None;
        self.kept = Kept::default();
        self.world.keep_gbuffers();
    }

    /// As if something of this kind had changed, although nothing has.
    pub(crate) fn touch(&mut self, change: Change) -> Result<(), BackendError> {
        match change {
            Change::Nothing => return Ok(()),
            Change::Camera => {
                self.world.keep_gbuffers();
                self.kept.seen_from_elsewhere();
            }
            Change::Lights => {
                self.world.set_lights(&mut self.backend, &self.scene.lights)?;
                self.kept.lights_changed();
            }
            Change::Meshes => {
                self.world.set_triangles(&mut self.backend, &self.scene, &self.tree)?;
                self.kept.meshes_moved(0..self.scene.triangles.len() as u32);
                self.world.keep_gbuffers();
            }
            Change::Materials => {
                self.world.set_materials(&mut self.backend, &self.scene)?;
                self.kept = Kept::default();
                self.world.keep_gbuffers();
            }
        }
        self.last = None;
        Ok(())
    }
}

/// The triangles that are not where they were: from the first to the last of them; all, if their number is another.
fn moved(before: &[Triangle], after: &[Triangle]) -> Option<Range<u32>> {
    if before.len() != after.len() {
        return Some(0..after.len() as u32);
    }
    let differs = |i: &usize| before[*i] != after[*i];
    let first = (0..after.len()).find(differs)?;
    let last = (first..after.len()).rfind(differs)?;
    Some(first as u32..last as u32 + 1)
}

/// [`Renderer::costs`] of a scene on no backend.
///
/// # Errors
/// What the technique reports for the scene.
pub fn costs(scene: &Scene, tree: &Bvh, plan: &Plan) -> Result<Costs, BackendError> {
    let mut recorder = Recorder::new(Cpu::new(None)?);
    recorder.log_allocations(true);
    let mut renderer = Renderer::with_tree(recorder, scene.clone(), tree.clone())?;
    let frame = renderer.render(plan)?;
    let (passes, counts) = (frame.rendered.timings, frame.counts);
    let buffers = renderer.backend.take_allocations();
    let computed = renderer.backend.computed().to_vec();
    let mut again = Vec::new();
    for change in Change::ALL {
        renderer.touch(change)?;
        again.push((change, renderer.render(plan)?.rendered.timings));
    }
    Ok(Costs { passes, buffers, again, counts, computed })
}
