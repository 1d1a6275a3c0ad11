//! Which knobs does soft global illumination have, and what do they do to error and cost?

use super::ENTRIES;
use crate::error::SettingsError;
use twinlight_kernels::sh::FADE;

/// How the logarithms of visibility are exponentiated. SGI §3.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exponential {
    /// HYB: scaled down to τ, optimal linear, squared. At the noise floor of the order at τ = ½ up to 16 overlapping proxies.
    Hybrid,
    /// OL: optimal linear alone; cheapest, 0.1 off from eight overlapping proxies on.
    OptimalLinear,
    /// PS: a product series; its terms times a product; diverges for many proxies.
    Series,
    /// Scaled down to τ, three terms of the series, squared; no table, nearer to the exact exponential than HYB at its cost.
    Taylor,
    /// None: visibilities are multiplied proxy by proxy. What the others approximate; cost of a product for each proxy.
    Product,
}

/// What a proxy's light is taken to be. SGI §5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// Everywhere that of the middle of what is seen: up to 89 % off for small proxies.
    Point,
    /// Everywhere the mean, by the paper's polynomials.
    AveragedFit,
    /// Everywhere the mean: 8 to 26 % off as an operator, less in pictures.
    Averaged,
    /// As it is distributed; two rotations for each proxy and colour.
    Exact,
}

/// The knobs of soft global illumination; `docs/soft-gi.md` has their errors measured.
#[derive(Clone, Debug, PartialEq)]
pub struct SoftGi {
    /// Order of the harmonics of light and shadow, 2 to 5. Cost of a proxy its square; shadows get sharper.
    pub order: u32,
    /// How visibility comes from the sum of logarithms.
    pub exponential: Exponential,
    /// τ of [`Exponential::Hybrid`] and [`Exponential::Taylor`], ¹⁄₁₆ to 1: halving it costs one more square.
    pub tau: f32,
    /// Terms of [`Exponential::Series`], 2 to 16.
    pub terms: u32,
    /// What a proxy's light is taken to be.
    pub operator: Operator,
    /// η: radius within which a proxy shadows, in its radii, 1 to 1000; if none, from how peaked the light is.
    pub shadow_reach: Option<f32>,
    /// η of reflected light.
    pub light_reach: f32,
    /// Pixels for a receiver along each axis: 1, 2, 4 or 8. Cost its inverse square.
    pub receiver_scale: u32,
    /// Rows of the table of logarithms, 16 to 4096.
    pub entries: u32,
    /// δ: where a proxy that holds a receiver from below has faded in, in its radii outside of it, 0.001 to 10. Wider ones let light into creases.
    pub fade: f32,
}

impl Default for SoftGi {
    fn default() -> Self {
        Self {
            order: 4,
            exponential: Exponential::Hybrid,
            tau: 0.5,
            terms: 9,
            operator: Operator::Averaged,
            shadow_reach: None,
            light_reach: 10.0,
            receiver_scale: 2,
            entries: ENTRIES,
            fade: FADE,
        }
    }
}

impl SoftGi {
    /// The names of [`SoftGi::preset`].
    pub const PRESETS: [&str; 2] = ["paper", "paper-fast"];

    /// The settings of the paper: order 4, HYB, η 15 and 10, receivers at a quarter of the resolution (or an eighth).
    pub fn preset(name: &str) -> Option<Self> {
        let receiver_scale = match name {
            "paper" => 4,
            "paper-fast" => 8,
            _ => return None,
        };
        let operator = Operator::AveragedFit;
        Some(Self { shadow_reach: Some(15.0), receiver_scale, operator, ..Self::default() })
    }

    /// Receivers for a picture of this size.
    pub fn receivers(&self, width: u32, height: u32) -> (u32, u32) {
        (width.div_ceil(self.receiver_scale), height.div_ceil(self.receiver_scale))
    }

    /// Refuses what cannot be done for a picture of this size.
    ///
    /// # Errors
    /// The first knob that is out of range, with its range.
    pub fn check(&self, width: u32, height: u32) -> Result<(), SettingsError> {
        let refuse = |knob: &'static str, reason: String| Err(SettingsError { knob, reason });
        if !(2..=5).contains(&self.order) {
            return refuse("order", format!("{} is not from 2 to 5", self.order));
        }
        if !(self.tau >= 0.0625 && self.tau <= 1.0) {
            return refuse("tau", format!("{} is not from 0.0625 to 1", self.tau));
        }
        if !(2..=16).contains(&self.terms) {
            return refuse("terms", format!("{} is not from 2 to 16", self.terms));
        }
        for (knob, value) in
            [("shadow-reach", self.shadow_reach.unwrap_or(1.0)), ("light-reach", self.light_reach)]
        {
            if !(1.0..=1000.0).contains(&value) {
                return refuse(knob, format!("{value} is not from 1 to 1000"));
            }
        }
        if !(16..=4096).contains(&self.entries) {
            return refuse("log-entries", format!("{} is not from 16 to 4096", self.entries));
        }
        if !(self.fade >= 0.001 && self.fade <= 10.0) {
            return refuse("self-shadow-fade", format!("{} is not from 0.001 to 10", self.fade));
        }
        if ![1, 2, 4, 8].contains(&self.receiver_scale) {
            return refuse("receiver-scale", format!("{} is not 1, 2, 4 or 8", self.receiver_scale));
        }
        let (w, h) = self.receivers(width, height);
        let (count, most) = (u64::from(w) * u64::from(h), MAX_RECEIVERS);
        if count == 0 || count > most {
            let reason =
                format!("{w}x{h} receivers are not from 1 to {most}; raise it or make the picture smaller");
            return refuse("receiver-scale", reason);
        }
        Ok(())
    }
}

/// The largest number of receivers: two vectors of 112 bytes each.
pub const MAX_RECEIVERS: u64 = 1 << 20;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_settings_are_accepted_and_others_refused() {
        for name in SoftGi::PRESETS {
            SoftGi::preset(name).unwrap().check(1024, 1024).unwrap();
        }
        assert!(SoftGi::preset("teapot").is_none());
        type Spoil = fn(&mut SoftGi);
        let spoilt: [(&str, Spoil); 12] = [
            ("order", |s| s.order = 1),
            ("order", |s| s.order = 6),
            ("tau", |s| s.tau = f32::NAN),
            ("tau", |s| s.tau = 1.5),
            ("terms", |s| s.terms = 1),
            ("shadow-reach", |s| s.shadow_reach = Some(0.5)),
            ("light-reach", |s| s.light_reach = f32::INFINITY),
            ("receiver-scale", |s| s.receiver_scale = 3),
            ("receiver-scale", |s| s.receiver_scale = 0),
            ("log-entries", |s| s.entries = 15),
            ("self-shadow-fade", |s| s.fade = 0.0),
            ("self-shadow-fade", |s| s.fade = f32::NAN),
        ];
        for (knob, spoil) in spoilt {
            let mut settings = SoftGi::default();
            spoil(&mut settings);
            assert_eq!(settings.check(512, 512).unwrap_err().knob, knob);
        }
        assert!(SoftGi { receiver_scale: 1, ..SoftGi::default() }.check(4096, 4096).is_err());
        assert!(SoftGi { tau: 1.0, ..SoftGi::default() }.check(8, 8).is_ok());
    }
}
