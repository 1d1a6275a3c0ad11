//! How does low-frequency light and shadow live in spherical harmonics?
//!
//! A vector of order n has n² coefficients `[f32; N]` (N = 4, 9, 16, 25 for orders 2 to 5), index l² + l + m; a zonal
//! vector has one coefficient per band `[f32; B]`. Sign convention: every odd-|m| function carries a minus sign, as in
//! DirectX. Directions are unit vectors; one that is off by δ changes band l by about (l + 1)δ.
//!
//! [`project`] and [`irradiance`] make light, [`cap`] and [`visibility`] shadows; [`product`] combines two, and many
//! are combined as the [`hybrid`] exponential of the sum of their logarithms ([`log_occlusion`]).

mod basis;
mod blocker;
mod emitter;
mod exponential;
mod logarithm;
mod product;
mod rotation;
mod rotation_tables;
mod triple_products;
mod zonal;

pub use basis::{
    UNIT, add_scaled, basis, basis_order2, basis_order3, basis_order4, basis_order5, dot, evaluate,
    is_finite, project,
};
pub use blocker::{
    Blocker, EXACT_OPERATOR_WORDS, FADE, averaged_operator, averaged_operator_fit, blocker, exact_operator,
};
pub use emitter::lambert_intensity;
pub use exponential::{
    MAX_HALVINGS, SMALL_NORM, clamp_to_feasible, hybrid, hybrid_with_table, norm_without_dc, occluded_dc,
    optimal_linear, product_series, taylor,
};
pub use logarithm::{influence_key, influence_weight, log_occlusion, occlusion_key};
pub use product::{product, square};
pub use rotation::rotate;
pub use rotation_tables::{LOBE_DIRECTIONS, LOBE_WEIGHTS_1, LOBE_WEIGHTS_2, LOBE_WEIGHTS_3, LOBE_WEIGHTS_4};
pub use zonal::{CLAMPED_COSINE, cap, cap_solid_angle, convolve, irradiance, rotate_zonal, visibility};
