//! Are samples where they should be, as many as they should be, and worth what they should be?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]

mod oracle;
#[path = "oracle/random.rs"]
mod random;
#[path = "oracle/vector64.rs"]
mod vector64;

use glam::{UVec3, Vec2, Vec3};
use oracle::vector_file;
use random::{Random, SPECIAL};
use std::collections::HashSet;
use twinlight_kernels::math::normalize_or;
use twinlight_kernels::sampling::attenuation::{
    bounded_inverse_square, clamped_inverse_square, disc_form_factor, disc_radius, range_window,
    vpl_form_factor,
};
use twinlight_kernels::sampling::halton::{
    halton, radical_inverse_2, radical_inverse_3, radical_inverse_5, radical_inverse_7, rotated,
};
use twinlight_kernels::sampling::hash::{combine, hash, position_hash, unit_float};
use twinlight_kernels::sampling::hemisphere::{
    cone, cosine_hemisphere, fold_barycentrics, to_world, triangle_point, uniform_sphere,
};
use twinlight_kernels::sampling::roulette::{accept, sample_count};
use twinlight_kernels::sampling::voxel_hash::{decode, encode, fits_u32, voxel_of};
use vector64::exact;

const EPS: f64 = 1.0 / 16_777_216.0;

#[test]
fn the_hash_is_a_bijection_and_mixes() {
    let mut seen = HashSet::new();
    let mut sum = 0.0;
    for i in 0..1u32 << 18 {
        assert!(seen.insert(hash(i)));
        sum += f64::from(unit_float(hash(i)));
    }
    let mean = sum / f64::from(1u32 << 18);
    assert!((mean - 0.5).abs() < 4.0 * (1.0f64 / 12.0).sqrt() / 512.0, "{mean}");
    // Each flipped bit of the input flips half of the output's.
    for bit in 0..32 {
        let flips: u32 =
            (0..4096).map(|i| (hash(i * 7919) ^ hash((i * 7919) ^ (1 << bit))).count_ones()).sum();
        let share = f64::from(flips) / (4096.0 * 32.0);
        assert!((share - 0.5).abs() < 0.02, "bit {bit}: {share}");
    }
    assert_ne!(combine(1, 2), combine(2, 1));
    assert_eq!(unit_float(u32::MAX), 1.0 - EPS as f32);
    assert_eq!(unit_float(255), 0.0);
}

#[test]
fn positions_in_a_cell_share_a_hash() {
    let p = Vec3::new(0.30, -2.71, 5.05);
    let h = position_hash(p, 10.0);
    assert_eq!(h, position_hash(p + Vec3::splat(1e-3), 10.0));
    assert_ne!(h, position_hash(p + Vec3::X * 0.1, 10.0));
    assert_eq!(position_hash(Vec3::ZERO, 1.0), position_hash(-Vec3::ZERO, 1.0));
    // On either side of 0 lie other cells: truncated, −0.3 and 0.3 would share theirs.
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        assert_eq!((-0.3f32) as i32, 0.3f32 as i32, "planted fault");
        assert_ne!(position_hash(axis * -0.3, 1.0), position_hash(axis * 0.3, 1.0));
        assert_eq!(position_hash(axis * -0.3, 1.0), position_hash(axis * -0.9, 1.0));
    }
    let mut random = Random::new(1);
    let hashes: HashSet<u32> = (0..20_000).map(|_| position_hash(random.point(1000.0), 100.0)).collect();
    assert!(hashes.len() > 19_990);
    for a in SPECIAL {
        position_hash(Vec3::new(a, -a, 1.0), 3.0);
    }
}

/// A base's radical inverse in exact integers.
fn rational(index: u64, base: u64) -> f64 {
    let (mut n, mut numerator, mut denominator) = (index, 0u64, 1u64);
    while n > 0 {
        numerator = numerator * base + n % base;
        denominator *= base;
        n /= base;
    }
    numerator as f64 / denominator as f64
}

/// The running product of 1/base: the planted fault.
fn running_product(index: u32, base: u32) -> f32 {
    let (mut n, mut x, mut f) = (index, 0.0f32, 1.0f32);
    let inverse = 1.0 / base as f32;
    while n > 0 {
        f *= inverse;
        x += f * (n % base) as f32;
        n /= base;
    }
    x
}

#[test]
fn halton_vectors_are_reproduced() {
    let file = vector_file("halton");
    let cases = file["cases"].as_array().expect("cases");
    assert_eq!(cases.len(), 28);
    for case in cases {
        let index = case["index"].as_u64().expect("index") as u32;
        let bits = u32::from_str_radix(&case["b2_f32_bits"].as_str().expect("bits")[2..], 16).expect("hex");
        assert_eq!(radical_inverse_2(index).to_bits(), bits, "index {index}");
        if index < 3_486_784_401 {
            let truth = case["b3"]["value"].as_f64().expect("b3");
            assert!((f64::from(radical_inverse_3(index)) - truth).abs() <= 1e-7, "base 3, {index}");
        }
        if index < 1_220_703_125 {
            let truth = case["b5"]["value"].as_f64().expect("b5");
            assert!((f64::from(radical_inverse_5(index)) - truth).abs() <= 1e-7, "base 5, {index}");
        }
    }
}

#[test]
fn radical_inverses_are_below_one_and_stratified() {
    let mut random = Random::new(2);
    type Inverse = fn(u32) -> f32;
    let bases: [(u32, Inverse, u32); 3] = [
        (3, radical_inverse_3, 3_486_784_401),
        (5, radical_inverse_5, 1_220_703_125),
        (7, radical_inverse_7, 1_977_326_743),
    ];
    for (base, function, period) in bases {
        let (mut worst, mut product_worst) = (0.0f64, 0.0f64);
        for i in 0..200_000u32 {
            let index = match i % 4 {
                0 => i,
                1 => period - 1 - i,
                _ => random.below(period),
            };
            let x = function(index);
            assert!((0.0..1.0).contains(&x));
            let truth = rational(index.into(), base.into());
            worst = worst.max((f64::from(x) - truth).abs());
            product_worst = product_worst.max((f64::from(running_product(index, base)) - truth).abs());
        }
        println!("base {base}: error {worst:e}, of a running product {product_worst:e}");
        assert!(worst <= 6e-8 && worst > 1e-9);
        assert!(product_worst > 1e-7, "base {base}: the planted fault was not seen");
        assert_eq!(function(period - 1), 1.0 - EPS as f32, "the last index");
        assert!(function(u32::MAX) < 1.0);
        let count = base.pow(5);
        let strata: HashSet<u32> = (0..count).map(|i| (function(i) * count as f32 + 0.01) as u32).collect();
        assert_eq!(strata.len(), count as usize, "base {base}");
    }
    let strata: HashSet<u32> = (0..1024).map(|i| (radical_inverse_2(i) * 1024.0) as u32).collect();
    assert_eq!(strata.len(), 1024);
    assert!(radical_inverse_2(u32::MAX) < 1.0);
    assert_eq!(halton(5), Vec2::new(0.625, radical_inverse_3(5)));
    assert_eq!(rotated(0.75, 0.5), 0.25);
    assert!(rotated(1.0 - EPS as f32, 1.0) < 1.0 && rotated(0.999_999_9, 0.999_999_94) < 1.0);
}

#[test]
fn voxel_numbers_are_injective_and_decode() {
    let mut random = Random::new(3);
    for dims in [UVec3::new(7, 5, 3), UVec3::new(1, 1, 9), UVec3::new(16, 1, 4)] {
        assert!(fits_u32(dims));
        let mut seen = HashSet::new();
        for i in 0..dims.x * dims.y * dims.z {
            let voxel = UVec3::new(i % dims.x, i / dims.x % dims.y, i / (dims.x * dims.y));
            let number = encode(voxel, dims);
            assert!(seen.insert(number) && number < dims.x * dims.y * dims.z);
            assert_eq!(decode(number, dims), voxel);
        }
    }
    let largest = UVec3::splat(1625);
    for _ in 0..10_000 {
        let voxel = UVec3::new(random.below(1625), random.below(1625), random.below(1625));
        let exact = (u64::from(voxel.z) * 1625 + u64::from(voxel.y)) * 1625 + u64::from(voxel.x);
        assert_eq!(u64::from(encode(voxel, largest)), exact);
        assert_eq!(decode(encode(voxel, largest), largest), voxel);
    }
    assert!(fits_u32(largest) && !fits_u32(UVec3::splat(1626)));
    assert!(fits_u32(UVec3::new(u32::MAX, 1, 1)) && !fits_u32(UVec3::new(65_536, 65_536, 1)));
    assert!(!fits_u32(UVec3::splat(u32::MAX)) && fits_u32(UVec3::new(u32::MAX, u32::MAX, 0)));
    // Planted fault: beyond the limit two voxels do share a number.
    let beyond = UVec3::new(2048, 2048, 2048);
    assert_eq!(encode(UVec3::new(0, 0, 1024), beyond), encode(UVec3::ZERO, beyond));
    assert_eq!(decode(5, UVec3::ZERO), UVec3::new(0, 0, 5));
}

#[test]
fn points_fall_into_their_voxels() {
    let (lower, dims) = (Vec3::new(-1.0, -2.0, 0.5), UVec3::new(4, 8, 2));
    let inverse = Vec3::splat(2.0);
    let of = |p: Vec3| voxel_of(p, lower, inverse, dims);
    assert_eq!(of(lower), UVec3::ZERO);
    assert_eq!(of(lower + Vec3::new(2.0, 4.0, 1.0)), dims - UVec3::ONE, "upper border");
    assert_eq!(of(lower - Vec3::splat(0.3)), UVec3::ZERO, "outside");
    assert_eq!(of(Vec3::new(-0.5, -1.5, 1.0)), UVec3::ONE, "border belongs to the voxel above");
    assert_eq!(of(Vec3::splat(f32::NAN)), UVec3::ZERO);
    assert_eq!(of(Vec3::splat(3e38)), dims - UVec3::ONE);
    assert_eq!(voxel_of(Vec3::ONE, lower, inverse, UVec3::ZERO), UVec3::ZERO);
    let mut random = Random::new(4);
    for _ in 0..50_000 {
        let p = random.point(3.0);
        let cell = |x: f32, low: f32, n: u32| {
            ((f64::from(x - low) * 2.0).floor()).clamp(0.0, f64::from(n) - 1.0) as u32
        };
        let truth =
            UVec3::new(cell(p.x, lower.x, dims.x), cell(p.y, lower.y, dims.y), cell(p.z, lower.z, dims.z));
        assert_eq!(of(p), truth, "{p:?}");
    }
}

#[test]
fn roulette_accepts_the_right_share() {
    for h in [0, 1, 255, 256, 0x8000_0000, u32::MAX] {
        assert!(!accept(h, 0.0) && !accept(h, -1.0) && !accept(h, f32::NAN) && !accept(h, 1e-9));
        assert!(accept(h, 1.0) && accept(h, 7.0));
    }
    assert!(accept(0x7FFF_FFFF, 0.5) && !accept(0x8000_0000, 0.5));
    let mut random = Random::new(5);
    // Sizes over five orders of magnitude; the sum of counts is area × density within 4 sigma.
    for density in [1e-3f32, 0.1, 10.0] {
        let (mut total, mut expected, mut variance, mut inverted) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
        for i in 0..100_000u32 {
            let area = random.log_uniform(1e-4, 10.0).abs();
            let share = area * density;
            let count = sample_count(share, hash(i));
            let exact = f64::from(share);
            total += f64::from(count);
            expected += exact;
            variance += exact.fract() * (1.0 - exact.fract());
            assert!((f64::from(count) - exact).abs() <= 1.0);
            assert_eq!(count, share.floor() as u32 + u32::from(unit_float(hash(i)) < share - share.floor()));
            // Planted fault: the printed rule, accept when the number exceeds the share.
            inverted += exact.floor() + f64::from(u8::from(f64::from(unit_float(hash(i))) > exact.fract()));
        }
        let deviation = (total - expected).abs() / variance.sqrt();
        println!("density {density}: {total} samples, expected {expected}, {deviation:.2} sigma");
        assert!(deviation < 4.0);
        assert!((inverted - expected).abs() / variance.sqrt() > 4.0, "the planted fault was not seen");
    }
    for x in [f32::NAN, f32::INFINITY, -3.0, 0.0, -0.0] {
        assert_eq!(sample_count(x, 0), 0);
    }
    assert_eq!(sample_count(3.0, 0), 3);
    assert_eq!(sample_count(3e38, 0), 4_294_967_040);
}

#[test]
fn directions_have_unit_length_and_the_right_moments() {
    let mut random = Random::new(6);
    let (mut worst, n) = (0.0f64, 1u32 << 16);
    let (mut cosine, mut sphere, mut z_squared) = ([0.0f64; 3], [0.0f64; 3], 0.0f64);
    for i in 0..n {
        let u = halton(i);
        let (c, s) = (exact(cosine_hemisphere(u)), exact(uniform_sphere(u)));
        worst = worst.max((c.length() - 1.0).abs()).max((s.length() - 1.0).abs());
        assert!(c.0[2] >= 0.0);
        for k in 0..3 {
            cosine[k] += c.0[k] / f64::from(n);
            sphere[k] += s.0[k] / f64::from(n);
        }
        z_squared += s.0[2] * s.0[2] / f64::from(n);
        let normal = normalize_or(random.point(1.0), Vec3::Z);
        let turned = exact(to_world(cosine_hemisphere(u), normal));
        assert!((turned.length() - 1.0).abs() < 8.0 * EPS);
        assert!((turned.dot(exact(normal)) - c.0[2]).abs() < 8.0 * EPS);
    }
    println!("length error {:.2} eps, cosine mean {cosine:?}, sphere mean {sphere:?}", worst / EPS);
    assert!(worst <= 4.0 * EPS);
    assert!(cosine[0].abs() < 2e-3 && cosine[1].abs() < 2e-3 && (cosine[2] - 2.0 / 3.0).abs() < 2e-3);
    assert!(sphere.iter().all(|m| m.abs() < 2e-3) && (z_squared - 1.0 / 3.0).abs() < 2e-3);
    assert_eq!(cosine_hemisphere(Vec2::ZERO), Vec3::Z);
    for x in SPECIAL {
        assert!(
            cosine_hemisphere(Vec2::new(x, x)).is_finite() && uniform_sphere(Vec2::new(x, x)).is_finite()
        );
        assert!(fold_barycentrics(Vec2::new(x, x)).is_finite());
    }
}

#[test]
fn barycentrics_are_inside_and_uniform() {
    let (a, b, c) = (Vec3::new(1.0, 0.0, 2.0), Vec3::new(0.0, 3.0, 1.0), Vec3::new(-2.0, 0.0, 0.0));
    let n = 1u32 << 16;
    let mut mean = Vec3::ZERO;
    let edges = [Vec2::new(1.0, 1.0), Vec2::new(1.0, 0.0), Vec2::new(0.0, 1.0), Vec2::new(0.5, 0.5)];
    for i in 0..n {
        let u = if i < 4 { edges[i as usize] } else { halton(i) };
        let w = fold_barycentrics(u);
        assert!(w.x >= 0.0 && w.y >= 0.0 && w.z >= 0.0 && w.max_element() <= 1.0);
        let sum = exact(w).0.iter().sum::<f64>();
        assert!((sum - 1.0).abs() <= 2.0 * EPS, "{u:?}: {sum}");
        mean += triangle_point(a, b, c, w) / n as f32;
    }
    assert!((mean - (a + b + c) / 3.0).length() < 2e-3, "{mean:?}");
}

#[test]
fn cone_sets_cover_the_hemisphere() {
    for count in 1..=32u32 {
        for turn in [0.0f32, 0.37] {
            let (mut sum, mut solid, mut sideways) = (0.0f64, 0.0f64, [0.0f64; 2]);
            for i in 0..count {
                let c = cone(count, i, turn);
                let d = exact(c.direction);
                assert!((d.length() - 1.0).abs() < 4.0 * EPS && d.0[2] > 0.0 && c.weight > 0.0);
                sum += f64::from(c.weight);
                sideways[0] += f64::from(c.weight) * d.0[0];
                sideways[1] += f64::from(c.weight) * d.0[1];
                solid += 1.0 - 1.0 / (1.0 + f64::from(c.tangent).powi(2)).sqrt();
            }
            assert!((sum - 1.0).abs() < 16.0 * EPS, "{count} cones: weights sum to {sum}");
            assert!((solid - 6.0 * (1.0 - 30f64.to_radians().cos())).abs() < 1e-5, "{count}: {solid}");
            let balance = if count < 9 { 1e-6 } else { 0.15 };
            assert!(sideways[0].hypot(sideways[1]) < balance, "{count} cones lean to {sideways:?}");
        }
    }
    let (centre, side) = (cone(6, 0, 0.0), cone(6, 1, 0.0));
    assert_eq!(centre.direction, Vec3::Z);
    assert!((centre.weight - 0.25).abs() < 2e-7 && (side.weight - 0.15).abs() < 2e-7);
    assert!((side.direction - Vec3::new(0.866_025_4, 0.0, 0.5)).length() < 3e-7, "{:?}", side.direction);
    assert!((side.tangent - 0.577_350_26).abs() < 3e-7);
    for (count, index) in [(0, 0), (6, 6), (3, u32::MAX)] {
        assert_eq!(cone(count, index, 0.0).weight, 0.0);
    }
    assert!(cone(6, 3, f32::NAN).direction.is_finite());
}

#[test]
fn a_light_nearby_never_gives_more_than_its_radiance() {
    let mut random = Random::new(7);
    let mut worst = 0.0f64;
    for _ in 0..200_000 {
        let area = random.log_uniform(1e-6, 1e4).abs();
        let r = disc_radius(area);
        let d = r * random.log_uniform(1e-6, 1e4).abs();
        let (c, e) = (random.range(-1.0, 1.0), random.range(-1.0, 1.0));
        let got = disc_form_factor(c, e, d * d, area);
        assert!((0.0..=1.0).contains(&got), "irradiance above pi times radiance");
        let (cosines, d2, a) = (f64::from(c.max(0.0) * e.max(0.0)), f64::from(d * d), f64::from(area));
        let truth = cosines * a / (std::f64::consts::PI * d2 + a);
        worst = worst.max((f64::from(got) - truth).abs() / truth.max(1e-30));
        let bare = cosines * a / (std::f64::consts::PI * d2);
        if d > 10.0 * r {
            assert!((f64::from(got) - bare).abs() <= 0.01 * bare, "far field");
            let ratio = f64::from(bounded_inverse_square(d * d, r)) * d2;
            assert!((0.99..=1.000_001).contains(&ratio));
            assert!((f64::from(clamped_inverse_square(d * d, r)) * d2 - 1.0).abs() < 1e-6);
        }
        // Planted fault: the bare law exceeds the bound nearby.
        if d < 0.1 * r && cosines > 0.1 {
            assert!(bare > 1.0);
        }
        assert!(f64::from(bounded_inverse_square(d * d, r)) * f64::from(r * r) <= 1.000_001);
    }
    println!("form factor error {worst:e}");
    assert!(worst < 1e-6);
    // Continuous at 0: closer and closer changes less and less.
    let at = |d: f32| disc_form_factor(1.0, 1.0, d * d, 0.5);
    assert_eq!(at(0.0), 1.0);
    assert!((at(1e-3) - 1.0).abs() < 1e-5 && at(0.1) < at(0.05) && at(0.05) < at(0.01));
    let vpl = |p: Vec3| vpl_form_factor(Vec3::ZERO, Vec3::Z, p, -Vec3::Z, 0.5);
    assert_eq!(vpl(Vec3::ZERO), 0.0, "the same point");
    assert!((vpl(Vec3::Z) - at(1.0)).abs() < 1e-6 && vpl(-Vec3::Z) == 0.0 && vpl(Vec3::X) == 0.0);
    assert_eq!(range_window(4.0, 0.0), 1.0);
    assert_eq!(range_window(4.0, 2.0), 0.0);
    assert_eq!(range_window(1.0, 2.0), 0.9375);
    for a in SPECIAL {
        for b in SPECIAL {
            let p = Vec3::new(a, b, 1.0);
            let values = [
                disc_form_factor(1.0, a, b, 1.0),
                disc_form_factor(1.0, 1.0, a, b),
                vpl_form_factor(Vec3::ZERO, Vec3::Z, p, -Vec3::Z, a),
                bounded_inverse_square(a, b),
                clamped_inverse_square(a, b),
                range_window(a, b),
                disc_radius(if a.is_finite() { a } else { 0.0 }),
            ];
            assert!(values.iter().all(|v| v.is_finite() && *v >= 0.0), "{a} {b}: {values:?}");
        }
    }
}

#[test]
fn normalize_gives_unit_length_from_1e_38_to_1e38() {
    let mut random = Random::new(8);
    let mut worst = 0.0f64;
    for i in 0..200_000 {
        let mut v = random.direction() * random.log_uniform(1.2e-38, 3e38);
        match i % 5 {
            0 => v = Vec3::new(random.log_uniform(1.2e-38, 3e38), v.y, random.log_uniform(1.2e-38, 3e38)),
            1 => v = Vec3::new(0.0, v.y, -0.0),
            _ => {}
        }
        if v.abs().max_element() < f32::MIN_POSITIVE || !v.is_finite() {
            continue;
        }
        let n = exact(normalize_or(v, Vec3::ZERO));
        worst = worst.max((n.length() - 1.0).abs());
        let along = n.dot(exact(v)) / exact(v).length();
        assert!((along - 1.0).abs() < 8.0 * EPS, "{v:?}");
    }
    println!("length error {:.2} eps", worst / EPS);
    assert!(worst <= 3.0 * EPS);
    let fallback = Vec3::new(0.0, 0.6, 0.8);
    for v in [Vec3::ZERO, -Vec3::ZERO, Vec3::NAN, Vec3::new(1.0, f32::NAN, 0.0), Vec3::INFINITY] {
        assert_eq!(normalize_or(v, fallback), fallback, "{v:?}");
    }
    // Planted fault: without the scaling both ends are lost.
    let naive = |v: Vec3| v / v.dot(v).sqrt();
    assert!(!naive(Vec3::splat(1e-30)).is_finite() && naive(Vec3::splat(1e30)).length() < 0.5);
}

#[test]
fn any_four_by_four_pixels_turn_all_ways() {
    use twinlight_kernels::sampling::interleaved::interleaved_turn;
    for (x0, y0) in [(0, 0), (1, 0), (3, 2), (1022, 4095)] {
        let turns: HashSet<u32> =
            (0..16).map(|k| (interleaved_turn(x0 + k % 4, y0 + k / 4) * 16.0) as u32).collect();
        assert_eq!(turns, (0..16).collect(), "from {x0}, {y0}");
        // Neighbours are at least a quarter of a turn apart, either way round.
        let apart = |a: f32, b: f32| (a - b).abs().min(1.0 - (a - b).abs());
        let own = interleaved_turn(x0, y0);
        assert!(
            apart(own, interleaved_turn(x0 + 1, y0)) >= 0.25
                && apart(own, interleaved_turn(x0, y0 + 1)) >= 0.25
        );
        // Planted fault: rows that are alike have four ways only.
        let alike: HashSet<u32> = (0..16).map(|k| (interleaved_turn(x0 + k % 4, y0) * 16.0) as u32).collect();
        assert_eq!(alike.len(), 4);
    }
}
