//! Does the walk visit exactly the voxels that the ray crosses, in order?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

mod oracle;
#[path = "oracle/random.rs"]
mod random;

use glam::{UVec3, Vec3};
use oracle::{numbers, vector_file};
use random::{Random, SPECIAL};
use twinlight_kernels::geometry::voxel_walk::VoxelWalk;

type Cell = [u32; 3];

fn walk(origin: Vec3, direction: Vec3, dims: UVec3, t_max: f32) -> Vec<Cell> {
    let mut walk = VoxelWalk::new(origin, direction, dims, t_max);
    let mut cells = Vec::new();
    while walk.inside {
        assert!(walk.t_enter <= walk.t_exit && walk.t_exit <= t_max);
        cells.push(walk.voxel.to_array());
        walk.step();
        assert!(cells.len() <= (dims.x + dims.y + dims.z + 4) as usize);
    }
    assert!(!walk.step());
    cells
}

/// The walk that adds up distances: the planted fault.
fn accumulated(origin: Vec3, direction: Vec3, dims: UVec3, t_max: f32) -> Vec<Cell> {
    let walk = VoxelWalk::new(origin, direction, dims, t_max);
    let mut cells = Vec::new();
    if !walk.inside {
        return cells;
    }
    let mut cell = walk.voxel.to_array().map(|c| c as i32);
    let (mut next, mut delta, mut end) = ([f32::MAX; 3], [f32::MAX; 3], t_max);
    for i in 0..3 {
        if direction[i] != 0.0 {
            let forward = direction[i] > 0.0;
            next[i] = ((cell[i] + i32::from(forward)) as f32 - origin[i]) / direction[i];
            delta[i] = 1.0 / direction[i].abs();
            end = end.min(((if forward { dims[i] } else { 0 }) as f32 - origin[i]) / direction[i]);
        }
    }
    loop {
        cells.push(cell.map(|c| c as u32));
        let axis = if next[0] <= next[1] && next[0] <= next[2] {
            0
        } else if next[1] <= next[2] {
            1
        } else {
            2
        };
        if next[axis] >= end {
            return cells;
        }
        cell[axis] += if direction[axis] > 0.0 { 1 } else { -1 };
        if cell[axis] < 0 || cell[axis] >= dims[axis] as i32 {
            return cells;
        }
        next[axis] += delta[axis];
    }
}

/// The exact list of a ray whose crossings are all at least `margin`·t apart, else nothing.
///
/// Crossings are rounded once in float64, so they are ordered right wherever they are that far apart.
fn exact_list(origin: Vec3, direction: Vec3, dims: UVec3, t_max: f32, margin: f64) -> Option<Vec<Cell>> {
    let o = origin.to_array().map(f64::from);
    let d = direction.to_array().map(f64::from);
    let (mut begin, mut end) = (0.0f64, f64::from(t_max));
    for i in 0..3 {
        if d[i] == 0.0 {
            if o[i] < 0.0 || o[i] >= f64::from(dims[i]) {
                return Some(Vec::new());
            }
            continue;
        }
        let (a, b) = ((0.0 - o[i]) / d[i], (f64::from(dims[i]) - o[i]) / d[i]);
        begin = begin.max(a.min(b));
        end = end.min(a.max(b));
    }
    if (end - begin).abs() <= margin * end.abs().max(begin) {
        return None;
    }
    if begin >= end {
        return Some(Vec::new());
    }
    let mut events: Vec<(f64, usize)> = Vec::new();
    let mut ties = [0, 0];
    let mut cell = [0i64; 3];
    for i in 0..3 {
        let p = o[i] + begin * d[i];
        let on_entry_face = begin > 0.0 && (p - p.round()).abs() < 1e-9 * (1.0 + p.abs());
        let p = if on_entry_face { p.round() } else { p };
        let start = if d[i] < 0.0 { p.ceil() as i64 - 1 } else { p.floor() as i64 };
        cell[i] = start.clamp(0, i64::from(dims[i]) - 1);
        if d[i] != 0.0 {
            for boundary in 0..=dims[i] {
                let t = (f64::from(boundary) - o[i]) / d[i];
                let near = margin * t.abs().max(begin);
                ties[0] += i32::from(t == begin && begin > 0.0);
                ties[1] += i32::from(t == end);
                if t > begin + near && t < end - near {
                    events.push((t, i));
                } else if (t - begin).abs() <= near && t != begin || (t - end).abs() <= near && t != end {
                    return None;
                }
            }
        }
    }
    if ties[0] > 1 || ties[1] > 1 {
        return None;
    }
    events.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut cells = vec![cell.map(|c| c as u32)];
    let mut last = begin;
    for (t, i) in events {
        if t - last <= margin * t {
            return None;
        }
        last = t;
        cell[i] += if d[i] > 0.0 { 1 } else { -1 };
        cells.push(cell.map(|c| c as u32));
    }
    Some(cells)
}

/// 8 eps, the distance of crossings below which their order may change.
const MARGIN: f64 = 8.0 / 16_777_216.0;

#[test]
fn all_vectors_are_reproduced() {
    let file = vector_file("dda");
    let cases = file["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 58);
    let mut control = 0;
    for case in cases {
        let vector = |name: &str| {
            let v = numbers(&case[name]);
            Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
        };
        let dims = numbers(&case["dims"]);
        let dims = UVec3::new(dims[0] as u32, dims[1] as u32, dims[2] as u32);
        let t_max = case["tmax"].as_f64().expect("tmax") as f32;
        let cells: Vec<Cell> = case["cells"]
            .as_array()
            .expect("cells")
            .iter()
            .map(|c| {
                let c = numbers(c);
                [c[0] as u32, c[1] as u32, c[2] as u32]
            })
            .collect();
        let got = walk(vector("origin"), vector("dir"), dims, t_max);
        assert_eq!(got, cells, "{}", case["tag"]);
        assert_eq!(case["hit"].as_bool().expect("hit"), !cells.is_empty());
        // Planted fault: the list of the ray one voxel beside.
        control += u32::from(walk(vector("origin") + Vec3::ONE, vector("dir"), dims, t_max) != cells);
    }
    assert!(control > 50);
}

/// A ray through a grid of n³ voxels, from inside or outside.
fn random_ray(random: &mut Random, n: f32) -> (Vec3, Vec3) {
    let target = (random.point(0.5) + Vec3::splat(0.5)) * n;
    let origin = target + random.point(1.0) * n;
    let direction = (target - origin) * random.log_uniform(1e-4, 1e4).abs();
    (origin, if random.below(4) == 0 { random.direction() } else { direction })
}

#[test]
fn lists_equal_the_exact_ones_and_drift_is_seen() {
    let mut random = Random::new(1);
    for (n, rounds, expected_drift) in [(8u32, 20_000, 0.0), (512, 1500, 0.01), (2048, 400, 0.1)] {
        let dims = UVec3::splat(n);
        let (mut lists, mut voxels, mut drifted) = (0, 0, 0);
        for _ in 0..rounds {
            let (origin, direction) = random_ray(&mut random, n as f32);
            let t_max = if random.below(4) == 0 { random.unit() } else { 1e30 };
            let got = walk(origin, direction, dims, t_max);
            let Some(truth) = exact_list(origin, direction, dims, t_max, MARGIN) else { continue };
            assert_eq!(got, truth, "{origin:?} {direction:?} {t_max}");
            lists += 1;
            voxels += got.len();
            drifted += usize::from(accumulated(origin, direction, dims, t_max) != truth);
        }
        println!("{n}³: {lists} lists, {voxels} voxels, {drifted} accumulated lists differ");
        assert!(lists > 0 && voxels > 2000);
        assert!(drifted as f64 >= expected_drift * lists as f64, "the planted fault was not seen");
    }
}

/// The length of a ray's stay in a voxel, below 0 where it passes by; in float64.
fn stay(cell: &Cell, o: [f64; 3], d: [f64; 3]) -> (f64, f64) {
    let (mut enter, mut exit) = (0.0f64, f64::INFINITY);
    for i in 0..3 {
        let (low, high) = (f64::from(cell[i]) - o[i], f64::from(cell[i]) + 1.0 - o[i]);
        if d[i] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return (f64::NEG_INFINITY, 0.0);
            }
            continue;
        }
        enter = enter.max((low / d[i]).min(high / d[i]));
        exit = exit.min((low / d[i]).max(high / d[i]));
    }
    (exit - enter, exit)
}

#[test]
fn where_crossings_tie_voxels_are_at_most_touched() {
    let mut random = Random::new(12);
    let dims = UVec3::new(9, 9, 9);
    let (mut ties, mut worst, mut thin, mut of_drift) = (0, f64::INFINITY, 0, f64::INFINITY);
    for _ in 0..20_000 {
        // From lattice points and middles of edges and faces along diagonals: two or three crossings at once, or nearly.
        let place = |r: &mut Random| r.below(17) as f32 * 0.5;
        let origin = Vec3::new(place(&mut random), place(&mut random), place(&mut random));
        let step = |r: &mut Random| (r.below(7) as f32 - 3.0) * (1.0 + (r.below(3) as f32 - 1.0) * 1.2e-7);
        let direction = Vec3::new(step(&mut random), step(&mut random), step(&mut random));
        if direction == Vec3::ZERO {
            continue;
        }
        ties += usize::from(exact_list(origin, direction, dims, 1e30, MARGIN).is_none());
        let (o, d) = (origin.to_array().map(f64::from), direction.to_array().map(f64::from));
        for cell in walk(origin, direction, dims, 1e30) {
            let (length, exit) = stay(&cell, o, d);
            worst = worst.min(length / exit.max(1.0));
            thin += usize::from(length.abs() < 1e-6);
        }
        // Planted fault: an origin a little off.
        let off = [o[0] + 1e-4, o[1], o[2]];
        for cell in walk(origin, direction, dims, 1e30) {
            let (length, exit) = stay(&cell, off, d);
            of_drift = of_drift.min(length / exit.max(1.0));
        }
    }
    println!(
        "{ties} rays with ties, {thin} voxels only touched, the least stay {worst:.1e} of t ({of_drift:.1e} off by 10⁻⁴)"
    );
    assert!(ties > 1_000 && thin > 100, "{ties} {thin}");
    assert!(worst > -8.0 * 2f64.powi(-24), "{worst:e}");
    assert!(of_drift < -1e-5, "planted fault");
}

#[test]
fn paths_are_connected_and_hold_their_points() {
    let mut random = Random::new(2);
    let mut points = 0;
    for _ in 0..20_000 {
        let dims = UVec3::new(1 + random.below(40), 1 + random.below(40), 1 + random.below(40));
        let (origin, direction) = random_ray(&mut random, 20.0);
        let cells = walk(origin, direction, dims, 1e30);
        assert!(cells.len() <= (dims.x + dims.y + dims.z - 2) as usize, "longer than any path");
        for pair in cells.windows(2) {
            let apart: u32 = (0..3).map(|i| pair[0][i].abs_diff(pair[1][i])).sum();
            assert_eq!(apart, 1, "{origin:?} {direction:?}");
        }
        for c in &cells {
            assert!(c[0] < dims.x && c[1] < dims.y && c[2] < dims.z);
        }
        let (o, d) = (origin.to_array().map(f64::from), direction.to_array().map(f64::from));
        let length = d.iter().map(|x| x * x).sum::<f64>().sqrt();
        for _ in 0..4 {
            let t = f64::from(random.unit()) * 60.0 / length;
            let p = [0, 1, 2].map(|i| o[i] + t * d[i]);
            let near = (0..3).any(|i| {
                let slack = 8.0 * MARGIN * (p[i].abs() + o[i].abs() + 1.0);
                (p[i] - p[i].round()).abs() < slack && d[i] != 0.0
            });
            let inside = (0..3).all(|i| p[i] >= 0.0 && p[i] < f64::from(dims[i]));
            if inside && !near {
                points += 1;
                assert!(cells.contains(&p.map(|x| x as u32)), "{origin:?} {direction:?} at {t}");
            }
        }
    }
    assert!(points > 5000, "{points}");
}

#[test]
fn the_reversed_ray_visits_the_reversed_list() {
    let mut random = Random::new(3);
    let dims = UVec3::new(30, 20, 25);
    let mut compared = 0;
    for _ in 0..20_000 {
        // Odd sixteenths: the far end is exact, so both rays are the same line, and no end is on a boundary.
        let mut corner = || {
            Vec3::new(random.below(800) as f32, random.below(800) as f32, random.below(800) as f32) / 8.0
                - Vec3::splat(30.3125)
        };
        let (a, b) = (corner(), corner());
        if exact_list(a, b - a, dims, 1.0, 4.0 * MARGIN).is_none()
            || exact_list(b, a - b, dims, 1.0, 4.0 * MARGIN).is_none()
        {
            continue;
        }
        let mut forward = walk(a, b - a, dims, 1.0);
        forward.reverse();
        assert_eq!(forward, walk(b, a - b, dims, 1.0), "{a:?} {b:?}");
        compared += usize::from(forward.len() > 3);
    }
    assert!(compared > 1000, "{compared}");
}

#[test]
fn every_walk_ends() {
    let mut random = Random::new(4);
    for _ in 0..100_000 {
        let mut values = [0.0f32; 7];
        for v in &mut values {
            *v = if random.below(3) == 0 {
                SPECIAL[random.below(SPECIAL.len() as u32) as usize]
            } else {
                random.log_uniform(1e-3, 1e2)
            };
        }
        let dims = UVec3::new(random.below(9), random.below(9), random.below(9));
        let mut walk = VoxelWalk::new(
            Vec3::new(values[0], values[1], values[2]),
            Vec3::new(values[3], values[4], values[5]),
            dims,
            values[6],
        );
        let mut steps = 0;
        while walk.inside {
            assert!(
                walk.voxel.x < dims.x && walk.voxel.y < dims.y && walk.voxel.z < dims.z,
                "{values:?} {dims}"
            );
            assert!(walk.t_enter.is_finite() && walk.t_exit.is_finite() && walk.t_enter <= walk.t_exit);
            walk.step();
            steps += 1;
            assert!(steps <= 30);
        }
    }
}
