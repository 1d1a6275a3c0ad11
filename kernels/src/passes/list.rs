//! Which passes exist? The one list that entry points, dispatchers, bindings, tests and benchmarks follow.

/// Calls `callback!` with every pass.
///
/// Each entry reads `shape name(Params; binding input: Element, …) -> binding output: Element, tolerance;` where
/// `tolerance` says how far the *fast* GPU result may lie from the strict one. Adding a pass is a function and a
/// parameter struct in this folder, a re-export in `passes/mod.rs`, and one line here.
#[macro_export]
macro_rules! for_each_pass {
    ($callback:ident) => {
        $callback! {
            // Vulkan allows sin and cos 2⁻¹¹, acos 4096 ULP; acos is what lavapipe is worst at.
            /// Elementary functions over arrays.
            map evaluate_elementary(ElementaryParams; 1 x: f32, 2 y: f32) -> 3 values: f32,
                Tolerance::Relative { relative: 1e-3, absolute: 5e-4, flips: 0.0 };
            /// Vector algebra over arrays.
            map evaluate_vector(EvaluateParams; 1 a: Vec4, 2 b: Vec4) -> 3 values: Vec4,
                Tolerance::Relative { relative: 1e-6, absolute: 1e-6, flips: 0.0 };
            /// Hashes, sequences, counts and direction sets over arrays.
            map evaluate_sampling(EvaluateParams; 1 words: UVec4, 2 x: Vec4, 3 y: Vec4) -> 4 values: Evaluation,
                Tolerance::Relative { relative: 2e-6, absolute: 1e-6, flips: 0.0 };
            // Many of the test's rays pass exactly through edges, where a contracted product decides otherwise.
            /// Intersections, voxel walks and overlaps over arrays.
            map evaluate_geometry(EvaluateParams; 1 a: Vec4, 2 b: Vec4, 3 c: Vec4, 4 d: Vec4, 5 e: Vec4)
                -> 6 values: Evaluation, Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 0.02 };
            // exp as of NVIDIA's H200: 1.8e-5.
            /// Gaussian lobes, weights and depth windows over arrays.
            map evaluate_gaussian(EvaluateParams; 1 a: Vec4, 2 b: Vec4, 3 c: Vec4) -> 4 values: Vec4,
                Tolerance::Relative { relative: 2e-5, absolute: 1e-6, flips: 0.0 };
            // exp2 and log2 as of NVIDIA's H200: 3.8e-5.
            /// Cone steps and compositing over arrays.
            map evaluate_cone(EvaluateParams; 1 a: Vec4, 2 b: Vec4) -> 3 values: Vec4,
                Tolerance::Relative { relative: 5e-5, absolute: 1e-6, flips: 0.0 };
            /// Spherical harmonics of order 3: linear operations and products.
            map evaluate_sh3(EvaluateParams; 1 a: ShVector, 2 b: ShVector, 3 arguments: Vec4) -> 4 vectors: ShVector,
                Tolerance::Relative { relative: 5e-7, absolute: 5e-7, flips: 0.0 };
            /// Spherical harmonics of order 3: logarithms and exponentials.
            map evaluate_sh3_exponential(EvaluateParams; 1 a: ShVector, 2 arguments: Vec4, 3 table: f32)
                -> 4 vectors: ShVector, Tolerance::Relative { relative: 5e-6, absolute: 2e-5, flips: 0.0 };
            /// Spherical harmonics of order 4: linear operations and products.
            map evaluate_sh4(EvaluateParams; 1 a: ShVector, 2 b: ShVector, 3 arguments: Vec4) -> 4 vectors: ShVector,
                Tolerance::Relative { relative: 5e-7, absolute: 5e-7, flips: 0.0 };
            /// Spherical harmonics of order 4: logarithms and exponentials.
            map evaluate_sh4_exponential(EvaluateParams; 1 a: ShVector, 2 arguments: Vec4, 3 table: f32)
                -> 4 vectors: ShVector, Tolerance::Relative { relative: 5e-6, absolute: 2e-5, flips: 0.0 };
            /// Spherical harmonics of order 5: linear operations and products.
            map evaluate_sh5(EvaluateParams; 1 a: ShVector, 2 b: ShVector, 3 arguments: Vec4) -> 4 vectors: ShVector,
                Tolerance::Relative { relative: 5e-7, absolute: 5e-7, flips: 0.0 };
            /// Sizes and offsets of the buffer elements.
            map report_layout(LayoutParams;) -> 1 words: u32, Tolerance::Exact;
            /// Sums of blocks of counts.
            map block_sums(ScanParams; 1 values: u32) -> 2 sums: u32, Tolerance::Exact;
            /// Exclusive scan within blocks.
            map scan_blocks(ScanParams; 1 values: u32) -> 2 within: u32, Tolerance::Exact;
            /// Exclusive scan over all blocks.
            map add_block_offsets(ScanParams; 1 within: u32, 2 offsets: u32) -> 3 scanned: u32, Tolerance::Exact;
            /// Indices of the items that carry a flag.
            scatter compact_indices(CompactParams; 1 flags: u32, 2 places: u32) -> 3 indices: u32, Tolerance::Exact;
            /// Histogram of a digit per block of keys.
            scatter count_digits(DigitParams; 1 items: u32) -> 2 counts: u32, Tolerance::Exact;
            /// Stable placement by a digit.
            scatter place_by_digit(DigitParams; 1 items: u32, 2 offsets: u32) -> 3 sorted: u32, Tolerance::Exact;
            /// Sums of eight vectors as a binary tree.
            map reduce_sum(ReduceParams; 1 values: Vec4) -> 2 sums: Vec4,
                Tolerance::Relative { relative: 1e-6, absolute: 1e-6, flips: 0.0 };
            // Here and below: a contracted product lets a ray that passes an edge decide otherwise.
            /// What the ray through each pixel meets first.
            map trace_primary(CameraParams; 1 nodes: BvhNode, 2 blocks: TriangleBlock, 3 triangles: Triangle,
                4 materials: Material, 5 texels: u32) -> 6 hits: Hit,
                Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 5e-3 };
            /// The surface at each hit.
            map resolve_surfaces(CameraParams; 1 hits: Hit, 2 triangles: Triangle, 3 materials: Material,
                4 texels: u32) -> 5 surfaces: Surface,
                Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 1e-3 };
            /// Specular colour and exponent of each surface.
            map resolve_gloss(CameraParams; 1 surfaces: Surface, 2 materials: Material, 3 texels: u32) -> 4 gloss: Vec4,
                Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 0.0 };
            /// Emitted radiance of each surface.
            map resolve_emission(CameraParams; 1 surfaces: Surface, 2 materials: Material, 3 texels: u32)
                -> 4 radiance: Vec4, Tolerance::Relative { relative: 1e-5, absolute: 1e-6, flips: 0.0 };
            /// Shadow rays: which lights each surface sees.
            map light_visibility(LightParams; 1 surfaces: Surface, 2 lights: Light, 3 nodes: BvhNode,
                4 blocks: TriangleBlock, 5 triangles: Triangle, 6 materials: Material, 7 texels: u32)
                -> 8 visible: u32, Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 5e-3 };
            // acos of the driver decides how far inside a spot's rim a point is.
            /// Diffuse reflection of the visible lights.
            map shade_diffuse(LightParams; 1 surfaces: Surface, 2 lights: Light, 3 visibility: u32, 4 previous: Vec4)
                -> 5 radiance: Vec4, Tolerance::Relative { relative: 1e-4, absolute: 5e-5, flips: 0.0 };
            // pow of the driver may be off by exponent · 2⁻²¹, 5e-4 at the largest exponent.
            /// Specular reflection of the visible lights.
            map shade_specular(LightParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 lights: Light, 4 visibility: u32,
                5 previous: Vec4) -> 6 radiance: Vec4,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-4, flips: 0.0 };
            // acos and atan2 of the driver say where on the environment map a ray ends; neighbours differ by factors.
            /// Diffuse reflection of the environment and of emissive surfaces.
            map gather_direct(GatherParams; 1 surfaces: Surface, 2 nodes: BvhNode, 3 blocks: TriangleBlock,
                4 triangles: Triangle, 5 materials: Material, 6 texels: u32, 7 previous: Vec4) -> 8 radiance: Vec4,
                Tolerance::Relative { relative: 2e-3, absolute: 1e-3, flips: 1e-2 };
            /// Cosine-weighted openness of each surface.
            map ambient_openness(GatherParams; 1 surfaces: Surface, 2 nodes: BvhNode, 3 blocks: TriangleBlock,
                4 triangles: Triangle, 5 materials: Material, 6 texels: u32) -> 7 openness: f32,
                Tolerance::Relative { relative: 1e-6, absolute: 1e-6, flips: 1e-2 };
            /// The sum of two buffers of radiance.
            map add_radiance(AddParams; 1 a: Vec4, 2 b: Vec4) -> 3 sum: Vec4,
                Tolerance::Relative { relative: 1e-6, absolute: 0.0, flips: 0.0 };
            /// The environment behind the surfaces.
            map fill_background(CameraParams; 1 environment: GatherParams, 2 surfaces: Surface, 3 texels: u32,
                4 previous: Vec4) -> 5 radiance: Vec4,
                Tolerance::Relative { relative: 2e-3, absolute: 1e-3, flips: 0.0 };
            /// `previous` plus what surfaces reflect diffusely of known light.
            map add_diffuse_reflection(AddParams; 1 surfaces: Surface, 2 light: Vec4, 3 previous: Vec4)
                -> 4 radiance: Vec4, Tolerance::Relative { relative: 1e-6, absolute: 0.0, flips: 0.0 };
            /// `previous` plus what surfaces reflect specularly of known light.
            map add_specular_reflection(AddParams; 1 gloss: Vec4, 2 light: Vec4, 3 previous: Vec4)
                -> 4 radiance: Vec4, Tolerance::Relative { relative: 1e-6, absolute: 0.0, flips: 0.0 };
            /// A fine picture from a coarse one, weighted by depth and normal.
            map upsample(UpsampleParams; 1 surfaces: Surface, 2 coarse_surfaces: Surface, 3 values: Vec4)
                -> 4 fine: Vec4, Tolerance::Relative { relative: 1e-4, absolute: 1e-5, flips: 1e-3 };
            /// The mean of a pixel's neighbourhood over about one plane, in which directions are turned in all ways.
            map filter_interleaved(InterleavedParams; 1 surfaces: Surface, 2 values: Vec4)
                -> 3 means: Vec4, Tolerance::Relative { relative: 1e-4, absolute: 1e-5, flips: 1e-3 };
            /// What each ray of a light's map meets first.
            map trace_light_map(LightMapParams; 1 nodes: BvhNode, 2 blocks: TriangleBlock, 3 triangles: Triangle,
                4 materials: Material, 5 texels: u32) -> 6 hits: Hit,
                Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 5e-3 };
            /// Which surfaces a light's map shows.
            map light_map_visibility(LightMapParams; 1 surfaces: Surface, 2 hits: Hit, 3 previous: u32)
                -> 4 visible: u32, Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 5e-3 };
            // A contracted area may tip the roulette.
            /// Proxies of each triangle.
            map proxy_counts(ProxyParams; 1 triangles: Triangle) -> 2 counts: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 5e-3 };
            /// Point proxies on the triangles.
            map make_proxies(ProxyParams; 1 starts: u32, 2 triangles: Triangle, 3 materials: Material, 4 texels: u32)
                -> 5 proxies: Proxy, Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 1e-3 };
            /// Proxies as surfaces seen from either side.
            map proxy_surfaces(ProxyParams; 1 proxies: Proxy, 2 triangles: Triangle, 3 materials: Material,
                4 texels: u32) -> 5 surfaces: Surface,
                Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 1e-3 };
            /// The voxel of each proxy's centre, as pairs to sort.
            map proxy_keys(GridParams; 1 proxies: Proxy) -> 2 pairs: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-3 };
            /// Proxies in the order of their voxels.
            map reorder_proxies(GridParams; 1 pairs: u32, 2 proxies: Proxy) -> 3 ordered: Proxy, Tolerance::Exact;
            /// Where each voxel's pairs begin.
            map cell_starts(GridParams; 1 pairs: u32) -> 2 starts: u32, Tolerance::Exact;
            /// How many cells each proxy overlaps.
            map overlap_counts(GridParams; 1 proxies: Proxy) -> 2 counts: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-3 };
            /// The cells that each proxy overlaps, as pairs to sort.
            map overlap_pairs(GridParams; 1 starts: u32, 2 proxies: Proxy) -> 3 pairs: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-3 };
            /// Sides of proxies before any light, with their openness.
            map dark_sides(GridParams; 1 openness: f32) -> 2 radiance: Vec4, Tolerance::Exact;
            // As for shade_diffuse, times the height of a lobe.
            /// Lobes of the lights that glossy sides mirror, behind the sides' radiance.
            map add_lobes(LobeParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 lights: Light, 4 visibility: u32,
                5 previous: Vec4) -> 6 radiance: Vec4,
                Tolerance::Relative { relative: 1e-3, absolute: 5e-5, flips: 0.0 };
            /// What each voxel sends out.
            map sum_voxels(GridParams; 1 starts: u32, 2 proxies: Proxy, 3 radiance: Vec4) -> 4 voxels: Voxel,
                Tolerance::Relative { relative: 1e-4, absolute: 1e-5, flips: 0.0 };
            /// The voxel that each ray of a coarse pixel meets first, by proxies.
            map march_rays(MarchParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 starts: u32, 4 pairs: u32,
                5 proxies: Proxy) -> 6 voxels: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            /// The voxel that each ray of a coarse pixel meets first, by triangles.
            map trace_rays(MarchParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 nodes: BvhNode, 4 blocks: TriangleBlock,
                5 triangles: Triangle, 6 materials: Material, 7 texels: u32) -> 8 voxels: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            /// Which share of each specular lobe ends on the scene.
            map lobe_coverage(MarchParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 voxels: u32) -> 4 coverage: f32,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-4, flips: 0.0 };
            /// The rays of each pixel in order of voxels.
            scatter sort_rays(ListParams; 1 voxels: u32) -> 2 sorted: u32, Tolerance::Exact;
            /// The voxels that each pixel's rays met, each once.
            scatter count_rays(ListParams; 1 sorted: u32) -> 2 counted: u32, Tolerance::Exact;
            // Thresholds of planes and normals may tip.
            /// The visibility filter: lists of the voxels that a window of pixels sees.
            scatter filter_lists(ListParams; 1 surfaces: Surface, 2 counted: u32) -> 3 lists: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            /// Position, normal and lobe coverage of each coarse pixel.
            map list_headers(ListParams; 1 surfaces: Surface, 2 coverage: f32) -> 3 headers: ListHeader,
                Tolerance::Relative { relative: 1e-5, absolute: 1e-6, flips: 1e-3 };
            // Shares of voxels near the threshold; up to 0.6 % on NVIDIA's H200.
            /// Light from visible voxels: irradiance/π.
            map gather_diffuse(GatherVoxelsParams; 1 surfaces: Surface, 2 headers: ListHeader, 3 lists: u32,
                4 voxels: Voxel, 5 proxies: Proxy, 6 radiance: Vec4) -> 7 light: Vec4,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-5, flips: 1e-2 };
            /// Light from visible voxels in the specular lobe.
            map gather_specular(GatherVoxelsParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 headers: ListHeader,
                4 lists: u32, 5 voxels: Voxel, 6 proxies: Proxy, 7 radiance: Vec4) -> 8 light: Vec4,
                Tolerance::Relative { relative: 2e-3, absolute: 1e-4, flips: 1e-3 };
            // Discs of one triangle lie in one plane: which is nearest is a matter of rounding, for 7.5 % of pixels on NVIDIA's H200.
            /// The proxies as discs.
            map draw_proxies(CameraParams; 1 grid: GridParams, 2 starts: u32, 3 pairs: u32, 4 proxies: Proxy,
                5 radiance: Vec4) -> 6 picture: Vec4,
                Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 0.1 };
            /// All triangles in the cell that is the whole.
            map root_pairs(VoxeliseParams;) -> 1 pairs: u32, Tolerance::Exact;
            // Triangles that touch a cell's border may tip.
            /// Which children of a cell a triangle meets.
            map child_masks(VoxeliseParams; 1 pairs: u32, 2 triangles: Triangle) -> 3 masks: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            /// How many children that are.
            map mask_counts(VoxeliseParams; 1 masks: u32) -> 2 counts: u32, Tolerance::Exact;
            /// The children with their triangles.
            map child_pairs(VoxeliseParams; 1 starts: u32, 2 masks: u32, 3 pairs: u32) -> 4 children: u32,
                Tolerance::Exact;
            /// Points of the lattice that are voxels.
            scatter mark_voxels(VoxeliseParams; 1 pairs: u32) -> 2 masks: u32, Tolerance::Exact;
            /// A level's words in the buffer of all levels.
            scatter place_words(WordParams; 1 words: u32) -> 2 all: u32, Tolerance::Exact;
            /// Points of a level that lie over voxels of the level below.
            map parent_masks(PyramidParams; 1 children: u32) -> 2 masks: u32, Tolerance::Exact;
            /// Voxels of each block of the lattice.
            map block_counts(PyramidParams; 1 masks: u32) -> 2 counts: u32, Tolerance::Exact;
            /// Blocks of the lattice, ready to be looked up.
            map pack_blocks(PyramidParams; 1 masks: u32, 2 starts: u32) -> 3 blocks: u32, Tolerance::Exact;
            /// Where each voxel lies.
            map voxel_points(PyramidParams; 1 blocks: u32) -> 2 points: u32, Tolerance::Exact;
            // A clipped corner may move by a rounding, and with it a count of 2⁻²⁰ of a face.
            // Rounded areas: 6.8 % of the words differ by one on NVIDIA's H200.
            /// What triangles cover of their voxels.
            scatter accumulate_leaves(PyramidParams; 1 pairs: u32, 2 blocks: u32, 3 triangles: Triangle,
                4 materials: Material, 5 texels: u32) -> 6 sums: u32,
                Tolerance::Relative { relative: 1e-3, absolute: 64.0, flips: 0.1 };
            /// Optical depths of the leaves.
            map leaf_depths(PyramidParams; 1 sums: u32) -> 2 depths: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 2e-2 };
            /// Optical depths of the voxels above.
            map filter_depths(PyramidParams; 1 points: u32, 2 blocks: u32, 3 children: u32) -> 4 depths: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 2e-2 };
            /// Leaves that photons meet.
            scatter mark_lit(PhotonParams; 1 hits: Hit, 2 triangles: Triangle, 3 blocks: u32) -> 4 flags: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            // The driver's acos decides how far inside a spot's rim a photon is.
            /// The power that photons leave with the leaves.
            scatter inject_photons(PhotonParams; 1 hits: Hit, 2 triangles: Triangle, 3 materials: Material,
                4 texels: u32, 5 lights: Light, 6 blocks: u32, 7 places: u32) -> 8 power: u32,
                Tolerance::Relative { relative: 1e-3, absolute: 64.0, flips: 2e-2 };
            /// Leaves in which something emits.
            scatter mark_emissive(PyramidParams; 1 pairs: u32, 2 blocks: u32, 3 triangles: Triangle,
                4 materials: Material, 5 texels: u32) -> 6 flags: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            /// The power that surfaces emit in the leaves.
            scatter inject_emission(PyramidParams; 1 pairs: u32, 2 blocks: u32, 3 triangles: Triangle,
                4 materials: Material, 5 texels: u32, 6 places: u32) -> 7 power: u32,
                Tolerance::Relative { relative: 1e-3, absolute: 64.0, flips: 2e-2 };
            /// Numbers of the lit voxels.
            map lit_places(PyramidParams; 1 flags: u32, 2 starts: u32) -> 3 places: u32, Tolerance::Exact;
            // Colours are nine bits: one may round the other way.
            /// Radiance of the lit leaves.
            map lit_radiance(PyramidParams; 1 lit: u32, 2 sums: u32, 3 power: u32) -> 4 radiance: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 2e-2 };
            /// Voxels above lit ones.
            scatter mark_lit_parents(PyramidParams; 1 lit: u32, 2 points: u32, 3 blocks: u32) -> 4 flags: u32,
                Tolerance::Exact;
            /// Radiance of the lit voxels above the leaves.
            scatter filter_radiance(PyramidParams; 1 lit: u32, 2 points: u32, 3 blocks: u32, 4 depths: u32,
                5 children: u32, 6 radiance: u32) -> 7 filtered: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 5e-2 };
            /// Openness by cones.
            map cone_openness(ConeParams; 1 surfaces: Surface, 2 blocks: u32, 3 depths: u32, 4 places: u32,
                5 radiance: u32) -> 6 openness: f32,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 2e-3 };
            /// Light from voxels all around: irradiance/π.
            map cone_diffuse(ConeParams; 1 surfaces: Surface, 2 blocks: u32, 3 depths: u32, 4 places: u32,
                5 radiance: u32) -> 6 light: Vec4,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 2e-3 };
            /// Light from voxels in the specular lobe.
            map cone_specular(ConeParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 blocks: u32, 4 depths: u32,
                5 places: u32, 6 radiance: u32, 7 texels: u32) -> 8 light: Vec4,
                Tolerance::Relative { relative: 2e-3, absolute: 1e-3, flips: 2e-3 };
            /// Radiance that leaves reflect of other voxels.
            map bounce_radiance(ConeParams; 1 points: u32, 2 sums: u32, 3 blocks: u32, 4 depths: u32, 5 places: u32,
                6 radiance: u32, 7 texels: u32) -> 8 bounced: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 5e-2 };
            /// Radiance of the leaves with a bounce more.
            map add_bounce(ConeParams; 1 places: u32, 2 radiance: u32, 3 bounced: u32) -> 4 sum: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 2e-2 };
            /// Leaves with any light.
            map mark_bright(PyramidParams; 1 radiance: u32, 2 places: u32, 3 direct: u32) -> 4 flags: u32, Tolerance::Exact;
            /// Radiance of the leaves with light.
            map keep_lit(PyramidParams; 1 lit: u32, 2 radiance: u32) -> 3 kept: u32, Tolerance::Exact;
            /// What glossy leaves mirror of photons, and from where to where.
            scatter inject_lobes(PhotonParams; 1 hits: Hit, 2 triangles: Triangle, 3 materials: Material,
                4 texels: u32, 5 lights: Light, 6 blocks: u32, 7 places: u32) -> 8 power: u32,
                Tolerance::Relative { relative: 1e-3, absolute: 64.0, flips: 2e-2 };
            /// Lobes of the lit leaves.
            scatter lit_lobes(PyramidParams; 1 lit: u32, 2 sums: u32, 3 power: u32) -> 4 lobes: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 5e-2 };
            /// Lobes of the lit voxels above the leaves.
            scatter filter_lobes(PyramidParams; 1 lit: u32, 2 points: u32, 3 blocks: u32, 4 depths: u32,
                5 children: u32, 6 lobes: u32) -> 7 filtered: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-1 };
            /// Lobes of the leaves that are lit by more.
            map keep_lobes(PyramidParams; 1 lit: u32, 2 places: u32, 3 radiance: u32) -> 4 kept: u32, Tolerance::Exact;
            /// Points of the lattice that are voxels of what stands still or of what moves.
            map merge_marks(PyramidParams; 1 blocks: u32, 2 marks: u32) -> 3 merged: u32, Tolerance::Exact;
            /// What standing triangles cover of the leaves.
            map carry_leaves(PyramidParams; 1 points: u32, 2 blocks: u32, 3 sums: u32) -> 4 carried: u32,
                Tolerance::Exact;
            /// Optical depths, filtered anew above what moves.
            map update_depths(PyramidParams; 1 points: u32, 2 blocks: u32, 3 children: u32, 4 standing_blocks: u32,
                5 standing_depths: u32, 6 marks: u32) -> 7 depths: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 2e-2 };
            /// Boxes around the receivers of tiles.
            map tile_bounds(SoftParams; 1 surfaces: Surface) -> 2 bounds: Vec4, Tolerance::Exact;
            // A sphere of influence may touch a box just so.
            /// How many proxies reach each tile.
            map tile_counts(SoftParams; 1 bounds: Vec4, 2 proxies: SphereProxy) -> 3 counts: u32,
                Tolerance::Relative { relative: 0.0, absolute: 1.0, flips: 0.0 };
            /// Which proxies those are.
            scatter tile_lists(SoftParams; 1 bounds: Vec4, 2 proxies: SphereProxy, 3 starts: u32) -> 4 lists: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            /// Logarithms of the visibility past proxies, added up.
            map accumulate_occlusion(SoftParams; 1 surfaces: Surface, 2 proxies: SphereProxy, 3 starts: u32,
                4 counts: u32, 5 lists: u32, 6 table: f32) -> 7 logarithms: ShVector,
                Tolerance::Relative { relative: 1e-4, absolute: 1e-4, flips: 0.0 };
            // Each product adds its factor's error.
            /// Visibility past proxies, multiplied.
            map multiply_visibility(SoftParams; 1 surfaces: Surface, 2 proxies: SphereProxy, 3 starts: u32,
                4 counts: u32, 5 lists: u32) -> 6 occlusion: ShVector,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 0.0 };
            // Squaring doubles relative errors up to twelve times.
            /// Visibility past all proxies, order 2.
            map exponentiate2(SoftParams; 1 logarithms: ShVector, 2 table: f32) -> 3 occlusion: ShVector,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 0.0 };
            /// Visibility past all proxies, order 3.
            map exponentiate3(SoftParams; 1 logarithms: ShVector, 2 table: f32) -> 3 occlusion: ShVector,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 0.0 };
            /// Visibility past all proxies, order 4.
            map exponentiate4(SoftParams; 1 logarithms: ShVector, 2 table: f32) -> 3 occlusion: ShVector,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 0.0 };
            /// Visibility past all proxies, order 5.
            map exponentiate5(SoftParams; 1 logarithms: ShVector, 2 table: f32) -> 3 occlusion: ShVector,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 0.0 };
            /// Light of the surroundings past proxies.
            map shade_shadowed(SoftParams; 1 surfaces: Surface, 2 occlusion: ShVector, 3 light: ShVector)
                -> 4 shadowed: Vec4, Tolerance::Relative { relative: 1e-4, absolute: 1e-4, flips: 0.0 };
            /// Light that proxies reflect, and their solid angle.
            map accumulate_indirect(SoftParams; 1 surfaces: Surface, 2 proxies: SphereProxy, 3 starts: u32,
                4 counts: u32, 5 lists: u32, 6 light: ShVector, 7 table: f32) -> 8 reflected: Vec4,
                Tolerance::Relative { relative: 1e-4, absolute: 1e-4, flips: 0.0 };
            /// Both lights together.
            map combine_soft(SoftParams; 1 shadowed: Vec4, 2 reflected: Vec4) -> 3 light: Vec4,
                Tolerance::Relative { relative: 1e-4, absolute: 1e-5, flips: 0.0 };
            /// The voxels of a level as cubes.
            map draw_voxels(CameraParams; 1 view: VoxelViewParams, 2 blocks: u32, 3 depths: u32, 4 places: u32,
                5 radiance: u32) -> 6 picture: Vec4,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 1e-2 };
            // Where a triangle's middle within a voxel is may tip, and with it whether there is a hole.
            /// Bits of the voxels that triangles meet.
            scatter mark_bits(PyramidParams; 1 pairs: u32, 2 triangles: Triangle, 3 materials: Material, 4 texels: u32)
                -> 5 voxels: u32, Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            /// Bytes of the voxels above.
            map shrink_voxels(ShrinkParams; 1 below: u32) -> 2 voxels: u32,
                Tolerance::Relative { relative: 0.0, absolute: 0.0, flips: 1e-2 };
            // Packed values at a rounding's edge may tip.
            /// Reflective shadow map of a light.
            map reflect_light(ReflectParams; 1 hits: Hit, 2 triangles: Triangle, 3 materials: Material, 4 texels: u32,
                5 lights: Light) -> 6 reflected: ReflectiveTexel,
                Tolerance::Relative { relative: 1e-5, absolute: 1e-5, flips: 2e-2 };
            /// Layers of a reflective shadow map.
            scatter split_layers(LayeredMap; 1 reflected: ReflectiveTexel) -> 2 layers: u32,
                Tolerance::Relative { relative: 0.0, absolute: 64.0, flips: 2e-2 };
            /// A level of the layers from the one below.
            scatter shrink_layers(LayeredMap; 1 below: u32) -> 2 layers: u32,
                Tolerance::Relative { relative: 0.0, absolute: 64.0, flips: 2e-2 };
            /// Light from layered reflective shadow maps: irradiance/π.
            map layered_diffuse(ConeParams; 1 surfaces: Surface, 2 voxels: u32, 3 maps: LayeredMap, 4 layers: u32)
                -> 5 light: Vec4, Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 2e-3 };
            /// Light from layered reflective shadow maps in the specular lobe.
            map layered_specular(ConeParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 voxels: u32, 4 maps: LayeredMap,
                5 layers: u32, 6 texels: u32) -> 7 light: Vec4,
                Tolerance::Relative { relative: 2e-3, absolute: 1e-3, flips: 2e-3 };
            /// The share of a light with an extent that each surface sees.
            map shadow_cone(ConeParams; 1 surfaces: Surface, 2 lights: Light, 3 voxels: u32) -> 4 visible: f32,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-3, flips: 2e-3 };
            /// Diffuse reflection of a light that is seen in part.
            map shade_soft_diffuse(LightParams; 1 surfaces: Surface, 2 lights: Light, 3 visible: f32, 4 previous: Vec4)
                -> 5 radiance: Vec4, Tolerance::Relative { relative: 1e-4, absolute: 5e-5, flips: 0.0 };
            /// Specular reflection of a light that is seen in part.
            map shade_soft_specular(LightParams; 1 surfaces: Surface, 2 gloss: Vec4, 3 lights: Light, 4 visible: f32,
                5 previous: Vec4) -> 6 radiance: Vec4,
                Tolerance::Relative { relative: 1e-3, absolute: 1e-4, flips: 0.0 };
        }
    };
}
