//! Do shadows and light of spherical proxies agree with rays, stay in range in hard cases, and give the same bits everywhere?

#[path = "../support/mod.rs"]
mod support;

mod light;
mod machines;
mod robust;

use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use support::*;
use twinlight::backend::{Backend, Cpu};
use twinlight::picture::Picture;
use twinlight::scene::{Scene, Sphere};
use twinlight::technique::soft_gi::{self, Counts, SoftGi, Surroundings};
use twinlight::technique::{Job, LightPart, Rendered, View, World};
use twinlight_kernels::sh;

fn render_on<B: Backend>(
    backend: &mut B,
    scene: &Scene,
    view: &View,
    job: &Job,
    settings: &SoftGi,
) -> (Rendered, Counts) {
    let world = World::upload(backend, scene, &tree(scene), false).unwrap();
    soft_gi::render(backend, &world, &Surroundings::new(scene), view, job, settings).unwrap()
}

/// A receiver for each pixel.
fn fine() -> SoftGi {
    SoftGi { receiver_scale: 1, ..SoftGi::default() }
}

/// A picture's buffers by name, on the CPU.
fn dumps(scene: &Scene, view: &View, settings: &SoftGi, names: &[&str]) -> Vec<Picture> {
    let job = Job { dumps: names.iter().map(|&n| n.to_owned()).collect(), ..Job::default() };
    let (mut rendered, _) = render_on(&mut Cpu::new(Some(2)).unwrap(), scene, view, &job, settings);
    names.iter().map(|&n| rendered.dumps.remove(n).unwrap()).collect()
}

fn sphere(centre: Vec3, radius: f32, albedo: f32) -> Sphere {
    Sphere { centre, radius, character: 0, albedo: Vec3::splat(albedo) }
}

/// A large white floor at y = 0 with these proxies, and nothing else that could be seen.
fn floor_with(proxies: Vec<Sphere>) -> Scene {
    let mut s = scene();
    square(&mut s, 0.0, 20.0, true, grey(1.0));
    s.proxies = proxies;
    s
}

/// Looks at the floor around the origin from above.
fn above(side: u32) -> View {
    view(&camera(v(0.0, 6.0, 0.01), Vec3::ZERO, 50.0), side, side)
}

/// What a floor point receives, by rays: irradiance/π past the spheres, and by way of them, each lit without shadow.
struct Traced {
    past: DVec3,
    sent: DVec3,
}

/// Traces `count` cosine-distributed rays from a floor point to the spheres themselves, under the light of `order`.
fn trace_floor(s: &Scene, around: &Surroundings, order: u32, point: DVec3, count: u32) -> Traced {
    let mut all = Traced { past: DVec3::ZERO, sent: DVec3::ZERO };
    let irradiance: Vec<[f32; 9]> =
        (0..3).map(|c| sh::irradiance::<3, 9>(&std::array::from_fn(|i| around.radiance[c][i]))).collect();
    for i in 0..count {
        let r = ((f64::from(i) + 0.5) / f64::from(count)).sqrt();
        let (sine, cosine) = (2.399_963_229_728_653 * f64::from(i)).sin_cos();
        let d = DVec3::new(r * cosine, (1.0 - r * r).sqrt(), r * sine);
        let mut nearest = (f64::INFINITY, None);
        for p in &s.proxies {
            let (c, radius) = (p.centre.as_dvec3() - point, f64::from(p.radius));
            let along = c.dot(d);
            let under = radius * radius - (c - d * along).length_squared();
            if under > 0.0 && along - under.sqrt() > 0.0 && along - under.sqrt() < nearest.0 {
                nearest = (along - under.sqrt(), Some(p));
            }
        }
        match nearest {
            (_, None) => all.past += around.seen(order, d.as_vec3()).as_dvec3(),
            (t, Some(p)) => {
                let normal = ((point + d * t) - p.centre.as_dvec3()) / f64::from(p.radius);
                let basis = sh::basis::<9>(normal.as_vec3());
                let of = |c: usize| f64::from(sh::dot(&irradiance[c], &basis)).max(0.0);
                all.sent += DVec3::new(of(0), of(1), of(2)) * p.albedo.as_dvec3() / PI;
            }
        }
    }
    Traced { past: all.past / f64::from(count), sent: all.sent / f64::from(count) }
}

/// The same for every pixel of a view of the floor.
fn traced(s: &Scene, order: u32, view: &View, count: u32) -> (Picture, Picture) {
    use rayon::prelude::*;
    let around = Surroundings::new(s);
    let all: Vec<Traced> = (0..view.pixels())
        .into_par_iter()
        .map(|i| {
            let (x, y) = (f64::from(i % view.width) + 0.5, f64::from(i / view.width) + 0.5);
            trace_floor(s, &around, order, floor_point(view, x, y), count)
        })
        .collect();
    let picture = |f: fn(&Traced) -> DVec3| Picture {
        width: view.width,
        height: view.height,
        pixels: all.iter().map(|t| f(t).as_vec3()).collect(),
    };
    (picture(|t| t.past), picture(|t| t.sent))
}

fn indirect_job() -> Job {
    Job { light: LightPart::Indirect, ..Job::default() }
}
