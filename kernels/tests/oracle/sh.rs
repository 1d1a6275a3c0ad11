//! What are the spherical-harmonic operators in float64, and how are their tables generated?
//!
//! Free of dependencies: the log-occlusion and optimal-linear generators can be moved into a host crate.
#![allow(dead_code)]
// Matrix algebra reads best with indices.
#![allow(clippy::needless_range_loop)]

use std::f64::consts::PI;

/// sqrt(4π): the constant function 1 is (S4, 0, 0, …).
pub fn s4() -> f64 {
    (4.0 * PI).sqrt()
}

/// A dense square matrix, row by row.
pub type Matrix = Vec<Vec<f64>>;

/// The associated Legendre function without the extra sign, P_l^m(z) for unit (x, y, z) divided by (1 − z²)^(m/2).
fn legendre_derivative(l: usize, m: usize, z: f64) -> f64 {
    let mut previous = 0.0;
    let mut current: f64 = (1..=m).map(|k| (2 * k - 1) as f64).product();
    for n in m..l {
        let next = ((2 * n + 1) as f64 * z * current - (n + m) as f64 * previous) / (n + 1 - m) as f64;
        previous = current;
        current = next;
    }
    current
}

/// The n² basis functions at a unit direction, from the definition (not from the polynomials of the kernels).
pub fn basis(order: usize, d: [f64; 3]) -> Vec<f64> {
    let factorial = |n: usize| -> f64 { (1..=n).map(|k| k as f64).product() };
    let mut y = vec![0.0; order * order];
    for l in 0..order {
        // (x + iy)^m holds (1 − z²)^(m/2) cos mφ and sin mφ.
        let (mut re, mut im) = (1.0, 0.0);
        for m in 0..=l {
            let k = ((2 * l + 1) as f64 / (4.0 * PI) * factorial(l - m) / factorial(l + m)).sqrt();
            let p = k * legendre_derivative(l, m, d[2]);
            if m == 0 {
                y[l * l + l] = p;
            } else {
                let scale = if m % 2 == 0 { 2f64.sqrt() } else { -(2f64.sqrt()) } * p;
                y[l * l + l + m] = scale * re;
                y[l * l + l - m] = scale * im;
            }
            (re, im) = (re * d[0] - im * d[1], re * d[1] + im * d[0]);
        }
    }
    y
}

/// P_l(z).
pub fn legendre(l: usize, z: f64) -> f64 {
    legendre_derivative(l, 0, z)
}

/// Nodes and weights of Gauss-Legendre quadrature on [−1, 1].
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    (0..count)
        .map(|i| {
            let mut x = (PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
            for _ in 0..100 {
                let derivative = legendre_derivative(count, 1, x);
                let step = legendre(count, x) / derivative;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            let derivative = legendre_derivative(count, 1, x);
            (x, 2.0 / ((1.0 - x * x) * derivative * derivative))
        })
        .collect()
}

/// Directions and weights that integrate polynomials up to degree 2·count − 1 over the sphere.
pub fn sphere_quadrature(count: usize) -> Vec<([f64; 3], f64)> {
    let mut points = Vec::new();
    for (z, w) in gauss_legendre(count) {
        for k in 0..2 * count {
            let phi = PI * (k as f64 + 0.5) / count as f64;
            let r = (1.0 - z * z).sqrt();
            points.push(([r * phi.cos(), r * phi.sin(), z], w * PI / count as f64));
        }
    }
    points
}

/// The unique non-zero triple products (i ≤ j ≤ k, ∫ y_i y_j y_k), ordered by k, then j, then i.
///
/// Ordered so that the list of a lower order is a prefix of that of a higher one.
pub fn triples(order: usize) -> Vec<(usize, usize, usize, f64)> {
    let points: Vec<_> =
        sphere_quadrature(3 * order / 2 + 2).into_iter().map(|(d, w)| (basis(order, d), w)).collect();
    let mut list = Vec::new();
    for k in 0..order * order {
        for j in 0..=k {
            for i in 0..=j {
                let v: f64 = points.iter().map(|(y, w)| w * y[i] * y[j] * y[k]).sum();
                if v.abs() > 1e-12 {
                    list.push((i, j, k, v));
                }
            }
        }
    }
    list
}

/// The distinct orderings of (i, j, k).
pub fn orderings(i: usize, j: usize, k: usize) -> Vec<(usize, usize, usize)> {
    let mut all = vec![(i, j, k), (i, k, j), (j, i, k), (j, k, i), (k, i, j), (k, j, i)];
    all.sort_unstable();
    all.dedup();
    all
}

/// SH algebra of one order.
pub struct Algebra {
    /// The order n; vectors have n² coefficients.
    pub order: usize,
    ordered: Vec<(usize, usize, usize, f64)>,
}

impl Algebra {
    /// Integrates the triple products.
    pub fn new(order: usize) -> Self {
        let mut ordered = Vec::new();
        for (i, j, k, v) in triples(order) {
            for (a, b, c) in orderings(i, j, k) {
                ordered.push((a, b, c, v));
            }
        }
        Self { order, ordered }
    }

    /// How many ordered triples do not vanish.
    pub fn ordered_count(&self) -> usize {
        self.ordered.len()
    }

    /// The truncated product.
    pub fn product(&self, a: &[f64], b: &[f64]) -> Vec<f64> {
        let mut out = vec![0.0; a.len()];
        for &(i, j, k, v) in &self.ordered {
            out[i] += v * a[j] * b[k];
        }
        out
    }

    /// M_g with (M_g)_ij = Σ_k Γ_ijk g_k.
    pub fn matrix(&self, g: &[f64]) -> Matrix {
        let n = g.len();
        let mut m = vec![vec![0.0; n]; n];
        for &(i, j, k, v) in &self.ordered {
            m[i][j] += v * g[k];
        }
        m
    }

    /// φ(M_g) 1 for a function φ of the eigenvalues, and the range of the eigenvalues.
    fn spectral(&self, g: &[f64], phi: impl Fn(f64) -> f64) -> (Vec<f64>, f64, f64) {
        let n = g.len();
        let (values, vectors) = symmetric_eigen(self.matrix(g));
        let mut out = vec![0.0; n];
        for e in 0..n {
            let scale = phi(values[e]) * vectors[0][e] * s4();
            for i in 0..n {
                out[i] += scale * vectors[i][e];
            }
        }
        let min = values.iter().copied().fold(f64::INFINITY, f64::min);
        let max = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        (out, min, max)
    }

    /// exp*(f) = exp(M_f) 1.
    pub fn exponential(&self, f: &[f64]) -> Vec<f64> {
        self.spectral(f, f64::exp).0
    }

    /// log*(g) with the eigenvalues clipped at `epsilon` from below; and the unclipped range of eigenvalues.
    pub fn logarithm(&self, g: &[f64], epsilon: f64) -> (Vec<f64>, f64, f64) {
        self.spectral(g, |w| w.max(epsilon).ln())
    }

    /// The robust HYB of order n: (g, halvings p); unclamped when `clamped` is false.
    pub fn hybrid(&self, f: &[f64], tau: f64, clamped: bool) -> (Vec<f64>, u32) {
        let mut x = norm(&f[1..]);
        let mut p = 0;
        while x > tau && p < 12 {
            x *= 0.5;
            p += 1;
        }
        let h: Vec<f64> = f.iter().map(|c| c * 0.5f64.powi(p as i32)).collect();
        let (a, b) = small_optimal_linear(self.order, x);
        let e = (h[0] / s4()).exp();
        let mut g: Vec<f64> = h.iter().map(|c| e * b * c).collect();
        g[0] = e * a * s4();
        for step in 0..=p {
            if step > 0 {
                g = self.product(&g, &g);
            }
            if clamped {
                clamp_to_feasible(&mut g);
            }
        }
        (g, p)
    }
}

/// a(x) and b(x) of the optimal linear exponential for x ≤ 0.5 (orders 3 to 5).
pub fn small_optimal_linear(order: usize, x: f64) -> (f64, f64) {
    let c: [f64; 5] = match order {
        3 => [-0.004165, 0.000319, -0.156730, 0.017518, 0.002318],
        4 => [-0.006951, 0.000425, -0.260291, 0.018923, 0.017607],
        _ => [-0.009653, 0.000931, -0.360671, 0.038317, 0.031593],
    };
    let a = 1.0 + x * x * (1.0 / (8.0 * PI) + x * (c[0] + x * c[1]));
    (a, 1.0 + x * (c[2] + x * (c[3] + x * c[4])))
}

/// Moves g into the ball that holds every projection of a function with values in [0, 1].
pub fn clamp_to_feasible(g: &mut [f64]) {
    g[0] = g[0].clamp(0.0, s4());
    let limit = g[0] * (s4() - g[0]);
    let q: f64 = g[1..].iter().map(|x| x * x).sum();
    if q > limit {
        let scale = (limit / q).sqrt();
        for x in &mut g[1..] {
            *x *= scale;
        }
    }
}

/// Euclidean norm.
pub fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by cyclic Jacobi rotations.
pub fn symmetric_eigen(mut m: Matrix) -> (Vec<f64>, Matrix) {
    let n = m.len();
    let mut v: Matrix = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _ in 0..60 {
        let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| m[i][j] * m[i][j]).sum();
        if off < 1e-300 {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if m[p][q] == 0.0 {
                    continue;
                }
                let theta = (m[q][q] - m[p][p]) / (2.0 * m[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let t = if theta == 0.0 { 1.0 } else { t };
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for k in 0..n {
                    (m[k][p], m[k][q]) = (c * m[k][p] - s * m[k][q], s * m[k][p] + c * m[k][q]);
                }
                for k in 0..n {
                    (m[p][k], m[q][k]) = (c * m[p][k] - s * m[q][k], s * m[p][k] + c * m[q][k]);
                }
                for k in 0..n {
                    (v[k][p], v[k][q]) = (c * v[k][p] - s * v[k][q], s * v[k][p] + c * v[k][q]);
                }
            }
        }
    }
    ((0..n).map(|i| m[i][i]).collect(), v)
}

/// Inverse by Gauss-Jordan elimination with pivoting.
pub fn inverse(mut m: Matrix) -> Matrix {
    let n = m.len();
    for (i, row) in m.iter_mut().enumerate() {
        row.extend((0..n).map(|j| f64::from(u8::from(i == j))));
    }
    for c in 0..n {
        let pivot = (c..n).max_by(|&a, &b| m[a][c].abs().total_cmp(&m[b][c].abs())).unwrap();
        m.swap(c, pivot);
        let scale = 1.0 / m[c][c];
        m[c].iter_mut().for_each(|x| *x *= scale);
        for r in 0..n {
            let factor = m[r][c];
            if r != c && factor != 0.0 {
                for k in 0..2 * n {
                    m[r][k] -= factor * m[c][k];
                }
            }
        }
    }
    m.into_iter().map(|row| row[n..].to_vec()).collect()
}

/// The zonal coefficients of a cap of key u = 1 − cos θ, divided by u (so that u = 0 has its limit).
pub fn cap_zonal_over_key(order: usize, u: f64) -> Vec<f64> {
    let c = 1.0 - u;
    (0..order)
        .map(|l| {
            if l == 0 {
                return PI.sqrt();
            }
            let k = ((2 * l + 1) as f64 / (4.0 * PI)).sqrt();
            2.0 * PI * k / (l * (l + 1)) as f64 * (2.0 - u) * legendre_derivative(l, 1, c)
        })
        .collect()
}

/// u = 1 − cos θ of the cap that a sphere of α = sin θ covers.
pub fn key(alpha: f64) -> f64 {
    alpha * alpha / (1.0 + ((1.0 - alpha) * (1.0 + alpha)).sqrt())
}

/// The zonal coefficients of 1 − cap as a full SH vector around +z.
pub fn visibility(order: usize, u: f64) -> Vec<f64> {
    let mut g = vec![0.0; order * order];
    for (l, v) in cap_zonal_over_key(order, u).into_iter().enumerate() {
        g[l * l + l] = -u * v;
    }
    g[0] += s4();
    g
}

/// The m = 0 entries of an SH vector.
pub fn zonal_part(f: &[f64], order: usize) -> Vec<f64> {
    (0..order).map(|l| f[l * l + l]).collect()
}

/// Where eigenvalues of the product matrix are clipped.
pub const EPSILON: f64 = 0.02;

/// The log-occlusion table: per entry e the n zonal coefficients of log*(1 − cap)/u at u = e/(entries − 1).
pub fn log_occlusion_table(algebra: &Algebra, entries: usize) -> Vec<f32> {
    let n = algebra.order;
    let mut table = Vec::with_capacity(entries * n);
    for e in 0..entries {
        let u = e as f64 / (entries - 1) as f64;
        let over_u: Vec<f64> = if e == 0 {
            cap_zonal_over_key(n, 0.0).iter().map(|v| -v).collect()
        } else {
            let (f, _, _) = algebra.logarithm(&visibility(n, u), EPSILON);
            zonal_part(&f, n).iter().map(|c| c / u).collect()
        };
        table.extend(over_u.iter().map(|&c| c as f32));
    }
    table
}

/// |f^|, a and b of the optimal linear exponential of one cap.
pub fn optimal_linear_of_cap(algebra: &Algebra, alpha: f64) -> (f64, f64, f64) {
    let n = algebra.order;
    let (mut f, _, _) = algebra.logarithm(&visibility(n, key(alpha)), EPSILON);
    f[0] = 0.0;
    let x = norm(&f);
    let g = algebra.exponential(&f);
    let overlap: f64 = (1..f.len()).map(|i| g[i] * f[i]).sum();
    (x, g[0] / s4(), if x > 0.0 { overlap / (x * x) } else { 1.0 })
}

/// The optimal linear table: interleaved a and b at |f^| = 0, step, 2·step, … up to the cap of `alpha_max`.
pub fn optimal_linear_table(algebra: &Algebra, step: f64, alpha_max: f64) -> Vec<f64> {
    let x_max = optimal_linear_of_cap(algebra, alpha_max).0;
    let mut table = vec![1.0, 1.0];
    let mut x = step;
    while x <= x_max {
        let (mut low, mut high) = (0.0, alpha_max);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if optimal_linear_of_cap(algebra, middle).0 < x { low = middle } else { high = middle }
        }
        let (_, a, b) = optimal_linear_of_cap(algebra, high);
        table.extend([a, b]);
        x += step;
    }
    table
}

/// Directions of the zonal lobes that rotation is built on, renormalised.
pub fn lobe_directions() -> Vec<[f64; 3]> {
    const SEARCHED: [[f64; 3]; 9] = [
        [-0.11165822, 0.83196509, -0.54347634],
        [-0.70612668, 0.66436328, -0.24496233],
        [0.34620586, 0.17162875, 0.92232590],
        [-0.05311074, 0.74829299, 0.66123888],
        [-0.54522354, -0.62369495, -0.56012132],
        [0.80843272, -0.18473336, 0.55884713],
        [-0.06241999, -0.99781679, -0.02157320],
        [0.33051422, -0.94345250, -0.02564626],
        [-0.53906147, 0.40139308, -0.74047034],
    ];
    SEARCHED
        .iter()
        .map(|d| {
            let r = norm(d);
            d.map(|c| c / r)
        })
        .collect()
}

/// A_l^-T with A_l[j][m] = y_lm(d_j): turns the coefficients of band l into those of its lobes.
pub fn lobe_matrix(l: usize) -> Matrix {
    let width = 2 * l + 1;
    let directions = lobe_directions();
    let transposed: Matrix =
        (0..width).map(|m| (0..width).map(|j| basis(l + 1, directions[j])[l * l + m]).collect()).collect();
    inverse(transposed)
}

/// ∫ over the sphere of (Σ f y − h)², as a root of the mean, for a plain function h.
pub fn rms_against(f: &[f64], order: usize, count: usize, h: impl Fn([f64; 3]) -> f64) -> f64 {
    let mut sum = 0.0;
    for (d, w) in sphere_quadrature(count) {
        let value: f64 = basis(order, d).iter().zip(f).map(|(y, c)| y * c).sum();
        sum += w * (value - h(d)).powi(2);
    }
    (sum / (4.0 * PI)).sqrt()
}
