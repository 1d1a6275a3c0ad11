//! How much light comes from beyond the scene, by direction?

use super::MAX_VALUE;
use super::gltf_accessor::read_file;
use crate::error::{SceneError, one_line};
use glam::{Vec3, Vec4};
use std::path::Path;
use twinlight_kernels::math::{acos, atan2, floor, normalize_or};

/// The largest side of an environment map, pixels.
pub const MAX_SIDE: u32 = 32768;

/// What a ray sees that leaves the scene: radiance in W/(m² sr), linear Rec.709.
#[derive(Clone, Debug, PartialEq, Default)]
pub enum Environment {
    /// Nothing: black.
    #[default]
    None,
    /// The same radiance from everywhere, ≥ 0.
    Constant(Vec3),
    /// Radiance by direction.
    Map(EnvironmentMap),
}

/// An equirectangular map: column 0 is left, row 0 is up (+y).
///
/// Direction (x, y, z) of unit length is at u = atan2(x, −z)/2π + ½ and v = acos(y)/π, in [0, 1] from the left and
/// the top: the middle of the map is −z, +x is to its right.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    /// Columns, at least 1.
    pub width: u32,
    /// Rows, at least 1.
    pub height: u32,
    /// `width × height` radiances row by row, finite and ≥ 0; w is 0.
    pub data: Vec<Vec4>,
}

impl Environment {
    /// Reads an equirectangular `.hdr` or `.exr`; negative radiances become 0.
    ///
    /// # Errors
    /// A file that can't be read or decoded, another format, a side beyond 32768 pixels, values not finite.
    pub fn open(path: &Path) -> Result<Self, SceneError> {
        let error = |reason: String| SceneError::Environment { path: one_line(path.display()), reason };
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        let format = match extension.as_str() {
            "hdr" => image::ImageFormat::Hdr,
            "exr" => image::ImageFormat::OpenExr,
            _ => return Err(error("its name ends neither in .hdr nor in .exr".into())),
        };
        let bytes =
            read_file(path).map_err(|reason| SceneError::Read { path: one_line(path.display()), reason })?;
        EnvironmentMap::decode(&bytes, format).map(Self::Map).map_err(error)
    }

    /// Returns the radiance that arrives along the reversed `direction` (that is, seen looking along it).
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        match self {
            Self::None => Vec3::ZERO,
            Self::Constant(radiance) => *radiance,
            Self::Map(map) => map.radiance(direction),
        }
    }

    /// Whether any light comes from it.
    pub fn is_lit(&self) -> bool {
        match self {
            Self::None => false,
            Self::Constant(radiance) => radiance.max_element() > 0.0,
            Self::Map(map) => map.data.iter().any(|texel| texel.max_element() > 0.0),
        }
    }
}

impl EnvironmentMap {
    /// Makes a map of radiances row by row; negative ones become 0 and w becomes 0.
    ///
    /// # Errors
    /// The reason, when the sizes don't fit together or a value is not finite.
    pub fn new(width: u32, height: u32, mut data: Vec<Vec4>) -> Result<Self, String> {
        if width == 0 || height == 0 || width > MAX_SIDE || height > MAX_SIDE {
            return Err(format!("{width}x{height} pixels are not within 1 to {MAX_SIDE} a side"));
        }
        if data.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(format!("{} values are not {width}x{height}", data.len()));
        }
        let in_range = |texel: &&Vec4| texel.truncate().abs().to_array().iter().all(|&x| x <= MAX_VALUE);
        let bad = data.len() - data.iter().filter(in_range).count();
        if bad > 0 {
            return Err(format!("{bad} pixels are not finite or beyond {MAX_VALUE:e}"));
        }
        for texel in &mut data {
            *texel = texel.truncate().max(Vec3::ZERO).extend(0.0);
        }
        Ok(Self { width, height, data })
    }

    /// Decodes an equirectangular picture; negative radiances become 0.
    ///
    /// # Errors
    /// The reason, when it can't be decoded, a side is beyond 32768 pixels, or a value is not finite or beyond 1e18.
    pub fn decode(bytes: &[u8], format: image::ImageFormat) -> Result<Self, String> {
        let mut reader = image::ImageReader::with_format(std::io::Cursor::new(bytes), format);
        let mut limits = image::Limits::default();
        limits.max_image_width = Some(MAX_SIDE);
        limits.max_image_height = Some(MAX_SIDE);
        // 16384 × 8192 pixels of 16 bytes, and as much again to work in.
        limits.max_alloc = Some(4 << 30);
        reader.limits(limits);
        let picture = reader.decode().map_err(one_line)?.into_rgb32f();
        let (width, height) = picture.dimensions();
        let data = picture.pixels().map(|p| Vec4::new(p[0], p[1], p[2], 0.0)).collect();
        Self::new(width, height, data)
    }

    /// Makes a map from a function of the unit direction of each texel's centre.
    ///
    /// # Errors
    /// As [`EnvironmentMap::new`].
    pub fn from_directions(width: u32, height: u32, f: impl Fn(Vec3) -> Vec3) -> Result<Self, String> {
        let (columns, rows) = (width.min(MAX_SIDE), height.min(MAX_SIDE));
        let texel = |i: u32| f(Self::direction(i % columns, i / columns, columns, rows)).extend(0.0);
        Self::new(width, height, (0..columns * rows).map(texel).collect())
    }

    /// Returns the unit direction of the centre of texel (column, row) of a map of this size.
    pub fn direction(column: u32, row: u32, width: u32, height: u32) -> Vec3 {
        let turn = (f64::from(column) + 0.5) / f64::from(width) - 0.5;
        let (sin_phi, cos_phi) = (std::f64::consts::TAU * turn).sin_cos();
        let (sin, cos) = (std::f64::consts::PI * (f64::from(row) + 0.5) / f64::from(height)).sin_cos();
        Vec3::new((sin * sin_phi) as f32, cos as f32, (-sin * cos_phi) as f32)
    }

    /// Returns the radiance seen along `direction` of any length: bilinear, around in u and clamped in v.
    pub fn radiance(&self, direction: Vec3) -> Vec3 {
        let d = normalize_or(direction, Vec3::Y);
        let u = atan2(d.x, -d.z) * (0.5 * std::f32::consts::FRAC_1_PI) + 0.5;
        let v = acos(d.y) * std::f32::consts::FRAC_1_PI;
        let (x, y) = (u * self.width as f32 - 0.5, v * self.height as f32 - 0.5);
        let (left, top) = (floor(x), floor(y));
        let (s, t) = (x - left, y - top);
        let row = |offset: i64| (top as i64 + offset).clamp(0, i64::from(self.height) - 1);
        let column = |offset: i64| (left as i64 + offset).rem_euclid(i64::from(self.width));
        let texel = |dx: i64, dy: i64| {
            let index = (row(dy) * i64::from(self.width) + column(dx)) as usize;
            self.data.get(index).map_or(Vec3::ZERO, |texel| texel.truncate())
        };
        let upper = texel(0, 0) * (1.0 - s) + texel(1, 0) * s;
        let lower = texel(0, 1) * (1.0 - s) + texel(1, 1) * s;
        upper * (1.0 - t) + lower * t
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Red grows with x, green with y, blue with z.
    fn compass(width: u32) -> EnvironmentMap {
        EnvironmentMap::from_directions(width, width / 2, |d| d * 0.5 + 0.5).unwrap()
    }

    #[test]
    fn the_middle_is_minus_z_and_plus_x_is_right_of_it() {
        let at =
            |u: f64, v: f64| EnvironmentMap::direction((u * 1000.0) as u32, (v * 1000.0) as u32, 1000, 1000);
        assert!((at(0.5, 0.5) - Vec3::NEG_Z).length() < 0.01);
        assert!((at(0.75, 0.5) - Vec3::X).length() < 0.01);
        assert!((at(0.3, 0.0) - Vec3::Y).length() < 0.01);
    }

    #[test]
    fn lookup_inverts_the_mapping() {
        let map = compass(256);
        for i in 0..1000 {
            let (a, b) = (i as f32 * 0.618, i as f32 / 999.0 * 2.0 - 1.0);
            let r = (1.0 - b * b).max(0.0).sqrt();
            let d = Vec3::new(r * a.cos(), b, r * a.sin());
            let error = (map.radiance(d * 3.0) - (d * 0.5 + 0.5)).abs().max_element();
            assert!(error < 0.02, "{d}: {error}");
        }
        // Negative control: a map turned by a quarter differs.
        assert!((map.radiance(Vec3::X) - map.radiance(Vec3::Z)).length() > 0.5);
    }

    #[test]
    fn bad_maps_are_refused_and_negative_values_clamped() {
        assert!(EnvironmentMap::new(2, 2, vec![Vec4::ZERO; 3]).is_err());
        assert!(EnvironmentMap::new(0, 0, vec![]).is_err());
        assert!(EnvironmentMap::new(1, 1, vec![Vec4::splat(f32::NAN)]).is_err());
        let map = EnvironmentMap::new(1, 1, vec![Vec4::new(-1.0, 2.0, 3.0, 4.0)]).unwrap();
        assert_eq!(map.data, [Vec4::new(0.0, 2.0, 3.0, 0.0)]);
        assert_eq!(map.radiance(Vec3::NAN), Vec3::new(0.0, 2.0, 3.0));
    }

    #[test]
    fn files_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let pixels: Vec<f32> = (0..8 * 4 * 3).map(|i| i as f32 * 0.25).collect();
        let picture = image::Rgb32FImage::from_raw(8, 4, pixels).unwrap();
        for name in ["a.exr", "a.hdr"] {
            let path = folder.path().join(name);
            image::DynamicImage::ImageRgb32F(picture.clone()).save(&path).unwrap();
            let Environment::Map(map) = Environment::open(&path).unwrap() else { panic!("no map") };
            assert_eq!((map.width, map.height), (8, 4));
            for (texel, pixel) in map.data.iter().zip(picture.pixels()) {
                let expected = Vec3::new(pixel[0], pixel[1], pixel[2]);
                assert!((texel.truncate() - expected).abs().max_element() <= 0.01 * expected.max_element());
            }
            let bytes = std::fs::read(&path).unwrap();
            std::fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
            assert!(matches!(Environment::open(&path), Err(SceneError::Environment { .. })));
        }
        assert!(matches!(Environment::open(Path::new("a.png")), Err(SceneError::Environment { .. })));
        assert!(matches!(Environment::open(Path::new("none.hdr")), Err(SceneError::Read { .. })));
    }
}
