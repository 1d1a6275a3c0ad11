//! Which spheres stand in for a scene's bodies: given by hand, by the file, or fitted to its meshes?

use super::bvh::Bvh;
use super::{Bounds, Scene, Sphere};
use crate::error::SceneError;
use glam::{DMat4, DVec3, Vec3};
use std::collections::HashMap;
use twinlight_kernels::geometry::bvh::{AcceptAll, NO_TRIANGLE, Ray, nearest_hit};
use twinlight_kernels::passes::material::{reflectance, texture_coordinates};
use twinlight_kernels::passes::scene::Triangle;
use twinlight_kernels::passes::surface::geometric_normal;

/// Cells along the longest side of the bodies that spheres are fitted to.
const FIT_CELLS: u32 = 48;
/// Rounds of moving spheres to the middle of their cells.
const FIT_ROUNDS: u32 = 24;
/// A body whose box is thinner than this share of its length is ground or wall.
const FLAT: f32 = 1.0e-3;

/// The largest number of proxies of a scene.
pub const MAX_PROXIES: usize = 32_768;

/// How well spheres fill the bodies that they were fitted to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// Spheres added.
    pub spheres: u32,
    /// Volume inside bodies and outside of spheres, or the other way round, over the bodies' volume.
    pub error: f64,
}

/// Reads the spheres of a node's extras, `{"spheres": [[x, y, z, radius], …]}` in the node's space, metres.
///
/// # Errors
/// What is wrong with them, without a name.
pub(super) fn from_extras(json: &str, world: &DMat4) -> Result<Vec<(Vec3, f32)>, String> {
    let value: serde_json::Value =
        serde_json::from_str(json).map_err(|e| format!("extras are not JSON: {e}"))?;
    let Some(spheres) = value.get("spheres") else { return Ok(vec![]) };
    let wrong = || "extras.spheres is not a list of [x, y, z, radius] with a radius above 0".to_owned();
    if spheres.as_array().is_some_and(|all| all.len() > MAX_PROXIES) {
        return Err(format!("extras.spheres has more than {MAX_PROXIES} spheres"));
    }
    // A node that is scaled unevenly makes ellipsoids: the sphere of the same volume.
    let scale = world.determinant().abs().cbrt();
    let mut read = vec![];
    for sphere in spheres.as_array().ok_or_else(wrong)? {
        let numbers: Option<Vec<f64>> =
            sphere.as_array().and_then(|s| s.iter().map(|x| x.as_f64()).collect());
        let &[x, y, z, radius] = numbers.ok_or_else(wrong)?.as_slice() else { return Err(wrong()) };
        let centre = world.transform_point3(DVec3::new(x, y, z)).as_vec3();
        let scaled = (radius * scale) as f32;
        let in_range = centre.to_array().iter().chain([&scaled]).all(|x| x.abs() <= super::MAX_VALUE);
        if !(in_range && radius > 0.0) {
            return Err(wrong());
        }
        // A node that is scaled to nothing hides its spheres.
        if scaled > 0.0 {
            read.push((centre, scaled));
        }
    }
    Ok(read)
}

impl Scene {
    /// Adds a sphere as a proxy of its own; without an albedo it has that of the surfaces near it.
    pub fn add_proxy(&mut self, centre: Vec3, radius: f32, albedo: Option<Vec3>) {
        let character = self.next_character();
        let albedo = albedo.unwrap_or_else(|| self.albedo_near(centre, radius));
        self.proxies.push(Sphere { centre, radius, character, albedo });
    }

    /// Adds spheres with the character that each belongs to; their albedos are those of the surfaces near them.
    pub(super) fn add_proxies(&mut self, spheres: &[(Vec3, f32, u32)]) -> Result<(), SceneError> {
        use rayon::prelude::*;
        let count = (self.proxies.len() + spheres.len()) as u64;
        if count > MAX_PROXIES as u64 {
            return Err(SceneError::TooLarge { what: "spheres".into(), count, limit: MAX_PROXIES as u64 });
        }
        let one = |&(centre, radius, character): &(Vec3, f32, u32)| Sphere {
            centre,
            radius,
            character,
            albedo: self.albedo_near(centre, radius),
        };
        let added: Vec<Sphere> = spheres.par_iter().map(one).collect();
        self.proxies.extend(added);
        Ok(())
    }

    fn next_character(&self) -> u32 {
        self.proxies.iter().map(|p| p.character + 1).max().unwrap_or(0)
    }

    /// Mean albedo, by area, of the triangles whose middle lies within 1.25 radii of a centre; without any, that of the
    /// triangle whose middle is nearest.
    fn albedo_near(&self, centre: Vec3, radius: f32) -> Vec3 {
        let of = |t: &Triangle| {
            let uv = texture_coordinates(t, 1.0 / 3.0, 1.0 / 3.0);
            let r = reflectance(&self.materials[t.material as usize], &self.texels, uv);
            // A glossy body sends its light back too, if not evenly.
            (r.diffuse + r.specular).min(Vec3::ONE).as_dvec3()
        };
        let (mut sum, mut area) = (DVec3::ZERO, 0.0);
        let mut nearest = (f32::INFINITY, None);
        for t in &self.triangles {
            let [a, b, c] = [t.p0, t.p1, t.p2].map(glam::Vec4::truncate);
            let squared = middle(t).distance_squared(centre);
            if squared < (1.25 * radius).powi(2) {
                let own = f64::from((b - a).cross(c - a).length());
                sum += of(t) * own;
                area += own;
            }
            if squared < nearest.0 {
                nearest = (squared, Some(t));
            }
        }
        if area > 0.0 {
            (sum / area).as_vec3()
        } else {
            nearest.1.map_or(Vec3::splat(0.5), |t| of(t).as_vec3())
        }
    }

    /// Fits `count` spheres to the scene's closed bodies and adds them as one character: cells of a grid that lie inside are
    /// divided among them, each is as large as its cells.
    ///
    /// # Errors
    /// No closed body, or a count of 0 or above 4096.
    pub fn fit_proxies(&mut self, count: u32) -> Result<Fit, SceneError> {
        let refuse = |reason: &str| SceneError::Proxies { reason: reason.into() };
        if !(1..=4096).contains(&count) {
            return Err(refuse(&format!("{count} spheres are not from 1 to 4096")));
        }
        let bodies = bodies(&self.triangles);
        if bodies.is_empty() {
            return Err(refuse("every mesh is flat"));
        }
        let bounds = Bounds::of(&bodies);
        let edge = bounds.size().max_element() / FIT_CELLS as f32;
        let inside = inside(&bodies, &bounds, edge)?;
        if inside.is_empty() {
            return Err(refuse("no mesh is closed with its faces outward"));
        }
        let spheres = divide(&inside, count as usize, edge);
        let error = difference(&inside, &spheres, &bounds, edge);
        let character = self.next_character();
        let added: Vec<_> = spheres.iter().map(|&(centre, radius)| (centre, radius, character)).collect();
        self.add_proxies(&added)?;
        Ok(Fit { spheres: spheres.len() as u32, error })
    }
}

/// Fitted spheres that go with the surfaces near them.
#[derive(Clone, Debug)]
pub struct Carried {
    spheres: Vec<Sphere>,
    /// The triangles near each, and the mean of their middles where they were fitted.
    near: Vec<(Vec<u32>, Vec3)>,
    triangles: usize,
}

impl Carried {
    /// Binds spheres to the triangles of the scene that they were fitted in.
    pub fn new(scene: &Scene, spheres: &[Sphere]) -> Self {
        use rayon::prelude::*;
        let near = |s: &Sphere| {
            let own = |factor: f32| -> Vec<u32> {
                let close = |t: &Triangle| middle(t).distance_squared(s.centre) < (factor * s.radius).powi(2);
                (0..scene.triangles.len() as u32).filter(|&i| close(&scene.triangles[i as usize])).collect()
            };
            // Farther out for a sphere well inside.
            let all = [1.25, 2.5, 5.0].into_iter().map(own).find(|all| !all.is_empty()).unwrap_or_default();
            let mean = mean_middle(scene, &all);
            (all, mean)
        };
        Self {
            spheres: spheres.to_vec(),
            near: spheres.par_iter().map(near).collect(),
            triangles: scene.triangles.len(),
        }
    }

    /// The spheres in another pose of the scene: each moved as the mean of the surfaces near it. Where they were if the
    /// scene has other triangles.
    pub fn in_pose(&self, scene: &Scene) -> Vec<Sphere> {
        let same = scene.triangles.len() == self.triangles;
        let moved = |(s, (near, before)): (&Sphere, &(Vec<u32>, Vec3))| {
            let by = if same && !near.is_empty() { mean_middle(scene, near) - *before } else { Vec3::ZERO };
            Sphere { centre: s.centre + by, ..*s }
        };
        self.spheres.iter().zip(&self.near).map(moved).collect()
    }
}

fn middle(t: &Triangle) -> Vec3 {
    (t.p0 + t.p1 + t.p2).truncate() / 3.0
}

/// Mean of triangles' middles.
fn mean_middle(scene: &Scene, triangles: &[u32]) -> Vec3 {
    let sum: DVec3 = triangles.iter().map(|&i| middle(&scene.triangles[i as usize]).as_dvec3()).sum();
    (sum / triangles.len().max(1) as f64).as_vec3()
}

/// The triangles of all connected parts that are not flat.
fn bodies(triangles: &[Triangle]) -> Vec<Triangle> {
    let mut parent: Vec<u32> = Vec::new();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            parent[i as usize] = parent[parent[i as usize] as usize];
            i = parent[i as usize];
        }
        i
    }
    let mut vertices: HashMap<[u32; 3], u32> = HashMap::new();
    let mut first = Vec::with_capacity(triangles.len());
    for t in triangles {
        let ids = [t.p0, t.p1, t.p2].map(|p| {
            *vertices.entry(p.truncate().to_array().map(|c| (c + 0.0).to_bits())).or_insert_with(|| {
                parent.push(parent.len() as u32);
                parent.len() as u32 - 1
            })
        });
        for id in &ids[1..] {
            let (a, b) = (root(&mut parent, ids[0]), root(&mut parent, *id));
            parent[a.max(b) as usize] = a.min(b);
        }
        first.push(ids[0]);
    }
    let mut parts: HashMap<u32, Vec<Triangle>> = HashMap::new();
    let mut order = vec![];
    for (t, id) in triangles.iter().zip(first) {
        let part = root(&mut parent, id);
        let list = parts.entry(part).or_default();
        if list.is_empty() {
            order.push(part);
        }
        list.push(*t);
    }
    let bulky = |list: &Vec<Triangle>| {
        let size = Bounds::of(list).size();
        size.min_element() > FLAT * size.max_element()
    };
    order.iter().filter_map(|part| parts.get(part).filter(|list| bulky(list))).flatten().copied().collect()
}

/// Middles of the cells that lie inside: most of six rays meet a face from behind first.
fn inside(bodies: &[Triangle], bounds: &Bounds, edge: f32) -> Result<Vec<Vec3>, SceneError> {
    use rayon::prelude::*;
    let tree = Bvh::build(bodies, &[])?;
    let cells = (bounds.size() / edge).ceil().max(Vec3::ONE).as_uvec3();
    let all = cells.x * cells.y * cells.z;
    let axes = [Vec3::X, Vec3::NEG_X, Vec3::Y, Vec3::NEG_Y, Vec3::Z, Vec3::NEG_Z];
    let is_inside = |p: Vec3| {
        let behind = axes.iter().filter(|&&direction| {
            let ray = Ray { origin: p, direction, t_min: 0.0, t_max: 1.0e30 };
            let hit = nearest_hit(&tree.nodes, &tree.blocks, &ray, &AcceptAll);
            hit.triangle != NO_TRIANGLE
                && geometric_normal(&bodies[hit.triangle as usize]).dot(direction) > 0.0
        });
        behind.count() >= 4
    };
    Ok((0..all)
        .into_par_iter()
        .map(|i| {
            let cell = glam::UVec3::new(i % cells.x, i / cells.x % cells.y, i / cells.x / cells.y);
            bounds.min + (cell.as_vec3() + 0.5) * edge
        })
        .filter(|&p| is_inside(p))
        .collect())
}

/// Divides cells among spheres: each cell to the nearest centre, each centre to the middle of its cells, over and over.
fn divide(cells: &[Vec3], count: usize, edge: f32) -> Vec<(Vec3, f32)> {
    use rayon::prelude::*;
    // Begin with cells far from each other.
    let mut centres = vec![cells[0]];
    let mut nearest: Vec<f32> = vec![f32::INFINITY; cells.len()];
    while centres.len() < count.min(cells.len()) {
        let last = centres[centres.len() - 1];
        let mut farthest = 0;
        for (i, cell) in cells.iter().enumerate() {
            nearest[i] = nearest[i].min(cell.distance_squared(last));
            if nearest[i] > nearest[farthest] {
                farthest = i;
            }
        }
        centres.push(cells[farthest]);
    }
    let mut volumes = vec![0u32; centres.len()];
    let mut owners = vec![];
    for _ in 0..FIT_ROUNDS {
        let own = |cell: &Vec3| {
            let nearest = |a: &(usize, f32), b: &(usize, f32)| a.1.total_cmp(&b.1);
            let distances = centres.iter().map(|c| c.distance_squared(*cell)).enumerate();
            distances.min_by(nearest).map_or(0, |(i, _)| i)
        };
        let now: Vec<usize> = cells.par_iter().map(own).collect();
        if now == owners {
            break;
        }
        owners = now;
        let mut sums = vec![(DVec3::ZERO, 0u32); centres.len()];
        for (cell, &own) in cells.iter().zip(&owners) {
            let sum = &mut sums[own];
            *sum = (sum.0 + cell.as_dvec3(), sum.1 + 1);
        }
        for (i, (sum, n)) in sums.into_iter().enumerate() {
            volumes[i] = n;
            if n > 0 {
                centres[i] = (sum / f64::from(n)).as_vec3();
            }
        }
    }
    let radius = |n: u32| edge * (f32::cbrt(3.0 * n as f32 / (4.0 * std::f32::consts::PI)));
    centres.into_iter().zip(volumes).filter(|v| v.1 > 0).map(|(c, n)| (c, radius(n))).collect()
}

/// The share of the bodies' volume that bodies and spheres do not have in common.
fn difference(inside: &[Vec3], spheres: &[(Vec3, f32)], bounds: &Bounds, edge: f32) -> f64 {
    use rayon::prelude::*;
    let in_sphere = |p: Vec3| spheres.iter().any(|s| p.distance_squared(s.0) <= s.1 * s.1);
    let missed = inside.par_iter().filter(|&&p| !in_sphere(p)).count();
    let key = |p: Vec3| ((p - bounds.min) / edge).floor().as_ivec3();
    let own: std::collections::HashSet<glam::IVec3> = inside.iter().map(|&p| key(p)).collect();
    let margin = spheres.iter().map(|s| s.1).fold(0.0f32, f32::max);
    let low = key(bounds.min - margin);
    let high = key(bounds.max + margin);
    let in_layer = |z: i32| {
        let mut beyond = 0usize;
        for y in low.y..=high.y {
            for x in low.x..=high.x {
                let cell = glam::IVec3::new(x, y, z);
                let middle = bounds.min + (cell.as_vec3() + 0.5) * edge;
                beyond += usize::from(!own.contains(&cell) && in_sphere(middle));
            }
        }
        beyond
    };
    let beyond: usize = (low.z..high.z + 1).into_par_iter().map(in_layer).sum();
    (missed + beyond) as f64 / inside.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_are_found_again() {
        let mut s = Scene::open("spheres").unwrap();
        let right = std::mem::take(&mut s.proxies);
        let fit = s.fit_proxies(right.len() as u32).unwrap();
        println!("{fit:?}");
        assert_eq!((fit.spheres as usize, s.proxies.len()), (right.len(), right.len()));
        assert!(fit.error < 0.35, "{fit:?}");
        let volume = |all: &[Sphere]| all.iter().map(|p| p.radius.powi(3)).sum::<f32>();
        // Characters' spheres overlap: their union is less than their sum.
        assert!((volume(&s.proxies) / volume(&right) - 0.9).abs() < 0.15);
        let mut coarse = Scene::open("spheres").unwrap();
        coarse.proxies.clear();
        let worse = coarse.fit_proxies(5).unwrap();
        assert!(worse.error > fit.error, "negative control: fewer spheres fit as well");
        let red = s.proxies.iter().filter(|p| p.centre.x < -3.0).map(|p| p.albedo.x).fold(1.0, f32::min);
        assert!(red > 0.6, "albedo of the surfaces near: {red}");
    }

    #[test]
    fn fitted_spheres_go_with_their_bodies() {
        let mut s = Scene::open("spheres").unwrap();
        s.proxies.clear();
        s.fit_proxies(40).unwrap();
        let carried = Carried::new(&s, &s.proxies);
        assert_eq!(carried.in_pose(&s), s.proxies);
        let later = Scene::open_at("spheres", 0.6).unwrap();
        let moved = carried.in_pose(&later);
        // Each stays as near to one of the scene's own spheres as it was.
        let nearest = |at: Vec3, all: &[Sphere]| {
            all.iter().map(|p| p.centre.distance(at)).fold(f32::INFINITY, f32::min)
        };
        let own = Scene::open("spheres").unwrap().proxies;
        let worst = |spheres: &[Sphere], all: &[Sphere]| {
            spheres.iter().map(|p| nearest(p.centre, all)).fold(0.0f32, f32::max)
        };
        let (before, after) = (worst(&s.proxies, &own), worst(&moved, &later.proxies));
        let left_behind = worst(&s.proxies, &later.proxies);
        println!(
            "farthest from a sphere: {before:.3}, in the other pose {after:.3}, unmoved {left_behind:.3}"
        );
        assert!(after < before + 0.2 && left_behind > after + 0.15);
        let other = Scene::open("cornell-box").unwrap();
        assert_eq!(carried.in_pose(&other), s.proxies);
    }

    #[test]
    fn what_has_no_inside_is_refused() {
        let mut open = Scene::open("spheres").unwrap();
        open.triangles.truncate(2);
        assert!(open.fit_proxies(4).unwrap_err().to_string().contains("flat"));
        let mut s = Scene::open("spheres").unwrap();
        assert!(s.fit_proxies(0).is_err() && s.fit_proxies(5000).is_err());
        // One sphere, inside out.
        s.triangles.truncate(2 + 1280);
        for t in &mut s.triangles {
            std::mem::swap(&mut t.p1, &mut t.p2);
        }
        assert!(s.fit_proxies(4).unwrap_err().to_string().contains("outward"));
    }

    #[test]
    fn extras_are_read_in_the_nodes_space() {
        let world = DMat4::from_translation(DVec3::X) * DMat4::from_scale(DVec3::splat(2.0));
        let read = from_extras(r#"{"spheres": [[1, 0, 0, 0.5]], "other": 1}"#, &world).unwrap();
        assert_eq!(read, [(Vec3::new(3.0, 0.0, 0.0), 1.0)]);
        assert_eq!(from_extras(r#"{"name": "x"}"#, &world).unwrap(), []);
        let hidden = DMat4::from_scale(DVec3::ZERO);
        assert_eq!(from_extras(r#"{"spheres": [[1, 0, 0, 0.5]]}"#, &hidden).unwrap(), []);
        for bad in [
            "{",
            r#"{"spheres": 1}"#,
            r#"{"spheres": [[1, 2, 3]]}"#,
            r#"{"spheres": [[1, 2, 3, -1]]}"#,
            r#"{"spheres": [["a", 2, 3, 1]]}"#,
            r#"{"spheres": [[1e300, 2, 3, 1]]}"#,
        ] {
            assert!(from_extras(bad, &world).is_err(), "{bad}");
        }
    }
}
