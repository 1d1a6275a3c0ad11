//! What may a scatter pass do to its output, and how does an invocation find its item?

use glam::UVec3;

/// Integer accumulation into a buffer of `u32` that gives the same sums in any order of threads.
///
/// Indices beyond the buffer are ignored.
pub trait Accumulate {
    /// Adds `value` to the cell, modulo 2³².
    fn add(&mut self, index: u32, value: u32);
    /// Sets the bits of `value` in the cell.
    fn or(&mut self, index: u32, value: u32);
    /// Lowers the cell to `value` if that is smaller.
    fn min(&mut self, index: u32, value: u32);
    /// Raises the cell to `value` if that is larger.
    fn max(&mut self, index: u32, value: u32);
}

/// The uniform block of every GPU entry point: how many items there are, then the pass's parameters.
#[repr(C)]
#[derive(Clone, Copy)]
pub struct Launch<P> {
    /// Number of work items; invocations beyond it do nothing.
    pub items: u32,
    /// Invocations in one row of workgroups: large launches are two-dimensional.
    pub row: u32,
    /// Always 0, which a compiler cannot know.
    pub zero: u32,
    /// Padding: parameters begin at byte 16.
    pub pad: u32,
    /// The pass's parameters.
    pub params: P,
}

impl<P> Launch<P> {
    /// Returns the work item of the invocation with this global id.
    #[inline]
    pub fn index(&self, id: UVec3) -> u32 {
        id.y * self.row + id.x
    }
}
