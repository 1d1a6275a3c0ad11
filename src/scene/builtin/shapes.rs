//! Which triangles make a quadrilateral, a block and a sphere?

use glam::Vec3;
use std::collections::HashMap;
use twinlight_kernels::passes::scene::Triangle;

/// Triangles as they are collected.
#[derive(Default)]
pub struct Mesh {
    pub triangles: Vec<Triangle>,
}

impl Mesh {
    /// Adds one triangle with these unit normals.
    fn triangle(&mut self, p: [Vec3; 3], n: [Vec3; 3], material: u32) {
        self.triangles.push(Triangle {
            p0: p[0].extend(0.0),
            p1: p[1].extend(0.0),
            p2: p[2].extend(0.0),
            n0: n[0].extend(0.0),
            n1: n[1].extend(0.0),
            n2: n[2].extend(0.0),
            material,
            ..Triangle::default()
        });
    }

    /// Adds a flat quadrilateral, counter-clockwise from its front.
    pub fn quad(&mut self, p: [Vec3; 4], material: u32) {
        let n = (p[1] - p[0]).cross(p[3] - p[0]).normalize();
        self.triangle([p[0], p[1], p[2]], [n; 3], material);
        self.triangle([p[0], p[2], p[3]], [n; 3], material);
    }

    /// Adds a closed block of this size, turned about the vertical axis through its centre.
    pub fn block(&mut self, centre: Vec3, size: Vec3, degrees: f32, material: u32) {
        let (sin, cos) = f64::from(degrees).to_radians().sin_cos();
        let (sin, cos) = (sin as f32, cos as f32);
        let corner = |x: f32, y: f32, z: f32| {
            let h = size * 0.5 * Vec3::new(x, y, z);
            centre + Vec3::new(h.x * cos + h.z * sin, h.y, h.z * cos - h.x * sin)
        };
        // Bits x, y, z of the index: upper or lower end.
        let at = |i: u32| {
            let end = |bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
            corner(end(0), end(1), end(2))
        };
        for face in [[0, 4, 6, 2], [5, 1, 3, 7], [4, 5, 7, 6], [1, 0, 2, 3], [6, 7, 3, 2], [0, 1, 5, 4]] {
            self.quad(face.map(at), material);
        }
    }

    /// Adds a closed sphere of 20·4ⁿ triangles with its corners, and their normals, exactly on the sphere.
    pub fn sphere(&mut self, centre: Vec3, radius: f32, subdivisions: u32, material: u32) {
        let (points, faces) = icosphere(subdivisions);
        for face in faces {
            let n = face.map(|i| points[i as usize]);
            self.triangle(n.map(|n| centre + n * radius), n, material);
        }
    }
}

/// Returns unit vectors and the faces over them, counter-clockwise from outside.
fn icosphere(subdivisions: u32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
    let golden = 0.5 * (1.0 + 5.0f32.sqrt());
    let ends = [(-1.0, golden), (1.0, golden), (-1.0, -golden), (1.0, -golden)];
    let mut points: Vec<Vec3> = ends.map(|(a, b)| Vec3::new(a, b, 0.0).normalize()).into();
    points.extend(ends.map(|(a, b)| Vec3::new(0.0, a, b).normalize()));
    // In the order of the faces below.
    points.extend(
        [(golden, -1.0), (golden, 1.0), (-golden, -1.0), (-golden, 1.0)]
            .map(|(a, b)| Vec3::new(a, 0.0, b).normalize()),
    );
    #[rustfmt::skip]
    let mut faces: Vec<[u32; 3]> = vec![
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
        [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
        [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ];
    for _ in 0..subdivisions {
        let mut middles: HashMap<(u32, u32), u32> = HashMap::new();
        let mut finer = Vec::with_capacity(faces.len() * 4);
        for [a, b, c] in faces {
            let mut middle = |i: u32, j: u32| {
                *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                    points.push((points[i as usize] + points[j as usize]).normalize());
                    points.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            finer.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        faces = finer;
    }
    (points, faces)
}
