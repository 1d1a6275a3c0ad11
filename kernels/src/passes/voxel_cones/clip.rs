//! Which part of a triangle lies in a voxel?

use crate::math::{cross, div, dot, sqrt};
use glam::Vec3;

/// Corners of a triangle cut by the six planes of a cube, at most.
const MAX_CORNERS: usize = 10;

/// A convex polygon.
struct Polygon {
    corners: [Vec3; MAX_CORNERS],
    count: u32,
}

impl Polygon {
    /// Cuts off what lies where `outside(corner)` is above 0; it is linear in the corner.
    #[inline]
    fn cut(&self, axis: u32, sign: f32, bound: f32) -> Self {
        let outside = |p: Vec3| {
            sign * (if axis == 0 {
                p.x
            } else if axis == 1 {
                p.y
            } else {
                p.z
            }) - bound
        };
        let mut cut = Self { corners: [Vec3::ZERO; MAX_CORNERS], count: 0 };
        // What lies in a cube's upper face belongs to the next.
        let mut within = false;
        let mut i = 0;
        while i < self.count {
            let a = self.corners[i as usize];
            let next = if i + 1 < self.count { i + 1 } else { 0 };
            let b = self.corners[next as usize];
            let (of_a, of_b) = (outside(a), outside(b));
            within |= of_a < 0.0 || (sign < 0.0 && of_a <= 0.0);
            if of_a <= 0.0 && cut.count < MAX_CORNERS as u32 {
                cut.corners[cut.count as usize] = a;
                cut.count += 1;
            }
            if ((of_a <= 0.0) != (of_b <= 0.0)) && cut.count < MAX_CORNERS as u32 {
                let t = div(of_a, of_a - of_b);
                cut.corners[cut.count as usize] = a + (b - a) * t;
                cut.count += 1;
            }
            i += 1;
        }
        if !within {
            cut.count = 0;
        }
        cut
    }
}

/// The part of a triangle in a cube.
pub struct Part {
    /// Its area, in squares of the cube's edge.
    pub area: f32,
    /// Its centroid; the middle of the cube where the area is 0.
    pub centroid: Vec3,
}

/// Returns the part of a triangle within the cube [−½, ½]³, by cutting it at the cube's planes one after the other.
///
/// Parts of a triangle in the cubes of a lattice add up to the triangle within 1e-5 of its area.
#[inline]
pub fn part_in_cube(a: Vec3, b: Vec3, c: Vec3) -> Part {
    let mut p = Polygon { corners: [Vec3::ZERO; MAX_CORNERS], count: 3 };
    p.corners[0] = a;
    p.corners[1] = b;
    p.corners[2] = c;
    let mut axis = 0;
    while axis < 3 {
        p = p.cut(axis, 1.0, 0.5);
        p = p.cut(axis, -1.0, 0.5);
        axis += 1;
    }
    let mut weighted = Vec3::ZERO;
    let mut area = 0.0;
    let first = p.corners[0];
    let mut i = 2;
    while i < p.count {
        let (b, c) = (p.corners[(i - 1) as usize], p.corners[i as usize]);
        let normal = cross(b - first, c - first);
        let own = 0.5 * sqrt(dot(normal, normal));
        // 1/3
        weighted += ((first + b) + c) * (own * 0.333_333_34);
        area += own;
        i += 1;
    }
    let centroid = if area > 1.0e-30 {
        Vec3::new(div(weighted.x, area), div(weighted.y, area), div(weighted.z, area))
    } else {
        Vec3::ZERO
    };
    Part { area, centroid }
}
