//! Which surfaces does a light see, by a map of what its own rays meet?
//!
//! One map per light: a square of rays, perspective for a narrow spot, parallel for a sun, and the octahedron of all
//! directions for everything else. Maps serve many receivers at the price of one ray per texel.

use super::material::AlphaTest;
use super::scene::{Material, Triangle};
use super::surface::Surface;
use crate::geometry::bvh::{BvhNode, Hit, NO_TRIANGLE, Ray, TriangleBlock, nearest_hit};
use crate::math::{abs, div, dot, floor, length, max, normalize_or, recip, sqrt, to_u32};
use glam::{Vec2, Vec3, Vec4};

/// [`LightMapParams::projection`]: rays from the light through a square, for a spot.
pub const PROJECT_PERSPECTIVE: u32 = 0;
/// [`LightMapParams::projection`]: parallel rays, for a sun.
pub const PROJECT_PARALLEL: u32 = 1;
/// [`LightMapParams::projection`]: the octahedron of all directions, for a point.
pub const PROJECT_OCTAHEDRON: u32 = 2;

/// Cosines at a receiver below this allow for no more depth within a texel.
const LEAST_COSINE: f32 = 0.1;

gpu_struct! {
    /// A light's map.
    pub struct LightMapParams {
        /// Position of the light, or the middle of the square that a sun shines through; w is 0.
        pub origin: Vec4,
        /// Across the map: unit times tan of the half angle (perspective), half the side in metres (parallel); w is 0.
        pub right: Vec4,
        /// Down the map, scaled as `right`; w is 0.
        pub down: Vec4,
        /// Unit direction into the map; w is 0.
        pub forward: Vec4,
        /// [`PROJECT_PERSPECTIVE`], [`PROJECT_PARALLEL`] or [`PROJECT_OCTAHEDRON`].
        pub projection: u32,
        /// Texels along a side.
        pub size: u32,
        /// Which bit of the visibility is this light's.
        pub light: u32,
        /// Width of a texel: as an angle in radians, or in metres (parallel).
        pub texel: f32,
        /// Depth differences in metres that are no shadow.
        pub bias: f32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }
}

/// Returns the unit direction of a point of the octahedral map, (x, y) in [−1, 1]².
#[inline]
pub fn octahedron_direction(x: f32, y: f32) -> Vec3 {
    let z = (1.0 - abs(x)) - abs(y);
    let (fold_x, fold_y) = (1.0 - abs(y), 1.0 - abs(x));
    let p = if z >= 0.0 {
        Vec3::new(x, y, z)
    } else {
        Vec3::new(if x >= 0.0 { fold_x } else { -fold_x }, if y >= 0.0 { fold_y } else { -fold_y }, z)
    };
    normalize_or(p, Vec3::Z)
}

/// Returns the point of the octahedral map of a direction of any length, in [−1, 1]²; (0, 0) for 0.
#[inline]
pub fn octahedron_point(direction: Vec3) -> Vec2 {
    let d = direction;
    let sum = (abs(d.x) + abs(d.y)) + abs(d.z);
    if !(sum > 0.0) {
        return Vec2::ZERO;
    }
    let (x, y) = (div(d.x, sum), div(d.y, sum));
    if d.z >= 0.0 {
        return Vec2::new(x, y);
    }
    let (fold_x, fold_y) = (1.0 - abs(y), 1.0 - abs(x));
    Vec2::new(if x >= 0.0 { fold_x } else { -fold_x }, if y >= 0.0 { fold_y } else { -fold_y })
}

/// Returns what the light's ray through texel `index` meets first; rows follow each other.
#[inline]
pub fn trace_light_map(
    index: u32,
    params: &LightMapParams,
    nodes: &[BvhNode],
    blocks: &[TriangleBlock],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> Hit {
    let scale = div(2.0, params.size as f32);
    let x = ((index % params.size) as f32 + 0.5) * scale - 1.0;
    let y = ((index / params.size) as f32 + 0.5) * scale - 1.0;
    let (right, down) = (params.right.truncate() * x, params.down.truncate() * y);
    let forward = params.forward.truncate();
    let mut ray = Ray { origin: params.origin.truncate(), direction: forward, t_min: 0.0, t_max: 1.0e30 };
    if params.projection == PROJECT_PARALLEL {
        ray.origin = (ray.origin + right) + down;
    } else if params.projection == PROJECT_PERSPECTIVE {
        ray.direction = normalize_or((forward + right) + down, forward);
    } else {
        ray.direction = octahedron_direction(x, y);
    }
    nearest_hit(nodes, blocks, &ray, &AlphaTest { triangles, materials, texels })
}

/// Returns the solid angle of a texel of a map in steradians, or its area in m² for a sun's; `spread` is the length of
/// [`LightMapParams::right`].
#[inline]
pub fn texel_measure(projection: u32, size: u32, spread: f32, texel: u32) -> f32 {
    let width = div(2.0, size as f32);
    let x = ((texel % size) as f32 + 0.5) * width - 1.0;
    let y = ((texel / size) as f32 + 0.5) * width - 1.0;
    let side = width * spread;
    if projection == PROJECT_PARALLEL {
        return side * side;
    }
    let squared = squared_distance(projection, spread * spread, x, y);
    let area = if projection == PROJECT_PERSPECTIVE { side * side } else { width * width };
    div(area, squared * sqrt(squared))
}

/// The squared distance from a light to a point of its map's plane, or of its octahedron, whose faces are at 1/√3. A texel's solid
/// angle falls with the cube of the distance.
#[inline]
pub(super) fn squared_distance(projection: u32, squared_spread: f32, x: f32, y: f32) -> f32 {
    if projection == PROJECT_PERSPECTIVE {
        return 1.0 + squared_spread * (x * x + y * y);
    }
    let z = (1.0 - abs(x)) - abs(y);
    let (fold_x, fold_y) = (1.0 - abs(y), 1.0 - abs(x));
    if z >= 0.0 { (x * x + y * y) + z * z } else { (fold_x * fold_x + fold_y * fold_y) + z * z }
}

/// Where a point is on a map.
pub(super) struct Place {
    /// In [−1, 1]² on the map; beyond it the light's map does not show the point.
    pub(super) point: Vec2,
    /// Distance along the map's ray, metres.
    pub(super) depth: f32,
    /// Unit direction of that ray.
    pub(super) direction: Vec3,
    /// Width of a texel there, metres.
    pub(super) texel: f32,
}

#[inline]
pub(super) fn place(params: &LightMapParams, position: Vec3) -> Place {
    let between = position - params.origin.truncate();
    let (right, down, forward) = (params.right.truncate(), params.down.truncate(), params.forward.truncate());
    let along = dot(between, forward);
    let across =
        Vec2::new(div(dot(between, right), dot(right, right)), div(dot(between, down), dot(down, down)));
    if params.projection == PROJECT_PARALLEL {
        return Place { point: across, depth: along, direction: forward, texel: params.texel };
    }
    let depth = length(between);
    let direction = normalize_or(between, forward);
    let point = if params.projection == PROJECT_OCTAHEDRON {
        octahedron_point(between)
    } else if along > 0.0 {
        let inverse = recip(along);
        Vec2::new(across.x * inverse, across.y * inverse)
    } else {
        Vec2::new(2.0, 2.0)
    };
    Place { point, depth, direction, texel: params.texel * depth }
}

/// Returns `previous` with the light's bit set where its map shows surface `index`, or nothing before it.
///
/// A surface is shown when the texel met its own triangle, or nothing nearer than its depth less the bias and what one
/// texel spans on a surface this steep.
#[inline]
pub fn light_map_visibility(
    index: u32,
    params: &LightMapParams,
    surfaces: &[Surface],
    hits: &[Hit],
    previous: &[u32],
) -> u32 {
    let s = &surfaces[index as usize];
    let before = previous[index as usize];
    if s.triangle == NO_TRIANGLE {
        return before;
    }
    let place = place(params, s.position.truncate());
    let facing = -dot(s.normal.truncate(), place.direction);
    let outside = !(abs(place.point.x) <= 1.0 && abs(place.point.y) <= 1.0);
    if outside || !(facing > 0.0) {
        return before;
    }
    let half = 0.5 * (params.size as f32);
    let texel = |x: f32| {
        let cell = to_u32(floor((x + 1.0) * half));
        if cell < params.size { cell } else { params.size - 1 }
    };
    let hit = &hits[(texel(place.point.y) * params.size + texel(place.point.x)) as usize];
    let slack = params.bias + div(place.texel, max(facing, LEAST_COSINE));
    let shown = hit.triangle == NO_TRIANGLE || hit.triangle == s.triangle || place.depth <= hit.t + slack;
    if shown { before | (1 << params.light) } else { before }
}
