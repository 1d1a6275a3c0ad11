//! Do moving meshes join the voxels of what stands still as if all had been voxelised at once?

use crate::cpu;
use crate::support::*;
use glam::Vec3;
use twinlight::backend::{Backend, Cpu};
use twinlight::scene::{Bounds, Scene};
use twinlight::technique::World;
use twinlight::technique::voxel_cones::{Pyramid, VoxelCones, Voxelisation};

/// A room, and in it a turning box at a place; returns the scene and its number of standing triangles.
fn room_with_box(x: f32, turn: f32) -> (Scene, u32) {
    let mut s = scene();
    room(&mut s, v(2.0, 1.0, 2.0), 0.0, grey(0.7));
    let standing = s.triangles.len() as u32;
    let mut moving = scene();
    room(&mut moving, v(0.3, 0.3, 0.3), turn, grey(0.3));
    let material = s.materials.len() as u32;
    s.materials.extend(moving.materials);
    for mut t in moving.triangles {
        for p in [&mut t.p0, &mut t.p1, &mut t.p2] {
            *p += Vec3::new(x, -0.4, 0.2).extend(0.0);
        }
        t.material += material;
        s.triangles.push(t);
    }
    (s, standing)
}

/// All that stays of a pyramid.
fn parts<B: Backend>(backend: &mut B, p: &Pyramid<B>) -> Vec<Vec<u32>> {
    let mut all: Vec<Vec<u32>> = [&p.blocks, &p.depths, &p.sums].map(|b| backend.download(b).unwrap()).into();
    all.extend(p.points.iter().map(|b| backend.download(b).unwrap()));
    all.push(p.firsts.clone());
    all
}

fn follow<B: Backend>(backend: &mut B, settings: &VoxelCones) {
    let (first, standing) = room_with_box(0.0, 0.0);
    let bounds = Bounds::of(&first.triangles);
    let world = World::upload(backend, &first, &tree(&first), false).unwrap();
    let base = Pyramid::build_part(backend, &world, settings, &bounds, 0..standing).unwrap();
    let before = parts(backend, &base);
    let mut last = None;
    for (x, turn) in [(0.0, 0.0), (0.41, 0.3), (-1.2, 0.9), (1.69, 0.0), (-2.05, 0.2), (2.05, 0.2)] {
        let (s, _) = room_with_box(x, turn);
        let world = World::upload(backend, &s, &tree(&s), false).unwrap();
        let all = standing..s.triangles.len() as u32;
        let joined = base.with_moving(backend, &world, all.clone()).unwrap();
        let at_once = Pyramid::build_part(backend, &world, settings, &bounds, 0..all.end).unwrap();
        let got = parts(backend, &joined);
        assert!(got == parts(backend, &at_once), "at {x}");
        assert_eq!(joined.pair_count, at_once.pair_count);
        assert!(joined.params == at_once.params);
        // Beyond the standing part's lattice voxels are left out, and that can be asked for.
        assert_eq!(base.holds(&Bounds::of(&s.triangles[standing as usize..])), x.abs() < 2.0);
        assert!(parts(backend, &base) == before, "the standing part was touched");
        assert!(last.as_ref() != Some(&got), "negative control: the box moved and its voxels did not");
        last = Some(got);
        // No triangle at all moves: what stands is what there is.
        let none = base.with_moving(backend, &world, standing..standing).unwrap();
        assert!(parts(backend, &none) == before, "nothing joined, and it is another pyramid");
    }
}

#[test]
fn what_moves_joins_what_stands_bit_for_bit() {
    for resolution in [16, 64] {
        follow(&mut cpu(), &VoxelCones { resolution, ..Default::default() });
    }
    let thin = VoxelCones {
        resolution: 32,
        voxelisation: Voxelisation::Thin,
        anisotropic: false,
        ..Default::default()
    };
    follow(&mut cpu(), &thin);
    if let Some(mut gpu) = strict_gpu() {
        follow(&mut gpu, &VoxelCones { resolution: 32, ..Default::default() });
    }
}

#[test]
fn only_what_moves_is_voxelised() {
    let settings = VoxelCones { resolution: 64, ..Default::default() };
    let (s, standing) = room_with_box(0.3, 0.2);
    let mut cpu = Cpu::new(Some(2)).unwrap();
    let world = World::upload(&mut cpu, &s, &tree(&s), false).unwrap();
    let bounds = Bounds::of(&s.triangles);
    let base = Pyramid::build_part(&mut cpu, &world, &settings, &bounds, 0..standing).unwrap();
    let items = |cpu: &mut Cpu, pass: &str| -> u64 {
        let timings = cpu.take_timings();
        timings.iter().filter(|t| t.pass == pass).map(|t| u64::from(t.items)).sum()
    };
    let all = items(&mut cpu, "accumulate_leaves");
    base.with_moving(&mut cpu, &world, standing..world.triangle_count).unwrap();
    let moved = items(&mut cpu, "accumulate_leaves");
    println!("pairs of voxels and triangles: {all} of what stands, {moved} of what moves");
    assert!(moved > 0 && 10 * moved < all, "{moved} of {all}");
}
