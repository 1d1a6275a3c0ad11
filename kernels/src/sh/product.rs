//! What are the coefficients of the product of two functions, truncated to their order?

use super::triple_products::{
    TRIPLES_OF_BAND_4, triples_of_band_2, triples_of_band_3, triples_of_bands_0_and_1,
};

/// Returns the product of two functions of the same order, truncated to it: Σ Γ_ijk a_j b_k. Orders 2 to 5.
///
/// Commutative bit for bit; *not* associative, because of the truncation: keep the order of a chain fixed. 2e-6 of
/// the product of the norms. 10/83/353/1158 ordered terms.
#[inline]
pub fn product<const N: usize>(a: &[f32; N], b: &[f32; N]) -> [f32; N] {
    const { assert!(N == 4 || N == 9 || N == 16 || N == 25) };
    let mut out = [0.0; N];
    // Literal indices and no branches: one straight line of code on every backend.
    macro_rules! add {
        (distinct $i:literal, $j:literal, $k:literal, $value:literal) => {
            out[$i] += $value * (a[$j] * b[$k] + a[$k] * b[$j]);
            out[$j] += $value * (a[$i] * b[$k] + a[$k] * b[$i]);
            out[$k] += $value * (a[$i] * b[$j] + a[$j] * b[$i]);
        };
        (twice $p:literal, $q:literal, $value:literal) => {
            out[$p] += $value * (a[$p] * b[$q] + a[$q] * b[$p]);
            out[$q] += $value * (a[$p] * b[$p]);
        };
        (thrice $p:literal, $value:literal) => {
            out[$p] += $value * (a[$p] * b[$p]);
        };
    }
    triples_of_bands_0_and_1!(add);
    if const { N > 4 } {
        triples_of_band_2!(add);
    }
    if const { N > 9 } {
        triples_of_band_3!(add);
    }
    if const { N > 16 } {
        for t in 0..TRIPLES_OF_BAND_4.len() {
            let (packed, value) = TRIPLES_OF_BAND_4[t];
            let (i, j, k) = unpack(packed);
            add_triple(&mut out, a, b, i, j, k, value);
        }
    }
    out
}

/// Returns the product of a function with itself: the bits of [`product`]`(a, a)` with a third fewer operations.
#[inline]
pub fn square<const N: usize>(a: &[f32; N]) -> [f32; N] {
    const { assert!(N == 4 || N == 9 || N == 16 || N == 25) };
    let mut out = [0.0; N];
    // Doubling is exact, so the bits are those of the product.
    macro_rules! add {
        (distinct $i:literal, $j:literal, $k:literal, $value:literal) => {
            out[$i] += (2.0 * $value) * (a[$j] * a[$k]);
            out[$j] += (2.0 * $value) * (a[$i] * a[$k]);
            out[$k] += (2.0 * $value) * (a[$i] * a[$j]);
        };
        (twice $p:literal, $q:literal, $value:literal) => {
            out[$p] += (2.0 * $value) * (a[$p] * a[$q]);
            out[$q] += $value * (a[$p] * a[$p]);
        };
        (thrice $p:literal, $value:literal) => {
            out[$p] += $value * (a[$p] * a[$p]);
        };
    }
    triples_of_bands_0_and_1!(add);
    if const { N > 4 } {
        triples_of_band_2!(add);
    }
    if const { N > 9 } {
        triples_of_band_3!(add);
    }
    if const { N > 16 } {
        for t in 0..TRIPLES_OF_BAND_4.len() {
            let (packed, value) = TRIPLES_OF_BAND_4[t];
            let (i, j, k) = unpack(packed);
            add_triple_of_square(&mut out, a, i, j, k, value);
        }
    }
    out
}

/// (i, j, k) of an entry of the table of band 4.
#[inline]
fn unpack(packed: u32) -> (usize, usize, usize) {
    ((packed & 31) as usize, ((packed >> 5) & 31) as usize, (packed >> 10) as usize)
}

/// Adds what the triple i ≤ j ≤ k contributes in all its orderings.
#[inline]
fn add_triple<const N: usize>(
    out: &mut [f32; N],
    a: &[f32; N],
    b: &[f32; N],
    i: usize,
    j: usize,
    k: usize,
    value: f32,
) {
    out[i] += value * pair(a, b, j, k);
    if j != i {
        out[j] += value * pair(a, b, i, k);
    }
    if k != j {
        out[k] += value * pair(a, b, i, j);
    }
}

/// Adds what the triple contributes to a square.
#[inline]
fn add_triple_of_square<const N: usize>(
    out: &mut [f32; N],
    a: &[f32; N],
    i: usize,
    j: usize,
    k: usize,
    value: f32,
) {
    out[i] += value * pair_of_square(a, j, k);
    if j != i {
        out[j] += value * pair_of_square(a, i, k);
    }
    if k != j {
        out[k] += value * pair_of_square(a, i, j);
    }
}

/// a_p b_q + a_q b_p: symmetric in a and b to the bit.
#[inline]
fn pair<const N: usize>(a: &[f32; N], b: &[f32; N], p: usize, q: usize) -> f32 {
    if p == q { a[p] * b[p] } else { a[p] * b[q] + a[q] * b[p] }
}

/// The same for a = b; doubling is exact.
#[inline]
fn pair_of_square<const N: usize>(a: &[f32; N], p: usize, q: usize) -> f32 {
    if p == q { a[p] * a[p] } else { 2.0 * (a[p] * a[q]) }
}
