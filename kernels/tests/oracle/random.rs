//! Which inputs are tried?
#![allow(dead_code)]

use glam::Vec3;

/// A small deterministic generator (PCG); its seed is printed so that a failure can be repeated.
pub struct Random(u64);

impl Random {
    /// A generator with this seed, which is printed.
    pub fn new(seed: u64) -> Self {
        println!("seed {seed}");
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        let old = self.0;
        self.0 = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let xorshifted = (((old >> 18) ^ old) >> 27) as u32;
        xorshifted.rotate_right((old >> 59) as u32)
    }

    /// An integer in 0..n.
    pub fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.bits()) * u64::from(n)) >> 32) as u32
    }

    /// A number in [0, 1) with 24 bits.
    pub fn unit(&mut self) -> f32 {
        (self.bits() >> 8) as f32 * 2f32.powi(-24)
    }

    /// A number in [low, high).
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// A number of either sign whose magnitude is log-uniform in [low, high].
    pub fn log_uniform(&mut self, low: f32, high: f32) -> f32 {
        let magnitude = self.range(low.ln(), high.ln()).exp();
        if self.bits() & 1 == 0 { magnitude } else { -magnitude }
    }

    /// A point of the cube [−size, size]³.
    pub fn point(&mut self, size: f32) -> Vec3 {
        Vec3::new(self.range(-size, size), self.range(-size, size), self.range(-size, size))
    }

    /// A direction of length about 1; one in four has zero, equal or tiny components.
    pub fn direction(&mut self) -> Vec3 {
        loop {
            let mut v = self.point(1.0);
            match self.below(16) {
                0 => v.x = 0.0,
                1 => v.y = -0.0,
                2 => v = Vec3::new(0.0, 0.0, v.z),
                3 => v.z = v.x,
                _ => {}
            }
            let length = v.length();
            if length > 1e-3 && length <= 1.0 {
                return v / length;
            }
        }
    }
}

/// The edge list that is mixed into random inputs.
pub const SPECIAL: [f32; 22] = [
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1.0,
    -1.0,
    1.000_000_1,
    0.999_999_94,
    0.5,
    -0.5,
    16_777_215.0,
    16_777_216.0,
    1e18,
    -1e18,
    3.4e38,
    -3.4e38,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
    1e-20,
];

/// The finite part of [`SPECIAL`] that may come in after sanitising (|x| ≤ 1e18).
pub const SANITISED: usize = 16;
