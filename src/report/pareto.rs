//! Which of many choices is beaten by no other?

/// Marks the points (cost, error) for which no other is at most as dear and at most as wrong, and better in one.
///
/// Points with a number that is not finite are beaten by all; of equal points all are marked.
pub fn pareto_front(points: &[(f64, f64)]) -> Vec<bool> {
    let usable = |p: &(f64, f64)| p.0.is_finite() && p.1.is_finite();
    let beats =
        |a: &(f64, f64), b: &(f64, f64)| usable(a) && a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    points.iter().map(|p| usable(p) && !points.iter().any(|other| beats(other, p))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_what_nothing_beats_is_on_the_front() {
        let points =
            [(1.0, 9.0), (2.0, 5.0), (2.0, 6.0), (3.0, 5.0), (4.0, 1.0), (0.5, f64::NAN), (4.0, 1.0)];
        assert_eq!(pareto_front(&points), [true, true, false, false, true, false, true]);
        assert!(pareto_front(&[]).is_empty());
    }
}
