//! Which voxels rays pass, triangles occupy and points lie in.

use super::Settings;
use super::case::{Case, Head, Measure, NAIVE, Unit};
use super::device::{Work, split};
use super::draw::list;
use super::geometry::meet;
use super::truth;
use glam::{DVec3, UVec3, UVec4, Vec3, Vec4};
use twinlight_kernels::geometry::overlap::{overlaps_conservative, overlaps_thin};
use twinlight_kernels::geometry::voxel_walk::VoxelWalk;
use twinlight_kernels::passes::{evaluate_geometry, evaluate_sampling};
use twinlight_kernels::sampling::hash::{combine, hash, position_hash};
use twinlight_kernels::sampling::voxel_hash::{encode, voxel_of};

/// Five vectors, as the pass takes them.
type Scene = [Vec4; 5];

/// All of them.
pub(super) fn cases(settings: &Settings) -> Vec<Box<dyn Measure>> {
    vec![
        walk(settings, false),
        walk(settings, true),
        crossings(settings),
        overlap(settings, Overlap::Conservative),
        overlap(settings, Overlap::Lost),
        overlap(settings, Overlap::Thin),
        voxel(settings),
        cell(settings),
    ]
}

/// Voxels along an axis of the grid: enough for errors that add up.
const SIZE: u32 = 512;
const DIMS: UVec3 = UVec3::splat(SIZE);
/// More voxels than a ray meets.
const CELLS: u32 = 3 * SIZE;

/// Rays from outside of the grid, and from within.
fn ways(settings: &Settings) -> Vec<Scene> {
    list("walks", settings.vectors, |r| {
        let inside = |x: f32| (x + 1.0) * 0.5 * SIZE as f32;
        let (target, direction) = (r.point(1.0), r.direction());
        let target = Vec3::new(inside(target.x), inside(target.y), inside(target.z));
        let origin = target - direction * r.range(0.0, 512.0);
        [
            origin.extend(0.0),
            direction.extend(1e30),
            Vec3::splat(SIZE as f32).extend(0.0),
            Vec4::ZERO,
            Vec4::ZERO,
        ]
    })
}

/// Number, hash and last of the voxels so far.
type Met = [u32; 3];

fn add(met: Met, voxel: UVec3) -> Met {
    let last = encode(voxel, DIMS);
    [met[0] + 1, combine(met[1], last), last]
}

/// Where the ray crosses planes within the grid, first and last the grid's own or the origin, and the voxels between.
fn true_walk(o: DVec3, d: DVec3) -> (Vec<f64>, Met) {
    let (mut near, mut far) = (0.0f64, f64::INFINITY);
    let size = f64::from(SIZE);
    for k in 0..3 {
        let (a, b) = (-o[k] / d[k], (size - o[k]) / d[k]);
        (near, far) = (near.max(a.min(b)), far.min(a.max(b)));
    }
    if near >= far {
        return (Vec::new(), [0; 3]);
    }
    let planes = (0..3).flat_map(|k| (0..=SIZE).map(move |i| (f64::from(i) - o[k]) / d[k]));
    let mut all: Vec<f64> = planes.filter(|t| *t > near && *t < far).chain([near, far]).collect();
    all.sort_by(f64::total_cmp);
    let met =
        all.windows(2).fold([0; 3], |met, t| add(met, (o + d * (0.5 * (t[0] + t[1]))).floor().as_uvec3()));
    (all, met)
}

fn walked([o, d, ..]: &Scene) -> (Met, [f32; 2]) {
    let mut walk = VoxelWalk::new(o.truncate(), d.truncate(), DIMS, d.w);
    let (mut met, mut interval) = ([0; 3], [0.0; 2]);
    for _ in 0..CELLS {
        if walk.inside {
            met = add(met, walk.voxel);
            interval = [walk.t_enter, walk.t_exit];
            walk.step();
        }
    }
    (met, interval)
}

/// Amanatides and Woo as printed: distances add up.
fn added_up([o, d, ..]: &Scene) -> Met {
    let (o, d) = (o.truncate(), d.truncate());
    let size = SIZE as f32;
    let (a, b) = (-o / d, (Vec3::splat(size) - o) / d);
    let (near, far) = (a.min(b).max_element().max(0.0), a.max(b).min_element());
    let mut met = [0; 3];
    if near >= far {
        return met;
    }
    let start = (o + d * near).clamp(Vec3::ZERO, Vec3::splat(size - 1e-4)).floor();
    let (mut voxel, step) = (start.as_ivec3(), d.signum().as_ivec3());
    let mut next = (start + d.signum().max(Vec3::ZERO) - o) / d;
    for _ in 0..CELLS {
        met = add(met, voxel.as_uvec3());
        let k = next.min_position();
        voxel[k] += step[k];
        if voxel[k] < 0 || voxel[k] >= SIZE as i32 {
            break;
        }
        next[k] += 1.0 / d[k].abs();
    }
    met
}

fn walks(all: &[Scene]) -> Work {
    Work::Geometry(evaluate_geometry::function::VOXEL_WALK, CELLS, split(all))
}

const WAYS: &str = "512³ voxels, from in it or up to 512 outside";
const APART: &str = "the same, crossings 8·2⁻²⁴ t apart";

/// Whether two crossings are nearer to each other than 8 roundings: their order may change.
fn tied(o: DVec3, d: DVec3, crossed: &[f64]) -> bool {
    let margin = |t: f64| 8.0 * 2f64.powi(-24) * t.abs();
    let [near, far] = [crossed.first(), crossed.last()].map(|t| t.copied().unwrap_or(0.0));
    let planes = (0..3).flat_map(|k| (0..=SIZE).map(move |i| (f64::from(i) - o[k]) / d[k]));
    let mut all: Vec<f64> = planes.filter(|t| *t >= near - margin(near) && *t <= far + margin(far)).collect();
    all.push(near);
    all.sort_by(f64::total_cmp);
    // The entry is one of the planes' own crossings.
    all.dedup();
    all.windows(2).any(|t| t[1] - t[0] <= margin(t[1]))
}

/// Of all rays, and of those whose crossings are apart: their lists are exact.
fn walk(settings: &Settings, apart: bool) -> Box<dyn Measure> {
    let head = Head::strict("voxel walk", if apart { APART } else { WAYS }, Unit::Wrong);
    Case::new(
        if apart { head.stated(0.0) } else { head },
        ways(settings),
        |x| walked(x).0,
        move |[o, d, ..], got| {
            let (o, d) = (o.truncate().as_dvec3(), d.truncate().as_dvec3());
            let (crossed, met) = true_walk(o, d);
            if apart && tied(o, d, &crossed) { 0.0 } else { truth::wrong(got, &met) }
        },
    )
    .way(NAIVE, added_up)
    .on(walks, |words| [words[4], words[5], words[6]])
    .boxed()
}

/// Of the last voxel, where all are right.
fn crossings(settings: &Settings) -> Box<dyn Measure> {
    Case::new(
        Head::new("voxel walk", "last crossings", WAYS, Unit::Relative),
        ways(settings),
        |x| {
            let (met, interval) = walked(x);
            [interval[0], interval[1], met[0] as f32]
        },
        |[o, d, ..], got: &[f32; 3]| {
            let (all, met) = true_walk(o.truncate().as_dvec3(), d.truncate().as_dvec3());
            if met[0] == 0 || got[2] != met[0] as f32 {
                return 0.0;
            }
            truth::largest_relative(&got[..2], &all[all.len() - 2..])
        },
    )
    .on(walks, |words| [f32::from_bits(words[0]), f32::from_bits(words[1]), words[4] as f32])
    .boxed()
}

/// Which overlap, and whether only voxels that are missed count.
#[derive(Clone, Copy, PartialEq)]
enum Overlap {
    Conservative,
    Lost,
    Thin,
}

/// Whether anything is left of a triangle that is cut at the planes of a cube of edge 1 about 0.
fn cut([a, b, c]: [DVec3; 3]) -> bool {
    let mut polygon = vec![a, b, c];
    for (k, sign) in (0..3).flat_map(|k| [(k, 1.0), (k, -1.0)]) {
        let inside = |p: DVec3| 0.5 - sign * p[k];
        let mut rest = Vec::new();
        for (i, &p) in polygon.iter().enumerate() {
            let q = polygon[(i + 1) % polygon.len()];
            if inside(p) >= 0.0 {
                rest.push(p);
            }
            if (inside(p) >= 0.0) != (inside(q) >= 0.0) {
                rest.push(p + (q - p) * (inside(p) / (inside(p) - inside(q))));
            }
        }
        polygon = rest;
    }
    !polygon.is_empty()
}

/// Whether one of the segments of length 1 through 0 along the axes meets the triangle.
fn crossed(corners: [DVec3; 3]) -> bool {
    DVec3::AXES.iter().any(|axis| meet(*axis * -0.5, *axis, corners).is_some_and(|t| t <= 1.0))
}

fn overlap(settings: &Settings, asked: Overlap) -> Box<dyn Measure> {
    let inputs = list("overlaps", settings.numbers, |r| {
        let voxel = Vec3::new(r.range(0.0, 255.0), r.range(0.0, 255.0), r.range(0.0, 255.0)).floor();
        let corners = [0; 3].map(|_| voxel + Vec3::splat(0.5) + r.point(1.5));
        let [a, b, c] = corners.map(|p| p.max(Vec3::ZERO).extend(0.0));
        [voxel.extend(0.0), Vec4::ZERO, a, b, c]
    });
    let (kernel, variant) = match asked {
        Overlap::Conservative => ("overlap, conservative", "strict"),
        Overlap::Lost => ("overlap, conservative", "voxels lost"),
        Overlap::Thin => ("overlap, thin", "strict"),
    };
    let head = Head::new(kernel, variant, "corners within 1.5, coordinates to 256", Unit::Wrong);
    let read: fn(&[u32]) -> u32 = if asked == Overlap::Thin { |words| words[5] } else { |words| words[4] };
    Case::new(
        if asked == Overlap::Lost { head.stated(0.0) } else { head },
        inputs,
        move |[v, _, a, b, c]| {
            let overlaps = if asked == Overlap::Thin { overlaps_thin } else { overlaps_conservative };
            u32::from(overlaps(a.truncate(), b.truncate(), c.truncate(), v.truncate().as_uvec3()))
        },
        move |[v, _, a, b, c], got| {
            let centre = v.truncate().as_dvec3() + DVec3::splat(0.5);
            let corners = [a, b, c].map(|p| p.truncate().as_dvec3() - centre);
            let truth = if asked == Overlap::Thin { crossed(corners) } else { cut(corners) };
            match asked {
                Overlap::Lost => f64::from(u8::from(truth && *got == 0)),
                _ => truth::wrong(&(*got == 1), &truth),
            }
        },
    )
    .on(|all| Work::Geometry(evaluate_geometry::function::OVERLAP, 0, split(all)), read)
    .boxed()
}

/// Integers and two vectors, as the pass of samples takes them.
type Sample = (UVec4, [Vec4; 2]);

fn samples(function: u32) -> impl Fn(&[Sample]) -> Work {
    move |all| {
        let vectors: Vec<_> = all.iter().map(|s| s.1).collect();
        Work::Sampling(function, all.iter().map(|s| s.0).collect(), split(&vectors))
    }
}

/// Points in and a twentieth beyond a grid.
fn voxel(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("voxels", settings.numbers, |r| -> Sample {
        let lower = r.point(10.0);
        let inverse = r.positive(10.0, 1000.0);
        let point = lower + (r.point(0.55) + Vec3::splat(0.5)) * (SIZE as f32 / inverse);
        (DIMS.extend(0), [point.extend(0.0), lower.extend(inverse)])
    });
    Case::new(
        Head::strict("voxel of a point", "512³ voxels, and a twentieth beyond", Unit::Wrong),
        inputs,
        |(dims, [p, grid])| {
            voxel_of(p.truncate(), grid.truncate(), Vec3::splat(grid.w), dims.truncate()).to_array()
        },
        |(_, [p, grid]), got: &[u32; 3]| {
            let place = (p.truncate().as_dvec3() - grid.truncate().as_dvec3()) * f64::from(grid.w);
            let voxel = place.floor().clamp(DVec3::ZERO, DVec3::splat(f64::from(SIZE - 1)));
            truth::wrong(got, &voxel.as_uvec3().to_array())
        },
    )
    .on(samples(evaluate_sampling::function::VOXEL_OF), |words| [words[4], words[5], words[6]])
    .boxed()
}

fn cell(settings: &Settings) -> Box<dyn Measure> {
    let inputs = list("cells", settings.numbers, |r| -> Sample {
        (UVec4::ZERO, [r.point(10.0).extend(0.0), Vec4::splat(r.positive(1.0, 100.0))])
    });
    Case::new(
        Head::strict("hash of a place", "within 10, 1 to 100 cells of a length", Unit::Wrong),
        inputs,
        |(_, [p, cells])| position_hash(p.truncate(), cells.x),
        |(_, [p, cells]), got| {
            let cell = (p.truncate().as_dvec3() * f64::from(cells.x)).floor();
            let [x, y, z] = cell.to_array().map(|c| if c == 0.0 { 0 } else { (c as f32).to_bits() });
            truth::wrong(got, &combine(combine(hash(x), y), z))
        },
    )
    .on(samples(evaluate_sampling::function::POSITION_HASH), |words| words[4])
    .boxed()
}
