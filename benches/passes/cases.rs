//! On which inputs is each pass timed?

#[path = "evaluate.rs"]
mod evaluate;
#[path = "layered.rs"]
mod layered;
#[path = "soft.rs"]
mod soft;
#[path = "visibility.rs"]
mod visibility;
#[path = "voxels.rs"]
mod voxels;

pub use evaluate::*;
pub use layered::*;
pub use soft::*;
pub use visibility::*;
pub use voxels::*;

use bytemuck::Pod;
use glam::Vec3;
use twinlight::backend::{Cpu, CpuBuffer};
use twinlight::scene::{Scene, bvh::Bvh, light};
use twinlight::technique::{View, World};
use twinlight_kernels::passes::elementary::function;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::gather::GATHER_EMISSION;
use twinlight_kernels::passes::layout_report::LAYOUT_WORDS;
use twinlight_kernels::passes::reduction::REDUCE_BLOCK;
use twinlight_kernels::passes::scan::SCAN_BLOCK;
use twinlight_kernels::passes::sort::{DIGITS, SORT_BLOCK};
use twinlight_kernels::sampling::hash::{hash, unit_float};

/// What a pass is timed on.
pub struct Case<P, I> {
    /// Its parameters.
    pub params: P,
    /// One vector per input.
    pub inputs: I,
    /// Elements of the output.
    pub outputs: u32,
    /// Work items.
    pub items: u32,
}

/// A case with as many outputs as items.
fn map<P, I>(params: P, inputs: I, items: u32) -> Case<P, I> {
    Case { params, inputs, outputs: items, items }
}

/// Columns and rows of the picture.
const SIDE: u32 = 256;
/// Its pixels, and the number of values for passes that know no pixels.
const COUNT: u32 = SIDE * SIDE;

/// A picture half way through the passes.
pub struct Samples {
    world: World<Cpu>,
    camera: CameraParams,
    light: LightParams,
    gather: GatherParams,
    hits: CpuBuffer<Hit>,
    surfaces: CpuBuffer<Surface>,
    gloss: CpuBuffer<Vec4>,
    visible: CpuBuffer<u32>,
    filter: Filter,
    voxels: Voxels,
    layered: Layered,
    soft: Soft,
}

impl Samples {
    /// Draws `spheres` with all that a scene may have but holes: gloss, emission, a light, an environment map.
    pub fn new(cpu: &mut Cpu) -> Result<Self, Box<dyn std::error::Error>> {
        let mut scene = Scene::open("spheres")?;
        scene.lights.push(light::point(Vec3::new(2.0, 5.0, 6.0), Vec3::splat(50.0)));
        for material in &mut scene.materials {
            material.roughness = 0.3;
            material.emission = Vec4::new(0.1, 0.1, 0.1, 0.0);
        }
        let tree = Bvh::build(&scene.triangles, &scene.materials)?;
        let w = World::upload(cpu, &scene, &tree, true)?;
        let camera = View::new(&scene.view(), SIDE, SIDE)?.params(0);
        let light = LightParams { eye: camera.eye, light_count: 1, ..Default::default() };
        let gather = GatherParams { rays: 1, flags: GATHER_EMISSION, ..w.environment };

        let (tris, mats, texels, n) = (&w.triangles, &w.materials, &w.texels, COUNT as usize);
        let mut hits = cpu.alloc("hits", n)?;
        cpu.trace_primary(&camera, &w.nodes, &w.blocks, tris, mats, texels, &mut hits, COUNT)?;
        let mut surfaces = cpu.alloc("surfaces", n)?;
        cpu.resolve_surfaces(&camera, &hits, tris, mats, texels, &mut surfaces, COUNT)?;
        let mut gloss = cpu.alloc("gloss", n)?;
        cpu.resolve_gloss(&camera, &surfaces, mats, texels, &mut gloss, COUNT)?;
        let mut visible = cpu.alloc("visibility", n)?;
        let v = &mut visible;
        cpu.light_visibility(
            &light, &surfaces, &w.lights, &w.nodes, &w.blocks, tris, mats, texels, v, COUNT,
        )?;
        let filter = Filter::new(cpu, &w, &camera, &surfaces, &gloss)?;
        let voxels = Voxels::new(cpu, &w)?;
        let layered = Layered::new(cpu, &w)?;
        let soft = Soft::new(cpu, &scene, &surfaces)?;
        Ok(Self {
            world: w,
            camera,
            light,
            gather,
            hits,
            surfaces,
            gloss,
            visible,
            filter,
            voxels,
            layered,
            soft,
        })
    }

    fn tree(&self) -> (Vec<BvhNode>, Vec<TriangleBlock>) {
        (copy(&self.world.nodes), copy(&self.world.blocks))
    }

    fn triangles(&self) -> Vec<Triangle> {
        copy(&self.world.triangles)
    }

    fn materials(&self) -> (Vec<Material>, Vec<u32>) {
        (copy(&self.world.materials), copy(&self.world.texels))
    }
}

fn copy<T: Pod>(buffer: &CpuBuffer<T>) -> Vec<T> {
    buffer.as_slice().to_vec()
}

/// Words of any value.
fn words(count: u32) -> Vec<u32> {
    (0..count).map(hash).collect()
}

/// Numbers in [0, 1).
fn floats(count: u32) -> Vec<f32> {
    words(count).into_iter().map(unit_float).collect()
}

/// Vectors with components in [0, 1).
fn vectors(count: u32) -> Vec<Vec4> {
    floats(4 * count).chunks_exact(4).map(Vec4::from_slice).collect()
}

fn exclusive_scan(values: &[u32]) -> Vec<u32> {
    let next = |sum: &mut u32, value: &u32| {
        let before = *sum;
        *sum += value;
        Some(before)
    };
    values.iter().scan(0, next).collect()
}

pub fn evaluate_elementary(_: &Samples) -> Case<ElementaryParams, (Vec<f32>, Vec<f32>)> {
    let params = ElementaryParams { function: function::POW, ..Default::default() };
    map(params, (floats(COUNT), floats(COUNT)), COUNT)
}

pub fn report_layout(_: &Samples) -> Case<LayoutParams, ()> {
    map(LayoutParams::default(), (), LAYOUT_WORDS.len() as u32)
}

const SCAN: ScanParams = ScanParams { count: COUNT, pad0: 0, pad1: 0, pad2: 0 };

pub fn block_sums(_: &Samples) -> Case<ScanParams, (Vec<u32>,)> {
    map(SCAN, (words(COUNT),), COUNT.div_ceil(SCAN_BLOCK))
}

pub fn scan_blocks(_: &Samples) -> Case<ScanParams, (Vec<u32>,)> {
    map(SCAN, (words(COUNT),), COUNT)
}

pub fn add_block_offsets(_: &Samples) -> Case<ScanParams, (Vec<u32>, Vec<u32>)> {
    map(SCAN, (words(COUNT), words(COUNT.div_ceil(SCAN_BLOCK))), COUNT)
}

pub fn compact_indices(_: &Samples) -> Case<CompactParams, (Vec<u32>, Vec<u32>)> {
    let flags: Vec<u32> = words(COUNT).iter().map(|w| w & 1).collect();
    let places = exclusive_scan(&flags);
    map(CompactParams { count: COUNT, ..Default::default() }, (flags, places), COUNT)
}

/// Parameters of the sort, pairs of random keys and indices, and where each digit of each block begins.
fn sort_case() -> (DigitParams, Vec<u32>, Vec<u32>) {
    let blocks = COUNT.div_ceil(SORT_BLOCK);
    let pairs: Vec<u32> = (0..COUNT).flat_map(|i| [hash(i), i]).collect();
    let mut counts = vec![0; (DIGITS * blocks) as usize];
    for (i, pair) in pairs.chunks_exact(2).enumerate() {
        counts[((pair[0] % DIGITS) * blocks) as usize + i / SORT_BLOCK as usize] += 1;
    }
    (DigitParams { count: COUNT, shift: 0, blocks, ..Default::default() }, pairs, exclusive_scan(&counts))
}

pub fn count_digits(_: &Samples) -> Case<DigitParams, (Vec<u32>,)> {
    let (params, pairs, offsets) = sort_case();
    Case { params, inputs: (pairs,), outputs: offsets.len() as u32, items: COUNT }
}

pub fn place_by_digit(_: &Samples) -> Case<DigitParams, (Vec<u32>, Vec<u32>)> {
    let (params, pairs, offsets) = sort_case();
    Case { params, inputs: (pairs, offsets), outputs: 2 * COUNT, items: COUNT }
}

pub fn reduce_sum(_: &Samples) -> Case<ReduceParams, (Vec<Vec4>,)> {
    let params = ReduceParams { count: COUNT, ..Default::default() };
    map(params, (vectors(COUNT),), COUNT.div_ceil(REDUCE_BLOCK))
}

type TracePrimary = (Vec<BvhNode>, Vec<TriangleBlock>, Vec<Triangle>, Vec<Material>, Vec<u32>);

pub fn trace_primary(s: &Samples) -> Case<CameraParams, TracePrimary> {
    let ((nodes, blocks), (materials, texels)) = (s.tree(), s.materials());
    map(s.camera, (nodes, blocks, s.triangles(), materials, texels), COUNT)
}

type ResolveSurfaces = (Vec<Hit>, Vec<Triangle>, Vec<Material>, Vec<u32>);

pub fn resolve_surfaces(s: &Samples) -> Case<CameraParams, ResolveSurfaces> {
    let (materials, texels) = s.materials();
    map(s.camera, (copy(&s.hits), s.triangles(), materials, texels), COUNT)
}

type OfSurfaces = (Vec<Surface>, Vec<Material>, Vec<u32>);

pub fn resolve_gloss(s: &Samples) -> Case<CameraParams, OfSurfaces> {
    let (materials, texels) = s.materials();
    map(s.camera, (copy(&s.surfaces), materials, texels), COUNT)
}

pub fn resolve_emission(s: &Samples) -> Case<CameraParams, OfSurfaces> {
    resolve_gloss(s)
}

type LightVisibility =
    (Vec<Surface>, Vec<Light>, Vec<BvhNode>, Vec<TriangleBlock>, Vec<Triangle>, Vec<Material>, Vec<u32>);

pub fn light_visibility(s: &Samples) -> Case<LightParams, LightVisibility> {
    let ((nodes, blocks), (materials, texels)) = (s.tree(), s.materials());
    let (surfaces, lights) = (copy(&s.surfaces), copy(&s.world.lights));
    map(s.light, (surfaces, lights, nodes, blocks, s.triangles(), materials, texels), COUNT)
}

type ShadeDiffuse = (Vec<Surface>, Vec<Light>, Vec<u32>, Vec<Vec4>);

pub fn shade_diffuse(s: &Samples) -> Case<LightParams, ShadeDiffuse> {
    map(s.light, (copy(&s.surfaces), copy(&s.world.lights), copy(&s.visible), vectors(COUNT)), COUNT)
}

type ShadeSpecular = (Vec<Surface>, Vec<Vec4>, Vec<Light>, Vec<u32>, Vec<Vec4>);

pub fn shade_specular(s: &Samples) -> Case<LightParams, ShadeSpecular> {
    let (surfaces, gloss, lights) = (copy(&s.surfaces), copy(&s.gloss), copy(&s.world.lights));
    map(s.light, (surfaces, gloss, lights, copy(&s.visible), vectors(COUNT)), COUNT)
}

type GatherDirect =
    (Vec<Surface>, Vec<BvhNode>, Vec<TriangleBlock>, Vec<Triangle>, Vec<Material>, Vec<u32>, Vec<Vec4>);

pub fn gather_direct(s: &Samples) -> Case<GatherParams, GatherDirect> {
    let ((nodes, blocks), (materials, texels)) = (s.tree(), s.materials());
    let surfaces = copy(&s.surfaces);
    map(s.gather, (surfaces, nodes, blocks, s.triangles(), materials, texels, vectors(COUNT)), COUNT)
}

type AmbientOpenness =
    (Vec<Surface>, Vec<BvhNode>, Vec<TriangleBlock>, Vec<Triangle>, Vec<Material>, Vec<u32>);

pub fn ambient_openness(s: &Samples) -> Case<GatherParams, AmbientOpenness> {
    let ((nodes, blocks), (materials, texels)) = (s.tree(), s.materials());
    map(s.gather, (copy(&s.surfaces), nodes, blocks, s.triangles(), materials, texels), COUNT)
}

pub fn add_radiance(_: &Samples) -> Case<AddParams, (Vec<Vec4>, Vec<Vec4>)> {
    map(AddParams::default(), (vectors(COUNT), vectors(COUNT)), COUNT)
}

type FillBackground = (Vec<GatherParams>, Vec<Surface>, Vec<u32>, Vec<Vec4>);

pub fn fill_background(s: &Samples) -> Case<CameraParams, FillBackground> {
    map(s.camera, (vec![s.gather], copy(&s.surfaces), copy(&s.world.texels), vectors(COUNT)), COUNT)
}
