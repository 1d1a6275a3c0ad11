//! What does a cone meet on its way through the pyramid? VCT §5.

use super::inject::RADIANCE_WORDS;
use super::lobes::{LOBE_WORDS, cone_variance, mirrored};
use super::storage::{SHARED_EXPONENT, load_radiance, ratio, unpack_depths, unpack_radiance};
use super::trace::ConeParams;
use crate::cone::{diameter, distance_falloff, mip_level, step_count_bound};
use crate::geometry::lattice::{NO_VOXEL, voxel_at};
use crate::math::{abs, clamp, div, dot, exp, exp2, floor, max, min, saturate, to_u32};
use glam::{UVec3, Vec3};

/// Samples whose voxels have less weight than this are empty.
const LEAST_WEIGHT: f32 = 1.0e-3;
/// Width of voxels as a share of what is left of a cone's reach.
const END_SHARE: f32 = 0.25;

/// A cone, in voxel edges of level 0.
#[derive(Clone, Copy)]
pub struct Ray {
    /// Where it starts.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Normal of the surface that it leaves: voxels that reach down to its plane do not count. 0 counts all.
    pub normal: Vec3,
    /// Tangent of the half angle.
    pub tangent: f32,
    /// Where it ends, at most.
    pub reach: f32,
}

/// What a cone met.
#[derive(Clone, Copy)]
pub struct Met {
    /// Radiance, in stored units.
    pub light: Vec3,
    /// Share of the cone that met nothing.
    pub through: f32,
    /// Share that met something, each part weighed by the falloff with its distance.
    pub occluded: f32,
    /// The largest optical depth anywhere on the way: of a voxel's width and half of the one before.
    pub densest: f32,
}

/// Optical depth per edge at a point and along a direction, and what a medium tells of what is there, times that depth.
#[derive(Clone, Copy)]
pub struct Sample {
    /// Optical depth per edge of level 0, or of the voxel for a voxel.
    pub density: f32,
    /// That times what the medium tells.
    pub carried: Vec3,
}

impl Sample {
    /// Nothing.
    pub const EMPTY: Self = Self { density: 0.0, carried: Vec3::ZERO };
}

/// Voxels that cones go through.
pub trait Medium {
    /// Where the first voxel of a level is centred, in edges of the level.
    const CENTRE: f32;

    /// What the voxel at a point of a level, none beyond the last, has along `direction`; `cone` is the
    /// [variance](cone_variance) of who looks.
    fn voxel(&self, level: u32, point: UVec3, direction: Vec3, cone: f32) -> Sample;

    /// The radiance of what is met, in stored units, from what samples carry of it; `width` is that of the voxels sampled,
    /// in edges of level 0.
    fn light(&self, carried: Vec3, direction: Vec3, width: f32) -> Vec3;
}

/// The voxels of a pyramid, which carry what they send.
#[derive(Clone, Copy)]
pub struct Pyramid<'a> {
    /// Depth of the pyramid.
    pub depth: u32,
    /// Words before the lobes in the radiance; 0 where there are none.
    pub lobes: u32,
    /// How radiance is stored: [`SHARED_EXPONENT`] or another.
    pub storage: u32,
    /// Blocks of all levels.
    pub blocks: &'a [u32],
    /// Optical depths of all voxels.
    pub depths: &'a [u32],
    /// Numbers, plus one, of the lit voxels.
    pub places: &'a [u32],
    /// What they send.
    pub radiance: &'a [u32],
}

impl Medium for Pyramid<'_> {
    const CENTRE: f32 = 0.0;

    #[inline]
    fn voxel(&self, level: u32, point: UVec3, direction: Vec3, cone: f32) -> Sample {
        let voxel = voxel_at(self.blocks, self.depth, level, point);
        if voxel == NO_VOXEL {
            return Sample::EMPTY;
        }
        let (lobes, storage) = (self.lobes, self.storage);
        sent_toward(voxel, direction, lobes, storage, cone, self.depths, self.places, self.radiance)
    }

    #[inline]
    fn light(&self, carried: Vec3, direction: Vec3, width: f32) -> Vec3 {
        let _ = (direction, width);
        carried
    }
}

/// The six sides of a voxel as a ray meets them.
///
/// What a pair of sides have in common is sent whichever way the ray goes. What one has over the other belongs to a surface that
/// faces its way: along all axes together such surfaces are seen from the front or from behind. Were each axis to
/// decide alone, a slanted wall would show its dark back beside its front, up to half of it.
struct Sides {
    both: Vec3,
    all: Vec3,
    net: Vec3,
}

impl Sides {
    /// The sides, each as `load` gives it, in the order of [`RADIANCE_WORDS`]; `along` are the optical depths, with the signs
    /// of the ray.
    #[inline]
    fn new(along: Vec3, load: impl Fn(u32) -> Vec3) -> Self {
        let mut sides = Self { both: Vec3::ZERO, all: Vec3::ZERO, net: Vec3::ZERO };
        sides.add(load(0), load(1), along.x);
        sides.add(load(2), load(3), along.y);
        sides.add(load(4), load(5), along.z);
        sides
    }

    /// Adds the sides that face up and down an axis; `along` is the optical depth along it, with the sign of the ray.
    #[inline]
    fn add(&mut self, up: Vec3, down: Vec3, along: f32) {
        let weight = abs(along);
        let common = Vec3::new(min(up.x, down.x), min(up.y, down.y), min(up.z, down.z));
        let one = (down - up) * along;
        self.both += common * weight;
        self.all += ((up + down) - common * 2.0) * weight;
        // A ray along +x sees what faces −x.
        self.net += one;
    }

    /// Radiance times depth: sides as a whole are seen from the front where `net` is above 0.
    #[inline]
    fn sum(&self) -> Vec3 {
        let seen = |all: f32, net: f32| clamp(0.5 * all + 2.0 * net, 0.0, all);
        self.both
            + Vec3::new(
                seen(self.all.x, self.net.x),
                seen(self.all.y, self.net.y),
                seen(self.all.z, self.net.z),
            )
    }
}

/// What a voxel sends against `direction`, for each of its edges; `cone` is the [variance](cone_variance) of who looks.
#[inline]
pub(super) fn sent_toward(
    voxel: u32,
    direction: Vec3,
    lobes: u32,
    storage: u32,
    cone: f32,
    depths: &[u32],
    places: &[u32],
    radiance: &[u32],
) -> Sample {
    let depth = unpack_depths(depths[voxel as usize]);
    let along = depth * direction;
    let density = (abs(along.x) + abs(along.y)) + abs(along.z);
    let mut carried = Vec3::ZERO;
    let place = places[voxel as usize];
    if place > 0 {
        let at = RADIANCE_WORDS * (place - 1);
        // One branch, not one for each side: this is the innermost loop.
        let sides = if storage == SHARED_EXPONENT {
            Sides::new(along, move |side| unpack_radiance(radiance[(at + side) as usize]))
        } else {
            Sides::new(along, move |side| load_radiance(radiance, storage, at + side))
        };
        carried = sides.sum();
        if lobes > 0 {
            carried += mirrored(radiance, lobes + LOBE_WORDS * (place - 1), direction, cone) * density;
        }
    }
    Sample { density, carried }
}

/// Interpolates one level between its eight voxels around a point.
#[inline]
fn sample_level<M: Medium>(
    params: &ConeParams,
    ray: &Ray,
    level: u32,
    position: Vec3,
    cone: f32,
    medium: &M,
) -> Sample {
    let edge = (1u32 << level) as f32;
    let mut p = position * div(1.0, edge);
    if M::CENTRE > 0.0 {
        p -= Vec3::splat(M::CENTRE);
    }
    let base = Vec3::new(floor(p.x), floor(p.y), floor(p.z));
    let f = p - base;
    let n = ray.normal;
    // Half of what a voxel spans along the normal, in its edges.
    let half = 0.5 * ((abs(n.x) + abs(n.y)) + abs(n.z));
    let mut sum = Sample::EMPTY;
    let mut whole = 0.0;
    // Beyond −1 a coordinate would count as −1.
    let within = base.x >= -1.0 && base.y >= -1.0 && base.z >= -1.0;
    // Two corners a round: rounds of loops are limited on some devices.
    for edge_along_x in 0..4 {
        let (y, z) = (edge_along_x & 1, edge_along_x >> 1);
        for_two!(0, 2, |x| {
            let offset = Vec3::new(x as f32, y as f32, z as f32);
            let mut weight = (if x == 1 { f.x } else { 1.0 - f.x })
                * (if y == 1 { f.y } else { 1.0 - f.y })
                * (if z == 1 { f.z } else { 1.0 - f.z });
            if half > 0.0 {
                let mut corner = base + offset;
                if M::CENTRE > 0.0 {
                    corner += Vec3::splat(M::CENTRE);
                }
                let height = div(dot(corner * edge - ray.origin, n), edge);
                weight *= saturate(2.0 * (height - params.clearance * half));
            }
            let point = UVec3::new(
                to_u32(base.x + 1.0).wrapping_add(x).wrapping_sub(1),
                to_u32(base.y + 1.0).wrapping_add(y).wrapping_sub(1),
                to_u32(base.z + 1.0).wrapping_add(z).wrapping_sub(1),
            );
            whole += weight;
            if within && weight > 0.0 {
                let sent = medium.voxel(level, point, ray.direction, cone);
                sum.density += sent.density * weight;
                sum.carried += sent.carried * weight;
            }
        });
    }
    // Voxels that do not count are as if unknown: the others stand for them.
    let scale = if whole > LEAST_WEIGHT { div(1.0, whole * edge) } else { 0.0 };
    Sample { density: sum.density * scale, carried: sum.carried * scale }
}

/// How far a ray from `origin` stays within the lattice [0, side]³; 0 if it starts outside and never enters.
#[inline]
fn exit_distance(origin: Vec3, direction: Vec3, side: f32) -> f32 {
    let along = |o: f32, d: f32| {
        if abs(d) < 1.0e-9 { 1.0e9 } else { div((if d > 0.0 { side } else { 0.0 }) - o, d) }
    };
    max(
        min(min(along(origin.x, direction.x), along(origin.y, direction.y)), along(origin.z, direction.z)),
        0.0,
    )
}

/// Returns what a cone meets, front to back; radiance is that of the voxels, through what is before them.
///
/// A step of s edges through a density σ takes 1 − e^(−σs) of what is left: VCT's step correction in closed form. Voxels
/// are `params.width` times as wide as the cone; two levels are mixed by the fraction of the level.
#[inline]
pub fn march<M: Medium>(params: &ConeParams, ray: &Ray, medium: &M) -> Met {
    let side = (1u32 << params.depth) as f32;
    let exit = exit_distance(ray.origin, ray.direction, side);
    let end = min(exit + max(diameter(exit, ray.tangent) * params.width, 1.0), ray.reach);
    let bound = step_count_bound(end, 1.0, params.step);
    let mut met = Met { light: Vec3::ZERO, through: 1.0, occluded: 0.0, densest: 0.0 };
    let cone = cone_variance(ray.tangent);
    let mut recent = 0.0;
    let keep = 1.0 - 0.5 * clamp(params.step, 0.0, 1.0);
    let mut t = params.start;
    let mut steps = 0;
    while t < end && met.through > params.cutoff && steps < bound {
        // Voxels near the end of the reach do not reach beyond it.
        let wanted = min(diameter(t, ray.tangent) * params.width, (ray.reach - t) * END_SHARE);
        let level = mip_level(wanted, params.depth as f32);
        let step = exp2(level) * clamp(params.step, 0.015_625, 64.0);
        let at = t + 0.5 * step;
        let position = ray.origin + ray.direction * at;
        let lower = floor(level);
        let fraction = level - lower;
        let low = to_u32(lower);
        let mut s = sample_level(params, ray, low, position, cone, medium);
        if fraction > 0.0 && low < params.depth {
            let coarse = sample_level(params, ray, low + 1, position, cone, medium);
            s.density += (coarse.density - s.density) * fraction;
            s.carried += (coarse.carried - s.carried) * fraction;
        }
        if s.density > 0.0 {
            let passed = exp(-(s.density * step));
            let taken = met.through * (1.0 - passed);
            let carried = ratio(s.carried, s.density);
            met.light += medium.light(carried, ray.direction, exp2(level)) * taken;
            met.occluded += taken * distance_falloff(at, params.falloff);
            met.through *= passed;
        }
        // A wall lies between two samples: each counts the half of the one before.
        recent = recent * keep + s.density * step;
        met.densest = max(met.densest, recent);
        t += step;
        steps += 1;
    }
    met
}
