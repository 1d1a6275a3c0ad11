//! Which random inputs do tests draw? Log-uniform magnitudes mixed with special values, from a printed seed.
#![allow(dead_code)]

use glam::{UVec4, Vec3, Vec4};
use proptest::prelude::*;
use proptest::sample::select;
use proptest::strategy::ValueTree;
use proptest::test_runner::{Config, RngAlgorithm, TestRng, TestRunner};

/// Used unless `TWINLIGHT_SEED` says otherwise.
const SEED: u64 = 20_261_123;

/// Values at which formulas change branch, saturate or lose digits; no denormals, which devices may flush.
const SPECIAL: [f32; 19] = [
    0.0,
    -0.0,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1.0,
    -1.0,
    1.0 + f32::EPSILON,
    1.0 - f32::EPSILON,
    0.5,
    -0.5,
    16_777_215.0,
    16_777_217.0,
    -16_777_217.0,
    1e9,
    1e18,
    -1e18,
    3.4e38,
    -3.4e38,
    0.25,
];

/// A source of random inputs.
pub struct Draw {
    runner: TestRunner,
}

impl Draw {
    /// Starts a stream of its own for each `name`; prints the seed.
    pub fn new(name: &str) -> Self {
        let seed = match std::env::var("TWINLIGHT_SEED") {
            Ok(text) => text.parse().expect("TWINLIGHT_SEED is an unsigned integer"),
            Err(_) => SEED,
        };
        println!("{name}: TWINLIGHT_SEED={seed}");
        let mut bytes = [0u8; 32];
        bytes[..8].copy_from_slice(&seed.to_le_bytes());
        for (i, b) in name.bytes().enumerate() {
            let at = 8 + i % 24;
            bytes[at] = bytes[at].wrapping_mul(31).wrapping_add(b);
        }
        let rng = TestRng::from_seed(RngAlgorithm::ChaCha, &bytes);
        Self { runner: TestRunner::new_with_rng(Config::default(), rng) }
    }

    /// One value of a strategy.
    pub fn of<S: Strategy>(&mut self, strategy: &S) -> S::Value {
        strategy.new_tree(&mut self.runner).expect("the strategy rejects nothing").current()
    }

    /// Uniform in [low, high).
    pub fn uniform(&mut self, low: f32, high: f32) -> f32 {
        self.of(&(low..high))
    }

    /// Uniform in [low, high).
    pub fn integer(&mut self, low: u32, high: u32) -> u32 {
        self.of(&(low..high))
    }

    /// True once in `times`.
    pub fn rarely(&mut self, times: u32) -> bool {
        self.integer(0, times) == 0
    }

    /// Any word; often a small one.
    pub fn word(&mut self) -> u32 {
        self.of(
            &prop_oneof![4 => any::<u32>(), 2 => 0u32..1000, 1 => Just(u32::MAX), 1 => Just(0x8000_0000u32)],
        )
    }

    /// Any four words.
    pub fn words(&mut self) -> UVec4 {
        UVec4::new(self.word(), self.word(), self.word(), self.word())
    }

    /// Log-uniform in [low, high] (both positive), with special values of that range mixed in; 0 among them.
    pub fn positive(&mut self, low: f32, high: f32) -> f32 {
        if self.rarely(8) {
            let value = self.of(&select(&SPECIAL[..])).abs();
            if value == 0.0 || (low..=high).contains(&value) {
                return value;
            }
        }
        let exponent = self.of(&(f64::from(low).ln()..f64::from(high).ln()));
        exponent.exp() as f32
    }

    /// The same with either sign.
    pub fn number(&mut self, low: f32, high: f32) -> f32 {
        let magnitude = self.positive(low, high);
        if self.of(&any::<bool>()) { magnitude } else { -magnitude }
    }

    /// Four of [`Draw::number`].
    pub fn numbers(&mut self, low: f32, high: f32) -> Vec4 {
        Vec4::new(
            self.number(low, high),
            self.number(low, high),
            self.number(low, high),
            self.number(low, high),
        )
    }

    /// Uniform in [0, 1] with both ends, a half and their neighbours mixed in.
    pub fn unit(&mut self) -> f32 {
        const EDGES: [f32; 6] = [0.0, 1.0, 0.5, 0.25, 5.960_464_5e-8, 0.999_999_94];
        self.of(&prop_oneof![7 => 0.0f32..1.0, 1 => select(&EDGES[..])])
    }

    /// Four of [`Draw::unit`].
    pub fn units(&mut self) -> Vec4 {
        Vec4::new(self.unit(), self.unit(), self.unit(), self.unit())
    }

    /// A point of a cube around the origin; sometimes on a plane, an axis or a corner of the integer grid.
    pub fn point(&mut self, extent: f32) -> Vec3 {
        let p = Vec3::new(
            self.uniform(-extent, extent),
            self.uniform(-extent, extent),
            self.uniform(-extent, extent),
        );
        if self.rarely(8) { p.round() } else { p }
    }

    /// A unit vector; sometimes an axis, a diagonal, or with one tiny component.
    pub fn direction(&mut self) -> Vec3 {
        let mut v = Vec3::ZERO;
        while v.length_squared() < 0.01 || v.length_squared() > 1.0 {
            v = Vec3::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0));
        }
        match self.integer(0, 24) {
            0 => v = Vec3::new(0.0, 0.0, v.z),
            1 => v = Vec3::new(0.0, v.y, 0.0),
            2 => v = Vec3::new(v.x, 0.0, v.z),
            3 => v = Vec3::ONE.copysign(v),
            4 => v.z = self.number(1e-12, 1e-6),
            _ => {}
        }
        if v.length_squared() == 0.0 {
            return Vec3::Y;
        }
        v.as_dvec3().normalize().as_vec3()
    }
}
