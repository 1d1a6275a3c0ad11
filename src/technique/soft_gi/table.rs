//! Which tables do the passes of soft global illumination read, and how are they made?
//!
//! Everything about a cap around +z is zonal: the product with it keeps m, so that its logarithm is a matter of one block of as many
//! rows as there are bands.

use std::sync::OnceLock;
use twinlight_kernels::sh::EXACT_OPERATOR_WORDS;

/// Rows of the tables.
pub const ENTRIES: u32 = 64;
/// Eigenvalues of a visibility below this count as this: its logarithm exists.
const LEAST_EIGENVALUE: f64 = 0.02;
/// √4π.
const UNIT: f64 = 3.544_907_701_811_032;

/// A symmetric matrix of up to five rows, or a vector of as many numbers.
type Matrix = Vec<Vec<f64>>;

/// Nodes and weights of Gauss–Legendre quadrature on [−1, 1].
pub fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    (0..count)
        .map(|i| {
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (count as f64 + 0.5)).cos();
            let mut slope = 1.0;
            for _ in 0..100 {
                let (p, below) = legendre_pair(count, x);
                slope = count as f64 * (x * p - below) / (x * x - 1.0);
                let step = p / slope;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * slope * slope))
        })
        .collect()
}

/// P_n and P_{n−1} at x.
fn legendre_pair(n: usize, x: f64) -> (f64, f64) {
    let (mut below, mut p) = (1.0, x);
    if n == 0 {
        return (1.0, 0.0);
    }
    for k in 2..=n {
        let next = ((2 * k - 1) as f64 * x * p - (k - 1) as f64 * below) / k as f64;
        (below, p) = (p, next);
    }
    (p, below)
}

/// y_l0 at cos θ = x.
fn zonal_basis(l: usize, x: f64) -> f64 {
    ((2 * l + 1) as f64 / (4.0 * std::f64::consts::PI)).sqrt() * legendre_pair(l, x).0
}

/// The product with a zonal function, on zonal functions: M_ij = Σ_k Γ_ijk g_k.
fn product_matrix(g: &[f64]) -> Matrix {
    static NODES: OnceLock<Vec<(f64, f64)>> = OnceLock::new();
    let n = g.len();
    // Exact to degree 23: three functions of degree 4 have 12.
    let nodes = NODES.get_or_init(|| gauss_legendre(12));
    let mut m = vec![vec![0.0; n]; n];
    for &(x, w) in nodes {
        let y: Vec<f64> = (0..n).map(|l| zonal_basis(l, x)).collect();
        let value: f64 = (0..n).map(|l| g[l] * y[l]).sum();
        for i in 0..n {
            for j in 0..n {
                m[i][j] += 2.0 * std::f64::consts::PI * w * value * y[i] * y[j];
            }
        }
    }
    m
}

/// Eigenvalues and eigenvectors (columns) of a symmetric matrix, by Jacobi's rotations.
fn eigen(mut a: Matrix) -> (Vec<f64>, Matrix) {
    let n = a.len();
    let mut v: Matrix = (0..n).map(|i| (0..n).map(|j| f64::from(u8::from(i == j))).collect()).collect();
    for _ in 0..60 {
        let off: f64 = (0..n).map(|p| a[p][p + 1..].iter().map(|x| x * x).sum::<f64>()).sum();
        if off < 1e-34 {
            break;
        }
        for p in 0..n {
            for q in p + 1..n {
                if a[p][q].abs() < 1e-300 {
                    continue;
                }
                let theta = (a[q][q] - a[p][p]) / (2.0 * a[p][q]);
                let t = theta.signum() / (theta.abs() + (theta * theta + 1.0).sqrt());
                let c = 1.0 / (t * t + 1.0).sqrt();
                let s = t * c;
                for row in &mut a {
                    let (x, y) = (row[p], row[q]);
                    (row[p], row[q]) = (c * x - s * y, s * x + c * y);
                }
                let (upper, lower) = a.split_at_mut(q);
                for (x, y) in upper[p].iter_mut().zip(&mut lower[0]) {
                    (*x, *y) = (c * *x - s * *y, s * *x + c * *y);
                }
                for row in &mut v {
                    let (x, y) = (row[p], row[q]);
                    (row[p], row[q]) = (c * x - s * y, s * x + c * y);
                }
            }
        }
    }
    ((0..n).map(|i| a[i][i]).collect(), v)
}

/// f(M_g) 1 for a zonal g: a function of the product with it, applied to the constant 1.
fn spectral(g: &[f64], f: impl Fn(f64) -> f64) -> Vec<f64> {
    let (values, v) = eigen(product_matrix(g));
    let n = g.len();
    (0..n).map(|i| (0..n).map(|k| v[i][k] * f(values[k]) * v[0][k]).sum::<f64>() * UNIT).collect()
}

/// Zonal coefficients of what a cap of key u = 1 − cos θ leaves, order n.
fn visibility(order: usize, u: f64) -> Vec<f64> {
    let c = 1.0 - u;
    // ∫ of P_l from c to 1 is (P_{l−1}(c) − P_{l+1}(c))/(2l + 1).
    (0..order)
        .map(|l| {
            let k = 2.0 * std::f64::consts::PI * ((2 * l + 1) as f64 / (4.0 * std::f64::consts::PI)).sqrt();
            let cap = if l == 0 {
                k * u
            } else {
                let above = legendre_pair(l + 1, c).0;
                k * (legendre_pair(l - 1, c).0 - above) / (2 * l + 1) as f64
            };
            (if l == 0 { UNIT } else { 0.0 }) - cap
        })
        .collect()
}

/// log* of what a cap of key u leaves: zonal coefficients.
pub(crate) fn logarithm(order: usize, u: f64) -> Vec<f64> {
    spectral(&visibility(order, u), |x| x.max(LEAST_EIGENVALUE).ln())
}

/// The table of [`log_occlusion`](twinlight_kernels::sh::log_occlusion): `entries` rows of `order` numbers, log*(1 − cap)/u.
pub fn log_occlusion_table(order: usize, entries: usize) -> Vec<f32> {
    let mut table = Vec::with_capacity(order * entries);
    for e in 0..entries {
        // At 0 the limit: u so small that the next term is 10⁻⁶, and the cap still keeps ten digits.
        let u = (e as f64 / (entries - 1) as f64).max(1e-6);
        table.extend(logarithm(order, u).iter().map(|f| (f / u) as f32));
    }
    table
}

/// Pairs (a, b) of the optimal linear exponential at norms 0, 0.05, 0.1, …, fitted to the family of single caps, up to where the
/// family's norm turns.
pub fn optimal_linear_table(order: usize) -> Vec<f32> {
    const STEP: f64 = 0.05;
    // Norm, a and b along the family.
    let mut family: Vec<(f64, f64, f64)> = vec![(0.0, 1.0, 1.0)];
    for i in 1..=20_000 {
        let mut f = logarithm(order, f64::from(i) / 20_000.0);
        f[0] = 0.0;
        let norm = f.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm < family[family.len() - 1].0 {
            break;
        }
        let g = spectral(&f, f64::exp);
        let along: f64 = g.iter().zip(&f).map(|(g, f)| g * f).sum();
        family.push((norm, g[0] / UNIT, along / (norm * norm)));
    }
    let mut table = Vec::new();
    let mut at = 0;
    for k in 0.. {
        let x = STEP * f64::from(k);
        while at + 1 < family.len() && family[at + 1].0 < x {
            at += 1;
        }
        let Some(&next) = family.get(at + 1) else { break };
        let low = family[at];
        let t = if next.0 > low.0 { (x - low.0) / (next.0 - low.0) } else { 0.0 };
        table.extend([(low.1 + t * (next.1 - low.1)) as f32, (low.2 + t * (next.2 - low.2)) as f32]);
    }
    table
}

/// The table of [`exact_operator`](twinlight_kernels::sh::exact_operator): `entries` rows of M/u.
pub fn exact_operator_table(entries: usize) -> Vec<f32> {
    let nodes = gauss_legendre(24);
    let mut table = Vec::with_capacity(entries * EXACT_OPERATOR_WORDS);
    for e in 0..entries {
        let u = (e as f64 / (entries - 1) as f64).powi(2).max(1e-9);
        table.extend(exact_operator_row(u, &nodes).iter().map(|m| (m / u) as f32));
    }
    table
}

/// Associated Legendre polynomials without (1 − x²)^(m/2) and sign, times their factors: l and m up to 2.
fn basis_part(l: usize, m: usize, x: f64) -> f64 {
    let pi = std::f64::consts::PI;
    match (l, m) {
        (0, 0) => (0.25 / pi).sqrt(),
        (1, 0) => (0.75 / pi).sqrt() * x,
        (1, 1) => (0.75 / pi).sqrt(),
        (2, 0) => (5.0 / (16.0 * pi)).sqrt() * (3.0 * x * x - 1.0),
        (2, 1) => (15.0 / (4.0 * pi)).sqrt() * x,
        _ => (15.0 / (16.0 * pi)).sqrt(),
    }
}

/// M for a proxy of key u: nine numbers for m = 0, four for |m| = 1, one for |m| = 2. SGI eq. 16.
fn exact_operator_row(key: f64, nodes: &[(f64, f64)]) -> [f64; EXACT_OPERATOR_WORDS] {
    let c = 1.0 - key;
    let alpha = (key * (2.0 - key)).sqrt();
    let mut row = [0.0; EXACT_OPERATOR_WORDS];
    for &(node, weight) in nodes {
        // s_z² = c² + t², t from 0 to α.
        let t = 0.5 * alpha * (node + 1.0);
        let s = (c * c + t * t).sqrt();
        let q = ((s - t) * s - 1.0) / alpha;
        let area = weight * 0.5 * alpha * t / s;
        let sines = ((1.0 - s * s).max(0.0) * (1.0 - q * q).max(0.0)).sqrt();
        let pi = std::f64::consts::PI;
        let mut add = |at: usize, l: usize, k: usize, m: usize| {
            // cos²(mφ) over the circle: 2π for m = 0, π otherwise; q̂ lies on the opposite side of nothing: same φ.
            let circle = if m == 0 { 2.0 * pi } else { pi };
            row[at] += area * circle * basis_part(l, m, s) * basis_part(k, m, q) * sines.powi(m as i32);
        };
        for l in 0..3 {
            for k in 0..3 {
                add(3 * l + k, l, k, 0);
            }
        }
        for l in 1..3 {
            for k in 1..3 {
                add(9 + 2 * (l - 1) + (k - 1), l, k, 1);
            }
        }
        add(13, 2, 2, 2);
    }
    row
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;
    use twinlight_kernels::sh;

    fn vectors(name: &str) -> Value {
        let path = format!("{}/kernels/tests/vectors/{name}.json", env!("CARGO_MANIFEST_DIR"));
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    }

    fn numbers(value: &Value) -> Vec<f64> {
        value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
    }

    #[test]
    fn logarithms_meet_the_vectors_of_three_orders() {
        for order in [3usize, 4, 5] {
            let file = vectors(&format!("log_occlusion_n{order}"));
            let (mut worst, mut unclipped) = (0.0f64, 0.0f64);
            for case in file["cases"].as_array().unwrap() {
                let alpha = case["alpha"].as_f64().unwrap();
                let u = 1.0 - ((1.0 - alpha) * (1.0 + alpha)).sqrt();
                let want = numbers(&case["log_zh"]);
                let got = logarithm(order, u);
                let planted = spectral(&visibility(order, u), |x| x.max(1e-3).ln());
                for l in 0..order {
                    worst = worst.max((got[l] - want[l]).abs() / want[l].abs().max(1e-3));
                    unclipped = unclipped.max((planted[l] - want[l]).abs());
                }
            }
            println!("order {order}: {worst:.1e}");
            assert!(worst < 1e-6, "order {order}: {worst:e}");
            assert!(unclipped > 0.1, "negative control: another clip gives the same");
        }
    }

    #[test]
    fn the_optimal_linear_tables_meet_the_vectors() {
        for order in [3usize, 4, 5] {
            let file = vectors(&format!("log_occlusion_n{order}"));
            let (a, b) = (numbers(&file["ol_a"]), numbers(&file["ol_b"]));
            let table = optimal_linear_table(order);
            let common = a.len().min(table.len() / 2);
            assert!(common + 3 > a.len(), "order {order}: {} entries for {}", table.len() / 2, a.len());
            let worst = (0..common - 1)
                .map(|k| {
                    let off = |got: f32, want: f64| (f64::from(got) - want).abs();
                    off(table[2 * k], a[k]).max(off(table[2 * k + 1], b[k]))
                })
                .fold(0.0, f64::max);
            println!("order {order}: {} entries, {worst:.1e}", table.len() / 2);
            assert!(worst < 5e-3, "order {order}: {worst}");
        }
    }

    #[test]
    fn the_exact_operator_meets_the_vectors() {
        let file = vectors("m_operator_n3");
        let table = exact_operator_table(ENTRIES as usize);
        let (mut worst, mut of_table, mut by_u) = (0.0f64, 0.0f64, 0.0f64);
        // As one would write it: rows of M/u at equal steps of u.
        let nodes = gauss_legendre(24);
        let rows: Vec<_> = (0..ENTRIES)
            .map(|i| (f64::from(i) / f64::from(ENTRIES - 1)).max(1e-9))
            .map(|u| exact_operator_row(u, &nodes).map(|m| m / u))
            .collect();
        for case in file["cases"].as_array().unwrap() {
            let alpha = case["alpha"].as_f64().unwrap();
            let mut want = [[0.0f64; 9]; 9];
            for entry in case["entries"].as_array().unwrap() {
                let e = numbers(entry);
                want[e[0] as usize][e[1] as usize] = e[2];
            }
            let u = 1.0 - ((1.0 - alpha) * (1.0 + alpha)).sqrt();
            let row = exact_operator_row(u, &nodes);
            let at = u * f64::from(ENTRIES - 1);
            let low = (at as usize).min(ENTRIES as usize - 2);
            for (k, (i, j)) in [(0, 0), (0, 2), (0, 6), (2, 0), (2, 2), (2, 6), (6, 0), (6, 2), (6, 6)]
                .into_iter()
                .chain([(1, 1), (1, 5), (5, 1), (5, 5), (4, 4)])
                .enumerate()
            {
                worst = worst.max((row[k] - want[i][j]).abs());
                let over_u = rows[low][k] + (rows[low + 1][k] - rows[low][k]) * (at - low as f64);
                by_u = by_u.max((u * over_u - want[i][j]).abs());
            }
            for column in 0..9 {
                let mut f = [0.0f32; 9];
                f[column] = 1.0;
                let got = sh::exact_operator(&table, ENTRIES, alpha as f32, &f);
                for (i, got) in got.iter().enumerate() {
                    of_table = of_table.max((f64::from(*got) - want[i][column]).abs());
                }
            }
        }
        println!("the operator {worst:.1e}, by its table {of_table:.1e}, by one of u {by_u:.1e}");
        assert!(worst < 1e-9 && of_table < 3e-4, "{worst:e}, {of_table:e}");
        assert!(by_u > 3.5e-4, "{by_u:e}");
    }

    #[test]
    fn tables_are_right_for_order_2_too() {
        // cos of a small cap: 1 − cap itself, to first order.
        let table = log_occlusion_table(2, 64);
        let first = [table[0], table[1]].map(f64::from);
        let limit = [1.772_453_850_9, 3.069_980_124];
        assert!((first[0] + limit[0]).abs() < 1e-4 && (first[1] + limit[1]).abs() < 1e-4, "{first:?}");
        assert!(optimal_linear_table(2).len() > 20);
    }
}
