//! Which pictures stand behind a point?

use super::Pictures;
use super::measure::{Measured, Right};
use super::run::Session;
use crate::cli::Failure;
use crate::picture::{Picture, write_whole};
use glam::Vec3;

impl Session<'_> {
    /// Keeps the pictures behind a point.
    pub(super) fn keep_pictures(
        &self,
        scene: &str,
        id: usize,
        m: &Measured,
        right: &Right,
    ) -> Result<(), Failure> {
        if self.a.pictures == Pictures::None {
            return Ok(());
        }
        let all = right.all.mean();
        self.keep(scene, &format!("{id}.all"), &m.all, exposure(all))?;
        let (picture, reference) = match &m.indirect {
            Some(indirect) => {
                let reference = right.indirect.mean();
                self.keep(scene, &format!("{id}.indirect"), indirect, exposure(reference))?;
                (indirect, reference)
            }
            None => (&m.all, all),
        };
        self.keep(scene, &format!("{id}.error"), &error_map(picture, reference, self.a.block), 0.0)
    }

    pub(super) fn keep(
        &self,
        scene: &str,
        name: &str,
        picture: &Picture,
        exposure: f32,
    ) -> Result<(), Failure> {
        let bytes =
            picture.jpeg(exposure).map_err(|e| Failure::Work(format!("cannot encode a picture: {e}")))?;
        Ok(write_whole(&self.folder.picture(scene, name), &bytes)?)
    }
}

/// Stops that make a picture's mean a quarter.
pub(super) fn exposure(picture: &Picture) -> f32 {
    let mean = picture.mean().element_sum() / 3.0;
    if mean > 0.0 { (0.25 / mean).log2().clamp(-60.0, 60.0) } else { 0.0 }
}

/// Too dark is blue, too bright red, in full colour at a quarter of the reference's mean.
fn error_map(picture: &Picture, reference: &Picture, side: u32) -> Picture {
    let (coarse, right) = (picture.averaged(side), reference.averaged(side));
    let full = 0.25 * right.mean().element_sum().max(1.0e-30);
    let mut map = Picture::new(picture.width, picture.height);
    for (i, pixel) in map.pixels.iter_mut().enumerate() {
        let (x, y) = (i as u32 % picture.width / side, i as u32 / picture.width / side);
        let at = (y.min(coarse.height - 1) * coarse.width + x.min(coarse.width - 1)) as usize;
        let off = ((coarse.pixels[at] - right.pixels[at]).element_sum() / full).clamp(-1.0, 1.0);
        let faded = 1.0 - off.abs();
        *pixel = if off > 0.0 { Vec3::new(1.0, faded, faded) } else { Vec3::new(faded, faded, 1.0) };
    }
    map
}
