//! What would the kernels give in float64? Straightforward code, none of it the kernels'.

use crate::technique::soft_gi::gauss_legendre;
use glam::{DQuat, DVec3};
use std::f64::consts::PI;

/// √4π, the coefficient of the constant function 1.
pub(super) fn unit() -> f64 {
    (4.0 * PI).sqrt()
}

/// Distance in units in the last place of `truth` as f32, for truths below `least` in those of `least`.
pub(super) fn ulp(got: f32, truth: f64, least: f64) -> f64 {
    if f64::from(got) == truth {
        return 0.0;
    }
    let magnitude = truth.abs().max(least).max(f64::from(f32::MIN_POSITIVE));
    let unit = 2f64.powi(magnitude.log2().floor() as i32 - 23);
    (f64::from(got) - truth).abs() / unit
}

/// Share of the truth; anything but 0 is infinitely wrong for 0.
pub(super) fn relative(got: f32, truth: f64) -> f64 {
    let difference = (f64::from(got) - truth).abs();
    if difference == 0.0 { 0.0 } else { difference / truth.abs() }
}

/// The largest difference.
pub(super) fn largest(got: &[f32], truth: &[f64]) -> f64 {
    got.iter().zip(truth).map(|(a, b)| (f64::from(*a) - b).abs()).fold(0.0, f64::max)
}

/// The largest share of the truth.
pub(super) fn largest_relative(got: &[f32], truth: &[f64]) -> f64 {
    got.iter().zip(truth).map(|(a, b)| relative(*a, *b)).fold(0.0, f64::max)
}

/// 1 for a wrong result.
pub(super) fn wrong<T: PartialEq>(got: &T, truth: &T) -> f64 {
    f64::from(u8::from(got != truth))
}

/// erf: its series below 2.5, a continued fraction of 1 − erf above.
pub(super) fn erf(x: f64) -> f64 {
    let a = x.abs();
    let value = if a < 2.5 {
        let (mut term, mut sum, mut n) = (a, a, 0.0);
        while term.abs() > 1e-18 * sum.abs() {
            n += 1.0;
            term *= -a * a / n;
            sum += term / (2.0 * n + 1.0);
        }
        sum * 2.0 / PI.sqrt()
    } else {
        let fraction = (1..=60).rev().fold(0.0, |below, k| f64::from(k) * 0.5 / (a + below));
        1.0 - (-a * a).exp() / ((a + fraction) * PI.sqrt())
    };
    value.copysign(x)
}

/// Sine and cosine of whole turns: the turns beyond quarters are taken away exactly.
pub(super) fn sin_cos_turn(t: f64) -> (f64, f64) {
    let quarters = (4.0 * t).round();
    let (s, c) = ((t - 0.25 * quarters) * 2.0 * PI).sin_cos();
    match quarters.rem_euclid(4.0) as u32 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

/// Tangent, bitangent and unit direction: the shortest turn from the pole on the direction's side, of x and, with that side's sign, y.
pub(super) fn frame(direction: DVec3) -> (DVec3, DVec3, DVec3) {
    let n = direction.normalize();
    let sign = if n.z >= 0.0 { 1.0 } else { -1.0 };
    let turn = DQuat::from_rotation_arc(DVec3::Z * sign, n);
    (turn * DVec3::X, turn * DVec3::Y * sign, n)
}

/// P_l^m(z) without the extra sign, over (1 − z²)^(m/2).
fn legendre(l: usize, m: usize, z: f64) -> f64 {
    let (mut before, mut p) = (0.0, (1..=m).map(|k| (2 * k - 1) as f64).product::<f64>());
    for n in m..l {
        let next = ((2 * n + 1) as f64 * z * p - (n + m) as f64 * before) / (n + 1 - m) as f64;
        (before, p) = (p, next);
    }
    p
}

/// The basis functions at a direction, from their definition.
pub(super) fn basis(order: usize, d: [f64; 3]) -> Vec<f64> {
    let length = norm(&d);
    let d = d.map(|c| c / length);
    let factorial = |n: usize| (1..=n).map(|k| k as f64).product::<f64>();
    let mut y = vec![0.0; order * order];
    for l in 0..order {
        // (x + iy)^m holds (1 − z²)^(m/2) cos mφ and sin mφ.
        let (mut re, mut im) = (1.0, 0.0);
        for m in 0..=l {
            let k = ((2 * l + 1) as f64 / (4.0 * PI) * factorial(l - m) / factorial(l + m)).sqrt();
            let p = k * legendre(l, m, d[2]);
            let sign = if m % 2 == 0 { 1.0 } else { -1.0 };
            let scale = if m == 0 { p } else { sign * 2f64.sqrt() * p };
            y[l * l + l - m] = scale * im;
            y[l * l + l + m] = scale * re;
            (re, im) = (re * d[0] - im * d[1], re * d[1] + im * d[0]);
        }
    }
    y
}

/// Euclidean norm.
pub(super) fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Norm of the difference.
pub(super) fn distance(got: &[f32], truth: &[f64]) -> f64 {
    got.iter().zip(truth).map(|(a, b)| (f64::from(*a) - b).powi(2)).sum::<f64>().sqrt()
}

/// The numbers in float64.
pub(super) fn wide(v: &[f32]) -> Vec<f64> {
    v.iter().map(|x| f64::from(*x)).collect()
}

/// Directions and weights that integrate polynomials over the sphere.
pub(super) fn sphere(count: usize) -> Vec<([f64; 3], f64)> {
    let mut points = Vec::new();
    for (z, w) in gauss_legendre(count) {
        for k in 0..2 * count {
            let (s, c) = (PI * (k as f64 + 0.5) / count as f64).sin_cos();
            let r = (1.0 - z * z).sqrt();
            points.push(([r * c, r * s, z], w * PI / count as f64));
        }
    }
    points
}

/// Zonal coefficient l of a cap of sine α: ∫ of P_l from cos θ to 1 is (P_{l−1} − P_{l+1})/(2l + 1).
pub(super) fn cap(l: usize, alpha: f64) -> f64 {
    let c = ((1.0 - alpha) * (1.0 + alpha)).sqrt();
    let k = 2.0 * PI * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
    if l == 0 {
        return k * alpha * alpha / (1.0 + c);
    }
    k * (legendre(l - 1, 0, c) - legendre(l + 1, 0, c)) / (2 * l + 1) as f64
}

/// Zonal coefficient l of max(0, cos θ), by quadrature over the upper half.
pub(super) fn clamped_cosine(l: usize) -> f64 {
    let of = |x: f64| x * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt() * legendre(l, 0, x);
    gauss_legendre(8).into_iter().map(|(x, w)| PI * w * of(0.5 * (x + 1.0))).sum()
}

/// Where rays meet a sphere of sine α about +z, over a circle of the azimuth: sines and cosines of the ray's angle and of the
/// normal's there, and shares of solid angle over 2π.
fn met(alpha: f64) -> Vec<([f64; 2], [f64; 2], f64)> {
    let nodes = gauss_legendre(64).into_iter();
    nodes
        .map(|(x, w)| {
            // The angle at the sphere between normal and ray; the ray passes the centre at α sin φ.
            let phi = 0.25 * PI * (x + 1.0);
            let t = (alpha * phi.sin()).asin();
            let share = 0.25 * PI * w * alpha * alpha * phi.sin() * phi.cos() / t.cos();
            ([t.sin(), t.cos()], [(phi - t).sin(), -(phi - t).cos()], share)
        })
        .collect()
}

/// Zonal coefficients of what averages a function of the normal over the part of a sphere that is seen: bands 0 to 2.
pub(super) fn averaged_operator(alpha: f64) -> [f64; 3] {
    let (mut sums, mut whole) = ([0.0; 3], 0.0);
    for (_, [_, z], share) in met(alpha) {
        whole += share;
        for (l, sum) in sums.iter_mut().enumerate() {
            *sum += share * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt() * legendre(l, 0, z);
        }
    }
    sums.map(|sum| sum / whole)
}

/// What a receiver gets of a sphere about +z whose radiance is `f` of its normal, order 3.
pub(super) fn sent(alpha: f64, f: &[f64]) -> Vec<f64> {
    let mut out = vec![0.0; f.len()];
    for ([sine, cosine], [across, along], share) in met(alpha) {
        for k in 0..8 {
            let (s, c) = (PI * (f64::from(k) + 0.5) / 4.0).sin_cos();
            let normal = basis(3, [across * c, across * s, along]);
            let radiance: f64 = normal.iter().zip(f).map(|(y, c)| y * c).sum();
            let y = basis(3, [sine * c, sine * s, cosine]);
            out.iter_mut().zip(&y).for_each(|(o, y)| *o += share * PI / 4.0 * radiance * y);
        }
    }
    out
}

/// Products of one order.
pub(super) struct Algebra {
    order: usize,
    /// i, j, k and ∫ y_i y_j y_k, in every order of the three.
    triples: Vec<(usize, usize, usize, f64)>,
}

impl Algebra {
    /// Integrates the triple products.
    pub(super) fn new(order: usize) -> Self {
        let n = order * order;
        let points: Vec<_> =
            sphere(3 * order / 2 + 2).into_iter().map(|(d, w)| (basis(order, d), w)).collect();
        let mut triples = Vec::new();
        for (i, j, k) in (0..n).flat_map(|k| (0..=k).flat_map(move |j| (0..=j).map(move |i| (i, j, k)))) {
            let v: f64 = points.iter().map(|(y, w)| w * y[i] * y[j] * y[k]).sum();
            if v.abs() > 1e-12 {
                let mut all = vec![(i, j, k), (i, k, j), (j, i, k), (j, k, i), (k, i, j), (k, j, i)];
                all.sort_unstable();
                all.dedup();
                triples.extend(all.into_iter().map(|(i, j, k)| (i, j, k, v)));
            }
        }
        Self { order, triples }
    }

    /// The truncated product.
    pub(super) fn product(&self, a: &[f64], b: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; a.len()];
        for &(i, j, k, v) in &self.triples {
            out[i] += v * a[j] * b[k];
        }
        out
    }

    /// exp(M_f) 1, M_f the product with f: Taylor's series of M_f/s, applied s times.
    pub(super) fn exponential(&self, f: &[f64]) -> Vec<f64> {
        let mut rest = f.to_vec();
        rest[0] = 0.0;
        // |M_f| is at most the largest value of f, and that at most |f| n/√4π.
        let steps = (norm(&rest) * self.order as f64 / unit()).ceil().max(1.0);
        rest.iter_mut().for_each(|c| *c /= steps);
        let mut g = vec![0.0; f.len()];
        g[0] = unit();
        for _ in 0..steps as u32 {
            let mut term = g.clone();
            for k in 1..=20 {
                term = self.product(&rest, &term);
                term.iter_mut().for_each(|c| *c /= f64::from(k));
                g.iter_mut().zip(&term).for_each(|(g, t)| *g += t);
            }
        }
        let dc = (f[0] / unit()).exp();
        g.iter_mut().for_each(|c| *c *= dc);
        g
    }
}
