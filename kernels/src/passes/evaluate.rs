//! What do the passes that evaluate single kernels take and give?

use glam::{UVec4, Vec4};

gpu_struct! {
    /// Parameters of the passes that evaluate one kernel per item.
    pub struct EvaluateParams {
        /// Which function; each pass has its own list.
        pub function: u32,
        /// A count that some functions need: cells of a walk, entries of a table, terms of a series.
        pub count: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }

    /// The result of a kernel that gives numbers and decisions.
    pub struct Evaluation {
        /// The numbers; unused ones are 0.
        pub numbers: Vec4,
        /// Integers and decisions (1 for true); unused ones are 0.
        pub words: UVec4,
    }
}

/// Numbers only.
#[inline]
pub(super) fn of_numbers(numbers: Vec4) -> Evaluation {
    Evaluation { numbers, words: UVec4::ZERO }
}

/// Integers only.
#[inline]
pub(super) fn of_words(words: UVec4) -> Evaluation {
    Evaluation { numbers: Vec4::ZERO, words }
}

/// A decision as an integer.
#[inline]
pub(super) fn bit(decision: bool) -> u32 {
    if decision { 1 } else { 0 }
}
