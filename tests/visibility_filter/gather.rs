//! Is light added up without loss, the seam at R small, and the light next to a proxy bounded?

use crate::support::*;
use crate::{Built, Random, indirect_job};
use glam::{Vec3, Vec4};
use twinlight::technique::Inspection;
use twinlight::technique::visibility_filter::VisibilityFilter;
use twinlight::technique::visibility_filter::lists::Lists;
use twinlight_kernels::passes;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::visibility_filter::gather_voxels::{
    CLAMP_DISC, CLAMP_NONE, CLAMP_RADIUS, GATHER_SHARE,
};
use twinlight_kernels::sampling::attenuation::vpl_form_factor;

const SIDE: u32 = 24;

/// A closed room with a table in it, all glossy, in which every side of every proxy has radiance 1.
fn furnace(settings: &VisibilityFilter, flags: u32, near_range: f32) -> (Vec<Vec4>, Vec<Vec4>, Vec<f32>) {
    let mut s = scene();
    room(&mut s, v(1.0, 1.0, 1.0), 0.2, metal(0.5, 0.45));
    square(&mut s, -0.3, 0.4, true, metal(0.5, 0.45));
    let mut b = Built::new(&s, settings);
    let count = 2 * b.proxies.count() as usize;
    let lit: Vec<Vec4> = b.cpu.download(&b.lit.radiance).iter().map(|l| Vec3::ONE.extend(l.w)).collect();
    assert_eq!(lit.len(), count);
    let radiance = b.cpu.upload("radiance", &lit).unwrap();
    let grid = GridParams { weighted: u32::from(flags & GATHER_SHARE != 0), ..b.proxies.grid };
    let mut voxels = b.cpu.alloc("voxels", grid.dims.w as usize).unwrap();
    b.cpu
        .sum_voxels(&grid, &b.proxies.starts, &b.proxies.proxies, &radiance, &mut voxels, grid.dims.w)
        .unwrap();
    let view = view(&camera(v(0.5, 0.4, 0.6), v(-0.3, -0.4, -0.2), 80.0), SIDE, SIDE);
    let settings = VisibilityFilter { marching: Some((SIDE, SIDE)), ..settings.clone() };
    let job = indirect_job();
    let mut seen = Inspection::new(&job, SIDE, SIDE);
    let lists = Lists::make(&mut b.cpu, &b.world, &b.proxies, &view, &job, &settings, &mut seen).unwrap();
    let g =
        twinlight::technique::gbuffer::GBuffer::trace(&mut b.cpu, &b.world, &view, 0..SIDE * SIDE, &mut seen)
            .unwrap();
    let params = GatherVoxelsParams {
        eye: g.params.eye,
        width: SIDE,
        coarse_width: SIDE,
        coarse_height: SIDE,
        scale_x: 1.0,
        scale_y: 1.0,
        near_range,
        depth_deviation: 0.01,
        normal_deviation: 0.1,
        capacity: lists.capacity,
        flags,
        trust: settings.trust,
        disc_radius: b.proxies.radius,
        ..Default::default()
    };
    let items = SIDE * SIDE;
    let mut diffuse = b.cpu.alloc("diffuse", items as usize).unwrap();
    let (p, light) = (&b.proxies.proxies, &radiance);
    b.cpu
        .gather_diffuse(
            &params,
            &g.surfaces,
            &lists.headers,
            &lists.lists,
            &voxels,
            p,
            light,
            &mut diffuse,
            items,
        )
        .unwrap();
    let gloss = g.gloss.as_ref().unwrap();
    let mut specular = b.cpu.alloc("specular", items as usize).unwrap();
    b.cpu
        .gather_specular(
            &params,
            &g.surfaces,
            gloss,
            &lists.headers,
            &lists.lists,
            &voxels,
            p,
            light,
            &mut specular,
            items,
        )
        .unwrap();
    let coverage = b.cpu.download(&lists.headers).iter().map(|h| h.normal.w).collect();
    (b.cpu.download(&diffuse), b.cpu.download(&specular), coverage)
}

#[test]
fn a_furnace_stays_at_one_whatever_the_knobs() {
    let mut worst_sum = 0.0f32;
    for (proxies, grid, rays, near_range, trust) in [
        (20_000, 4, 32, 0.5, 2.0),
        (20_000, 12, 64, 0.0, 2.0),
        (5_000, 7, 16, 9.0, 0.0),
        (40_000, 20, 8, 0.3, 5.0),
    ] {
        let settings =
            VisibilityFilter { proxies, grid: [grid; 3], rays, trust, overlap: 5.0, ..Default::default() };
        let (diffuse, specular, coverage) = furnace(&settings, GATHER_SHARE, near_range);
        for (d, (s, c)) in diffuse.iter().zip(specular.iter().zip(&coverage)) {
            // What is missing slipped between discs.
            assert!(d.x == d.y && d.x > 0.97 && d.x < 1.000_01, "{d} at grid {grid}");
            assert!((s.x - c).abs() < 1e-4 * c.max(0.1), "specular {s} of coverage {c} at grid {grid}");
        }
        let mean = diffuse.iter().map(|d| d.x).sum::<f32>() / diffuse.len() as f32;
        println!("{proxies} proxies, grid {grid}, {rays} rays: {mean:.4}");
        assert!(mean > 0.99, "{mean}");
        let (sum, _, _) = furnace(&settings, 0, near_range);
        worst_sum = sum.iter().fold(worst_sum, |worst, d| worst.max((d.x - 1.0).abs()));
    }
    println!("summing all proxies of listed voxels: up to {worst_sum:.2} off");
    assert!(worst_sum > 0.1, "negative control: the paper's sum is off by {worst_sum} only");
}

/// One voxel's light at one receiver, proxy by proxy and by its sums.
fn both_ways(proxies: &[Proxy], radiance: &[Vec4], receiver: Vec3, normal: Vec3, flags: u32) -> (f32, f32) {
    let grid = GridParams::default();
    let voxel = passes::sum_voxels(0, &grid, &[0, proxies.len() as u32], proxies, radiance);
    let surface = Surface {
        position: receiver.extend(1.0),
        normal: normal.extend(1.0),
        triangle: 0,
        ..Default::default()
    };
    let header = ListHeader { position: surface.position, normal: normal.extend(0.0) };
    let gather = |near_range: f32| {
        let params = GatherVoxelsParams {
            width: 1,
            coarse_width: 1,
            coarse_height: 1,
            scale_x: 1.0,
            scale_y: 1.0,
            near_range,
            depth_deviation: 0.01,
            normal_deviation: 0.1,
            capacity: 1,
            flags,
            ..Default::default()
        };
        let list = [10, 1, 0, 5, 1, 5];
        passes::gather_diffuse(0, &params, &[surface], &[header], &list, &[voxel], proxies, radiance).x
    };
    (gather(1e9), gather(0.0))
}

/// The proxies of a voxel of edge 0.2 around the origin, on one wall or two.
fn walls(normals: &[Vec3], random: &mut Random) -> Vec<Proxy> {
    (0..60)
        .map(|i| {
            let n = normals[i % normals.len()];
            let (t, b) = n.any_orthonormal_pair();
            let at = t * random.within(-0.1, 0.1) + b * random.within(-0.1, 0.1);
            Proxy { position: at.extend(0.01), normal: n.extend(3e-4), ..Default::default() }
        })
        .collect()
}

/// Largest and root mean square jump at R = 1 over the voxel's mean light, for voxels of edge 0.2.
fn seam(kind: &str, flags: u32) -> (f32, f32) {
    let mut random = Random(31);
    let (mut worst, mut squares, mut count) = (0.0f32, 0.0f32, 0);
    while count < 3_000 {
        let normals = [random.direction(), random.direction()];
        let used = if kind == "flat" { &normals[..1] } else { &normals[..] };
        let receiver = random.direction();
        let normal = (random.direction() - receiver).normalize();
        let seen = used.iter().map(|n| n.dot(receiver).abs()).fold(f32::MAX, f32::min);
        if normal.dot(-receiver) < 0.5 || seen < 0.3 {
            continue;
        }
        let proxies = walls(used, &mut random);
        // Each wall has a radiance of its own, on both sides.
        let levels = [random.within(0.1, 1.0), random.within(0.1, 1.0)];
        let radiance: Vec<Vec4> =
            (0..120).map(|i| Vec3::splat(levels[i / 2 % used.len()]).extend(1.0)).collect();
        let (near, far) = both_ways(&proxies, &radiance, receiver, normal, flags);
        let jump = (far / near - 1.0).abs();
        worst = worst.max(jump);
        squares += jump * jump;
        count += 1;
    }
    let rms = (squares / count as f32).sqrt();
    println!("jump at R, {kind}, flags {flags}: {:.1} % at most, {:.1} % RMS", 100.0 * worst, 100.0 * rms);
    (worst, rms)
}

#[test]
fn the_seam_at_r_is_small() {
    let (flat, _) = seam("flat", 0);
    assert!(flat < 0.10, "{flat}");
    // Two bands cannot tell two walls apart: the sum jumps, the mean radiance hardly.
    let (_, corner) = seam("corner", 0);
    let (worst, share) = seam("corner", GATHER_SHARE);
    assert!(corner < 0.15 && share < 0.06 && worst < 0.6, "{corner} {share} {worst}");
    let (flat, _) = seam("flat", GATHER_SHARE);
    assert!(flat < 1e-4, "{flat}");
    assert!(corner > 2.0 * share, "negative control: two walls in one voxel do jump in the sum");
}

#[test]
fn light_next_to_a_proxy_is_bounded_and_the_same_far_away() {
    let proxy = Proxy { position: Vec4::W * 0.1, normal: Vec3::Z.extend(0.031_415_93), ..Default::default() };
    let radiance = [Vec4::ONE; 2];
    let light = |distance: f32, clamp: u32| {
        let voxel = passes::sum_voxels(0, &GridParams::default(), &[0, 1], &[proxy], &radiance);
        let at = Vec3::Z * distance;
        let surface =
            Surface { position: at.extend(1.0), normal: Vec3::NEG_Z.extend(1.0), ..Default::default() };
        let header = ListHeader { position: surface.position, normal: surface.normal.truncate().extend(0.0) };
        let params = GatherVoxelsParams {
            width: 1,
            coarse_width: 1,
            coarse_height: 1,
            scale_x: 1.0,
            scale_y: 1.0,
            near_range: 1e9,
            depth_deviation: 0.01,
            normal_deviation: 0.1,
            capacity: 1,
            clamp,
            ..Default::default()
        };
        passes::gather_diffuse(
            0,
            &params,
            &[surface],
            &[header],
            &[1, 1, 0, 1, 1, 1],
            &[voxel],
            &[proxy],
            &radiance,
        )
        .x
    };
    for distance in [1e-6f32, 1e-3, 0.03, 0.1, 0.3, 1.0, 10.0] {
        let (disc, radius, bare) =
            (light(distance, CLAMP_DISC), light(distance, CLAMP_RADIUS), light(distance, CLAMP_NONE));
        let expected = vpl_form_factor(Vec3::Z * distance, Vec3::NEG_Z, Vec3::ZERO, Vec3::Z, proxy.normal.w);
        assert!((disc - expected).abs() <= 1e-6 * expected, "{disc} for {expected} at {distance}");
        assert!(disc <= 1.0 && radius <= 1.0 && disc <= radius && radius <= bare);
        if distance >= 1.0 {
            assert!((disc / bare - 1.0).abs() < 0.01 && radius == bare, "{disc} {radius} {bare}");
        }
    }
    assert!(light(1e-3, CLAMP_NONE) > 1e3, "negative control: the bare law blows up");
    assert_eq!(light(0.0, CLAMP_NONE), 0.0, "in the same place there is no direction");
}

#[test]
fn without_a_neighbour_or_a_voxel_there_is_no_light() {
    let params = GatherVoxelsParams {
        width: 1,
        coarse_width: 1,
        coarse_height: 1,
        scale_x: 1.0,
        scale_y: 1.0,
        capacity: 1,
        depth_deviation: 0.01,
        normal_deviation: 0.1,
        flags: GATHER_SHARE,
        ..Default::default()
    };
    let surface = Surface { position: Vec4::W, normal: Vec4::new(0.0, 1.0, 0.0, 1.0), ..Default::default() };
    let seen = ListHeader { position: Vec4::W, normal: Vec4::Y };
    let unseen = ListHeader { position: Vec4::NEG_W, normal: Vec4::ZERO };
    let run = |header, list: &[u32]| {
        let voxel = Voxel::default();
        let d = passes::gather_diffuse(0, &params, &[surface], &[header], list, &[voxel], &[], &[]);
        let gloss = [Vec4::new(0.5, 0.5, 0.5, 40.0)];
        let s = passes::gather_specular(0, &params, &[surface], &gloss, &[header], list, &[voxel], &[], &[]);
        (d, s)
    };
    assert_eq!(run(unseen, &[5, 1, 0, 5, 1, 5]), (Vec4::ZERO, Vec4::W));
    assert_eq!(run(seen, &[0, 0, 0, 0, 0, 0]), (Vec4::ZERO, Vec4::W));
    // A voxel without proxies, as rays to triangles may find.
    assert_eq!(run(seen, &[5, 1, 0, 5, 1, 5]), (Vec4::W, Vec4::W));
}
