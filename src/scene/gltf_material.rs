//! What do a glTF material's values become in the buffers?

use super::MAX_VALUE;
use super::gltf_texture::{Placed, Space, Textures, numbered};
use crate::error::SceneError;
use glam::Vec4;
use gltf::material::AlphaMode;
use gltf::texture::{Info, WrappingMode};
use twinlight_kernels::passes::scene::{MATERIAL_MASKED, Material};

/// A material and where its texture coordinates come from.
pub struct Loaded {
    /// For the buffer.
    pub material: Material,
    /// Which TEXCOORD set its textures use; nothing for a material without textures.
    pub texture_coordinates: Option<Coordinates>,
}

/// A set of texture coordinates and the affine map applied to it (KHR_texture_transform).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    /// TEXCOORD_n.
    pub set: u32,
    /// u′ = m₀u + m₁v + m₂, v′ = m₃u + m₄v + m₅.
    pub map: [f32; 6],
}

/// Returns the images that a material reads.
pub fn images(material: &gltf::Material) -> Vec<(usize, Space)> {
    textures(material).iter().map(|(info, space)| (image(info), *space)).collect()
}

/// Converts a material; what can't be kept is told in `warnings`.
///
/// Base colour, alpha, metallic and roughness are clamped to [0, 1], emission and cut-off to 0 and more. BLEND is
/// treated as opaque; a mask that no texel can fail is dropped.
pub fn convert(
    source: &gltf::Material,
    textures_read: &Textures,
    warnings: &mut Vec<String>,
) -> Result<Loaded, SceneError> {
    let what = match source.index() {
        Some(index) => format!("material {}", numbered(index, source.name())),
        None => "default material".into(),
    };
    let pbr = source.pbr_metallic_roughness();
    let strength = source.emissive_strength().unwrap_or(1.0);
    let cutoff = source.alpha_cutoff().unwrap_or(0.5);
    let [er, eg, eb] = source.emissive_factor().map(|c| c * strength);
    let base = Vec4::from(pbr.base_color_factor());
    let (metallic, roughness) = (pbr.metallic_factor(), pbr.roughness_factor());
    let in_range = |f: &f32| f.abs() <= MAX_VALUE;
    let factors = [er, eg, eb, metallic, roughness, cutoff];
    if !(base.to_array().iter().all(in_range) && factors.iter().all(in_range)) {
        return Err(SceneError::Value {
            what,
            reason: format!("a factor is not finite or beyond {MAX_VALUE:e}"),
        });
    }
    let place = |info: Option<Info>, space: Space| {
        info.and_then(|info| textures_read.place(image(&info), space)).unwrap_or_default()
    };
    let base_texture: Placed = place(pbr.base_color_texture(), Space::Colour);
    let rough_texture = place(pbr.metallic_roughness_texture(), Space::Data);
    let emission_texture = place(source.emissive_texture(), Space::Colour);

    let base = base.clamp(Vec4::ZERO, Vec4::ONE);
    let cutoff = cutoff.max(0.0);
    let lowest_alpha = base.w * if base_texture.size == 0 { 1.0 } else { base_texture.min_alpha };
    // The slack covers the rounding of filtered alpha.
    let has_holes = source.alpha_mode() == AlphaMode::Mask && lowest_alpha < cutoff + 1.0e-5;
    if source.alpha_mode() == AlphaMode::Blend {
        warnings.push(format!("{what}: alphaMode BLEND is treated as opaque"));
    }
    let material = Material {
        base,
        emission: Vec4::new(er.max(0.0), eg.max(0.0), eb.max(0.0), 0.0),
        metallic: metallic.clamp(0.0, 1.0),
        roughness: roughness.clamp(0.0, 1.0),
        cutoff,
        flags: if has_holes { MATERIAL_MASKED } else { 0 },
        base_texture: base_texture.first,
        base_size: base_texture.size,
        rough_texture: rough_texture.first,
        rough_size: rough_texture.size,
        emission_texture: emission_texture.first,
        emission_size: emission_texture.size,
        ..Material::default()
    };
    Ok(Loaded { material, texture_coordinates: coordinates(source, &what, warnings)? })
}

/// Returns the texture coordinates of the first texture; others that differ can't be kept.
fn coordinates(
    source: &gltf::Material,
    what: &str,
    warnings: &mut Vec<String>,
) -> Result<Option<Coordinates>, SceneError> {
    let mut first = None;
    for (info, _) in textures(source) {
        let sampler = info.texture().sampler();
        if [sampler.wrap_s(), sampler.wrap_t()] != [WrappingMode::Repeat; 2] {
            warnings.push(format!("{what}: a texture's wrapping is treated as repeat"));
        }
        let own = of_texture(&info);
        if !own.map.iter().all(|m| m.is_finite()) {
            let reason = "a texture transform is not finite".into();
            return Err(SceneError::Value { what: what.into(), reason });
        }
        if *first.get_or_insert(own) != own {
            warnings.push(format!("{what}: all its textures use the coordinates of the first"));
        }
    }
    Ok(first)
}

fn of_texture(info: &Info) -> Coordinates {
    let Some(transform) = info.texture_transform() else {
        return Coordinates { set: info.tex_coord(), map: [1.0, 0.0, 0.0, 0.0, 1.0, 0.0] };
    };
    let ([x, y], [sx, sy]) = (transform.offset(), transform.scale());
    let (sin, cos) = transform.rotation().sin_cos();
    Coordinates {
        set: transform.tex_coord().unwrap_or(info.tex_coord()),
        map: [cos * sx, sin * sy, x, -sin * sx, cos * sy, y],
    }
}

/// The textures that are used, the base colour first.
fn textures<'a>(material: &gltf::Material<'a>) -> Vec<(Info<'a>, Space)> {
    let pbr = material.pbr_metallic_roughness();
    let all = [
        (pbr.base_color_texture(), Space::Colour),
        (material.emissive_texture(), Space::Colour),
        (pbr.metallic_roughness_texture(), Space::Data),
    ];
    all.into_iter().filter_map(|(info, space)| Some((info?, space))).collect()
}

fn image(info: &Info) -> usize {
    info.texture().source().index()
}
