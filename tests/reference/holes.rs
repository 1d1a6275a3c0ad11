//! A masked surface below its cut-off is a hole for primary, shadow and scattered rays.

use crate::support::*;
use glam::Vec3;
use twinlight::picture::Picture;
use twinlight::scene::{Environment, Scene, light};
use twinlight::technique::View;
use twinlight::technique::reference::Bounces;
use twinlight_kernels::passes::scene::Material;

/// A lit floor under an emissive ceiling, between them, perhaps, a sheet.
fn room_with_sheet(sheet: Option<(f32, Material)>) -> Scene {
    let mut s = scene();
    square(&mut s, 0.0, 2.0, true, grey(0.6));
    square(&mut s, 3.0, 0.7, false, emitter(0.3, 2.0));
    s.lights = vec![
        light::point(v(0.2, 2.5, 0.1), Vec3::splat(4.0)),
        light::sun(v(0.1, -1.0, 0.2).normalize(), Vec3::ONE),
    ];
    s.environment = Environment::Constant(Vec3::splat(0.2));
    if let Some((height, material)) = sheet {
        square(&mut s, height, 1.0, true, material);
    }
    s
}

fn picture(s: &Scene, view: &View) -> Picture {
    trace(s, view, &settings(Bounces::Count(2), 16)).all()
}

#[test]
fn a_hole_is_as_if_nothing_were_there() {
    // From above the sheet, primary rays meet it; from below, only shadow and scattered rays do.
    for (from, eye) in [("above", v(0.3, 1.6, 0.4)), ("below", v(0.3, 0.4, 0.4))] {
        let view = view(&camera(eye, v(0.0, 0.0, 0.0), 70.0), 48, 32);
        let without = picture(&room_with_sheet(None), &view);
        let hole = picture(&room_with_sheet(Some((1.0, masked(0.0)))), &view);
        assert!(same_bits(&without, &hole), "{from}: {:?}", difference(&without, &hole));
        let whole = picture(&room_with_sheet(Some((1.0, masked(1.0)))), &view);
        assert!(difference(&without, &whole).0 > 0.1, "{from}: negative control: an opaque sheet");
        // Not masked, alpha means nothing.
        let opaque = Material { flags: 0, ..masked(0.0) };
        let opaque = picture(&room_with_sheet(Some((1.0, opaque))), &view);
        assert!(same_bits(&whole, &opaque), "{from}: {:?}", difference(&whole, &opaque));
    }
}

#[test]
fn each_kind_of_ray_goes_through_on_its_own() {
    let view = view(&camera(v(0.3, 0.4, 0.4), Vec3::ZERO, 70.0), 48, 32);
    type Change = fn(&mut Scene);
    let only: [(&str, Change); 4] = [
        ("shadow rays to a point", |s| s.lights.truncate(1)),
        ("shadow rays to a sun", |s| s.lights = s.lights.split_off(1)),
        ("scattered rays to an emitter", |s| s.lights.clear()),
        ("scattered rays to the sky", |s| {
            s.lights.clear();
            s.materials[1].emission = Default::default();
            s.environment = Environment::Constant(Vec3::ONE);
        }),
    ];
    for (rays, change) in only {
        let [without, hole, whole] =
            [None, Some((1.0, masked(0.0))), Some((1.0, masked(1.0)))].map(|sheet| {
                let mut s = room_with_sheet(sheet);
                if rays != "scattered rays to the sky" {
                    s.environment = Environment::None;
                }
                change(&mut s);
                if rays.starts_with("shadow") {
                    s.materials[1].emission = Default::default();
                }
                picture(&s, &view)
            });
        assert!(without.mean().x > 0.0, "{rays}");
        assert!(same_bits(&without, &hole), "{rays}: {:?}", difference(&without, &hole));
        assert!(difference(&without, &whole).0 > 0.1, "{rays}: negative control: an opaque sheet");
    }
}

#[test]
fn a_textured_hole_begins_where_alpha_falls_below_the_cut_off() {
    let mut sheet = masked(1.0);
    sheet.base_size = 2 | 1 << 16;
    let mut s = scene();
    quad(&mut s, [v(-1.0, 0.0, 0.0), v(1.0, 0.0, 0.0), v(1.0, 2.0, 0.0), v(-1.0, 2.0, 0.0)], sheet);
    // Texture coordinate u from 0 at the left to 1 at the right; the left texel is opaque, the right one clear.
    for t in &mut s.triangles {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            p.w = 0.5 + 0.5 * p.x;
        }
    }
    s.texels = vec![0xFFFF_FFFF, 0xFFFF_FFFF, 0xFFFF_FFFF, 0x0000_FFFF];
    s.environment = Environment::Constant(Vec3::ONE);
    // The view is the sheet, from edge to edge.
    let view = view(&camera(v(0.0, 1.0, 1.0), v(0.0, 1.0, 0.0), 90.0), 64, 64);
    let picture = trace(&s, &view, &settings(Bounces::Count(0), 4)).all();
    // Bilinear and repeating: alpha is ½ at both edges and in the middle, above it on the left, below on the right.
    for (i, p) in picture.pixels.iter().enumerate() {
        let expected = if i % 64 < 32 { 0.5 } else { 1.0 };
        assert!(relative(p.x, expected) < 1e-5, "column {}: {p}, expected {expected}", i % 64);
    }
}
