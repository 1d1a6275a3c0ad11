//! Where does the field replace a distribution, a kernel or a window by a Gaussian?
//!
//! Direction lobes of voxels ([`length_to_variance`]), reflection lobes ([`specular_weight`]), similarity of pixels
//! ([`upsampling_weights`]), and the depths under a shadow-map texel ([`depth_coverage`]).

mod bilateral;
mod depth_window;
mod lobe;
mod specular;

pub use bilateral::{
    CoarseSamples, depth_similarity, gathering_weights, gaussian_falloff, geometric_weight, mean_or_zero,
    normal_similarity, place_weights, plane_similarity, shares_visibility, upsampling_weights,
};
pub use depth_window::{
    UNORM16_DEVIATION, depth_coverage, layer_coordinate, layer_decay, minimum_deviation, smooth_step,
    variance_from_moments, weighted_moments,
};
pub use lobe::{
    Lobe, MIN_LENGTH, cone_deviation, convolve_lengths, length_to_variance, lobe_of_mean, spread_to_variance,
    variance_to_length, von_mises_fisher_concentration,
};
pub use specular::{MIN_DEVIATION, lobe_offset, one_minus_cosine, specular_falloff, specular_weight};
