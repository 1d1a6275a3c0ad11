//! How long does one call of each kernel take on this CPU?
//!
//! `cargo bench -p twinlight-kernels` measures all, `cargo bench -p twinlight-kernels -- sh/` one topic. Each
//! iteration calls a kernel on 1024 different inputs, one after the other; the time of a call is the reported time
//! divided by 1024, or 1/throughput. Inputs and results pass through `black_box`, which keeps calls apart: a loop
//! that the compiler can turn into SIMD does better.
#![allow(missing_docs)]

use criterion::measurement::WallTime;
use criterion::{BenchmarkGroup, Criterion, Throughput, criterion_group, criterion_main};
use glam::{Mat3, Mat4, UVec3, UVec4, Vec2, Vec3, Vec4};
use std::hint::black_box;
use std::time::Duration;
use twinlight_kernels::geometry::{box_, bvh, disc, overlap, triangle, voxel_walk};
use twinlight_kernels::sampling::{attenuation, halton, hash, hemisphere, roulette, voxel_hash};
use twinlight_kernels::{cone, gaussian, math, sh};

/// Inputs per iteration.
const INPUTS: u32 = 1024;

/// Times `call` over the inputs as `name` of the group.
fn kernel<I, O>(group: &mut BenchmarkGroup<'_, WallTime>, name: &str, inputs: &[I], call: impl Fn(&I) -> O) {
    group.throughput(Throughput::Elements(inputs.len() as u64));
    group.bench_function(name, |b| {
        b.iter(|| {
            for input in black_box(inputs) {
                black_box(call(input));
            }
        });
    });
}

/// The inputs that `make` makes from a source of random numbers in [0, 1).
fn inputs<I>(make: impl Fn(&mut dyn FnMut() -> f32) -> I) -> Vec<I> {
    (0..INPUTS)
        .map(|i| {
            let mut state = hash::hash(i);
            make(&mut || {
                state = hash::hash(state);
                hash::unit_float(state)
            })
        })
        .collect()
}

fn within(random: &mut dyn FnMut() -> f32, low: f32, high: f32) -> f32 {
    low + (high - low) * random()
}

/// A point of the cube [−1, 1]³.
fn point(random: &mut dyn FnMut() -> f32) -> Vec3 {
    Vec3::new(within(random, -1.0, 1.0), within(random, -1.0, 1.0), within(random, -1.0, 1.0))
}

fn direction(random: &mut dyn FnMut() -> f32) -> Vec3 {
    hemisphere::uniform_sphere(Vec2::new(random(), random()))
}

fn elementary(c: &mut Criterion) {
    let mut group = c.benchmark_group("math");
    let group = &mut group;
    let signed = inputs(|r| within(r, -8.0, 8.0));
    let positive = inputs(|r| math::exp2(within(r, -20.0, 20.0)));
    let unit = inputs(|r| within(r, -1.0, 1.0));
    let pairs = inputs(|r| (math::exp2(within(r, -10.0, 10.0)), within(r, -8.0, 8.0)));
    kernel(group, "exp2", &signed, |x| math::exp2(*x));
    kernel(group, "exp", &signed, |x| math::exp(*x));
    kernel(group, "exp_minus_one", &signed, |x| math::exp_minus_one(*x));
    kernel(group, "log2", &positive, |x| math::log2(*x));
    kernel(group, "ln", &positive, |x| math::ln(*x));
    kernel(group, "ln_one_plus", &positive, |x| math::ln_one_plus(*x));
    kernel(group, "sin_cos_turn", &signed, |x| math::sin_cos_turn(*x));
    kernel(group, "sin_cos", &signed, |x| math::sin_cos(*x));
    kernel(group, "acos", &unit, |x| math::acos(*x));
    kernel(group, "atan2", &pairs, |(x, y)| math::atan2(*y, *x));
    kernel(group, "erf", &signed, |x| math::erf(*x));
    kernel(group, "pow", &pairs, |(x, y)| math::pow(*x, *y));
    kernel(group, "pow_fast", &pairs, |(x, y)| math::pow_fast(*x, *y));
    kernel(group, "powi_32", &unit, |x| math::powi(*x, 32));
    kernel(group, "rsqrt", &positive, |x| math::rsqrt(*x));
    kernel(group, "sqrt", &positive, |x| math::sqrt(*x));
    kernel(group, "sqrt_software", &positive, |x| math::strict::sqrt_software(*x));
    kernel(group, "div", &pairs, |(x, y)| math::div(*y, *x));
    kernel(group, "div_software", &pairs, |(x, y)| math::strict::div_software(*y, *x));
    kernel(group, "floor", &signed, |x| math::floor(*x));
}

/// The system's functions beside ours: what the same bits everywhere cost.
fn system(c: &mut Criterion) {
    let mut group = c.benchmark_group("math-system");
    let group = &mut group;
    let signed = inputs(|r| within(r, -8.0, 8.0));
    let positive = inputs(|r| math::exp2(within(r, -20.0, 20.0)));
    let unit = inputs(|r| within(r, -1.0, 1.0));
    let pairs = inputs(|r| (math::exp2(within(r, -10.0, 10.0)), within(r, -8.0, 8.0)));
    kernel(group, "exp2", &signed, |x| x.exp2());
    kernel(group, "exp", &signed, |x| x.exp());
    kernel(group, "log2", &positive, |x| x.log2());
    kernel(group, "ln", &positive, |x| x.ln());
    kernel(group, "sin_cos", &signed, |x| x.sin_cos());
    kernel(group, "acos", &unit, |x| x.acos());
    kernel(group, "atan2", &pairs, |(x, y)| y.atan2(*x));
    kernel(group, "pow", &pairs, |(x, y)| x.powf(*y));
    kernel(group, "sqrt", &positive, |x| x.sqrt());
    kernel(group, "floor", &signed, |x| x.floor());
}

fn vector(c: &mut Criterion) {
    let mut group = c.benchmark_group("vector");
    let group = &mut group;
    let points = inputs(point);
    let directions = inputs(direction);
    let matrix = Mat4::from_scale_rotation_translation(
        Vec3::splat(2.0),
        glam::Quat::from_rotation_y(0.5),
        Vec3::new(1.0, 2.0, 3.0),
    );
    kernel(group, "length", &points, |v| math::length(*v));
    kernel(group, "normalize_or", &points, |v| math::normalize_or(*v, Vec3::Y));
    kernel(group, "orthonormal_frame", &directions, |n| math::orthonormal_frame(*n));
    kernel(group, "transform_point", &points, |p| math::transform_point(&matrix, *p));
}

fn sampling(c: &mut Criterion) {
    let mut group = c.benchmark_group("sampling");
    let group = &mut group;
    let indices: Vec<u32> = (0..INPUTS).map(hash::hash).collect();
    let points = inputs(point);
    let uniform = inputs(|r| Vec2::new(r(), r()));
    let discs = inputs(|r| (point(r), direction(r), point(r), direction(r), r()));
    kernel(group, "hash", &indices, |i| hash::hash(*i));
    kernel(group, "position_hash", &points, |p| hash::position_hash(*p, 64.0));
    kernel(group, "halton", &indices, |i| halton::halton(*i));
    kernel(group, "radical_inverse_3", &indices, |i| halton::radical_inverse_3(*i));
    kernel(group, "radical_inverse_5", &indices, |i| halton::radical_inverse_5(*i));
    kernel(group, "radical_inverse_7", &indices, |i| halton::radical_inverse_7(*i));
    kernel(group, "cosine_hemisphere", &uniform, |u| hemisphere::cosine_hemisphere(*u));
    kernel(group, "uniform_sphere", &uniform, |u| hemisphere::uniform_sphere(*u));
    kernel(group, "to_world", &discs, |d| hemisphere::to_world(d.1, d.3));
    kernel(group, "cone", &indices, |i| hemisphere::cone(6, i % 6, 0.25));
    kernel(group, "sample_count", &indices, |i| roulette::sample_count(2.5, *i));
    kernel(group, "voxel_of", &points, |p| {
        voxel_hash::voxel_of(*p, Vec3::NEG_ONE, Vec3::splat(64.0), UVec3::splat(128))
    });
    kernel(group, "vpl_form_factor", &discs, |d| attenuation::vpl_form_factor(d.0, d.1, d.2, d.3, d.4));
}

/// A triangle about half as wide as the cube of points.
fn small_triangle(random: &mut dyn FnMut() -> f32) -> [Vec3; 3] {
    let centre = point(random);
    [0; 3].map(|_| centre + point(random) * 0.5)
}

fn geometry(c: &mut Criterion) {
    let mut group = c.benchmark_group("geometry");
    let group = &mut group;
    // Rays from far outside toward the cube, so that hits and misses both occur.
    let rays = inputs(|r| {
        let origin = direction(r) * 4.0;
        (origin, point(r) - origin)
    });
    let prepared: Vec<_> = rays
        .iter()
        .map(|(o, d)| (box_::BoxRay::new(*o, *d), triangle::TriangleRay::new(*o, *d), *o, *d))
        .collect();
    kernel(group, "box_ray", &rays, |(o, d)| box_::BoxRay::new(*o, *d));
    kernel(group, "triangle_ray", &rays, |(o, d)| triangle::TriangleRay::new(*o, *d));

    let node = four_random_boxes();
    kernel(group, "box_interval", &prepared, |(ray, ..)| {
        box_::box_interval(Vec3::splat(-0.5), Vec3::splat(0.5), ray, 0.0, 1e30)
    });
    kernel(group, "four_boxes", &prepared, |(ray, ..)| {
        let n = black_box(&node);
        box_::four_boxes(n.min_x, n.max_x, n.min_y, n.max_y, n.min_z, n.max_z, ray, 0.0, 1e30)
    });
    let triangles = inputs(small_triangle);
    let ray_and_triangle: Vec<_> = prepared.iter().zip(&triangles).collect();
    kernel(group, "ray_triangle", &ray_and_triangle, |((_, ray, ..), [a, b, c])| {
        triangle::ray_triangle(*a, *b, *c, ray, 0.0, 1e30)
    });
    let block = block_of(&triangles[..4], 0);
    kernel(group, "four_triangles", &prepared, |(_, ray, ..)| {
        let b = black_box(&block);
        triangle::four_triangles(b.x0, b.y0, b.z0, b.x1, b.y1, b.z1, b.x2, b.y2, b.z2, ray, 0.0, 1e30)
    });
    kernel(group, "ray_disc", &prepared, |(_, _, o, d)| {
        disc::ray_disc(*o, *d, Vec3::ZERO, Vec3::new(0.6, 0.0, 0.8), 0.7, 0.0, 1e30)
    });
    kernel(group, "voxel_walk_64", &rays, |(o, d)| {
        let lift = Vec3::splat(1.0);
        let mut walk = voxel_walk::VoxelWalk::new((*o + lift) * 32.0, *d * 32.0, UVec3::splat(64), 1e30);
        let mut sum = 0;
        while walk.inside {
            sum += walk.voxel.x;
            walk.step();
        }
        sum
    });
    // Coordinates in voxels of a 4³ grid: about half of the pairs overlap.
    let pairs = inputs(|r| {
        let t = small_triangle(r).map(|p| (p + Vec3::ONE) * 2.0);
        let at = ((t[0] + t[1] + t[2]) / 3.0).clamp(Vec3::ZERO, Vec3::splat(3.0)).as_uvec3();
        (t, UVec3::new(at.x, at.y, at.z + u32::from(r() < 0.5)))
    });
    kernel(group, "overlaps_conservative", &pairs, |([a, b, c], v)| {
        overlap::overlaps_conservative(*a, *b, *c, *v)
    });
    kernel(group, "overlaps_thin", &pairs, |([a, b, c], v)| overlap::overlaps_thin(*a, *b, *c, *v));
}

fn four_random_boxes() -> bvh::BvhNode {
    let corners = inputs(|r| (point(r), point(r)));
    let mut node = bvh::BvhNode::default();
    for (lane, (a, b)) in corners[..4].iter().enumerate() {
        set_bounds(&mut node, lane, a.min(*b), a.max(*b));
    }
    node
}

fn set_bounds(node: &mut bvh::BvhNode, lane: usize, lower: Vec3, upper: Vec3) {
    let (lower, upper) = box_::pad_bounds(lower, upper);
    (node.min_x[lane], node.max_x[lane]) = (lower.x, upper.x);
    (node.min_y[lane], node.max_y[lane]) = (lower.y, upper.y);
    (node.min_z[lane], node.max_z[lane]) = (lower.z, upper.z);
}

/// Up to four triangles, numbered from `first`.
fn block_of(triangles: &[[Vec3; 3]], first: u32) -> bvh::TriangleBlock {
    let mut b = bvh::TriangleBlock { triangles: UVec4::splat(bvh::NO_TRIANGLE), ..Default::default() };
    for (lane, [p, q, r]) in triangles.iter().enumerate() {
        (b.x0[lane], b.y0[lane], b.z0[lane]) = (p.x, p.y, p.z);
        (b.x1[lane], b.y1[lane], b.z1[lane]) = (q.x, q.y, q.z);
        (b.x2[lane], b.y2[lane], b.z2[lane]) = (r.x, r.y, r.z);
        b.triangles[lane] = first + lane as u32;
    }
    b
}

/// A tree over triangles, halved by count along the longest axis: no good tree, but always the same.
#[derive(Default)]
struct Tree {
    nodes: Vec<bvh::BvhNode>,
    blocks: Vec<bvh::TriangleBlock>,
}

impl Tree {
    fn new(mut triangles: Vec<[Vec3; 3]>) -> Self {
        let mut tree = Self::default();
        tree.node(&mut triangles);
        tree
    }

    fn node(&mut self, triangles: &mut [[Vec3; 3]]) -> u32 {
        let index = self.nodes.len();
        let (min, max) = (Vec4::splat(3e38), Vec4::splat(-3e38));
        self.nodes.push(bvh::BvhNode {
            min_x: min,
            max_x: max,
            min_y: min,
            max_y: max,
            min_z: min,
            max_z: max,
            children: UVec4::splat(bvh::NO_CHILD),
        });
        let (left, right) = halves(triangles);
        let ((a, b), (c, d)) = (halves(left), halves(right));
        for (lane, part) in [a, b, c, d].into_iter().enumerate() {
            if part.is_empty() {
                continue;
            }
            let (lower, upper) = bounds(part);
            let child = if part.len() <= 4 {
                self.blocks.push(block_of(part, 4 * self.blocks.len() as u32));
                bvh::LEAF | (self.blocks.len() as u32 - 1)
            } else {
                self.node(part)
            };
            set_bounds(&mut self.nodes[index], lane, lower, upper);
            self.nodes[index].children[lane] = child;
        }
        index as u32
    }
}

fn bounds(triangles: &[[Vec3; 3]]) -> (Vec3, Vec3) {
    let corners = triangles.iter().flatten();
    corners.fold((Vec3::MAX, Vec3::MIN), |(lower, upper), p| (lower.min(*p), upper.max(*p)))
}

fn halves(triangles: &mut [[Vec3; 3]]) -> (&mut [[Vec3; 3]], &mut [[Vec3; 3]]) {
    let (lower, upper) = bounds(triangles);
    let extent = upper - lower;
    let axis = (0..3).fold(0, |best, i| if extent[i] > extent[best] { i } else { best });
    triangles.sort_by(|s, t| (s[0] + s[1] + s[2])[axis].total_cmp(&(t[0] + t[1] + t[2])[axis]));
    let half = triangles.len() / 2;
    triangles.split_at_mut(half)
}

/// A wavy height field of 2 × 128 × 128 triangles, seen from above and along.
fn tree_walk(c: &mut Criterion) {
    const SIDE: u32 = 128;
    let height = |x: u32, z: u32| {
        let (x, z) = (x as f32 / SIDE as f32, z as f32 / SIDE as f32);
        Vec3::new(
            2.0 * x - 1.0,
            0.2 * math::sin_cos_turn(3.0 * x).0 * math::sin_cos_turn(2.0 * z).0,
            2.0 * z - 1.0,
        )
    };
    let mut triangles = vec![];
    for (x, z) in (0..SIDE * SIDE).map(|i| (i % SIDE, i / SIDE)) {
        let corners = [height(x, z), height(x + 1, z), height(x + 1, z + 1), height(x, z + 1)];
        triangles.push([corners[0], corners[1], corners[2]]);
        triangles.push([corners[0], corners[2], corners[3]]);
    }
    let tree = Tree::new(triangles);
    let ray = |origin: Vec3, to: Vec3| bvh::Ray { origin, direction: to - origin, t_min: 0.0, t_max: 1e30 };
    let from_above = inputs(|r| ray(direction(r).abs() * 3.0, point(r) * Vec3::new(1.0, 0.0, 1.0)));
    let along = inputs(|r| ray(Vec3::new(-1.5, 0.1, 0.0), point(r) * Vec3::new(0.5, 0.2, 1.0)));
    let mut group = c.benchmark_group("bvh");
    for (name, rays) in [("from_above", &from_above), ("along", &along)] {
        kernel(&mut group, &format!("nearest_hit/{name}"), rays, |ray| {
            bvh::nearest_hit(&tree.nodes, &tree.blocks, ray, &bvh::AcceptAll)
        });
        kernel(&mut group, &format!("any_hit/{name}"), rays, |ray| {
            bvh::any_hit(&tree.nodes, &tree.blocks, ray, &bvh::AcceptAll)
        });
    }
}

/// The kernels of one order: B bands, N = B² coefficients.
fn sh_order<const B: usize, const N: usize>(c: &mut Criterion) {
    let mut group = c.benchmark_group(format!("sh/order{B}"));
    let group = &mut group;
    let directions = inputs(direction);
    let vectors = inputs(|r| std::array::from_fn::<f32, N, _>(|_| within(r, -1.0, 1.0)));
    let pairs: Vec<_> = vectors.iter().zip(vectors.iter().skip(1).chain(&vectors[..1])).collect();
    // Logarithms of visibility: negative on the whole.
    let logarithms: Vec<_> = vectors
        .iter()
        .map(|v| {
            let mut f = *v;
            f[0] = -4.0 * v[0].abs();
            f
        })
        .collect();
    let rotations =
        inputs(|r| (Mat3::from_axis_angle(direction(r), 6.0 * r()), std::array::from_fn(|_| r())));
    let sines = inputs(|r| r());
    let table: Vec<f32> = inputs(|r| -r()).into_iter().take(64 * B).collect();
    kernel(group, "basis", &directions, |d| sh::basis::<N>(*d));
    kernel(group, "evaluate", &vectors, |v| sh::evaluate(v, Vec3::new(0.6, 0.0, 0.8)));
    kernel(group, "rotate", &rotations, |(m, v)| sh::rotate::<N>(m, v));
    kernel(group, "product", &pairs, |(a, b)| sh::product(a, b));
    kernel(group, "square", &vectors, sh::square);
    kernel(group, "hybrid", &logarithms, |f| sh::hybrid(f, 2.0));
    kernel(group, "taylor", &logarithms, |f| sh::taylor(f, 0.5));
    kernel(group, "product_series_8", &logarithms, |f| sh::product_series(f, 8));
    kernel(group, "clamp_to_feasible", &vectors, sh::clamp_to_feasible);
    kernel(group, "cap", &sines, |s| sh::cap::<B>(*s));
    kernel(group, "log_occlusion", &sines, |s| sh::log_occlusion::<B>(&table, 64, *s));
    kernel(group, "rotate_zonal", &directions, |d| sh::rotate_zonal::<B, N>(&[0.5; B], *d));
    kernel(group, "irradiance", &vectors, sh::irradiance::<B, N>);
}

fn spherical_harmonics(c: &mut Criterion) {
    sh_order::<2, 4>(c);
    sh_order::<3, 9>(c);
    sh_order::<4, 16>(c);
    sh_order::<5, 25>(c);
}

fn gaussians(c: &mut Criterion) {
    let mut group = c.benchmark_group("gaussian");
    let group = &mut group;
    let points = inputs(point);
    let triples = inputs(|r| (within(r, -1.0, 1.0), r(), within(r, 0.01, 0.5)));
    let samples = inputs(|r| gaussian::CoarseSamples {
        bilinear: [0.25; 4],
        depth: [0; 4].map(|_| within(r, 1.0, 1.1)),
        normal: [0; 4].map(|_| direction(r)),
    });
    kernel(group, "lobe_of_mean", &points, |p| gaussian::lobe_of_mean(*p, Vec3::Y));
    kernel(group, "convolve_lengths", &triples, |t| gaussian::convolve_lengths(t.1, t.2));
    kernel(group, "cone_deviation", &triples, |t| gaussian::cone_deviation(t.1));
    kernel(group, "von_mises_fisher_concentration", &triples, |t| {
        gaussian::von_mises_fisher_concentration(t.1)
    });
    kernel(group, "specular_weight", &triples, |t| gaussian::specular_weight(t.1, 64.0, t.2));
    kernel(group, "lobe_offset", &triples, |t| gaussian::lobe_offset(t.1, 64.0));
    kernel(group, "gaussian_falloff", &triples, |t| gaussian::gaussian_falloff(t.0, t.2));
    kernel(group, "geometric_weight", &triples, |t| gaussian::geometric_weight(t.0, t.1, t.2, 0.2));
    kernel(group, "normal_similarity", &points, |p| gaussian::normal_similarity(*p, Vec3::Y));
    kernel(group, "upsampling_weights", &samples, |s| gaussian::upsampling_weights(s, 1.05, Vec3::Y));
    kernel(group, "depth_coverage", &triples, |t| gaussian::depth_coverage(t.0, t.2, t.1, 0.3));
    kernel(group, "weighted_moments", &triples, |t| gaussian::weighted_moments(t.1, t.0, 1.0, 1e-3));
    kernel(group, "layer_decay", &triples, |t| gaussian::layer_decay(t.1, 0.0, 1.0, t.2, false, false));
}

fn cones(c: &mut Criterion) {
    let mut group = c.benchmark_group("cone");
    let group = &mut group;
    let samples = inputs(|r| (Vec4::new(r(), r(), r(), r()), within(r, 0.1, 4.0)));
    kernel(group, "mip_level", &samples, |(_, d)| cone::mip_level(8.0 * *d, 7.0));
    kernel(group, "step_length", &samples, |(_, d)| cone::step_length(*d, 1.0, 0.5));
    kernel(group, "corrected_opacity", &samples, |(s, ratio)| cone::corrected_opacity(s.w, *ratio));
    kernel(group, "corrected_sample", &samples, |(s, ratio)| cone::corrected_sample(*s, *ratio));
    kernel(group, "composite", &samples, |(s, _)| cone::composite(*s, Vec4::splat(0.5)));
    kernel(group, "distance_falloff", &samples, |(_, d)| cone::distance_falloff(*d, 2.0));
    kernel(group, "mean", &samples, |(s, d)| cone::ConeSum { weighted: *s, weight: *d }.mean(Vec4::ZERO));
}

criterion_group! {
    name = kernels;
    // About 130 kernels: half a second each.
    config = Criterion::default()
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_millis(400))
        .sample_size(30);
    targets = elementary, system, vector, sampling, geometry, tree_walk, spherical_harmonics, gaussians, cones
}
criterion_main!(kernels);
