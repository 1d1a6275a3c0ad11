//! Exponentials of spherical harmonics by method, and the table of logarithms by entries.

use super::Settings;
use super::case::{Case, Each, Head, Measure, OnDevice, Unit, each, numbers};
use super::device::Work;
use super::draw::{Random, list};
use super::harmonics::vector;
use super::truth::{self, Algebra};
use crate::technique::soft_gi::{ENTRIES, log_occlusion_table, logarithm, optimal_linear_table};
use glam::Vec4;
use std::rc::Rc;
use twinlight_kernels::passes::evaluate_sh::exponential;
use twinlight_kernels::sh;

/// Every order, method and table.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let mut all = order::<2, 4>(settings, &|m| matches!(m, Method::Hybrid(tau) if *tau == 0.5));
    all.extend(order::<3, 9>(settings, &|_| true));
    all.extend(order::<4, 16>(settings, &|_| true));
    all.extend(order::<5, 25>(settings, &|m| matches!(m, Method::Hybrid(_))));
    all.extend(tables::<3, 9>(settings));
    all.extend(tables::<4, 16>(settings));
    all
}

/// How the exponential is taken.
enum Method {
    /// τ, up to 0.5.
    Hybrid(f32),
    /// τ above it.
    HybridWithTable(f32),
    OptimalLinear,
    /// τ.
    Taylor(f32),
    /// Terms.
    Series(u32),
}

impl Method {
    fn all() -> Vec<Self> {
        let mut all = vec![Self::OptimalLinear];
        all.extend([2.0, 1.0].map(Self::HybridWithTable));
        all.extend([0.5, 0.25, 0.125].map(Self::Hybrid));
        all.extend([1.0, 0.5].map(Self::Taylor));
        all.extend((3..=9).map(Self::Series));
        all
    }

    fn name(&self) -> String {
        match self {
            Self::Hybrid(tau) => format!("hybrid, τ {tau}"),
            Self::HybridWithTable(tau) => format!("hybrid with table, τ {tau}"),
            Self::OptimalLinear => "optimal linear".into(),
            Self::Taylor(tau) => format!("Taylor, τ {tau}"),
            Self::Series(terms) => format!("series, {terms} terms"),
        }
    }

    fn call<const N: usize>(&self, table: Rc<Vec<f32>>) -> Each<[f32; N], [f32; N]> {
        let entries = table.len() as u32 / 2;
        match *self {
            Self::Hybrid(tau) => each(move |f| sh::hybrid(f, tau)),
            Self::HybridWithTable(tau) => each(move |f| sh::hybrid_with_table(f, tau, &table, entries)),
            Self::OptimalLinear => each(move |f| sh::optimal_linear(f, &table, entries)),
            Self::Taylor(tau) => each(move |f| sh::taylor(f, tau)),
            Self::Series(terms) => each(move |f| sh::product_series(f, terms)),
        }
    }

    /// The function of the pass and its argument.
    fn selection(&self) -> (u32, Vec4) {
        let (function, x, w) = match *self {
            Self::Hybrid(tau) => (exponential::HYBRID, 0.0, tau),
            Self::HybridWithTable(tau) => (exponential::HYBRID_WITH_TABLE, 0.0, tau),
            Self::OptimalLinear => (exponential::OPTIMAL_LINEAR, 0.0, 1.0),
            Self::Taylor(tau) => (exponential::TAYLOR, 0.0, tau),
            Self::Series(terms) => (exponential::SERIES, terms as f32, 1.0),
        };
        (function, Vec4::new(x, 0.0, 0.0, w))
    }
}

/// The logarithm of what eight blockers over a hemisphere leave.
fn blockers<const B: usize, const N: usize>(r: &mut Random, table: &[f32]) -> [f32; N] {
    (0..8).fold([0.0; N], |sum, _| {
        let (mut d, alpha) = (r.direction(), r.positive(0.1, 0.7));
        d.z = d.z.abs();
        let zonal: [f32; B] = sh::log_occlusion(table, ENTRIES, sh::occlusion_key(alpha));
        sh::add_scaled(&sum, &sh::rotate_zonal(&zonal, d), 1.0)
    })
}

fn order<const B: usize, const N: usize>(
    settings: &Settings,
    wanted: &dyn Fn(&Method) -> bool,
) -> Vec<Box<dyn Measure>> {
    let logarithms = log_occlusion_table(B, ENTRIES as usize);
    let inputs = list("blockers", settings.sets, |r| blockers::<B, N>(r, &logarithms));
    let algebra = Algebra::new(B);
    let truths: Vec<Vec<f64>> = inputs.iter().map(|f| algebra.exponential(&truth::wide(f))).collect();
    let (truths, table) = (Rc::new(truths), Rc::new(optimal_linear_table(B)));
    let methods = Method::all().into_iter().filter(wanted);
    methods.map(|m| method::<B, N>(&m, &inputs, &truths, &table)).collect()
}

fn method<const B: usize, const N: usize>(
    method: &Method,
    inputs: &[[f32; N]],
    truths: &Rc<Vec<Vec<f64>>>,
    table: &Rc<Vec<f32>>,
) -> Box<dyn Measure> {
    let ((function, argument), truths, on_device) = (method.selection(), truths.clone(), table.clone());
    Box::new(Case {
        head: Head::new(
            "SH exponential",
            &format!("order {B}, {}", method.name()),
            "8 blockers, sin 0.1 to 0.7",
            Unit::Sphere,
        ),
        inputs: inputs.to_vec(),
        strict: method.call(table.clone()),
        others: Vec::new(),
        error: Box::new(move |i, _, got: &[f32; N]| truth::distance(got, &truths[i]) / truth::unit()),
        device: (B == 3 || B == 4).then(|| OnDevice {
            work: Box::new(move |all: &[[f32; N]]| {
                let entries = on_device.len() as u32 / 2;
                let vectors = all.iter().map(|f| vector(f)).collect();
                let arguments = vec![argument; all.len()];
                Work::Exponential(B as u32, function, vectors, arguments, on_device.to_vec(), entries)
            }),
            read: numbers::<N>,
            software: false,
        }),
    })
}

/// A zonal vector among all coefficients.
fn spread(zonal: &[f64]) -> Vec<f64> {
    let mut all = vec![0.0; zonal.len() * zonal.len()];
    zonal.iter().enumerate().for_each(|(l, c)| all[l * l + l] = *c);
    all
}

/// Lookups in tables of the logarithm: by how much the visibility of a blocker is off for the table.
fn tables<const B: usize, const N: usize>(settings: &Settings) -> Vec<Box<dyn Measure>> {
    let algebra = Rc::new(Algebra::new(B));
    let inputs = list("lookups", settings.sets, |r| r.positive(0.02, 0.7));
    let key = |alpha: f32| f64::from(alpha).powi(2) / (1.0 + (1.0 - f64::from(alpha).powi(2)).sqrt());
    let truths: Rc<Vec<Vec<f64>>> =
        Rc::new(inputs.iter().map(|a| algebra.exponential(&spread(&logarithm(B, key(*a))))).collect());
    let one = |entries: u32| -> Box<dyn Measure> {
        let (algebra, truths) = (algebra.clone(), truths.clone());
        let table = log_occlusion_table(B, entries as usize);
        let on_device = table.clone();
        Box::new(Case {
            head: Head::new(
                "log table",
                &format!("order {B}, {entries} entries"),
                "one blocker, sin 0.02 to 0.7",
                Unit::Sphere,
            ),
            inputs: inputs.clone(),
            strict: each(move |alpha: &f32| {
                sh::log_occlusion::<B>(&table, entries, sh::occlusion_key(*alpha))
            }),
            others: Vec::new(),
            error: Box::new(move |i, _, got: &[f32; B]| {
                let g = algebra.exponential(&spread(&truth::wide(got)));
                let difference: Vec<f64> = g.iter().zip(&truths[i]).map(|(a, b)| a - b).collect();
                truth::norm(&difference) / truth::unit()
            }),
            device: Some(OnDevice {
                work: Box::new(move |all: &[f32]| {
                    let arguments = all.iter().map(|alpha| Vec4::new(*alpha, 15.0, 2.0, 0.5)).collect();
                    let nothing = vec![vector(&[]); all.len()];
                    let table = on_device.clone();
                    Work::Exponential(B as u32, exponential::LOGARITHM, nothing, arguments, table, entries)
                }),
                read: numbers::<B>,
                software: false,
            }),
        })
    };
    [16, 32, 64, 128, 256].map(one).into_iter().collect()
}
