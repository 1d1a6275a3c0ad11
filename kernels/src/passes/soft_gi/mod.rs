//! Soft shadows and inter-reflection by spherical proxies under light in spherical harmonics. Sloan et al. 2007 (SGI).
//!
//! [`cull`] lists for each tile of receivers the proxies that reach it, [`accumulate`] adds the logarithms of their
//! visibility up and takes the exponential (or multiplies them), [`indirect`] adds up what they reflect, [`shade`] puts both together.

pub mod accumulate;
pub mod cull;
pub mod indirect;
mod receiver;
pub mod shade;

use glam::Vec4;

/// [`SoftParams::exponential`]: scaling, optimal linear, squaring.
pub const HYBRID: u32 = 0;
/// [`SoftParams::exponential`]: optimal linear alone.
pub const OPTIMAL_LINEAR: u32 = 1;
/// [`SoftParams::exponential`]: a product series.
pub const SERIES: u32 = 2;
/// [`SoftParams::exponential`]: scaling, a series of three terms, squaring.
pub const TAYLOR: u32 = 3;

/// [`SoftParams::exponential`]: none, visibilities are multiplied.
pub const PRODUCT: u32 = 4;

/// [`SoftParams::operator`]: radiance in the middle of the proxy.
pub const POINT: u32 = 0;
/// [`SoftParams::operator`]: mean radiance by SGI's polynomials.
pub const AVERAGED_FIT: u32 = 1;
/// [`SoftParams::operator`]: mean radiance.
pub const AVERAGED: u32 = 2;
/// [`SoftParams::operator`]: radiance as it is distributed.
pub const EXACT: u32 = 3;

/// [`SoftParams::parts`]: light of the surroundings past the proxies.
pub const SHADOWED: u32 = 1;
/// [`SoftParams::parts`]: light that proxies reflect.
pub const REFLECTED: u32 = 2;

gpu_struct! {
    /// A spherical proxy.
    pub struct SphereProxy {
        /// Centre, metres; w is the radius.
        pub sphere: Vec4,
        /// Albedo; w is unused.
        pub albedo: Vec4,
    }

    /// Parameters of the passes of soft global illumination.
    pub struct SoftParams {
        /// Receivers in a row.
        pub width: u32,
        /// Rows of receivers.
        pub height: u32,
        /// Receivers along a side of a tile.
        pub tile: u32,
        /// Tiles in a row.
        pub tiles_x: u32,
        /// Number of proxies.
        pub proxies: u32,
        /// Order of shadows, 2 to 5.
        pub order: u32,
        /// [`HYBRID`], [`OPTIMAL_LINEAR`], [`SERIES`], [`TAYLOR`] or [`PRODUCT`].
        pub exponential: u32,
        /// Terms of the series.
        pub terms: u32,
        /// τ of the scaling.
        pub tau: f32,
        /// Radius within which a proxy shadows, in its radii.
        pub shadow_reach: f32,
        /// Radius within which a proxy's light counts, in its radii.
        pub light_reach: f32,
        /// [`POINT`], [`AVERAGED_FIT`], [`AVERAGED`] or [`EXACT`].
        pub operator: u32,
        /// Rows of the table of logarithms.
        pub entries: u32,
        /// Rows of the table of the exact operator.
        pub operator_entries: u32,
        /// Pairs in the table of the optimal linear exponential.
        pub pairs: u32,
        /// [`SHADOWED`], [`REFLECTED`].
        pub parts: u32,
        /// Where a sphere that holds a point from below has faded in, in its radii outside of it.
        pub fade: f32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}
