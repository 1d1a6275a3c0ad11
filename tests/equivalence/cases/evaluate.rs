//! Inputs of the passes that evaluate single kernels.
//!
//! Where a formula cancels or a driver's function is only good near 0, the whole domain is compared strictly and a
//! tamer part in fast mode too.

use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::{UVec4, Vec3, Vec4};
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::{
    elementary, evaluate_cone as cone, evaluate_gaussian as gaussian, evaluate_geometry as geometry,
    evaluate_sampling as sampling, evaluate_vector as vector,
};

const ITEMS: usize = 1000;
const LARGEST: f32 = 3.4e38;
const LEAST: f32 = f32::MIN_POSITIVE;

fn list<T>(draw: &mut Draw, mut one: impl FnMut(&mut Draw) -> T) -> Vec<T> {
    (0..ITEMS).map(|_| one(draw)).collect()
}

fn launch(label: &str) -> Launch {
    Launch::new(label, ITEMS, ITEMS as u32)
}

fn params(function: u32) -> EvaluateParams {
    EvaluateParams { function, ..Default::default() }
}

type Number = fn(&mut Draw) -> f32;

pub fn evaluate_elementary(draw: &mut Draw) -> Vec<case::evaluate_elementary> {
    use elementary::function::*;
    let any: Number = |d| d.number(LEAST, LARGEST);
    let positive: Number = |d| d.positive(LEAST, LARGEST);
    let moderate: Number = |d| d.number(1e-18, 1e18);
    let exponent: Number = |d| d.number(1e-9, 87.0);
    let near: Number = |d| d.uniform(-3.2, 3.2);
    // (name, function, x, y, compared in fast mode).
    let all: [(&str, u32, Number, Number, bool); 34] = [
        ("exp2", EXP2, |d| d.number(1e-9, 126.0), any, true),
        ("exp2 anywhere", EXP2, any, any, false),
        ("exp", EXP, exponent, any, true),
        ("exp anywhere", EXP, any, any, false),
        ("exp - 1", EXP_MINUS_ONE, |d| d.number(1e-30, 88.0), any, true),
        ("exp - 1 anywhere", EXP_MINUS_ONE, any, any, false),
        ("log2", LOG2, positive, any, true),
        ("log2 near 1", LOG2, |d| d.uniform(0.9, 1.1), any, true),
        ("log2 anywhere", LOG2, any, any, false),
        ("ln", LN, positive, any, true),
        ("ln near 1", LN, |d| d.uniform(0.9, 1.1), any, true),
        ("ln(1 + x)", LN_ONE_PLUS, |d| d.number(1e-30, 0.999), any, true),
        ("ln(1 + x) anywhere", LN_ONE_PLUS, any, any, false),
        ("sin of turns", SIN_TURN, |d| d.number(1e-9, 100.0), any, true),
        ("cos of turns", COS_TURN, |d| d.number(1e-9, 100.0), any, true),
        ("sin of many turns", SIN_TURN, any, any, false),
        ("cos of many turns", COS_TURN, any, any, false),
        ("sin", SIN, near, any, true),
        ("cos", COS, near, any, true),
        ("sin of large angles", SIN, |d| d.number(1e-30, 8192.0), any, false),
        ("cos of large angles", COS, |d| d.number(1e-30, 8192.0), any, false),
        ("acos", ACOS, |d| d.number(1e-9, 1.5), any, true),
        ("acos near 1", ACOS, |d| 1.0 - d.positive(1e-7, 1e-2), any, true),
        ("atan2", ATAN2, moderate, moderate, true),
        ("erf", ERF, |d| d.number(1e-30, 10.0), any, true),
        ("pow, fast", POW_FAST, |d| d.positive(1e-2, 1e2), |d| d.number(1e-3, 10.0), true),
        // 0 to a negative power is +∞ only in strict mode.
        ("pow", POW, |d| non_zero(d.positive(1e-2, 1e2)), |d| d.number(1e-3, 10.0), true),
        ("pow anywhere", POW, any, moderate, false),
        ("1/sqrt", RSQRT, positive, any, true),
        ("sqrt", SQRT, positive, any, true),
        ("quotient", DIV, moderate, moderate, true),
        ("floor", FLOOR, any, any, true),
        ("to an integer", TO_INTEGER, any, any, true),
        ("product", MULTIPLY, any, any, true),
    ];
    let mut cases = Vec::new();
    let probes: [(&str, u32, Number, Number, bool); 3] = [
        ("sum less a summand", ADD_SUBTRACT, moderate, moderate, false),
        ("product plus a factor", MULTIPLY_ADD, moderate, moderate, false),
        ("quotient of anything but 0", DIV, any, |d| non_zero(d.number(LEAST, LARGEST)), false),
    ];
    for (name, function, x, y, fast) in all.into_iter().chain(probes) {
        let launch = if fast { launch(name) } else { launch(name).strict_only() };
        cases.push(case::evaluate_elementary {
            launch,
            params: ElementaryParams { function, ..Default::default() },
            x: list(draw, x),
            y: list(draw, y),
        });
    }
    cases
}

fn non_zero(x: f32) -> f32 {
    if x == 0.0 { 1.0 } else { x }
}

pub fn evaluate_vector(draw: &mut Draw) -> Vec<case::evaluate_vector> {
    use vector::function::*;
    let direction: fn(&mut Draw) -> Vec4 = |d| d.direction().extend(0.0);
    let near: fn(&mut Draw) -> Vec4 = |d| d.numbers(1e-3, 10.0);
    let mut cases = Vec::new();
    for function in 0..COUNT {
        let draw_a = match function {
            TANGENT | BITANGENT => direction,
            EXPONENTS => |d: &mut Draw| Vec4::new(d.unit(), d.number(1e-3, 1e10), d.number(1e-3, 1e10), 0.0),
            _ => near,
        };
        cases.push(case::evaluate_vector {
            launch: launch(&format!("function {function}")),
            params: params(function),
            a: list(draw, draw_a),
            b: list(draw, near),
        });
        if !matches!(function, TANGENT | BITANGENT | EXPONENTS) {
            // Sums of products that cancel are not worth a digit in fast mode.
            let wide: fn(&mut Draw) -> Vec4 =
                if function == NORMALIZE { |d| d.numbers(1e-37, 1e38) } else { |d| d.numbers(1e-12, 1e12) };
            cases.push(case::evaluate_vector {
                launch: launch(&format!("function {function}, wide range")).strict_only(),
                params: params(function),
                a: list(draw, wide),
                b: list(draw, wide),
            });
        }
    }
    cases
}

pub fn evaluate_sampling(draw: &mut Draw) -> Vec<case::evaluate_sampling> {
    use sampling::function::*;
    let mut cases = Vec::new();
    for function in 0..COUNT {
        let words = list(draw, |d| match function {
            VOXEL_NUMBER | VOXEL_OF => {
                UVec4::new(d.integer(0, 600), d.integer(0, 600), d.integer(1, 600), d.word())
            }
            CONE | CONE_TANGENT => UVec4::new(d.integer(0, 40), d.integer(0, 40), 0, 0),
            _ => d.words(),
        });
        let x = list(draw, |d| match function {
            ROULETTE => Vec4::new(d.positive(1e-3, 1e9), d.number(1e-3, 2.0), d.number(1e-9, 100.0), 0.0),
            POSITION_HASH => d.numbers(1e-6, 1e9),
            VOXEL_OF => d.numbers(1e-3, 1e3),
            CONE | CONE_TANGENT => Vec4::new(d.number(1e-3, 2.0), 0.0, 0.0, 0.0),
            // cosines, squared distance, area; a point and an area.
            FORM_FACTOR => Vec4::new(d.unit(), d.unit(), d.positive(1e-3, 10.0), d.positive(1e-6, 1.0)),
            ATTENUATION => Vec4::new(d.positive(1e-9, 1e9), d.positive(1e-3, 1e3), 0.0, 0.0),
            _ => d.units(),
        });
        let y = list(draw, |d| match function {
            POSITION_HASH => Vec4::splat(d.positive(1e-2, 1e2)),
            VOXEL_OF => Vec4::new(d.uniform(-9.0, 9.0), d.uniform(-9.0, 9.0), 0.0, d.positive(1e-1, 1e1)),
            COSINE_HEMISPHERE => d.direction().extend(0.0),
            _ => d.numbers(1e-2, 10.0),
        });
        cases.push(case::evaluate_sampling {
            launch: launch(&format!("function {function}")),
            params: params(function),
            words,
            x,
            y,
        });
    }
    cases
}

/// A ray toward a point, of any length of direction: (origin, start) and (direction, end).
fn ray_toward(draw: &mut Draw, target: Vec3) -> (Vec4, Vec4) {
    let origin = draw.point(4.0);
    let mut direction = target - origin;
    if draw.rarely(2) {
        direction *= draw.positive(0.25, 16.0);
    }
    match draw.integer(0, 16) {
        0 => direction = draw.direction(),
        1 => direction = Vec3::X,
        2 => direction = Vec3::new(0.0, direction.y, 0.0),
        _ => {}
    }
    let start = if draw.rarely(8) { draw.uniform(0.0, 2.0) } else { 0.0 };
    let end = if draw.rarely(8) { draw.uniform(0.0, 4.0) } else { 1e30 };
    (origin.extend(start), direction.extend(end))
}

/// A point of a triangle, sometimes on an edge or a corner.
fn point_of(draw: &mut Draw, [a, b, c]: [Vec3; 3]) -> Vec3 {
    let (mut u, mut v) = (draw.unit(), draw.unit());
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    a * (1.0 - u - v) + b * u + c * v
}

pub fn evaluate_geometry(draw: &mut Draw) -> Vec<case::evaluate_geometry> {
    use geometry::function::*;
    let mut cases = Vec::new();
    for function in 0..COUNT {
        let mut inputs: [Vec<Vec4>; 5] = Default::default();
        for _ in 0..ITEMS {
            let one = match function {
                DISC => disc(draw),
                BOX | FOUR_BOXES => box_(draw),
                TRIANGLE | FOUR_TRIANGLES => triangle(draw),
                VOXEL_WALK => walk(draw),
                _ => overlap(draw),
            };
            for (all, value) in inputs.iter_mut().zip(one) {
                all.push(value);
            }
        }
        let [a, b, c, d, e] = inputs;
        cases.push(case::evaluate_geometry {
            launch: launch(&format!("function {function}")),
            params: EvaluateParams { function, count: 48, ..Default::default() },
            a,
            b,
            c,
            d,
            e,
        });
    }
    cases
}

fn disc(draw: &mut Draw) -> [Vec4; 5] {
    let centre = draw.point(2.0);
    let normal = draw.direction();
    let radius = draw.positive(1e-2, 2.0);
    let within = draw.direction().cross(normal) * (radius * draw.uniform(0.0, 1.5));
    let (a, b) = ray_toward(draw, centre + within);
    [a, b, centre.extend(radius), normal.extend(0.0), Vec4::ZERO]
}

fn box_(draw: &mut Draw) -> [Vec4; 5] {
    let lower = draw.point(2.0);
    let mut size = Vec3::new(draw.uniform(0.0, 2.0), draw.uniform(0.0, 2.0), draw.uniform(0.0, 2.0));
    match draw.integer(0, 16) {
        0 => size.x = 0.0,
        1 => size.y = 0.0,
        2 => size.x = -size.x,
        _ => {}
    }
    let target = lower + size * Vec3::new(draw.unit(), draw.unit(), draw.uniform(-0.5, 1.5));
    let (a, b) = ray_toward(draw, target);
    [a, b, lower.extend(0.0), (lower + size).extend(0.0), Vec4::ZERO]
}

fn triangle(draw: &mut Draw) -> [Vec4; 5] {
    let mut corners = [draw.point(2.0), draw.point(2.0), draw.point(2.0)];
    if draw.rarely(16) {
        corners[2] = corners[1];
    }
    let target = point_of(draw, corners);
    let (a, b) = ray_toward(draw, target);
    [a, b, corners[0].extend(0.0), corners[1].extend(0.0), corners[2].extend(0.0)]
}

fn walk(draw: &mut Draw) -> [Vec4; 5] {
    let dims = Vec3::new(
        draw.integer(1, 40) as f32,
        draw.integer(1, 40) as f32,
        if draw.rarely(16) { 0.0 } else { draw.integer(1, 40) as f32 },
    );
    let inside = dims * Vec3::new(draw.unit(), draw.unit(), draw.unit());
    let mut origin = draw.point(50.0);
    if draw.rarely(2) {
        origin = dims * Vec3::new(draw.unit(), draw.unit(), draw.unit());
    }
    let mut direction = inside - origin;
    match draw.integer(0, 8) {
        0 => direction = draw.direction(),
        1 => direction = Vec3::new(1.0, 1.0, -1.0),
        2 => direction = Vec3::new(direction.x, 0.0, 0.0),
        _ => {}
    }
    let end = if draw.rarely(4) { draw.uniform(-0.1, 2.0) } else { 1e30 };
    [origin.extend(0.0), direction.extend(end), dims.extend(0.0), Vec4::ZERO, Vec4::ZERO]
}

fn overlap(draw: &mut Draw) -> [Vec4; 5] {
    let extent = draw.uniform(1.0, 8.0);
    let around = Vec3::splat(10.0);
    let corners = [draw.point(extent), draw.point(extent), draw.point(extent)].map(|p| p + around);
    let near = point_of(draw, corners) + draw.point(1.2);
    let voxel = near.floor().max(Vec3::ZERO);
    [voxel.extend(0.0), Vec4::ZERO, corners[0].extend(0.0), corners[1].extend(0.0), corners[2].extend(0.0)]
}

pub fn evaluate_gaussian(draw: &mut Draw) -> Vec<case::evaluate_gaussian> {
    use gaussian::function::*;
    let mut cases = Vec::new();
    for function in 0..COUNT {
        let (mut a, mut b, mut c) = (Vec::new(), Vec::new(), Vec::new());
        for _ in 0..ITEMS {
            let [p, q, r] = gaussian_inputs(draw, function);
            a.push(p);
            b.push(q);
            c.push(r);
        }
        cases.push(case::evaluate_gaussian {
            launch: launch(&format!("function {function}")),
            params: params(function),
            a,
            b,
            c,
        });
    }
    cases
}

fn gaussian_inputs(d: &mut Draw, function: u32) -> [Vec4; 3] {
    use gaussian::function::*;
    let zero = Vec4::ZERO;
    match function {
        LOBE => [(d.direction() * d.unit()).extend(0.0), zero, zero],
        LENGTHS => [Vec4::new(d.unit(), d.positive(1e-6, 1e6), d.unit(), d.unit()), zero, zero],
        CONE_DEVIATION => [Vec4::new(d.uniform(-0.1, 1.7), d.unit(), 0.0, 0.0), zero, zero],
        SPECULAR => {
            let axis = d.direction();
            let off = d.positive(1e-4, 2.0);
            let other = (axis + d.direction() * off).try_normalize().unwrap_or(axis);
            let of = Vec4::new(d.positive(1e-2, 1e3), d.positive(1e-2, 2.0), 0.0, 0.0);
            [axis.extend(0.0), other.extend(0.0), of]
        }
        UPSAMPLING => {
            let depth = d.positive(1e-2, 1e3);
            let mut near = || depth * d.uniform(0.99, 1.01);
            let depths = Vec4::new(near(), near(), near(), near());
            let (x, y) = (d.unit(), d.unit());
            let bilinear = Vec4::new((1.0 - x) * (1.0 - y), x * (1.0 - y), (1.0 - x) * y, x * y);
            [depths, bilinear, d.direction().extend(depth)]
        }
        SIMILARITY => {
            let n = d.direction();
            let of = Vec4::new(d.positive(1e-2, 10.0), d.positive(1e-2, 1.0), 0.0, 0.0);
            [n.extend(0.0), (n + d.point(0.1)).normalize_or(Vec3::Y).extend(0.0), of]
        }
        COVERAGE => {
            let deviation = if d.rarely(8) { 0.0 } else { d.positive(1e-3, 1.0) };
            [
                Vec4::new(d.uniform(-1.0, 1.0), deviation, d.uniform(-1.0, 1.0), d.positive(1e-6, 1.0)),
                zero,
                zero,
            ]
        }
        MOMENTS => {
            let (m, spread) = (d.uniform(-1.0, 1.0), d.positive(1e-3, 1.0));
            let moments = Vec4::new(m, m * m + spread * spread, d.number(1e-2, 10.0), d.number(1e-2, 10.0));
            let opacity = if d.rarely(8) { 0.0 } else { d.positive(0.1, 1.0) };
            [moments, Vec4::splat(opacity), Vec4::splat(d.positive(1e-3, 1e-1))]
        }
        LAYERS => {
            let (from, to) = (d.uniform(0.0, 1.0), d.uniform(1.0, 2.0));
            let overlap = if d.rarely(8) { 0.0 } else { d.uniform(1e-2, 0.5) };
            [Vec4::new(d.uniform(-0.5, 2.5), from, to, overlap), Vec4::splat(d.unit()), zero]
        }
        _ => {
            let limits = Vec4::new(d.positive(1e-2, 10.0), d.unit(), d.unit(), 0.0);
            [Vec4::new(d.unit(), d.unit(), d.number(1e-2, 10.0), 0.0), limits, zero]
        }
    }
}

pub fn evaluate_cone(draw: &mut Draw) -> Vec<case::evaluate_cone> {
    use cone::function::*;
    let mut cases = Vec::new();
    for function in 0..COUNT {
        let (mut a, mut b) = (Vec::new(), Vec::new());
        for _ in 0..ITEMS {
            let d = &mut *draw;
            let (p, q) = match function {
                OPACITY => {
                    let alpha = if d.rarely(2) { d.unit() } else { d.positive(1e-30, 1.0) };
                    (Vec4::new(alpha, d.positive(1e-6, 1e3), 0.0, 0.0), Vec4::ZERO)
                }
                SAMPLE => (d.units(), Vec4::splat(d.positive(1e-3, 1e2))),
                STEP => (
                    Vec4::new(
                        d.uniform(-0.1, 1.7),
                        d.positive(1e-3, 1e3),
                        d.integer(0, 12) as f32,
                        d.positive(1e-2, 1.0),
                    ),
                    Vec4::splat(d.positive(1e-3, 1e2)),
                ),
                FALLOFF => (
                    Vec4::new(d.number(1e-3, 1e6), d.positive(1e-3, 1e2), d.unit(), 0.0),
                    Vec4::new(d.positive(1e-1, 1e5), d.positive(1e-2, 1e1), d.positive(1e-3, 1e2), 0.0),
                ),
                _ => (d.units(), d.units()),
            };
            a.push(p);
            b.push(q);
        }
        cases.push(case::evaluate_cone {
            launch: launch(&format!("function {function}")),
            params: params(function),
            a,
            b,
        });
    }
    cases
}
