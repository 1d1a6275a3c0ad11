//! What is the smallest box around a set of points?

use glam::Vec3;
use twinlight_kernels::passes::scene::Triangle;

/// An axis-aligned box, metres; empty when `min` exceeds `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates.
    pub min: Vec3,
    /// Largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// The box without points.
    pub const EMPTY: Self = Self { min: Vec3::splat(f32::INFINITY), max: Vec3::splat(f32::NEG_INFINITY) };

    /// Returns the box around the corners of all triangles; [`Bounds::EMPTY`] for none.
    pub fn of(triangles: &[Triangle]) -> Self {
        triangles.iter().fold(Self::EMPTY, |all, t| all.union(Self::of_triangle(t)))
    }

    /// Returns the box around one triangle's corners, exactly.
    pub fn of_triangle(triangle: &Triangle) -> Self {
        let (a, b, c) = (triangle.p0.truncate(), triangle.p1.truncate(), triangle.p2.truncate());
        Self { min: a.min(b).min(c), max: a.max(b).max(c) }
    }

    /// Returns the smallest box around both.
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// Whether there is no point in the box.
    pub fn is_empty(&self) -> bool {
        !(self.min.x <= self.max.x && self.min.y <= self.max.y && self.min.z <= self.max.z)
    }

    /// Returns the centre; the origin for an empty box.
    pub fn centre(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.min * 0.5 + self.max * 0.5 }
    }

    /// Returns the edge lengths in metres; 0 for an empty box.
    pub fn size(&self) -> Vec3 {
        if self.is_empty() { Vec3::ZERO } else { self.max - self.min }
    }

    /// Returns half the surface area in m²; 0 for an empty box.
    pub fn half_area(&self) -> f32 {
        let s = self.size();
        s.x * s.y + s.y * s.z + s.z * s.x
    }
}
