//! What of a scene lies in the backend's memory, and from where is it seen?

use super::gbuffer::GBuffer;
use crate::backend::{Backend, BackendError};
use crate::error::SceneError;
use crate::plan::{Effect, Plan};
use crate::scene::{Bounds, Camera, CameraFrame, Environment, Scene, area, bvh::Bvh};
use glam::{UVec4, Vec4};
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;
use twinlight_kernels::geometry::bvh::{BvhNode, TriangleBlock};
use twinlight_kernels::passes::elements::{CameraParams, GatherParams, Light, Material, Triangle};

/// A scene's buffers on a backend.
pub struct World<B: Backend> {
    /// The tree's nodes.
    pub nodes: B::Buffer<BvhNode>,
    /// The tree's triangles.
    pub blocks: B::Buffer<TriangleBlock>,
    /// Triangles by index.
    pub triangles: B::Buffer<Triangle>,
    /// Materials by index.
    pub materials: B::Buffer<Material>,
    /// Textures, then the environment map.
    pub texels: B::Buffer<u32>,
    /// Lights; one dark light for a scene without any.
    pub lights: B::Buffer<Light>,
    /// Number of lights.
    pub light_count: u32,
    /// The environment, with the defaults of the passes that look it up.
    pub environment: GatherParams,
    /// The box around all triangles.
    pub bounds: Bounds,
    /// Number of triangles.
    pub triangle_count: u32,
    /// Their area in m², one side.
    pub area: f64,
    /// The lights on the host, for their maps.
    pub host_lights: Vec<Light>,
    /// Whether point, spot and sun lights shine straight on what is seen.
    pub lights_shine: bool,
    /// Whether the environment gives light.
    pub has_environment: bool,
    /// Whether some surface is glossy.
    pub has_gloss: bool,
    /// Whether what glossy surfaces mirror of others is wanted.
    pub has_mirrors: bool,
    /// Whether emissive surfaces emit.
    pub emits: bool,
    /// The largest radiance that a material emits, W/(m² sr); 0 where nothing does.
    pub largest_emission: f32,
    /// Mean radiance of the environment, of its strongest colour.
    pub mean_environment: f32,
    /// G-buffers of views that may come again, if they are kept.
    pub(super) kept: RefCell<Option<Vec<KeptGBuffer<B>>>>,
}

/// A G-buffer that may be wanted again.
pub(super) struct KeptGBuffer<B: Backend> {
    pub(super) view: View,
    pub(super) pixels: Range<u32>,
    pub(super) gbuffer: Rc<GBuffer<B>>,
}

/// The parameters that describe an environment whose map, if any, follows `first_word` words of texels.
pub fn environment_params(environment: &Environment, first_word: u32) -> GatherParams {
    let mut params = GatherParams { rays: 1, reach: 1.0e30, ..Default::default() };
    match environment {
        Environment::None => {}
        Environment::Constant(radiance) => params.environment = radiance.extend(0.0),
        Environment::Map(map) => {
            params.map = UVec4::new(first_word, map.width, map.height, copies(map.width, map.height));
        }
    }
    params
}

/// How many smaller copies follow a map: down to one row.
fn copies(width: u32, height: u32) -> u32 {
    if width == 0 || height == 0 { 0 } else { height.ilog2() }
}

/// The textures, then the map's texels as three words of f32 bits each, then its copies of half the size, a quarter …
pub(crate) fn texels_with_environment(scene: &Scene) -> Vec<u32> {
    let mut texels = scene.texels.clone();
    if let Environment::Map(map) = &scene.environment {
        let mut keep = |data: &[Vec4]| {
            texels.extend(data.iter().flat_map(|t| [t.x.to_bits(), t.y.to_bits(), t.z.to_bits()]));
        };
        keep(&map.data);
        let (mut data, mut width, mut height) = (map.data.clone(), map.width, map.height);
        for _ in 0..copies(width, height) {
            data = halved(&data, width, height);
            (width, height) = ((width / 2).max(1), height / 2);
            keep(&data);
        }
    }
    texels
}

/// A map of half the width and height: means of four texels, rows by their solid angle. An odd last row or column counts
/// with the one before.
fn halved(data: &[Vec4], width: u32, height: u32) -> Vec<Vec4> {
    let (columns, rows) = ((width / 2).max(1), (height / 2).max(1));
    let sine = |y: u32| (std::f64::consts::PI * (f64::from(y) + 0.5) / f64::from(height)).sin();
    let share =
        |i: u32, count: u32, all: u32| (i * 2).min(all - 1)..if i + 1 == count { all } else { 2 * i + 2 };
    let mut small = Vec::with_capacity((columns * rows) as usize);
    for y in 0..rows {
        for x in 0..columns {
            let (mut sum, mut whole) = (glam::DVec4::ZERO, 0.0);
            for from_y in share(y, rows, height) {
                for from_x in share(x, columns, width) {
                    sum += data[(from_y * width + from_x) as usize].as_dvec4() * sine(from_y);
                    whole += sine(from_y);
                }
            }
            small.push((sum / whole).as_vec4());
        }
    }
    small
}

/// The mean radiance over all texels of an environment, of the strongest colour.
fn mean_environment(environment: &Environment) -> f32 {
    match environment {
        Environment::None => 0.0,
        Environment::Constant(radiance) => radiance.max_element(),
        Environment::Map(map) => {
            let sum: glam::DVec3 = map.data.iter().map(|t| t.truncate().as_dvec3()).sum();
            (sum.max_element() / map.data.len().max(1) as f64) as f32
        }
    }
}

fn largest_emission(scene: &Scene) -> f32 {
    scene.materials.iter().map(|m| m.emission.truncate().max_element()).fold(0.0, f32::max)
}

impl<B: Backend> World<B> {
    /// Has what a plan calls for of what the scene has; whether that is other than before.
    pub(crate) fn follow(&mut self, plan: &Plan) -> bool {
        let flags = |w: &Self| (w.lights_shine, w.has_environment, w.has_gloss, w.has_mirrors, w.emits);
        let before = flags(self);
        use Effect::{Emission, Environment, Gloss, Lights, ProxyBounce, ProxyShadows, SpecularBounce};
        self.lights_shine = plan.calls(Lights);
        self.has_environment = [Environment, ProxyShadows, ProxyBounce].iter().any(|&e| plan.calls(e));
        self.has_gloss = plan.calls(Gloss);
        self.has_mirrors = plan.calls(SpecularBounce);
        self.emits = plan.calls(Emission);
        before != flags(self)
    }

    /// Keeps the G-buffers that are made from here on, without those of before.
    pub(crate) fn keep_gbuffers(&mut self) {
        self.kept = RefCell::new(Some(Vec::new()));
    }

    /// Forgets kept G-buffers of other views than this one, whatever its size.
    pub(crate) fn forget_other_views(&mut self, view: &View) {
        if let Some(kept) = self.kept.get_mut() {
            kept.retain(|k| (k.view.frame, k.view.aspect) == (view.frame, view.aspect));
        }
    }

    /// Takes over the lights of a scene.
    pub(crate) fn set_lights(&mut self, backend: &mut B, lights: &[Light]) -> Result<(), BackendError> {
        let dark = [Light::default()];
        self.lights = backend.upload("lights", if lights.is_empty() { &dark[..] } else { lights })?;
        self.light_count = lights.len() as u32;
        self.host_lights = lights.to_vec();
        Ok(())
    }

    /// Takes over the surroundings and textures of a scene.
    pub(crate) fn set_surroundings(&mut self, backend: &mut B, scene: &Scene) -> Result<(), BackendError> {
        self.texels = backend.upload("texels", &texels_with_environment(scene))?;
        self.environment = environment_params(&scene.environment, scene.texels.len() as u32);
        self.mean_environment = mean_environment(&scene.environment);
        Ok(())
    }

    /// Takes over the materials and textures of a scene.
    pub(crate) fn set_materials(&mut self, backend: &mut B, scene: &Scene) -> Result<(), BackendError> {
        self.materials = backend.upload("materials", &scene.materials)?;
        self.largest_emission = largest_emission(scene);
        self.set_surroundings(backend, scene)
    }

    /// Takes over the triangles of a scene and their tree.
    pub(crate) fn set_triangles(
        &mut self,
        backend: &mut B,
        scene: &Scene,
        tree: &Bvh,
    ) -> Result<(), BackendError> {
        self.nodes = backend.upload("nodes", &tree.nodes)?;
        self.blocks = backend.upload("blocks", &tree.blocks)?;
        self.triangles = backend.upload("triangles", &scene.triangles)?;
        self.bounds = scene.bounds();
        self.triangle_count = scene.triangles.len() as u32;
        self.area = scene.triangles.iter().map(area).sum();
        Ok(())
    }

    /// Uploads a scene and its tree; with `emissive`, emissive surfaces emit.
    pub fn upload(backend: &mut B, scene: &Scene, tree: &Bvh, emissive: bool) -> Result<Self, BackendError> {
        let census = scene.census();
        let texels = texels_with_environment(scene);
        let dark = [Light::default()];
        let lights = if scene.lights.is_empty() { &dark[..] } else { &scene.lights };
        Ok(Self {
            nodes: backend.upload("nodes", &tree.nodes)?,
            blocks: backend.upload("blocks", &tree.blocks)?,
            triangles: backend.upload("triangles", &scene.triangles)?,
            materials: backend.upload("materials", &scene.materials)?,
            texels: backend.upload("texels", &texels)?,
            lights: backend.upload("lights", lights)?,
            light_count: scene.lights.len() as u32,
            environment: environment_params(&scene.environment, scene.texels.len() as u32),
            bounds: scene.bounds(),
            triangle_count: scene.triangles.len() as u32,
            area: scene.triangles.iter().map(area).sum(),
            host_lights: scene.lights.clone(),
            lights_shine: true,
            has_environment: census.has_environment,
            has_gloss: census.has_gloss,
            has_mirrors: census.has_gloss,
            emits: emissive && census.has_emission,
            largest_emission: largest_emission(scene),
            mean_environment: mean_environment(&scene.environment),
            kept: RefCell::new(None),
        })
    }
}

/// A camera and a picture size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera's axes.
    pub frame: CameraFrame,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Width over height of what is seen; another than that of the pixels makes pixels that are not square.
    pub aspect: f32,
}

impl View {
    /// The view of a valid camera.
    pub fn new(camera: &Camera, width: u32, height: u32) -> Result<Self, SceneError> {
        Ok(Self { frame: camera.frame()?, width, height, aspect: width as f32 / height as f32 })
    }

    /// The same view in other pixels: the same rays bound the picture.
    pub fn resized(&self, width: u32, height: u32) -> Self {
        Self { width, height, ..*self }
    }

    /// Number of pixels.
    pub fn pixels(&self) -> u32 {
        self.width * self.height
    }

    /// The parameters of the passes for the band that begins at `first_pixel`.
    pub fn params(&self, first_pixel: u32) -> CameraParams {
        let f = &self.frame;
        CameraParams {
            eye: f.eye.extend(0.0),
            right: (f.right * (f.tan_half_fov * self.aspect)).extend(0.0),
            up: (f.up * f.tan_half_fov).extend(0.0),
            forward: f.forward.extend(0.0),
            width: self.width,
            first_pixel,
            pixel_width: 2.0 / self.width as f32,
            pixel_height: 2.0 / self.height as f32,
        }
    }
}
