//! How far is a picture from a reference that is itself noisy?
//!
//! A reference of independent halves r₁, r₂ tells: the mean of (x − r₁)(x − r₂) over pixels has the squared error of x as its
//! expectation, whatever the noise of the halves, as long as x does not depend on it.

use crate::picture::Picture;
use flip_rs::{HdrOptions, RgbImage, hdr_flip};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// A reference picture as two pictures of independent paths.
#[derive(Clone, Debug)]
pub struct Halves {
    first: Picture,
    second: Picture,
    mean: Picture,
}

/// What a picture is beside a reference in two halves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Errors {
    /// Root mean square of the differences over all pixels and colours, over the mean of the reference; the reference's noise is
    /// not in it, and 0 stands for less than can be told from it.
    pub relative_rmse: f64,
    /// Mean of the picture over the mean of the reference.
    pub mean_ratio: f64,
    /// Half of the pixels are no further off than this, over the mean of the reference; noise of the reference is in it.
    pub p50: f64,
    /// 99 % of the pixels are no further off.
    pub p99: f64,
    /// No pixel is further off.
    pub max: f64,
    /// Errors below this cannot be told from none: by twice the standard error of the mean of the products.
    #[serde(default)]
    pub resolution: f64,
}

impl Errors {
    /// The relative RMSE, as far as it can be told: at most this.
    pub fn told(&self) -> f64 {
        // Not the greater of both: NaN stays.
        if self.relative_rmse < self.resolution { self.resolution } else { self.relative_rmse }
    }

    /// `<` where the relative RMSE cannot be told from none, else nothing.
    pub fn below(&self) -> &'static str {
        if self.relative_rmse < self.resolution { "<" } else { "" }
    }
}

fn grey(c: DVec3) -> f64 {
    (c.x + c.y + c.z) / 3.0
}

impl Halves {
    /// Takes two pictures of one size; `None` where sizes differ.
    pub fn new(first: Picture, second: Picture) -> Option<Self> {
        if (first.width, first.height) != (second.width, second.height) {
            return None;
        }
        let mut mean = first.clone();
        for (a, &b) in mean.pixels.iter_mut().zip(&second.pixels) {
            *a = (*a + b) * 0.5;
        }
        Some(Self { first, second, mean })
    }

    /// The mean of both: the best that is known.
    pub fn mean(&self) -> &Picture {
        &self.mean
    }

    /// Blocks of `side` × `side` pixels averaged, which makes noise less.
    pub fn averaged(&self, side: u32) -> Self {
        let mean = self.mean.averaged(side);
        Self { first: self.first.averaged(side), second: self.second.averaged(side), mean }
    }

    /// The standard error of a pixel of the mean, root mean square, over the mean of the picture.
    pub fn noise(&self) -> f64 {
        let (mut squares, mut sum) = (0.0, 0.0);
        for (a, b) in self.first.pixels.iter().zip(&self.second.pixels) {
            let (a, b) = (a.as_dvec3(), b.as_dvec3());
            squares += ((a - b) * 0.5).length_squared() / 3.0;
            sum += grey(a + b) * 0.5;
        }
        let pixels = self.mean.pixels.len().max(1) as f64;
        if sum > 0.0 { (squares / pixels).sqrt() / (sum / pixels) } else { 0.0 }
    }

    /// Mean HDR-FLIP beside the mean of both, 0 to 1: what a viewer sees at 67 pixels a degree, noise of the reference included; `None` where
    /// sizes differ, or the reference is black.
    pub fn flip(&self, picture: &Picture) -> Option<f64> {
        let image = |p: &Picture| {
            let floats = p.pixels.iter().flat_map(|c| c.max(Vec3::ZERO).to_array()).collect();
            RgbImage::new(p.width as usize, p.height as usize, floats).ok()
        };
        let mut options = HdrOptions::default();
        options.return_exposure_map = false;
        let result = hdr_flip(&image(&self.mean)?, &image(picture)?, options).ok()?;
        Some(f64::from(result.error_map.statistics().mean))
    }

    /// The error of a picture; `None` where sizes differ or the reference is black.
    pub fn errors(&self, picture: &Picture) -> Option<Errors> {
        self.errors_of_two(picture, picture)
    }

    /// The error of what two pictures of independent noise have in common; the noise of neither is in the root mean square.
    pub fn errors_of_two(&self, one: &Picture, other: &Picture) -> Option<Errors> {
        let size = (self.mean.width, self.mean.height);
        if (one.width, one.height) != size || (other.width, other.height) != size {
            return None;
        }
        let (mut squares, mut fourth, mut sum, mut right) = (0.0, 0.0, 0.0, 0.0);
        let mut off = Vec::with_capacity(one.pixels.len());
        for (i, (a, b)) in one.pixels.iter().zip(&other.pixels).enumerate() {
            let (a, b) = (a.as_dvec3(), b.as_dvec3());
            let halves = (self.first.pixels[i].as_dvec3(), self.second.pixels[i].as_dvec3());
            let product = ((a - halves.0) * (b - halves.1)).element_sum() / 3.0;
            squares += product;
            fourth += product * product;
            let (both, reference) = ((a + b) * 0.5, (halves.0 + halves.1) * 0.5);
            sum += grey(both);
            right += grey(reference);
            off.push(((both - reference).length_squared() / 3.0).sqrt());
        }
        if right.is_nan() || right <= 0.0 {
            return None;
        }
        let pixels = off.len() as f64;
        let mean = right / pixels;
        off.sort_by(f64::total_cmp);
        let share = |p: f64| off[((p * pixels) as usize).min(off.len() - 1)] / mean;
        Some(Errors {
            // NaN, where a pixel is none, must stay.
            relative_rmse: if squares < 0.0 { 0.0 } else { (squares / pixels).sqrt() / mean },
            mean_ratio: sum / right,
            p50: share(0.5),
            p99: share(0.99),
            max: share(1.0),
            resolution: {
                let variance = (fourth / pixels - (squares / pixels).powi(2)).max(0.0);
                (2.0 * (variance / pixels).sqrt()).sqrt() / mean
            },
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinlight_kernels::sampling::hash::{combine, unit_float};

    /// A ramp with noise of the given size, by seed.
    fn noisy(seed: u32, noise: f32) -> Picture {
        let mut picture = Picture::new(64, 64);
        for (i, pixel) in picture.pixels.iter_mut().enumerate() {
            let random = unit_float(combine(combine(seed, 7), i as u32)) - 0.5;
            *pixel = Vec3::splat(1.0 + i as f32 / 4096.0 + noise * random);
        }
        picture
    }

    #[test]
    fn the_noise_of_a_reference_is_not_in_the_error() {
        let halves = Halves::new(noisy(1, 2.0), noisy(2, 2.0)).unwrap();
        let right = noisy(0, 0.0);
        let exact = halves.errors(&right).unwrap();
        assert!(exact.relative_rmse < 0.08 && (exact.mean_ratio - 1.0).abs() < 0.02, "{exact:?}");
        let mut off = right.clone();
        off.pixels.iter_mut().for_each(|p| *p *= 1.3);
        let error = halves.errors(&off).unwrap();
        // 0.3 × √(mean of the ramp's square) over its mean
        assert!((error.relative_rmse - 0.305).abs() < 0.02 && (error.mean_ratio - 1.3).abs() < 0.02);
        assert!(exact.relative_rmse < 1.5 * exact.resolution && error.relative_rmse > 2.0 * exact.resolution);
        // Negative control: a plain difference has the noise in it.
        let plain = crate::report::error::picture_error(&right, halves.mean()).unwrap();
        assert!(plain.relative_rmse > 0.2 && (halves.noise() - plain.relative_rmse).abs() < 0.03);
        // A picture that is the reference's own half is not independent, and seems better than it is.
        assert!(halves.errors(&noisy(1, 2.0)).unwrap().relative_rmse < 0.08);
        assert!(halves.errors(&noisy(3, 2.0)).unwrap().relative_rmse > 0.3);
    }

    #[test]
    fn what_cannot_be_told_is_below_and_nan_stays() {
        let e = |relative_rmse: f64| {
            let e = Errors { relative_rmse, mean_ratio: 1.0, p50: 0.0, p99: 0.0, max: 0.0, resolution: 0.1 };
            (e.told(), e.below())
        };
        assert_eq!([e(0.0), e(0.02), e(0.1), e(0.3)], [(0.1, "<"), (0.1, "<"), (0.1, ""), (0.3, "")]);
        let (told, below) = e(f64::NAN);
        assert!(told.is_nan() && below.is_empty());
    }

    #[test]
    fn noise_of_two_pictures_is_not_in_what_they_have_in_common() {
        let halves = Halves::new(noisy(1, 0.5), noisy(2, 0.5)).unwrap();
        let both = halves.errors_of_two(&noisy(3, 2.0), &noisy(4, 2.0)).unwrap();
        assert!(both.relative_rmse < 0.08, "{both:?}");
    }

    #[test]
    fn bad_pixels_sizes_and_black_references_show() {
        let halves = Halves::new(noisy(1, 0.1), noisy(2, 0.1)).unwrap();
        let mut bad = noisy(3, 0.0);
        bad.pixels[5].y = f32::NAN;
        assert!(halves.errors(&bad).unwrap().relative_rmse.is_nan());
        assert!(halves.errors(&Picture::new(32, 32)).is_none());
        assert!(Halves::new(noisy(1, 0.1), Picture::new(8, 8)).is_none());
        let black = Halves::new(Picture::new(8, 8), Picture::new(8, 8)).unwrap();
        assert!(black.errors(&Picture::new(8, 8)).is_none() && black.noise() == 0.0);
    }

    #[test]
    fn flip_sees_what_a_viewer_sees() {
        let right = noisy(0, 0.0);
        let halves = Halves::new(right.clone(), right.clone()).unwrap();
        assert_eq!(halves.flip(&right), Some(0.0));
        let slightly = halves.flip(&noisy(3, 0.05)).unwrap();
        let much = halves.flip(&noisy(3, 1.0)).unwrap();
        assert!(slightly > 0.0 && slightly < 0.1 && much > 3.0 * slightly, "{slightly} {much}");
    }

    #[test]
    fn blocks_are_averaged() {
        let halves = Halves::new(noisy(1, 2.0), noisy(2, 2.0)).unwrap();
        let coarse = halves.averaged(4);
        assert_eq!((coarse.mean().width, coarse.mean().height), (16, 16));
        assert!((coarse.noise() * 4.0 / halves.noise() - 1.0).abs() < 0.2);
    }
}
