//! How do scan, sort, compaction and reduction drive their passes?
//!
//! Each is a short sequence of passes of the list, so it runs on either backend with the same result.

use crate::backend::{Backend, BackendError, BufferLength};
use glam::Vec4;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::reduction::REDUCE_BLOCK;
use twinlight_kernels::passes::scan::SCAN_BLOCK;
use twinlight_kernels::passes::sort::{DIGITS, SORT_BLOCK};

/// Returns the exclusive scan of the first `count` values, modulo 2³².
pub fn exclusive_scan<B: Backend>(
    backend: &mut B,
    values: &B::Buffer<u32>,
    count: u32,
) -> Result<B::Buffer<u32>, BackendError> {
    let params = ScanParams { count, ..Default::default() };
    let mut within = backend.alloc("scan within blocks", count as usize)?;
    backend.scan_blocks(&params, values, &mut within, count)?;
    if count <= SCAN_BLOCK {
        return Ok(within);
    }
    let blocks = count.div_ceil(SCAN_BLOCK);
    let mut sums = backend.alloc("scan block sums", blocks as usize)?;
    backend.block_sums(&params, values, &mut sums, blocks)?;
    let offsets = exclusive_scan(backend, &sums, blocks)?;
    let mut scanned = backend.alloc("scan", count as usize)?;
    backend.add_block_offsets(&params, &within, &offsets, &mut scanned, count)?;
    Ok(scanned)
}

/// Returns the (key, index) pairs sorted by key, equal keys in their former order; pairs are interleaved.
///
/// `key_bits` bounds the keys: bits from there on are not looked at.
pub fn sort_pairs<B: Backend>(
    backend: &mut B,
    pairs: B::Buffer<u32>,
    key_bits: u32,
) -> Result<B::Buffer<u32>, BackendError> {
    let count = (pairs.element_count() / 2) as u32;
    let blocks = count.div_ceil(SORT_BLOCK).max(1);
    let mut sorted = pairs;
    for shift in (0..key_bits.min(32)).step_by(4) {
        let params = DigitParams { count, shift, blocks, ..Default::default() };
        let mut counts = backend.alloc("digit counts", (DIGITS * blocks) as usize)?;
        backend.count_digits(&params, &sorted, &mut counts, count)?;
        let offsets = exclusive_scan(backend, &counts, DIGITS * blocks)?;
        let mut placed = backend.alloc("sorted pairs", 2 * count as usize)?;
        backend.place_by_digit(&params, &sorted, &offsets, &mut placed, count)?;
        sorted = placed;
    }
    Ok(sorted)
}

/// Returns the indices of the flags that are 1, in order, and how many there are; flags are 0 or 1.
pub fn compact<B: Backend>(
    backend: &mut B,
    flags: &B::Buffer<u32>,
    count: u32,
) -> Result<(B::Buffer<u32>, u32), BackendError> {
    let (indices, _, found) = listed(backend, flags, count)?;
    Ok((indices, found))
}

/// The indices of flags that are 1, in order; how many stand before each flag; how many there are.
pub type Listed<B> = (<B as Backend>::Buffer<u32>, <B as Backend>::Buffer<u32>, u32);

/// Lists the flags that are 1.
pub fn listed<B: Backend>(
    backend: &mut B,
    flags: &B::Buffer<u32>,
    count: u32,
) -> Result<Listed<B>, BackendError> {
    let places = exclusive_scan(backend, flags, count)?;
    let mut indices = backend.alloc("compacted", count as usize)?;
    backend.compact_indices(
        &CompactParams { count, ..Default::default() },
        flags,
        &places,
        &mut indices,
        count,
    )?;
    if count == 0 {
        return Ok((indices, places, 0));
    }
    let last_place = backend.download(&places)?[count as usize - 1];
    let last_flag = backend.download(flags)?[count as usize - 1];
    Ok((indices, places, last_place + last_flag))
}

/// Returns the sum of the first `count` vectors in the fixed order of a tree of eights.
pub fn reduce<B: Backend>(
    backend: &mut B,
    values: &B::Buffer<Vec4>,
    count: u32,
) -> Result<Vec4, BackendError> {
    if count == 0 {
        return Ok(Vec4::ZERO);
    }
    let step = |backend: &mut B, values: &B::Buffer<Vec4>, count: u32| {
        let blocks = count.div_ceil(REDUCE_BLOCK);
        let mut sums = backend.alloc("partial sums", blocks as usize)?;
        backend.reduce_sum(&ReduceParams { count, ..Default::default() }, values, &mut sums, blocks)?;
        Ok::<_, BackendError>((sums, blocks))
    };
    let (mut sums, mut left) = step(backend, values, count)?;
    while left > 1 {
        (sums, left) = step(backend, &sums, left)?;
    }
    Ok(backend.download(&sums)?[0])
}
