//! Light from surfaces that emit: the furnace, and two parallel squares.

use crate::support::*;
use glam::Vec3;
use twinlight::scene::Scene;
use twinlight::technique::View;
use twinlight::technique::reference::{Bounces, Reference};

const EMISSION: f32 = 2.0;
const ALBEDO: f32 = 0.5;

/// A closed box, askew, all of whose faces emit, and a wide view from inside.
fn furnace(albedo: f32) -> (Scene, View) {
    let mut s = scene();
    room(&mut s, v(1.0, 0.7, 1.3), 0.3, emitter(albedo, EMISSION));
    (s, view(&camera(v(0.1, -0.2, 0.3), v(0.9, 0.6, -0.4), 110.0), 48, 32))
}

/// e Σ ρᵏ over `terms` terms.
fn series(albedo: f64, terms: i32) -> f64 {
    f64::from(EMISSION) * (1.0 - albedo.powi(terms)) / (1.0 - albedo)
}

#[test]
fn a_furnace_is_a_geometric_series_in_every_pixel() {
    let (s, view) = furnace(ALBEDO);
    for n in [0, 1, 2, 5] {
        // Seen, reflected once as direct light, and n times more.
        let expected = series(f64::from(ALBEDO), n as i32 + 2);
        let result = trace(&s, &view, &settings(Bounces::Count(n), 16));
        let all = result.all();
        // Every path sees the same radiance at every step: a single ray through a crack would show.
        let worst = all.pixels.iter().map(|p| relative(p.x, expected)).fold(0.0, f64::max);
        assert!(worst < 1e-5, "{n} bounces: {worst} from {expected}");
        let missing = series(f64::from(ALBEDO), n as i32 + 1);
        assert!(relative(all.pixels[0].x, missing) > 1e-3, "negative control: one bounce less");
        let direct = relative(result.direct.pixels[7].x, series(f64::from(ALBEDO), 2));
        assert!(direct < 1e-5, "direct light is emission and its first reflection: {direct}");
    }
    let dark = Reference { emissive: false, ..settings(Bounces::Count(2), 4) };
    assert!(trace(&s, &view, &dark).all().pixels.iter().all(|p| *p == Vec3::ZERO));
}

#[test]
fn a_furnace_without_end_is_e_over_one_minus_albedo() {
    for albedo in [ALBEDO, 0.9] {
        let (s, view) = furnace(albedo);
        let result = trace(&s, &view, &settings(Bounces::All, 256));
        let expected = f64::from(EMISSION) / (1.0 - f64::from(albedo));
        assert_mean(&format!("furnace of albedo {albedo}"), &result.statistics[2], expected, 0.02);
    }
}

/// Form factor of parallel squares of side 1 at this distance (Incropera, table 13.2).
fn parallel_squares(distance: f64) -> f64 {
    let x = 1.0 / distance;
    let y = 1.0 + x * x;
    let log = (y * y / (1.0 + 2.0 * x * x)).ln() / 2.0;
    2.0 / (std::f64::consts::PI * x * x)
        * (log + 2.0 * x * y.sqrt() * (x / y.sqrt()).atan() - 2.0 * x * x.atan())
}

/// Two unit squares that face each other; the camera between them sees exactly the lower one.
fn squares(distance: f32, front_down: bool) -> (Scene, View) {
    let mut s = scene();
    square(&mut s, 0.0, 0.5, true, grey(0.8));
    square(&mut s, distance, 0.5, !front_down, emitter(0.0, 3.0));
    (s, view(&camera(v(0.0, 0.5, 0.0), Vec3::ZERO, 90.0), 32, 32))
}

#[test]
fn parallel_squares_exchange_their_form_factor() {
    assert!((parallel_squares(1.0) - 0.1998).abs() < 1e-4);
    let reference = Reference { pixel_filter: true, ..settings(Bounces::Count(0), 1024) };
    for distance in [1.0, 0.6] {
        let (s, view) = squares(distance, true);
        let result = trace(&s, &view, &reference);
        let expected = 0.8 * 3.0 * parallel_squares(f64::from(distance));
        assert_mean(&format!("squares at {distance} m"), &result.statistics[0], expected, 0.02);
        assert_eq!(result.statistics[1].mean, glam::DVec3::ZERO, "a black emitter reflects nothing");
    }
    let (s, view) = squares(1.0, false);
    let back = trace(&s, &view, &reference);
    assert!(back.all().pixels.iter().all(|p| *p == Vec3::ZERO), "the back of an emitter is dark");
}
