//! Which random inputs do tests draw? Log-uniform magnitudes, unit vectors, and an edge list, from a printed seed.
#![allow(dead_code)]

/// The edge list: values at which formulas change branch, saturate or lose digits.
pub const EDGES: [f32; 22] = [
    0.0,
    -0.0,
    1e-45,
    -1e-45,
    f32::MIN_POSITIVE,
    -f32::MIN_POSITIVE,
    1.0,
    -1.0,
    1.0 - f32::EPSILON,
    1.0 + f32::EPSILON,
    0.5,
    -0.5,
    1e-7,
    1e-3,
    16_777_215.0,
    16_777_217.0,
    1e9,
    -1e9,
    1e18,
    -1e18,
    f32::MAX,
    f32::MIN,
];

/// A permuted congruential generator.
pub struct Draw(u64);

impl Draw {
    /// Starts at `seed` and prints it.
    pub fn new(seed: u64) -> Self {
        println!("seed {seed}");
        Self(seed)
    }

    /// 32 random bits.
    pub fn bits(&mut self) -> u32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let x = ((self.0 >> 18) ^ self.0) >> 27;
        (x as u32).rotate_right((self.0 >> 59) as u32)
    }

    /// Uniform in [low, high).
    pub fn uniform(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * ((self.bits() >> 8) as f32 / 16_777_216.0)
    }

    /// Log-uniform in [low, high], both positive.
    pub fn log_uniform(&mut self, low: f32, high: f32) -> f32 {
        self.uniform(low.ln(), high.ln()).exp()
    }

    /// One of the edges with probability 1/8, else log-uniform over 60 orders of magnitude with a random sign.
    pub fn wild(&mut self) -> f32 {
        if self.bits().is_multiple_of(8) {
            return EDGES[self.bits() as usize % EDGES.len()];
        }
        let magnitude = self.log_uniform(1e-30, 1e30);
        if self.bits() & 1 == 0 { magnitude } else { -magnitude }
    }

    /// Approximately normal with variance 1.
    pub fn normal(&mut self) -> f32 {
        (0..12).map(|_| self.uniform(0.0, 1.0)).sum::<f32>() - 6.0
    }

    /// A unit vector in f64, normally an arbitrary one, sometimes an axis or a diagonal.
    pub fn direction64(&mut self) -> [f64; 3] {
        loop {
            let mut v = [0.0f64; 3];
            for component in &mut v {
                *component =
                    if self.bits().is_multiple_of(16) { 0.0 } else { f64::from(self.uniform(-1.0, 1.0)) };
            }
            let square: f64 = v.iter().map(|x| x * x).sum();
            if square > 1e-3 && square <= 1.0 {
                return v.map(|x| x / square.sqrt());
            }
        }
    }

    /// A unit vector rounded to f32.
    pub fn direction(&mut self) -> [f32; 3] {
        self.direction64().map(|x| x as f32)
    }

    /// A rotation matrix in f64, as rows.
    pub fn rotation64(&mut self) -> [[f64; 3]; 3] {
        let mut q = [0.0f64; 4];
        let mut square = 0.0;
        while square < 1e-2 {
            q = [0; 4].map(|_| f64::from(self.normal()));
            square = q.iter().map(|x| x * x).sum();
        }
        let [w, x, y, z] = q.map(|c| c / square.sqrt());
        [
            [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
            [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
            [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
        ]
    }
}
