//! Inputs of the passes over spherical harmonics.

use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::Vec4;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::evaluate_sh::{exponential, function};

const ITEMS: usize = 256;
/// Rows of the tables of logarithms and of the optimal linear exponential.
const ENTRIES: u32 = 40;

/// A vector of `count` coefficients that fall off with the band; now and then one that is 0, or only DC.
pub fn vector(draw: &mut Draw, count: usize, scale: f32) -> ShVector {
    let mut v = ShVector::default();
    let out: &mut [f32] = bytemuck::cast_slice_mut(std::slice::from_mut(&mut v));
    let used = match draw.integer(0, 16) {
        0 => 0,
        1 => 1,
        _ => count,
    };
    for (i, c) in out[..used].iter_mut().enumerate() {
        *c = draw.number(1e-3, 2.0) * scale / (1.0 + (i as f32).sqrt().floor());
    }
    v
}

/// A direction and a number in [0, 1].
fn argument(draw: &mut Draw) -> Vec4 {
    draw.direction().extend(draw.unit())
}

/// A smooth table of `bands` numbers a row, negative like logarithms.
fn table(draw: &mut Draw, bands: u32) -> Vec<f32> {
    let step = draw.uniform(0.01, 0.02);
    (0..ENTRIES * bands).map(|i| -0.5 - step * (i / bands) as f32 - 0.1 * (i % bands) as f32).collect()
}

macro_rules! linear {
    ($($linear:ident, $n:literal;)*) => {$(
        pub fn $linear(draw: &mut Draw) -> Vec<case::$linear> {
            (0..function::COUNT)
                .map(|f| case::$linear {
                    launch: Launch::new(format!("function {f}"), ITEMS, ITEMS as u32),
                    params: EvaluateParams { function: f, ..Default::default() },
                    a: (0..ITEMS).map(|_| vector(draw, $n, 1.0)).collect(),
                    b: (0..ITEMS).map(|_| vector(draw, $n, 1.0)).collect(),
                    arguments: (0..ITEMS).map(|_| argument(draw)).collect(),
                })
                .collect()
        }
    )*};
}

macro_rules! exponentials {
    ($($exponential:ident, $n:literal, $bands:literal;)*) => {$(
        pub fn $exponential(draw: &mut Draw) -> Vec<case::$exponential> {
            (0..exponential::COUNT)
                .map(|f| case::$exponential {
                    launch: Launch::new(format!("function {f}"), ITEMS, ITEMS as u32),
                    params: EvaluateParams { function: f, count: ENTRIES, ..Default::default() },
                    a: (0..ITEMS).map(|_| logarithm(draw, $n)).collect(),
                    arguments: (0..ITEMS)
                        .map(|_| match f {
                            exponential::SERIES => Vec4::splat(draw.integer(1, 9) as f32),
                            // sin θ of the blocker, radius of influence, width of the ramp.
                            exponential::LOGARITHM => {
                                Vec4::new(draw.unit(), draw.uniform(1.0, 20.0), draw.uniform(0.9, 3.0), 0.0)
                            }
                            _ => argument(draw),
                        })
                        .collect(),
                    table: table(draw, $bands),
                })
                .collect()
        }
    )*};
}

/// The logarithm of a visibility: DC not above 0, the rest no longer than DC.
fn logarithm(draw: &mut Draw, count: usize) -> ShVector {
    let scale = draw.positive(1e-2, 4.0);
    let mut v = vector(draw, count, 0.3 * scale);
    v.c0.x = -scale * draw.uniform(0.5, 2.0);
    v
}

linear! {
    evaluate_sh3, 9;
    evaluate_sh4, 16;
    evaluate_sh5, 25;
}

exponentials! {
    evaluate_sh3_exponential, 9, 3;
    evaluate_sh4_exponential, 16, 4;
}
