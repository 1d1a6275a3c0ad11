//! Which scenes are there without any file?

mod shapes;

use super::{Camera, Environment, EnvironmentMap, Scene, Sphere, light};
use glam::{Vec3, Vec4};
use shapes::Mesh;
use twinlight_kernels::passes::scene::Material;

/// Subdivisions of an icosahedron that make a smooth sphere: 1280 triangles.
const SPHERE_SUBDIVISIONS: u32 = 3;

/// A plain Lambert material.
fn diffuse(r: f32, g: f32, b: f32) -> Material {
    Material { base: Vec4::new(r, g, b, 1.0), roughness: 1.0, ..Material::default() }
}

/// The Cornell box: 2 m wide, high and deep, centred on x = z = 0, floor at y = 0, open at +z.
///
/// Walls are sheets that face the room, blocks are closed. A point light of 2 W/sr hangs 0.2 m below the ceiling; the
/// lamp's surface emits about as much along its normal, when surfaces are allowed to emit. `glossy` polishes the
/// floor and makes the tall block metal.
pub fn cornell_box(glossy: bool) -> Scene {
    let white = diffuse(0.725, 0.71, 0.68);
    let mut lamp = diffuse(0.78, 0.78, 0.78);
    lamp.emission = Vec4::new(11.0, 11.0, 11.0, 0.0);
    let (mut floor, mut tall) = (white, white);
    if glossy {
        floor.roughness = 0.25;
        tall = Material { base: Vec4::new(0.9, 0.75, 0.5, 1.0), metallic: 1.0, roughness: 0.2, ..white };
    }
    const WHITE: u32 = 0;
    const RED: u32 = 1;
    const GREEN: u32 = 2;
    const LAMP: u32 = 3;
    const FLOOR: u32 = 4;
    const TALL: u32 = 5;
    let materials = vec![white, diffuse(0.63, 0.065, 0.05), diffuse(0.14, 0.45, 0.091), lamp, floor, tall];

    let v = Vec3::new;
    let mut mesh = Mesh::default();
    mesh.quad([v(-1.0, 0.0, 1.0), v(1.0, 0.0, 1.0), v(1.0, 0.0, -1.0), v(-1.0, 0.0, -1.0)], FLOOR);
    mesh.quad([v(-1.0, 2.0, -1.0), v(1.0, 2.0, -1.0), v(1.0, 2.0, 1.0), v(-1.0, 2.0, 1.0)], WHITE);
    mesh.quad([v(-1.0, 0.0, -1.0), v(1.0, 0.0, -1.0), v(1.0, 2.0, -1.0), v(-1.0, 2.0, -1.0)], WHITE);
    mesh.quad([v(-1.0, 0.0, 1.0), v(-1.0, 0.0, -1.0), v(-1.0, 2.0, -1.0), v(-1.0, 2.0, 1.0)], RED);
    mesh.quad([v(1.0, 0.0, -1.0), v(1.0, 0.0, 1.0), v(1.0, 2.0, 1.0), v(1.0, 2.0, -1.0)], GREEN);
    mesh.block(v(-0.35, 0.6, -0.3), v(0.6, 1.2, 0.6), 17.0, TALL);
    mesh.block(v(0.34, 0.3, 0.37), v(0.6, 0.6, 0.6), -16.5, WHITE);
    // Just below the ceiling: a wider gap would show as a dark frame in the light of the point.
    let (x, y, z) = (0.235, 1.998, 0.19);
    mesh.quad([v(-x, y, -z), v(x, y, -z), v(x, y, z), v(-x, y, z)], LAMP);

    Scene {
        name: if glossy { "cornell-glossy" } else { "cornell-box" }.into(),
        triangles: mesh.triangles,
        materials,
        lights: vec![light::point(v(0.0, 1.8, 0.0), Vec3::splat(2.0))],
        camera: Some(Camera { eye: v(0.0, 1.0, 3.9), target: v(0.0, 1.0, 0.0), up: Vec3::Y, fov: 39.0 }),
        ..Scene::default()
    }
}

/// Five characters of eight spheres each on a 300 m plane at y = 0, under a sky with a soft bright side.
///
/// Characters stand 2 m apart on a staggered row and sway, each in its own time, twice in five seconds; their spheres are in
/// [`Scene::proxies`]. At 0 s all stand upright.
pub fn spheres(seconds: f64) -> Scene {
    // Centre and radius of one character's spheres, facing +z, 1.8 m high.
    const PARTS: [(Vec3, f32); 8] = [
        (Vec3::new(0.0, 1.60, 0.0), 0.20),
        (Vec3::new(0.0, 1.15, 0.0), 0.30),
        (Vec3::new(0.0, 0.80, 0.0), 0.26),
        (Vec3::new(-0.40, 1.10, 0.06), 0.14),
        (Vec3::new(0.40, 1.10, 0.06), 0.14),
        (Vec3::new(-0.16, 0.45, 0.0), 0.17),
        (Vec3::new(0.16, 0.45, 0.0), 0.17),
        (Vec3::new(0.0, 0.14, 0.04), 0.14),
    ];
    let mut materials = vec![diffuse(0.5, 0.5, 0.5)];
    let mut mesh = Mesh::default();
    let mut proxies = vec![];
    let side = 150.0;
    let corner = |x: f32, z: f32| Vec3::new(x * side, 0.0, z * side);
    mesh.quad([corner(-1.0, 1.0), corner(1.0, 1.0), corner(1.0, -1.0), corner(-1.0, -1.0)], 0);
    let colours =
        [[0.7, 0.25, 0.2], [0.25, 0.6, 0.3], [0.25, 0.35, 0.75], [0.75, 0.65, 0.2], [0.7, 0.7, 0.7]];
    for (character, [r, g, b]) in colours.into_iter().enumerate() {
        materials.push(diffuse(r, g, b));
        let place = Vec3::new(character as f32 * 2.0 - 4.0, 0.0, if character % 2 == 0 { 0.0 } else { -1.5 });
        let sway = (std::f64::consts::TAU * 0.4 * seconds).sin() as f32 * (0.6 + 0.1 * character as f32);
        for (centre, radius) in PARTS {
            // Upper parts lean more.
            let lean = Vec3::new(0.35 * centre.y, 0.0, 0.15 * centre.y) * (sway * centre.y);
            let centre = centre + lean;
            mesh.sphere(place + centre, radius, SPHERE_SUBDIVISIONS, character as u32 + 1);
            proxies.push(Sphere {
                centre: place + centre,
                radius,
                character: character as u32,
                albedo: Vec3::new(r, g, b),
            });
        }
    }
    let sky = EnvironmentMap::from_directions(64, 32, sky_radiance);
    Scene {
        name: "spheres".into(),
        triangles: mesh.triangles,
        materials,
        environment: sky.map_or(Environment::Constant(Vec3::ONE), Environment::Map),
        camera: Some(Camera {
            eye: Vec3::new(0.0, 3.6, 11.0),
            target: Vec3::new(0.0, 0.7, 0.0),
            up: Vec3::Y,
            fov: 45.0,
        }),
        proxies,
        ..Scene::default()
    }
}

/// A clear sky: blue above, white near the horizon, darker below, with a broad warm lobe around (1, 1.2, 0.8).
fn sky_radiance(direction: Vec3) -> Vec3 {
    let height = direction.y;
    let blue = Vec3::new(0.25, 0.45, 0.9);
    let white = Vec3::new(0.8, 0.85, 0.9);
    if height < 0.0 {
        return white + (Vec3::splat(0.2) - white) * -height;
    }
    let towards = direction.dot(Vec3::new(1.0, 1.2, 0.8).normalize()).max(0.0);
    // The 16th power by squaring: the same bits everywhere.
    let lobe = (0..4).fold(towards, |p, _| p * p);
    white + (blue - white) * height + Vec3::new(6.0, 5.2, 4.0) * lobe
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Bounds;
    use std::collections::HashMap;
    use twinlight_kernels::passes::scene::Triangle;

    /// Whether every edge is met by exactly one triangle from each side.
    fn is_closed(triangles: &[Triangle]) -> bool {
        let mut edges: HashMap<[[u32; 3]; 2], i32> = HashMap::new();
        let key = |p: Vec4| p.truncate().to_array().map(|c| (c + 0.0).to_bits());
        for t in triangles {
            for (a, b) in [(t.p0, t.p1), (t.p1, t.p2), (t.p2, t.p0)] {
                *edges.entry([key(a), key(b)]).or_default() += 1;
            }
        }
        edges.iter().all(|([a, b], n)| *n == 1 && edges.get(&[*b, *a]) == Some(&1))
    }

    #[test]
    fn the_box_has_closed_blocks_and_walls_that_face_the_room() {
        let scene = cornell_box(false);
        assert_eq!(scene.triangles.len(), 6 * 2 + 2 * 12);
        assert!(is_closed(&scene.triangles[10..22]) && is_closed(&scene.triangles[22..34]));
        assert!(!is_closed(&scene.triangles[..10]), "negative control: the walls are open at +z");
        let centre = Vec3::new(0.0, 1.0, 0.0);
        for t in scene.triangles[..10].iter().chain(&scene.triangles[34..]) {
            assert!(t.n0.truncate().dot(centre - t.p0.truncate()) > 0.0);
        }
        let bounds = scene.bounds();
        assert_eq!(bounds, Bounds { min: Vec3::new(-1.0, 0.0, -1.0), max: Vec3::new(1.0, 2.0, 1.0) });
        let census = scene.census();
        assert!(census.has_emission && !census.has_gloss && !census.has_masked && census.points == 1);
        assert!(cornell_box(true).census().has_gloss);
    }

    #[test]
    fn normals_agree_with_windings_and_have_unit_length() {
        for scene in [cornell_box(false), spheres(0.0), spheres(0.7)] {
            for t in &scene.triangles {
                let p = [t.p0, t.p1, t.p2].map(Vec4::truncate);
                let face = (p[1] - p[0]).cross(p[2] - p[0]);
                for n in [t.n0, t.n1, t.n2].map(Vec4::truncate) {
                    assert!(n.dot(face) > 0.0 && (n.length() - 1.0).abs() < 1e-6);
                }
                assert!((t.material as usize) < scene.materials.len());
            }
            scene.view().frame().unwrap();
        }
    }

    #[test]
    fn spheres_are_closed_and_on_their_proxies() {
        let scene = spheres(0.4);
        let per_sphere = 20 << (2 * SPHERE_SUBDIVISIONS);
        assert_eq!(scene.triangles.len(), 2 + scene.proxies.len() * per_sphere);
        for (proxy, triangles) in scene.proxies.iter().zip(scene.triangles[2..].chunks(per_sphere)) {
            assert!(is_closed(triangles));
            for t in triangles {
                let distance = (t.p0.truncate() - proxy.centre).length();
                assert!((distance - proxy.radius).abs() < 1e-5);
            }
        }
        assert!(scene.census().has_environment);
    }
}
