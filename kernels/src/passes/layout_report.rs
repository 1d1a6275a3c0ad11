//! Where do the members of each buffer element lie, as this backend's compiler sees it?
//!
//! The pass reports size, alignment and offsets from the device; a test compares them with the host's.

use crate::geometry::bvh::{BvhNode, Hit, TriangleBlock};
use crate::passes::evaluate::{EvaluateParams, Evaluation};
use crate::passes::evaluate_sh::ShVector;
use crate::passes::gather::GatherParams;
use crate::passes::interleaved::InterleavedParams;
use crate::passes::layered_rsm::lookup::LayeredMap;
use crate::passes::layered_rsm::reflect::{ReflectParams, ReflectiveTexel};
use crate::passes::layered_rsm::voxels::ShrinkParams;
use crate::passes::light::LightParams;
use crate::passes::light_map::LightMapParams;
use crate::passes::scene::{Light, Material, Triangle};
use crate::passes::soft_gi::{SoftParams, SphereProxy};
use crate::passes::surface::{CameraParams, Surface};
use crate::passes::upsample::UpsampleParams;
use crate::passes::visibility_filter::gather_voxels::GatherVoxelsParams;
use crate::passes::visibility_filter::gloss::LobeParams;
use crate::passes::visibility_filter::grid::{GridParams, Voxel};
use crate::passes::visibility_filter::list::{ListHeader, ListParams};
use crate::passes::visibility_filter::march::MarchParams;
use crate::passes::visibility_filter::proxy::{Proxy, ProxyParams};
use crate::passes::voxel_cones::build::PyramidParams;
use crate::passes::voxel_cones::inject::PhotonParams;
use crate::passes::voxel_cones::trace::ConeParams;
use crate::passes::voxel_cones::view::VoxelViewParams;
use crate::passes::voxel_cones::voxelise::{VoxeliseParams, WordParams};

gpu_struct! {
    /// Parameters of [`report_layout`].
    pub struct LayoutParams {
        /// Padding: the pass needs none.
        pub pad0: u32,
        /// Padding.
        pub pad1: u32,
        /// Padding.
        pub pad2: u32,
        /// Padding.
        pub pad3: u32,
    }
}

macro_rules! layout_words {
    ($($Type:ident { $($field:ident),* })*) => {
        /// The layout of every listed element: size in bytes, then the byte offset of each member.
        pub const LAYOUT_WORDS: &[u32] = &[$(
            core::mem::size_of::<$Type>() as u32,
            $(core::mem::offset_of!($Type, $field) as u32,)*
        )*];
        /// What each word of [`LAYOUT_WORDS`] is.
        #[cfg(not(target_arch = "spirv"))]
        pub const LAYOUT_NAMES: &[&str] = &[$(
            stringify!($Type),
            $(concat!(stringify!($Type), ".", stringify!($field)),)*
        )*];

        /// Returns word `index` of [`LAYOUT_WORDS`] as this backend's compiler laid the elements out; 0 beyond.
        #[inline]
        #[allow(unused_assignments)]
        pub fn report_layout(index: u32, params: &LayoutParams) -> u32 {
            let _ = params;
            let mut word = 0u32;
            let mut found = 0u32;
            $(
                if word == index { found = core::mem::size_of::<$Type>() as u32; }
                word += 1;
                $(
                    if word == index { found = core::mem::offset_of!($Type, $field) as u32; }
                    word += 1;
                )*
            )*
            found
        }
    };
}

layout_words! {
    BvhNode { min_x, max_x, min_y, max_y, min_z, max_z, children }
    TriangleBlock { x0, y0, z0, x1, y1, z1, x2, y2, z2, triangles }
    Triangle { p0, p1, p2, n0, n1, n2, material }
    Material {
        base, emission, metallic, roughness, cutoff, flags, base_texture, base_size, rough_texture, rough_size,
        emission_texture, emission_size
    }
    Light { position, direction, intensity, kind, inner, outer }
    Hit { t, u, v, triangle }
    Surface { position, normal, diffuse, triangle, material, u, v }
    CameraParams { eye, right, up, forward, width, first_pixel, pixel_width, pixel_height }
    LightParams { eye, first_light, light_count }
    GatherParams { environment, map, rays, seed, flags, falloff, first_pixel, reach }
    EvaluateParams { function, count }
    Evaluation { numbers, words }
    ShVector { c0, c4, c8, c12, c16, c20, c24 }
    Proxy { position, normal, triangle, u, v }
    GridParams { lower, inverse_size, dims, proxies, pairs, weighted, lights }
    Voxel {
        centroid, right_area, right_light, left_area, left_light, up_area, up_light, down_area, down_light,
        near_area, near_light, far_area, far_light, begin, end, lit, mean_area, glossy
    }
    ListHeader { position, normal }
    ProxyParams { density, radius, cells_per_length, seed, triangles, proxies }
    MarchParams {
        lower, cell_inverse_size, cell_dims, voxel_inverse_size, voxel_dims, eye, diffuse_rays, lobe_rays, seed,
        flags, cells_per_length
    }
    ListParams {
        width, height, diffuse_rays, lobe_rays, half_width, half_height, capacity, max_depth_difference,
        min_normal_cosine, occupied
    }
    GatherVoxelsParams {
        eye, width, first_pixel, coarse_width, coarse_height, scale_x, scale_y, near_range, depth_deviation,
        normal_deviation, specular_deviation, capacity, flags, clamp, trust, disc_radius, lights,
        sides
    }
    LobeParams { first_light, light_count, lights, sides }
    InterleavedParams { columns, rows }
    UpsampleParams { width, first_pixel, coarse_width, coarse_height, scale_x, scale_y, filter }
    VoxeliseParams { lower, pairs, thin, depth, first }
    WordParams { offset, count }
    PyramidParams {
        lower, inverse_edge, depth, level, first, child_first, flags, leaves, thin, power_scale, radiance_scale,
        first_lit, child_first_lit, lobes
    }
    PhotonParams { lower, inverse_edge, depth, first, light, projection, size, spread, scale }
    ConeParams {
        lower, eye, environment, map, inverse_edge, depth, cones, tangent, width, step, start, clearance, cutoff,
        falloff, reach, radiance_unit, flags, first, radiance_scale, lobes, maps, light, extent, columns
    }
    LayeredMap {
        origin, right, down, forward, projection, size, level, first, depth_layers, normal_layers, format, flags, texel,
        near, thickness, overlap, window, footprint, least_level, deviation
    }
    ReflectParams { light, radiance_scale, flux, inverse_squared }
    ReflectiveTexel { radiance, normal, depth, cosine }
    ShrinkParams { depth, level, mean, pad }
    SphereProxy { sphere, albedo }
    SoftParams {
        width, height, tile, tiles_x, proxies, order, exponential, terms, tau, shadow_reach, light_reach, operator,
        entries, operator_entries, pairs, parts, fade
    }
    VoxelViewParams { lower, inverse_edge, depth, level, what, lobes, radiance_unit }
    LightMapParams { origin, right, down, forward, projection, size, light, texel, bias }
}
