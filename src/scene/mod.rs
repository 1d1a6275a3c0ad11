//! What is to be rendered: which triangles, materials, textures, lights, surroundings and camera?
//!
//! Everything is in world space, in metres, y up, and already in the elements of the buffers that kernels read.

mod bounds;
mod builtin;
pub mod bvh;
mod camera;
mod daylight;
mod environment;
mod gltf_accessor;
mod gltf_file;
mod gltf_material;
mod gltf_node;
mod gltf_pose;
mod gltf_texture;
pub mod light;
mod proxies;

pub use bounds::Bounds;
pub use camera::{Camera, CameraFrame};
pub use daylight::daylight;
pub use environment::{Environment, EnvironmentMap};
pub use proxies::{Carried, Fit, MAX_PROXIES};

use crate::error::SceneError;
use glam::Vec3;
use std::path::Path;
use twinlight_kernels::passes::scene::{
    LIGHT_POINT, LIGHT_SPOT, LIGHT_SUN, Light, MATERIAL_MASKED, Material, NO_TEXTURE, Triangle,
};

/// The largest magnitude of a coordinate (metres), an intensity or a radiance: products of two stay far within f32.
pub const MAX_VALUE: f32 = 1.0e18;

/// The names that [`Scene::open`] takes besides files.
pub const BUILT_IN: [&str; 3] = ["cornell-box", "cornell-glossy", "spheres"];

/// A scene, ready for [`bvh::Bvh::build`] and for upload.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Scene {
    /// The file's name without folder and extension, or the built-in's name.
    pub name: String,
    /// Every triangle, in the order of the file; at least one, at most [`bvh::MAX_TRIANGLES`].
    pub triangles: Vec<Triangle>,
    /// The materials that triangles index; at least one.
    pub materials: Vec<Material>,
    /// All textures: two words a texel, linear 16-bit unorm r | g << 16 and b | a << 16, rows from the top.
    ///
    /// A material's texture index counts texels: its first word is at twice the index.
    pub texels: Vec<u32>,
    /// Lights of the file; may be empty (see [`light::default_light`]).
    pub lights: Vec<Light>,
    /// What rays see that leave the scene.
    pub environment: Environment,
    /// The scene's own camera; see [`Scene::view`].
    pub camera: Option<Camera>,
    /// Spheres that stand in for characters: of the built-in `spheres`, of nodes' extras, or added.
    pub proxies: Vec<Sphere>,
    /// What a file had that is not in the scene.
    pub dropped: Dropped,
    /// One line for each thing of the file that was ignored or replaced.
    pub warnings: Vec<String>,
}

/// A sphere of a character's rough shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, metres.
    pub centre: Vec3,
    /// Radius, metres, positive.
    pub radius: f32,
    /// Which character it belongs to: 0, 1, …
    pub character: u32,
    /// Albedo of what it stands in for, in [0, 1].
    pub albedo: Vec3,
}

/// Counts of what a file had that is not in the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// Triangles of no area.
    pub zero_area: u64,
    /// Primitives of points or lines.
    pub points_and_lines: u64,
    /// Vertex normals of length 0, replaced by the face's normal.
    pub zero_normals: u64,
}

/// What a scene has, as far as it decides which effects are needed. Only materials in use count.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Census {
    /// Number of triangles.
    pub triangles: u64,
    /// Number of materials in use.
    pub materials: u64,
    /// Whether some surface has a roughness below 1 or is metallic.
    pub has_gloss: bool,
    /// Whether some surface emits when it is allowed to.
    pub has_emission: bool,
    /// Whether some surface has holes.
    pub has_masked: bool,
    /// Number of point lights.
    pub points: u64,
    /// Number of spot lights.
    pub spots: u64,
    /// Number of suns.
    pub suns: u64,
    /// Whether the surroundings give light.
    pub has_environment: bool,
    /// Share of the surfaces' area that is glossy.
    pub glossy_share: f64,
    /// Share of the surfaces' area that emits when it is allowed to.
    pub emissive_share: f64,
    /// No surface reflects more of the light that arrives than this, diffusely and in its lobe.
    pub largest_albedo: f64,
    /// No surface's lobe reflects more than this.
    pub largest_specular: f64,
    /// Number of spherical proxies.
    pub proxies: u64,
}

impl Scene {
    /// A number that another scene hardly has: of its triangles, materials, textures, lights, surroundings and proxies.
    ///
    /// It may differ between versions of the compiler.
    pub fn fingerprint(&self) -> u64 {
        use std::hash::{DefaultHasher, Hash, Hasher};
        let mut hasher = DefaultHasher::new();
        bytemuck::cast_slice::<_, u8>(&self.triangles).hash(&mut hasher);
        bytemuck::cast_slice::<_, u8>(&self.materials).hash(&mut hasher);
        bytemuck::cast_slice::<_, u8>(&self.lights).hash(&mut hasher);
        self.texels.hash(&mut hasher);
        for proxy in &self.proxies {
            format!("{proxy:?}").hash(&mut hasher);
        }
        match &self.environment {
            Environment::None => {}
            Environment::Constant(c) => bytemuck::bytes_of(c).hash(&mut hasher),
            Environment::Map(map) => {
                map.width.hash(&mut hasher);
                bytemuck::cast_slice::<_, u8>(&map.data).hash(&mut hasher);
            }
        }
        hasher.finish()
    }

    /// Opens a `.glb` or `.gltf` file, or makes the built-in scene of that name (see [`BUILT_IN`]).
    ///
    /// A built-in's name wins over a file of the same name, as it has no extension. Albedo, metallic, roughness and
    /// alpha are clamped to [0, 1].
    ///
    /// # Errors
    /// One line that says what is wrong where: unknown name, unreadable or malformed file, impossible values,
    /// nothing to render, too much to address.
    pub fn open(name: &str) -> Result<Self, SceneError> {
        Self::open_at(name, 0.0)
    }

    /// Opens a scene as [`Scene::open`] does, at a moment: a file's first animation at `seconds`, over and over, with its
    /// skins; the characters of `spheres` sway.
    ///
    /// # Errors
    /// As [`Scene::open`], and for an animation that is not usable.
    pub fn open_at(name: &str, seconds: f64) -> Result<Self, SceneError> {
        let seconds = if seconds.is_finite() { seconds } else { 0.0 };
        match name {
            "cornell-box" => Ok(builtin::cornell_box(false)),
            "cornell-glossy" => Ok(builtin::cornell_box(true)),
            "spheres" => Ok(builtin::spheres(seconds)),
            _ => {
                let path = Path::new(name);
                let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
                if matches!(extension.as_str(), "glb" | "gltf") || path.is_file() {
                    gltf_file::open(path, seconds)
                } else {
                    Err(SceneError::Unknown { name: name.chars().take(200).collect() })
                }
            }
        }
    }

    /// Reads the bytes of a `.glb` or `.gltf` file at a moment; `path` is its name in messages and the place where the files that it names are looked
    /// for.
    ///
    /// # Errors
    /// As [`Scene::open_at`].
    pub fn from_gltf(bytes: Vec<u8>, path: &Path, seconds: f64) -> Result<Self, SceneError> {
        gltf_file::read(bytes, path, if seconds.is_finite() { seconds } else { 0.0 })
    }

    /// Returns the box around all triangles, metres.
    pub fn bounds(&self) -> Bounds {
        Bounds::of(&self.triangles)
    }

    /// Returns the scene's camera, or one that frames everything.
    pub fn view(&self) -> Camera {
        self.camera.unwrap_or_else(|| Camera::framing(&self.bounds()))
    }

    /// Returns what the scene has.
    pub fn census(&self) -> Census {
        let mut used = vec![false; self.materials.len()];
        for triangle in &self.triangles {
            if let Some(used) = used.get_mut(triangle.material as usize) {
                *used = true;
            }
        }
        let (mut whole, mut glossy, mut emissive) = (0.0, 0.0, 0.0);
        for triangle in &self.triangles {
            let Some(m) = self.materials.get(triangle.material as usize) else { continue };
            let own = area(triangle);
            whole += own;
            glossy += if is_glossy(m) { own } else { 0.0 };
            emissive += if is_emissive(m) { own } else { 0.0 };
        }
        let share = |part: f64| if whole > 0.0 { part / whole } else { 0.0 };
        let in_use = || self.materials.iter().zip(&used).filter(|(_, used)| **used).map(|(m, _)| m);
        let lights = |kind: u32| self.lights.iter().filter(|light| light.kind == kind).count() as u64;
        Census {
            triangles: self.triangles.len() as u64,
            materials: in_use().count() as u64,
            has_gloss: in_use().any(is_glossy),
            has_emission: in_use().any(is_emissive),
            has_masked: in_use().any(|m| m.flags & MATERIAL_MASKED != 0),
            points: lights(LIGHT_POINT),
            spots: lights(LIGHT_SPOT),
            suns: lights(LIGHT_SUN),
            has_environment: self.environment.is_lit(),
            glossy_share: share(glossy),
            emissive_share: share(emissive),
            largest_albedo: in_use().map(|m| largest_reflectance(m).0).fold(0.0, f64::max),
            largest_specular: in_use().map(|m| largest_reflectance(m).1).fold(0.0, f64::max),
            proxies: self.proxies.len() as u64,
        }
    }
}

fn is_glossy(m: &Material) -> bool {
    m.roughness < 1.0 || m.metallic > 0.0 || m.rough_size != NO_TEXTURE
}

fn is_emissive(m: &Material) -> bool {
    m.emission.truncate().max_element() > 0.0
}

/// What a material reflects in all and in its lobe at most, whatever its textures hold: those multiply by at most 1.
fn largest_reflectance(m: &Material) -> (f64, f64) {
    let base = f64::from(m.base.truncate().max_element());
    if !is_glossy(m) {
        return (base, 0.0);
    }
    // Albedo b (1 − g s) and lobe g (0.04 (1 − m) + m b): their sum is b + 0.04 g (1 − m) (1 − b) − …, at most the larger of both
    // ends over g and m in what the factors allow.
    let metallic = f64::from(m.metallic);
    let dielectric = if m.rough_size == NO_TEXTURE { 0.04 * (1.0 - metallic) } else { 0.04 };
    let rough = if m.rough_size == NO_TEXTURE { f64::from(m.roughness) } else { 0.0 };
    let gloss = 1.0 - rough.powi(4);
    ((base + gloss * dielectric * (1.0 - base)).min(1.0), gloss * (dielectric + metallic * base).min(1.0))
}

/// A triangle's area in m².
pub(crate) fn area(t: &Triangle) -> f64 {
    let [a, b, c] = [t.p0, t.p1, t.p2].map(|p| p.truncate().as_dvec3());
    0.5 * (b - a).cross(c - a).length()
}
