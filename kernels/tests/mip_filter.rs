//! Does the 3 × 3 × 3 filter of voxels keep what is the same everywhere? VCT §8.2.

// Planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

use glam::{UVec3, Vec3};
use twinlight_kernels::geometry::lattice::{
    BLOCK_WORDS, block_count, block_of, level_offset, pack_point, point_bit, voxel_at,
};
use twinlight_kernels::passes::Accumulate;
use twinlight_kernels::passes::voxel_cones::build::{PyramidParams, filter_depths};
use twinlight_kernels::passes::voxel_cones::filter::filter_radiance;
use twinlight_kernels::passes::voxel_cones::inject::RADIANCE_WORDS;
use twinlight_kernels::passes::voxel_cones::storage::{
    FLOAT, STORAGE_SHIFT, pack_depths, radiance_word, unpack_depths, words_of,
};

/// Half an ULP at 1.
const EPS: f32 = 5.960_464_5e-8;

/// A pyramid in which every point is a voxel.
struct Dense {
    blocks: Vec<u32>,
    /// The number of each level's first voxel, leaves first.
    first: Vec<u32>,
    /// Points of the level above the leaves, in the order of its voxels.
    points: Vec<u32>,
}

fn dense(depth: u32) -> Dense {
    let mut blocks = vec![0u32; (BLOCK_WORDS * block_count(depth)) as usize];
    let lattice = |level: u32| {
        let side = (1u32 << (depth - level)) + 1;
        (0..side.pow(3)).map(move |i| UVec3::new(i % side, i / side % side, i / side / side))
    };
    for level in 0..=depth {
        for p in lattice(level) {
            let at = BLOCK_WORDS * block_of(depth, level, p) + point_bit(p) / 32;
            blocks[at as usize] |= 1 << (point_bit(p) % 32);
        }
    }
    let (mut voxels, mut first) = (0, vec![0; depth as usize + 1]);
    for block in 0..block_count(depth) {
        if let Some(level) = (0..=depth).find(|l| level_offset(depth, *l) == block) {
            first[level as usize] = voxels;
        }
        let at = (BLOCK_WORDS * block) as usize;
        blocks[at + 2] = voxels;
        voxels += blocks[at].count_ones() + blocks[at + 1].count_ones();
    }
    let mut points: Vec<_> = lattice(1).map(|p| (voxel_at(&blocks, depth, 1, p), pack_point(p))).collect();
    points.sort_unstable();
    Dense { blocks, first, points: points.into_iter().map(|(_, p)| p).collect() }
}

impl Dense {
    fn params(&self, depth: u32) -> PyramidParams {
        PyramidParams {
            depth,
            level: 1,
            first: self.first[1],
            child_first: self.first[0],
            flags: FLOAT << STORAGE_SHIFT,
            ..bytemuck::Zeroable::zeroed()
        }
    }
}

struct Words(Vec<u32>);

impl Accumulate for Words {
    fn add(&mut self, at: u32, value: u32) {
        self.0[at as usize] += value;
    }
    fn or(&mut self, at: u32, value: u32) {
        self.0[at as usize] |= value;
    }
    fn min(&mut self, at: u32, value: u32) {
        self.0[at as usize] = self.0[at as usize].min(value);
    }
    fn max(&mut self, at: u32, value: u32) {
        self.0[at as usize] = self.0[at as usize].max(value);
    }
}

const DEPTH: u32 = 3;
/// The point in the middle, which has all 27 children.
const MIDDLE: UVec3 = UVec3::new(2, 2, 2);

/// Weights of the centre, six faces, twelve edges and eight corners.
fn class_weights(number: u32) -> [f32; 4] {
    let aside = u32::from(number % 3 != 1) + u32::from(number / 3 % 3 != 1) + u32::from(number / 9 != 1);
    std::array::from_fn(|class| if class as u32 == aside { 0.125 / (1 << aside) as f32 } else { 0.0 })
}

/// The optical depth along x of each voxel of the level above, of one leaf with a depth of `word`.
fn above(d: &Dense, leaf: UVec3, word: u32) -> Vec<f32> {
    let mut children = vec![0; 9usize.pow(3)];
    children[(voxel_at(&d.blocks, DEPTH, 0, leaf) - d.first[0]) as usize] = word;
    let params = d.params(DEPTH);
    (0..d.points.len() as u32)
        .map(|i| unpack_depths(filter_depths(i, &params, &d.points, &d.blocks, &children)).x)
        .collect()
}

#[test]
fn each_child_counts_by_its_class() {
    let whole = (0..27).flat_map(class_weights).fold(0.0f32, |sum, w| sum + w);
    assert_eq!(whole, 1.0);
    // VCT's text lists three passes: centre, faces and corners.
    let published: f32 = (0..27).flat_map(|n| [0, 1, 3].map(|class| class_weights(n)[class])).sum();
    assert_eq!(published, 0.625, "planted fault: the twelve edges are forgotten");
    let d = dense(DEPTH);
    let index = (voxel_at(&d.blocks, DEPTH, 1, MIDDLE) - d.first[1]) as usize;
    let word = pack_depths(Vec3::splat(0.1));
    let depth = unpack_depths(word).x;
    let (mut worst, mut of_even) = (0.0f32, 0.0f32);
    for number in 0..27 {
        let child = MIDDLE * 2 + UVec3::new(number % 3, number / 3 % 3, number / 9) - UVec3::ONE;
        let got = above(&d, child, word)[index];
        let weight: f32 = class_weights(number).iter().sum();
        // Depths in twice as wide voxels are twice as large; what is averaged are opacities, here nearly the same.
        worst = worst.max((got / (2.0 * depth * weight) - 1.0).abs());
        of_even = of_even.max((got / (2.0 * depth / 27.0) - 1.0).abs());
    }
    println!("a child's share of the depth: within {worst:.3} of its class's weight");
    assert!(worst < 0.08, "{worst}");
    assert!(of_even > 0.5, "planted fault: equal weights for all 27 children");
}

#[test]
fn nothing_of_a_leaf_is_lost() {
    let d = dense(DEPTH);
    let word = pack_depths(Vec3::splat(0.1));
    // Between parents on no, one, two and three axes.
    for leaf in [UVec3::new(4, 4, 4), UVec3::new(4, 4, 3), UVec3::new(5, 4, 3), UVec3::new(3, 5, 3)] {
        // Faces above are four times as large.
        let all = 4.0 * above(&d, leaf, word).iter().sum::<f32>() / unpack_depths(word).x;
        println!("leaf {leaf}: {all:.3} of its depth times face");
        // Depths are kept in steps, and opacities are averaged.
        assert!((all - 1.0).abs() < 0.1, "{leaf}: {all}");
    }
}

#[test]
fn a_mist_alike_everywhere_stays_the_mist() {
    let d = dense(DEPTH);
    let params = d.params(DEPTH);
    let index = voxel_at(&d.blocks, DEPTH, 1, MIDDLE) - d.first[1];
    assert_eq!(d.points[index as usize], pack_point(MIDDLE));
    let leaves = 9usize.pow(3);
    let mut worst = 0.0f32;
    for step in 1..=700u32 {
        // Twice the depth, for a voxel is two of its children wide: the same mist.
        let child = step | ((step / 2 + 1) << 10) | ((701 - step) << 20);
        let want = unpack_depths(child) * 2.0;
        let got = filter_depths(index, &params, &d.points, &d.blocks, &vec![child; leaves]);
        // Depths from 8·0.9999 on are kept as the share of light that passes, to 10⁻⁴.
        let dense = want.max_element() > 7.5;
        assert!(dense || got == pack_depths(want), "step {step}: {} for {want}", unpack_depths(got));
        let share = |depth: Vec3| Vec3::from_array(depth.to_array().map(|x| 1.0 - (-x).exp()));
        worst = worst.max((share(unpack_depths(got)) - share(want)).abs().max_element());
    }
    println!("share of light blocked: off by {worst:.1e}");
    assert!(worst < 5e-3, "{worst}");
    // Planted fault: each of the twelve edges, left out, is noticed.
    let child = 300 | (300 << 10) | (300 << 20);
    let same = filter_depths(index, &params, &d.points, &d.blocks, &vec![child; leaves]);
    for number in (0..27).filter(|n| class_weights(*n)[2] > 0.0) {
        let at = MIDDLE * 2 + UVec3::new(number % 3, number / 3 % 3, number / 9) - UVec3::ONE;
        let mut children = vec![child; leaves];
        children[(voxel_at(&d.blocks, DEPTH, 0, at) - d.first[0]) as usize] = 0;
        assert_ne!(filter_depths(index, &params, &d.points, &d.blocks, &children), same, "edge {number}");
    }
}

#[test]
fn light_alike_everywhere_stays_the_same() {
    let d = dense(DEPTH);
    let params = d.params(DEPTH);
    let index = voxel_at(&d.blocks, DEPTH, 1, MIDDLE) - d.first[1];
    let leaves = 9u32.pow(3);
    let places: Vec<u32> = (1..=leaves).collect();
    // The middle voxel alone is lit among its level's: its radiance goes to the start.
    let lit = vec![index];
    let radiance = Vec3::new(0.7, 12.3, 1.0 / 3.0);
    let stored: Vec<u32> = (0..leaves * RADIANCE_WORDS)
        .flat_map(|_| (0..words_of(FLOAT)).map(|word| radiance_word(FLOAT, radiance, word)))
        .collect();
    let mut worst = 0.0f32;
    for step in [1u32, 3, 30, 100, 300, 700, 1023] {
        let depths = vec![step | (step << 10) | (step << 20); d.first[0] as usize + leaves as usize];
        let mut out = Words(vec![0; (RADIANCE_WORDS * words_of(FLOAT)) as usize]);
        filter_radiance(0, &params, &lit, &d.points, &d.blocks, &depths, &places, &stored, &mut out);
        for (i, word) in out.0.iter().enumerate() {
            let off = f32::from_bits(*word) / radiance[i % 3] - 1.0;
            // What a thin mist blocks is the difference of 1 and its transmittance.
            let condition = 1.0 / (1.0 - (-unpack_depths(step)[0]).exp());
            worst = worst.max(off.abs() / condition);
        }
    }
    println!("radiance: off by {:.1} × 2⁻²⁴ for a dense mist", worst / EPS);
    assert!(worst < 8.0 * EPS, "{worst}");
    // Negative control: a single dark child among 27 is noticed.
    let mut dark = places;
    dark[(voxel_at(&d.blocks, DEPTH, 0, MIDDLE * 2) - d.first[0]) as usize] = 0;
    let depths = vec![300 | (300 << 10) | (300 << 20); d.first[0] as usize + leaves as usize];
    let mut out = Words(vec![0; (RADIANCE_WORDS * words_of(FLOAT)) as usize]);
    filter_radiance(0, &params, &lit, &d.points, &d.blocks, &depths, &dark, &stored, &mut out);
    assert!(f32::from_bits(out.0[0]) < 0.95 * radiance[0]);
}
