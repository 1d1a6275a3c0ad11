//! Do shadows and reflected light agree with rays to the spheres, and with the path tracer's meshes?

use crate::support::*;
use crate::*;
use glam::Vec3;
use twinlight::report::error::picture_error;
use twinlight::scene::{Environment, EnvironmentMap};
use twinlight::technique::reference::{Bounces, Reference};
use twinlight::technique::soft_gi::{Exponential, Operator};

/// A sky that is brighter on one side: what order 4 can say, and more.
fn sky() -> Environment {
    let radiance = |d: Vec3| {
        let lobe = d.dot(Vec3::new(1.0, 1.2, 0.8).normalize()).max(0.0).powi(8);
        Vec3::new(0.4, 0.5, 0.8) + Vec3::new(5.0, 4.0, 3.0) * lobe
    };
    EnvironmentMap::from_directions(64, 32, radiance).map(Environment::Map).unwrap()
}

/// A few balls over the floor, apart from each other, some near it, some touching it.
fn balls() -> Scene {
    let mut s = floor_with(vec![
        sphere(v(0.0, 0.6, 0.0), 0.5, 0.8),
        sphere(v(1.2, 0.4, 0.5), 0.4, 0.5),
        sphere(v(-1.0, 0.9, -0.6), 0.3, 0.9),
        sphere(v(-0.5, 0.25, 1.1), 0.25, 0.3),
    ]);
    s.environment = sky();
    s
}

#[test]
fn shadows_agree_with_rays() {
    let (s, view) = (balls(), above(40));
    let mut errors = Vec::new();
    for order in [3, 4, 5] {
        let settings = SoftGi { order, shadow_reach: Some(40.0), ..fine() };
        let got = dumps(&s, &view, &settings, &["shadowed"]).remove(0);
        let right = traced(&s, order, &view, 4096).0;
        let e = picture_error(&got, &right).unwrap();
        println!("order {order}: RMSE {:.2} %, mean {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        assert!((e.mean_ratio - 1.0).abs() < 0.006 && e.relative_rmse < 0.03, "order {order}: {e:?}");
        errors.push(e.relative_rmse);
        let bare = Scene { proxies: vec![], ..s.clone() };
        let lit = dumps(&bare, &view, &settings, &["shadowed"]).remove(0);
        let without = picture_error(&lit, &right).unwrap();
        assert!(without.relative_rmse > 2.0 * e.relative_rmse, "negative control: {without:?}");
    }
}

#[test]
fn the_operators_get_nearer_as_they_cost_more() {
    let (s, view) = (balls(), above(40));
    let right = traced(&s, 4, &view, 4096).1;
    let with = |operator| {
        let settings = SoftGi { operator, light_reach: 40.0, ..fine() };
        let got = dumps(&s, &view, &settings, &["indirect"]).remove(0);
        let e = picture_error(&got, &right).unwrap();
        println!("{operator:?}: RMSE {:.1} %, mean {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        e
    };
    let (point, fit) = (with(Operator::Point), with(Operator::AveragedFit));
    let (averaged, exact) = (with(Operator::Averaged), with(Operator::Exact));
    assert!(exact.relative_rmse < averaged.relative_rmse && averaged.relative_rmse < point.relative_rmse);
    assert!((fit.relative_rmse - averaged.relative_rmse).abs() < 0.02);
    assert!((exact.mean_ratio - 1.0).abs() < 0.1 && exact.relative_rmse < 0.25, "{exact:?}");
}

#[test]
fn exponentials_and_the_product_agree_with_rays_where_balls_overlap() {
    // Balls one behind the other as seen from the floor's middle.
    let mut s = floor_with((0..8).map(|i| sphere(v(0.2, 0.8 + 0.35 * i as f32, 0.1), 0.5, 0.0)).collect());
    s.environment = Environment::Constant(Vec3::ONE);
    let view = above(24);
    let right = traced(&s, 4, &view, 4096).0;
    let with = |exponential, tau, terms| {
        let settings = SoftGi { exponential, tau, terms, shadow_reach: Some(40.0), ..fine() };
        let got = dumps(&s, &view, &settings, &["shadowed"]).remove(0);
        let e = picture_error(&got, &right).unwrap();
        println!("{exponential:?} {tau} {terms}: {:.2} %, {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        e.relative_rmse
    };
    let hybrid = with(Exponential::Hybrid, 0.5, 9);
    let finer = with(Exponential::Hybrid, 0.125, 9);
    let taylor = with(Exponential::Taylor, 1.0, 9);
    let linear = with(Exponential::OptimalLinear, 0.5, 9);
    let series = with(Exponential::Series, 0.5, 3);
    let coarser = with(Exponential::Hybrid, 1.0, 9);
    let product = with(Exponential::Product, 0.5, 9);
    assert!(product < 0.12 && coarser < 0.12 && coarser != hybrid, "{product}, {coarser}");
    assert!(hybrid < 0.12 && finer < 0.12 && taylor < 0.12, "{hybrid}, {finer}, {taylor}");
    assert!(linear > hybrid && series > hybrid, "negative controls: {linear}, {series}");
}

#[test]
fn a_white_ball_under_an_even_sky_is_as_bright_as_the_sky() {
    // What it takes, it gives back: irradiance/π stays 1 near one white ball, and near two that overlap.
    for proxies in [
        vec![sphere(v(0.0, 0.8, 0.0), 0.5, 1.0)],
        vec![sphere(v(0.0, 0.8, 0.0), 0.5, 1.0), sphere(v(0.1, 0.9, 0.1), 0.5, 1.0)],
    ] {
        let mut s = floor_with(proxies);
        s.environment = Environment::Constant(Vec3::ONE);
        let settings = SoftGi { shadow_reach: Some(10.0), light_reach: 10.0, ..fine() };
        let all = dumps(&s, &above(32), &settings, &["shadowed", "indirect"]);
        let mut worst = 0.0f32;
        for (past, sent) in all[0].pixels.iter().zip(&all[1].pixels) {
            worst = worst.max((past.x + sent.x - 1.0).abs());
        }
        let darkest = all[0].pixels.iter().fold(1.0f32, |a, p| a.min(p.x));
        println!("{} balls: sum off by {worst:.3}, darkest without {darkest:.3}", s.proxies.len());
        assert!(worst < 0.03, "{worst}");
        assert!(darkest < 0.75, "negative control: the ball's shadow is not there");
    }
}

#[test]
fn characters_agree_with_the_path_tracers_meshes() {
    let s = Scene::open("spheres").unwrap();
    let order = 4;
    let smooth = Scene { environment: Surroundings::new(&s).as_environment(order, 128), ..s.clone() };
    let view = view(&s.view(), 64, 64);
    let settings = Reference { emissive: false, ..settings(Bounces::Count(1), 1024) };
    let right = trace(&smooth, &view, &settings);
    let job = Job { light: LightPart::All, ..Job::default() };
    let all = render_on(&mut Cpu::new(Some(2)).unwrap(), &smooth, &view, &job, &fine()).0.picture;
    let both = Picture {
        pixels: right.direct.pixels.iter().zip(&right.indirect.pixels).map(|(a, b)| *a + *b).collect(),
        ..right.direct.clone()
    };
    let e = picture_error(&all, &both).unwrap();
    let bare = Scene { proxies: vec![], ..smooth.clone() };
    let lit = render_on(&mut Cpu::new(Some(2)).unwrap(), &bare, &view, &job, &fine()).0.picture;
    let without = picture_error(&lit, &both).unwrap();
    println!("{e:?}\nwithout proxies {without:?}");
    assert!((e.mean_ratio - 1.0).abs() < 0.02 && e.relative_rmse < 0.08, "{e:?}");
    assert!(without.relative_rmse > 1.3 * e.relative_rmse, "negative control");
    // Reflected light on the floor: characters alone send it there. (On characters the path tracer has the floor's too.)
    let indirect = render_on(&mut Cpu::new(Some(2)).unwrap(), &smooth, &view, &indirect_job(), &fine());
    let place = dumps(&smooth, &view, &fine(), &["position"]).remove(0);
    let on_floor = |p: &Picture| -> f32 {
        p.pixels.iter().zip(&place.pixels).filter(|(_, at)| at.y.abs() < 1e-3).map(|(p, _)| p.y).sum()
    };
    let ratio = on_floor(&indirect.0.picture) / on_floor(&right.indirect);
    println!("reflected light on the floor: {ratio:.3} of the path tracer's");
    assert!((0.7..1.4).contains(&ratio), "{ratio}");
}

#[test]
fn coarse_receivers_are_near_fine_ones() {
    let s = Scene::open("spheres").unwrap();
    let view = view(&s.view(), 128, 128);
    let at = |receiver_scale| {
        let settings = SoftGi { receiver_scale, ..SoftGi::default() };
        render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &Job::default(), &settings).0.picture
    };
    let right = at(1);
    let mut before = 0.0;
    for scale in [2, 4, 8] {
        let e = picture_error(&at(scale), &right).unwrap();
        println!("receivers at 1/{scale}: RMSE {:.2} %, mean {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        assert!(e.relative_rmse < 0.06 && (e.mean_ratio - 1.0).abs() < 0.01, "{e:?}");
        assert!(e.relative_rmse > before, "negative control: coarser is no worse");
        before = e.relative_rmse;
    }
}

#[test]
fn what_does_not_overlap_is_not_taken_away() {
    // One ball: nothing overlaps, whatever the reaches of shadow and light are.
    let mut s = floor_with(vec![sphere(v(0.0, 0.8, 0.0), 0.5, 1.0)]);
    s.environment = Environment::Constant(Vec3::ONE);
    for (shadow, light) in [(None, 10.0), (Some(15.0), 4.0), (Some(3.0), 12.0)] {
        let settings = SoftGi { shadow_reach: shadow, light_reach: light, ..fine() };
        let wide = view(&camera(v(0.0, 9.0, 0.01), Vec3::ZERO, 90.0), 32, 32);
        let xi = dumps(&s, &wide, &settings, &["xi"]);
        let least = xi[0].pixels.iter().fold(1.0f32, |a, p| a.min(p.x));
        println!("reaches {shadow:?}, {light}: ξ from {least:.3}");
        assert!(least > 0.95, "{least}");
    }
    // Negative control: two balls in one place count once.
    s.proxies.push(s.proxies[0]);
    let xi = dumps(&s, &above(16), &fine(), &["xi"]);
    assert!(xi[0].pixels.iter().any(|p| p.x < 0.7));
}
