//! Which scene, lights, camera and backend do the options ask for?

use super::Failure;
use crate::backend::{Arithmetic, Cpu, Gpu, GpuOptions};
use crate::scene::light::{
    default_light, parse_daylight, parse_point, parse_sky, parse_sphere, parse_spot, parse_sun, parse_vector,
};
use crate::scene::{Camera, Carried, Environment, Scene, bvh::Bvh};
use crate::technique::View;
use clap::{Args, ValueEnum};
use glam::{Vec3, Vec4};
use std::path::PathBuf;
use twinlight_kernels::passes::scene::{Light, NO_TEXTURE};

/// The largest side of a picture.
const MAX_SIDE: u32 = 32_768;
/// The largest number of pixels: beyond it the buffers of one picture no longer fit into common memories.
const MAX_PIXELS: u64 = 1 << 27;

/// The scene and how it is looked at and lit.
#[derive(Args, Clone)]
pub(crate) struct SceneOptions {
    /// A .glb or .gltf file, or cornell-box, cornell-glossy, spheres
    pub scene: String,
    #[command(flatten)]
    pub look: LookOptions,
}

/// How a scene is looked at and lit.
#[derive(Args, Clone, Default, PartialEq, Debug)]
pub(crate) struct LookOptions {
    /// Picture size in pixels
    #[arg(long, default_value = "512x512", value_name = "WxH", value_parser = parse_size)]
    pub size: (u32, u32),
    /// Camera position, metres
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub eye: Option<String>,
    /// Point in the middle of the picture, metres
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub target: Option<String>,
    /// Direction upwards in the picture
    #[arg(long, value_name = "x,y,z", allow_hyphen_values = true)]
    pub up: Option<String>,
    /// Full vertical angle of view in degrees
    #[arg(long, value_name = "DEG", allow_hyphen_values = true)]
    pub fov: Option<f32>,
    /// Point light: position and radiant intensity in W/sr; repeatable
    #[arg(long, value_name = "x,y,z:R,G,B", allow_hyphen_values = true)]
    pub point: Vec<String>,
    /// Spot light: position, direction, W/sr, half angles in degrees; repeatable
    #[arg(long, value_name = "x,y,z:dx,dy,dz:R,G,B:OUTER[,INNER]", allow_hyphen_values = true)]
    pub spot: Vec<String>,
    /// Sun: the way light travels, and irradiance in W/m² on a surface that faces it; repeatable
    #[arg(long, value_name = "dx,dy,dz:R,G,B", allow_hyphen_values = true)]
    pub sun: Vec<String>,
    /// Constant radiance from all around
    #[arg(long, value_name = "R,G,B", conflicts_with = "environment", allow_hyphen_values = true)]
    pub sky: Option<String>,
    /// Sky of a clear day: the direction toward the sun, and turbidity from 2 to 10
    #[arg(long, value_name = "x,y,z[:TURBIDITY]", conflicts_with_all = ["environment", "sky"], allow_hyphen_values = true)]
    pub daylight: Option<String>,
    /// Equirectangular radiance from a file
    #[arg(long, value_name = "FILE.hdr|.exr")]
    pub environment: Option<PathBuf>,
    /// Spherical proxy: centre, radius, and albedo if not that of the surfaces near; repeatable
    #[arg(long, value_name = "x,y,z:RADIUS[:R,G,B]", allow_hyphen_values = true)]
    pub sphere: Vec<String>,
    /// Fit this many spherical proxies to the closed meshes
    #[arg(long, value_name = "N")]
    pub fit_spheres: Option<u32>,
    /// Ignore the spherical proxies of the scene
    #[arg(long)]
    pub no_scene_spheres: bool,
    /// Ignore the lights and the surroundings of the scene
    #[arg(long)]
    pub no_scene_lights: bool,
    /// Let emissive surfaces emit
    #[arg(long)]
    pub emissive: bool,
    /// Override every albedo by this grey
    #[arg(long, value_name = "A")]
    pub albedo: Option<f32>,
}

/// What the first frame of an animation chose from where things were, for all frames.
#[derive(Default)]
pub(crate) struct Kept {
    camera: Option<Camera>,
    target: Option<Vec3>,
    light: Option<Light>,
    fitted: Option<Carried>,
}

/// Where and how to compute.
#[derive(Args, Clone)]
pub(crate) struct BackendOptions {
    /// Part of the adapter's name
    #[arg(long, value_name = "NAME")]
    pub adapter: Option<String>,
    /// Arithmetic of the GPU; the CPU is always strict [default: fast for render, strict for compare]
    #[arg(long)]
    pub arithmetic: Option<ArithmeticChoice>,
    /// Worker threads of the CPU [default: one per core]
    #[arg(long, value_name = "N")]
    pub threads: Option<usize>,
}

/// `--arithmetic`.
#[derive(Clone, Copy, ValueEnum, PartialEq, Eq, Debug)]
pub(crate) enum ArithmeticChoice {
    /// The same bits as the CPU
    Strict,
    /// The driver's functions, within declared tolerances
    Fast,
}

pub(crate) fn parse_size(text: &str) -> Result<(u32, u32), String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(w, h)| Some((w.parse().ok()?, h.parse().ok()?)));
    let Some((width, height)) = parsed else {
        return Err("expected WxH in pixels, such as 1280x720".into());
    };
    if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
        return Err(format!("each side must be from 1 to {MAX_SIDE} pixels"));
    }
    if u64::from(width) * u64::from(height) > MAX_PIXELS {
        return Err(format!("at most {MAX_PIXELS} pixels in all"));
    }
    Ok((width, height))
}

impl LookOptions {
    /// The same as words of a command line, without the size.
    pub(crate) fn words(&self) -> Vec<String> {
        let mut words = Vec::new();
        let mut one = |name: &str, value: &Option<String>| {
            words.extend(value.iter().map(|v| format!("--{name}={v}")));
        };
        one("eye", &self.eye);
        one("target", &self.target);
        one("up", &self.up);
        one("fov", &self.fov.map(|x| x.to_string()));
        one("sky", &self.sky);
        one("daylight", &self.daylight);
        one("environment", &self.environment.as_ref().map(|p| p.display().to_string()));
        one("fit-spheres", &self.fit_spheres.map(|x| x.to_string()));
        one("albedo", &self.albedo.map(|x| x.to_string()));
        let many =
            [("point", &self.point), ("spot", &self.spot), ("sun", &self.sun), ("sphere", &self.sphere)];
        for (name, values) in many {
            words.extend(values.iter().map(|v| format!("--{name}={v}")));
        }
        let flags = [
            ("--no-scene-spheres", self.no_scene_spheres),
            ("--no-scene-lights", self.no_scene_lights),
            ("--emissive", self.emissive),
        ];
        words.extend(flags.into_iter().filter(|f| f.1).map(|f| f.0.to_owned()));
        words
    }
}

impl SceneOptions {
    /// Opens the scene with its lights as asked for, and its view.
    pub(crate) fn open(&self) -> Result<(Scene, View), Failure> {
        self.open_at(0.0, 0.0, &mut Kept::default())
    }

    /// Opens the scene at a moment; what the first frame chose, the others keep.
    ///
    /// The camera is turned by `degrees` around its target.
    pub(crate) fn open_at(
        &self,
        seconds: f64,
        degrees: f64,
        kept: &mut Kept,
    ) -> Result<(Scene, View), Failure> {
        let mut scene = Scene::open_at(&self.scene, seconds)?;
        if self.look.no_scene_lights {
            scene.lights.clear();
            scene.environment = Environment::None;
        }
        for text in &self.look.point {
            scene.lights.push(parse_point(text)?);
        }
        for text in &self.look.spot {
            scene.lights.push(parse_spot(text)?);
        }
        for text in &self.look.sun {
            scene.lights.push(parse_sun(text)?);
        }
        if let Some(text) = &self.look.sky {
            scene.environment = parse_sky(text)?;
        }
        if let Some(text) = &self.look.daylight {
            scene.environment = parse_daylight(text)?;
        }
        if let Some(path) = &self.look.environment {
            scene.environment = Environment::open(path)?;
        }
        if let Some(albedo) = self.look.albedo {
            override_albedo(&mut scene, albedo)?;
        }
        self.add_proxies(&mut scene, kept)?;
        let census = scene.census();
        let lit = census.has_environment || (self.look.emissive && census.has_emission);
        if scene.lights.is_empty() && !lit && !self.look.no_scene_lights {
            scene.lights.push(*kept.light.get_or_insert_with(|| default_light(&scene.bounds())));
            scene.warnings.push("the scene has no lights: a default point light was added".into());
        }
        let view = self.view(&scene, degrees, kept)?;
        Ok((scene, view))
    }

    fn add_proxies(&self, scene: &mut Scene, kept: &mut Kept) -> Result<(), Failure> {
        if self.look.no_scene_spheres {
            scene.proxies.clear();
        }
        for text in &self.look.sphere {
            let (centre, radius, albedo) = parse_sphere(text)?;
            scene.add_proxy(centre, radius, albedo);
        }
        if let Some(fitted) = &kept.fitted {
            scene.proxies.extend(fitted.in_pose(scene));
        } else if let Some(count) = self.look.fit_spheres {
            let own = scene.proxies.len();
            let fit = scene.fit_proxies(count)?;
            kept.fitted = Some(Carried::new(scene, &scene.proxies[own..]));
            scene.warnings.push(format!(
                "{} spheres fitted: they and the meshes differ by {:.1} % of the meshes' volume",
                fit.spheres,
                100.0 * fit.error
            ));
        }
        Ok(())
    }

    fn view(&self, scene: &Scene, degrees: f64, kept: &mut Kept) -> Result<View, Failure> {
        // A camera that frames the scene must not follow what moves in it.
        let mut camera = scene.camera.unwrap_or_else(|| *kept.camera.get_or_insert_with(|| scene.view()));
        if let Some(text) = &self.look.eye {
            camera.eye = parse_vector("--eye", text)?;
        }
        if let Some(text) = &self.look.target {
            camera.target = parse_vector("--target", text)?;
        } else if self.look.eye.is_some() {
            camera.target = *kept.target.get_or_insert_with(|| scene.bounds().centre());
        }
        if let Some(text) = &self.look.up {
            camera.up = parse_vector("--up", text)?;
        }
        if let Some(fov) = self.look.fov {
            camera.fov = fov;
        }
        if degrees != 0.0 {
            // From the first frame's place each time: angles do not add up rounding errors.
            let axis = camera.up.as_dvec3().normalize_or(glam::DVec3::Y);
            let turn = glam::DQuat::from_axis_angle(axis, degrees.to_radians());
            let target = camera.target.as_dvec3();
            camera.eye = (target + turn * (camera.eye.as_dvec3() - target)).as_vec3();
        }
        Ok(View::new(&camera, self.look.size.0, self.look.size.1)?)
    }
}

/// Makes every surface Lambertian with one grey albedo; holes stay.
fn override_albedo(scene: &mut Scene, albedo: f32) -> Result<(), Failure> {
    if !(0.0..=1.0).contains(&albedo) {
        return Err(Failure::Request(format!("--albedo {albedo}: give a number from 0 to 1")));
    }
    for proxy in &mut scene.proxies {
        proxy.albedo = Vec3::splat(albedo);
    }
    for m in &mut scene.materials {
        m.base = Vec4::new(albedo, albedo, albedo, m.base.w);
        m.metallic = 0.0;
        m.roughness = 1.0;
        m.rough_size = NO_TEXTURE;
        // The colour texture stays for its alpha: its colours become white.
        let (width, height) = ((m.base_size & 0xFFFF) as usize, (m.base_size >> 16) as usize);
        let first = 2 * m.base_texture as usize;
        for texel in scene.texels[first..].chunks_exact_mut(2).take(width * height) {
            texel[0] = 0xFFFF_FFFF;
            texel[1] |= 0xFFFF;
        }
    }
    Ok(())
}

/// Builds the tree on the backend's threads.
pub(crate) fn build_tree(scene: &Scene) -> Result<Bvh, Failure> {
    Ok(Bvh::build(&scene.triangles, &scene.materials)?)
}

impl BackendOptions {
    /// The same as words of a command line.
    pub(crate) fn words(&self) -> Vec<String> {
        let mut words: Vec<String> = self.adapter.iter().map(|name| format!("--adapter={name}")).collect();
        words.extend(self.arithmetic.iter().map(|a| match a {
            ArithmeticChoice::Strict => "--arithmetic=strict".to_owned(),
            ArithmeticChoice::Fast => "--arithmetic=fast".to_owned(),
        }));
        words.extend(self.threads.iter().map(|n| format!("--threads={n}")));
        words
    }

    /// Starts the CPU backend.
    pub(crate) fn cpu(&self) -> Result<Cpu, Failure> {
        if self.threads == Some(0) {
            return Err(Failure::Request("--threads 0: give at least 1".into()));
        }
        Ok(Cpu::new(self.threads)?)
    }

    /// Opens the GPU backend.
    pub(crate) fn gpu(&self, default: ArithmeticChoice) -> Result<Gpu, Failure> {
        let arithmetic = match self.arithmetic.unwrap_or(default) {
            ArithmeticChoice::Strict => Arithmetic::Strict,
            ArithmeticChoice::Fast => Arithmetic::Fast,
        };
        Ok(Gpu::new(&GpuOptions { adapter: self.adapter.clone(), arithmetic })?)
    }
}
