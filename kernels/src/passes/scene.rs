//! What does a scene look like in buffers?
//!
//! Triangles are stored twice: in traversal order as [`crate::geometry::bvh::TriangleBlock`], and by index as
//! [`Triangle`] with all that shading needs.

use glam::Vec4;

/// `Material` texture size when there is no texture.
pub const NO_TEXTURE: u32 = 0;
/// Bit of [`Material::flags`]: alpha below the cut-off is a hole for every ray (glTF `alphaMode: MASK`).
pub const MATERIAL_MASKED: u32 = 1;
/// [`Light::kind`]: radiates from a point, intensity in W/sr.
pub const LIGHT_POINT: u32 = 0;
/// [`Light::kind`]: a point that radiates into a cone, intensity in W/sr.
pub const LIGHT_SPOT: u32 = 1;
/// [`Light::kind`]: parallel light, irradiance in W/m² on a surface that faces it.
pub const LIGHT_SUN: u32 = 2;

gpu_struct! {
    /// One triangle with its vertex normals and texture coordinates, metres, counter-clockwise from the front.
    pub struct Triangle {
        /// First corner; w is its texture coordinate u.
        pub p0: Vec4,
        /// Second corner; w is its texture coordinate u.
        pub p1: Vec4,
        /// Third corner; w is its texture coordinate u.
        pub p2: Vec4,
        /// Unit normal at the first corner; w is its texture coordinate v.
        pub n0: Vec4,
        /// Unit normal at the second corner; w is its texture coordinate v.
        pub n1: Vec4,
        /// Unit normal at the third corner; w is its texture coordinate v.
        pub n2: Vec4,
        /// Index into the materials.
        pub material: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
    }

    /// A surface's colours, in linear Rec.709; see [`crate::passes::material`] for what they mean.
    pub struct Material {
        /// Base colour and alpha, multiplied by the texture where there is one.
        pub base: Vec4,
        /// Emitted radiance of the front face in W/(m² sr), multiplied by the texture; w is 0.
        pub emission: Vec4,
        /// Metallic share in [0, 1], multiplied by the blue channel of the texture.
        pub metallic: f32,
        /// Roughness in [0, 1], multiplied by the green channel of the texture.
        pub roughness: f32,
        /// Alpha below this is a hole when the material is masked.
        pub cutoff: f32,
        /// [`MATERIAL_MASKED`].
        pub flags: u32,
        /// First texel of the base-colour texture.
        pub base_texture: u32,
        /// Its width | height << 16; [`NO_TEXTURE`] for none.
        pub base_size: u32,
        /// First texel of the metallic-roughness texture.
        pub rough_texture: u32,
        /// Its width | height << 16; [`NO_TEXTURE`] for none.
        pub rough_size: u32,
        /// First texel of the emissive texture.
        pub emission_texture: u32,
        /// Its width | height << 16; [`NO_TEXTURE`] for none.
        pub emission_size: u32,
        /// Padding.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
    }

    /// A light without extent.
    pub struct Light {
        /// Position in metres (point, spot); w is 0.
        pub position: Vec4,
        /// Unit direction in which the light travels (spot axis, sun); w is 0.
        pub direction: Vec4,
        /// W/sr (point, spot) or W/m² (sun), linear Rec.709; w is 0.
        pub intensity: Vec4,
        /// [`LIGHT_POINT`], [`LIGHT_SPOT`] or [`LIGHT_SUN`].
        pub kind: u32,
        /// Half angle within which a spot is at full intensity, radians.
        pub inner: f32,
        /// Half angle from which a spot is dark, radians; between them intensity is linear in the angle.
        pub outer: f32,
        /// Padding.
        pub pad: u32,
    }
}
