//! Does light leak, depend on where things are, or change with what should not matter?

use crate::support::*;
use crate::{cpu, indirect, render_on};
use glam::{Mat3, Vec3};
use twinlight::picture::Picture;
use twinlight::report::error::picture_error;
use twinlight::scene::{Scene, light};
use twinlight::technique::layered_rsm::{LayeredRsm, Opacity};
use twinlight::technique::{Cones, Job, LightPart};

/// Two closed rooms side by side with a thin wall between them; the light is in the left one.
fn two_rooms() -> Scene {
    let mut s = scene();
    let mut own = scene();
    room(&mut own, v(1.0, 1.0, 1.0), 0.0, grey(0.7));
    for x in [-1.0, 1.0] {
        let first = s.materials.len() as u32;
        s.materials.extend(own.materials.clone());
        for mut t in own.triangles.clone() {
            for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
                p.x += x;
            }
            t.material += first;
            s.triangles.push(t);
        }
    }
    s.lights = vec![light::point(v(-1.0, 0.3, 0.2), Vec3::splat(3.0))];
    s
}

#[test]
fn little_leaks_through_a_thin_wall() {
    let s = two_rooms();
    let look = |x: f32| view(&camera(v(x, 0.0, 0.9), v(x, -0.1, -1.0), 70.0), 24, 24);
    let score = |settings: &LayeredRsm| {
        let [lit, dark] = [-1.0, 1.0].map(|x| indirect(&s, &look(x), settings).mean().y);
        dark / lit
    };
    let at = |resolution, opacity| LayeredRsm { resolution, opacity, map: 256, ..Default::default() };
    let (covered, fine) = (score(&at(64, Opacity::Covered)), score(&at(128, Opacity::Covered)));
    let mean = score(&at(64, Opacity::Mean));
    println!("leak score {covered:.4} at 64³, {fine:.4} at 128³; with mean opacity {mean:.4}");
    assert!(covered < 0.02 && fine < 0.02, "{covered}, {fine}");
    assert!(mean > 2.0 * covered, "negative control: means leak, {mean}");
}

fn cornell_box() -> Scene {
    Scene::open("cornell-box").unwrap()
}

fn seen(turn: Mat3, scale: f32, shift: Vec3, settings: &LayeredRsm) -> Picture {
    let (s, camera) = mapped(&cornell_box(), turn, scale, shift);
    indirect(&s, &view(&camera, 32, 32), settings)
}

fn base_settings() -> LayeredRsm {
    LayeredRsm { resolution: 64, cones: Cones { count: 32, ..Cones::default() }, ..Default::default() }
}

#[test]
fn places_axes_and_units_do_not_matter() {
    let settings = base_settings();
    let base = seen(Mat3::IDENTITY, 1.0, Vec3::ZERO, &settings);
    let swapped = Mat3::from_cols(Vec3::Y, Vec3::Z, Vec3::X);
    let slanted = Mat3::from_euler(glam::EulerRot::XYZ, 0.4, 0.3, 0.2);
    for (what, turn, scale, shift, (mean, rmse)) in [
        ("moved", Mat3::IDENTITY, 1.0, Vec3::new(3.0, -7.0, 11.0), (0.01, 0.05)),
        ("in millimetres", Mat3::IDENTITY, 1e3, Vec3::ZERO, (0.01, 0.05)),
        ("in kilometres", Mat3::IDENTITY, 1e-3, Vec3::ZERO, (0.01, 0.05)),
        ("axes swapped", swapped, 1.0, Vec3::ZERO, (0.04, 0.1)),
        ("turned by 90°", Mat3::from_rotation_y(std::f32::consts::FRAC_PI_2), 1.0, Vec3::ZERO, (0.03, 0.12)),
        ("turned by 20°", Mat3::from_rotation_y(0.35), 1.0, Vec3::ZERO, (0.05, 0.18)),
        ("turned about all axes", slanted, 1.0, Vec3::ZERO, (0.18, 0.3)),
    ] {
        let e = picture_error(&seen(turn, scale, shift, &settings), &base).unwrap();
        println!("{what}: RMSE {:.1} %, mean ratio {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        assert!((e.mean_ratio - 1.0).abs() < mean && e.relative_rmse < rmse, "{what}: {e:?}");
    }
    let other = seen(Mat3::from_diagonal(v(1.0, 1.5, 1.0)), 1.0, Vec3::ZERO, &settings);
    let e = picture_error(&other, &base).unwrap();
    assert!((e.mean_ratio - 1.0).abs() > 0.05 || e.relative_rmse > 0.3, "negative control: {e:?}");
}

#[test]
fn where_the_voxels_lie_does_not_matter() {
    let settings = base_settings();
    let (s, camera) = mapped(&cornell_box(), Mat3::IDENTITY, 1.0, Vec3::ZERO);
    let camera = view(&camera, 32, 32);
    let base = indirect(&s, &camera, &settings);
    // A speck far below moves and widens the lattice under the box, and nothing else.
    for far in [0.3, 0.7, 1.3] {
        let mut s = s.clone();
        let mut t = s.triangles[0];
        let at = v(-far, -far, -far);
        (t.p0, t.p1, t.p2) =
            (at.extend(0.0), (at + v(1e-3, 0.0, 0.0)).extend(0.0), (at + v(0.0, 0.0, 1e-3)).extend(0.0));
        s.triangles.push(t);
        let e = picture_error(&indirect(&s, &camera, &settings), &base).unwrap();
        println!("speck {far} m off: RMSE {:.1} %, mean ratio {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        assert!((e.mean_ratio - 1.0).abs() < 0.08 && e.relative_rmse < 0.35, "{far}: {e:?}");
    }
}

#[test]
fn steps_and_resolutions_do_not_matter() {
    let with = |step: f32, resolution: u32| {
        let cones = Cones { step, ..Cones::default() };
        seen(Mat3::IDENTITY, 1.0, Vec3::ZERO, &LayeredRsm { resolution, cones, ..base_settings() })
    };
    let fine = with(0.25, 64);
    for (step, resolution, mean) in [(0.5, 64, 0.02), (1.0, 64, 0.03), (0.5, 128, 0.06), (0.5, 256, 0.06)] {
        let e = picture_error(&with(step, resolution), &fine).unwrap();
        println!(
            "step {step}, {resolution}³: {:.1} %, mean ratio {:.4}",
            100.0 * e.relative_rmse,
            e.mean_ratio
        );
        assert!((e.mean_ratio - 1.0).abs() < mean, "{e:?}");
    }
}

#[test]
fn lights_add_up_however_many_are_gathered_together() {
    let s = Scene::open("cornell-box").unwrap();
    let view = view(&s.view(), 20, 20);
    let lamps: Vec<_> = (0..9)
        .map(|i| light::point(v(0.15 * (i % 3) as f32 - 0.15, 1.5, 0.15 * (i / 3) as f32), Vec3::splat(0.3)))
        .collect();
    let with = |lights: &[_], settings: &LayeredRsm| {
        indirect(&Scene { lights: lights.to_vec(), ..s.clone() }, &view, settings)
    };
    // Maps of 512 texels in 64 layers are gathered two by two, small ones all at once.
    let few = LayeredRsm { resolution: 64, map: 64, ..Default::default() };
    let many = LayeredRsm { depth_layers: 8, normal_layers: 8, map: 512, ..few.clone() };
    for (settings, grouped) in [(&few, false), (&many, true)] {
        let job = Job { light: LightPart::Indirect, ..Job::default() };
        let all = Scene { lights: lamps.clone(), ..s.clone() };
        let (rendered, counts) = render_on(&mut cpu(), &all, &view, &job, settings);
        assert_eq!(counts.lights, 9);
        let runs = rendered.timings.iter().filter(|t| t.pass == "layered_diffuse").count() as u32;
        assert_eq!(runs, 9u32.div_ceil(counts.lights_at_once.min(9)));
        assert_eq!(runs > 1, grouped, "{runs} runs, {} at once", counts.lights_at_once);
        let together = with(&lamps, settings);
        let mut sum = Picture::new(20, 20);
        for lamp in &lamps {
            let one = with(std::slice::from_ref(lamp), settings);
            sum.pixels.iter_mut().zip(&one.pixels).for_each(|(a, b)| *a += *b);
        }
        let e = picture_error(&together, &sum).unwrap();
        println!("nine lights: RMSE {:.2} %, mean ratio {:.4}", 100.0 * e.relative_rmse, e.mean_ratio);
        assert!(e.relative_rmse < 0.01 && (e.mean_ratio - 1.0).abs() < 0.003, "{e:?}");
    }
}

#[test]
fn a_moving_light_flickers_less_at_coarser_levels() {
    let s = Scene::open("cornell-glossy").unwrap();
    let view = view(&s.view(), 32, 32);
    // What neighbouring frames differ by beyond a steady change, second differences, over the mean; and that.
    let seen = |(least_level, most_level): (f32, Option<u32>)| {
        let cones = Cones { specular_half_angle: Some(5.0), ..Cones::default() };
        let settings =
            LayeredRsm { least_level, most_level, cones, illumination: Some((32, 32)), ..Default::default() };
        let job = Job {
            light: LightPart::Indirect,
            dumps: ["diffuse", "specular"].map(str::to_owned).to_vec(),
            ..Job::default()
        };
        let frames: Vec<_> = (0..8)
            .map(|i| {
                let lamp = light::point(v(-0.2 + 0.011 * i as f32, 1.2, 0.1), Vec3::splat(2.0));
                let lit = Scene { lights: vec![lamp], ..s.clone() };
                render_on(&mut cpu(), &lit, &view, &job, &settings).0.dumps
            })
            .collect();
        ["diffuse", "specular"].map(|part| {
            let whole: f64 =
                frames.iter().flat_map(|f| &f[part].pixels).map(|p| f64::from(p.element_sum())).sum();
            let mut of_pixel = vec![0.0f64; 32 * 32];
            for w in frames.windows(3) {
                let pixels = w[0][part].pixels.iter().zip(&w[1][part].pixels).zip(&w[2][part].pixels);
                for (sum, ((a, b), c)) in of_pixel.iter_mut().zip(pixels) {
                    *sum += f64::from((*a - *b * 2.0 + *c).abs().element_sum());
                }
            }
            // Pixels where surfaces touch see one or the other by chance: of a thousand these are left out.
            of_pixel.sort_by(f64::total_cmp);
            (of_pixel[..32 * 32 - 8].iter().sum::<f64>() / whole, whole)
        })
    };
    let [sharp, calm, sharpest] = [(0.0, None), (3.0, None), (0.0, Some(0))].map(seen);
    println!(
        "flicker and light, diffuse and specular: {sharp:?} at the finest level, {calm:?} from level 3 on, {sharpest:?} at the finest one alone"
    );
    // Narrow specular cones look up the finest level in either case.
    let flicker = |[diffuse, _]: [(f64, f64); 2]| diffuse.0;
    assert!(flicker(sharpest) > 1.05 * flicker(sharp), "{sharpest:?}, {sharp:?}");
    for (sharp, calm) in sharp.into_iter().zip(calm) {
        assert!(calm.0 < 0.95 * sharp.0, "{sharp:?}, {calm:?}");
        assert!((calm.1 / sharp.1 - 1.0).abs() < 0.1, "light: {sharp:?}, {calm:?}");
    }
}
