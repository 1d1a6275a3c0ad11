//! Do basis, zonal vectors, products and rotations agree with their definitions in float64?

// Oracles and planted faults may use what kernels may not.
#![allow(clippy::disallowed_methods)]
// Coefficients and bands are numbered.
#![allow(clippy::needless_range_loop)]

#[path = "oracle/draw.rs"]
mod draw;
mod oracle;
#[path = "oracle/sh.rs"]
mod sh_oracle;

use draw::{Draw, EDGES};
use glam::{Mat3, Vec3};
use oracle::{numbers, vector_file};
use serde_json::Value;
use std::f64::consts::PI;
use twinlight_kernels::sh::*;

fn cases(file: &Value) -> &Vec<Value> {
    file["cases"].as_array().unwrap()
}

fn vec3(v: &[f64]) -> Vec3 {
    Vec3::new(v[0] as f32, v[1] as f32, v[2] as f32)
}

/// The numbers as f32; the vectors' inputs are exact.
fn array<const N: usize>(v: &[f64]) -> [f32; N] {
    std::array::from_fn(|i| v[i] as f32)
}

/// Largest absolute difference; lengths must agree and NaN counts as infinite.
fn worst(got: &[f32], want: &[f64]) -> f64 {
    assert_eq!(got.len(), want.len());
    got.iter().zip(want).fold(0.0, |w: f64, (&g, &t)| {
        let e = (f64::from(g) - t).abs();
        if e.is_nan() { f64::INFINITY } else { w.max(e) }
    })
}

fn random<const N: usize>(draw: &mut Draw) -> [f32; N] {
    std::array::from_fn(|_| draw.normal())
}

fn wide(v: &[f32]) -> Vec<f64> {
    v.iter().map(|&x| f64::from(x)).collect()
}

#[test]
fn basis_meets_the_vectors_and_the_definition() {
    let file = vector_file("sh_basis");
    let mut error = 0.0f64;
    let mut unsigned = 0.0f64;
    for case in cases(&file) {
        let (d, want) = (vec3(&numbers(&case["dir"])), numbers(&case["y"]));
        let y = basis_order5(d);
        error = error.max(worst(&y, &want));
        let mut flipped = y;
        flipped[3] = -flipped[3];
        unsigned = unsigned.max(worst(&flipped, &want));
    }
    println!("basis: {error:.2e} absolute on the vectors");
    assert!(error <= 4e-7);
    assert!(unsigned > 0.1, "planted fault: the other sign convention");

    let mut draw = Draw::new(31);
    let mut band_error = [0.0f64; 5];
    for _ in 0..50_000 {
        let d = draw.direction();
        let y = basis_order5(Vec3::from_array(d));
        let want = sh_oracle::basis(5, draw_normalised(d));
        for l in 0..5 {
            band_error[l] =
                band_error[l].max(worst(&y[l * l..(l + 1) * (l + 1)], &want[l * l..(l + 1) * (l + 1)]));
        }
        assert_eq!(&y[..4], &basis_order2(Vec3::from_array(d)));
        assert_eq!(&y[..9], &basis_order3(Vec3::from_array(d)));
        assert_eq!(&y[..16], &basis_order4(Vec3::from_array(d)));
    }
    println!("basis per band against unit directions: {band_error:?}");
    for (error, stated) in band_error.iter().zip([1.5e-8, 5.1e-8, 1.6e-7, 2.8e-7, 5.4e-7]) {
        assert!(*error <= stated && *error > 0.1 * stated, "{error:e}, stated {stated:e}");
    }
}

/// The unit vector nearest to an f32 direction.
fn draw_normalised(d: [f32; 3]) -> [f64; 3] {
    let d = d.map(f64::from);
    let r = sh_oracle::norm(&d);
    d.map(|c| c / r)
}

#[test]
fn basis_obeys_the_addition_theorem() {
    let mut draw = Draw::new(32);
    let (mut error, mut faulty) = (0.0f64, 0.0f64);
    for _ in 0..20_000 {
        let (a, b) = (draw.direction(), draw.direction());
        let (ya, yb) = (basis_order5(Vec3::from_array(a)), basis_order5(Vec3::from_array(b)));
        let cosine: f64 = (0..3).map(|c| draw_normalised(a)[c] * draw_normalised(b)[c]).sum();
        for l in 0..5usize {
            let want = (2 * l + 1) as f64 / (4.0 * PI) * sh_oracle::legendre(l, cosine);
            let sum = |from: usize| {
                (from..(l + 1) * (l + 1)).map(|i| f64::from(ya[i]) * f64::from(yb[i])).sum::<f64>()
            };
            error = error.max((sum(l * l) - want).abs());
            if l > 0 {
                faulty = faulty.max((sum(l * l + 1) - want).abs());
            }
        }
    }
    println!("addition theorem: {error:.2e}");
    assert!(error <= 1e-6);
    assert!(faulty > 0.1, "planted fault: one function left out");
}

#[test]
fn projection_and_evaluation_are_inverse() {
    let mut draw = Draw::new(33);
    let f: [f32; 16] = random(&mut draw);
    let mut sum = [0.0f32; 16];
    for (d, w) in sh_oracle::sphere_quadrature(5) {
        let d = vec3(&d);
        sum = project(&sum, d, evaluate(&f, d) * w as f32);
    }
    assert!(worst(&sum, &wide(&f)) < 1e-5);
    assert_eq!(dot(&f, &add_scaled(&[0.0; 16], &f, 2.0)), 2.0 * dot(&f, &f));
    assert!(is_finite(&f) && !is_finite(&[0.0, f32::NAN, 0.0, 0.0]) && !is_finite(&[f32::INFINITY; 4]));
}

#[test]
fn caps_meet_the_vectors_and_their_limits() {
    let file = vector_file("cap_zh");
    let mut error = 0.0f64;
    for case in cases(&file) {
        let alpha = case["alpha"].as_f64().unwrap() as f32;
        let (want, open) = (numbers(&case["cap_zh"]), numbers(&case["visibility_zh"]));
        let (v, o) = (cap::<5>(alpha), visibility::<5>(alpha));
        for l in 0..5 {
            // Relative to α²: bands 3 and 4 pass through 0.
            let scale = if l < 3 { want[l].abs() } else { want[l].abs().max(f64::from(alpha).powi(2) * 0.3) };
            if scale > 0.0 {
                error = error.max((f64::from(v[l]) - want[l]).abs() / scale);
            } else {
                assert_eq!(f64::from(v[l]), want[l]);
            }
            let opening = (f64::from(o[l]) - open[l]).abs();
            assert!(
                opening <= 3e-7 * (1.0 + open[l].abs()),
                "alpha {alpha} band {l}: {opening:e}, {} {}",
                o[l],
                open[l]
            );
        }
        let omega = case["omega"].as_f64().unwrap();
        assert!((f64::from(cap_solid_angle(alpha)) - omega).abs() <= 3e-7 * omega);
        assert_eq!(cap::<3>(alpha), v[..3]);
    }
    println!("cap: {error:.2e} relative");
    assert!(error <= 3e-7);
    let alpha = 1e-3f32;
    let naive = 1.0 - (1.0 - alpha * alpha).sqrt();
    assert!((f64::from(naive) / sh_oracle::key(alpha.into()) - 1.0).abs() > 1e-2, "planted fault: 1 − cos");

    let mut previous = -1.0f32;
    for i in 0..=2000 {
        let v = cap::<5>(i as f32 / 2000.0);
        assert!(v[0] >= previous, "DC grows with the cap");
        previous = v[0];
    }
    for alpha in [1e-6f32, 1e-5, 1e-4] {
        for l in 0..5 {
            let ratio = f64::from(cap::<5>(alpha)[l]) / f64::from(alpha).powi(2);
            let limit = (PI * (2 * l + 1) as f64).sqrt() / 2.0;
            assert!((ratio / limit - 1.0).abs() <= 3e-7, "alpha {alpha} band {l}");
        }
    }
    let hemisphere = cap::<5>(1.0);
    assert!(
        worst(&hemisphere, &[PI.sqrt(), (3.0 * PI).sqrt() / 2.0, 0.0, -(7.0 * PI).sqrt() / 8.0, 0.0]) < 3e-7
    );
    for alpha in EDGES.into_iter().chain([f32::NAN, f32::INFINITY]) {
        assert!(cap::<5>(alpha).iter().chain(&visibility::<5>(alpha)).all(|v| v.is_finite()));
    }
}

#[test]
fn zonal_rotation_and_convolution_meet_the_vectors() {
    let mut error = 0.0f64;
    for case in cases(&vector_file("zh_rotation")) {
        let zonal: [f32; 5] = array(&numbers(&case["zh"]));
        let got: [f32; 25] = rotate_zonal(&zonal, vec3(&numbers(&case["dir"])));
        error = error.max(worst(&got, &numbers(&case["sh"])) / sh_oracle::norm(&wide(&zonal)));
    }
    println!("rotate_zonal: {error:.2e} of the norm");
    assert!(error <= 1e-6);
    let cosine = numbers(&vector_file("clamped_cosine_zh")["zh"]);
    for l in 0..9 {
        assert!((f64::from(CLAMPED_COSINE[l]) - cosine[l]).abs() <= 3e-7 * cosine[l].abs());
    }

    let mut draw = Draw::new(34);
    let (mut zonal_error, mut light_error, mut band_fault) = (0.0f64, 0.0f64, 0.0f64);
    for _ in 0..2_000 {
        let zonal: [f32; 4] = random(&mut draw);
        let (d, s) = (draw.direction(), draw.direction());
        let f: [f32; 16] = rotate_zonal(&zonal, Vec3::from_array(d));
        let cosine: f64 = (0..3).map(|c| draw_normalised(d)[c] * draw_normalised(s)[c]).sum();
        let want: f64 = (0..4)
            .map(|l| {
                f64::from(zonal[l])
                    * ((2 * l + 1) as f64 / (4.0 * PI)).sqrt()
                    * sh_oracle::legendre(l, cosine)
            })
            .sum();
        let norm = sh_oracle::norm(&wide(&zonal));
        zonal_error = zonal_error.max((f64::from(evaluate(&f, Vec3::from_array(s))) - want).abs() / norm);
        // Irradiance at a normal is the product of light and clamped cosine about it.
        let light: [f32; 16] = random(&mut draw);
        let about: [f32; 16] = rotate_zonal(&array::<4>(&wide(&CLAMPED_COSINE)), Vec3::from_array(s));
        let (direct, convolved) =
            (dot(&light, &about), evaluate(&irradiance::<4, 16>(&light), Vec3::from_array(s)));
        light_error = light_error.max(f64::from((direct - convolved).abs()));
        let mut faulty = irradiance::<4, 16>(&light);
        faulty[8] = light[8];
        band_fault = band_fault.max(f64::from((direct - evaluate(&faulty, Vec3::from_array(s))).abs()));
    }
    println!("zonal evaluation {zonal_error:.2e} of the norm, irradiance {light_error:.2e}");
    assert!(zonal_error <= 2e-6 && light_error <= 1e-5);
    assert!(band_fault > 1e-2, "planted fault: factor repeated l times only");
    let mut one = [0.0f32; 9];
    one[0] = UNIT;
    let e = evaluate(&irradiance::<3, 9>(&one), Vec3::Z);
    assert!((f64::from(e) - PI).abs() < 1e-6, "radiance 1 gives π: {e}");
}

/// The whole tensor as the kernel's product of unit vectors, compared with quadrature; returns the non-zeros.
fn tensor_nonzeros<const N: usize>(fault: f32) -> Result<usize, String> {
    let order = (N as f64).sqrt() as usize;
    let mut want = std::collections::BTreeMap::new();
    for (i, j, k, v) in sh_oracle::triples(order) {
        for ordering in sh_oracle::orderings(i, j, k) {
            want.insert(ordering, v);
        }
    }
    let mut count = 0;
    for j in 0..N {
        for k in 0..N {
            let (mut a, mut b) = ([0.0f32; N], [0.0f32; N]);
            a[j] = 1.0;
            b[k] = 1.0;
            let mut got = product(&a, &b);
            if (j, k) == (1, 2) {
                got[N / 2] += fault;
            }
            for i in 0..N {
                let truth = want.get(&(i, j, k)).copied().unwrap_or(0.0);
                if (f64::from(got[i]) - truth).abs() > 6e-8 * truth.abs() {
                    return Err(format!("Γ_{i},{j},{k} = {}, should be {truth}", got[i]));
                }
                count += usize::from(got[i] != 0.0);
            }
        }
    }
    Ok(count)
}

#[test]
fn the_product_tensor_is_that_of_quadrature() {
    assert_eq!(tensor_nonzeros::<4>(0.0), Ok(10));
    assert_eq!(tensor_nonzeros::<9>(0.0), Ok(83));
    assert_eq!(tensor_nonzeros::<16>(0.0), Ok(353));
    assert_eq!(tensor_nonzeros::<25>(0.0), Ok(1158));
    assert!(tensor_nonzeros::<16>(1e-6).is_err(), "planted fault");
    for (name, order) in [("gamma_n3", 3), ("gamma_n4", 4)] {
        let file = vector_file(name);
        let mut ours = sh_oracle::triples(order);
        ours.sort_by_key(|t| (t.0, t.1, t.2));
        let entries = file["entries"].as_array().unwrap();
        assert_eq!(ours.len(), entries.len());
        for ((i, j, k, v), entry) in ours.iter().zip(entries) {
            let e = numbers(entry);
            assert_eq!((*i as f64, *j as f64, *k as f64), (e[0], e[1], e[2]));
            assert!((v - e[3]).abs() < 1e-13);
        }
        assert_eq!(
            sh_oracle::Algebra::new(order).ordered_count() as u64,
            file["ordered_nonzeros"].as_u64().unwrap()
        );
    }
}

fn product_errors<const N: usize>(case: &Value) -> (f64, f64) {
    let (a, b): ([f32; N], [f32; N]) = (array(&numbers(&case["a"])), array(&numbers(&case["b"])));
    let (na, nb) = (sh_oracle::norm(&wide(&a)), sh_oracle::norm(&wide(&b)));
    (
        worst(&product(&a, &b), &numbers(&case["product"])) / (na * nb),
        worst(&square(&a), &numbers(&case["square_a"])) / (na * na),
    )
}

#[test]
fn products_meet_the_vectors() {
    let mut error = 0.0f64;
    for case in cases(&vector_file("sh_product")) {
        let (p, s) = match case["order"].as_u64().unwrap() {
            3 => product_errors::<9>(case),
            4 => product_errors::<16>(case),
            _ => product_errors::<25>(case),
        };
        error = error.max(p).max(s);
    }
    println!("product: {error:.2e} of the norms");
    assert!(error <= 2e-6);
}

fn product_properties<const N: usize>(draw: &mut Draw) {
    let mut one = [0.0f32; N];
    one[0] = UNIT;
    let mut faulty = 0.0f32;
    for _ in 0..300 {
        let (a, b, c): ([f32; N], [f32; N], [f32; N]) = (random(draw), random(draw), random(draw));
        let ab = product(&a, &b);
        assert_eq!(ab.map(f32::to_bits), product(&b, &a).map(f32::to_bits), "commutative to the bit");
        assert_eq!(square(&a).map(f32::to_bits), product(&a, &a).map(f32::to_bits));
        let scale =
            sh_oracle::norm(&wide(&a)) * (sh_oracle::norm(&wide(&b)) + sh_oracle::norm(&wide(&c)) + 4.0);
        assert!(worst(&product(&one, &a), &wide(&a)) <= 2e-6 * scale);
        let energy: f64 = wide(&a).iter().map(|x| x * x).sum();
        assert!((f64::from(square(&a)[0]) - energy / sh_oracle::s4()).abs() <= 2e-6 * scale * scale);
        let sum = product(&a, &add_scaled(&b, &c, 1.0));
        assert!(worst(&sum, &wide(&add_scaled(&ab, &product(&a, &c), 1.0))) <= 2e-6 * scale);
        let left = product(&ab, &c);
        let right = product(&a, &product(&b, &c));
        faulty = faulty.max((0..N).map(|i| (left[i] - right[i]).abs()).fold(0.0, f32::max));
    }
    // Truncation shows from order 3 on: the comparison would see a product of higher order.
    assert!(faulty > 1e-2, "order {N}: truncated products are not associative ({faulty:e})");
}

#[test]
fn products_commute_and_are_linear() {
    let mut draw = Draw::new(35);
    product_properties::<4>(&mut draw);
    product_properties::<9>(&mut draw);
    product_properties::<16>(&mut draw);
    product_properties::<25>(&mut draw);
}

fn matrix(rows: [[f64; 3]; 3]) -> Mat3 {
    Mat3::from_cols_array_2d(&rows.map(|r| r.map(|x| x as f32))).transpose()
}

#[test]
fn rotations_meet_the_vectors() {
    let (mut error, mut inverse_error) = (0.0f64, 0.0f64);
    for case in cases(&vector_file("sh_rotation_n5")) {
        let rows: Vec<Vec<f64>> = case["matrix"].as_array().unwrap().iter().map(numbers).collect();
        let r = matrix([0, 1, 2].map(|i| [rows[i][0], rows[i][1], rows[i][2]]));
        let f: [f32; 25] = array(&numbers(&case["input"]));
        let want = numbers(&case["output"]);
        let norm = sh_oracle::norm(&wide(&f));
        let got = rotate(&r, &f);
        error = error.max(worst(&got, &want) / norm);
        inverse_error = inverse_error.max(worst(&rotate(&r.transpose(), &f), &want) / norm);
        assert!(worst(&rotate(&r, &array::<4>(&wide(&f))), &want[..4]) <= 1e-6 * norm);
        assert!(worst(&rotate(&r, &array::<9>(&wide(&f))), &want[..9]) <= 1e-6 * norm);
        assert!(worst(&rotate(&r, &array::<16>(&wide(&f))), &want[..16]) <= 1e-6 * norm);
    }
    println!("rotate: {error:.2e} of the norm");
    assert!(error <= 1e-6);
    assert!(inverse_error > 0.1, "planted fault: the inverse rotation");
}

#[test]
fn rotations_form_a_group_and_keep_norms() {
    let mut draw = Draw::new(36);
    let mut errors = [0.0f64; 5];
    for _ in 0..500 {
        let (r1, r2) = (draw.rotation64(), draw.rotation64());
        let mut r12 = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..3 {
                r12[i][j] = (0..3).map(|k| r1[i][k] * r2[k][j]).sum();
            }
        }
        let f: [f32; 25] = random(&mut draw);
        let norm = sh_oracle::norm(&wide(&f));
        let g = rotate(&matrix(r2), &f);
        let s = draw.direction64();
        // f(R⁻¹ s) in float64.
        let back = [0, 1, 2].map(|c| (0..3).map(|k| r2[k][c] * s[k]).sum::<f64>());
        let value = |c: &[f32], d: [f64; 3]| -> f64 {
            sh_oracle::basis(5, d).iter().zip(c).map(|(y, &c)| y * f64::from(c)).sum()
        };
        errors[0] = errors[0].max((value(&g, s) - value(&f, back)).abs() / norm);
        for l in 0..5usize {
            let band = l * l..(l + 1) * (l + 1);
            let change = sh_oracle::norm(&wide(&g[band.clone()])) - sh_oracle::norm(&wide(&f[band]));
            errors[1] = errors[1].max(change.abs() / norm);
        }
        errors[2] = errors[2].max(worst(&rotate(&matrix(r2).transpose(), &g), &wide(&f)) / norm);
        errors[3] = errors[3].max(worst(&rotate(&matrix(r1), &g), &wide(&rotate(&matrix(r12), &f))) / norm);
        errors[4] = errors[4].max(worst(&rotate(&Mat3::IDENTITY, &f), &wide(&f)) / norm);
    }
    println!("rotation: value, band norms, inverse, composition, identity: {errors:?}");
    assert!(errors.iter().all(|&e| e <= 2e-6));
    let zonal = [0.5f32, 1.0, -0.7, 0.3, 0.2];
    let r = draw.rotation64();
    let axis = Vec3::new(r[0][2] as f32, r[1][2] as f32, r[2][2] as f32);
    let turned = rotate(&matrix(r), &rotate_zonal::<5, 25>(&zonal, Vec3::Z));
    assert!(worst(&turned, &wide(&rotate_zonal::<5, 25>(&zonal, axis))) < 2e-6);
}

fn lobe_mismatch<const W: usize>(table: [[f32; W]; W]) -> f64 {
    let want = sh_oracle::lobe_matrix(W / 2);
    (0..W).map(|j| worst(&table[j], &want[j])).fold(0.0, f64::max)
}

#[test]
fn rotation_tables_are_those_of_the_generator() {
    for (d, want) in LOBE_DIRECTIONS.iter().zip(sh_oracle::lobe_directions()) {
        assert!(worst(d, &want) <= 3e-8);
    }
    let errors = [
        lobe_mismatch(LOBE_WEIGHTS_1),
        lobe_mismatch(LOBE_WEIGHTS_2),
        lobe_mismatch(LOBE_WEIGHTS_3),
        lobe_mismatch(LOBE_WEIGHTS_4),
    ];
    assert!(errors.iter().all(|&e| e <= 2.4e-7), "{errors:?}");
    let mut fault = LOBE_WEIGHTS_2;
    fault[1][3] += 1e-5;
    assert!(lobe_mismatch(fault) > 1e-6, "planted fault");
}
