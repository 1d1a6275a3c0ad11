//! Are shadows by cones as soft as those of a light with an extent?

use crate::render_on;
use crate::support::*;
use glam::Vec3;
use twinlight::backend::Cpu;
use twinlight::picture::Picture;
use twinlight::report::error::picture_error;
use twinlight::scene::{Scene, light};
use twinlight::technique::layered_rsm::{LayeredRsm, Opacity};
use twinlight::technique::reference::Bounces;
use twinlight::technique::{Job, LightPart};

/// Adds a ball that emits outward.
fn emitting_ball(s: &mut Scene, centre: Vec3, radius: f32, radiance: f32) {
    let (rings, sectors) = (12, 24);
    let point = |i: usize, j: usize| {
        let (sin, cos) = (std::f32::consts::PI * i as f32 / rings as f32).sin_cos();
        let (sj, cj) = (std::f32::consts::TAU * j as f32 / sectors as f32).sin_cos();
        centre + radius * v(sin * cj, cos, sin * sj)
    };
    for i in 0..rings {
        for j in 0..sectors {
            quad(
                s,
                [point(i, j), point(i, j + 1), point(i + 1, j + 1), point(i + 1, j)],
                emitter(0.0, radiance),
            );
        }
    }
}

/// A floor of 4 m and a box that floats over it; the floor is what is looked at.
fn floor_and_box() -> Scene {
    let mut s = scene();
    square(&mut s, 0.0, 2.0, true, grey(0.6));
    let mut own = scene();
    room(&mut own, v(0.35, 0.2, 0.35), 0.4, grey(0.5));
    let first = s.materials.len() as u32;
    s.materials.extend(own.materials);
    for mut t in own.triangles {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            p.y += 0.7;
        }
        t.material += first;
        s.triangles.push(t);
    }
    s
}

#[test]
fn penumbras_are_those_of_an_area_light() {
    let (at, radius) = (v(0.4, 2.2, 0.0), 0.3);
    let view = view(&camera(v(0.0, 3.8, 0.01), Vec3::ZERO, 50.0), 48, 48);
    let mut with_ball = floor_and_box();
    // A ball of radiance L and radius r is seen as far away as a point of L π r².
    emitting_ball(&mut with_ball, at, radius, 10.0);
    let right = trace(&with_ball, &view, &settings(Bounces::Count(0), 6144)).direct;
    let mut s = floor_and_box();
    s.lights = vec![light::point(at, Vec3::splat(10.0 * std::f32::consts::PI * radius * radius))];
    let soft = |light_radius: f32, resolution: u32| {
        let settings = LayeredRsm { shadow_cones: true, light_radius, resolution, ..Default::default() };
        let job = Job { light: LightPart::Direct, ..Job::default() };
        render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &job, &settings).0.picture
    };
    // What the ball itself hides or shows of the floor is not compared: pixels that see it, or the box.
    let masked = |p: &Picture, by: &Picture| {
        let mut p = p.clone();
        for (pixel, other) in p.pixels.iter_mut().zip(&by.pixels) {
            if other.x > 2.0 {
                *pixel = Vec3::ZERO;
            }
        }
        p
    };
    let whole = masked(&right, &right);
    let error = |p: Picture| picture_error(&masked(&p, &right), &whole).unwrap();
    let (good, hard, wide) =
        (error(soft(radius, 128)), error(soft(0.0, 128)), error(soft(4.0 * radius, 128)));
    if let Ok(folder) = std::env::var("TWINLIGHT_PICTURES") {
        let folder = std::path::Path::new(&folder);
        whole.save(&folder.join("area-light.exr"), 0.0).unwrap();
        masked(&soft(radius, 128), &right).save(&folder.join("shadow-cones.exr"), 0.0).unwrap();
    }
    println!("as wide as the light {good:?}\nwithout extent {hard:?}\nfour times as wide {wide:?}");
    assert!(good.relative_rmse < 0.2 && (good.mean_ratio - 1.0).abs() < 0.05, "{good:?}");
    // About 0.1 of it is the reference's own noise; the next test has none.
    assert!(good.relative_rmse < hard.relative_rmse, "{hard:?}");
}

/// The share of a ball that a point sees past an upright box, by rays to 600 points of the ball's disc.
fn seen_share(from: Vec3, ball: Vec3, radius: f32, low: Vec3, high: Vec3) -> f32 {
    let axis = (ball - from).normalize();
    let (right, up) = axis.any_orthonormal_pair();
    let count = 600;
    let free = (0..count).filter(|&i| {
        let r = radius * ((i as f32 + 0.5) / count as f32).sqrt();
        let (sin, cos) = (2.399_963 * i as f32).sin_cos();
        let d = ball + right * (r * cos) + up * (r * sin) - from;
        let (a, b) = ((low - from) / d, (high - from) / d);
        let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
        enter > leave || leave < 0.0 || enter > 1.0
    });
    free.count() as f32 / count as f32
}

#[test]
fn shares_are_those_of_rays_to_all_of_the_light() {
    let mut s = scene();
    square(&mut s, 0.0, 2.0, true, grey(0.6));
    let (low, high) = (v(-0.4, 0.5, -0.3), v(0.4, 0.9, 0.3));
    let mut own = scene();
    room(&mut own, 0.5 * (high - low), 0.0, grey(0.5));
    let first = s.materials.len() as u32;
    s.materials.extend(own.materials);
    for mut t in own.triangles {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p += (0.5 * (high + low)).extend(0.0);
        }
        t.material += first;
        s.triangles.push(t);
    }
    let (ball, radius) = (v(0.4, 2.2, 0.0), 0.3);
    s.lights = vec![light::point(ball, Vec3::ONE)];
    let view = view(&camera(v(0.0, 3.8, 0.01), Vec3::ZERO, 50.0), 64, 64);
    let error = |light_radius: f32, opacity: Opacity| {
        let settings =
            LayeredRsm { shadow_cones: true, light_radius, opacity, resolution: 128, ..Default::default() };
        let dumps = vec!["shadow".to_owned(), "position".to_owned()];
        let job = Job { light: LightPart::Direct, dumps, ..Job::default() };
        let rendered = render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &job, &settings).0;
        let (mut square, mut count) = (0.0, 0);
        for (p, got) in rendered.dumps["position"].pixels.iter().zip(&rendered.dumps["shadow"].pixels) {
            let right = seen_share(*p, ball, radius, low, high);
            // The floor where the shadow's edge is.
            if p.y.abs() < 1e-3 && p.x.abs() < 1.4 && p.z.abs() < 1.0 {
                square += (got.x - right) * (got.x - right);
                count += 1;
            }
        }
        assert!(count > 500);
        (square / count as f32).sqrt()
    };
    let soft = error(radius, Opacity::Covered);
    let others = [
        ("without extent", error(0.0, Opacity::Covered)),
        ("four times as wide", error(4.0 * radius, Opacity::Covered)),
    ];
    let published = error(radius, Opacity::Mean);
    println!("shares are off by {soft:.3} RMS; {others:?}; with mean opacity, as published, {published:.3}");
    assert!(soft < 0.1 && published < 0.1, "{soft}, {published}");
    assert!(others.iter().all(|(_, e)| *e > 1.3 * soft), "negative controls: {others:?}");
}

#[test]
fn what_is_behind_or_beside_a_light_does_not_hide_it() {
    let mut s = scene();
    room(&mut s, v(1.0, 1.0, 1.0), 0.0, grey(0.5));
    for (height, light_radius) in [(0.8, 0.15), (0.8, 0.19), (0.95, 0.05)] {
        s.lights = vec![light::point(v(0.0, height, 0.0), Vec3::ONE)];
        let view = view(&camera(v(0.0, 0.6, 0.01), v(0.0, -1.0, 0.0), 80.0), 24, 24);
        let settings = LayeredRsm { shadow_cones: true, light_radius, resolution: 128, ..Default::default() };
        let dumps = ["shadow", "position"].map(str::to_owned).to_vec();
        let job = Job { light: LightPart::Direct, dumps, ..Job::default() };
        let seen = render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &job, &settings).0;
        // In corners a cone begins within the other wall's voxels.
        let on_floor = |p: &Vec3| p.y < -0.99 && p.x.abs().max(p.z.abs()) < 0.9;
        let shares = seen.dumps["position"].pixels.iter().zip(&seen.dumps["shadow"].pixels);
        let least = shares.filter(|(p, _)| on_floor(p)).map(|(_, s)| s.x).fold(1.0, f32::min);
        println!("{height} m up, radius {light_radius}: shares from {least:.3}");
        assert!(least > 0.95, "an empty room shadows itself: {least}");
    }
    // Planted fault: a plate before the light does.
    s.lights = vec![light::point(v(0.0, 0.8, 0.0), Vec3::ONE)];
    quad(&mut s, [v(-0.2, 0.5, -0.2), v(0.2, 0.5, -0.2), v(0.2, 0.5, 0.2), v(-0.2, 0.5, 0.2)], grey(0.5));
    let view = view(&camera(v(0.0, 0.4, 0.01), v(0.0, -1.0, 0.0), 40.0), 24, 24);
    let settings =
        LayeredRsm { shadow_cones: true, light_radius: 0.1, resolution: 128, ..Default::default() };
    let job = Job { light: LightPart::Direct, dumps: vec!["shadow".to_owned()], ..Job::default() };
    let seen = render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &job, &settings).0;
    println!("behind a plate {:.3}", seen.dumps["shadow"].mean().x);
    assert!(seen.dumps["shadow"].mean().x < 0.2, "{}", seen.dumps["shadow"].mean());
}

#[test]
fn a_cone_without_extent_is_a_ray() {
    let view = view(&camera(v(0.0, 3.8, 0.01), Vec3::ZERO, 50.0), 48, 48);
    for lamp in [
        light::point(v(0.4, 2.2, 0.0), Vec3::splat(3.0)),
        light::spot(v(0.0, 2.5, 0.5), Vec3::NEG_Y, Vec3::splat(5.0), 0.4, 0.8),
        light::sun(v(1.0, -1.0, 0.1).normalize(), Vec3::splat(2.0)),
    ] {
        let s = Scene { lights: vec![lamp], ..floor_and_box() };
        let with = |shadow_cones: bool| {
            let settings = LayeredRsm { shadow_cones, resolution: 256, ..Default::default() };
            let job = Job { light: LightPart::Direct, ..Job::default() };
            render_on(&mut Cpu::new(Some(2)).unwrap(), &s, &view, &job, &settings).0.picture
        };
        let (rays, cones) = (with(false), with(true));
        let e = picture_error(&cones, &rays).unwrap();
        println!("kind {}: RMSE {:.1} %, mean ratio {:.3}", lamp.kind, 100.0 * e.relative_rmse, e.mean_ratio);
        assert!(e.relative_rmse < 0.2 && (e.mean_ratio - 1.0).abs() < 0.03, "{e:?}");
        let unlit = rays.pixels.iter().filter(|p| p.x < 1e-6).count();
        assert!(unlit > 20, "negative control: the box throws a shadow");
    }
}
