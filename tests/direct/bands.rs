//! A picture of several bands is the picture that one band would be.

use crate::support::*;
use crate::{direct_light, openness};
use glam::Vec4;
use twinlight::backend::{Backend, Cpu};
use twinlight::scene::{Environment, Scene};
use twinlight::technique::gbuffer::{BAND_PIXELS, GBuffer, bands};
use twinlight::technique::reference::{Bounces, Reference};
use twinlight::technique::{Inspection, Job, View, World};
use twinlight_kernels::passes::elements::GatherParams;

/// Two bands, the seam between them in the middle of a row.
fn two_bands(s: &Scene) -> View {
    let view = view(&s.view(), 1500, 1000);
    let ranges: Vec<_> = bands(&view).collect();
    assert_eq!(ranges, [0..BAND_PIXELS, BAND_PIXELS..1_500_000]);
    assert_ne!(BAND_PIXELS % 1500, 0);
    view
}

#[test]
fn lights_do_not_show_the_seam() {
    let s = Scene::open("cornell-box").unwrap();
    let view = two_bands(&s);
    let technique = direct_light(&s, &view, &Job::default(), false);
    let reference = Reference { emissive: false, ..settings(Bounces::Count(0), 1) };
    let right = trace(&s, &view, &reference).all();
    let (worst, at) = difference(&technique, &right);
    assert!(worst < 1e-5, "pixel {at}: {worst:e}");
    let mut shifted = technique;
    shifted.pixels[BAND_PIXELS as usize..].rotate_right(1);
    assert!(difference(&shifted, &right).0 > 1e-3, "negative control: the second band off by a pixel");
}

#[test]
fn rays_all_around_do_not_show_the_seam() {
    let mut s = Scene::open("cornell-box").unwrap();
    s.environment = Environment::Constant(glam::Vec3::ONE);
    s.lights.clear();
    let view = two_bands(&s);
    let job = Job { rays: 1, seed: 7, ..Job::default() };
    let occlusion = openness(&s, &view, &job);
    let sky = direct_light(&s, &view, &job, false);

    // A band of its own across the seam gives the same bits.
    let range = BAND_PIXELS - 2000..BAND_PIXELS + 2000;
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let w = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
    let mut seen = Inspection::new(&job, view.width, view.height);
    let g = GBuffer::trace(&mut cpu, &w, &view, range.clone(), &mut seen).unwrap();
    let mut gather = |first_pixel: u32| {
        let params =
            GatherParams { rays: job.rays, seed: job.seed, reach: job.reach, first_pixel, ..w.environment };
        let count = g.count();
        let mut open = Backend::alloc(&mut cpu, "openness", count as usize).unwrap();
        Backend::ambient_openness(
            &mut cpu,
            &params,
            &g.surfaces,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut open,
            count,
        )
        .unwrap();
        let black = Backend::upload(&mut cpu, "black", &vec![Vec4::ZERO; count as usize]).unwrap();
        let mut radiance = Backend::alloc(&mut cpu, "radiance", count as usize).unwrap();
        Backend::gather_direct(
            &mut cpu,
            &params,
            &g.surfaces,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &black,
            &mut radiance,
            count,
        )
        .unwrap();
        (cpu.download(&open), cpu.download::<Vec4>(&radiance))
    };
    let pixels = range.start as usize..range.end as usize;
    let same = |(open, radiance): &(Vec<f32>, Vec<Vec4>)| {
        let seen = |i: usize| g.surfaces.as_slice()[i].position.w >= 0.0;
        occlusion.pixels[pixels.clone()].iter().zip(open).all(|(p, o)| p.x == *o)
            && (sky.pixels[pixels.clone()].iter().zip(radiance).enumerate())
                .all(|(i, (p, r))| !seen(i) || *p == r.truncate())
    };
    assert!(same(&gather(range.start)));
    assert!(!same(&gather(0)), "negative control: directions of another band");
}
