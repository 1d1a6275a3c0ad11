//! What is the vector algebra of the float64 oracles?
#![allow(dead_code)]

use std::ops::{Add, Mul, Sub};

/// A float64 vector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Vector(pub [f64; 3]);

/// The float64 vector of an f32 one.
pub fn exact(v: glam::Vec3) -> Vector {
    Vector(v.to_array().map(f64::from))
}

impl Vector {
    /// a·b.
    pub fn dot(self, b: Self) -> f64 {
        self.0[0] * b.0[0] + self.0[1] * b.0[1] + self.0[2] * b.0[2]
    }

    /// a × b.
    pub fn cross(self, b: Self) -> Self {
        let (a, b) = (self.0, b.0);
        Self([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])
    }

    /// |a|.
    pub fn length(self) -> f64 {
        self.dot(self).sqrt()
    }
}

impl Add for Vector {
    type Output = Self;
    fn add(self, b: Self) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] + b.0[i]))
    }
}

impl Sub for Vector {
    type Output = Self;
    fn sub(self, b: Self) -> Self {
        Self([0, 1, 2].map(|i| self.0[i] - b.0[i]))
    }
}

impl Mul<f64> for Vector {
    type Output = Self;
    fn mul(self, k: f64) -> Self {
        Self(self.0.map(|x| x * k))
    }
}
