//! Which options set the knobs of soft global illumination?

use crate::technique::soft_gi::{Exponential, Operator, SoftGi};
use clap::{Args, ValueEnum};

/// The knobs; what is left out keeps the default or the preset's value.
#[derive(Args, Clone, Default, PartialEq)]
#[command(next_help_heading = "Soft global illumination")]
pub(crate) struct SoftGiOptions {
    /// Order of the spherical harmonics of light and shadow, 2 to 5
    #[arg(long, value_name = "N")]
    order: Option<u32>,
    /// How visibility comes from the sum of logarithms
    #[arg(long)]
    exponential: Option<ExponentialChoice>,
    /// Norm below which hybrid and taylor need no further square
    #[arg(long, value_name = "τ", allow_hyphen_values = true)]
    tau: Option<f32>,
    /// Terms of the series
    #[arg(long, value_name = "N")]
    terms: Option<u32>,
    /// What the light of a proxy is taken to be
    #[arg(long)]
    operator: Option<OperatorChoice>,
    /// η of shadows: a proxy's reach in its radii [default: as the light needs]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    shadow_reach: Option<f32>,
    /// η of reflected light
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    light_reach: Option<f32>,
    /// Pixels for a receiver along each axis: 1, 2, 4 or 8
    #[arg(long, value_name = "N")]
    receiver_scale: Option<u32>,
    /// Rows of the table of logarithms, 16 to 4096
    #[arg(long, value_name = "N")]
    log_entries: Option<u32>,
    /// δ: where a proxy that holds a receiver from below has faded in, in its radii outside of it
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    self_shadow_fade: Option<f32>,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum ExponentialChoice {
    /// Scaling, optimal linear, squaring
    Hybrid,
    /// Optimal linear alone
    OptimalLinear,
    /// A product series
    Series,
    /// Scaling, three terms, squaring
    Taylor,
    /// None: a product for each proxy
    Product,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum OperatorChoice {
    /// That of the middle
    Point,
    /// The mean, by the paper's polynomials
    AveragedFit,
    /// The mean
    Averaged,
    /// As it is distributed
    Exact,
}

impl SoftGiOptions {
    /// Sets the knobs that the options name.
    pub(super) fn apply(&self, s: &mut SoftGi) {
        s.order = self.order.unwrap_or(s.order);
        s.tau = self.tau.unwrap_or(s.tau);
        s.terms = self.terms.unwrap_or(s.terms);
        s.shadow_reach = self.shadow_reach.or(s.shadow_reach);
        s.light_reach = self.light_reach.unwrap_or(s.light_reach);
        s.receiver_scale = self.receiver_scale.unwrap_or(s.receiver_scale);
        s.entries = self.log_entries.unwrap_or(s.entries);
        s.fade = self.self_shadow_fade.unwrap_or(s.fade);
        s.exponential = match self.exponential {
            None => s.exponential,
            Some(ExponentialChoice::Hybrid) => Exponential::Hybrid,
            Some(ExponentialChoice::OptimalLinear) => Exponential::OptimalLinear,
            Some(ExponentialChoice::Series) => Exponential::Series,
            Some(ExponentialChoice::Taylor) => Exponential::Taylor,
            Some(ExponentialChoice::Product) => Exponential::Product,
        };
        s.operator = match self.operator {
            None => s.operator,
            Some(OperatorChoice::Point) => Operator::Point,
            Some(OperatorChoice::AveragedFit) => Operator::AveragedFit,
            Some(OperatorChoice::Averaged) => Operator::Averaged,
            Some(OperatorChoice::Exact) => Operator::Exact,
        };
    }
}
