//! Which small scenes, views and comparisons do several test files need?
//!
//! Not every file uses every helper.
#![allow(dead_code)]

use glam::{DVec3, Vec3, Vec4};
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use twinlight::backend::{Arithmetic, Gpu, GpuOptions};
use twinlight::picture::Picture;
use twinlight::scene::bvh::Bvh;
use twinlight::scene::{Camera, Scene};
use twinlight::technique::View;
use twinlight::technique::reference::{self, Bounces, Reference, ReferenceResult, Statistics};
use twinlight_kernels::passes::scene::{MATERIAL_MASKED, Material, Triangle};

/// Shorthand for a vector.
pub fn v(x: f32, y: f32, z: f32) -> Vec3 {
    Vec3::new(x, y, z)
}

/// A Lambertian grey.
pub fn grey(albedo: f32) -> Material {
    Material { base: Vec4::new(albedo, albedo, albedo, 1.0), roughness: 1.0, ..Material::default() }
}

/// A Lambertian grey whose front face emits.
pub fn emitter(albedo: f32, radiance: f32) -> Material {
    Material { emission: Vec3::splat(radiance).extend(0.0), ..grey(albedo) }
}

/// A metal of this grey and roughness.
pub fn metal(base: f32, roughness: f32) -> Material {
    Material { metallic: 1.0, roughness, ..grey(base) }
}

/// A grey sheet that alpha makes a hole, or, with `alpha` 1, leaves whole.
pub fn masked(alpha: f32) -> Material {
    let mut m = grey(0.5);
    m.base.w = alpha;
    Material { flags: MATERIAL_MASKED, cutoff: 0.5, ..m }
}

/// An empty scene, to be filled with [`quad`].
pub fn scene() -> Scene {
    Scene { name: "test".into(), ..Scene::default() }
}

/// Adds a flat quadrilateral of its own material, counter-clockwise from its front.
pub fn quad(scene: &mut Scene, p: [Vec3; 4], material: Material) {
    let n = (p[1] - p[0]).cross(p[3] - p[0]).normalize().extend(0.0);
    let index = scene.materials.len() as u32;
    scene.materials.push(material);
    for [a, b, c] in [[p[0], p[1], p[2]], [p[0], p[2], p[3]]] {
        scene.triangles.push(Triangle {
            p0: a.extend(0.0),
            p1: b.extend(0.0),
            p2: c.extend(0.0),
            n0: n,
            n1: n,
            n2: n,
            material: index,
            ..Triangle::default()
        });
    }
}

/// Adds a horizontal square of half side `half` at height `y`, its front up or down.
pub fn square(scene: &mut Scene, y: f32, half: f32, up: bool, material: Material) {
    let mut p = [v(-half, y, half), v(half, y, half), v(half, y, -half), v(-half, y, -half)];
    if !up {
        p.swap(1, 3);
    }
    quad(scene, p, material);
}

/// Adds a closed box of half size `half` whose faces look inwards, turned about two axes by `turn` radians.
pub fn room(scene: &mut Scene, half: Vec3, turn: f32, material: Material) {
    let rotation = glam::Mat3::from_rotation_y(turn) * glam::Mat3::from_rotation_x(0.7 * turn);
    // Bits x, y, z of the index: upper or lower end.
    let at = |i: u32| {
        let end = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        rotation * (half * v(end(0), end(1), end(2)))
    };
    for face in [[0, 2, 6, 4], [5, 7, 3, 1], [4, 6, 7, 5], [1, 3, 2, 0], [6, 2, 3, 7], [0, 4, 5, 1]] {
        quad(scene, face.map(at), material);
    }
}

/// A scene turned, then made `scale` times as large, then moved, lit so that it looks the same, and its mapped camera.
pub fn mapped(scene: &Scene, turn: glam::Mat3, scale: f32, shift: Vec3) -> (Scene, Camera) {
    let mut s = scene.clone();
    let point = |p: Vec3| turn * p * scale + shift;
    for t in &mut s.triangles {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p = point(p.truncate()).extend(p.w);
        }
        for n in [&mut t.n0, &mut t.n1, &mut t.n2] {
            *n = (turn * n.truncate()).extend(n.w);
        }
    }
    for l in &mut s.lights {
        l.position = point(l.position.truncate()).extend(0.0);
        l.direction = (turn * l.direction.truncate()).extend(0.0);
        l.intensity *= scale * scale;
    }
    for p in &mut s.proxies {
        (p.centre, p.radius) = (point(p.centre), p.radius * scale);
    }
    let c = scene.view();
    let camera = Camera { eye: point(c.eye), target: point(c.target), up: turn * c.up, fov: c.fov };
    (s, camera)
}

/// A camera at `eye` that looks at `target`; up is +y unless that is where it looks.
pub fn camera(eye: Vec3, target: Vec3, fov: f32) -> Camera {
    let along = (target - eye).normalize();
    Camera { eye, target, up: if along.y.abs() > 0.999 { Vec3::NEG_Z } else { Vec3::Y }, fov }
}

/// The view of a camera onto a picture.
pub fn view(camera: &Camera, width: u32, height: u32) -> View {
    View::new(camera, width, height).unwrap()
}

/// The tree of a scene.
pub fn tree(scene: &Scene) -> Bvh {
    Bvh::build(&scene.triangles, &scene.materials).unwrap()
}

/// Settings of a reference through pixel centres.
pub fn settings(bounces: Bounces, samples: u32) -> Reference {
    Reference { bounces, samples, emissive: true, pixel_filter: false, ..Reference::default() }
}

/// Renders a reference to its end.
pub fn trace(scene: &Scene, view: &View, settings: &Reference) -> ReferenceResult {
    reference::render(scene, &tree(scene), view, settings, &AtomicBool::new(false), |_| ())
}

/// How many standard errors lie between a mean and what it should be; 1e-5 of the value is left to rounding.
pub fn sigmas(s: &Statistics, expected: f64) -> f64 {
    let mean = (s.mean.x + s.mean.y + s.mean.z) / 3.0;
    assert!(mean.is_finite() && s.standard_error.is_finite(), "{s:?}");
    ((mean - expected).abs() - 1e-5 * expected.abs()).max(0.0) / s.standard_error.max(1e-12)
}

/// Checks a mean within four standard errors, and that a value off by `fault` would be noticed.
pub fn assert_mean(what: &str, s: &Statistics, expected: f64, fault: f64) {
    let off = sigmas(s, expected);
    println!("{what}: {:.6} ± {:.6}, expected {expected:.6}: {off:.2} sigma", s.mean.x, s.standard_error);
    assert!(off <= 4.0, "{what}: {} ± {} is {off} sigma from {expected}", s.mean, s.standard_error);
    let caught = sigmas(s, expected * (1.0 + fault)).min(sigmas(s, expected * (1.0 - fault)));
    assert!(caught > 4.0, "{what}: negative control: {fault} more or less would pass at {caught} sigma");
}

/// The largest relative difference of two pictures' colours, and the pixel where it is.
pub fn difference(a: &Picture, b: &Picture) -> (f64, usize) {
    assert_eq!((a.width, a.height, a.pixels.len()), (b.width, b.height, b.pixels.len()));
    let mut worst = (0.0, 0);
    for (i, (a, b)) in a.pixels.iter().zip(&b.pixels).enumerate() {
        for (a, b) in a.to_array().into_iter().zip(b.to_array()) {
            let off = relative(a, f64::from(b));
            if off > worst.0 {
                worst = (off, i);
            }
        }
    }
    worst
}

/// The relative difference from what a value should be; not finite is infinitely far.
pub fn relative(got: f32, expected: f64) -> f64 {
    if !got.is_finite() {
        return f64::INFINITY;
    }
    (f64::from(got) - expected).abs() / expected.abs().max(1e-9)
}

/// Whether two pictures are the same bits.
pub fn same_bits(a: &Picture, b: &Picture) -> bool {
    let bits =
        |p: &Picture| -> Vec<[u32; 3]> { p.pixels.iter().map(|c| c.to_array().map(f32::to_bits)).collect() };
    (a.width, a.height) == (b.width, b.height) && bits(a) == bits(b)
}

/// Where the ray through a point of the picture meets the plane y = 0, in double precision.
pub fn floor_point(view: &View, x: f64, y: f64) -> DVec3 {
    let f = &view.frame;
    let (w, h, t) = (f64::from(view.width), f64::from(view.height), f64::from(f.tan_half_fov));
    let direction = f.right.as_dvec3() * ((2.0 * x / w - 1.0) * (w / h) * t)
        + f.up.as_dvec3() * ((1.0 - 2.0 * y / h) * t)
        + f.forward.as_dvec3();
    let eye = f.eye.as_dvec3();
    eye - direction * (eye.y / direction.y)
}

/// A GPU with the CPU's bits; without one a visible skip, or a failure where `TWINLIGHT_REQUIRE_GPU` is 1.
pub fn strict_gpu() -> Option<Gpu> {
    match Gpu::new(&GpuOptions { arithmetic: Arithmetic::Strict, ..Default::default() }) {
        Ok(gpu) => Some(gpu),
        Err(e) => {
            let required = std::env::var("TWINLIGHT_REQUIRE_GPU").is_ok_and(|x| x == "1");
            assert!(!required, "TWINLIGHT_REQUIRE_GPU is 1, but {e}");
            eprintln!("skipped: {e}");
            None
        }
    }
}

/// A test scene's file in `TWINLIGHT_SCENES`, or in `shared/scenes` beside the workspace; otherwise a visible skip.
pub fn scene_file(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    let folder = std::env::var_os("TWINLIGHT_SCENES").map_or_else(beside, PathBuf::from);
    let path = folder.join(name);
    if path.is_file() {
        return Some(path);
    }
    eprintln!("skipped: {} is not there; set TWINLIGHT_SCENES to the folder of test scenes", path.display());
    None
}
