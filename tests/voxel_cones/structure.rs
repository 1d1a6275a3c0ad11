//! Are voxels where triangles are, and is nothing lost on the way up?

use crate::support::*;
use crate::{Built, cpu};
use glam::{UVec3, Vec3};
use twinlight::scene::Scene;
use twinlight::technique::World;
use twinlight::technique::voxel_cones::{Pyramid, VoxelCones, Voxelisation};
use twinlight_kernels::geometry::lattice::{NO_VOXEL, nth_bit, point_of, unpack_point, voxel_at};
use twinlight_kernels::passes::elements::ConeParams;
use twinlight_kernels::passes::voxel_cones::build::{AREA_SCALE, LEAF_WORDS};
use twinlight_kernels::passes::voxel_cones::clip::part_in_cube;
use twinlight_kernels::passes::voxel_cones::march::{self, Ray, march};
use twinlight_kernels::passes::voxel_cones::storage::{
    FIXED, FIXED_RANGE, FLOAT, HALF, SHARED_EXPONENT, UNORM8, load_radiance, pack_depths, pack_radiance,
    radiance_word, unpack_depths, unpack_radiance, words_of,
};
use twinlight_kernels::sampling::hash::{hash, unit_float};

fn at(resolution: u32) -> VoxelCones {
    VoxelCones { resolution, ..Default::default() }
}

/// The area in all leaves, m².
fn area(b: &Built) -> f64 {
    let face = f64::from(b.pyramid.params.lower.w).powi(2);
    let faces: f64 = b.sums.chunks_exact(LEAF_WORDS as usize).map(|s| f64::from(s[6])).sum();
    faces / f64::from(AREA_SCALE) * face
}

#[test]
fn leaves_hold_the_area_of_the_triangles() {
    for name in ["cornell-box", "spheres"] {
        let s = Scene::open(name).unwrap();
        let world = World::upload(&mut cpu(), &s, &tree(&s), false).unwrap();
        for resolution in [8, 32, 128] {
            let off = area(&Built::new(&s, &at(resolution))) / world.area - 1.0;
            println!("{name} at {resolution}³: area off by {:.1e}", off);
            assert!(off.abs() < 1e-3, "{name} at {resolution}³: {off}");
        }
        // Negative control: voxels that count fully have another area.
        let thin = VoxelCones { voxelisation: Voxelisation::Thin, ..at(32) };
        assert!((area(&Built::new(&s, &thin)) / world.area - 1.0).abs() > 0.01);
    }
}

#[test]
fn every_voxel_is_found_where_it_is_and_nowhere_else() {
    let b = Built::new(&Scene::open("spheres").unwrap(), &at(64));
    let depth = b.pyramid.params.depth;
    for level in 0..=depth {
        let (params, count) = b.pyramid.level(level);
        let points = b.cpu.download(&b.pyramid.points[level as usize]);
        assert_eq!(points.len(), count as usize);
        for (i, &word) in points.iter().enumerate() {
            let voxel = params.first + i as u32;
            let point = unpack_point(word);
            assert_eq!(voxel_at(&b.blocks, depth, level, point), voxel);
            assert_eq!(point_of(&b.blocks, depth, level, voxel), point);
        }
        let side = (1u32 << (depth - level)) + 1;
        let all = (0..side.pow(3))
            .map(|i| UVec3::new(i % side, i / side % side, i / side / side))
            .filter(|&p| voxel_at(&b.blocks, depth, level, p) != NO_VOXEL);
        assert_eq!(all.count(), count as usize, "level {level}");
    }
    assert_eq!(voxel_at(&b.blocks, depth, 0, UVec3::new(u32::MAX, 0, 0)), NO_VOXEL);
    for n in 0..20 {
        let word = hash(n) | 1;
        let set: Vec<u32> = (0..32).filter(|&i| word >> i & 1 == 1).collect();
        for (i, &bit) in set.iter().enumerate() {
            assert_eq!(nth_bit(word, i as u32), bit, "{word:b}");
        }
    }
}

#[test]
fn every_point_of_a_surface_lies_in_a_leaf() {
    let s = Scene::open("spheres").unwrap();
    let b = Built::new(&s, &at(128));
    let p = &b.pyramid.params;
    let lost = |offset: f32| {
        let mut lost = 0;
        for i in 0..20_000u32 {
            let t = &s.triangles[(hash(i) % s.triangles.len() as u32) as usize];
            let (u, v) = (unit_float(hash(i ^ 0x55)), unit_float(hash(i ^ 0xAA)));
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let point = (t.p0 + (t.p1 - t.p0) * u + (t.p2 - t.p0) * v).truncate() + Vec3::Y * offset;
            let cell = ((point - p.lower.truncate()) * p.inverse_edge + 0.5).floor().as_uvec3();
            lost += u32::from(voxel_at(&b.blocks, p.depth, 0, cell) == NO_VOXEL);
        }
        lost
    };
    assert_eq!(lost(0.0), 0);
    assert!(lost(3.0 * p.lower.w) > 1_000, "negative control: points off the surface are in leaves");
}

#[test]
fn parts_of_a_triangle_in_cubes_add_up() {
    let corner = |i: u32| {
        let c = |k: u32| 6.0 * unit_float(hash(7 * i + k)) - 3.0;
        Vec3::new(c(1), c(2), c(3))
    };
    for i in 0..200 {
        let [a, b, c] = [3 * i, 3 * i + 1, 3 * i + 2].map(corner);
        let whole = 0.5 * f64::from((b - a).cross(c - a).length());
        let mut sum = 0.0;
        let mut moment = glam::DVec3::ZERO;
        for z in -4..=4 {
            for y in -4..=4 {
                for x in -4..=4 {
                    let centre = Vec3::new(x as f32, y as f32, z as f32);
                    let part = part_in_cube(a - centre, b - centre, c - centre);
                    assert!(part.centroid.abs().max_element() <= 0.500_1 || part.area == 0.0);
                    sum += f64::from(part.area);
                    moment += (part.centroid + centre).as_dvec3() * f64::from(part.area);
                }
            }
        }
        assert!((sum / whole - 1.0).abs() < 1e-5, "{sum} for {whole}");
        assert!((moment / sum - ((a + b + c) / 3.0).as_dvec3()).length() < 1e-4);
    }
}

#[test]
fn words_keep_depths_and_radiance() {
    for i in 0..5_000 {
        let x = |k: u32| unit_float(hash(9 * i + k));
        let depths = Vec3::new(8.0 * x(0), 8.0 * x(1) * x(1), x(2).powi(6));
        let got = unpack_depths(pack_depths(depths));
        let step = (depths * (4.0 * 8.0 / 1023.0 / 1023.0)).map(f32::sqrt) + Vec3::splat(2e-6);
        assert!((got - depths).abs().cmple(step).all(), "{depths} became {got}");
        let radiance = Vec3::new(x(3), x(4), x(5)) * 10f32.powf(8.0 * x(6) - 4.0);
        let got = unpack_radiance(pack_radiance(radiance));
        let worst = (got - radiance).abs().max_element() / radiance.max_element();
        // Below 2⁻¹⁶ steps are those of 2⁻¹⁶.
        assert!(worst <= 1.0 / 511.0 || radiance.max_element() < 1.53e-5, "{radiance} became {got}");
    }
    assert_eq!(unpack_depths(pack_depths(Vec3::ZERO)), Vec3::ZERO);
    assert!((unpack_depths(pack_depths(Vec3::splat(9.0))) - Vec3::splat(8.0)).abs().max_element() < 1e-5);
    for odd in [f32::NAN, -1.0, f32::NEG_INFINITY] {
        assert_eq!((pack_radiance(Vec3::splat(odd)), pack_depths(Vec3::splat(odd))), (0, 0));
    }
    assert_eq!(unpack_radiance(pack_radiance(Vec3::splat(f32::INFINITY))), Vec3::splat(65_408.0));
}

#[test]
fn every_storage_keeps_radiance_to_its_step() {
    let mut worst = [0.0f32; 5];
    for i in 0..20_000 {
        let x = |k: u32| unit_float(hash(9 * i + k));
        let radiance = Vec3::new(x(0), x(1), x(2)) * 2f32.powf(14.0 * x(3) - 10.0);
        for storage in [SHARED_EXPONENT, UNORM8, FIXED, HALF, FLOAT] {
            // Between two others.
            let entry = |r: Vec3| (0..words_of(storage)).map(move |w| radiance_word(storage, r, w));
            let words: Vec<u32> = entry(Vec3::ONE).chain(entry(radiance)).chain(entry(Vec3::ONE)).collect();
            let off = (load_radiance(&words, storage, 1) - radiance).abs();
            let allowed = match storage {
                UNORM8 => Vec3::splat(0.5 * FIXED_RANGE / 255.0 + 1e-6),
                FIXED => Vec3::splat(0.5 * FIXED_RANGE / 1023.0 + 1e-6),
                SHARED_EXPONENT => Vec3::splat(radiance.max_element() / 511.0),
                HALF => radiance / 2048.0 + Vec3::splat(3e-8),
                _ => Vec3::ZERO,
            };
            assert!(off.cmple(allowed).all(), "storage {storage}: {radiance} is off by {off}");
            worst[storage as usize] = worst[storage as usize].max(off.max_element());
        }
    }
    // What is coarser is so.
    assert!(worst[UNORM8 as usize] > worst[FIXED as usize] && worst[FIXED as usize] > 5e-3, "{worst:?}");
    for storage in [SHARED_EXPONENT, UNORM8, FIXED, HALF, FLOAT] {
        for odd in [f32::NAN, -1.0, f32::NEG_INFINITY] {
            assert!((0..words_of(storage)).all(|w| radiance_word(storage, Vec3::splat(odd), w) == 0));
        }
        let words: Vec<u32> =
            (0..words_of(storage)).map(|w| radiance_word(storage, Vec3::splat(f32::INFINITY), w)).collect();
        let most = if matches!(storage, UNORM8 | FIXED) { FIXED_RANGE } else { 65_408.0 };
        let got = load_radiance(&words, storage, 0);
        assert!((got / most - Vec3::ONE).abs().max_element() < 1e-3, "storage {storage}: {got}");
    }
}

/// A wall in a larger box of air, its normal turned away from x.
fn wall(turn: f32) -> Scene {
    let mut s = scene();
    let turned = |p: Vec3| glam::Quat::from_rotation_y(turn) * p;
    quad(
        &mut s,
        [v(0.0, -1.0, -1.0), v(0.0, 1.0, -1.0), v(0.0, 1.0, 1.0), v(0.0, -1.0, 1.0)].map(turned),
        grey(0.5),
    );
    // What gives the box its size.
    for corner in [v(-1.2, -1.2, -1.2), v(1.2, 1.2, 1.2)] {
        quad(
            &mut s,
            [v(0.0, 0.0, 0.0), v(0.01, 0.0, 0.0), v(0.01, 0.01, 0.0), v(0.0, 0.01, 0.0)].map(|p| p + corner),
            grey(0.5),
        );
    }
    s
}

/// The optical depth that a cone along `direction` meets between two points.
fn depth_through(b: &Built, from: Vec3, direction: Vec3, tangent: f32, step: f32) -> f32 {
    let p = &b.pyramid.params;
    let origin = (from - p.lower.truncate()) * p.inverse_edge;
    let params = ConeParams { depth: p.depth, width: 1.0, step, cutoff: 0.0, ..Default::default() };
    let ray = Ray { origin, direction, normal: Vec3::ZERO, tangent, reach: 1e9 };
    let dark = vec![0; b.depths.len()];
    let medium = march::Pyramid {
        depth: p.depth,
        lobes: 0,
        storage: 0,
        blocks: &b.blocks,
        depths: &b.depths,
        places: &dark,
        radiance: &[0],
    };
    -march(&params, &ray, &medium).through.max(1e-12).ln()
}

#[test]
fn a_wall_has_the_same_depth_wherever_and_however_it_is_crossed() {
    for turn in [0.0, 0.3, 0.7] {
        let b = Built::new(&wall(turn), &at(64));
        let mut depths = Vec::new();
        for i in 0..40 {
            let across = v(0.0, 0.8 * unit_float(hash(i)) - 0.4, 0.8 * unit_float(hash(i + 99)) - 0.4);
            let start = across - v(0.9 + 0.1 * unit_float(hash(i + 7)), 0.0, 0.0);
            for step in [0.2, 0.5, 1.0] {
                depths.push(depth_through(&b, start, Vec3::X, 0.0, step));
            }
        }
        let mean = depths.iter().sum::<f32>() / depths.len() as f32;
        let worst = depths.iter().map(|d| (d / mean - 1.0).abs()).fold(0.0, f32::max);
        println!("turned by {turn}: optical depth {mean:.2}, off by {:.1} % at most", 100.0 * worst);
        assert!((mean / 6.0 - 1.0).abs() < 0.1 && worst < 0.35, "{mean}, {worst}");
        // Wide cones sample coarse levels.
        for (tangent, least) in [(0.05, 4.0), (0.2, 2.0), (0.5, 1.0)] {
            let depth = depth_through(&b, v(-1.0, 0.03, 0.02), Vec3::X, tangent, 0.5);
            assert!(depth > least, "a cone of tangent {tangent} sees through the wall: depth {depth}");
        }
        assert!(depth_through(&b, v(1.0, 0.0, 0.0), Vec3::X, 0.0, 0.5) < 0.01, "behind the wall is air");
    }
}

/// What a level's voxels take of light from afar along x, were none behind another: Σ depth × face, m².
fn taken(b: &Built, level: u32) -> f64 {
    let (params, count) = b.pyramid.level(level);
    let face = (f64::from(params.lower.w) * f64::from(1u32 << level)).powi(2);
    let own = params.first as usize..(params.first + count) as usize;
    b.depths[own].iter().map(|&w| f64::from(unpack_depths(w).x) * face).sum()
}

#[test]
fn nothing_is_lost_from_level_to_level() {
    // A mist of small triangles, so thin that opacities add up as depths do.
    let mut mist = scene();
    for i in 0..600u32 {
        let c = |k: u32| 2.0 * unit_float(hash(11 * i + k)) - 1.0;
        let p = v(c(0), c(1), c(2));
        let e = 0.01;
        quad(&mut mist, [p, p + v(0.0, e, 0.0), p + v(0.0, e, e), p + v(0.0, 0.0, e)], grey(0.5));
    }
    let area = 600.0 * 1e-4 * 6.0;
    for resolution in [8, 16] {
        let b = Built::new(&mist, &at(resolution));
        for level in 0..3 {
            let got = taken(&b, level) / area;
            println!("mist at {resolution}³, level {level}: {got:.4}");
            assert!((got - 1.0).abs() < 0.03, "{got} of the mist's depth at level {level}");
        }
    }
    // A wall across x: depths add up along x, whichever way its layer falls.
    let b = Built::new(&wall(0.0), &at(64));
    let whole = taken(&b, 0);
    // Along its border columns are covered in part: what is averaged there are opacities.
    for level in 1..3 {
        let got = taken(&b, level) / whole;
        println!("wall, level {level}: {got:.4}");
        assert!((got - 1.0).abs() < 0.1, "{got} of the wall's depth at level {level}");
    }
    // Negative control: a filter that loses one voxel in sixteen is noticed.
    let mut lossy = Built::new(&mist, &at(16));
    lossy.depths.iter_mut().step_by(16).for_each(|d| *d = 0);
    assert!((taken(&lossy, 1) / area - 1.0).abs() > 0.03);
}

#[test]
fn interpolated_opacities_would_leak() {
    // The same wall, one voxel thick, if opacities were interpolated: what two samples a voxel apart let through.
    let through = |offset: f32| (1.0 - (1.0 - offset)) * (1.0 - offset);
    let worst = (0..=100).map(|i| through(i as f32 / 100.0)).fold(0.0, f32::max);
    let right = (-6.0f32).exp();
    println!("interpolated opacities: up to {:.1} %, depths {:.2} %", 100.0 * worst, 100.0 * right);
    assert!(worst > 50.0 * right);
}

#[test]
fn interpolation_is_continuous_across_blocks() {
    let b = Built::new(&wall(0.4), &at(32));
    let p = b.pyramid.params;
    // Blocks are four lattice points wide: between 11 and 12 interpolation takes from two of them.
    let border = p.lower.truncate() + Vec3::splat(11.5) * p.lower.w;
    let worst = |along: Vec3, step: f32| {
        let at = |i: f32| {
            let from =
                (v(-0.95, border.y, 0.11) + v(0.0, 0.0, border.z - 0.11) * along.z) + along * (step * i);
            depth_through(&b, from, Vec3::X, 0.3, 0.5)
        };
        // Each span crosses lattice points 11 and 12.
        let half = (0.75 * p.lower.w / step) as i32;
        (-half..half).map(|i| (at(i as f32) - at(i as f32 + 1.0)).abs()).fold(0.0f32, f32::max)
    };
    for along in [Vec3::Y, Vec3::Z] {
        let (coarse, fine) = (worst(along, 1e-3), worst(along, 1e-4));
        println!("along {along}: largest jump {coarse:.2e} at 1 mm, {fine:.2e} at 0.1 mm");
        assert!(coarse > 1e-3, "negative control: something changes along the scan");
        assert!(fine < 0.3 * coarse, "{coarse}, {fine}");
    }
}

#[test]
fn the_structure_is_small_and_does_not_depend_on_the_order_of_triangles() {
    let s = Scene::open("spheres").unwrap();
    let settings = at(128);
    let b = Built::new(&s, &settings);
    let bytes = b.pyramid.bytes() as f64 / f64::from(b.pyramid.voxels());
    println!("{} voxels, {bytes:.1} bytes each", b.pyramid.voxels());
    assert!(bytes < 120.0, "{bytes} bytes a voxel");
    let mut reversed = s.clone();
    reversed.triangles.reverse();
    let r = Built::new(&reversed, &settings);
    assert!(b.blocks == r.blocks && b.depths == r.depths && b.sums == r.sums);
    if let Some(path) = scene_file("sponza.glb") {
        let s = Scene::open(path.to_str().unwrap()).unwrap();
        let mut cpu = cpu();
        let world = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
        let p = Pyramid::build(&mut cpu, &world, &at(256)).unwrap();
        println!("Sponza at 256³: {} voxels, {:.0} MiB", p.voxels(), p.bytes() as f64 / 1_048_576.0);
        assert!(p.bytes() < 150 << 20);
    }
}
