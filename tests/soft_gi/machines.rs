//! Are the bits the same on any number of threads and on the strict GPU, and does work follow what proxies reach?

use crate::support::*;
use crate::*;
use glam::Vec3;
use twinlight::scene::light;
use twinlight::technique::Inspection;
use twinlight::technique::gbuffer::GBuffer;
use twinlight::technique::soft_gi::{Exponential, Operator};
use twinlight_kernels::sh::UNIT;

#[test]
fn any_number_of_threads_and_the_strict_gpu_write_the_same_bits() {
    let mut gpu = strict_gpu();
    let mut s = Scene::open("spheres").unwrap();
    s.lights.push(light::point(v(0.0, 3.0, 3.0), Vec3::splat(5.0)));
    let view = view(&s.view(), 56, 40);
    for settings in [
        SoftGi::default(),
        SoftGi { order: 2, exponential: Exponential::Series, operator: Operator::Point, ..fine() },
        SoftGi { order: 3, exponential: Exponential::Taylor, operator: Operator::AveragedFit, ..fine() },
        SoftGi { order: 5, operator: Operator::Exact, receiver_scale: 4, ..SoftGi::default() },
        SoftGi { exponential: Exponential::Product, receiver_scale: 4, ..SoftGi::default() },
        SoftGi { order: 3, exponential: Exponential::Product, ..fine() },
        SoftGi { tau: 1.0, ..SoftGi::default() },
        SoftGi { exponential: Exponential::OptimalLinear, ..SoftGi::preset("paper").unwrap() },
    ] {
        let job = Job { rays: 4, ..Job::default() };
        let on =
            |threads| render_on(&mut Cpu::new(Some(threads)).unwrap(), &s, &view, &job, &settings).0.picture;
        let one = on(1);
        for threads in [2, 7] {
            assert!(same_bits(&one, &on(threads)), "{threads} threads, {settings:?}");
        }
        if let Some(gpu) = &mut gpu {
            let got = render_on(gpu, &s, &view, &job, &settings).0.picture;
            let (worst, at) = difference(&got, &one);
            assert!(same_bits(&got, &one), "{settings:?}: off by {worst:e} at pixel {at}");
        }
    }
}

#[test]
fn tiles_list_every_proxy_that_counts() {
    let s = Scene::open("spheres").unwrap();
    let view = view(&s.view(), 96, 64);
    let settings = SoftGi { shadow_reach: Some(8.0), light_reach: 2.0, ..fine() };
    let got = dumps(&s, &view, &settings, &["log-occlusion"]).remove(0);
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let world = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
    let job = Job::default();
    let mut seen = Inspection::new(&job, view.width, view.height);
    let g = GBuffer::trace(&mut cpu, &world, &view, 0..view.pixels(), &mut seen).unwrap();
    let surfaces = cpu.download(&g.surfaces);
    let table = soft_gi::log_occlusion_table(4, soft_gi::ENTRIES as usize);
    let least = sh::influence_key(8.0);
    let (mut shadowed, mut wrong) = (0, 0);
    for (surface, pixel) in surfaces.iter().zip(&got.pixels) {
        if surface.triangle == u32::MAX {
            continue;
        }
        let (p, n) = (surface.position.truncate(), surface.normal.truncate());
        let mut sum = [0.0f32; 16];
        for proxy in &s.proxies {
            let b = sh::blocker(proxy.centre, proxy.radius, p, n, sh::FADE);
            let u = sh::occlusion_key(b.alpha);
            let weight = b.weight * sh::influence_weight(u, least, 2.0);
            if weight > 0.0 {
                let zonal = sh::log_occlusion::<4>(&table, soft_gi::ENTRIES, u);
                sum = sh::add_scaled(&sum, &sh::rotate_zonal::<4, 16>(&zonal, b.direction), weight);
            }
        }
        shadowed += u32::from(sum[0] < 0.0);
        wrong += u32::from(pixel.x != -sum[0] / UNIT);
    }
    println!("{shadowed} receivers in reach, {wrong} with other sums than all proxies give");
    assert!(shadowed > 200 && wrong == 0);
}

#[test]
fn work_follows_what_proxies_reach() {
    let s = Scene::open("spheres").unwrap();
    let view = view(&s.view(), 96, 96);
    let pairs = |reach: f32, s: &Scene| {
        let settings = SoftGi { shadow_reach: Some(reach), light_reach: reach, ..fine() };
        render_on(&mut Cpu::new(Some(2)).unwrap(), s, &view, &Job::default(), &settings).1
    };
    let (short, long) = (pairs(2.0, &s), pairs(15.0, &s));
    let all = u64::from(long.proxies) * u64::from(long.receivers);
    println!("pairs: {} at η = 2, {} at 15, {all} were none culled", short.pairs, long.pairs);
    assert!(3 * short.pairs < long.pairs && 3 * long.pairs < 2 * all);
    // Proxies that nobody sees cost nothing but their tests.
    let mut more = s.clone();
    more.proxies.extend((0..400).map(|i| sphere(v(i as f32, 500.0, 0.0), 0.5, 0.5)));
    assert_eq!(pairs(2.0, &more).pairs, short.pairs);
}

#[test]
fn light_that_reaches_farther_than_shadow_is_not_cut() {
    let s = Scene::open("spheres").unwrap();
    let view = view(&s.view(), 64, 48);
    let lit = |shadow_reach| {
        let settings = SoftGi { shadow_reach: Some(shadow_reach), light_reach: 12.0, ..fine() };
        let sent = dumps(&s, &view, &settings, &["indirect"]).remove(0);
        sent.pixels.iter().filter(|p| p.max_element() > 1e-4).count()
    };
    let (short, long) = (lit(1.5), lit(30.0));
    println!("receivers with reflected light: {short} and {long}");
    assert!(short > 200 && short as f32 > 0.98 * long as f32);
}
