//! What is in a file's textures, as texels that kernels read?

use super::gltf_accessor::{Buffers, read_uri};
use crate::error::{SceneError, one_line};
use gltf::Document;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::io::Cursor;
use std::path::Path;

/// The largest side of a texture, pixels.
const MAX_SIDE: u32 = 32768;
/// Texels of all textures together: their words must be addressable with 32 bits.
const MAX_TEXELS: u64 = 1 << 31;

/// How an image's numbers are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Space {
    /// Red, green and blue are sRGB encoded, alpha is linear.
    Colour,
    /// All channels are linear.
    Data,
}

/// Where a texture lies among all texels.
#[derive(Clone, Copy, Debug, Default)]
pub struct Placed {
    /// Index of its first texel.
    pub first: u32,
    /// Width | height << 16.
    pub size: u32,
    /// Smallest alpha, in [0, 1].
    pub min_alpha: f32,
}

/// The textures of a document, each image once for each meaning it is used with.
pub struct Textures {
    /// Two words a texel.
    pub texels: Vec<u32>,
    placed: BTreeMap<(usize, Space), Placed>,
}

impl Textures {
    /// Reads and converts the `wanted` images, in parallel, and lays them out in the order of `wanted`'s keys.
    pub fn read(
        document: &Document,
        buffers: &Buffers,
        path: &Path,
        wanted: impl IntoIterator<Item = (usize, Space)>,
    ) -> Result<Self, SceneError> {
        let keys: Vec<_> = BTreeMap::from_iter(wanted.into_iter().map(|key| (key, ()))).into_keys().collect();
        let folder = path.parent().unwrap_or(Path::new(""));
        let curve = curve();
        let images: Vec<Result<_, SceneError>> = keys
            .par_iter()
            .map(|&(index, space)| {
                read_image(document, buffers, folder, index, space, &curve).map_err(|reason| {
                    let name = document.images().nth(index).and_then(|i| i.name().map(one_line));
                    SceneError::Texture { image: numbered(index, name.as_deref()), reason }
                })
            })
            .collect();
        let mut all = Self { texels: vec![], placed: BTreeMap::new() };
        for (key, image) in keys.into_iter().zip(images) {
            let Image { texels, width, height, min_alpha } = image?;
            let first = all.texels.len() as u64 / 2;
            let count = first + texels.len() as u64 / 2;
            if count > MAX_TEXELS {
                return Err(SceneError::TooLarge { what: "texels".into(), count, limit: MAX_TEXELS });
            }
            all.texels.extend(texels);
            all.placed.insert(key, Placed { first: first as u32, size: width | height << 16, min_alpha });
        }
        Ok(all)
    }

    /// Returns where an image lies that was wanted.
    pub fn place(&self, image: usize, space: Space) -> Option<Placed> {
        self.placed.get(&(image, space)).copied()
    }
}

/// Returns `index`, with the name in brackets where there is one.
pub fn numbered(index: usize, name: Option<&str>) -> String {
    match name {
        Some(name) => format!("{index} ({})", one_line(name).chars().take(60).collect::<String>()),
        None => index.to_string(),
    }
}

struct Image {
    texels: Vec<u32>,
    width: u32,
    height: u32,
    min_alpha: f32,
}

fn read_image(
    document: &Document,
    buffers: &Buffers,
    folder: &Path,
    index: usize,
    space: Space,
    curve: &[u16],
) -> Result<Image, String> {
    // Through the parsed JSON: the document's own accessor trusts that a MIME type is given.
    let source = document.as_json().images.get(index).ok_or("there is no such image")?;
    let bytes: std::borrow::Cow<[u8]> = match (&source.buffer_view, &source.uri) {
        (Some(view), _) => {
            let view = document.views().nth(view.value()).ok_or("its buffer view is missing")?;
            buffers.view(&view)?.into()
        }
        (None, Some(uri)) => read_uri(folder, uri)?.into(),
        (None, None) => return Err("it has neither a buffer view nor a file".into()),
    };
    let mut reader = image::ImageReader::new(Cursor::new(&bytes)).with_guessed_format().map_err(one_line)?;
    if !matches!(reader.format(), Some(image::ImageFormat::Png | image::ImageFormat::Jpeg)) {
        return Err("it is neither PNG nor JPEG".into());
    }
    let mut limits = image::Limits::default();
    limits.max_image_width = Some(MAX_SIDE);
    limits.max_image_height = Some(MAX_SIDE);
    limits.max_alloc = Some(8 << 30);
    reader.limits(limits);
    let picture = reader.decode().map_err(one_line)?.into_rgba16();
    let (width, height) = picture.dimensions();
    if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
        return Err(format!("{width}x{height} pixels are not within 1 to {MAX_SIDE} a side"));
    }
    let linear = |value: u16| if space == Space::Colour { curve[usize::from(value)] } else { value };
    let mut texels = Vec::with_capacity(2 * width as usize * height as usize);
    let mut min_alpha = u16::MAX;
    for pixel in picture.pixels() {
        let [r, g, b, a] = pixel.0;
        texels.push(u32::from(linear(r)) | u32::from(linear(g)) << 16);
        texels.push(u32::from(linear(b)) | u32::from(a) << 16);
        min_alpha = min_alpha.min(a);
    }
    Ok(Image { texels, width, height, min_alpha: f32::from(min_alpha) / 65535.0 })
}

/// Returns the linear value, as 16-bit unorm, of every sRGB encoded 16-bit unorm.
fn curve() -> Vec<u16> {
    (0..=u16::MAX)
        .map(|value| {
            let s = f64::from(value) / 65535.0;
            let linear = if s <= 0.04045 { s / 12.92 } else { ((s + 0.055) / 1.055).powf(2.4) };
            (linear * 65535.0).round() as u16
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_is_srgb() {
        let curve = curve();
        assert_eq!((curve[0], curve[65535]), (0, 65535));
        assert!(curve.is_sorted());
        // Middle grey: 188/255 encodes one half.
        assert!((f64::from(curve[188 * 257]) / 65535.0 - 0.5029).abs() < 1e-4);
    }
}
