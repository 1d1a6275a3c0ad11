//! How does a renderer get indirect illumination that a CPU and a GPU agree on?
//!
//! [`scene`] reads a glTF file or makes a built-in scene, in the buffers that the kernels of
//! [`twinlight_kernels`] work on, and builds the tree that their rays walk.
//!
//! ```
//! use twinlight::scene::{Scene, bvh::Bvh};
//!
//! let scene = Scene::open("cornell-box")?;
//! let tree = Bvh::build(&scene.triangles, &scene.materials)?;
//! assert!(tree.depth <= 21);
//! # Ok::<(), twinlight::error::SceneError>(())
//! ```
#![forbid(unsafe_code)]

pub mod backend;
pub mod cli;
pub mod error;
pub mod picture;
pub mod plan;
pub mod primitives;
pub mod renderer;
pub mod report;
pub mod scene;
pub mod technique;

/// The README's examples, compiled and run as tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
