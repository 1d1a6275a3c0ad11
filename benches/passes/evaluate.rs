//! On which inputs are the passes timed that evaluate one kernel per item? The heaviest function of each.

use super::{COUNT, Case, Samples, map, vectors, words};
use glam::Vec3;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::{
    evaluate_cone as cone, evaluate_gaussian as gaussian, evaluate_geometry as geometry,
    evaluate_sampling as sampling, evaluate_sh as sh,
};

/// Items of the passes over spherical harmonics.
const SH_COUNT: u32 = 4096;

fn select(function: u32, count: u32) -> EvaluateParams {
    EvaluateParams { function, count, ..Default::default() }
}

/// Unit directions in the first octant, and a number in [0, 1) in w.
fn directions(count: u32) -> Vec<Vec4> {
    vectors(count).into_iter().map(|v| (v.truncate() + Vec3::splat(0.01)).normalize().extend(v.w)).collect()
}

fn coefficients(count: u32) -> Vec<ShVector> {
    vectors(7 * count)
        .chunks_exact(7)
        .map(|v| {
            let [c0, c4, c8, c12, c16, c20, c24] = [0, 1, 2, 3, 4, 5, 6].map(|i| v[i] * -0.3);
            ShVector { c0, c4, c8, c12, c16, c20, c24 }
        })
        .collect()
}

pub fn evaluate_vector(_: &Samples) -> Case<EvaluateParams, (Vec<Vec4>, Vec<Vec4>)> {
    map(select(0, 0), (vectors(COUNT), directions(COUNT)), COUNT)
}

pub fn evaluate_sampling(_: &Samples) -> Case<EvaluateParams, (Vec<UVec4>, Vec<Vec4>, Vec<Vec4>)> {
    let numbers = words(4 * COUNT).chunks_exact(4).map(UVec4::from_slice).collect();
    map(select(sampling::function::COSINE_HEMISPHERE, 0), (numbers, vectors(COUNT), vectors(COUNT)), COUNT)
}

type Geometry = (Vec<Vec4>, Vec<Vec4>, Vec<Vec4>, Vec<Vec4>, Vec<Vec4>);

pub fn evaluate_geometry(_: &Samples) -> Case<EvaluateParams, Geometry> {
    let origins = vectors(COUNT).into_iter().map(|v| (v.truncate() - Vec3::splat(1.0)).extend(0.0)).collect();
    let ends = directions(COUNT).into_iter().map(|v| v.truncate().extend(1.0e3)).collect();
    let corners = || vectors(COUNT);
    let inputs = (origins, ends, corners(), corners(), corners());
    map(select(geometry::function::FOUR_TRIANGLES, 0), inputs, COUNT)
}

pub fn evaluate_gaussian(_: &Samples) -> Case<EvaluateParams, (Vec<Vec4>, Vec<Vec4>, Vec<Vec4>)> {
    let inputs = (vectors(COUNT), vectors(COUNT), vectors(COUNT));
    map(select(gaussian::function::COVERAGE, 0), inputs, COUNT)
}

pub fn evaluate_cone(_: &Samples) -> Case<EvaluateParams, (Vec<Vec4>, Vec<Vec4>)> {
    map(select(cone::function::SAMPLE, 0), (vectors(COUNT), vectors(COUNT)), COUNT)
}

macro_rules! harmonics {
    ($($name:ident)*) => {$(
        pub fn $name(_: &Samples) -> Case<EvaluateParams, (Vec<ShVector>, Vec<ShVector>, Vec<Vec4>)> {
            let inputs = (coefficients(SH_COUNT), coefficients(SH_COUNT), directions(SH_COUNT));
            map(select(sh::function::PRODUCT, 0), inputs, SH_COUNT)
        }
    )*};
}
harmonics!(evaluate_sh3 evaluate_sh4 evaluate_sh5);

macro_rules! exponentials {
    ($($name:ident)*) => {$(
        pub fn $name(_: &Samples) -> Case<EvaluateParams, (Vec<ShVector>, Vec<Vec4>, Vec<f32>)> {
            let arguments = vec![Vec4::new(0.0, 0.0, 1.0, 0.5); SH_COUNT as usize];
            map(select(sh::exponential::HYBRID, 0), (coefficients(SH_COUNT), arguments, vec![0.0]), SH_COUNT)
        }
    )*};
}
exponentials!(evaluate_sh3_exponential evaluate_sh4_exponential);
