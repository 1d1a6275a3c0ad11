//! Do the bounds of what is left out hold against the path tracer, as power that leaves all surfaces?

use crate::support::{scene_file, settings, tree, v};
use glam::{Vec3, Vec4};
use twinlight::plan::Effect;
use twinlight::scene::{Camera, Environment, Scene, bvh::Bvh, light};
use twinlight::technique::View;
use twinlight::technique::reference::{self, Bounces};
use twinlight_kernels::passes::scene::NO_TEXTURE;
use twinlight_kernels::sampling::hash::{hash, unit_float};

/// Radiance of each look: reflected first, once more, and ever after. Their means are the power that leaves surfaces per area.
struct Power(Vec<[f64; 3]>);

impl Power {
    fn mean(&self, of: impl Fn(&[f64; 3]) -> f64) -> f64 {
        self.0.iter().map(of).sum::<f64>() / self.0.len() as f64
    }

    /// The standard error of that mean.
    fn error(&self, of: impl Fn(&[f64; 3]) -> f64 + Copy) -> f64 {
        let mean = self.mean(of);
        (self.mean(|v| (of(v) - mean).powi(2)) / self.0.len() as f64).sqrt()
    }
}

/// Points of all surfaces by area, each seen from a direction by its cosine over both sides.
fn looks(s: &Scene, count: u32) -> Vec<View> {
    let area = |i: usize| {
        let t = &s.triangles[i];
        let [a, b, c] = [t.p0, t.p1, t.p2].map(Vec4::truncate);
        0.5 * f64::from((b - a).cross(c - a).length())
    };
    let mut ends = Vec::new();
    let mut sum = 0.0;
    for i in 0..s.triangles.len() {
        sum += area(i);
        ends.push(sum);
    }
    let small = 1e-3 * s.bounds().size().max_element();
    (0..count)
        .map(|n| {
            let r = |k: u32| unit_float(hash(9 * n + k));
            let at = (f64::from(n) + f64::from(r(0))) / f64::from(count) * sum;
            let t = &s.triangles[ends.partition_point(|&e| e < at).min(ends.len() - 1)];
            let [a, b, c] = [t.p0, t.p1, t.p2].map(Vec4::truncate);
            let (x, y) = (r(1).sqrt(), r(2));
            let p = a * (1.0 - x) + b * (x * (1.0 - y)) + c * (x * y);
            let n = (b - a).cross(c - a).normalize() * if r(3) < 0.5 { 1.0 } else { -1.0 };
            let (sin, cos) = (std::f32::consts::TAU * r(4)).sin_cos();
            let (right, up) = n.any_orthonormal_pair();
            let q = r(5);
            let d = n * (1.0 - q).sqrt() + (right * cos + up * sin) * q.sqrt();
            let camera = Camera {
                eye: p + d * small,
                target: p,
                up: if d.y.abs() > 0.9 { Vec3::X } else { Vec3::Y },
                fov: 1.0,
            };
            View::new(&camera, 1, 1).unwrap()
        })
        .collect()
}

fn power(s: &Scene, tree: &Bvh, looks: &[View]) -> Power {
    let stop = std::sync::atomic::AtomicBool::new(false);
    let mut values: Vec<[f64; 3]> = Vec::new();
    for (number, view) in looks.iter().enumerate() {
        let of = |bounces| {
            let settings = reference::Reference {
                emissive: false,
                pixel_filter: false,
                seed: number as u32,
                ..settings(bounces, 8)
            };
            let r = reference::render(s, tree, view, &settings, &stop, |_| ());
            let mean = |p: &twinlight::picture::Picture| f64::from(p.pixels[0].element_sum()) / 3.0;
            (mean(&r.direct), mean(&r.indirect))
        };
        let (first, once) = of(Bounces::Count(1));
        values.push([first, once, of(Bounces::All).1 - once]);
    }
    Power(values)
}

/// The same surfaces, without lobes; `white` reflects all.
fn matte(s: &Scene, white: bool) -> Scene {
    let mut s = s.clone();
    for m in &mut s.materials {
        let gloss = if m.roughness < 1.0 { 1.0 - m.roughness.powi(4) } else { 0.0 };
        let share = m.metallic + 0.04 * (1.0 - m.metallic);
        m.base = if white { Vec4::ONE } else { (m.base.truncate() * (1.0 - gloss * share)).extend(m.base.w) };
        (m.metallic, m.roughness, m.rough_size) = (0.0, 1.0, NO_TEXTURE);
        if white {
            m.base_size = NO_TEXTURE;
        }
    }
    s
}

fn subjects() -> Vec<(Scene, u32)> {
    let mut all: Vec<(Scene, u32)> = Vec::new();
    for name in ["cornell-box", "cornell-glossy"] {
        let mut s = Scene::open(name).unwrap();
        // Some way from the ceiling: what is close to a light has nearly all of its power, and few points.
        s.lights = vec![light::point(v(0.0, 1.4, 0.6), Vec3::ONE)];
        all.push((s, 2500));
    }
    let mut spheres = Scene::open("spheres").unwrap();
    spheres.environment = Environment::Constant(Vec3::ONE);
    all.push((spheres, 400));
    let sun = light::sun(v(0.25, -1.0, 0.15).normalize(), v(12.0, 11.0, 9.5));
    let lamp = light::point(v(0.0, 8.0, 0.0), v(120.0, 115.0, 100.0));
    let low = light::point(v(0.0, 1.4, 0.6), Vec3::ONE);
    let cornell =
        ["original", "glossy", "sphere", "empty-co", "empty-rg"].map(|n| format!("cornell-{n}.glb"));
    for name in &cornell {
        if let Some(path) = scene_file(name) {
            let s = Scene::open(path.to_str().unwrap()).unwrap();
            all.push((Scene { lights: vec![low], environment: Environment::None, ..s }, 600));
        }
    }
    for (name, lamp) in [("sponza.glb", sun), ("sibenik.glb", lamp), ("dragon.glb", sun)] {
        if let Some(path) = scene_file(name) {
            let s = Scene::open(path.to_str().unwrap()).unwrap();
            all.push((Scene { lights: vec![lamp], environment: Environment::None, ..s }, 400));
        }
    }
    all
}

#[test]
fn bounces_add_no_more_than_their_bounds() {
    let mut broken = 0;
    for (s, count) in subjects() {
        let tree = tree(&s);
        let p = power(&s, &tree, &looks(&s, count));
        let census = s.census();
        for (effect, k) in [(Effect::Bounce, 1), (Effect::FurtherBounces, 2)] {
            let (first, own) = (p.mean(|v| v[0]), p.mean(|v| v[k]));
            let Some(bound) = effect.bound(&census) else {
                println!(
                    "{}: {} adds {:.3} of the light reflected first, unbounded",
                    s.name,
                    effect.name(),
                    own / first
                );
                continue;
            };
            let over = |limit: f64| (p.mean(|v| v[k] - limit * v[0]), p.error(|v| v[k] - limit * v[0]));
            let (excess, error) = over(bound.share);
            println!(
                "{}: {} adds {:.3} of the light reflected first, {bound}: {:.1} standard errors below",
                s.name,
                effect.name(),
                own / first,
                -excess / error
            );
            assert!(excess <= 3.0 * error, "{}: {} adds {}", s.name, effect.name(), own / first);
            let (excess, error) = over(0.3 * bound.share);
            broken += u32::from(effect == Effect::Bounce && excess > error);
        }
    }
    // Planted fault: a bound of a third of that is broken.
    assert!(broken > 0, "the bounds are so far that nothing comes near");
}

#[test]
fn gloss_adds_no_more_than_its_bound() {
    let mut s = Scene::open("cornell-glossy").unwrap();
    s.lights = vec![light::point(v(0.0, 1.4, 0.6), Vec3::ONE)];
    let looks = looks(&s, 4000);
    let [all, diffuse, arriving] =
        [s.clone(), matte(&s, false), matte(&s, true)].map(|s| power(&s, &tree(&s), &looks));
    let first = |p: &Power| p.mean(|v| v[0]);
    let share = (first(&all) - first(&diffuse)) / first(&arriving);
    let bound = Effect::Gloss.bound(&s.census()).unwrap().share;
    println!("lobes reflect {share:.3} of the light that arrives, at most {bound:.3}");
    assert!(share <= bound + 0.02 && share > 0.02, "{share}");
}
