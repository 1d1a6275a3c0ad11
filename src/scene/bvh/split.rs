//! Where is a set of triangles best cut in two?

use crate::scene::Bounds;
use glam::Vec3;

const BINS: usize = 16;
/// A cut by area leaves at least this share on either side, so that the number of cuts is bounded.
const SMALLEST_SHARE: usize = 32;

/// Half the surface area in f64: boxes of 1e18 m have one that f32 sums can't hold.
pub fn half_area(bounds: &Bounds) -> f64 {
    let s = bounds.size().as_dvec3();
    s.x * s.y + s.y * s.z + s.z * s.x
}

/// Sorts the triangles so that the first `left` have the smaller centres along the longest axis of the centres.
///
/// Equal centres are told apart by index. `left` must be less than the number of triangles.
pub fn by_count(triangles: &mut [u32], bounds: &[Bounds], left: usize) {
    let size = around_centres(triangles, bounds).size();
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    let centre = |i: u32| bounds[i as usize].centre()[axis];
    triangles.select_nth_unstable_by(left, |&i, &j| centre(i).total_cmp(&centre(j)).then(i.cmp(&j)));
}

/// Sorts the triangles into two parts of small surface times count; returns the size of the first.
///
/// Falls back to [`by_count`] where centres coincide or the parts are too unequal. At least two triangles.
pub fn by_area(triangles: &mut [u32], bounds: &[Bounds]) -> usize {
    let count = triangles.len();
    let centres = around_centres(triangles, bounds);
    let scale = centres.size().as_dvec3().to_array().map(|s| if s > 0.0 { BINS as f64 / s } else { 0.0 });
    let bin = |i: u32, axis: usize| {
        let distance = f64::from(bounds[i as usize].centre()[axis]) - f64::from(centres.min[axis]);
        ((distance * scale[axis]) as usize).min(BINS - 1)
    };
    let mut bins = [[(Bounds::EMPTY, 0usize); BINS]; 3];
    for &i in triangles.iter() {
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[bin(i, axis)];
            *bin = (bin.0.union(bounds[i as usize]), bin.1 + 1);
        }
    }
    // Cost, axis and last bin of the left part.
    let mut best = (f64::INFINITY, 0, 0);
    for (axis, bins) in bins.iter().enumerate() {
        let mut rights = [(0.0, 0); BINS];
        let mut right = (Bounds::EMPTY, 0);
        for (k, bin) in bins.iter().enumerate().rev() {
            rights[k] = (half_area(&right.0) * right.1 as f64, right.1);
            right = (right.0.union(bin.0), right.1 + bin.1);
        }
        let mut left = (Bounds::EMPTY, 0);
        for (k, bin) in bins.iter().enumerate() {
            left = (left.0.union(bin.0), left.1 + bin.1);
            let cost = half_area(&left.0) * left.1 as f64 + rights[k].0;
            if left.1.min(rights[k].1) * SMALLEST_SHARE >= count && cost < best.0 {
                best = (cost, axis, k);
            }
        }
    }
    let (cost, axis, last) = best;
    if cost.is_infinite() {
        by_count(triangles, bounds, count / 2);
        return count / 2;
    }
    let (left, right): (Vec<u32>, Vec<u32>) = triangles.iter().partition(|&&i| bin(i, axis) <= last);
    triangles[..left.len()].copy_from_slice(&left);
    triangles[left.len()..].copy_from_slice(&right);
    left.len()
}

fn around_centres(triangles: &[u32], bounds: &[Bounds]) -> Bounds {
    let point = |p: Vec3| Bounds { min: p, max: p };
    triangles.iter().fold(Bounds::EMPTY, |all, &i| all.union(point(bounds[i as usize].centre())))
}
