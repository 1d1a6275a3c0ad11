//! Which knobs does the visibility filter have, and what do they do to error and cost?

use crate::error::SettingsError;
use crate::technique::gathered::illumination_size;
use twinlight_kernels::passes::visibility_filter::list::{MAX_COUNT, MAX_VOXEL, list_stride};

/// How the light of visible voxels is added up, VF eq. 5.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Gather {
    /// Every proxy of a listed voxel sends its light, as in the paper: sharp, but too bright behind partly hidden
    /// voxels, too dark where no ray met a visible one.
    Sum,
    /// A voxel sends its mean radiance from the solid angle that its proxies or, where these disagree, the rays tell.
    Share,
}

/// What becomes of 1/d² near a proxy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Clamp {
    /// The form factor of a disc, A/(πd² + A).
    Disc,
    /// Constant within the disc's radius.
    Radius,
    /// Nothing: unbiased, with bright spots next to proxies.
    None,
}

/// What the rays of the coarse pixels meet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Visibility {
    /// Discs, as in the paper.
    Proxies,
    /// The scene's triangles, which the discs approximate: no holes, no rims.
    Triangles,
}

/// What chooses the directions of a pixel's rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// The pixel.
    Pixel,
    /// The place in the world: the pattern of errors sticks to surfaces instead of the screen.
    World,
}

/// The knobs of the visibility filter.
///
/// Errors named here are of indirect light; `docs/visibility-filter.md` has them measured.
#[derive(Clone, Debug, PartialEq)]
pub struct VisibilityFilter {
    /// Proxies on the whole scene. Leaks and the blur of edges fall with its root; tests of discs grow with it.
    pub proxies: u32,
    /// How many discs cover a point of a surface on average. Below 2 rays slip through holes, above 4 edges swell.
    pub overlap: f32,
    /// Voxels along each axis of the scene's box. Larger voxels blur light and let hidden parts shine.
    pub grid: [u32; 3],
    /// Coarse pixels, at which visibility is found; a quarter of the picture's sides if none, at most 2¹⁸. Cost: their number.
    pub marching: Option<(u32, u32)>,
    /// Pixels at which light is gathered; half of the picture's sides if none, at most 2²⁰. Cost: their number.
    pub illumination: Option<(u32, u32)>,
    /// Rays of a coarse pixel over its hemisphere. Noise falls with the root of their number, times the filter's.
    pub rays: u32,
    /// Rays of a coarse pixel in its specular lobe, where there is gloss.
    pub lobe_rays: u32,
    /// Half widths (n, m) of the filter in coarse pixels, at most 4: (3, 3) is 7 × 7. Wider is smoother and blurrier.
    pub filter: (u32, u32),
    /// Pixels share visibility when each is this near to the other's plane, as a share of the distance from the eye.
    pub max_depth_difference: f32,
    /// … and when the cosine between their normals is at least this.
    pub min_normal_cosine: f32,
    /// Voxels that a pixel's list holds; if none, all that can occur, at most 1024.
    pub capacity: Option<u32>,
    /// R: voxels nearer than this many metres count proxy by proxy; if none, one voxel's diagonal.
    pub near_range: Option<f32>,
    /// How light is added up.
    pub gather: Gather,
    /// With [`Gather::Share`]: standard errors by which rays may disagree with proxies before they count more. 0 believes
    /// the rays alone: unbiased but for the voxels' size, and noisy.
    pub trust: f32,
    /// What becomes of 1/d² near a proxy.
    pub clamp: Clamp,
    /// Texels along a side of the maps by which lights see the proxies; 0 sends a ray to each.
    pub light_map: u32,
    /// What the rays meet.
    pub visibility: Visibility,
    /// Whether glossy proxies mirror point, spot and sun lights onto what sees them. Without, that light is missing.
    pub proxy_gloss: bool,
    /// What chooses their directions.
    pub anchor: Anchor,
    /// Standard deviation of the distance from a pixel's plane in w_G, as a share of the distance from the eye.
    pub depth_deviation: f32,
    /// Standard deviation of 1 − N·N′ in w_G.
    pub normal_deviation: f32,
    /// σ_θ of eq. 7 for the specular lobe, 0.001 to 0.3; 0 weighs by the surface's own lobe.
    pub specular_deviation: f32,
    /// n of eq. 7 for all surfaces, 0.1 to 10⁵; if none, for each the one by which eq. 7 is half where the surface's lobe is.
    pub specular_exponent: Option<f32>,
}

impl Default for VisibilityFilter {
    fn default() -> Self {
        Self {
            proxies: 60_000,
            overlap: 4.0,
            grid: [8; 3],
            marching: None,
            illumination: None,
            rays: 64,
            lobe_rays: 16,
            filter: (3, 3),
            max_depth_difference: 0.02,
            min_normal_cosine: 0.9,
            capacity: None,
            near_range: None,
            gather: Gather::Share,
            trust: 2.0,
            clamp: Clamp::Disc,
            light_map: 0,
            visibility: Visibility::Triangles,
            proxy_gloss: true,
            anchor: Anchor::Pixel,
            depth_deviation: 0.01,
            normal_deviation: 0.1,
            specular_deviation: 0.0,
            specular_exponent: None,
        }
    }
}

/// The largest number of proxies.
pub const MAX_PROXIES: u32 = 1 << 22;
/// The largest number of voxels.
pub const MAX_VOXELS: u64 = MAX_VOXEL as u64;
/// The largest number of pixels at which visibility is found or light is gathered.
pub const MAX_PIXELS: u64 = 1 << 20;
/// Rays of a pixel, either kind.
pub const MAX_RAYS: u32 = MAX_COUNT;
/// The largest number of rays of all coarse pixels.
const MAX_ALL_RAYS: u64 = 1 << 28;
/// The largest number of words of all lists: 4 GiB.
const MAX_LIST_WORDS: u64 = 1 << 30;
/// The largest number of coarse pixels when none is asked for: each has a list.
const MAX_DEFAULT_MARCHING: u64 = 1 << 18;
/// The largest list when none is asked for.
const MAX_CAPACITY: u32 = 1024;

impl VisibilityFilter {
    /// The names of [`VisibilityFilter::preset`].
    pub const PRESETS: [&str; 3] = ["paper-cornell", "paper-cornell-128", "paper-sponza"];

    /// The settings of a table of the paper (§4, table 1), for a picture of 512 × 512.
    pub fn preset(name: &str) -> Option<Self> {
        let paper = Self {
            gather: Gather::Sum,
            illumination: Some((256, 256)),
            light_map: 256,
            filter: (3, 3),
            visibility: Visibility::Proxies,
            proxy_gloss: false,
            ..Self::default()
        };
        let cornell = Self { proxies: 24_000, grid: [6; 3], ..paper.clone() };
        match name {
            "paper-cornell" => Some(Self { marching: Some((64, 64)), ..cornell }),
            "paper-cornell-128" => Some(Self { marching: Some((128, 128)), ..cornell }),
            "paper-sponza" => {
                Some(Self { proxies: 170_000, grid: [20; 3], marching: Some((128, 128)), ..paper })
            }
            _ => None,
        }
    }

    /// Coarse pixels for a picture of this size.
    pub fn marching_size(&self, width: u32, height: u32) -> (u32, u32) {
        self.marching.unwrap_or_else(|| shrunk(width, height, 4, MAX_DEFAULT_MARCHING))
    }

    /// Pixels at which light is gathered for a picture of this size.
    pub fn illumination_size(&self, width: u32, height: u32) -> (u32, u32) {
        illumination_size(self.illumination, width, height)
    }

    /// Rays of a coarse pixel, in a scene with gloss or without.
    pub fn all_rays(&self, gloss: bool) -> u32 {
        self.rays + if gloss { self.lobe_rays } else { 0 }
    }

    /// Voxels that a list holds, of the `occupied` ones that there are.
    pub fn list_capacity(&self, gloss: bool, occupied: u32) -> u32 {
        let window = (2 * self.filter.0 + 1) * (2 * self.filter.1 + 1) * self.all_rays(gloss);
        let possible = window.min(occupied).max(1);
        self.capacity.unwrap_or(MAX_CAPACITY).min(possible)
    }

    /// Refuses what cannot be done for a picture of this size.
    ///
    /// # Errors
    /// The first knob that is out of range, with its range.
    pub fn check(&self, width: u32, height: u32) -> Result<(), SettingsError> {
        let refuse = |knob: &'static str, reason: String| Err(SettingsError { knob, reason });
        let within = |knob, value: u32, low: u32, high: u32| {
            if (low..=high).contains(&value) {
                Ok(())
            } else {
                refuse(knob, format!("{value} is not from {low} to {high}"))
            }
        };
        within("proxies", self.proxies, 1, MAX_PROXIES)?;
        within("rays", self.rays, 1, MAX_RAYS)?;
        within("lobe-rays", self.lobe_rays, 0, MAX_RAYS)?;
        within("filter", self.filter.0.max(self.filter.1), 0, 4)?;
        within("light-map", self.light_map, 0, 8192)?;
        within("list-capacity", self.capacity.unwrap_or(1), 1, 1 << 16)?;
        let voxels: u64 = self.grid.iter().map(|&n| u64::from(n.min(1 << 20))).product();
        if voxels == 0 || voxels > MAX_VOXELS {
            return refuse("grid", format!("{voxels} voxels are not from 1 to {MAX_VOXELS}"));
        }
        let marching = self.marching_size(width, height);
        for (knob, (w, h)) in
            [("marching", marching), ("illumination", self.illumination_size(width, height))]
        {
            let pixels = u64::from(w) * u64::from(h);
            if pixels == 0 || pixels > MAX_PIXELS {
                return refuse(knob, format!("{w}x{h} is not from 1 to {MAX_PIXELS} pixels"));
            }
        }
        let rays = u64::from(marching.0) * u64::from(marching.1) * u64::from(self.all_rays(true));
        if rays > MAX_ALL_RAYS {
            return refuse(
                "rays",
                format!("{rays} in all are more than {MAX_ALL_RAYS}; lower marching or rays"),
            );
        }
        let capacity = self.list_capacity(true, voxels as u32);
        let words = u64::from(marching.0) * u64::from(marching.1) * u64::from(list_stride(capacity));
        if words > MAX_LIST_WORDS {
            let reason = format!(
                "lists of {capacity} voxels for {}x{} pixels need {} MiB, over {}; lower marching, grid or list-capacity",
                marching.0,
                marching.1,
                words >> 18,
                MAX_LIST_WORDS >> 18
            );
            return refuse("list-capacity", reason);
        }
        let finite = |knob, value: f32, low: f32, high: f32| {
            if value >= low && value <= high {
                Ok(())
            } else {
                refuse(knob, format!("{value} is not from {low} to {high}"))
            }
        };
        finite("overlap", self.overlap, 0.1, 100.0)?;
        finite("filter-depth", self.max_depth_difference, 0.0, 1.0e6)?;
        finite("filter-normal", self.min_normal_cosine, -1.0, 1.0)?;
        finite("near-range", self.near_range.unwrap_or(0.0), 0.0, 1.0e18)?;
        finite("trust", self.trust, 0.0, 1.0e6)?;
        finite("depth-deviation", self.depth_deviation, 1.0e-6, 1.0e6)?;
        finite("normal-deviation", self.normal_deviation, 1.0e-6, 1.0e6)?;
        // Narrower, eq. 7 saturates; wider, it does not vanish at the lobe's edge.
        if self.specular_deviation != 0.0 {
            finite("specular-deviation", self.specular_deviation, 1.0e-3, 0.3)?;
        }
        if let Some(exponent) = self.specular_exponent {
            finite("specular-exponent", exponent, 0.1, 1.0e5)?;
            if self.specular_deviation == 0.0 {
                return refuse("specular-exponent", "it is that of --specular-deviation: give both".into());
            }
        }
        Ok(())
    }
}

/// A picture's sides over `divisor`, and further until it has at most `most` pixels.
fn shrunk(width: u32, height: u32, divisor: u32, most: u64) -> (u32, u32) {
    let (mut w, mut h) = (width.div_ceil(divisor), height.div_ceil(divisor));
    while u64::from(w) * u64::from(h) > most {
        (w, h) = (w.div_ceil(2), h.div_ceil(2));
    }
    (w, h)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_settings_are_accepted_and_others_refused() {
        for name in VisibilityFilter::PRESETS {
            let settings = VisibilityFilter::preset(name).unwrap();
            assert!(settings.visibility == Visibility::Proxies && !settings.proxy_gloss);
            settings.check(512, 512).unwrap();
            assert_eq!((settings.filter, settings.light_map), ((3, 3), 256));
        }
        assert!(VisibilityFilter::preset("paper-teapot").is_none());
        type Spoil = fn(&mut VisibilityFilter);
        let spoilt: [(&str, Spoil); 15] = [
            ("proxies", |s| s.proxies = 0),
            ("proxies", |s| s.proxies = MAX_PROXIES + 1),
            ("rays", |s| s.rays = 0),
            ("rays", |s| (s.rays, s.marching) = (4095, Some((1024, 1024)))),
            ("grid", |s| s.grid = [0, 1, 1]),
            ("grid", |s| s.grid = [u32::MAX; 3]),
            ("filter", |s| s.filter = (5, 0)),
            ("list-capacity", |s| {
                (s.grid, s.capacity, s.marching) = ([80; 3], Some(1 << 16), Some((1000, 1000)))
            }),
            ("marching", |s| s.marching = Some((2048, 1024))),
            ("illumination", |s| s.illumination = Some((0, 1))),
            ("overlap", |s| s.overlap = f32::NAN),
            ("near-range", |s| s.near_range = Some(f32::INFINITY)),
            ("specular-deviation", |s| s.specular_deviation = 0.9),
            ("specular-exponent", |s| s.specular_exponent = Some(8.0)),
            ("specular-exponent", |s| (s.specular_deviation, s.specular_exponent) = (0.1, Some(f32::NAN))),
        ];
        for (knob, spoil) in spoilt {
            let mut settings = VisibilityFilter::default();
            spoil(&mut settings);
            let error = settings.check(512, 512).unwrap_err();
            assert_eq!(error.knob, knob, "{error}");
        }
    }

    #[test]
    fn default_sizes_follow_the_picture() {
        let settings = VisibilityFilter::default();
        assert_eq!(
            (settings.marching_size(512, 512), settings.illumination_size(512, 512)),
            ((128, 128), (256, 256))
        );
        assert_eq!((settings.marching_size(1, 3), settings.illumination_size(1, 3)), ((1, 1), (1, 2)));
        settings.check(32_768, 4096).unwrap();
        assert_eq!(settings.marching_size(32_768, 4096), (1024, 128));
        assert_eq!(settings.list_capacity(false, 5000), 1024);
        assert_eq!(settings.list_capacity(true, 216), 216);
    }
}
