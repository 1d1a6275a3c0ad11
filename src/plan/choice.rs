//! Is an effect called for, and which technique suits a scene?

use super::{Decision, Effect, Request, Technique};
use crate::scene::Census;
use crate::technique::LightPart;

/// Why an effect is called for, or why not.
enum Verdict {
    Called(String),
    /// There is nothing that it could add.
    Nothing(&'static str),
    /// It could add something, and is left out.
    LeftOut(String),
}

use Verdict::{Called, LeftOut, Nothing};

/// Decides about an effect; `before` tells which of those before it are called for.
pub(super) fn decide(
    effect: Effect,
    census: &Census,
    request: &Request,
    before: &dyn Fn(Effect) -> bool,
) -> Decision {
    let bound = effect.bound(census);
    let verdict = match has_use(effect, census, request, before) {
        Called(why) => {
            let small = bound.filter(|b| b.share <= request.quality);
            let unasked = request.effects.as_ref().is_some_and(|asked| !asked.contains(&effect));
            if unasked {
                LeftOut("not among the effects asked for".into())
            } else if let Some(b) = small {
                LeftOut(format!("{b}, no more than the quality asked for, {}, allows", request.quality))
            } else {
                Called(why)
            }
        }
        other => other,
    };
    match verdict {
        Called(why) => Decision { effect, called: true, why, bound: None },
        Nothing(why) => Decision { effect, called: false, why: why.into(), bound: None },
        LeftOut(why) => Decision { effect, called: false, why, bound },
    }
}

/// Whether an effect has a use in the scene, the technique can compute it and the part of the light asked for has it.
fn has_use(effect: Effect, census: &Census, request: &Request, before: &dyn Fn(Effect) -> bool) -> Verdict {
    use Effect::*;
    let technique = &request.technique;
    let lights = census.points + census.spots + census.suns;
    let part = request.job.light;
    let emits = request.emissive && census.has_emission;
    let shines = lights > 0 || census.has_environment || emits;
    let unable = || LeftOut(format!("{} does not compute it", technique.name()));
    let glossy = format!("{:.1} % of the surfaces are glossy", 100.0 * census.glossy_share);
    let indirect_only = part == LightPart::Indirect;
    let direct_only = part == LightPart::Direct;
    if technique.is_occlusion() {
        return match effect {
            Occlusion => Called("the picture is of openness, not of light".into()),
            _ => LeftOut("the picture is of openness, not of light".into()),
        };
    }
    match effect {
        Occlusion => Nothing("the picture is of light"),
        Lights if lights == 0 => Nothing("the scene has no point, spot or sun light"),
        // Indirect light needs them too, but not on what is seen.
        Lights if indirect_only => LeftOut("indirect light alone is asked for".into()),
        Lights => Called(format!("{lights} point, spot and sun lights")),
        SoftShadows if !technique.has(effect) => unable(),
        SoftShadows => match technique {
            Technique::LayeredRsm(s) if s.shadow_cones && before(Lights) => {
                Called("shadows by cones are asked for".into())
            }
            Technique::LayeredRsm(s) if s.shadow_cones => Nothing("no light shines straight on what is seen"),
            _ => LeftOut("hard shadows are asked for".into()),
        },
        Environment if !census.has_environment => Nothing("the surroundings are dark"),
        Environment if !technique.has(effect) => LeftOut("proxy-shadows stands for it".into()),
        Environment => Called("the surroundings shine".into()),
        Emission if !census.has_emission => Nothing("no surface emits"),
        Emission if !request.emissive => LeftOut("emissive surfaces may not emit".into()),
        Emission => Called(format!("{:.2} % of the surfaces emit", 100.0 * census.emissive_share)),
        Gloss if !census.has_gloss => Nothing("no surface is glossy"),
        Gloss if !shines => Nothing("nothing shines"),
        Gloss => Called(glossy),
        Bounce | SpecularBounce | FurtherBounces if !shines => Nothing("nothing shines"),
        SpecularBounce if !census.has_gloss => Nothing("no surface is glossy"),
        Bounce | SpecularBounce | FurtherBounces if !technique.has(effect) => unable(),
        Bounce | SpecularBounce | FurtherBounces if direct_only => {
            LeftOut("direct light alone is asked for".into())
        }
        Bounce if census.largest_albedo <= 0.0 => Nothing("every surface is black"),
        Bounce if matches!(technique, Technique::LayeredRsm(_)) && lights == 0 => {
            LeftOut("layered maps pass on point, spot and sun lights alone".into())
        }
        Bounce => Called(format!("surfaces reflect up to {:.2}", census.largest_albedo)),
        SpecularBounce if !before(Gloss) => LeftOut("gloss is left out".into()),
        SpecularBounce => match technique {
            Technique::VisibilityFilter(s) if s.lobe_rays == 0 => LeftOut("lobes have no rays".into()),
            Technique::VisibilityFilter(_) if !before(Bounce) => LeftOut("bounce is left out".into()),
            Technique::VoxelCones(_) if !before(Bounce) => LeftOut("bounce is left out".into()),
            Technique::LayeredRsm(_) if !before(Bounce) && !before(Environment) => {
                LeftOut("bounce is left out, and mirrors have no surroundings to show".into())
            }
            _ => Called(glossy),
        },
        FurtherBounces => match technique {
            Technique::VoxelCones(s) if s.bounces > 1 && before(Bounce) => {
                Called(format!("{} bounces are asked for", s.bounces))
            }
            Technique::VoxelCones(s) if s.bounces > 1 => LeftOut("bounce is left out".into()),
            _ => LeftOut("one bounce is asked for".into()),
        },
        ProxyShadows | ProxyBounce if !technique.has(effect) => Nothing("proxies belong to soft-gi"),
        ProxyShadows | ProxyBounce if !census.has_environment => Nothing("the surroundings are dark"),
        ProxyShadows if indirect_only => LeftOut("indirect light alone is asked for".into()),
        ProxyShadows => Called(format!("the surroundings shine past {} proxies", census.proxies)),
        ProxyBounce if census.proxies == 0 => Nothing("the scene has no spherical proxies"),
        ProxyBounce if direct_only => LeftOut("direct light alone is asked for".into()),
        ProxyBounce => Called(format!("{} proxies under surroundings that shine", census.proxies)),
    }
}

/// Which technique suits a scene, by name, and why. `moving`: its meshes or lights move.
pub fn choose(
    census: &Census,
    light: LightPart,
    emissive: bool,
    moving: bool,
) -> (&'static str, &'static str) {
    let lights = census.points + census.spots + census.suns;
    let emits = emissive && census.has_emission;
    if light == LightPart::Direct {
        ("direct", "nothing else is asked for")
    } else if lights == 0 && !emits && census.has_environment && census.proxies > 0 {
        ("soft-gi", "proxies under surroundings that shine, and no other light")
    } else if lights == 0 && !emits && !census.has_environment {
        ("direct", "nothing shines: there is no light to pass on")
    } else if lights == 0 {
        (
            "voxel-cones",
            "no point, spot or sun light: voxels pass on the light of surroundings and emissive surfaces",
        )
    } else if moving && lights <= 4 {
        ("layered-rsm", "what moves is voxelised anew for each frame, which binary voxels make cheapest")
    } else {
        ("visibility-filter", "lights on surfaces that stay: the least error of direct light and one bounce")
    }
}
