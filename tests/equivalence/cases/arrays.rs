//! Inputs of the passes over plain arrays: layout, scan, sort, sums.

use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::Vec4;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::layout_report::LAYOUT_WORDS;
use twinlight_kernels::passes::reduction::REDUCE_BLOCK;
use twinlight_kernels::passes::scan::SCAN_BLOCK;
use twinlight_kernels::passes::sort::{DIGITS, SORT_BLOCK};

/// Sizes around the blocks' edges.
const SIZES: [u32; 7] = [1, 31, 32, 33, 128, 129, 1000];

pub fn report_layout(_: &mut Draw) -> Vec<case::report_layout> {
    let items = LAYOUT_WORDS.len() as u32 + 5;
    vec![case::report_layout {
        params: LayoutParams::default(),
        launch: Launch::new("all words and some beyond", items as usize, items),
    }]
}

fn words(draw: &mut Draw, count: u32) -> Vec<u32> {
    (0..count).map(|_| draw.word()).collect()
}

pub fn block_sums(draw: &mut Draw) -> Vec<case::block_sums> {
    let mut make = |count: u32| {
        let blocks = count.div_ceil(SCAN_BLOCK);
        case::block_sums {
            params: ScanParams { count, ..Default::default() },
            values: words(draw, count),
            launch: Launch::new(format!("{count} values"), blocks as usize, blocks),
        }
    };
    SIZES.iter().map(|&count| make(count)).collect()
}

pub fn scan_blocks(draw: &mut Draw) -> Vec<case::scan_blocks> {
    let mut make = |count: u32| case::scan_blocks {
        params: ScanParams { count, ..Default::default() },
        values: words(draw, count),
        launch: Launch::new(format!("{count} values"), count as usize, count),
    };
    SIZES.iter().map(|&count| make(count)).collect()
}

pub fn add_block_offsets(draw: &mut Draw) -> Vec<case::add_block_offsets> {
    let mut make = |count: u32| case::add_block_offsets {
        params: ScanParams { count, ..Default::default() },
        within: words(draw, count),
        offsets: words(draw, count.div_ceil(SCAN_BLOCK)),
        launch: Launch::new(format!("{count} values"), count as usize, count),
    };
    SIZES.iter().map(|&count| make(count)).collect()
}

/// The exclusive scan on the host.
pub(crate) fn scanned(values: &[u32]) -> Vec<u32> {
    let mut sum = 0u32;
    let before = |&v: &u32| {
        let before = sum;
        sum = sum.wrapping_add(v);
        before
    };
    values.iter().map(before).collect()
}

pub fn compact_indices(draw: &mut Draw) -> Vec<case::compact_indices> {
    let mut make = |count: u32| {
        let flags: Vec<u32> = (0..count).map(|_| draw.integer(0, 2)).collect();
        case::compact_indices {
            params: CompactParams { count, ..Default::default() },
            places: scanned(&flags),
            flags,
            launch: Launch::new(format!("{count} flags"), count as usize, count),
        }
    };
    SIZES.iter().map(|&count| make(count)).collect()
}

/// (key, index) pairs; half of the keys are small, so that many are equal.
fn pairs(draw: &mut Draw, count: u32) -> Vec<u32> {
    (0..count).flat_map(|i| [draw.word(), i]).collect()
}

fn digit_params(count: u32, shift: u32) -> DigitParams {
    DigitParams { count, shift, blocks: count.div_ceil(SORT_BLOCK), ..Default::default() }
}

/// The counts by digit, then by block, on the host.
fn counts(pairs: &[u32], params: &DigitParams) -> Vec<u32> {
    let mut counts = vec![0; (DIGITS * params.blocks) as usize];
    for i in 0..params.count {
        let digit = (pairs[2 * i as usize] >> params.shift) % DIGITS;
        counts[(digit * params.blocks + i / SORT_BLOCK) as usize] += 1;
    }
    counts
}

pub fn count_digits(draw: &mut Draw) -> Vec<case::count_digits> {
    let mut make = |count: u32| {
        let params = digit_params(count, 4 * draw.integer(0, 8));
        case::count_digits {
            params,
            items: pairs(draw, count),
            launch: Launch::new(
                format!("{count} pairs, digit at bit {}", params.shift),
                (DIGITS * params.blocks) as usize,
                count,
            ),
        }
    };
    SIZES.iter().map(|&count| make(count)).collect()
}

pub fn place_by_digit(draw: &mut Draw) -> Vec<case::place_by_digit> {
    let mut make = |count: u32| {
        let params = digit_params(count, 4 * draw.integer(0, 8));
        let pairs = pairs(draw, count);
        case::place_by_digit {
            params,
            offsets: scanned(&counts(&pairs, &params)),
            items: pairs,
            launch: Launch::new(
                format!("{count} pairs, digit at bit {}", params.shift),
                2 * count as usize,
                count,
            ),
        }
    };
    SIZES.iter().map(|&count| make(count)).collect()
}

pub fn reduce_sum(draw: &mut Draw) -> Vec<case::reduce_sum> {
    let mut make = |count: u32| {
        let blocks = count.div_ceil(REDUCE_BLOCK);
        case::reduce_sum {
            params: ReduceParams { count, ..Default::default() },
            values: (0..count).map(|_| draw.numbers(1e-6, 1e6)).collect(),
            launch: Launch::new(format!("{count} vectors"), blocks as usize, blocks),
        }
    };
    [1, 7, 8, 9, 63, 64, 65, 1000].iter().map(|&count| make(count)).collect()
}

pub fn add_radiance(draw: &mut Draw) -> Vec<case::add_radiance> {
    let vectors = |draw: &mut Draw| -> Vec<Vec4> { (0..1000).map(|_| draw.numbers(1e-30, 1e30)).collect() };
    vec![case::add_radiance {
        params: AddParams::default(),
        a: vectors(draw),
        b: vectors(draw),
        // One item less than the output holds: the last element must stay.
        launch: Launch::new("1000 vectors", 1000, 999),
    }]
}
