//! Which approximation of a technique of cones costs how much?
//!
//! A stage at a time is replaced by its exact counterpart: whether light gets through by rays to the triangles, what is met by
//! the light of what rays meet. Diffuse surfaces and one bounce; CPU only.

use super::path::{from_lights, nearest};
use super::{Reference, Setting, setting};
use crate::backend::{Backend, BackendError, Cpu};
use crate::picture::Picture;
use crate::scene::{Scene, bvh::Bvh};
use crate::technique::layered_rsm::{self, LayeredRsm};
use crate::technique::voxel_cones::{self, VoxelCones};
use crate::technique::{View, World};
use glam::{Vec2, Vec3};
use rayon::prelude::*;
use twinlight_kernels::cone::diameter;
use twinlight_kernels::geometry::bvh::{Hit, NO_TRIANGLE};
use twinlight_kernels::math::dot;
use twinlight_kernels::passes::elements::{ConeParams, LayeredMap, Surface};
use twinlight_kernels::passes::layered_rsm::lookup::Maps;
use twinlight_kernels::passes::layered_rsm::trace::occluders;
use twinlight_kernels::passes::layered_rsm::voxels::BinaryVoxels;
use twinlight_kernels::passes::material::reflectance;
use twinlight_kernels::passes::surface::{pixel_direction, ray_origin, surface_at};
use twinlight_kernels::passes::voxel_cones::march::{Medium, Pyramid, Ray, Sample, march};
use twinlight_kernels::passes::voxel_cones::storage::storage_of;
use twinlight_kernels::passes::voxel_cones::trace::on_lattice;
use twinlight_kernels::sampling::hash::{combine, hash, unit_float};
use twinlight_kernels::sampling::hemisphere::{cone, cosine_hemisphere, to_world};

/// Which stages are exact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exact {
    /// None: the cones' own light, in as many directions as are asked for.
    Nothing,
    /// Whether and where something is met: by rays. What it sends: as cones find it there.
    Visibility,
    /// What it sends: as rays find it. Whether it is met: by cones.
    Radiance,
    /// Both: nothing of the technique is left, as a check.
    Both,
}

/// A technique of cones with what it made of the scene.
trait Cones: Sync {
    fn params(&self) -> &ConeParams;
    /// Light along a cone from a point of the lattice, in W/(m² sr), and the share of it that met nothing.
    fn along(&self, ray: &Ray) -> (Vec3, f32);
    /// What is sent back from `distance` edges along the ray, where something was met.
    fn at(&self, ray: &Ray, distance: f32) -> Vec3;
}

/// The buffers of voxel cones.
struct Voxels {
    params: ConeParams,
    blocks: Vec<u32>,
    depths: Vec<u32>,
    places: Vec<u32>,
    radiance: Vec<u32>,
}

/// Voxels that stop what meets them.
struct Solid<M: Medium>(M);

impl<M: Medium> Medium for Solid<M> {
    const CENTRE: f32 = M::CENTRE;

    fn voxel(&self, level: u32, point: glam::UVec3, direction: Vec3, cone: f32) -> Sample {
        let s = self.0.voxel(level, point, direction, cone);
        Sample { density: s.density * 64.0, carried: s.carried * 64.0 }
    }

    fn light(&self, carried: Vec3, direction: Vec3, width: f32) -> Vec3 {
        self.0.light(carried, direction, width)
    }
}

impl Voxels {
    fn medium(&self) -> Pyramid<'_> {
        Pyramid {
            depth: self.params.depth,
            lobes: self.params.lobes,
            storage: storage_of(self.params.flags),
            blocks: &self.blocks,
            depths: &self.depths,
            places: &self.places,
            radiance: &self.radiance,
        }
    }
}

impl Cones for Voxels {
    fn params(&self) -> &ConeParams {
        &self.params
    }

    fn along(&self, ray: &Ray) -> (Vec3, f32) {
        let met = march(&self.params, ray, &self.medium());
        (met.light * self.params.radiance_unit, met.through)
    }

    fn at(&self, ray: &Ray, distance: f32) -> Vec3 {
        // The first sample lies where something is; behind it the next voxels stand for it, if it has none.
        let width = (diameter(distance, ray.tangent) * self.params.width).max(1.0);
        let start = (distance - 0.5 * width * self.params.step).max(0.0);
        let params = ConeParams { start, ..self.params };
        let all = Ray { normal: Vec3::ZERO, ..*ray };
        let met = march(&params, &all, &Solid(self.medium()));
        if met.through < 1.0 {
            met.light * (self.params.radiance_unit / (1.0 - met.through))
        } else {
            Vec3::ZERO
        }
    }
}

/// The buffers of layered maps, a group of lights after the other.
struct Layered {
    params: ConeParams,
    words: Vec<u32>,
    groups: Vec<(Vec<LayeredMap>, Vec<u32>)>,
}

impl Layered {
    fn media(&self) -> impl Iterator<Item = BinaryVoxels<'_>> {
        self.groups.iter().map(|(maps, layers)| BinaryVoxels {
            occluders: occluders(&self.params, &self.words),
            maps: Maps { count: maps.len() as u32, lower: self.params.lower, maps, layers },
        })
    }
}

impl Cones for Layered {
    fn params(&self) -> &ConeParams {
        &self.params
    }

    fn along(&self, ray: &Ray) -> (Vec3, f32) {
        let mut sum = (Vec3::ZERO, 1.0);
        for medium in self.media() {
            let met = march(&self.params, ray, &medium);
            sum = (sum.0 + met.light * self.params.radiance_unit, met.through);
        }
        sum
    }

    fn at(&self, ray: &Ray, distance: f32) -> Vec3 {
        let point = ray.origin + ray.direction * distance;
        let width = (diameter(distance, ray.tangent) * self.params.width).max(1.0);
        let sent = self.media().map(|m| m.maps.radiance(point, ray.direction, width));
        sent.sum::<Vec3>() * self.params.radiance_unit
    }
}

/// A technique whose stages are taken apart.
pub struct Stages {
    cones: Box<dyn Cones>,
    /// Tangent of the half angle of its cones.
    tangent: f32,
}

impl Stages {
    /// Voxel cones', with their voxels and light.
    ///
    /// # Errors
    /// What the backend reports.
    pub fn voxel_cones(cpu: &mut Cpu, world: &World<Cpu>, s: &VoxelCones) -> Result<Self, BackendError> {
        let pyramid = voxel_cones::Pyramid::build(cpu, world, s)?;
        let lighting = voxel_cones::Lighting::new(cpu, world, &pyramid, s)?;
        let lit = &lighting.reflected;
        let voxels = Voxels {
            params: voxel_cones::cone_params(world, &pyramid, lit, s),
            blocks: cpu.download(&pyramid.blocks)?,
            depths: cpu.download(&pyramid.depths)?,
            places: cpu.download(&lit.places)?,
            radiance: cpu.download(&lit.radiance)?,
        };
        Ok(Self::of(voxels))
    }

    /// Layered maps', with their voxels and maps.
    ///
    /// # Errors
    /// What the backend reports.
    pub fn layered_rsm(cpu: &mut Cpu, world: &World<Cpu>, s: &LayeredRsm) -> Result<Self, BackendError> {
        let voxels = layered_rsm::BinaryVoxels::build(cpu, world, s)?;
        let maps = layered_rsm::Maps::build(cpu, world, s)?;
        let mut groups = Vec::new();
        for group in &maps.groups {
            groups.push((cpu.download(&group.maps)?, cpu.download(&group.layers)?));
        }
        let params = layered_rsm::cone_params(world, &voxels, s, maps.radiance_scale);
        Ok(Self::of(Layered { params, words: cpu.download(&voxels.words)?, groups }))
    }

    fn of(cones: impl Cones + 'static) -> Self {
        let params = cones.params();
        let own = cone(params.cones, 0, 0.0).tangent;
        let tangent = if params.tangent > 0.0 { params.tangent } else { own };
        Self { cones: Box::new(cones), tangent }
    }

    /// Indirect light of one bounce, by this many directions from each pixel's centre, with these stages exact.
    pub fn render(
        &self,
        scene: &Scene,
        tree: &Bvh,
        view: &View,
        exact: Exact,
        directions: u32,
        seed: u32,
    ) -> Picture {
        let settings = Reference { seed, ..Reference::default() };
        let setting = setting(scene, tree, view, &settings);
        let mut picture = Picture::new(view.width, view.height);
        picture.pixels.par_iter_mut().enumerate().for_each(|(i, pixel)| {
            *pixel = self.pixel(&setting, i as u32, exact, directions);
        });
        picture
    }

    fn pixel(&self, setting: &Setting<'_>, pixel: u32, exact: Exact, directions: u32) -> Vec3 {
        let camera = &setting.camera;
        let direction = pixel_direction(pixel, camera);
        let Some(s) = seen(setting, camera.eye.truncate(), direction) else { return Vec3::ZERO };
        let scene = setting.scene;
        let uv = Vec2::new(s.u, s.v);
        let albedo = reflectance(&scene.materials[s.material as usize], &setting.texels, uv).diffuse;
        let (position, normal) = (s.position.truncate(), s.normal.truncate());
        let mut sum = Vec3::ZERO;
        for number in 0..directions {
            let key = combine(combine(setting.settings.seed, pixel), number);
            let u = Vec2::new(unit_float(hash(key)), unit_float(hash(key ^ 0x9E37_79B9)));
            let direction = to_world(cosine_hemisphere(u), normal);
            if dot(direction, normal) > 0.0 {
                sum += self.found(setting, &s, position, normal, direction, exact);
            }
        }
        albedo * (sum / directions.max(1) as f32)
    }

    /// What is found along a direction.
    fn found(
        &self,
        setting: &Setting<'_>,
        s: &Surface,
        position: Vec3,
        normal: Vec3,
        direction: Vec3,
        exact: Exact,
    ) -> Vec3 {
        let params = self.cones.params();
        let ray = Ray {
            origin: on_lattice(params, position),
            direction,
            normal,
            tangent: self.tangent,
            reach: params.reach,
        };
        if exact == Exact::Nothing {
            return self.cones.along(&ray).0;
        }
        let triangle = &setting.scene.triangles[s.triangle as usize];
        let Some(met) = seen(setting, ray_origin(position, triangle, direction), direction) else {
            return Vec3::ZERO;
        };
        let distance = (met.position.truncate() - position).length() * params.inverse_edge;
        if exact == Exact::Visibility {
            return self.cones.at(&ray, distance);
        }
        let material = &setting.scene.materials[met.material as usize];
        let lobes = reflectance(material, &setting.texels, Vec2::new(met.u, met.v));
        let sent = from_lights(setting, &met, &lobes, -direction);
        if exact == Exact::Both { sent } else { sent * (1.0 - self.cones.along(&ray).1) }
    }
}

/// The surface that a ray meets.
fn seen(setting: &Setting<'_>, origin: Vec3, direction: Vec3) -> Option<Surface> {
    let hit: Hit = nearest(setting, origin, direction);
    let scene = setting.scene;
    (hit.triangle != NO_TRIANGLE)
        .then(|| surface_at(&hit, direction, &scene.triangles, &scene.materials, &setting.texels))
}
