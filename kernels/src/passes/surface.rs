//! Which surface does each pixel see?
//!
//! The G-buffer: primary rays find a [`Hit`], which becomes a [`Surface`]. Gloss and emission have buffers of
//! their own, which exist only where the scene calls for them.

use super::material::{AlphaTest, emitted_radiance, reflectance, texture_coordinates};
use super::scene::{Material, Triangle};
use crate::geometry::bvh::{BvhNode, Hit, NO_TRIANGLE, Ray, TriangleBlock, nearest_hit};
use crate::math::{cross, dot, max, max_abs, normalize_or};
use glam::{Vec3, Vec4};

gpu_struct! {
    /// A camera and the pixels of a band of its image.
    pub struct CameraParams {
        /// Position in metres; w is 0.
        pub eye: Vec4,
        /// Unit right times tan(fov/2) times width/height; w is 0.
        pub right: Vec4,
        /// Unit up times tan(fov/2); w is 0.
        pub up: Vec4,
        /// Unit forward; w is 0.
        pub forward: Vec4,
        /// Pixels in a row.
        pub width: u32,
        /// Row-major number of the first pixel of the band.
        pub first_pixel: u32,
        /// 2/width.
        pub pixel_width: f32,
        /// 2/height.
        pub pixel_height: f32,
    }

    /// What a pixel sees.
    pub struct Surface {
        /// Position in metres; w is the distance from the eye, −1 where the pixel sees nothing.
        pub position: Vec4,
        /// Unit shading normal, turned to the viewer; w is 1 for the front face, −1 for the back, 0 for nothing.
        pub normal: Vec4,
        /// Lambertian albedo; w is 0.
        pub diffuse: Vec4,
        /// Triangle index, [`NO_TRIANGLE`] where the pixel sees nothing.
        pub triangle: u32,
        /// Material index.
        pub material: u32,
        /// Texture coordinate u.
        pub u: f32,
        /// Texture coordinate v.
        pub v: f32,
    }
}

/// Returns the unit direction of the ray through (x, y) in pixels, measured from the image's top left corner.
#[inline]
pub fn camera_direction(camera: &CameraParams, x: f32, y: f32) -> Vec3 {
    let horizontal = camera.right.truncate() * (x * camera.pixel_width - 1.0);
    let vertical = camera.up.truncate() * (1.0 - y * camera.pixel_height);
    let forward = camera.forward.truncate();
    normalize_or((horizontal + vertical) + forward, forward)
}

/// The direction through the centre of pixel `index` of the band.
#[inline]
pub fn pixel_direction(index: u32, camera: &CameraParams) -> Vec3 {
    let pixel = camera.first_pixel + index;
    let x = (pixel % camera.width) as f32 + 0.5;
    let y = (pixel / camera.width) as f32 + 0.5;
    camera_direction(camera, x, y)
}

/// Returns what the ray through the centre of pixel `index` of the band meets first.
#[inline]
pub fn trace_primary(
    index: u32,
    params: &CameraParams,
    nodes: &[BvhNode],
    blocks: &[TriangleBlock],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> Hit {
    let ray = Ray {
        origin: params.eye.truncate(),
        direction: pixel_direction(index, params),
        t_min: 0.0,
        t_max: 1.0e30,
    };
    nearest_hit(nodes, blocks, &ray, &AlphaTest { triangles, materials, texels })
}

/// Returns the surface at a hit, seen along `direction`; `position.w` is −1 for a miss.
#[inline]
pub fn surface_at(
    hit: &Hit,
    direction: Vec3,
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> Surface {
    if hit.triangle == NO_TRIANGLE {
        return Surface {
            position: Vec4::new(0.0, 0.0, 0.0, -1.0),
            normal: Vec4::ZERO,
            diffuse: Vec4::ZERO,
            triangle: NO_TRIANGLE,
            material: 0,
            u: 0.0,
            v: 0.0,
        };
    }
    let t = &triangles[hit.triangle as usize];
    let w = (1.0 - hit.u) - hit.v;
    let position = (t.p0.truncate() * w + t.p1.truncate() * hit.u) + t.p2.truncate() * hit.v;
    let flat = geometric_normal(t);
    let smooth = (t.n0.truncate() * w + t.n1.truncate() * hit.u) + t.n2.truncate() * hit.v;
    let smooth = normalize_or(smooth, flat);
    // The shading normal is turned on its own: where it and the triangle disagree about the side, it decides.
    let smooth = if dot(smooth, direction) > 0.0 { -smooth } else { smooth };
    let side = if dot(flat, direction) > 0.0 { -1.0 } else { 1.0 };
    let uv = texture_coordinates(t, hit.u, hit.v);
    let r = reflectance(&materials[t.material as usize], texels, uv);
    Surface {
        position: position.extend(hit.t),
        normal: smooth.extend(side),
        diffuse: r.diffuse.extend(0.0),
        triangle: hit.triangle,
        material: t.material,
        u: uv.x,
        v: uv.y,
    }
}

/// Returns the triangle's unit normal by the winding of its corners; up for a triangle without area.
#[inline]
pub fn geometric_normal(t: &Triangle) -> Vec3 {
    let a = t.p0.truncate();
    normalize_or(cross(t.p1.truncate() - a, t.p2.truncate() - a), Vec3::Y)
}

/// Returns the start of a ray that leaves `position` on triangle `t` along `direction`, clear of the triangle.
///
/// Moved along the triangle's normal to the side that the ray goes to, by 2⁻¹⁷ of the largest coordinate: far
/// above the rounding of positions and of the triangle test. Moved toward the triangle's centroid by 2⁻¹⁷ of the
/// way too: a position on an edge may lie, by its rounding, behind the next triangle.
#[inline]
pub fn ray_origin(position: Vec3, t: &Triangle, direction: Vec3) -> Vec3 {
    let normal = geometric_normal(t);
    let a = t.p0.truncate();
    let b = t.p1.truncate();
    let c = t.p2.truncate();
    let extent = max(max(max_abs(a), max_abs(b)), max_abs(c));
    // 2⁻¹⁷
    let offset = extent * 7.629_394_5e-6;
    // 1/3 and 2⁻¹⁷
    let inward = (((a + b) + c) * 0.333_333_34 - position) * 7.629_394_5e-6;
    let clear = if dot(normal, direction) >= 0.0 { normal * offset } else { -normal * offset };
    (position + inward) + clear
}

/// Returns the surface that pixel `index` of the band sees.
#[inline]
pub fn resolve_surfaces(
    index: u32,
    params: &CameraParams,
    hits: &[Hit],
    triangles: &[Triangle],
    materials: &[Material],
    texels: &[u32],
) -> Surface {
    let hit = hits[index as usize];
    surface_at(&hit, pixel_direction(index, params), triangles, materials, texels)
}

/// Returns the specular colour, and in w the Phong exponent, of pixel `index`.
#[inline]
pub fn resolve_gloss(
    index: u32,
    params: &CameraParams,
    surfaces: &[Surface],
    materials: &[Material],
    texels: &[u32],
) -> Vec4 {
    let _ = params;
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE {
        return Vec4::ZERO;
    }
    let r = reflectance(&materials[s.material as usize], texels, glam::Vec2::new(s.u, s.v));
    r.specular.extend(r.exponent)
}

/// Returns the radiance that pixel `index` sees emitted by the front face of its surface.
#[inline]
pub fn resolve_emission(
    index: u32,
    params: &CameraParams,
    surfaces: &[Surface],
    materials: &[Material],
    texels: &[u32],
) -> Vec4 {
    let _ = params;
    let s = &surfaces[index as usize];
    if s.triangle == NO_TRIANGLE || s.normal.w < 0.0 {
        return Vec4::ZERO;
    }
    emitted_radiance(&materials[s.material as usize], texels, glam::Vec2::new(s.u, s.v)).extend(0.0)
}
