//! Which work items run over buffers, and what binds to each?
//!
//! A pass is one of two shapes:
//!
//! - **map**: `fn(index, &Params, inputs…) -> Output`; the dispatcher stores the value at `index`.
//! - **scatter**: `fn(index, &Params, inputs…, &mut impl Accumulate)`; the output takes only commutative,
//!   associative integer operations, so its sum does not depend on the order of threads.
//!
//! All of them stand in one list, [`for_each_pass!`](crate::for_each_pass). Work items never ask a slice for its
//! length: counts come in the parameters, because an empty buffer cannot be bound on a GPU.

/// Does the same for one or two items from the first on, in their order: rounds of loops are limited on some devices.
macro_rules! for_two {
    ($first:expr, $end:expr, |$at:ident| $body:block) => {
        let $at = $first;
        $body
        if $first + 1 < $end {
            let $at = $first + 1;
            $body
        }
    };
}

mod accumulate;
pub mod combine;
mod describe;
pub mod elementary;
pub mod evaluate;
pub mod evaluate_cone;
pub mod evaluate_gaussian;
pub mod evaluate_geometry;
pub mod evaluate_sampling;
pub mod evaluate_sh;
pub mod evaluate_vector;
pub mod gather;
pub mod interleaved;
pub mod layered_rsm;
pub mod layout_report;
pub mod light;
pub mod light_map;
#[macro_use]
mod list;
pub mod material;
pub mod reduction;
pub mod scan;
pub mod scene;
pub mod soft_gi;
pub mod sort;
pub mod surface;
pub mod upsample;
pub mod visibility_filter;
pub mod voxel_cones;

pub use accumulate::{Accumulate, Launch};
pub use combine::{add_diffuse_reflection, add_radiance, add_specular_reflection};
pub use describe::{BindingInfo, PASSES, PassInfo, PassTiming, Shape, Tolerance, info};
pub use elementary::evaluate_elementary;
pub use evaluate_cone::evaluate_cone;
pub use evaluate_gaussian::evaluate_gaussian;
pub use evaluate_geometry::evaluate_geometry;
pub use evaluate_sampling::evaluate_sampling;
pub use evaluate_sh::{
    evaluate_sh3, evaluate_sh3_exponential, evaluate_sh4, evaluate_sh4_exponential, evaluate_sh5,
};
pub use evaluate_vector::evaluate_vector;
pub use gather::{ambient_openness, fill_background, gather_direct};
pub use interleaved::filter_interleaved;
pub use layered_rsm::layers::{shrink_layers, split_layers};
pub use layered_rsm::reflect::reflect_light;
pub use layered_rsm::shadow::{shade_soft_diffuse, shade_soft_specular, shadow_cone};
pub use layered_rsm::trace::{layered_diffuse, layered_specular};
pub use layered_rsm::voxels::{mark_bits, shrink_voxels};
pub use layout_report::report_layout;
pub use light::{light_visibility, shade_diffuse, shade_specular};
pub use light_map::{light_map_visibility, trace_light_map};
pub use reduction::reduce_sum;
pub use scan::{add_block_offsets, block_sums, compact_indices, scan_blocks};
pub use soft_gi::accumulate::{
    accumulate_occlusion, exponentiate2, exponentiate3, exponentiate4, exponentiate5, multiply_visibility,
};
pub use soft_gi::cull::{tile_bounds, tile_counts, tile_lists};
pub use soft_gi::indirect::accumulate_indirect;
pub use soft_gi::shade::{combine_soft, shade_shadowed};
pub use sort::{count_digits, place_by_digit};
pub use surface::{resolve_emission, resolve_gloss, resolve_surfaces, trace_primary};
pub use upsample::upsample;
pub use visibility_filter::gather_reflection::gather_specular;
pub use visibility_filter::gather_voxels::gather_diffuse;
pub use visibility_filter::gloss::add_lobes;
pub use visibility_filter::grid::{
    cell_starts, dark_sides, overlap_counts, overlap_pairs, proxy_keys, reorder_proxies, sum_voxels,
};
pub use visibility_filter::list::{count_rays, filter_lists, list_headers, sort_rays};
pub use visibility_filter::march::{lobe_coverage, march_rays, trace_rays};
pub use visibility_filter::proxy::{make_proxies, proxy_counts, proxy_surfaces};
pub use visibility_filter::view::draw_proxies;
pub use voxel_cones::build::{
    accumulate_leaves, block_counts, filter_depths, leaf_depths, pack_blocks, parent_masks, voxel_points,
};
pub use voxel_cones::filter::{filter_radiance, keep_lit, lit_places, mark_bright, mark_lit_parents};
pub use voxel_cones::inject::{inject_emission, inject_photons, lit_radiance, mark_emissive, mark_lit};
pub use voxel_cones::lobes::{filter_lobes, inject_lobes, keep_lobes, lit_lobes};
pub use voxel_cones::moving::{carry_leaves, merge_marks, update_depths};
pub use voxel_cones::trace::{add_bounce, bounce_radiance, cone_diffuse, cone_openness, cone_specular};
pub use voxel_cones::view::draw_voxels;
pub use voxel_cones::voxelise::{
    child_masks, child_pairs, mark_voxels, mask_counts, place_words, root_pairs,
};

/// Every type that the pass list names, for the places that call [`for_each_pass!`](crate::for_each_pass).
pub mod elements {
    pub use super::combine::AddParams;
    pub use super::describe::Tolerance;
    pub use super::elementary::ElementaryParams;
    pub use super::evaluate::{EvaluateParams, Evaluation};
    pub use super::evaluate_sh::ShVector;
    pub use super::gather::GatherParams;
    pub use super::interleaved::InterleavedParams;
    pub use super::layered_rsm::lookup::LayeredMap;
    pub use super::layered_rsm::reflect::{ReflectParams, ReflectiveTexel};
    pub use super::layered_rsm::voxels::ShrinkParams;
    pub use super::layout_report::LayoutParams;
    pub use super::light::LightParams;
    pub use super::light_map::LightMapParams;
    pub use super::reduction::ReduceParams;
    pub use super::scan::{CompactParams, ScanParams};
    pub use super::scene::{Light, Material, Triangle};
    pub use super::soft_gi::{SoftParams, SphereProxy};
    pub use super::sort::DigitParams;
    pub use super::surface::{CameraParams, Surface};
    pub use super::upsample::UpsampleParams;
    pub use super::visibility_filter::gather_voxels::GatherVoxelsParams;
    pub use super::visibility_filter::gloss::LobeParams;
    pub use super::visibility_filter::grid::{GridParams, Voxel};
    pub use super::visibility_filter::list::{ListHeader, ListParams};
    pub use super::visibility_filter::march::MarchParams;
    pub use super::visibility_filter::proxy::{Proxy, ProxyParams};
    pub use super::voxel_cones::build::PyramidParams;
    pub use super::voxel_cones::inject::PhotonParams;
    pub use super::voxel_cones::trace::ConeParams;
    pub use super::voxel_cones::view::VoxelViewParams;
    pub use super::voxel_cones::voxelise::{VoxeliseParams, WordParams};
    pub use crate::geometry::bvh::{BvhNode, Hit, TriangleBlock};
    pub use glam::{UVec4, Vec4};
}
