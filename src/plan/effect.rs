//! Which effects are there, and how much light can each add at most?

use crate::scene::Census;

/// A part of a picture's light that may be left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Effect {
    /// Straight from point, spot and sun lights.
    Lights,
    /// Soft instead of hard shadows of these.
    SoftShadows,
    /// From the surroundings, which are seen too.
    Environment,
    /// From emissive surfaces, which are seen to shine.
    Emission,
    /// What lobes reflect of lights.
    Gloss,
    /// One diffuse reflection more.
    Bounce,
    /// What lobes mirror of other surfaces.
    SpecularBounce,
    /// All further reflections.
    FurtherBounces,
    /// The surroundings' light, shadowed by proxies.
    ProxyShadows,
    /// What proxies reflect of it.
    ProxyBounce,
    /// Openness instead of light.
    Occlusion,
}

impl Effect {
    /// Every effect.
    pub const ALL: [Self; 11] = [
        Self::Lights,
        Self::SoftShadows,
        Self::Environment,
        Self::Emission,
        Self::Gloss,
        Self::Bounce,
        Self::SpecularBounce,
        Self::FurtherBounces,
        Self::ProxyShadows,
        Self::ProxyBounce,
        Self::Occlusion,
    ];

    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Lights => "lights",
            Self::SoftShadows => "soft-shadows",
            Self::Environment => "environment",
            Self::Emission => "emission",
            Self::Gloss => "gloss",
            Self::Bounce => "bounce",
            Self::SpecularBounce => "specular-bounce",
            Self::FurtherBounces => "further-bounces",
            Self::ProxyShadows => "proxy-shadows",
            Self::ProxyBounce => "proxy-bounce",
            Self::Occlusion => "occlusion",
        }
    }

    /// The effect of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|e| e.name() == name)
    }

    /// What the effect can add at most, where the scene's materials bound it.
    ///
    /// Surfaces reflect at most ρ, the largest albedo, of what arrives: of the light that they reflect first, a bounce adds at most ρ
    /// as much, all further ones together ρ²/(1 − ρ), what mirrors show of others ρₛ, the largest lobe's share.
    pub fn bound(self, census: &Census) -> Option<Bound> {
        let (all, lobe) = (census.largest_albedo, census.largest_specular);
        let of = |share: f64, of: &'static str| share.is_finite().then_some(Bound { share, of });
        const REFLECTED: &str = "of the light that surfaces reflect first";
        match self {
            Self::Gloss => of(lobe, "of the light that arrives"),
            Self::Bounce => of(all, REFLECTED),
            Self::SpecularBounce => of(lobe, REFLECTED),
            Self::FurtherBounces if all < 1.0 => of(all * all / (1.0 - all), REFLECTED),
            _ => None,
        }
    }
}

/// The most that an effect can add.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bound {
    /// How much.
    pub share: f64,
    /// Of what.
    pub of: &'static str,
}

impl std::fmt::Display for Bound {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "at most {:.3} {}", self.share, self.of)
    }
}
