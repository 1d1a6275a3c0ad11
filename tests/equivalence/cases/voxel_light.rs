//! Inputs of the passes that light a pyramid of voxels and look at it: the random scenes of `voxelised`.

use super::arrays::scanned;
use super::scene::launch;
use super::voxelised::{DEPTH, MAP, Voxelised, at};
use super::voxels::items;
use crate::body::Launch;
use crate::case;
use crate::common::draw::Draw;
use twinlight_kernels::passes::elements::*;
use twinlight_kernels::passes::voxel_cones::lobes::LOBE_WORDS;
use twinlight_kernels::passes::voxel_cones::storage::storage_of;
use twinlight_kernels::passes::voxel_cones::view::{VIEW_LOBES, VIEW_RADIANCE};

pub fn mark_lit(draw: &mut Draw) -> Vec<case::mark_lit> {
    Voxelised::all(draw)
        .map(|v| case::mark_lit {
            launch: Launch::new("a map", v.params.leaves as usize, MAP * MAP),
            params: v.photons,
            hits: v.hits,
            triangles: v.world.triangles,
            blocks: v.blocks,
        })
        .into()
}

pub fn inject_photons(draw: &mut Draw) -> Vec<case::inject_photons> {
    Voxelised::all(draw)
        .map(|v| case::inject_photons {
            launch: Launch::new("a map", v.power.len(), MAP * MAP),
            params: v.photons,
            hits: v.hits,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
            lights: v.world.lights,
            blocks: v.blocks,
            places: v.places,
        })
        .into()
}

pub fn mark_emissive(draw: &mut Draw) -> Vec<case::mark_emissive> {
    Voxelised::all(draw)
        .map(|v| case::mark_emissive {
            launch: Launch::new("all pairs", v.params.leaves as usize, v.pairs.len() as u32 / 2),
            params: v.params,
            pairs: v.pairs,
            blocks: v.blocks,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
        })
        .into()
}

pub fn inject_emission(draw: &mut Draw) -> Vec<case::inject_emission> {
    Voxelised::all(draw)
        .map(|v| case::inject_emission {
            launch: Launch::new("all pairs", v.power.len(), v.pairs.len() as u32 / 2),
            params: v.params,
            pairs: v.pairs,
            blocks: v.blocks,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
            places: v.places,
        })
        .into()
}

pub fn lit_places(draw: &mut Draw) -> Vec<case::lit_places> {
    Voxelised::all(draw)
        .map(|v| case::lit_places {
            launch: items("leaves", v.flags.len()),
            params: PyramidParams { first_lit: 7, ..v.params },
            starts: scanned(&v.flags),
            flags: v.flags,
        })
        .into()
}

pub fn lit_radiance(draw: &mut Draw) -> Vec<case::lit_radiance> {
    Voxelised::stored(draw)
        .into_iter()
        .map(|v| case::lit_radiance {
            launch: v.stored_as(items("lit leaves", v.radiance.len())),
            params: v.params,
            lit: v.lit,
            sums: v.sums,
            power: v.power,
        })
        .collect()
}

pub fn mark_lit_parents(draw: &mut Draw) -> Vec<case::mark_lit_parents> {
    Voxelised::all(draw)
        .map(|v| {
            let (params, count) = at(&v.params, &v.firsts, 1);
            case::mark_lit_parents {
                launch: Launch::new("level 1", count as usize, v.lit.len() as u32),
                params,
                lit: v.lit,
                points: v.points[0].clone(),
                blocks: v.blocks,
            }
        })
        .into()
}

pub fn filter_radiance(draw: &mut Draw) -> Vec<case::filter_radiance> {
    Voxelised::stored(draw)
        .into_iter()
        .map(|v| {
            let (params, count) = at(&v.params, &v.firsts, 1);
            case::filter_radiance {
                launch: v.stored_as(Launch::new("all of level 1", (count * v.voxel_words()) as usize, count)),
                params,
                lit: (0..count).collect(),
                points: v.points[1].clone(),
                blocks: v.blocks,
                depths: v.depths,
                children: v.places,
                radiance: v.radiance,
            }
        })
        .collect()
}

pub fn cone_openness(draw: &mut Draw) -> Vec<case::cone_openness> {
    Voxelised::all(draw)
        .map(|v| case::cone_openness {
            launch: launch("pixels"),
            params: v.cones(),
            radiance: v.radiance_and_lobes(),
            places: v.all_places(),
            surfaces: v.world.surfaces,
            blocks: v.blocks,
            depths: v.depths,
        })
        .into()
}

pub fn cone_diffuse(draw: &mut Draw) -> Vec<case::cone_diffuse> {
    Voxelised::stored(draw)
        .into_iter()
        .map(|v| case::cone_diffuse {
            launch: launch("pixels"),
            params: v.cones(),
            radiance: v.radiance_and_lobes(),
            places: v.all_places(),
            surfaces: v.world.surfaces,
            blocks: v.blocks,
            depths: v.depths,
        })
        .collect()
}

pub fn cone_specular(draw: &mut Draw) -> Vec<case::cone_specular> {
    Voxelised::stored(draw)
        .into_iter()
        .map(|v| case::cone_specular {
            launch: launch("pixels"),
            params: v.cones(),
            radiance: v.radiance_and_lobes(),
            places: v.all_places(),
            gloss: v.world.gloss(),
            surfaces: v.world.surfaces,
            blocks: v.blocks,
            depths: v.depths,
            texels: v.world.texels,
        })
        .collect()
}

pub fn bounce_radiance(draw: &mut Draw) -> Vec<case::bounce_radiance> {
    Voxelised::stored(draw)
        .into_iter()
        .map(|v| case::bounce_radiance {
            launch: v.stored_as(items("leaves", (v.params.leaves * v.voxel_words()) as usize)),
            params: v.cones(),
            radiance: v.radiance_and_lobes(),
            places: v.all_places(),
            points: v.points[0].clone(),
            sums: v.sums,
            blocks: v.blocks,
            depths: v.depths,
            texels: v.world.texels,
        })
        .collect()
}

/// Words of radiance like those of leaves.
fn bounced(v: &Voxelised) -> Vec<u32> {
    v.radiance.iter().copied().cycle().take((v.params.leaves * v.voxel_words()) as usize).collect()
}

pub fn add_bounce(draw: &mut Draw) -> Vec<case::add_bounce> {
    Voxelised::stored(draw)
        .into_iter()
        .map(|v| case::add_bounce {
            launch: v.stored_as(items("leaves", (v.params.leaves * v.voxel_words()) as usize)),
            params: v.cones(),
            places: v.all_places(),
            bounced: bounced(&v),
            radiance: v.radiance,
        })
        .collect()
}

pub fn mark_bright(draw: &mut Draw) -> Vec<case::mark_bright> {
    Voxelised::stored(draw)
        .into_iter()
        .map(|v| case::mark_bright {
            launch: items("leaves", v.params.leaves as usize),
            params: PyramidParams { lobes: v.radiance.len() as u32, ..v.params },
            radiance: bounced(&v),
            places: v.all_places(),
            direct: v.radiance_and_lobes(),
        })
        .collect()
}

pub fn keep_lit(draw: &mut Draw) -> Vec<case::keep_lit> {
    Voxelised::stored(draw)
        .into_iter()
        .map(|v| case::keep_lit {
            launch: items("lit leaves", v.lit.len() * v.voxel_words() as usize),
            params: v.params,
            radiance: bounced(&v),
            lit: v.lit,
        })
        .collect()
}

pub fn inject_lobes(draw: &mut Draw) -> Vec<case::inject_lobes> {
    Voxelised::all(draw)
        .map(|v| case::inject_lobes {
            launch: Launch::new("all photons", v.lobe_power.len(), MAP * MAP),
            params: v.photons,
            hits: v.hits,
            triangles: v.world.triangles,
            materials: v.world.materials,
            texels: v.world.texels,
            lights: v.world.lights,
            blocks: v.blocks,
            places: v.places,
        })
        .into()
}

pub fn lit_lobes(draw: &mut Draw) -> Vec<case::lit_lobes> {
    Voxelised::all(draw)
        .map(|v| {
            assert!(v.lobes.iter().filter(|&&w| w != 0).count() > 40, "few leaves mirror anything");
            case::lit_lobes {
                launch: Launch::new("lit leaves", v.lobes.len(), v.lit.len() as u32),
                params: v.params,
                lit: v.lit,
                sums: v.sums,
                power: v.lobe_power,
            }
        })
        .into()
}

pub fn filter_lobes(draw: &mut Draw) -> Vec<case::filter_lobes> {
    Voxelised::all(draw)
        .map(|v| {
            let (params, count) = at(&v.params, &v.firsts, 1);
            case::filter_lobes {
                launch: Launch::new("all of level 1", (count * LOBE_WORDS) as usize, count),
                params,
                lit: (0..count).collect(),
                points: v.points[1].clone(),
                blocks: v.blocks,
                depths: v.depths,
                children: v.places,
                lobes: v.lobes,
            }
        })
        .into()
}

pub fn keep_lobes(draw: &mut Draw) -> Vec<case::keep_lobes> {
    Voxelised::all(draw)
        .map(|v| case::keep_lobes {
            launch: items("leaves", (v.params.leaves * LOBE_WORDS) as usize),
            params: PyramidParams { lobes: v.radiance.len() as u32, ..v.params },
            lit: (0..v.params.leaves).collect(),
            places: v.all_places(),
            radiance: v.radiance_and_lobes(),
        })
        .into()
}

pub fn draw_voxels(draw: &mut Draw) -> Vec<case::draw_voxels> {
    let mut cases = Vec::new();
    for v in Voxelised::stored(draw) {
        for (level, what) in [(0, VIEW_RADIANCE), (0, VIEW_LOBES), (2, VIEW_RADIANCE)] {
            let view = VoxelViewParams {
                lower: v.params.lower,
                inverse_edge: v.params.inverse_edge,
                depth: DEPTH,
                level,
                what,
                lobes: v.radiance.len() as u32,
                radiance_unit: 2.0,
                storage: storage_of(v.params.flags),
                ..Default::default()
            };
            cases.push(case::draw_voxels {
                launch: launch(&format!("level {level}, {what}")),
                params: v.world.camera,
                view: vec![view],
                blocks: v.blocks.clone(),
                depths: v.depths.clone(),
                places: v.all_places(),
                radiance: v.radiance_and_lobes(),
            });
        }
    }
    cases
}
