//! Which row measures each kernel, and which kernels need none?

/// File under kernels/src, its functions and the kernel that a row names.
pub(super) const ROWS: &[(&str, &[(&str, &str)])] = &[
    ("cone/composite.rs", &[("composite", "compositing"), ("accumulate", "accumulation")]),
    (
        "cone/occlusion.rs",
        &[
            ("distance_falloff", "falloff with distance"),
            ("faded_opacity", "faded opacity"),
            ("with", "mean of cones"),
            ("mean", "mean of cones"),
        ],
    ),
    (
        "cone/step.rs",
        &[
            ("corrected_opacity", "step correction"),
            ("premultiplied_scale", "premultiplied scale"),
            ("corrected_sample", "corrected sample"),
            ("aperture_tangent", "aperture tangent"),
            ("diameter", "cone diameter"),
            ("mip_level", "mip level"),
            ("step_length", "step length"),
            ("step_count_bound", "bound of steps"),
        ],
    ),
    (
        "gaussian/bilateral.rs",
        &[
            ("depth_similarity", "depth similarity"),
            ("normal_similarity", "normal similarity"),
            ("plane_similarity", "plane similarity"),
            ("upsampling_weights", "upsampling weights"),
            ("place_weights", "weights by place"),
            ("gaussian_falloff", "Gaussian falloff"),
            ("geometric_weight", "geometric weight"),
            ("gathering_weights", "gathering weights"),
            ("mean_or_zero", "mean or 0"),
            ("shares_visibility", "shared visibility"),
        ],
    ),
    (
        "gaussian/depth_window.rs",
        &[
            ("depth_coverage", "depth window"),
            ("variance_from_moments", "variance of moments"),
            ("weighted_moments", "moments over opacity"),
            ("minimum_deviation", "least deviation"),
            ("layer_coordinate", "layer coordinate"),
            ("smooth_step", "smooth step"),
            ("layer_decay", "layer weight"),
        ],
    ),
    (
        "gaussian/lobe.rs",
        &[
            ("lobe_of_mean", "lobe of a mean"),
            ("length_to_variance", "lobe variance"),
            ("variance_to_length", "lobe length"),
            ("spread_to_variance", "lobe variance of a spread"),
            ("convolve_lengths", "lobe convolution"),
            ("cone_deviation", "cone deviation"),
            ("von_mises_fisher_concentration", "concentration"),
        ],
    ),
    (
        "gaussian/specular.rs",
        &[
            ("one_minus_cosine", "1 - cos"),
            ("lobe_offset", "lobe offset 1 - cos^n"),
            ("specular_falloff", "specular falloff"),
            ("specular_weight", "specular weight"),
        ],
    ),
    (
        "geometry/box_.rs",
        &[
            ("new", "ray-box"),
            ("pad_bounds", "ray-box"),
            ("box_interval", "ray-box"),
            ("four_boxes", "ray-four boxes"),
        ],
    ),
    ("geometry/bvh.rs", &[("nearest_hit", "nearest hit"), ("any_hit", "any hit")]),
    ("geometry/disc.rs", &[("ray_disc", "ray-disc")]),
    (
        "geometry/overlap.rs",
        &[("overlaps_conservative", "overlap, conservative"), ("overlaps_thin", "overlap, thin")],
    ),
    (
        "geometry/triangle.rs",
        &[
            ("new", "ray-triangle"),
            ("ray_triangle", "ray-triangle"),
            ("four_triangles", "ray-four triangles"),
        ],
    ),
    ("geometry/voxel_walk.rs", &[("new", "voxel walk"), ("step", "voxel walk")]),
    ("math/mod.rs", &[("div", "div"), ("recip", "div"), ("sqrt", "sqrt")]),
    ("math/strict/basics.rs", &[("floor", "floor"), ("to_i32", "to_i32"), ("to_u32", "to_u32")]),
    (
        "math/strict/division.rs",
        &[("two_product", "exact product"), ("two_sum", "exact sum"), ("div_software", "div")],
    ),
    ("math/strict/error_function.rs", &[("erf", "erf")]),
    ("math/strict/exponential.rs", &[("exp2", "exp2"), ("exp", "exp"), ("exp_minus_one", "exp_minus_one")]),
    ("math/strict/logarithm.rs", &[("log2", "log2"), ("ln", "ln"), ("ln_one_plus", "ln_one_plus")]),
    ("math/strict/power.rs", &[("powi", "powi"), ("pow_fast", "pow_fast"), ("pow", "pow")]),
    ("math/strict/root.rs", &[("sqrt", "sqrt"), ("sqrt_software", "sqrt"), ("rsqrt", "rsqrt")]),
    (
        "math/strict/trigonometry.rs",
        &[("sin_cos_turn", "sin_turn"), ("sin_cos", "sin"), ("acos", "acos"), ("atan2", "atan2")],
    ),
    (
        "math/vector.rs",
        &[
            ("dot", "dot product"),
            ("cross", "cross product"),
            ("dot4", "dot product of four"),
            ("length", "length"),
            ("normalize_or", "normalize"),
            ("orthonormal_frame", "frame of a direction"),
            ("transform_point", "transformed point"),
        ],
    ),
    (
        "sampling/attenuation.rs",
        &[
            ("disc_form_factor", "form factor of a disc"),
            ("vpl_form_factor", "form factor of a light"),
            ("bounded_inverse_square", "bounded inverse square"),
            ("clamped_inverse_square", "clamped inverse square"),
            ("range_window", "end of a light's range"),
            ("disc_radius", "radius of a disc"),
        ],
    ),
    (
        "sampling/halton.rs",
        &[
            ("radical_inverse_2", "radical inverse"),
            ("radical_inverse_3", "radical inverse"),
            ("radical_inverse_5", "radical inverse"),
            ("radical_inverse_7", "radical inverse"),
            ("halton", "radical inverse"),
            ("rotated", "rotated point"),
        ],
    ),
    (
        "sampling/hash.rs",
        &[("hash", "hash"), ("unit_float", "number of a hash"), ("position_hash", "hash of a place")],
    ),
    (
        "sampling/hemisphere.rs",
        &[
            ("cosine_hemisphere", "cosine hemisphere"),
            ("phong_lobe_direction", "Phong lobe"),
            ("uniform_sphere", "uniform sphere"),
            ("to_world", "direction in space"),
            ("fold_barycentrics", "folded weights"),
            ("triangle_point", "point of a triangle"),
            ("cone", "cone of a set"),
        ],
    ),
    ("sampling/roulette.rs", &[("accept", "acceptance"), ("sample_count", "sample count")]),
    ("sampling/voxel_hash.rs", &[("voxel_of", "voxel of a point")]),
    (
        "sh/basis.rs",
        &[
            ("basis", "SH basis"),
            ("basis_order2", "SH basis"),
            ("basis_order3", "SH basis"),
            ("basis_order4", "SH basis"),
            ("basis_order5", "SH basis"),
            ("dot", "SH dot product"),
            ("add_scaled", "SH projection"),
            ("project", "SH projection"),
            ("evaluate", "SH value"),
        ],
    ),
    (
        "sh/blocker.rs",
        &[
            ("blocker", "blocker"),
            ("averaged_operator", "averaged operator"),
            ("averaged_operator_fit", "averaged operator"),
            ("exact_operator", "light of a sphere"),
        ],
    ),
    ("sh/emitter.rs", &[("lambert_intensity", "intensity of emitters")]),
    (
        "sh/exponential.rs",
        &[
            ("norm_without_dc", "SH norm without DC"),
            ("clamp_to_feasible", "SH clamp"),
            ("hybrid", "SH exponential"),
            ("hybrid_with_table", "SH exponential"),
            ("optimal_linear", "SH exponential"),
            ("taylor", "SH exponential"),
            ("product_series", "SH exponential"),
            ("occluded_dc", "SH coverage"),
        ],
    ),
    (
        "sh/logarithm.rs",
        &[
            ("occlusion_key", "occlusion key"),
            ("log_occlusion", "log table"),
            ("influence_key", "influence key"),
            ("influence_weight", "influence weight"),
        ],
    ),
    ("sh/product.rs", &[("product", "SH product"), ("square", "SH square")]),
    ("sh/rotation.rs", &[("rotate", "SH rotation")]),
    (
        "sh/zonal.rs",
        &[
            ("cap", "SH cap"),
            ("cap_solid_angle", "SH cap's solid angle"),
            ("visibility", "SH visibility"),
            ("rotate_zonal", "SH visibility"),
            ("convolve", "SH convolution"),
            ("irradiance", "SH irradiance"),
        ],
    ),
];

const INTEGERS: &str = "integers alone";
const CHOOSES: &str = "chooses among inputs or bits, rounds nothing";
const DRIVER: &str = "the driver's: its errors are the fast GPU columns";

/// File under kernels/src, its functions without a row and why.
pub(super) const EXCLUDED: &[(&str, &[&str], &str)] = &[
    (
        "geometry/lattice.rs",
        &[
            "blocks_along",
            "level_offset",
            "block_count",
            "bit_count",
            "nth_bit",
            "point_bit",
            "block_of",
            "voxel_at",
            "point_of",
            "pack_point",
            "unpack_point",
        ],
        INTEGERS,
    ),
    (
        "math/fast.rs",
        &["log2", "ln", "sin_cos", "sin_cos_turn", "acos", "atan2", "pow_fast", "pow", "rsqrt"],
        DRIVER,
    ),
    (
        "math/strict/basics.rs",
        &["is_nan", "is_finite", "min", "max", "clamp", "saturate", "abs", "copy_sign"],
        CHOOSES,
    ),
    ("math/strict/basics.rs", &["min_u32", "exp2_integer"], INTEGERS),
    ("math/vector.rs", &["without_faint", "max_abs"], CHOOSES),
    ("sampling/hash.rs", &["combine"], INTEGERS),
    ("sampling/interleaved.rs", &["interleaved_turn"], "sixteenths of an integer, exact"),
    ("sampling/voxel_hash.rs", &["encode", "decode", "fits_u32"], INTEGERS),
    ("sh/basis.rs", &["is_finite"], CHOOSES),
];
