//! How does a picture reach a file?
//!
//! Files are written beside their place and renamed, so that none is ever half written.

use glam::Vec3;
use std::path::{Path, PathBuf};

/// Linear radiance by pixel, rows from the top, in W/(m² sr), Rec.709 primaries.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// `width × height` colours.
    pub pixels: Vec<Vec3>,
}

/// Why a file could not be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The name ends in something else.
    #[error("cannot write {path}: the name must end in .png or .exr")]
    Extension {
        /// The file.
        path: String,
    },
    /// The folder is missing, the disk is full, or the like.
    #[error("cannot write {path}: {reason}; check the folder, its permissions and the free space")]
    Write {
        /// The file.
        path: String,
        /// What the operating system says.
        reason: String,
    },
}

/// Writes `bytes` to `path` through a file beside it, so that `path` is whole or untouched.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), OutputError> {
    let failed =
        |e: std::io::Error| OutputError::Write { path: path.display().to_string(), reason: e.to_string() };
    let mut beside = path.as_os_str().to_owned();
    beside.push(format!(".{}.part", std::process::id()));
    let beside = PathBuf::from(beside);
    let written = (|| {
        use std::io::Write;
        let mut file = std::fs::File::create(&beside)?;
        file.write_all(bytes)?;
        file.sync_all()?;
        std::fs::rename(&beside, path)
    })();
    if written.is_err() {
        let _ = std::fs::remove_file(&beside);
    }
    written.map_err(failed)
}

/// What a picture's file holds, by the ending of its name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// 8-bit sRGB after exposure, clipped.
    Png,
    /// 32-bit linear radiance.
    Exr,
}

impl Format {
    /// The format that the file's name asks for.
    pub fn of(path: &Path) -> Result<Self, OutputError> {
        match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
            Some("png") => Ok(Self::Png),
            Some("exr") => Ok(Self::Exr),
            _ => Err(OutputError::Extension { path: path.display().to_string() }),
        }
    }
}

impl Picture {
    /// A black picture.
    pub fn new(width: u32, height: u32) -> Self {
        Self { width, height, pixels: vec![Vec3::ZERO; width as usize * height as usize] }
    }

    /// Mean colour over all pixels.
    pub fn mean(&self) -> Vec3 {
        let sum = self.pixels.iter().fold(glam::DVec3::ZERO, |s, p| s + p.as_dvec3());
        (sum / self.pixels.len().max(1) as f64).as_vec3()
    }

    /// Blocks of `side` × `side` pixels averaged; what is left over at the right and below counts for no block.
    pub fn averaged(&self, side: u32) -> Self {
        let side = side.max(1);
        let mut small = Self::new(self.width / side, self.height / side);
        let scale = 1.0 / (side * side) as f32;
        for y in 0..small.height * side {
            for x in 0..small.width * side {
                let pixel = self.pixels[(y * self.width + x) as usize];
                small.pixels[(y / side * small.width + x / side) as usize] += pixel * scale;
            }
        }
        small
    }

    /// The picture in fewer pixels, each the mean over its part of this one; parts of pixels count by their area.
    pub fn shrunk(&self, width: u32, height: u32) -> Self {
        let across = shares(self.width, width);
        let down = shares(self.height, height);
        let mut small = Self::new(width, height);
        for (y, rows) in down.iter().enumerate() {
            for (x, columns) in across.iter().enumerate() {
                let pixel = &mut small.pixels[y * width as usize + x];
                for &(row, tall) in rows {
                    for &(column, wide) in columns {
                        *pixel += self.pixels[(row * self.width + column) as usize] * (tall * wide);
                    }
                }
            }
        }
        small
    }

    /// Writes the picture: `.exr` as it is, `.png` times 2^`exposure`, clipped, sRGB.
    pub fn save(&self, path: &Path, exposure: f32) -> Result<(), OutputError> {
        let bytes = match Format::of(path)? {
            Format::Png => self.png(exposure),
            Format::Exr => self.exr(),
        };
        let bytes = bytes
            .map_err(|e| OutputError::Write { path: path.display().to_string(), reason: e.to_string() })?;
        write_whole(path, &bytes)
    }

    fn png(&self, exposure: f32) -> Result<Vec<u8>, image::ImageError> {
        encode(self.bytes(exposure).into(), image::ImageFormat::Png)
    }

    /// The bytes of a `.jpg` to look at: times 2^`exposure`, clipped, sRGB.
    ///
    /// # Errors
    /// A picture without pixels.
    pub fn jpeg(&self, exposure: f32) -> Result<Vec<u8>, image::ImageError> {
        encode(self.bytes(exposure).into(), image::ImageFormat::Jpeg)
    }

    fn bytes(&self, exposure: f32) -> image::RgbImage {
        let scale = exposure.exp2();
        let data = self.pixels.iter().flat_map(|p| p.to_array().map(|c| srgb_byte(c * scale))).collect();
        image::ImageBuffer::from_raw(self.width, self.height, data).unwrap_or_default()
    }

    fn exr(&self) -> Result<Vec<u8>, image::ImageError> {
        let data = self.pixels.iter().flat_map(|p| p.to_array()).collect();
        let picture: image::Rgb32FImage =
            image::ImageBuffer::from_raw(self.width, self.height, data).unwrap_or_default();
        encode(picture.into(), image::ImageFormat::OpenExr)
    }

    /// Reads a picture back, as linear values from `.exr`.
    pub fn open_exr(path: &Path) -> Result<Self, image::ImageError> {
        let picture = image::ImageReader::open(path)?.with_guessed_format()?.decode()?.into_rgb32f();
        let (width, height) = picture.dimensions();
        Ok(Self { width, height, pixels: picture.pixels().map(|p| Vec3::from_array(p.0)).collect() })
    }
}

/// For each of `few` equal parts of a row of `many` pixels: which pixels it has, and by what share of the part.
fn shares(many: u32, few: u32) -> Vec<Vec<(u32, f32)>> {
    let length = f64::from(many) / f64::from(few.max(1));
    let part = |i: u32| {
        let (begin, end) = (f64::from(i) * length, f64::from(i + 1) * length);
        let last = (end.ceil() as u32).min(many);
        let share = |p: u32| (f64::from(p + 1).min(end) - f64::from(p).max(begin)).max(0.0) / length;
        (begin.floor() as u32..last).map(|p| (p, share(p) as f32)).collect()
    };
    (0..few).map(part).collect()
}

fn encode(picture: image::DynamicImage, format: image::ImageFormat) -> Result<Vec<u8>, image::ImageError> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    picture.write_to(&mut bytes, format)?;
    Ok(bytes.into_inner())
}

/// The sRGB byte of a linear value, clipped; NaN is black.
fn srgb_byte(linear: f32) -> u8 {
    let x = linear.clamp(0.0, 1.0);
    let encoded = if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exr_keeps_every_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        let mut picture = Picture::new(3, 2);
        picture.pixels[4] = Vec3::new(1.0e-7, 123.456, 9.0e6);
        picture.save(&path, 5.0).unwrap();
        assert_eq!(Picture::open_exr(&path).unwrap(), picture);
        assert_eq!(
            std::fs::read_dir(folder.path()).unwrap().count(),
            1,
            "something was left beside the file"
        );
    }

    #[test]
    fn parts_of_pixels_count_by_their_area() {
        let mut ramp = Picture::new(6, 3);
        ramp.pixels.iter_mut().enumerate().for_each(|(i, p)| *p = Vec3::splat((i % 6) as f32));
        let small = ramp.shrunk(4, 2);
        for (x, want) in [1.0 / 3.0, 5.0 / 3.0, 10.0 / 3.0, 14.0 / 3.0].into_iter().enumerate() {
            assert!((small.pixels[x].x - want).abs() < 1e-6 && (small.pixels[4 + x].y - want).abs() < 1e-6);
        }
        let (blocks, shrunk) = (ramp.averaged(3), ramp.shrunk(2, 1));
        assert!(blocks.pixels.iter().zip(&shrunk.pixels).all(|(a, b)| (*a - *b).length() < 1e-6));
        assert_eq!(ramp.shrunk(6, 3), ramp);
    }

    #[test]
    fn srgb_bytes_are_the_standard_ones() {
        let table =
            [(0.0, 0), (1.0, 255), (0.5, 188), (0.214_041_14, 128), (-1.0, 0), (7.0, 255), (f32::NAN, 0)];
        for (linear, byte) in table {
            assert_eq!(srgb_byte(linear), byte, "{linear}");
        }
    }

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("no/such/folder/a.png");
        assert!(matches!(Picture::new(1, 1).save(&missing, 0.0), Err(OutputError::Write { .. })));
        let taken = folder.path().join("taken.png");
        std::fs::create_dir(&taken).unwrap();
        assert!(matches!(Picture::new(1, 1).save(&taken, 0.0), Err(OutputError::Write { .. })));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(matches!(
            Picture::new(1, 1).save(Path::new("a.jpg"), 0.0),
            Err(OutputError::Extension { .. })
        ));
    }
}
