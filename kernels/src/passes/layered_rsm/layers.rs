//! Which surfaces of a light's map are filtered together? LRSM §4.2, §4.3.
//!
//! A surface belongs to a layer by its depth and by ⟨n·l⟩. A layer's finest level merges two by two texels of the map.

use super::lookup::LayeredMap;
use super::reflect::ReflectiveTexel;
use super::texel::{LayerTexel, TexelSum, pack_texel, texel_words, unpack_texel};
use crate::gaussian::layer_coordinate;
use crate::math::{clamp, floor, max, to_u32};
use crate::passes::Accumulate;
use crate::passes::light_map::PROJECT_PARALLEL;
use crate::passes::voxel_cones::lobes::unpack_mean;
use crate::passes::voxel_cones::storage::unpack_radiance;

/// Returns the texels before those of a level, of one layer: Σ (size/2^i)² over the finer ones.
#[inline]
pub fn texels_before(size: u32, level: u32) -> u32 {
    let side = size >> level;
    4 * (size * size - side * side) / 3
}

/// Returns the near and far end of depth layer `d`, with half of the overlap beyond each.
#[inline]
pub fn layer_range(map: &LayeredMap, d: u32) -> (f32, f32) {
    let near = map.near + map.thickness * d as f32;
    (near - 0.5 * map.overlap, near + (map.thickness + 0.5 * map.overlap))
}

/// Whether a depth belongs to depth layer `d`: what lies before the first or behind the last belongs to that.
#[inline]
fn holds(map: &LayeredMap, d: u32, depth: f32) -> bool {
    let (near, far) = layer_range(map, d);
    (d == 0 || depth >= near) && (d + 1 == map.depth_layers || depth < far)
}

/// The layer of a cosine.
#[inline]
fn normal_layer(map: &LayeredMap, cosine: f32) -> u32 {
    let n = map.normal_layers;
    let layer = to_u32(floor(clamp(cosine, 0.0, 1.0) * n as f32));
    if layer < n { layer } else { n - 1 }
}

/// Returns the square of the farthest depth of a map, m²: the unit of squared distances, so that stored flux does not depend on
/// the unit of length. 1 for parallel rays.
#[inline]
pub fn farthest_squared(map: &LayeredMap) -> f32 {
    if map.projection == PROJECT_PARALLEL {
        return 1.0;
    }
    let far = map.near + map.thickness * map.depth_layers as f32;
    max(far * far, 1.0e-18)
}

#[inline]
fn write(map: &LayeredMap, index: u32, t: &LayerTexel, output: &mut impl Accumulate) {
    let words = texel_words(map.format);
    let packed = pack_texel(map.format, t);
    let at = words * index;
    output.or(at, packed[0]);
    output.or(at + 1, packed[1]);
    output.or(at + 2, packed[2]);
    if words > 3 {
        output.or(at + 3, packed[3]);
    }
}

/// Writes texel `index` of the finest level, layer by layer: what of four texels of the light's map belongs to the layer.
#[inline]
pub fn split_layers(
    index: u32,
    params: &LayeredMap,
    reflected: &[ReflectiveTexel],
    output: &mut impl Accumulate,
) {
    let side = params.size;
    let layer = index / (side * side);
    let texel = index - layer * side * side;
    let (x, y) = (2 * (texel % side), 2 * (texel / side));
    let depth_layer = layer / params.normal_layers;
    let (near, far) = layer_range(params, depth_layer);
    let mut sum = TexelSum::new(0.0);
    for k in 0..4 {
        let at = (y + k / 2) * (2 * side) + (x + (k & 1));
        let r = &reflected[at as usize];
        let normals = layer - depth_layer * params.normal_layers;
        if r.cosine >= 0.0 && holds(params, depth_layer, r.depth) && normal_layer(params, r.cosine) == normals
        {
            let one = LayerTexel {
                reflected: unpack_radiance(r.radiance),
                opacity: 1.0,
                normal: unpack_mean(r.normal),
                mean: clamp(layer_coordinate(r.depth, near, far), -1.0, 1.0),
                variance: 0.0,
            };
            sum = told_from(sum, &one);
            sum.add(&one, 0.25);
        }
    }
    write(params, index, &sum.whole(), output);
}

/// The sum, its depths told from the first surface that is added: what is alike keeps its precision.
#[inline]
fn told_from(sum: TexelSum, t: &LayerTexel) -> TexelSum {
    if sum.is_empty() && t.opacity > 0.0 { TexelSum::new(t.mean) } else { sum }
}

/// Writes texel `index` of level `params.level`, layer by layer, from the four below it. `below` holds that level alone.
#[inline]
pub fn shrink_layers(index: u32, params: &LayeredMap, below: &[u32], output: &mut impl Accumulate) {
    let side = params.size >> params.level;
    let words = texel_words(params.format);
    let layer = index / (side * side);
    let texel = index - layer * side * side;
    let (x, y) = (2 * (texel % side), 2 * (texel / side));
    let first = layer * (4 * side * side);
    let mut sum = TexelSum::new(0.0);
    for k in 0..4 {
        let at = first + (y + k / 2) * (2 * side) + (x + (k & 1));
        let t = unpack_texel(params.format, below, words * at);
        sum = told_from(sum, &t);
        sum.add(&t, 0.25);
    }
    write(params, index, &sum.whole(), output);
}
