//! What does a surface reflect and emit at a point?
//!
//! The mapping from glTF's metallic-roughness model, for base colour b, metallic m and roughness r:
//!
//! - Phong exponent Ns = 2/r⁴ − 2, at most [`MAX_EXPONENT`]
//! - gloss g = 1 − r⁴: how much of the surface mirrors rather than scatters
//! - specular share s = m + 0.04 (1 − m), specular colour g·(0.04 (1 − m) + m b)
//! - diffuse albedo b (1 − g s)
//!
//! A rough surface (r = 1) is Lambertian with albedo b, metal or not, and albedo plus specular colour never
//! exceeds 1. The specular lobe is the normalised Phong lobe (Ns + 2)/(2π) cosᴺˢ about the mirror direction.

use super::scene::{MATERIAL_MASKED, Material, NO_TEXTURE, Triangle};
use crate::geometry::bvh::HitFilter;
use crate::math::{FRAC_1_PI, clamp, div, dot, floor, min, normalize_or, pow, saturate, to_u32};
use glam::{Vec2, Vec3, Vec4};

/// The largest Phong exponent that the mapping gives: a highlight about 2.5° wide.
pub const MAX_EXPONENT: f32 = 1024.0;

/// Returns the texel, linear red, green, blue and alpha in [0, 1]; texels are two words of 16-bit parts.
#[inline]
fn texel(texels: &[u32], first: u32, width: u32, x: u32, y: u32) -> Vec4 {
    // 1/65535
    const UNIT: f32 = 1.525_902_2e-5;
    let at = 2 * (first + y * width + x);
    let rg = texels[at as usize];
    let ba = texels[(at + 1) as usize];
    Vec4::new((rg & 0xFFFF) as f32, (rg >> 16) as f32, (ba & 0xFFFF) as f32, (ba >> 16) as f32) * UNIT
}

/// Returns the texture at `uv`, bilinear, repeating; row 0 is v = 0. White when `size` is [`NO_TEXTURE`].
#[inline]
pub fn sample_texture(texels: &[u32], first: u32, size: u32, uv: Vec2) -> Vec4 {
    if size == NO_TEXTURE {
        return Vec4::ONE;
    }
    let width = size & 0xFFFF;
    let height = size >> 16;
    let (x0, x1, fx) = neighbours(uv.x, width);
    let (y0, y1, fy) = neighbours(uv.y, height);
    let top = texel(texels, first, width, x0, y0) * (1.0 - fx) + texel(texels, first, width, x1, y0) * fx;
    let bottom = texel(texels, first, width, x0, y1) * (1.0 - fx) + texel(texels, first, width, x1, y1) * fx;
    top * (1.0 - fy) + bottom * fy
}

/// The two texels beside a coordinate and the share of the second; texel centres lie at halves.
#[inline]
fn neighbours(coordinate: f32, size: u32) -> (u32, u32, f32) {
    let wrapped = saturate(coordinate - floor(coordinate));
    let x = wrapped * (size as f32) - 0.5;
    let cell = floor(x);
    let fraction = saturate(x - cell);
    let first = if cell < 0.0 { size - 1 } else { to_u32(cell) };
    let first = if first >= size { size - 1 } else { first };
    let second = if first + 1 >= size { 0 } else { first + 1 };
    (first, second, fraction)
}

/// Returns the texture coordinates at (u, v) of a triangle.
#[inline]
pub fn texture_coordinates(t: &Triangle, u: f32, v: f32) -> Vec2 {
    let w = (1.0 - u) - v;
    Vec2::new((t.p0.w * w + t.p1.w * u) + t.p2.w * v, (t.n0.w * w + t.n1.w * u) + t.n2.w * v)
}

/// Returns base colour and alpha at texture coordinates.
#[inline]
pub fn base_color(m: &Material, texels: &[u32], uv: Vec2) -> Vec4 {
    m.base * sample_texture(texels, m.base_texture, m.base_size, uv)
}

/// Returns the radiance that the front face emits.
#[inline]
pub fn emitted_radiance(m: &Material, texels: &[u32], uv: Vec2) -> Vec3 {
    let emission = m.emission * sample_texture(texels, m.emission_texture, m.emission_size, uv);
    emission.truncate()
}

/// How a surface reflects.
#[derive(Clone, Copy)]
pub struct Reflectance {
    /// Lambertian albedo.
    pub diffuse: Vec3,
    /// Colour of the specular lobe.
    pub specular: Vec3,
    /// Phong exponent of the specular lobe.
    pub exponent: f32,
}

/// Returns how the surface reflects, by the mapping of this module.
#[inline]
pub fn reflectance(m: &Material, texels: &[u32], uv: Vec2) -> Reflectance {
    let base = base_color(m, texels, uv).truncate();
    let factors = sample_texture(texels, m.rough_texture, m.rough_size, uv);
    let metallic = saturate(m.metallic * factors.z);
    let roughness = saturate(m.roughness * factors.y);
    let squared = roughness * roughness;
    let fourth = clamp(squared * squared, div(2.0, MAX_EXPONENT + 2.0), 1.0);
    let gloss = if roughness >= 1.0 { 0.0 } else { 1.0 - fourth };
    let share = metallic + 0.04 * (1.0 - metallic);
    let dielectric = 0.04 * (1.0 - metallic);
    Reflectance {
        diffuse: base * (1.0 - gloss * share),
        specular: (Vec3::splat(dielectric) + base * metallic) * gloss,
        exponent: min(div(2.0, fourth) - 2.0, MAX_EXPONENT),
    }
}

/// Returns the mirror image of the viewer's direction about the normal, both unit vectors.
#[inline]
pub fn mirror_direction(normal: Vec3, to_viewer: Vec3) -> Vec3 {
    normalize_or(normal * (2.0 * dot(normal, to_viewer)) - to_viewer, normal)
}

/// Returns the Phong lobe (Ns + 2)/(2π)·cosᴺˢ of the angle between the mirrored view and the light, in 1/sr.
///
/// `normal`, `to_viewer` and `to_light` are unit vectors on the same side; the mirror image of the viewer is exact.
#[inline]
pub fn phong_lobe(normal: Vec3, to_viewer: Vec3, to_light: Vec3, exponent: f32) -> f32 {
    let mirror = normal * (2.0 * dot(normal, to_viewer)) - to_viewer;
    let cosine = min(dot(mirror, to_light), 1.0);
    if cosine <= 0.0 {
        return 0.0;
    }
    (exponent + 2.0) * (0.5 * FRAC_1_PI) * pow(cosine, exponent)
}

/// Looks up whether a masked triangle has a hole: glTF `alphaMode: MASK`.
#[derive(Clone, Copy)]
pub struct AlphaTest<'a> {
    /// The scene's triangles.
    pub triangles: &'a [Triangle],
    /// The scene's materials.
    pub materials: &'a [Material],
    /// The scene's texels.
    pub texels: &'a [u32],
}

impl HitFilter for AlphaTest<'_> {
    #[inline]
    fn accepts(&self, triangle: u32, u: f32, v: f32) -> bool {
        let t = &self.triangles[triangle as usize];
        let m = &self.materials[t.material as usize];
        if m.flags & MATERIAL_MASKED == 0 {
            return true;
        }
        base_color(m, self.texels, texture_coordinates(t, u, v)).w >= m.cutoff
    }
}
