//! What do the surfaces around a point send, by what each light sees of them? LRSM §4.1, algorithm 1.

use super::layers::{farthest_squared, layer_range, texels_before};
use super::texel::{LayerTexel, TexelSum, texel_words, unpack_texel};
use crate::cone::mip_level;
use crate::gaussian::{depth_coverage, layer_coordinate, layer_decay};
use crate::math::{abs, clamp, div, dot, exp2, floor, max, sqrt, to_u32};
use crate::passes::light_map::{
    LightMapParams, PROJECT_OCTAHEDRON, PROJECT_PARALLEL, place, squared_distance,
};
use glam::{Vec2, Vec3, Vec4};

/// [`LayeredMap::flags`]: algorithm 1 as published. Surfaces count by their share of the light's rays, what of these is not in
/// the sample counts as dark, and a cosine stands for what is turned away.
pub const WEIGH_OPACITY: u32 = 1;
/// Fewer rays than this share of a sample's, that meet something in it, are taken for a part of something dark.
const LEAST_SHARE: f32 = 0.05;
/// Surfaces that are lit at a cosine below this have no deeper window.
const LEAST_COSINE: f32 = 0.1;
/// Surfaces that are lit at a cosine below this have their flux told for this one.
pub(super) const LEAST_LIT_COSINE: f32 = 0.02;
/// How far that is, as a share of the square of its width.
const SOFTENING: f32 = 0.4;
/// Beyond any depth, in half layers.
const BEFORE: f32 = 1.0e3;
/// Its inverse.
const STEEPEST: f32 = 10.0;

gpu_struct! {
    /// The layers of a light's map, and how they are looked up.
    pub struct LayeredMap {
        /// Origin of the light's rays, as in [`LightMapParams`].
        pub origin: Vec4,
        /// Across the map.
        pub right: Vec4,
        /// Down the map.
        pub down: Vec4,
        /// Into the map.
        pub forward: Vec4,
        /// How the map is laid over the directions.
        pub projection: u32,
        /// Texels along a side of the finest level: half of the light's map.
        pub size: u32,
        /// The level that is made or, for lookups, the number of levels.
        pub level: u32,
        /// First word of the layers.
        pub first: u32,
        /// Number of depth layers.
        pub depth_layers: u32,
        /// Number of normal layers.
        pub normal_layers: u32,
        /// How depths are stored.
        pub format: u32,
        /// [`WEIGH_OPACITY`].
        pub flags: u32,
        /// Width of a texel of the finest level: as an angle in radians, or in metres (parallel).
        pub texel: f32,
        /// Near end of the first layer, metres from the light.
        pub near: f32,
        /// Depth of a layer without overlap, metres.
        pub thickness: f32,
        /// Overlap of neighbouring layers, metres; 0 reads all layers that a sample reaches, without decay.
        pub overlap: f32,
        /// Radius within which surfaces belong to a sample, in half widths of its voxels.
        pub window: f32,
        /// Diameter looked up on the map, as a share of the width of the sample's voxels.
        pub footprint: f32,
        /// The finest level looked up.
        pub least_level: f32,
        /// The smallest deviation of depths, as a share of half a layer.
        pub deviation: f32,
    }
}

/// The maps of several lights, and how a point's place is told to them.
#[derive(Clone, Copy)]
pub struct Maps<'a> {
    /// Number of maps.
    pub count: u32,
    /// Lattice point (0, 0, 0) in metres; w is the voxel edge, metres.
    pub lower: Vec4,
    /// One for each light.
    pub maps: &'a [LayeredMap],
    /// Their layers.
    pub layers: &'a [u32],
}

impl Maps<'_> {
    /// What surfaces at a point of the lattice send against `direction`; voxels of `width` edges were met there.
    #[inline]
    pub fn radiance(&self, point: Vec3, direction: Vec3, width: f32) -> Vec3 {
        let position = self.lower.truncate() + point * self.lower.w;
        let mut sum = Vec3::ZERO;
        for number in 0..self.count {
            sum += reflected_at(
                &self.maps[number as usize],
                self.layers,
                position,
                direction,
                width * self.lower.w,
            );
        }
        sum
    }
}

/// The light's map as the pass that laid it out knows it.
#[inline]
fn projection(map: &LayeredMap) -> LightMapParams {
    LightMapParams {
        origin: map.origin,
        right: map.right,
        down: map.down,
        forward: map.forward,
        projection: map.projection,
        size: map.size,
        light: 0,
        texel: map.texel,
        bias: 0.0,
        pad0: 0,
        pad1: 0,
        pad2: 0,
    }
}

/// The width of a map's texel over that of one in its middle, or over the mean of an octahedron's.
#[inline]
fn narrowing(map: &LayeredMap, point: Vec2) -> f32 {
    if map.projection == PROJECT_PARALLEL {
        return 1.0;
    }
    let spread = map.right.truncate();
    let squared = squared_distance(map.projection, dot(spread, spread), point.x, point.y);
    // √(4π)/2 widths of its plane are the mean of an octahedron's.
    let mean = if map.projection == PROJECT_OCTAHEDRON { 0.564_189_6 } else { 1.0 };
    div(mean, sqrt(squared * sqrt(squared)))
}

/// Returns the radiance, in stored units, that surfaces lit by the map's light send against `direction` from voxels of `width`
/// metres at `position`. LRSM eq. 14.
#[inline]
pub fn reflected_at(map: &LayeredMap, layers: &[u32], position: Vec3, direction: Vec3, width: f32) -> Vec3 {
    let at = place(&projection(map), position);
    if !(abs(at.point.x) <= 1.0 && abs(at.point.y) <= 1.0) {
        return Vec3::ZERO;
    }
    let levels = map.level as f32 - 1.0;
    let texel = max(at.texel * narrowing(map, at.point), 1.0e-18);
    let level = clamp(mip_level(div(width * map.footprint, texel), levels), map.least_level, levels);
    // A sample is no finer than the texels that are looked up: what these have beside it is their own surface, no shadow.
    let published = map.flags & WEIGH_OPACITY != 0;
    let width = if published { width } else { max(width, div(texel * exp2(level), map.footprint)) };
    let radius = 0.5 * width * map.window;
    let parallel = map.projection == PROJECT_PARALLEL;
    // A wide sample sees the mean of what falls off around the light: as if this were behind its surfaces by some of its
    // width. The whole that reaches a plane stays the same.
    let soft = if parallel { 0.0 } else { SOFTENING * width * width };
    let squared = if parallel { 1.0 } else { max(at.depth * at.depth + soft, 1.0e-18) };
    let (mut light, mut lit, mut dark) = (Vec3::ZERO, 0.0, 0.0);
    for layer in 0..map.depth_layers * map.normal_layers {
        let (counts, shadows) = layer_weights(map, layer / map.normal_layers, at.depth, radius);
        if max(counts, shadows) > 0.0 {
            let (near, far) = layer_range(map, layer / map.normal_layers);
            let centre = layer_coordinate(at.depth, near, far);
            let t = sample(map, layers, layer, level, at.point, centre);
            if t.opacity > 0.0 {
                let part = inside(map, &t, centre, radius, near, far, at.direction);
                let cosine = -dot(t.normal, direction);
                let slant = max(-dot(t.normal, at.direction), 0.0);
                let height = slant * at.depth;
                let slant = if parallel { slant } else { sqrt(div(height * height + soft, squared)) };
                light += t.reflected * (counts * part.within * max(cosine, 0.0));
                lit += div(counts * t.opacity * part.within * abs(cosine), max(slant, LEAST_LIT_COSINE));
                dark += shadows * t.opacity * part.before;
            }
        }
    }
    if published {
        return light;
    }
    // Areas for each ray. What stands before the sample shadows as much of it as lies across its rays, turned anyhow.
    light * div(farthest_squared(map), max(lit + 0.5 * dark, LEAST_SHARE) * squared)
}

/// How much a depth layer's surfaces count for a sample: by LRSM eq. 15, or whether it has surfaces within the sample. Then how
/// much those before it count: as published they do not.
#[inline]
fn layer_weights(map: &LayeredMap, d: u32, depth: f32, radius: f32) -> (f32, f32) {
    let (near, far) = layer_range(map, d);
    let (first, last) = (d == 0, d + 1 == map.depth_layers);
    // A steep surface's window is deeper.
    let reach = radius * STEEPEST;
    let published = map.flags & WEIGH_OPACITY != 0;
    let begun = first || depth + reach >= near;
    let shadows = if published || !begun { 0.0 } else { 1.0 };
    if map.overlap > 0.0 {
        return (layer_decay(depth, near, far, map.overlap, first, last), shadows);
    }
    let behind = !last && depth - reach >= far;
    (if !begun || behind { 0.0 } else { 1.0 }, shadows)
}

/// The shares of a layer's surfaces that lie within a sample, and before it as the light sees them.
struct Parts {
    within: f32,
    before: f32,
}

/// LRSM eq. 12.
#[inline]
fn inside(
    map: &LayeredMap,
    t: &LayerTexel,
    centre: f32,
    radius: f32,
    near: f32,
    far: f32,
    along: Vec3,
) -> Parts {
    let half = max(0.5 * (far - near), 1.0e-18);
    // Across a footprint a slanted surface goes deeper than the sample is wide: all of it belongs to the sample.
    let published = map.flags & WEIGH_OPACITY != 0;
    let steep = if published { 1.0 } else { clamp(-dot(t.normal, along), LEAST_COSINE, 1.0) };
    let window = div(radius, half * steep);
    let deviation = sqrt(max(t.variance, map.deviation * map.deviation));
    let within = depth_coverage(t.mean, deviation, centre, window);
    let before = depth_coverage(t.mean, deviation, centre - window - BEFORE, BEFORE);
    Parts { within, before }
}

/// Interpolates a layer at a point of its map, between two levels.
#[inline]
fn sample(map: &LayeredMap, layers: &[u32], layer: u32, level: f32, point: Vec2, pivot: f32) -> LayerTexel {
    let lower = floor(level);
    let fraction = level - lower;
    let low = to_u32(lower);
    let mut sum = TexelSum::new(clamp(pivot, -2.0, 2.0));
    add_level(map, layers, layer, low, point, 1.0 - fraction, &mut sum);
    if fraction > 0.0 && low + 1 < map.level {
        add_level(map, layers, layer, low + 1, point, fraction, &mut sum);
    }
    sum.whole()
}

/// Adds the four texels of a level around a point.
#[inline]
fn add_level(
    map: &LayeredMap,
    layers: &[u32],
    layer: u32,
    level: u32,
    point: Vec2,
    weight: f32,
    sum: &mut TexelSum,
) {
    let side = map.size >> level;
    let words = texel_words(map.format);
    let of_layer =
        texels_before(map.size, level) * (map.depth_layers * map.normal_layers) + layer * side * side;
    let (u, v) = ((point.x + 1.0) * (0.5 * side as f32) + 0.5, (point.y + 1.0) * (0.5 * side as f32) + 0.5);
    let (left, top) = (floor(u), floor(v));
    let (fx, fy) = (u - left, v - top);
    // Counted from one before the first, so that nothing is below 0.
    let (x, y) = (to_u32(left), to_u32(top));
    // Unrolled: rounds of loops are limited on some devices.
    let w = [(1.0 - fx) * (1.0 - fy), fx * (1.0 - fy), (1.0 - fx) * fy, fx * fy];
    let at = [
        texel_at(map, side, x, y),
        texel_at(map, side, x + 1, y),
        texel_at(map, side, x, y + 1),
        texel_at(map, side, x + 1, y + 1),
    ];
    let first = map.first;
    sum.add(&unpack_texel(map.format, layers, first + words * (of_layer + at[0])), w[0] * weight);
    sum.add(&unpack_texel(map.format, layers, first + words * (of_layer + at[1])), w[1] * weight);
    sum.add(&unpack_texel(map.format, layers, first + words * (of_layer + at[2])), w[2] * weight);
    sum.add(&unpack_texel(map.format, layers, first + words * (of_layer + at[3])), w[3] * weight);
}

/// The number of a texel whose column and row are counted from one before the first. Over an edge of the octahedron lies the other
/// half of the same edge; over those of other maps lies nothing else.
#[inline]
fn texel_at(map: &LayeredMap, side: u32, x: u32, y: u32) -> u32 {
    let (mut x, mut y) = (x, y);
    let fold = map.projection == PROJECT_OCTAHEDRON;
    if x == 0 || x > side {
        x = if x == 0 { 1 } else { side };
        y = if fold { side + 1 - y } else { y };
    }
    if y == 0 || y > side {
        y = if y == 0 { 1 } else { side };
        x = if fold { side + 1 - x } else { x };
    }
    (y - 1) * side + (x - 1)
}
