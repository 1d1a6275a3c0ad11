//! Are the lists the unions that eq. 4 asks for, whatever their length?

use crate::Random;
use glam::{Vec3, Vec4};
use std::collections::{BTreeMap, BTreeSet};
use twinlight_kernels::passes::elements::{ListParams, Surface};
use twinlight_kernels::passes::visibility_filter::list::list_stride;
use twinlight_kernels::passes::visibility_filter::march::NO_VOXEL;
use twinlight_kernels::passes::{self, Accumulate};

const WIDTH: u32 = 13;
const HEIGHT: u32 = 9;
const PIXELS: u32 = WIDTH * HEIGHT;
const DIFFUSE: u32 = 7;
const LOBE: u32 = 2;
const RAYS: u32 = DIFFUSE + LOBE;

struct Cells(Vec<u32>);

impl Accumulate for Cells {
    fn add(&mut self, index: u32, value: u32) {
        self.0[index as usize] += value;
    }
    fn or(&mut self, index: u32, value: u32) {
        assert!(self.0[index as usize] == 0 || value == 0, "word {index} is written twice");
        self.0[index as usize] |= value;
    }
    fn min(&mut self, _: u32, _: u32) {
        unreachable!();
    }
    fn max(&mut self, _: u32, _: u32) {
        unreachable!();
    }
}

/// Two walls that meet in the middle of the picture, with gaps, and what random rays met.
fn inputs(random: &mut Random, voxels: u32) -> (Vec<Surface>, Vec<u32>) {
    let surfaces = (0..PIXELS)
        .map(|i| {
            let (x, y) = ((i % WIDTH) as f32, (i / WIDTH) as f32);
            if random.next() < 0.1 {
                return Surface { triangle: u32::MAX, position: Vec4::NEG_W, ..Default::default() };
            }
            let (normal, z) = if i % WIDTH < 6 { (Vec3::Z, 0.0) } else { (Vec3::X, x - 6.0) };
            let bump = random.direction() * 0.3;
            Surface {
                position: Vec4::new(x.min(6.0), y, z, 10.0),
                normal: (normal + bump).normalize().extend(1.0),
                ..Default::default()
            }
        })
        .collect::<Vec<Surface>>();
    let met = (0..PIXELS * RAYS)
        .map(|i| {
            let s = &surfaces[(i / RAYS) as usize];
            if s.triangle == u32::MAX || random.next() < 0.2 {
                NO_VOXEL
            } else {
                (random.next() * random.next() * voxels as f32) as u32
            }
        })
        .collect();
    (surfaces, met)
}

fn params(capacity: u32, half: (u32, u32), occupied: u32) -> ListParams {
    ListParams {
        width: WIDTH,
        height: HEIGHT,
        diffuse_rays: DIFFUSE,
        lobe_rays: LOBE,
        half_width: half.0,
        half_height: half.1,
        capacity,
        max_depth_difference: 0.12,
        min_normal_cosine: 0.85,
        occupied,
        ..Default::default()
    }
}

fn lists(params: &ListParams, surfaces: &[Surface], met: &[u32]) -> Vec<u32> {
    let mut sorted = Cells(vec![0; (PIXELS * RAYS) as usize]);
    (0..PIXELS * RAYS).for_each(|i| passes::sort_rays(i, params, met, &mut sorted));
    let mut counted = Cells(vec![0; (PIXELS * (RAYS + 1)) as usize]);
    (0..PIXELS).for_each(|i| passes::count_rays(i, params, &sorted.0, &mut counted));
    let mut out = Cells(vec![0; (PIXELS * list_stride(params.capacity)) as usize]);
    (0..PIXELS).for_each(|i| passes::filter_lists(i, params, surfaces, &counted.0, &mut out));
    out.0
}

/// One list: rays, dropped voxels, counts by voxel; checks how many rays met anything.
fn read(list: &[u32]) -> (u32, u32, BTreeMap<u32, u32>) {
    let kept = list[1] as usize;
    let pairs: Vec<(u32, u32)> = list[4..4 + 2 * kept].chunks_exact(2).map(|p| (p[0] - 1, p[1])).collect();
    assert!(pairs.is_sorted_by(|a, b| a.0 < b.0), "{pairs:?}");
    assert!(list[4 + 2 * kept..].iter().all(|&w| w == 0), "behind the list");
    let met: u32 = pairs.iter().map(|p| p.1).sum();
    assert!(
        list[3] == met || (list[2] > 0 && list[3] > met),
        "{} rays met something, {met} are listed",
        list[3]
    );
    (list[0], list[2], pairs.into_iter().collect())
}

/// Whether two pixels exchange lists, as eq. 4 with planes instead of depths says.
fn exchange(p: &ListParams, a: &Surface, b: &Surface) -> bool {
    if a.triangle == u32::MAX || b.triangle == u32::MAX {
        return false;
    }
    let between = (b.position - a.position).truncate();
    let (na, nb) = (a.normal.truncate(), b.normal.truncate());
    let off = between.dot(na).abs().max(between.dot(nb).abs());
    off <= p.max_depth_difference * a.position.w.max(b.position.w) && na.dot(nb) >= p.min_normal_cosine
}

fn oracle(p: &ListParams, surfaces: &[Surface], met: &[u32], pixel: u32) -> (u32, BTreeMap<u32, u32>) {
    let (x, y) = ((pixel % WIDTH) as i32, (pixel / WIDTH) as i32);
    let (n, m) = (p.half_width as i32, p.half_height as i32);
    let (mut rays, mut union) = (0, BTreeMap::new());
    for j in (y - m).max(0)..=(y + m).min(HEIGHT as i32 - 1) {
        for i in (x - n).max(0)..=(x + n).min(WIDTH as i32 - 1) {
            let other = j as u32 * WIDTH + i as u32;
            if !exchange(p, &surfaces[pixel as usize], &surfaces[other as usize]) {
                continue;
            }
            rays += DIFFUSE;
            for ray in 0..RAYS {
                let voxel = met[(other * RAYS + ray) as usize];
                if voxel != NO_VOXEL {
                    *union.entry(voxel).or_insert(0) += u32::from(ray < DIFFUSE);
                }
            }
        }
    }
    (rays, union)
}

#[test]
fn lists_are_unions_with_counts() {
    let mut random = Random(21);
    let mut largest = 0;
    for round in 0..12 {
        let voxels = [5, 60, 2_000][round % 3];
        let (surfaces, met) = inputs(&mut random, voxels);
        let half = [(3, 3), (0, 0), (4, 1), (2, 4)][round % 4];
        let p = params(600, half, voxels);
        let out = lists(&p, &surfaces, &met);
        for (pixel, list) in out.chunks_exact(list_stride(600) as usize).enumerate() {
            let (rays, dropped, union) = read(list);
            let expected = oracle(&p, &surfaces, &met, pixel as u32);
            assert_eq!((rays, dropped, &union), (expected.0, 0, &expected.1), "round {round}, pixel {pixel}");
            largest = largest.max(union.len());
            let own = &met[pixel * RAYS as usize..(pixel + 1) * RAYS as usize];
            assert!(own.iter().all(|v| *v == NO_VOXEL || union.contains_key(v)), "a pixel's own voxels");
        }
    }
    assert!(largest > 100, "the largest union has {largest} voxels only");
}

#[test]
fn acceptance_is_symmetric_and_windows_only_add() {
    let mut random = Random(22);
    let (surfaces, met) = inputs(&mut random, 300);
    // Each pixel meets its own number alone: lists then say who exchanges with whom.
    let own: Vec<u32> =
        met.iter().enumerate().map(|(i, &v)| if v == NO_VOXEL { v } else { i as u32 / RAYS }).collect();
    let sets = |half, met: &[u32]| -> Vec<BTreeSet<u32>> {
        let p = params(600, half, 600);
        let out = lists(&p, &surfaces, met);
        out.chunks_exact(list_stride(600) as usize).map(|l| read(l).2.into_keys().collect()).collect()
    };
    let partners = sets((3, 3), &own);
    let mut pairs = 0;
    for (a, set) in partners.iter().enumerate() {
        for &b in set.iter().filter(|&&b| b as usize != a) {
            pairs += 1;
            let answered = own[a * RAYS as usize..].iter().take(RAYS as usize).any(|&v| v != NO_VOXEL);
            assert!(!answered || partners[b as usize].contains(&(a as u32)), "{a} takes from {b} only");
        }
    }
    assert!(pairs > 300);
    let (small, large) = (sets((1, 1), &met), sets((3, 3), &met));
    assert!(small.iter().zip(&large).all(|(s, l)| s.is_subset(l)));
    assert!(small.iter().zip(&large).any(|(s, l)| s.len() < l.len()));
}

#[test]
fn what_finds_no_room_is_counted_and_no_part_is_preferred() {
    let mut random = Random(23);
    let (mut kept_low, mut kept_high, mut cut_high, mut full) = (0, 0, 0, 0);
    for _ in 0..20 {
        let (surfaces, met) = inputs(&mut random, 1_000);
        let (roomy, tight) = (params(900, (3, 3), 1_000), params(40, (3, 3), 1_000));
        let all = lists(&roomy, &surfaces, &met);
        let some = lists(&tight, &surfaces, &met);
        let strides = (list_stride(900) as usize, list_stride(40) as usize);
        for (all, some) in all.chunks_exact(strides.0).zip(some.chunks_exact(strides.1)) {
            let ((rays, _, union), (rays_left, dropped, kept)) = (read(all), read(some));
            assert_eq!(kept.len() + dropped as usize, union.len());
            assert!(kept.len() <= 40 && kept.iter().all(|(v, c)| union[v] == *c));
            assert_eq!((rays_left, some[3]), (rays, all[3]), "thinning changes neither rays nor hits");
            if dropped > 0 {
                full += 1;
                assert!(kept.len() > 10, "{} of {} are kept where 40 fit", kept.len(), union.len());
                let middle = *union.keys().nth(union.len() / 2).unwrap();
                kept_low += kept.range(..middle).count();
                kept_high += kept.range(middle..).count();
                cut_high += 40usize.saturating_sub(union.len() / 2);
            }
        }
    }
    let balance = kept_low as f64 / kept_high as f64;
    println!("{full} lists too long; lower half {kept_low}, upper half {kept_high}");
    assert!(full > 500 && (0.93..1.07).contains(&balance), "{full} lists, balance {balance}");
    // Negative control: cutting off the end, as a plain list would.
    let cut = (40.0 * full as f64 - cut_high as f64) / cut_high as f64;
    assert!(cut > 1.5, "a cut-off list has a balance of {cut} only");
}
