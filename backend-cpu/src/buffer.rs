//! What is a buffer on the CPU, and how do threads add to it at once?

use bytemuck::Pod;
use std::sync::atomic::{AtomicU32, Ordering};
use twinlight_kernels::passes::Accumulate;

/// A typed array in main memory.
#[derive(Clone, Debug)]
pub struct CpuBuffer<T> {
    pub(crate) values: Vec<T>,
}

impl<T: Pod> CpuBuffer<T> {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.values.len()
    }

    /// True for a buffer without elements.
    pub fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Size in bytes.
    pub fn bytes(&self) -> u64 {
        std::mem::size_of_val(self.values.as_slice()) as u64
    }

    /// The elements.
    pub fn as_slice(&self) -> &[T] {
        &self.values
    }
}

/// A thread's view of the output of a scatter pass.
#[derive(Clone, Copy)]
pub(crate) struct AtomicView<'a> {
    cells: &'a [AtomicU32],
}

impl<'a> AtomicView<'a> {
    pub(crate) fn new(cells: &'a mut [u32]) -> Self {
        // SAFETY: AtomicU32 has the size and bit validity of u32, and the alignment is the same on every target
        // that has it; the exclusive borrow guarantees that for 'a nothing reads the cells but through this view.
        let cells =
            unsafe { std::slice::from_raw_parts(cells.as_mut_ptr().cast::<AtomicU32>(), cells.len()) };
        Self { cells }
    }
}

macro_rules! atomic {
    ($($method:ident = $operation:ident;)*) => {$(
        #[inline]
        fn $method(&mut self, index: u32, value: u32) {
            if let Some(cell) = self.cells.get(index as usize) {
                // Relaxed: the operations commute, and the join at the end of the pass orders them with readers.
                cell.$operation(value, Ordering::Relaxed);
            }
        }
    )*};
}

impl Accumulate for AtomicView<'_> {
    atomic! {
        add = fetch_add;
        or = fetch_or;
        min = fetch_min;
        max = fetch_max;
    }
}
