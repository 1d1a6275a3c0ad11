//! Inputs of the passes that trace and shade: small random scenes with everything that scenes may have.

use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use glam::{UVec4, Vec2, Vec3, Vec4};
use twinlight::scene::{Camera, bvh::Bvh, light};
use twinlight::technique::View;
use twinlight_kernels::passes;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::gather::GATHER_EMISSION;
use twinlight_kernels::passes::scene::MATERIAL_MASKED;

pub(super) const WIDTH: u32 = 28;
const HEIGHT: u32 = 18;
/// The band that is rendered: neither the first pixel nor the last.
pub(super) const FIRST: u32 = 5;
pub(super) const PIXELS: u32 = WIDTH * HEIGHT - 9;

/// A random scene and what a camera sees of it.
pub(super) struct World {
    pub(super) nodes: Vec<BvhNode>,
    pub(super) blocks: Vec<TriangleBlock>,
    pub(super) triangles: Vec<Triangle>,
    pub(super) materials: Vec<Material>,
    pub(super) texels: Vec<u32>,
    pub(super) lights: Vec<Light>,
    pub(super) camera: CameraParams,
    pub(super) hits: Vec<Hit>,
    pub(super) surfaces: Vec<Surface>,
    pub(super) gather: GatherParams,
}

pub(super) fn launch(label: &str) -> Launch {
    Launch::new(label, PIXELS as usize, PIXELS)
}

/// Two scenes: the constant environment, then the map.
pub(super) fn worlds(draw: &mut Draw) -> [World; 2] {
    [World::new(draw, false), World::new(draw, true)]
}

impl World {
    fn new(draw: &mut Draw, map: bool) -> Self {
        let mut texels = textures(draw);
        let materials = materials(draw);
        let triangles = triangles(draw, materials.len() as u32);
        let tree = Bvh::build(&triangles, &materials).expect("valid triangles");
        let gather = environment(draw, &mut texels, map);
        let eye = Vec3::new(0.2, 0.1, 6.0);
        let camera = Camera { eye, target: draw.point(0.5), up: Vec3::Y, fov: 50.0 };
        let camera = View::new(&camera, WIDTH, HEIGHT).expect("a valid camera").params(FIRST);
        let mut world = Self {
            lights: lights(draw),
            nodes: tree.nodes,
            blocks: tree.blocks,
            triangles,
            materials,
            texels,
            camera,
            hits: Vec::new(),
            surfaces: Vec::new(),
            gather,
        };
        let w = &world;
        world.hits = (0..PIXELS)
            .map(|i| {
                passes::trace_primary(
                    i,
                    &w.camera,
                    &w.nodes,
                    &w.blocks,
                    &w.triangles,
                    &w.materials,
                    &w.texels,
                )
            })
            .collect();
        let w = &world;
        world.surfaces = (0..PIXELS)
            .map(|i| passes::resolve_surfaces(i, &w.camera, &w.hits, &w.triangles, &w.materials, &w.texels))
            .collect();
        let seen = world.surfaces.iter().filter(|s| s.triangle != u32::MAX).count();
        assert!(seen > 50 && seen < PIXELS as usize, "{seen} pixels see something: too plain a scene");
        world
    }

    pub(super) fn gloss(&self) -> Vec<Vec4> {
        let one = |i| passes::resolve_gloss(i, &self.camera, &self.surfaces, &self.materials, &self.texels);
        (0..PIXELS).map(one).collect()
    }

    pub(super) fn light_params(&self, first_light: u32) -> LightParams {
        LightParams {
            eye: self.camera.eye,
            first_light,
            light_count: self.lights.len() as u32 - first_light,
            ..Default::default()
        }
    }

    pub(super) fn visibility(&self, params: &LightParams) -> Vec<u32> {
        (0..PIXELS)
            .map(|i| {
                passes::light_visibility(
                    i,
                    params,
                    &self.surfaces,
                    &self.lights,
                    &self.nodes,
                    &self.blocks,
                    &self.triangles,
                    &self.materials,
                    &self.texels,
                )
            })
            .collect()
    }
}

/// A 4×4 texture with holes and a 3×5 one.
fn textures(draw: &mut Draw) -> Vec<u32> {
    (0..4 * 4 + 3 * 5).flat_map(|_| [draw.word(), draw.word()]).collect()
}

fn materials(draw: &mut Draw) -> Vec<Material> {
    let first = |width: u32, height: u32| width | height << 16;
    let mut all = Vec::new();
    for i in 0..5 {
        let mut m = Material {
            base: draw.units(),
            metallic: draw.unit(),
            roughness: draw.unit(),
            cutoff: 0.5,
            ..Default::default()
        };
        match i {
            1 => {
                m.flags = MATERIAL_MASKED;
                m.base.w = 1.0;
                m.base_size = first(4, 4);
            }
            2 => {
                m.rough_texture = 16;
                m.rough_size = first(3, 5);
            }
            3 => {
                m.emission = (draw.units() * 10.0).truncate().extend(0.0);
                m.emission_texture = 16;
                m.emission_size = first(3, 5);
            }
            4 => m.roughness = 1.0,
            _ => {}
        }
        all.push(m);
    }
    all
}

fn triangles(draw: &mut Draw, materials: u32) -> Vec<Triangle> {
    let mut all: Vec<Triangle> = (0..60)
        .map(|i| {
            let centre = draw.point(2.0);
            let corners = [0; 3].map(|_| centre + draw.point(1.0));
            let flat = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize_or(Vec3::Y);
            let normals = [0; 3].map(|_| (flat + draw.point(0.2)).normalize_or(Vec3::Y));
            let uvs = [0; 3].map(|_| Vec2::new(draw.uniform(-1.0, 2.0), draw.uniform(-1.0, 2.0)));
            triangle(corners, normals, uvs, i % materials)
        })
        .collect();
    // A wall behind it all, whose halves share an edge that rays may meet.
    let corners = [(-3.0, -3.0), (3.0, -3.0), (3.0, 3.0), (-3.0, 3.0)].map(|(x, y)| Vec3::new(x, y, -3.0));
    let uvs = [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y];
    for [a, b, c] in [[0, 1, 2], [0, 2, 3]] {
        all.push(triangle([corners[a], corners[b], corners[c]], [Vec3::Z; 3], [uvs[a], uvs[b], uvs[c]], 0));
    }
    all
}

fn triangle(p: [Vec3; 3], n: [Vec3; 3], uv: [Vec2; 3], material: u32) -> Triangle {
    Triangle {
        p0: p[0].extend(uv[0].x),
        p1: p[1].extend(uv[1].x),
        p2: p[2].extend(uv[2].x),
        n0: n[0].extend(uv[0].y),
        n1: n[1].extend(uv[1].y),
        n2: n[2].extend(uv[2].y),
        material,
        ..Default::default()
    }
}

/// Two of each kind, one of them inside the scene.
fn lights(draw: &mut Draw) -> Vec<Light> {
    let mut all = Vec::new();
    for extent in [1.0, 5.0] {
        let power = draw.units().truncate() * 30.0;
        all.push(light::point(draw.point(extent), power));
        let (inner, outer) = (draw.uniform(0.0, 0.5), draw.uniform(0.5, 1.2));
        let at = Vec3::Z * (4.0 + extent);
        all.push(light::spot(at, (draw.point(1.0) - at).normalize(), power, inner, outer));
        all.push(light::sun(draw.direction(), power));
    }
    all
}

fn environment(draw: &mut Draw, texels: &mut Vec<u32>, map: bool) -> GatherParams {
    let mut params = GatherParams {
        environment: draw.units().truncate().extend(0.0),
        rays: 6,
        seed: draw.word(),
        flags: GATHER_EMISSION,
        falloff: 0.7,
        first_pixel: FIRST,
        reach: 3.0,
        ..Default::default()
    };
    if map {
        let (width, height) = (8, 5);
        params.map = UVec4::new(texels.len() as u32, width, height, 0);
        texels.extend((0..3 * width * height).map(|_| draw.positive(1e-3, 1e2).to_bits()));
    }
    params
}

pub(super) fn previous(draw: &mut Draw) -> Vec<Vec4> {
    (0..PIXELS).map(|_| draw.units().truncate().extend(0.0)).collect()
}

pub fn trace_primary(draw: &mut Draw) -> Vec<case::trace_primary> {
    let make = |w: World| case::trace_primary {
        launch: launch("a band of pixels"),
        params: w.camera,
        nodes: w.nodes,
        blocks: w.blocks,
        triangles: w.triangles,
        materials: w.materials,
        texels: w.texels,
    };
    worlds(draw).map(make).into()
}

pub fn resolve_surfaces(draw: &mut Draw) -> Vec<case::resolve_surfaces> {
    let make = |w: World| case::resolve_surfaces {
        launch: launch("a band of pixels"),
        params: w.camera,
        hits: w.hits,
        triangles: w.triangles,
        materials: w.materials,
        texels: w.texels,
    };
    worlds(draw).map(make).into()
}

pub fn resolve_gloss(draw: &mut Draw) -> Vec<case::resolve_gloss> {
    let make = |w: World| case::resolve_gloss {
        launch: launch("a band of pixels"),
        params: w.camera,
        surfaces: w.surfaces,
        materials: w.materials,
        texels: w.texels,
    };
    worlds(draw).map(make).into()
}

pub fn resolve_emission(draw: &mut Draw) -> Vec<case::resolve_emission> {
    let make = |w: World| case::resolve_emission {
        launch: launch("a band of pixels"),
        params: w.camera,
        surfaces: w.surfaces,
        materials: w.materials,
        texels: w.texels,
    };
    worlds(draw).map(make).into()
}

pub fn light_visibility(draw: &mut Draw) -> Vec<case::light_visibility> {
    let make = |w: World| case::light_visibility {
        launch: launch("all lights but the first"),
        params: w.light_params(1),
        surfaces: w.surfaces,
        lights: w.lights,
        nodes: w.nodes,
        blocks: w.blocks,
        triangles: w.triangles,
        materials: w.materials,
        texels: w.texels,
    };
    worlds(draw).map(make).into()
}

pub fn shade_diffuse(draw: &mut Draw) -> Vec<case::shade_diffuse> {
    let [w, _] = worlds(draw);
    let params = w.light_params(0);
    vec![case::shade_diffuse {
        launch: launch("all lights"),
        params,
        visibility: w.visibility(&params),
        surfaces: w.surfaces,
        lights: w.lights,
        previous: previous(draw),
    }]
}

pub fn shade_specular(draw: &mut Draw) -> Vec<case::shade_specular> {
    let [w, _] = worlds(draw);
    let params = w.light_params(0);
    vec![case::shade_specular {
        launch: launch("all lights"),
        params,
        gloss: w.gloss(),
        visibility: w.visibility(&params),
        surfaces: w.surfaces,
        lights: w.lights,
        previous: previous(draw),
    }]
}

pub fn gather_direct(draw: &mut Draw) -> Vec<case::gather_direct> {
    let worlds = worlds(draw);
    let mut make = |w: World| case::gather_direct {
        launch: launch(if w.gather.map.z == 0 { "constant environment" } else { "environment map" }),
        params: w.gather,
        surfaces: w.surfaces,
        nodes: w.nodes,
        blocks: w.blocks,
        triangles: w.triangles,
        materials: w.materials,
        texels: w.texels,
        previous: previous(draw),
    };
    worlds.map(&mut make).into()
}

pub fn ambient_openness(draw: &mut Draw) -> Vec<case::ambient_openness> {
    let make = |w: World| case::ambient_openness {
        launch: launch("six rays a pixel"),
        params: w.gather,
        surfaces: w.surfaces,
        nodes: w.nodes,
        blocks: w.blocks,
        triangles: w.triangles,
        materials: w.materials,
        texels: w.texels,
    };
    worlds(draw).map(make).into()
}

pub fn fill_background(draw: &mut Draw) -> Vec<case::fill_background> {
    let worlds = worlds(draw);
    let mut make = |w: World| case::fill_background {
        launch: launch(if w.gather.map.z == 0 { "constant environment" } else { "environment map" }),
        params: w.camera,
        environment: vec![w.gather],
        surfaces: w.surfaces,
        texels: w.texels,
        previous: previous(draw),
    };
    worlds.map(&mut make).into()
}
