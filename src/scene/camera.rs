//! Where does the picture look from, and which ray belongs to a pixel?

use super::{Bounds, MAX_VALUE};
use crate::error::SceneError;
use glam::{DVec3, Vec3};

/// A perspective camera in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Position, metres.
    pub eye: Vec3,
    /// A point that projects to the middle of the picture, metres; different from `eye`.
    pub target: Vec3,
    /// A direction that points upwards in the picture; not parallel to the view, of any length but 0.
    pub up: Vec3,
    /// Full vertical angle of view in degrees, between 0 and 180 exclusively.
    pub fov: f32,
}

/// The orthonormal axes of a valid camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraFrame {
    /// Position, metres.
    pub eye: Vec3,
    /// Unit vector to the right in the picture.
    pub right: Vec3,
    /// Unit vector upwards in the picture.
    pub up: Vec3,
    /// Unit vector into the picture.
    pub forward: Vec3,
    /// Tangent of half the vertical angle of view, positive.
    pub tan_half_fov: f32,
}

impl Camera {
    /// Returns a camera that sees the whole box in a picture at least as wide as high, from the front (+z).
    ///
    /// Looks level into boxes that are high, and down from 25° at ones that are flat.
    pub fn framing(bounds: &Bounds) -> Self {
        let size = bounds.size().as_dvec3();
        let centre = bounds.centre().as_dvec3();
        let widest = size.x.max(size.z);
        let fov: f64 = 40.0;
        let tangent = (0.5 * fov).to_radians().tan();
        let elevation = if size.y < 0.6 * widest { 25.0f64.to_radians() } else { 0.0 };
        let (sin, cos) = elevation.sin_cos();
        // Half extents of the turned box across, upwards and towards the eye.
        let across = 0.5 * size.x;
        let upwards = 0.5 * (size.y * cos + size.z * sin);
        let towards = 0.5 * (size.y * sin + size.z * cos);
        let distance = across.max(upwards) * 1.05 / tangent + towards;
        let scale = centre.abs().max_element().max(1.0e-3);
        let distance = if distance > 1.0e-6 * scale { distance } else { scale };
        let eye = centre + DVec3::new(0.0, sin, cos) * distance;
        Self { eye: eye.as_vec3(), target: centre.as_vec3(), up: Vec3::Y, fov: fov as f32 }
    }

    /// Returns the camera's axes.
    ///
    /// # Errors
    /// Values that are not finite or beyond 8e18, eye and target at the same point, up parallel to the view (within 1e-6) or 0,
    /// an angle of view outside (0, 180).
    pub fn frame(&self) -> Result<CameraFrame, SceneError> {
        let error = |reason: &str| Err(SceneError::Camera { reason: reason.into() });
        // From where the largest scene is seen whole.
        let in_range = |v: Vec3| v.to_array().iter().all(|x| x.abs() <= 8.0 * MAX_VALUE);
        if !(in_range(self.eye) && in_range(self.target) && in_range(self.up)) {
            return error(
                "a coordinate of eye, target or up is not finite or beyond 8e18; give three finite numbers each",
            );
        }
        if !(self.fov > 0.0 && self.fov < 180.0) {
            return error("the angle of view is not between 0 and 180 degrees; 40 to 60 is usual");
        }
        let view = self.target.as_dvec3() - self.eye.as_dvec3();
        let Some(forward) = view.try_normalize() else {
            return error("eye and target are the same point; move one of them");
        };
        let Some(up) = self.up.as_dvec3().try_normalize() else {
            return error("up has length 0; 0,1,0 is usual");
        };
        let right = forward.cross(up);
        if right.length() < 1.0e-6 {
            return error("up is parallel to the direction of view; give another, such as 0,0,-1");
        }
        let right = right.normalize();
        Ok(CameraFrame {
            eye: self.eye,
            right: right.as_vec3(),
            up: right.cross(forward).as_vec3(),
            forward: forward.as_vec3(),
            tan_half_fov: (0.5 * f64::from(self.fov)).to_radians().tan() as f32,
        })
    }
}

impl CameraFrame {
    /// Returns the ray through a point of a picture of `width` × `height` pixels: its direction, of length ≥ 1.
    ///
    /// `x` and `y` are in pixels from the left and top edge: the centre of pixel (i, j) is (i + 0.5, j + 0.5). The
    /// component along [`CameraFrame::forward`] is 1, so t along the ray is depth.
    pub fn direction(&self, x: f32, y: f32, width: u32, height: u32) -> Vec3 {
        let (w, h) = (width.max(1) as f32, height.max(1) as f32);
        let across = (2.0 * x / w - 1.0) * (w / h) * self.tan_half_fov;
        let upwards = (1.0 - 2.0 * y / h) * self.tan_half_fov;
        self.right * across + self.up * upwards + self.forward
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn camera() -> Camera {
        Camera { eye: Vec3::new(0.0, 1.0, 3.0), target: Vec3::new(0.0, 1.0, 0.0), up: Vec3::Y, fov: 90.0 }
    }

    #[test]
    fn column_0_is_left_and_row_0_is_top() {
        let frame = camera().frame().unwrap();
        assert_eq!((frame.right, frame.up, frame.forward), (Vec3::X, Vec3::Y, -Vec3::Z));
        let corner = frame.direction(0.0, 0.0, 200, 100);
        assert!((corner - Vec3::new(-2.0, 1.0, -1.0)).length() < 1e-6, "{corner}");
        assert_eq!(frame.direction(100.0, 50.0, 200, 100), -Vec3::Z);
    }

    #[test]
    fn impossible_cameras_are_refused() {
        let cases = [
            (Camera { target: camera().eye, ..camera() }, "same point"),
            (Camera { up: Vec3::Z * -5.0, ..camera() }, "parallel"),
            (Camera { up: Vec3::ZERO, ..camera() }, "length 0"),
            (Camera { fov: 180.0, ..camera() }, "angle"),
            (Camera { fov: f32::NAN, ..camera() }, "angle"),
            (Camera { eye: Vec3::NAN, ..camera() }, "finite"),
        ];
        for (camera, word) in cases {
            let message = camera.frame().unwrap_err().to_string();
            assert!(message.contains(word) && !message.contains('\n'), "{message}");
        }
    }

    #[test]
    fn framing_shows_every_corner() {
        let boxes = [
            (Vec3::new(-1.0, 0.0, -1.0), Vec3::new(1.0, 2.0, 1.0)),
            (Vec3::new(-19.0, -1.0, -12.0), Vec3::new(18.0, 14.0, 11.0)),
            (Vec3::new(5.0, 0.0, 5.0), Vec3::new(9.0, 0.0, 9.0)),
            (Vec3::splat(7.0), Vec3::splat(7.0)),
            (Vec3::splat(-1e18), Vec3::splat(1e18)),
        ];
        for (min, max) in boxes {
            let frame = Camera::framing(&Bounds { min, max }).frame().unwrap();
            for corner in 0..8 {
                let pick = |bit: u32, a: f32, b: f32| if corner >> bit & 1 == 0 { a } else { b };
                let p = Vec3::new(pick(0, min.x, max.x), pick(1, min.y, max.y), pick(2, min.z, max.z));
                let v = p.as_dvec3() - frame.eye.as_dvec3();
                let depth = v.dot(frame.forward.as_dvec3()) * f64::from(frame.tan_half_fov);
                assert!(v.dot(frame.right.as_dvec3()).abs() <= depth, "{min} {max} {p}");
                assert!(v.dot(frame.up.as_dvec3()).abs() <= depth, "{min} {max} {p}");
            }
        }
    }
}
