//! Is every proxy where its voxel says, and does a voxel send out what its proxies do?

use crate::support::*;
use crate::{Built, Discs, Random};
use glam::{DVec3, UVec3, Vec3, Vec4};
use twinlight::scene::{Scene, light};
use twinlight::technique::visibility_filter::{Gather, VisibilityFilter};
use twinlight_kernels::passes::elements::{GridParams, Proxy, Voxel};
use twinlight_kernels::sampling::voxel_hash::{encode, voxel_of};
use twinlight_kernels::sh::{self, lambert_intensity};

fn number(grid: &GridParams, p: Vec3) -> u32 {
    let dims = grid.dims.truncate();
    encode(voxel_of(p, grid.lower.truncate(), grid.inverse_size.truncate(), dims), dims)
}

fn built(gather: Gather) -> Built {
    let mut scene = Scene::open("cornell-box").unwrap();
    scene.lights.push(light::spot(v(0.5, 1.0, 0.5), Vec3::NEG_X, v(1.0, 2.0, 3.0), 0.4, 0.8));
    Built::new(&scene, &VisibilityFilter { proxies: 12_000, grid: [7, 6, 5], gather, ..Default::default() })
}

#[test]
fn proxies_stand_in_the_order_of_their_voxels() {
    let b = built(Gather::Share);
    let grid = b.proxies.grid;
    let proxies = b.cpu.download(&b.proxies.proxies);
    let starts = b.cpu.download(&b.proxies.starts);
    assert_eq!((starts.len() as u32, starts[0]), (7 * 6 * 5 + 1, 0));
    assert_eq!(*starts.last().unwrap() as usize, proxies.len());
    let occupied = starts.windows(2).filter(|w| w[0] < w[1]).count() as u32;
    assert_eq!(b.proxies.occupied, occupied);
    for (voxel, w) in starts.windows(2).enumerate() {
        for p in &proxies[w[0] as usize..w[1] as usize] {
            assert_eq!(number(&grid, p.position.truncate()), voxel as u32);
        }
    }
    // Ties keep the order in which proxies were made: by triangle.
    for w in starts.windows(2) {
        assert!(proxies[w[0] as usize..w[1] as usize].is_sorted_by_key(|p| p.triangle));
    }
}

#[test]
fn every_cell_that_a_disc_touches_names_it() {
    let b = built(Gather::Share);
    let Discs { grid: cells, starts, pairs } = b.discs();
    let proxies = b.cpu.download(&b.proxies.proxies);
    let mut random = Random(4);
    let names = |cell: u32, proxy: u32| {
        let range = starts[cell as usize]..starts[cell as usize + 1];
        range.into_iter().any(|i| pairs[2 * i as usize] == cell && pairs[2 * i as usize + 1] == proxy)
    };
    let mut elsewhere = 0;
    for _ in 0..20_000 {
        let i = (random.next() * proxies.len() as f32) as u32;
        let p: &Proxy = &proxies[i as usize];
        let (tangent, bitangent) = p.normal.truncate().any_orthonormal_pair();
        let (turn, r) = (random.within(0.0, std::f32::consts::TAU), p.position.w * random.next().sqrt());
        let point = p.position.truncate() + (tangent * turn.cos() + bitangent * turn.sin()) * (0.999 * r);
        let cell = number(&cells, point);
        assert!(names(cell, i), "disc {i} reaches into cell {cell}, which does not know");
        elsewhere += u32::from(cell != number(&cells, p.position.truncate()));
    }
    // Negative control: a list by centres alone would not do.
    assert!(elsewhere > 2_000, "only {elsewhere} points lie in another cell than the centre");
}

/// What a voxel's proxies send toward a direction, W/sr, in double precision.
fn intensity(range: std::ops::Range<usize>, proxies: &[Proxy], radiance: &[Vec4], d: DVec3) -> DVec3 {
    range
        .map(|i| {
            let cosine = proxies[i].normal.truncate().as_dvec3().dot(d);
            let side = if cosine >= 0.0 { radiance[2 * i] } else { radiance[2 * i + 1] };
            side.truncate().as_dvec3() * (f64::from(proxies[i].normal.w) * cosine.abs())
        })
        .sum()
}

/// Projected areas and mean radiances.
fn groups(v: &Voxel) -> [(Vec4, Vec4); 6] {
    [
        (v.right_area, v.right_light),
        (v.left_area, v.left_light),
        (v.up_area, v.up_light),
        (v.down_area, v.down_light),
        (v.near_area, v.near_light),
        (v.far_area, v.far_light),
    ]
}

#[test]
fn a_voxel_sends_out_the_power_of_its_proxies() {
    let b = built(Gather::Sum);
    let (proxies, radiance) = (b.cpu.download(&b.proxies.proxies), b.cpu.download(&b.lit.radiance));
    let voxels = b.cpu.download(&b.lit.voxels);
    let (mut checked, mut flat) = (0, 0);
    let mut random = Random(5);
    for voxel in &voxels {
        let range = voxel.begin as usize..voxel.end as usize;
        if voxel.lit == 0 {
            assert!(range.clone().all(|i| radiance[2 * i].x == 0.0 && radiance[2 * i + 1].x == 0.0));
            continue;
        }
        checked += 1;
        // A Lambert emitter of intensity a·cos has power π·a, and band 0 of √π/2·a.
        let band0 = groups(voxel).map(|(area, light)| f64::from(area.x * light.y)).iter().sum::<f64>()
            / (0.5 * std::f64::consts::PI.sqrt());
        let power: f64 = range
            .clone()
            .map(|i| f64::from(radiance[2 * i].y + radiance[2 * i + 1].y) * f64::from(proxies[i].normal.w))
            .sum();
        assert!((band0 / power - 1.0).abs() < 1e-5, "{band0} for {power}");
        let centre = voxel.centroid.truncate();
        assert!(range.clone().all(|i| {
            (proxies[i].position.truncate() - centre).length() <= voxel.centroid.w * 1.000_01 + 1e-6
        }));
        let first = proxies[voxel.begin as usize].normal.truncate();
        if range.clone().all(|i| proxies[i].normal.truncate() == first) {
            flat += 1;
            for _ in 0..20 {
                let d = random.direction();
                let got: f32 =
                    groups(voxel).iter().map(|(area, light)| light.x * lambert_intensity(*area, d)).sum();
                let expected = intensity(range.clone(), &proxies, &radiance, d.as_dvec3()).x;
                let scale = power + expected;
                assert!((f64::from(got) - expected).abs() < 1e-5 * scale, "{got} for {expected}");
            }
        }
    }
    assert!(checked > 50 && flat > 20, "{checked} lit voxels, {flat} of them flat");
}

#[test]
fn two_bands_are_read_as_emitters() {
    let mut random = Random(6);
    let lambert = [sh::CLAMPED_COSINE[0], sh::CLAMPED_COSINE[1]];
    let (mut worst_linear, mut worst_flat, mut negative) = (0.0f32, 0.0f32, 0);
    for _ in 0..2_000 {
        let (n, d) = (random.direction(), random.direction());
        let c: [f32; 4] = sh::rotate_zonal(&lambert, n);
        let exact = n.dot(d).max(0.0);
        worst_flat = worst_flat.max((lambert_intensity(Vec4::from_array(c), d) - exact).abs());
        let linear = sh::evaluate(&c, d);
        worst_linear = worst_linear.max((linear - exact).abs());
        negative += u32::from(linear < -0.1);
        // All around: the same in any direction.
        let mut sum = Vec4::ZERO;
        for k in 0..6 {
            let axis = [Vec3::X, Vec3::Y, Vec3::Z][k / 2] * if k % 2 == 0 { 1.0 } else { -1.0 };
            sum += Vec4::from_array(sh::rotate_zonal(&lambert, axis));
        }
        assert!((lambert_intensity(sum, d) - 1.5).abs() < 1e-5);
        let any = Vec4::new(random.within(0.0, 1.0), d.x, d.y, d.z);
        assert!(lambert_intensity(any, n) >= 0.0, "bands that no emitters have");
    }
    println!("flat voxel: {worst_flat:.1e} here, {worst_linear:.2} by the series");
    assert!(worst_flat < 1e-6);
    assert!(
        worst_linear > 0.24 && negative > 0,
        "negative control: the series is off by {worst_linear} only"
    );
}

#[test]
fn the_grid_holds_the_scene_whatever_its_shape() {
    for (half, at) in [(v(1.0, 0.0, 1.0), 0.0), (v(1e-3, 1e-3, 0.0), 500.0), (v(200.0, 1e-3, 3.0), -1e4)] {
        let mut s = scene();
        let corners = [v(-1.0, 0.0, 1.0), v(1.0, 0.0, 1.0), v(1.0, 0.0, -1.0), v(-1.0, 0.0, -1.0)];
        quad(&mut s, corners.map(|c| v(c.x, c.z, c.z) * half + Vec3::splat(at)), grey(0.5));
        let b = Built::new(&s, &VisibilityFilter { proxies: 500, ..Default::default() });
        let (grid, cells) = (b.proxies.grid, b.discs().grid);
        for p in b.cpu.download(&b.proxies.proxies) {
            for g in [grid, cells] {
                let local = (p.position.truncate() - g.lower.truncate()) * g.inverse_size.truncate();
                let dims: UVec3 = g.dims.truncate();
                assert!(
                    local.cmpge(Vec3::ZERO).all() && local.cmple(dims.as_vec3()).all(),
                    "{local} in {dims}"
                );
            }
        }
    }
}
