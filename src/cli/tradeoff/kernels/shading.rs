//! Gaussian lobes, depth windows and steps of cones.

use super::Settings;
use super::case::{Case, Each, Head, Measure, NATIVE, OnDevice, Unit, each, number};
use super::device::Work;
use super::draw::list;
use super::truth::{self, erf, relative};
use glam::{DVec4, Vec3, Vec4};
use twinlight_kernels::passes::{evaluate_cone, evaluate_gaussian, evaluate_vector};
use twinlight_kernels::{cone, gaussian, math};

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let mut all = vec![normalisation(settings)];
    all.extend([1.0, 8.0, 64.0, 512.0].map(|exponent| lobe_offset(settings, exponent)));
    all.push(specular(settings));
    all.push(lobe_width(settings));
    all.push(convolution(settings));
    all.push(cone_deviation(settings));
    all.extend(depth_windows(settings));
    all.extend(step_correction(settings));
    all.push(compositing(settings));
    all.push(mip_level(settings));
    all.push(aperture(settings));
    all
}

type One = [f32; 1];

/// A kernel of four numbers that gives one.
fn scalar(
    head: Head,
    inputs: Vec<Vec4>,
    strict: Each<Vec4, One>,
    others: Vec<(&'static str, Each<Vec4, One>)>,
    truth: fn(DVec4) -> f64,
    device: Option<OnDevice<Vec4, One>>,
) -> Box<dyn Measure> {
    let unit = head.unit;
    let error = move |_: usize, x: &Vec4, got: &One| {
        let truth = truth(x.as_dvec4());
        if unit == Unit::Relative { relative(got[0], truth) } else { (f64::from(got[0]) - truth).abs() }
    };
    Box::new(Case { head, inputs, strict, others, error: Box::new(error), device })
}

/// The pass of lobes, with the inputs as its first argument.
fn gaussian_pass(function: u32, read: fn(&[u32]) -> One) -> Option<OnDevice<Vec4, One>> {
    let zeros = |n| vec![Vec4::ZERO; n];
    Some(OnDevice {
        work: Box::new(move |a: &[Vec4]| {
            Work::Gaussian(function, [a.to_vec(), zeros(a.len()), zeros(a.len())])
        }),
        read,
        software: false,
    })
}

fn cone_pass(function: u32, read: fn(&[u32]) -> One) -> Option<OnDevice<Vec4, One>> {
    Some(OnDevice {
        work: Box::new(move |a: &[Vec4]| Work::Cone(function, [a.to_vec(), vec![Vec4::ONE; a.len()]])),
        read,
        software: false,
    })
}

fn normalisation(settings: &Settings) -> Box<dyn Measure> {
    Box::new(Case {
        head: Head::strict("normalize", "lengths 1e-3 to 1e3", Unit::Absolute),
        inputs: list("normalize", settings.vectors, |r| r.direction() * r.positive(1e-3, 1e3)),
        strict: each(|v: &Vec3| math::normalize_or(*v, Vec3::Y).to_array()),
        others: vec![(NATIVE, each(|v: &Vec3| v.normalize().to_array()))],
        error: Box::new(|_, v, got| truth::distance(got, &v.as_dvec3().normalize().to_array())),
        device: Some(OnDevice {
            work: Box::new(|all: &[Vec3]| {
                let a = all.iter().map(|v| v.extend(0.0)).collect();
                Work::Vector(evaluate_vector::function::NORMALIZE, [a, vec![Vec4::ZERO; all.len()]])
            }),
            read: |words| [0, 1, 2].map(|i| f32::from_bits(words[i])),
            software: false,
        }),
    })
}

fn lobe_offset(settings: &Settings, exponent: f32) -> Box<dyn Measure> {
    let mut head = Head::strict("lobe offset 1 - cos^n", "1 - cos 1e-9 to 0.99", Unit::Relative).stated(4e-7);
    head.variant = format!("exponent {exponent}");
    scalar(
        head,
        list("offset", settings.numbers, |r| Vec4::new(r.positive(1e-9, 0.99), exponent, 0.0, 0.0)),
        each(|x: &Vec4| [gaussian::lobe_offset(x.x, x.y)]),
        vec![
            (NATIVE, each(|x: &Vec4| [-(x.y * (-x.x).ln_1p()).exp_m1()])),
            ("naive", each(|x: &Vec4| [1.0 - (1.0 - x.x).powf(x.y)])),
        ],
        |x| -(x.y * (-x.x).ln_1p()).exp_m1(),
        None,
    )
}

/// Two directions, exponent and deviation.
type Gloss = (Vec3, Vec3, f32, f32);

fn specular(settings: &Settings) -> Box<dyn Measure> {
    fn truth((a, b, exponent, deviation): &Gloss) -> f64 {
        let gap = (a.as_dvec3() - b.as_dvec3()).length_squared() / 2.0;
        let x = if gap < 1.0 { -(f64::from(*exponent) * (-gap).ln_1p()).exp_m1() } else { 1.0 };
        let (s, q) = (f64::from(*deviation), x / f64::from(*deviation));
        (-0.5 * q * q).exp() / (s * std::f64::consts::TAU.sqrt())
    }
    Box::new(Case {
        head: Head::strict("specular weight", "1 to 256, deviation 0.15 to 1", Unit::Relative).stated(1e-5),
        inputs: list("specular", settings.numbers, |r| {
            let a = r.direction();
            let b = a + r.direction() * r.positive(1e-4, 2.0);
            (a, math::normalize_or(b, a), r.positive(1.0, 256.0), r.positive(0.15, 1.0))
        }),
        strict: each(|(a, b, n, s): &Gloss| {
            [gaussian::specular_weight(gaussian::one_minus_cosine(*a, *b), *n, *s)]
        }),
        others: vec![(
            NATIVE,
            each(|(a, b, n, s): &Gloss| {
                let gap = (0.5 * (*a - *b).length_squared()).min(1.0);
                let q = -(n * (-gap).ln_1p()).exp_m1() / s;
                [(-0.5 * q * q).exp() / (s * std::f32::consts::TAU.sqrt())]
            }),
        )],
        error: Box::new(|_, x, got| relative(got[0], truth(x))),
        device: Some(OnDevice {
            work: Box::new(|all: &[Gloss]| {
                let a = all.iter().map(|x| x.0.extend(0.0)).collect();
                let b = all.iter().map(|x| x.1.extend(0.0)).collect();
                let c = all.iter().map(|x| Vec4::new(x.2, x.3, 0.0, 0.0)).collect();
                Work::Gaussian(evaluate_gaussian::function::SPECULAR, [a, b, c])
            }),
            read: number::<3>,
            software: false,
        }),
    })
}

fn lobe_width(settings: &Settings) -> Box<dyn Measure> {
    scalar(
        Head::strict("lobe variance", "lengths 0.05 to 1", Unit::Absolute),
        list("variance", settings.numbers, |r| Vec4::new(r.range(0.05, 1.0), 0.0, 0.0, 0.0)),
        each(|x: &Vec4| [gaussian::length_to_variance(x.x)]),
        vec![(NATIVE, each(|x: &Vec4| [(1.0 - x.x) / x.x]))],
        |x| (1.0 - x.x) / x.x,
        gaussian_pass(evaluate_gaussian::function::LENGTHS, number::<0>),
    )
}

fn convolution(settings: &Settings) -> Box<dyn Measure> {
    scalar(
        Head::strict("lobe convolution", "lengths 0.01 to 1", Unit::Relative),
        list("convolution", settings.numbers, |r| {
            Vec4::new(r.range(0.01, 1.0), 0.0, 0.0, r.range(0.01, 1.0))
        }),
        each(|x: &Vec4| [gaussian::convolve_lengths(x.x, x.w)]),
        vec![(NATIVE, each(|x: &Vec4| [x.x * x.w / (x.x + x.w - x.x * x.w)]))],
        |x| x.x * x.w / (x.x + x.w - x.x * x.w),
        gaussian_pass(evaluate_gaussian::function::LENGTHS, number::<3>),
    )
}

fn cone_deviation(settings: &Settings) -> Box<dyn Measure> {
    scalar(
        Head::strict("cone deviation", "half angles 1e-3 to π/2", Unit::Relative),
        list("deviation", settings.numbers, |r| Vec4::new(r.range(1e-3, 1.57), 0.0, 0.0, 0.0)),
        each(|x: &Vec4| [gaussian::cone_deviation(x.x)]),
        vec![(NATIVE, each(|x: &Vec4| [(0.5 * x.x).tan()]))],
        |x| (0.5 * x.x).tan(),
        gaussian_pass(evaluate_gaussian::function::CONE_DEVIATION, number::<0>),
    )
}

/// Windows as wide as the distribution, where erf decides, and narrow ones, where a series does.
fn depth_windows(settings: &Settings) -> Vec<Box<dyn Measure>> {
    fn coverage(x: DVec4) -> f64 {
        let (d, scale) = (x.z - x.x, 1.0 / (x.y * 2f64.sqrt()));
        0.5 * (erf((d + x.w) * scale) - erf((d - x.w) * scale))
    }
    /// Simpson's rule, which does not cancel.
    fn narrow(x: DVec4) -> f64 {
        let density = |t: f64| (-0.5 * t * t).exp() / std::f64::consts::TAU.sqrt();
        let (d, h) = ((x.z - x.x) / x.y, x.w / x.y / 4.0);
        let at = |k: i32| density(d + f64::from(k) * h);
        h / 3.0 * (at(-4) + 4.0 * (at(-3) + at(-1) + at(1) + at(3)) + 2.0 * (at(-2) + at(0) + at(2)) + at(4))
    }
    let kernel = || each(|x: &Vec4| [gaussian::depth_coverage(x.x, x.y, x.z, x.w)]);
    let pass = || gaussian_pass(evaluate_gaussian::function::COVERAGE, number::<0>);
    let wide = list("wide windows", settings.numbers, |r| {
        Vec4::new(r.range(-1.0, 1.0), r.positive(0.05, 1.0), r.range(-1.0, 1.0), r.positive(0.05, 1.0))
    });
    let tight = list("narrow windows", settings.numbers, |r| {
        let deviation = r.positive(0.1, 1.0);
        Vec4::new(0.0, deviation, r.range(-3.0, 3.0) * deviation, deviation * r.positive(1e-6, 0.045))
    });
    let head = |variant, domain, unit| Head::new("depth window", variant, domain, unit);
    // 1.3e-7 + 0.4·2⁻²⁴(|centre| + |mean| + radius)/deviation, at the worst of the domain.
    let by_erf = head("wide", "deviation and radius 0.05 to 1", Unit::Absolute).stated(1.6e-6);
    let by_series = head("narrow", "radius below 0.045 deviations", Unit::Relative).stated(1e-5);
    vec![
        scalar(by_erf, wide, kernel(), Vec::new(), coverage, pass()),
        scalar(by_series, tight, kernel(), Vec::new(), narrow, pass()),
    ]
}

fn step_correction(settings: &Settings) -> Vec<Box<dyn Measure>> {
    fn truth(x: DVec4) -> f64 {
        -(x.y * (-x.x).ln_1p()).exp_m1()
    }
    let inputs = || {
        list("steps", settings.numbers, |r| {
            Vec4::new(r.positive(1e-7, 0.99), r.positive(1.0 / 16.0, 4.0), 0.0, 0.0)
        })
    };
    let domain = "opacity 1e-7 to 0.99, ratio 1/16 to 4";
    vec![
        scalar(
            Head::strict("step correction", domain, Unit::Relative).stated(3e-7),
            inputs(),
            each(|x: &Vec4| [cone::corrected_opacity(x.x, x.y)]),
            vec![
                (NATIVE, each(|x: &Vec4| [-(x.y * (-x.x).ln_1p()).exp_m1()])),
                ("naive", each(|x: &Vec4| [1.0 - (1.0 - x.x).powf(x.y)])),
            ],
            truth,
            cone_pass(evaluate_cone::function::OPACITY, number::<0>),
        ),
        scalar(
            Head::strict("premultiplied scale", domain, Unit::Relative).stated(4e-7),
            inputs(),
            each(|x: &Vec4| [cone::premultiplied_scale(x.x, x.y)]),
            vec![(NATIVE, each(|x: &Vec4| [-(x.y * (-x.x).ln_1p()).exp_m1() / x.x]))],
            |x| truth(x) / x.x,
            cone_pass(evaluate_cone::function::OPACITY, number::<1>),
        ),
    ]
}

fn compositing(settings: &Settings) -> Box<dyn Measure> {
    Box::new(Case {
        head: Head::strict("compositing", "premultiplied, 0 to 1", Unit::Absolute).stated(2.4e-7),
        inputs: list("compositing", settings.vectors, |r| {
            let mut sample =
                || r.unit() as f32 * Vec4::new(r.range(0.0, 1.0), r.range(0.0, 1.0), r.range(0.0, 1.0), 1.0);
            (sample(), sample())
        }),
        strict: each(|(a, b): &(Vec4, Vec4)| cone::composite(*a, *b).to_array()),
        others: Vec::new(),
        error: Box::new(|_, (a, b), got| {
            let truth = a.as_dvec4() + b.as_dvec4() * (1.0 - f64::from(a.w));
            (Vec4::from_array(*got).as_dvec4() - truth).abs().max_element()
        }),
        device: Some(OnDevice {
            work: Box::new(|all: &[(Vec4, Vec4)]| {
                let (a, b) = all.iter().copied().unzip();
                Work::Cone(evaluate_cone::function::COMPOSITE, [a, b])
            }),
            read: |words| [0, 1, 2, 3].map(|i| f32::from_bits(words[i])),
            software: false,
        }),
    })
}

/// No pass gives the level of a diameter alone.
fn mip_level(settings: &Settings) -> Box<dyn Measure> {
    scalar(
        Head::strict("mip level", "diameters 1 to 1024", Unit::Absolute),
        list("levels", settings.numbers, |r| Vec4::new(r.positive(1.0, 1024.0), 12.0, 0.0, 0.0)),
        each(|x: &Vec4| [cone::mip_level(x.x, x.y)]),
        vec![(NATIVE, each(|x: &Vec4| [x.x.log2().clamp(0.0, x.y)]))],
        |x| x.x.log2().clamp(0.0, x.y),
        None,
    )
}

fn aperture(settings: &Settings) -> Box<dyn Measure> {
    scalar(
        Head::strict("aperture tangent", "half angles 0.01 to 1.48", Unit::Relative),
        list("apertures", settings.numbers, |r| Vec4::new(r.range(0.01, 1.48), 1.0, 5.0, 1.0)),
        each(|x: &Vec4| [cone::aperture_tangent(x.x)]),
        vec![(NATIVE, each(|x: &Vec4| [x.x.tan()]))],
        |x| x.x.tan(),
        cone_pass(evaluate_cone::function::STEP, number::<0>),
    )
}
