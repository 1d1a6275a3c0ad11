//! Which options set the knobs of the visibility filter?

use super::set;
use crate::cli::options::parse_size;
use crate::technique::visibility_filter::{Anchor, Clamp, Gather, Visibility, VisibilityFilter};
use clap::{Args, ValueEnum};

/// The knobs; what is left out keeps the default or the preset's value.
#[derive(Args, Clone, Default, PartialEq)]
#[command(next_help_heading = "Visibility filter")]
pub(crate) struct VisibilityFilterOptions {
    /// Point proxies on the whole scene
    #[arg(long, value_name = "N")]
    proxies: Option<u32>,
    /// How many discs cover a surface on average
    #[arg(long, value_name = "K", allow_hyphen_values = true)]
    overlap: Option<f32>,
    /// Voxels along each axis
    #[arg(long, value_name = "N|XxYxZ", value_parser = parse_grid)]
    grid: Option<[u32; 3]>,
    /// Coarse pixels at which visibility is found [default: a quarter of the picture's sides]
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    marching: Option<(u32, u32)>,
    /// Rays of a coarse pixel over its hemisphere
    #[arg(long, value_name = "N")]
    rays: Option<u32>,
    /// Rays of a coarse pixel in its specular lobe, where the scene has gloss
    #[arg(long, value_name = "N")]
    lobe_rays: Option<u32>,
    /// Width of the filter in coarse pixels: 7 or 7x5, odd, at most 9
    #[arg(long, value_name = "N|NxM", value_parser = parse_filter)]
    filter: Option<(u32, u32)>,
    /// Farthest from each other's plane that pixels share visibility, as a share of the distance from the eye
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    filter_depth: Option<f32>,
    /// Smallest cosine between the normals of pixels that share visibility
    #[arg(long, value_name = "COS", allow_hyphen_values = true)]
    filter_normal: Option<f32>,
    /// Voxels that a pixel's list holds [default: all that can occur, at most 1024]
    #[arg(long, value_name = "N")]
    list_capacity: Option<u32>,
    /// R: voxels nearer than this count proxy by proxy [default: a voxel's diagonal]
    #[arg(long, value_name = "METRES", allow_hyphen_values = true)]
    near_range: Option<f32>,
    /// How visible light adds up
    #[arg(long)]
    gather: Option<GatherChoice>,
    /// With --gather share: standard errors by which rays may disagree with proxies; 0 believes the rays alone
    #[arg(long, value_name = "Z", allow_hyphen_values = true)]
    trust: Option<f32>,
    /// What becomes of 1/d² near a proxy
    #[arg(long)]
    clamp: Option<ClampChoice>,
    /// Side of the maps by which lights see the proxies, texels; 0 sends a ray to each proxy
    #[arg(long, value_name = "N")]
    light_map: Option<u32>,
    /// What the coarse pixels' rays meet
    #[arg(long)]
    meet: Option<MeetChoice>,
    /// Whether glossy proxies mirror lights onto what sees them
    #[arg(long, value_name = "BOOL")]
    proxy_gloss: Option<bool>,
    /// What chooses the rays' directions
    #[arg(long)]
    anchor: Option<AnchorChoice>,
    /// Standard deviation of the plane distance between pixels in the geometric weight, share of the distance
    #[arg(long, value_name = "SHARE", allow_hyphen_values = true)]
    depth_deviation: Option<f32>,
    /// Standard deviation of 1 - N.N' in the geometric weight
    #[arg(long, value_name = "SIGMA", allow_hyphen_values = true)]
    normal_deviation: Option<f32>,
    /// Width of the Gaussian in the specular weight, 0.001 to 0.3; 0 weighs by the surface's own lobe
    #[arg(long, value_name = "SIGMA", allow_hyphen_values = true)]
    specular_deviation: Option<f32>,
    /// Exponent of the cosine in the specular weight, for --specular-deviation [default: as each surface's lobe]
    #[arg(long, value_name = "N", allow_hyphen_values = true)]
    specular_exponent: Option<f32>,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum GatherChoice {
    /// All light of each visible voxel, as published: biased where voxels are partly hidden
    Sum,
    /// Mean radiance times the visible solid angle, as proxies and rays tell
    Share,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum ClampChoice {
    /// The form factor of a disc
    Disc,
    /// Constant within the disc's radius
    Radius,
    /// Nothing: unbiased, with bright spots
    None,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum MeetChoice {
    /// Discs
    Proxies,
    /// The scene's triangles
    Triangles,
}

#[derive(Clone, Copy, ValueEnum, PartialEq)]
enum AnchorChoice {
    /// The pixel
    Pixel,
    /// The place in the world
    World,
}

fn parse_grid(text: &str) -> Result<[u32; 3], String> {
    let numbers: Option<Vec<u32>> = text.split(['x', 'X']).map(|n| n.parse().ok()).collect();
    match numbers.as_deref() {
        Some(&[n]) => Ok([n; 3]),
        Some(&[x, y, z]) => Ok([x, y, z]),
        _ => Err("expected N or XxYxZ voxels, such as 16 or 20x10x12".into()),
    }
}

fn parse_filter(text: &str) -> Result<(u32, u32), String> {
    let numbers: Option<Vec<u32>> = text.split(['x', 'X']).map(|n| n.parse().ok()).collect();
    let (width, height) = match numbers.as_deref() {
        Some(&[n]) => (n, n),
        Some(&[n, m]) => (n, m),
        _ => (0, 0),
    };
    if width % 2 == 1 && height % 2 == 1 && width <= 9 && height <= 9 {
        Ok((width / 2, height / 2))
    } else {
        Err("expected an odd number of pixels up to 9, or two: 7 or 7x5".into())
    }
}

impl VisibilityFilterOptions {
    /// Sets the knobs that the options name.
    pub(super) fn apply(&self, s: &mut VisibilityFilter) {
        set(&mut s.proxies, self.proxies);
        set(&mut s.overlap, self.overlap);
        set(&mut s.grid, self.grid);
        s.marching = self.marching.or(s.marching);
        set(&mut s.rays, self.rays);
        set(&mut s.lobe_rays, self.lobe_rays);
        set(&mut s.filter, self.filter);
        set(&mut s.max_depth_difference, self.filter_depth);
        set(&mut s.min_normal_cosine, self.filter_normal);
        s.capacity = self.list_capacity.or(s.capacity);
        s.near_range = self.near_range.or(s.near_range);
        set(&mut s.trust, self.trust);
        set(&mut s.light_map, self.light_map);
        set(&mut s.proxy_gloss, self.proxy_gloss);
        set(&mut s.depth_deviation, self.depth_deviation);
        set(&mut s.normal_deviation, self.normal_deviation);
        set(&mut s.specular_deviation, self.specular_deviation);
        s.specular_exponent = self.specular_exponent.or(s.specular_exponent);
        match self.gather {
            Some(GatherChoice::Sum) => s.gather = Gather::Sum,
            Some(GatherChoice::Share) => s.gather = Gather::Share,
            None => {}
        }
        match self.clamp {
            Some(ClampChoice::Disc) => s.clamp = Clamp::Disc,
            Some(ClampChoice::Radius) => s.clamp = Clamp::Radius,
            Some(ClampChoice::None) => s.clamp = Clamp::None,
            None => {}
        }
        match self.meet {
            Some(MeetChoice::Proxies) => s.visibility = Visibility::Proxies,
            Some(MeetChoice::Triangles) => s.visibility = Visibility::Triangles,
            None => {}
        }
        match self.anchor {
            Some(AnchorChoice::Pixel) => s.anchor = Anchor::Pixel,
            Some(AnchorChoice::World) => s.anchor = Anchor::World,
            None => {}
        }
    }
}
