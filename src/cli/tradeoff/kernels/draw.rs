//! Which random inputs are measured? The same ones every time.

use glam::Vec3;

/// A small deterministic generator (PCG).
pub(super) struct Random(u64);

impl Random {
    /// A generator with a stream of its own for each name.
    pub(super) fn new(name: &str) -> Self {
        let seed = name
            .bytes()
            .fold(0xCBF2_9CE4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x0000_0100_0000_01B3));
        let mut random = Self(seed | 1);
        random.bits();
        random
    }

    /// 32 random bits.
    pub(super) fn bits(&mut self) -> u32 {
        let old = self.0;
        self.0 = old.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let mixed = (((old >> 18) ^ old) >> 27) as u32;
        mixed.rotate_right((old >> 59) as u32)
    }

    /// A number in [0, 1).
    pub(super) fn unit(&mut self) -> f64 {
        f64::from(self.bits()) / 4_294_967_296.0
    }

    /// A number in [low, high].
    pub(super) fn range(&mut self, low: f64, high: f64) -> f32 {
        (low + (high - low) * self.unit()) as f32
    }

    /// A positive number, log-uniform in [low, high].
    pub(super) fn positive(&mut self, low: f64, high: f64) -> f32 {
        (low.ln() + (high / low).ln() * self.unit()).exp() as f32
    }

    /// The same with either sign.
    pub(super) fn signed(&mut self, low: f64, high: f64) -> f32 {
        let x = self.positive(low, high);
        if self.bits() & 1 == 0 { x } else { -x }
    }

    /// A point of the cube [−size, size]³.
    pub(super) fn point(&mut self, size: f64) -> Vec3 {
        Vec3::new(self.range(-size, size), self.range(-size, size), self.range(-size, size))
    }

    /// A unit direction, rounded.
    pub(super) fn direction(&mut self) -> Vec3 {
        let z = 2.0 * self.unit() - 1.0;
        let (sine, cosine) = (self.unit() * std::f64::consts::TAU).sin_cos();
        let r = (1.0 - z * z).sqrt();
        glam::DVec3::new(r * cosine, r * sine, z).as_vec3()
    }
}

/// `count` values that `one` makes.
pub(super) fn list<T>(name: &str, count: usize, mut one: impl FnMut(&mut Random) -> T) -> Vec<T> {
    let mut random = Random::new(name);
    (0..count).map(|_| one(&mut random)).collect()
}
