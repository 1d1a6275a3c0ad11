//! Lights without extent on a plane, pixel by pixel.

use crate::support::*;
use glam::{DVec3, Vec3};
use std::f64::consts::PI;
use twinlight::scene::{Scene, light};
use twinlight::technique::View;
use twinlight::technique::reference::Bounces;

const ALBEDO: f32 = 0.6;

fn plane(lights: Vec<twinlight_kernels::passes::scene::Light>) -> (Scene, View) {
    let mut s = scene();
    square(&mut s, 0.0, 4.0, true, grey(ALBEDO));
    s.lights = lights;
    (s, view(&camera(v(0.4, 2.5, 1.5), v(0.1, 0.0, 0.2), 50.0), 64, 48))
}

/// Compares every pixel with the irradiance at its point of the plane; returns the largest relative difference.
fn worst(s: &Scene, view: &View, irradiance: impl Fn(DVec3) -> Option<f64>) -> f64 {
    let picture = trace(s, view, &settings(Bounces::Count(0), 1)).all();
    let mut worst = 0.0f64;
    let mut compared = 0;
    for y in 0..view.height {
        for x in 0..view.width {
            let point = floor_point(view, f64::from(x) + 0.5, f64::from(y) + 0.5);
            if let Some(e) = irradiance(point) {
                let got = picture.pixels[(y * view.width + x) as usize].x;
                worst = worst.max(relative(got, f64::from(ALBEDO) / PI * e));
                compared += 1;
            }
        }
    }
    assert!(compared * 4 > view.pixels() * 3, "only {compared} pixels were compared");
    worst
}

/// I cos/d² on the floor.
fn from_point(light: DVec3, intensity: f64, p: DVec3) -> f64 {
    let d = light - p;
    intensity * d.y / d.length().powi(3)
}

#[test]
fn a_point_light_gives_i_cos_over_d_squared() {
    let (s, view) = plane(vec![light::point(v(0.5, 1.5, -0.3), Vec3::splat(7.0))]);
    let right = worst(&s, &view, |p| Some(from_point(DVec3::new(0.5, 1.5, -0.3), 7.0, p)));
    assert!(right < 1e-5, "{right}");
    // f32 and f64 disagree about the place of the light by less than this.
    let off = worst(&s, &view, |p| Some(from_point(DVec3::new(0.5, 1.5001, -0.3), 7.0, p)));
    assert!(off > 1e-5, "negative control: the light 0.1 mm higher");
    let no_pi = worst(&s, &view, |p| Some(from_point(DVec3::new(0.5, 1.5, -0.3), 7.0, p) * PI));
    assert!(no_pi > 0.5, "negative control: π");
}

#[test]
fn a_spot_falls_off_linearly_in_the_angle() {
    let (at, along) = (v(0.0, 2.0, 0.0), v(0.2, -1.0, 0.1).normalize());
    let (inner, outer) = (10f32.to_radians(), 35f32.to_radians());
    let (s, view) = plane(vec![light::spot(at, along, Vec3::splat(5.0), inner, outer)]);
    let expected = |inner: f32, linear: bool| {
        move |p: DVec3| {
            let to_point = (p - at.as_dvec3()).normalize();
            let angle = to_point.dot(along.as_dvec3().normalize()).acos();
            let (inner, outer) = (f64::from(inner), f64::from(outer));
            // At the rim the share is the difference of two nearly equal angles.
            if (angle - outer).abs() < 0.02 {
                return None;
            }
            let share = ((outer - angle) / (outer - inner)).clamp(0.0, 1.0);
            let share = if linear { share } else { share * share };
            Some(share * from_point(at.as_dvec3(), 5.0, p))
        }
    };
    let picture = trace(&s, &view, &settings(Bounces::Count(0), 1)).all();
    assert!(picture.pixels.iter().any(|p| p.x == 0.0) && picture.pixels.iter().any(|p| p.x > 0.1));
    let right = worst(&s, &view, expected(inner, true));
    assert!(right < 3e-5, "{right}");
    assert!(worst(&s, &view, expected(inner + 1e-3, true)) > 3e-5, "negative control: another inner angle");
    assert!(worst(&s, &view, expected(inner, false)) > 1e-2, "negative control: quadratic falloff");
}

#[test]
fn a_sun_gives_its_irradiance_times_the_cosine() {
    let direction = v(1.0, -2.0, 0.5).normalize();
    let (s, view) = plane(vec![light::sun(direction, Vec3::splat(3.0))]);
    let cosine = -f64::from(direction.y);
    assert!(worst(&s, &view, |_| Some(3.0 * cosine)) < 1e-6);
    assert!(worst(&s, &view, |_| Some(3.0)) > 1e-2, "negative control: no cosine");
}

#[test]
fn a_square_casts_its_shadow() {
    let sun = light::sun(v(1.0, -2.0, 0.0).normalize(), Vec3::splat(3.0));
    let point = light::point(v(0.0, 2.0, 0.0), Vec3::splat(7.0));
    // Centre and half side of the shadow on the floor of a square of half side 0.25 at height 1.
    for (light, centre, half) in [(point, 0.0, 0.5), (sun, 0.5, 0.25)] {
        let (mut s, view) = plane(vec![light]);
        // Beside the camera's view of the shadow; back or front casts alike.
        let view = View { frame: camera(v(0.4, 0.9, 1.5), v(0.1, 0.0, 0.2), 60.0).frame().unwrap(), ..view };
        square(&mut s, 1.0, 0.25, light.kind == 0, grey(0.5));
        let shade = |half: f64| {
            move |p: DVec3| {
                let inside = (p.x - centre).abs().max(p.z.abs()) - half;
                if inside.abs() < 2e-3 || p.abs().max_element() > 3.9 {
                    return None;
                }
                let lit = if light.kind == 0 {
                    from_point(DVec3::new(0.0, 2.0, 0.0), 7.0, p)
                } else {
                    3.0 * 2.0 / 5f64.sqrt()
                };
                Some(if inside < 0.0 { 0.0 } else { lit })
            }
        };
        let right = worst(&s, &view, shade(half));
        assert!(right < 1e-5, "{right}");
        assert!(worst(&s, &view, shade(half + 0.05)) > 0.9, "negative control: a larger shadow");
    }
}
