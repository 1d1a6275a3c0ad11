//! The strict GPU writes the CPU's file, byte by byte.

use crate::support::*;
use twinlight::backend::{Backend, Cpu, Gpu};
use twinlight::picture::Picture;
use twinlight::scene::{BUILT_IN, Scene, light};
use twinlight::technique::{Job, View, World, ambient_occlusion, direct};

fn pictures<B: Backend>(backend: &mut B, s: &Scene, view: &View, job: &Job) -> [Picture; 2] {
    let world = World::upload(backend, s, &tree(s), true).unwrap();
    let direct = direct::render(backend, &world, view, job).unwrap().picture;
    [direct, ambient_occlusion::render(backend, &world, view, job).unwrap().picture]
}

fn exr(picture: &Picture) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    picture.save(&path, 0.0).unwrap();
    std::fs::read(path).unwrap()
}

fn check(gpu: &mut Gpu, s: &Scene, width: u32, height: u32, rays: u32) {
    let view = view(&s.view(), width, height);
    let job = Job { rays, ..Job::default() };
    let cpu = pictures(&mut Cpu::new(Some(2)).unwrap(), s, &view, &job);
    let gpu = pictures(gpu, s, &view, &job);
    for (what, (a, b)) in ["direct", "ambient occlusion"].iter().zip(cpu.iter().zip(&gpu)) {
        let mean = a.mean();
        assert!(mean.is_finite() && mean.max_element() > 0.0, "{}, {what}: {mean}", s.name);
        let (worst, at) = difference(a, b);
        assert!(
            exr(a) == exr(b),
            "{}, {what}: largest difference {worst:e} at pixel {at}: cpu {}, gpu {}",
            s.name,
            a.pixels[at],
            b.pixels[at]
        );
        let mut off = a.clone();
        let last = off.pixels.len() - 1;
        off.pixels[last].z = f32::from_bits(off.pixels[last].z.to_bits() ^ 1);
        assert!(exr(&off) != exr(a), "negative control: the last bit of the last pixel");
    }
}

#[test]
fn built_in_scenes_are_the_same_file() {
    let Some(mut gpu) = strict_gpu() else { return };
    for name in BUILT_IN {
        check(&mut gpu, &Scene::open(name).unwrap(), 96, 96, 8);
    }
}

#[test]
fn large_scenes_are_the_same_file() {
    let Some(mut gpu) = strict_gpu() else { return };
    for name in ["sponza.glb", "sibenik.glb"] {
        let Some(path) = scene_file(name) else { continue };
        let mut s = Scene::open(path.to_str().unwrap()).unwrap();
        s.lights = vec![light::default_light(&s.bounds())];
        check(&mut gpu, &s, 160, 120, 2);
    }
}
