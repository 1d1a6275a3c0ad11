//! What are the formulas of indirect illumination, written so that a CPU and a GPU give the same bits?
//!
//! Every kernel is a plain function on `f32`, `u32` and glam vectors: pure, total, without allocation.
//! Compiled natively it gives the *strict* result; compiled by rust-gpu it gives the same bits when the
//! float operations carry `NoContraction` (the `strict` modules of `twinlight-gpu` do).
//!
//! ```
//! use twinlight_kernels::cone;
//!
//! // A sample of opacity 0.5 taken over half a voxel, twice, covers as much as over a whole one.
//! let half = cone::corrected_opacity(0.5, 0.5);
//! assert!(((1.0 - half) * (1.0 - half) - 0.5).abs() < 1e-6);
//! ```
#![no_std]
#![forbid(unsafe_code)]
// Spelled-out comparisons define what NaN does; the suggested forms do not or compile to other code on a GPU.
#![allow(clippy::manual_clamp, clippy::neg_cmp_op_on_partial_ord)]
// Indices: iterators over slices do not compile to SPIR-V.
#![allow(clippy::needless_range_loop)]

#[cfg(any(test, all(feature = "std", not(target_arch = "spirv"))))]
extern crate std;

pub use bytemuck;

#[macro_use]
pub mod layout;

pub mod cone;
pub mod gaussian;
pub mod geometry;
pub mod math;
pub mod passes;
pub mod sampling;
pub mod sh;
