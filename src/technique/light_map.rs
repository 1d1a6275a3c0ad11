//! How is a light's map laid over what it shines on?

use super::World;
use crate::backend::{Backend, BackendError};
use crate::scene::Bounds;
use glam::{Vec3, Vec4};
use twinlight_kernels::passes::elements::{Light, LightMapParams, Surface};
use twinlight_kernels::passes::light_map::{PROJECT_OCTAHEDRON, PROJECT_PARALLEL, PROJECT_PERSPECTIVE};
use twinlight_kernels::passes::scene::{LIGHT_SPOT, LIGHT_SUN};

/// Spots wider than this half angle (80°) have a map of all directions.
const WIDEST_PERSPECTIVE: f32 = 1.396;

/// The map of a light with `size` × `size` texels, for surfaces within `bounds`; `bias` in metres is no shadow.
pub fn map_params(light: &Light, bounds: &Bounds, size: u32, bias: f32) -> LightMapParams {
    let forward = light.direction.truncate();
    let forward = if forward.length_squared() > 0.5 { forward } else { Vec3::NEG_Y };
    let (right, down) = forward.any_orthonormal_pair();
    let position = light.position.truncate();
    let params = LightMapParams { size, bias, ..Default::default() };
    let axes = |params: LightMapParams, scale: f32| LightMapParams {
        right: (right * scale).extend(0.0),
        down: (down * scale).extend(0.0),
        forward: forward.extend(0.0),
        ..params
    };
    let side = size as f32;
    if light.kind == LIGHT_SUN {
        // A little more than the sphere around the scene, from well before it.
        let radius = 0.505 * bounds.size().length().max(1.0e-6);
        let origin = bounds.centre() - forward * (2.0 * radius);
        let (projection, texel) = (PROJECT_PARALLEL, 2.0 * radius / side);
        return axes(LightMapParams { origin: origin.extend(0.0), projection, texel, ..params }, radius);
    }
    let origin: Vec4 = position.extend(0.0);
    if light.kind == LIGHT_SPOT && light.outer < WIDEST_PERSPECTIVE {
        let tangent = light.outer.tan() * 1.01;
        let (projection, texel) = (PROJECT_PERSPECTIVE, 2.0 * tangent / side);
        return axes(LightMapParams { origin, projection, texel, ..params }, tangent);
    }
    // The whole sphere over size² texels; the octahedron stretches some of them by about two.
    let texel = 2.0 * (4.0 * std::f32::consts::PI).sqrt() / side;
    axes(LightMapParams { origin, projection: PROJECT_OCTAHEDRON, texel, ..params }, 1.0)
}

/// One bit per light and surface, from maps of `size` × `size` texels: lights `first` to `first + count`, at most 32.
pub fn visibility<B: Backend>(
    backend: &mut B,
    world: &World<B>,
    surfaces: &B::Buffer<Surface>,
    items: u32,
    lights: std::ops::Range<u32>,
    size: u32,
    bias: f32,
) -> Result<B::Buffer<u32>, BackendError> {
    let w = world;
    let mut visible = backend.alloc("visibility", items as usize)?;
    let mut next = backend.alloc("visibility", items as usize)?;
    for (bit, light) in lights.enumerate() {
        let params = LightMapParams {
            light: bit as u32,
            ..map_params(&w.host_lights[light as usize], &w.bounds, size, bias)
        };
        let mut hits = backend.alloc("light map", (size * size) as usize)?;
        backend.trace_light_map(
            &params,
            &w.nodes,
            &w.blocks,
            &w.triangles,
            &w.materials,
            &w.texels,
            &mut hits,
            size * size,
        )?;
        backend.light_map_visibility(&params, surfaces, &hits, &visible, &mut next, items)?;
        std::mem::swap(&mut visible, &mut next);
    }
    Ok(visible)
}
