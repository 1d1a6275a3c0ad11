//! How far is a picture from the right one?

use crate::picture::Picture;
use glam::DVec3;

/// What one picture is beside a reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PictureError {
    /// Root mean square of the differences over all pixels and colours, over the mean of the reference.
    pub relative_rmse: f64,
    /// Mean of the picture over the mean of the reference.
    pub mean_ratio: f64,
}

/// Compares a picture with a reference of the same size; `None` where sizes differ, infinite where the reference is black.
///
/// A pixel that is not finite makes both figures so.
pub fn picture_error(picture: &Picture, reference: &Picture) -> Option<PictureError> {
    if (picture.width, picture.height) != (reference.width, reference.height) {
        return None;
    }
    let grey = |c: DVec3| (c.x + c.y + c.z) / 3.0;
    let (mut squares, mut sum, mut reference_sum) = (0.0, 0.0, 0.0);
    for (a, b) in picture.pixels.iter().zip(&reference.pixels) {
        let (a, b) = (a.as_dvec3(), b.as_dvec3());
        squares += (a - b).length_squared() / 3.0;
        sum += grey(a);
        reference_sum += grey(b);
    }
    let pixels = picture.pixels.len().max(1) as f64;
    Some(PictureError {
        relative_rmse: (squares / pixels).sqrt() / (reference_sum / pixels),
        mean_ratio: sum / reference_sum,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn grey(values: [f32; 4]) -> Picture {
        Picture { width: 2, height: 2, pixels: values.map(Vec3::splat).to_vec() }
    }

    #[test]
    fn figures_are_those_of_the_definition() {
        let reference = grey([1.0, 1.0, 3.0, 3.0]);
        let same = picture_error(&reference, &reference).unwrap();
        assert_eq!((same.relative_rmse, same.mean_ratio), (0.0, 1.0));
        let other = picture_error(&grey([2.0, 0.0, 3.0, 3.0]), &reference).unwrap();
        // √(2/4)/2
        assert!((other.relative_rmse - 0.353_553_39).abs() < 1e-8 && other.mean_ratio == 1.0);
        assert_eq!(picture_error(&grey([2.0, 2.0, 6.0, 6.0]), &reference).unwrap().mean_ratio, 2.0);
    }

    #[test]
    fn bad_pixels_and_sizes_show() {
        let reference = grey([1.0; 4]);
        let bad = picture_error(&grey([1.0, f32::NAN, 1.0, 1.0]), &reference).unwrap();
        assert!(bad.relative_rmse.is_nan() && bad.mean_ratio.is_nan());
        let wide = Picture { width: 4, height: 1, pixels: reference.pixels.clone() };
        assert!(picture_error(&wide, &reference).is_none());
    }
}
