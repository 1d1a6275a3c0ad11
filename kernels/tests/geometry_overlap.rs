//! Are exactly the voxels reported that a triangle touches, or that it seals?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

#[path = "oracle/random.rs"]
mod random;
#[path = "oracle/vector64.rs"]
mod vector64;

use glam::{UVec3, Vec3};
use random::{Random, SPECIAL};
use twinlight_kernels::geometry::overlap::{overlaps_conservative, overlaps_thin};
use vector64::{Vector, exact};

type Triangle = [Vec3; 3];

/// The largest gap of a separating axis: > 0 apart, < 0 overlapping, 0 touching; exact for short dyadic
/// inputs.
///
/// `half` is half the cube's edge. Gaps are in units of the axis, which is normalised if `normalised`.
fn gap(t: &Triangle, voxel: UVec3, half: f64, normalised: bool) -> f64 {
    let centre = Vector([voxel.x, voxel.y, voxel.z].map(|v| f64::from(v) + 0.5));
    let v = t.map(|p| exact(p) - centre);
    let unit = [Vector([1.0, 0.0, 0.0]), Vector([0.0, 1.0, 0.0]), Vector([0.0, 0.0, 1.0])];
    let edges = [v[1] - v[0], v[2] - v[1], v[0] - v[2]];
    let mut axes: Vec<Vector> = unit.to_vec();
    axes.push(edges[0].cross(edges[1]));
    for e in edges {
        axes.extend(unit.map(|u| e.cross(u)));
    }
    let mut largest = f64::NEG_INFINITY;
    for axis in axes {
        let length = axis.length();
        if length == 0.0 {
            continue;
        }
        let p = v.map(|q| q.dot(axis));
        let extent = half * (axis.0[0].abs() + axis.0[1].abs() + axis.0[2].abs());
        let apart = (p[0].min(p[1]).min(p[2]) - extent).max(-extent - p[0].max(p[1]).max(p[2]));
        largest = largest.max(if normalised { apart / length } else { apart });
    }
    largest
}

/// Whether the triangle meets the voxel's axis cross with half length `half`; exact for short dyadic inputs.
fn meets_cross(t: &Triangle, voxel: UVec3, half: f64) -> bool {
    let centre = Vector([voxel.x, voxel.y, voxel.z].map(|v| f64::from(v) + 0.5));
    let v = t.map(|p| (exact(p) - centre).0);
    (0..3).any(|z| {
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let side = |i: usize, j: usize| v[i][x] * v[j][y] - v[i][y] * v[j][x];
        let (of_a, of_b, of_c) = (side(1, 2), side(2, 0), side(0, 1));
        let area = of_a + of_b + of_c;
        let inside =
            (of_a >= 0.0 && of_b >= 0.0 && of_c >= 0.0) || (of_a <= 0.0 && of_b <= 0.0 && of_c <= 0.0);
        let height = of_a * v[0][z] + of_b * v[1][z] + of_c * v[2][z];
        inside && area != 0.0 && height.abs() <= half * area.abs()
    })
}

/// Corners on a lattice of 1/steps: everything the oracles compute is exact, and touching is common.
fn lattice_triangle(random: &mut Random, size: u32, steps: u32) -> Triangle {
    let mut point = || {
        let mut c = || random.below(size * steps + 1) as f32 / steps as f32;
        Vec3::new(c(), c(), c())
    };
    [point(), point(), point()]
}

fn voxels(n: u32) -> impl Iterator<Item = UVec3> {
    (0..n * n * n).map(move |i| UVec3::new(i % n, i / n % n, i / (n * n)))
}

#[test]
fn conservative_reports_every_touched_voxel_and_no_distant_one() {
    let mut random = Random::new(1);
    let (mut touched, mut only_touched, mut surplus, mut open_missed) = (0, 0, 0, 0);
    for round in 0..6000 {
        let steps = [1, 2, 4, 64, 1024][round % 5];
        let mut t = lattice_triangle(&mut random, 5, steps);
        match round % 7 {
            0 => t[2] = t[1],
            1 => t = [t[0], t[0], t[0]],
            2 => t[2] = (t[0] + t[1]) * 0.5,
            3 => t = t.map(|v| Vec3::new(v.x, 2.0, v.z)),
            _ => {}
        }
        for voxel in voxels(5) {
            let apart = gap(&t, voxel, 0.5, false);
            let got = overlaps_conservative(t[0], t[1], t[2], voxel);
            if apart <= 0.0 {
                touched += 1;
                only_touched += u32::from(apart == 0.0);
                assert!(got, "{t:?} {voxel}");
                // Planted fault: a box without its skin loses what it only touches.
                open_missed += u32::from(gap(&t, voxel, 0.5 - 1e-6, false) > 0.0);
            } else if got {
                surplus += 1;
                assert!(gap(&t, voxel, 0.5, true) < 1e-5, "{t:?} {voxel}");
            }
        }
    }
    println!("{touched} touched, {only_touched} only at the surface, {surplus} reported beyond");
    assert!(touched > 50_000 && only_touched > 10_000 && surplus < touched / 100);
    assert!(open_missed > 1000, "the planted fault was not seen");
}

#[test]
fn conservative_holds_for_any_f32_and_far_from_the_origin() {
    let mut random = Random::new(2);
    let (mut touched, mut surplus) = (0, 0);
    for round in 0..200_000 {
        let corner = UVec3::splat([0, 500, 2000][round % 3]);
        let base = Vec3::splat(corner.x as f32 + 0.5);
        let size = random.log_uniform(0.1, 300.0).abs();
        let a = base + random.point(1.0);
        let t = [
            a,
            a + random.point(size),
            if round % 4 == 0 { a + random.point(1e-3) } else { a + random.point(size) },
        ];
        let got = overlaps_conservative(t[0], t[1], t[2], corner);
        let apart = gap(&t, corner, 0.5, true);
        if apart <= 0.0 {
            touched += 1;
            assert!(got, "{t:?}");
        } else if got {
            surplus += 1;
            assert!(apart < 1e-3, "{t:?} {apart}");
        }
    }
    println!("{touched} touched, {surplus} reported beyond");
    assert!(touched > 50_000 && surplus < 500);
}

#[test]
fn thin_reports_the_voxels_whose_cross_is_met() {
    let mut random = Random::new(3);
    let (mut met, mut conservative, mut surplus) = (0, 0, 0);
    for round in 0..6000 {
        let steps = [1, 2, 4, 64, 1024][round % 5];
        let t = lattice_triangle(&mut random, 5, steps);
        for voxel in voxels(5) {
            let got = overlaps_thin(t[0], t[1], t[2], voxel);
            let truth = meets_cross(&t, voxel, 0.5);
            met += u32::from(truth);
            assert!(got || !truth, "{t:?} {voxel}");
            if got {
                assert!(overlaps_conservative(t[0], t[1], t[2], voxel), "thin is not within conservative");
                surplus += u32::from(!truth);
                assert!(meets_cross(&t, voxel, 0.500_01), "{t:?} {voxel}");
            }
            conservative += u32::from(overlaps_conservative(t[0], t[1], t[2], voxel));
        }
    }
    println!("{met} met, {surplus} reported beyond, {conservative} conservative");
    assert!(met > 10_000 && surplus < met / 100 && conservative > 2 * met);
}

#[test]
fn thin_voxels_of_a_closed_surface_seal_it() {
    let mut random = Random::new(4);
    const N: u32 = 24;
    for round in 0..30 {
        // An octahedron with random corners around the middle; corners on voxel centres half of the time.
        let middle = Vec3::splat(12.5);
        let mut reach = || {
            let r = random.range(3.0, 11.0);
            if round % 2 == 0 { r.floor() } else { r }
        };
        let x = [middle + Vec3::X * reach(), middle - Vec3::X * reach()];
        let y = [middle + Vec3::Y * reach(), middle - Vec3::Y * reach()];
        let z = [middle + Vec3::Z * reach(), middle - Vec3::Z * reach()];
        let mut solid = vec![false; (N * N * N) as usize];
        for i in 0..8 {
            // One face left out: the planted fault.
            if round % 5 == 4 && i == 0 {
                continue;
            }
            let t = [x[i & 1], y[i >> 1 & 1], z[i >> 2]];
            for (n, voxel) in voxels(N).enumerate() {
                solid[n] |= overlaps_thin(t[0], t[1], t[2], voxel);
            }
        }
        let index = |v: [i32; 3]| ((v[2] * N as i32 + v[1]) * N as i32 + v[0]) as usize;
        let mut stack = vec![[0i32; 3]];
        let mut seen = vec![false; solid.len()];
        while let Some(v) = stack.pop() {
            if v.iter().any(|&c| c < 0 || c >= N as i32) || seen[index(v)] || solid[index(v)] {
                continue;
            }
            seen[index(v)] = true;
            for axis in 0..3 {
                for step in [-1, 1] {
                    let mut next = v;
                    next[axis] += step;
                    stack.push(next);
                }
            }
        }
        assert_eq!(seen[index([12; 3])], round % 5 == 4, "round {round}");
    }
}

#[test]
fn degenerate_and_wild_triangles() {
    let voxel = UVec3::new(1, 1, 1);
    let p = Vec3::splat(1.5);
    assert!(overlaps_conservative(p, p, p, voxel) && !overlaps_thin(p, p, p, voxel));
    let on_face = [Vec3::new(0.0, 2.0, 0.0), Vec3::new(3.0, 2.0, 0.0), Vec3::new(0.0, 2.0, 3.0)];
    for y in [1, 2] {
        let voxel = UVec3::new(1, y, 1);
        assert!(overlaps_conservative(on_face[0], on_face[1], on_face[2], voxel));
        assert!(overlaps_thin(on_face[0], on_face[1], on_face[2], voxel));
    }
    assert!(!overlaps_conservative(on_face[0], on_face[1], on_face[2], UVec3::new(1, 0, 1)));
    for bad in SPECIAL {
        let t = [Vec3::new(bad, 1.0, 1.0), p, p + Vec3::X];
        let (c, thin) =
            (overlaps_conservative(t[0], t[1], t[2], voxel), overlaps_thin(t[0], t[1], t[2], voxel));
        if !bad.is_finite() {
            assert!(!c && !thin, "{bad}");
        }
    }
}
