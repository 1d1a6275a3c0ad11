//! What do two buffers of radiance add up to?

use glam::Vec4;

gpu_struct! {
    /// Parameters of [`add_radiance`].
    pub struct AddParams {
        /// Padding: the pass needs none.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
        /// Padding.
        pub pad3: u32,
    }
}

/// Returns the sum of both buffers at `index`.
#[inline]
pub fn add_radiance(index: u32, params: &AddParams, a: &[Vec4], b: &[Vec4]) -> Vec4 {
    let _ = params;
    a[index as usize] + b[index as usize]
}
