//! Do rays through the cells meet the discs that a look at every disc finds?

use crate::{Built, Discs, Random};
use glam::Vec3;
use twinlight::scene::Scene;
use twinlight::technique::visibility_filter::VisibilityFilter;
use twinlight_kernels::geometry::disc::ray_disc;
use twinlight_kernels::passes::elements::{GridParams, Proxy};
use twinlight_kernels::passes::visibility_filter::march::{NO_VOXEL, ProxyRay, trace_proxies};
use twinlight_kernels::sampling::voxel_hash::{encode, voxel_of};

/// The nearest disc by a look at all: t, or infinity. With a side, the surface's own discs do not count.
fn nearest(proxies: &[Proxy], ray: &ProxyRay) -> f32 {
    let meets = |p: &Proxy| {
        let hit = ray_disc(
            ray.origin,
            ray.direction,
            p.position.truncate(),
            p.normal.truncate(),
            p.position.w,
            0.0,
            1e30,
        );
        let own = ray.side * p.normal.truncate().dot(ray.direction) > 0.0 && hit.t < 2.0 * p.position.w;
        if hit.hit && !own { hit.t } else { f32::INFINITY }
    };
    proxies.iter().map(meets).fold(f32::INFINITY, f32::min)
}

/// Pairs (cell of the centre, proxy) and where each cell's begin.
fn by_centre(cells: &GridParams, proxies: &[Proxy]) -> (Vec<u32>, Vec<u32>) {
    let dims = cells.dims.truncate();
    let cell = |p: &Proxy| {
        encode(
            voxel_of(p.position.truncate(), cells.lower.truncate(), cells.inverse_size.truncate(), dims),
            dims,
        )
    };
    let mut pairs: Vec<[u32; 2]> = proxies.iter().enumerate().map(|(i, p)| [cell(p), i as u32]).collect();
    pairs.sort();
    let starts = (0..=cells.dims.w).map(|c| pairs.partition_point(|p| p[0] < c) as u32).collect();
    (pairs.concat(), starts)
}

#[test]
fn a_walk_through_cells_finds_the_nearest_disc() {
    let scene = Scene::open("cornell-box").unwrap();
    let b = Built::new(&scene, &VisibilityFilter { proxies: 3_000, overlap: 1.5, ..Default::default() });
    let proxies = b.cpu.download(&b.proxies.proxies);
    let Discs { grid, starts, pairs } = b.discs();
    let trace = |ray: &ProxyRay| trace_proxies(&grid, &starts, &pairs, &proxies, ray);
    let mut random = Random(11);
    let (mut met, mut by_centres) = (0, 0);
    let (centres, centre_starts) = by_centre(&grid, &proxies);
    for i in 0..6_000 {
        let from_surface = i % 2 == 0;
        let p = &proxies[(random.next() * proxies.len() as f32) as usize];
        let (origin, side) = if from_surface {
            (p.position.truncate(), if i % 4 == 0 { 1.0 } else { -1.0 })
        } else {
            (Vec3::Y + random.point(1.5), 0.0)
        };
        let mut direction = random.direction();
        if from_surface && direction.dot(p.normal.truncate()) * side < 0.0 {
            direction = -direction;
        }
        let ray = ProxyRay { origin, direction, side };
        let (hit, expected) = (trace(&ray), nearest(&proxies, &ray));
        // Cells end with the scene: discs that stand out of its box are not met there.
        let end = ray.origin + ray.direction * expected.min(1e3);
        if expected.is_finite() && ((end - Vec3::Y).abs().max_element() > 1.0) {
            continue;
        }
        if hit.proxy == NO_VOXEL {
            assert!(expected.is_infinite(), "{ray:?}: missed a disc at {expected}");
        } else {
            met += 1;
            assert_eq!(hit.t, expected, "{ray:?}");
        }
        // Negative control: discs listed in the cell of their centre alone.
        let lost = trace_proxies(&grid, &centre_starts, &centres, &proxies, &ray);
        by_centres += u32::from(lost.t != hit.t);
    }
    assert!(by_centres > 300, "only {by_centres} rays miss what reaches over a border");
    assert!(met > 2_000, "only {met} rays met discs");
}
