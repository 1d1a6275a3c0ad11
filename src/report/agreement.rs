//! How far do two backends' outputs of a pass lie apart?

use crate::backend::BufferElement;
use twinlight_kernels::layout::WordKind;
use twinlight_kernels::passes::{PassInfo, Tolerance};

/// The comparison of one run of a pass.
#[derive(Clone, Debug, PartialEq)]
pub struct Agreement {
    /// The pass.
    pub pass: &'static str,
    /// Elements compared.
    pub elements: usize,
    /// Elements with a word that differs; −0 equals 0, any NaN any NaN, values below 2⁻¹²⁶ equal 0.
    pub different: usize,
    /// Elements beyond the pass's tolerance of the fast mode.
    pub beyond: usize,
    /// Largest distance of two floats in units of the last place; infinite where only one is finite.
    pub max_ulp: f64,
    /// Largest relative difference of two floats.
    pub max_relative: f64,
    /// Largest absolute difference of two floats.
    pub max_absolute: f64,
    /// The first differing element as text, for messages.
    pub first: Option<String>,
    /// Why the outputs could not be compared at all.
    pub unequal_length: bool,
    tolerance: Tolerance,
}

impl Agreement {
    /// True when every word is the same.
    pub fn is_exact(&self) -> bool {
        !self.unequal_length && self.different == 0
    }

    /// True when the fast mode's declared tolerance holds.
    pub fn is_tolerable(&self) -> bool {
        let flips = match self.tolerance {
            Tolerance::Exact => 0.0,
            Tolerance::Relative { flips, .. } => f64::from(flips),
        };
        !self.unequal_length && self.beyond as f64 <= flips * self.elements as f64
    }
}

/// Values that a device may flush count as 0.
fn flush(x: f32) -> f32 {
    if x.abs() < f32::MIN_POSITIVE { 0.0 } else { x }
}

/// A float's place in the ordered sequence of all floats.
fn rank(x: f32) -> i64 {
    let bits = i64::from(x.to_bits() & 0x7FFF_FFFF);
    if x.is_sign_negative() { -bits } else { bits }
}

/// Distance in units of the last place, with the rules of [`Agreement::different`].
pub fn ulp_distance(a: f32, b: f32) -> f64 {
    let (a, b) = (flush(a), flush(b));
    if a.is_nan() && b.is_nan() || a == b {
        return 0.0;
    }
    if a.is_nan() || b.is_nan() || a.is_infinite() || b.is_infinite() {
        return f64::INFINITY;
    }
    (rank(a) - rank(b)).unsigned_abs() as f64
}

/// Compares two outputs of a pass word by word.
pub fn compare_elements<T: BufferElement>(pass: &PassInfo, expected: &[T], got: &[T]) -> Agreement {
    let mut a = Agreement {
        pass: pass.name,
        elements: expected.len(),
        different: 0,
        beyond: 0,
        max_ulp: 0.0,
        max_relative: 0.0,
        max_absolute: 0.0,
        first: None,
        unequal_length: expected.len() != got.len(),
        tolerance: pass.tolerance,
    };
    let words = size_of::<T>() / 4;
    let mut kinds = vec![WordKind::Unsigned; words];
    for field in T::FIELDS {
        let first = field.offset as usize / 4;
        kinds[first..first + field.words as usize].fill(field.kind);
    }
    for (index, (e, g)) in expected.iter().zip(got).enumerate() {
        let (e, g): (Vec<u32>, Vec<u32>) = (
            bytemuck::pod_collect_to_vec(bytemuck::bytes_of(e)),
            bytemuck::pod_collect_to_vec(bytemuck::bytes_of(g)),
        );
        let mut different = false;
        let mut beyond = false;
        for word in 0..words {
            let (d, b) = compare_word(&mut a, kinds[word], e[word], g[word]);
            different |= d;
            beyond |= b;
        }
        a.different += usize::from(different);
        a.beyond += usize::from(beyond);
        if different && a.first.is_none() {
            let shown = |words: &[u32]| {
                let floats: Vec<String> = words
                    .iter()
                    .zip(&kinds)
                    .map(|(&w, k)| match k {
                        WordKind::Float => format!("{:e}", f32::from_bits(w)),
                        WordKind::Unsigned => w.to_string(),
                    })
                    .collect();
                floats.join(" ")
            };
            a.first = Some(format!("element {index}: expected {}, got {}", shown(&e), shown(&g)));
        }
    }
    a
}

/// Notes the difference of two words; returns whether they differ, and whether beyond the tolerance.
fn compare_word(a: &mut Agreement, kind: WordKind, expected: u32, got: u32) -> (bool, bool) {
    if kind == WordKind::Unsigned {
        return (expected != got, expected != got);
    }
    let (x, y) = (f32::from_bits(expected), f32::from_bits(got));
    let ulp = ulp_distance(x, y);
    if ulp == 0.0 {
        return (false, false);
    }
    let difference = (f64::from(x) - f64::from(y)).abs();
    let relative = difference / f64::from(x).abs().max(f64::from(f32::MIN_POSITIVE));
    a.max_ulp = a.max_ulp.max(ulp);
    if difference.is_finite() {
        a.max_absolute = a.max_absolute.max(difference);
        a.max_relative = a.max_relative.max(relative);
    } else {
        a.max_absolute = f64::INFINITY;
        a.max_relative = f64::INFINITY;
    }
    let allowed = match a.tolerance {
        Tolerance::Exact => 0.0,
        Tolerance::Relative { relative, absolute, .. } => {
            f64::from(relative) * f64::from(x).abs() + f64::from(absolute)
        }
    };
    // Negated so that a NaN difference counts as beyond.
    #[allow(clippy::neg_cmp_op_on_partial_ord)]
    let beyond = !(difference <= allowed);
    (true, beyond)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec4;
    use twinlight_kernels::passes::info;

    fn values() -> Vec<Vec4> {
        (0..10).map(|i| Vec4::new(i as f32, 1.0, -2.5, 1e-20)).collect()
    }

    #[test]
    fn equal_outputs_are_exact() {
        let a = compare_elements(&info::reduce_sum, &values(), &values());
        assert!(a.is_exact() && a.is_tolerable());
    }

    #[test]
    fn every_planted_fault_is_caught() {
        let faults: [fn(&mut Vec<Vec4>); 5] = [
            |v| v[3].x = f32::from_bits(v[3].x.to_bits() + 1),
            |v| v[9].z = f32::NAN,
            |v| v[0].y = f32::INFINITY,
            |v| v[5].w = -v[5].w,
            |v| {
                v.pop();
            },
        ];
        for (number, fault) in faults.iter().enumerate() {
            let mut bad = values();
            fault(&mut bad);
            let a = compare_elements(&info::reduce_sum, &values(), &bad);
            assert!(!a.is_exact(), "fault {number} passed as exact");
            // One ULP is within the declared tolerance, and so is a sign at 1e-20.
            assert_eq!(a.is_tolerable(), number == 0 || number == 3, "fault {number}");
        }
    }

    #[test]
    fn zeros_of_either_sign_and_any_nan_are_equal() {
        let a = compare_elements(
            &info::reduce_sum,
            &[Vec4::new(0.0, f32::NAN, 1e-40, 0.0)],
            &[Vec4::new(-0.0, f32::from_bits(0xFFC0_1234), 0.0, 0.0)],
        );
        assert!(a.is_exact(), "{a:?}");
        assert_eq!(ulp_distance(1.0, f32::from_bits(1.0f32.to_bits() + 3)), 3.0);
        assert_eq!(ulp_distance(f32::INFINITY, 1.0), f64::INFINITY);
    }
}
