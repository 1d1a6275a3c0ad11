//! What a sphere covers and sends back, when it counts, and how bright many emitters are.

use super::Settings;
use super::case::{Case, Head, Measure, NAIVE, Unit};
use super::device::Work;
use super::draw::{Random, list};
use super::harmonics::vector;
use super::truth;
use crate::technique::soft_gi::exact_operator_table;
use glam::{DVec3, Vec3, Vec4};
use std::f32::consts::{PI, TAU};
use std::rc::Rc;
use twinlight_kernels::passes::evaluate_sh::exponential;
use twinlight_kernels::sh::{self, FADE};

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let mut all = vec![key(settings), influence_key(settings), influence_weight(settings)];
    all.extend([Asked::Sine, Asked::Direction, Asked::Weight].map(|asked| blocker(settings, asked)));
    all.extend([averaged(settings), fitted(settings)]);
    all.extend(operators(settings));
    all.extend([emitters::<1>(settings), emitters::<4>(settings)]);
    all
}

/// Sine, radius of influence, width of the ramp: of the pass of order 3, whose table is not looked at.
fn pass(all: &[Vec4]) -> Work {
    let nothing = vec![vector(&[]); all.len()];
    Work::Exponential(3, exponential::LOGARITHM, nothing, all.to_vec(), vec![0.0], 1)
}

/// 1 − cos of the angle of this sine.
fn true_key(alpha: f64) -> f64 {
    alpha * alpha / (1.0 + ((1.0 - alpha) * (1.0 + alpha)).sqrt())
}

fn key(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("occlusion key", "sin 1e-4 to 1", Unit::Relative),
        list("keys", settings.numbers, |r| Vec4::new(r.positive(1e-4, 1.0), 15.0, 2.0, 0.5)),
        |x| [sh::occlusion_key(x.x)],
        |x, got| truth::relative(got[0], true_key(f64::from(x.x))),
    )
    .way(NAIVE, |x| [1.0 - (1.0 - x.x * x.x).sqrt()])
    .on(pass, |words| [f32::from_bits(words[7])])
    .boxed()
}

fn influence_key(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("influence key", "radii 1 to 100", Unit::Relative),
        list("influence", settings.numbers, |r| r.positive(1.0, 100.0)),
        |eta| [sh::influence_key(*eta)],
        |eta, got| truth::relative(got[0], true_key(1.0 / f64::from(*eta).max(1.0))),
    )
    .boxed()
}

/// Of sines near that where influence ends.
fn influence_weight(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("influence weights", settings.numbers, |r| {
        let reach = r.positive(5.0, 50.0);
        Vec4::new(r.range(0.9, 1.6) / reach, reach, r.range(1.5, 3.0), 0.5)
    });
    Case::new(
        Head::strict("influence weight", "near the end of 5 to 50 radii", Unit::Absolute),
        inputs,
        |x| [sh::influence_weight(sh::occlusion_key(x.x), sh::influence_key(x.y), x.z)],
        |x, got: &[f32; 1]| {
            let x = x.as_dvec4();
            let t = ((true_key(x.x) / true_key(1.0 / x.y) - 1.0) / (x.z - 1.0)).clamp(0.0, 1.0);
            (f64::from(got[0]) - (3.0 - 2.0 * t) * t.powi(2)).abs()
        },
    )
    .on(pass, |words| [f32::from_bits(words[8])])
    .boxed()
}

/// Which part of a blocker is compared.
#[derive(Clone, Copy, PartialEq)]
enum Asked {
    Sine,
    Direction,
    Weight,
}

/// Centre and radius, receiver, its normal.
type Placed = (Vec4, Vec3, Vec3);

/// Sine, direction and weight: the ball between the plane and the sphere's topmost point, which fades as the sphere holds the point
/// from below.
fn true_blocker((sphere, p, n): &Placed) -> (f64, DVec3, f64) {
    let (n, r) = (n.as_dvec3(), f64::from(sphere.w));
    let to = sphere.truncate().as_dvec3() - p.as_dvec3();
    let top = to.dot(n) + r;
    if top <= 0.0 {
        return (0.0, n, 0.0);
    }
    if top >= 2.0 * r {
        return ((r / to.length()).min(1.0), to.normalize(), 1.0);
    }
    let ball = to - n * to.dot(n) + n * (0.5 * top);
    let smooth = |t: f64| t.clamp(0.0, 1.0).powi(2) * (3.0 - 2.0 * t.clamp(0.0, 1.0));
    let holds = 1.0 - smooth((to.length() / r - 1.0) / f64::from(FADE));
    ((0.5 * top / ball.length()).min(1.0), ball.normalize(), 1.0 - smooth(2.0 - top / r) * holds)
}

fn blocker(settings: &Settings, asked: Asked) -> Box<dyn Measure> {
    let inputs = list("blockers met", settings.numbers, |r| -> Placed {
        let (p, n, radius) = (r.point(4.0), r.direction(), r.positive(0.1, 1.0));
        ((p + r.point(3.0) * radius).extend(radius), p, n)
    });
    let (variant, stated) = match asked {
        Asked::Sine => ("sine", 2e-5),
        Asked::Direction => ("direction", 1e-3),
        Asked::Weight => ("weight", 2e-5),
    };
    Case::new(
        Head::new("blocker", variant, "within 3 radii, also through the plane", Unit::Absolute)
            .stated(stated),
        inputs,
        |(sphere, p, n)| {
            let b = sh::blocker(sphere.truncate(), sphere.w, *p, *n, FADE);
            let [x, y, z] = b.direction.to_array();
            [b.alpha, x, y, z, b.weight]
        },
        move |x, got: &[f32; 5]| {
            let (sine, direction, weight) = true_blocker(x);
            match asked {
                Asked::Sine => (f64::from(got[0]) - sine).abs(),
                Asked::Direction => truth::distance(&got[1..4], &direction.to_array()),
                Asked::Weight => (f64::from(got[4]) - weight).abs(),
            }
        },
    )
    .boxed()
}

/// Band 1 as SGI eq. 14 has it, in distances over radii.
fn printed([zero, _, two]: [f32; 3], alpha: f32) -> [f32; 3] {
    let d = 1.0 / alpha;
    let root = (d * d - 1.0).max(0.0).sqrt();
    let above = 2.0 * d * d * d - 2.0 * root * d * d - root + 1.0;
    [zero, -(3f32.sqrt()) * above / (6.0 * PI.sqrt() * d * (d - root)), two]
}

fn averaged(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::strict("averaged operator", "sin 1e-3 to 1", Unit::Relative).stated(5e-7),
        list("averaged", settings.vectors, |r| r.positive(1e-3, 1.0)),
        |alpha| sh::averaged_operator(*alpha),
        |alpha, got| truth::largest_relative(got, &truth::averaged_operator(f64::from(*alpha))),
    )
    .way("band 1 as printed", |alpha| printed(sh::averaged_operator(*alpha), *alpha))
    .boxed()
}

fn fitted(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new("averaged operator", "polynomials", "sin 1e-3 to 1", Unit::Absolute).stated(0.0054),
        list("averaged", settings.vectors, |r| r.positive(1e-3, 1.0)),
        |alpha| sh::averaged_operator_fit(*alpha),
        |alpha, got: &[f32; 3]| truth::largest(got, &truth::averaged_operator(f64::from(*alpha))),
    )
    .boxed()
}

/// A sine, and radiance of the sphere's surface by its normal.
type Sent = (f32, [f32; 9]);

/// What a sphere sends, all bands; the zonal operator of a sine.
type Kernel = Box<dyn Fn(&Sent) -> [f32; 9]>;
type Mean = (&'static str, fn(f32) -> [f32; 3]);

/// What a sphere sends: the exact operator by tables, and a mean radiance times what the sphere covers.
fn operators(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let inputs: Vec<Sent> = list("sent", settings.sets, |r: &mut Random| {
        (r.positive(0.02, 0.95), std::array::from_fn(|_| r.range(-1.0, 1.0)))
    });
    let truths = inputs.iter().map(|(alpha, f)| truth::sent(f64::from(*alpha), &truth::wide(f)));
    let truths: Rc<Vec<Vec<f64>>> = Rc::new(truths.collect());
    let one = |variant: &str, kernel: Kernel| {
        let truths = truths.clone();
        let head = Head::new("light of a sphere", variant, "sin 0.02 to 0.95, order 3", Unit::Sphere);
        let mut case = Case::new(head, inputs.clone(), kernel, |_, _| 0.0);
        case.error = Box::new(move |i, _, got| truth::distance(got, &truths[i]) / truth::unit());
        case.boxed()
    };
    let mut all: Vec<_> = [16u32, 32, 64, 128]
        .map(|entries| {
            let table = exact_operator_table(entries as usize);
            let kernel = move |(alpha, f): &Sent| sh::exact_operator(&table, entries, *alpha, f);
            one(&format!("exact, {entries} entries"), Box::new(kernel))
        })
        .into();
    let means: [Mean; 3] = [
        ("averaged", sh::averaged_operator),
        ("averaged by polynomials", sh::averaged_operator_fit),
        // y_l0 at −z.
        ("of the nearest point", |_| [0.282_094_8, -0.488_602_5, 0.630_783_1]),
    ];
    all.extend(means.map(|(variant, operator)| {
        let kernel = move |(alpha, f): &Sent| {
            let d = operator(*alpha);
            let mean = d[0] * f[0] + d[1] * f[2] + d[2] * f[6];
            let cap = sh::cap::<3>(*alpha);
            [mean * cap[0], 0.0, mean * cap[1], 0.0, 0.0, 0.0, mean * cap[2], 0.0, 0.0]
        };
        one(variant, Box::new(kernel))
    }));
    all
}

/// Emitters' normals with intensities, their sum in two bands, a direction.
type Emitters<const K: usize> = ([Vec4; K], Vec4, Vec3);

/// Against each emitter's own cosine. Of one emitter what is read is exact, of four it is not.
fn emitters<const K: usize>(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("emitters", settings.numbers, |r| -> Emitters<K> {
        let all = [0; K].map(|_| r.direction().extend(r.positive(0.1, 1.0)));
        let bands = all.iter().map(|e| {
            let ([x, y, z, _], a) = (e.to_array(), e.w);
            let (zero, one) = (0.5 * PI.sqrt(), (PI / 3.0).sqrt());
            Vec4::new(zero, -one * y, one * z, -one * x) * a
        });
        (all, bands.sum(), r.direction())
    });
    let variant = if K == 1 { "one" } else { "four" };
    Case::new(
        Head::new("intensity of emitters", variant, "intensities 0.1 to 1", Unit::OfNorm),
        inputs,
        |(_, sum, d)| [sh::lambert_intensity(*sum, *d)],
        |(all, _, d), got: &[f32; 1]| {
            let d = d.as_dvec3();
            let of = |e: &Vec4| f64::from(e.w) * e.truncate().as_dvec3().dot(d).max(0.0);
            let total: f64 = all.iter().map(|e| f64::from(e.w)).sum();
            (f64::from(got[0]) - all.iter().map(of).sum::<f64>()).abs() / total
        },
    )
    .way("series", |(_, c, d)| {
        let band = (0.75 / PI).sqrt();
        [c.x / (2.0 * TAU).sqrt() + band * (c.z * d.z - c.y * d.y - c.w * d.x)]
    })
    .boxed()
}
