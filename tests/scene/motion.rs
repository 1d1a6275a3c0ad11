//! Do animations, skins and spheres in extras stand where the file says, at any moment?

use crate::file::File;
use glam::Vec3;
use serde_json::json;
use twinlight::scene::Scene;

/// The file with more numbers behind its buffer, and a view and an accessor for each group.
fn with_numbers(file: File, groups: &[(&str, &[f32])]) -> File {
    let mut file = file;
    for (kind, numbers) in groups {
        let width = match *kind {
            "SCALAR" => 1,
            "VEC3" => 3,
            "VEC4" => 4,
            _ => 16,
        };
        file = file.append(kind, numbers.len() / width, numbers);
    }
    file
}

fn corner(s: &Scene) -> Vec3 {
    s.triangles[0].p0.truncate()
}

#[test]
fn nodes_move_with_their_animation() {
    let file = || {
        // Accessors 4 and 5: two moments, two places.
        with_numbers(File::new(), &[("SCALAR", &[0.0, 2.0]), ("VEC3", &[0.0, 0.0, 0.0, 4.0, 0.0, 0.0])])
            .set(
                "/animations",
                json!([{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                        "samplers": [{"input": 4, "output": 5}]}]),
            )
            .set("/nodes/0", json!({"mesh": 0, "extras": {"spheres": [[0.0, 1.0, 0.0, 0.5]]}}))
    };
    for (seconds, x) in [(0.0, 0.0), (0.5, 1.0), (1.5, 3.0), (2.5, 1.0), (-0.5, 3.0)] {
        let s = file().open_at(seconds).unwrap();
        assert!((corner(&s) - Vec3::new(x, 0.0, 0.0)).length() < 1e-6, "{seconds} s: {}", corner(&s));
        assert_eq!(s.proxies.len(), 1);
        let p = s.proxies[0];
        assert!((p.centre - Vec3::new(x, 1.0, 0.0)).length() < 1e-6 && p.radius == 0.5, "{seconds} s: {p:?}");
    }
    let falling = with_numbers(File::new(), &[("SCALAR", &[2.0, 1.0]), ("VEC3", &[0.0; 6])]).set(
        "/animations",
        json!([{"channels": [{"sampler": 0, "target": {"node": 0, "path": "translation"}}],
                "samplers": [{"input": 4, "output": 5}]}]),
    );
    assert!(falling.open().unwrap_err().to_string().contains("times do not rise"));
    let short = with_numbers(File::new(), &[("SCALAR", &[0.0, 1.0]), ("VEC3", &[0.0; 3])]).set(
        "/animations",
        json!([{"channels": [{"sampler": 0, "target": {"node": 0, "path": "scale"}}],
                "samplers": [{"input": 4, "output": 5}]}]),
    );
    assert!(short.open().unwrap_err().to_string().contains("as many as its times"));
}

/// The triangle on two joints: its first corner on the first, which lies at the origin, the others on the second, which is
/// two metres up and may turn; a quarter turn about z takes +x to +y.
fn skinned(turn: [f32; 4]) -> File {
    let mut bind = [0.0f32; 32];
    for joint in 0..2 {
        for k in 0..4 {
            bind[16 * joint + 5 * k] = 1.0;
        }
    }
    // What is on the second joint is given in the mesh's space: two metres down in the joint's.
    bind[16 + 13] = -2.0;
    let file = with_numbers(
        File::new(),
        &[
            ("VEC4", &[0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
            ("VEC4", &[1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 2.0, 0.0, 0.0, 0.0]),
            ("MAT4", &bind),
        ],
    );
    file.set("/meshes/0/primitives/0/attributes/JOINTS_0", json!(4))
        .set("/meshes/0/primitives/0/attributes/WEIGHTS_0", json!(5))
        .set("/skins", json!([{"joints": [1, 2], "inverseBindMatrices": 6}]))
        .set("/nodes", json!([
            {"mesh": 0, "skin": 0, "translation": [100.0, 0.0, 0.0]},
            {"children": [2]},
            {"translation": [0.0, 2.0, 0.0], "rotation": turn, "extras": {"spheres": [[1.0, 0.0, 0.0, 0.25]]}},
        ]))
        .set("/scenes/0/nodes", json!([0, 1]))
}

#[test]
fn skins_carry_vertices_and_spheres() {
    let rest = skinned([0.0, 0.0, 0.0, 1.0]).open().unwrap();
    let p = |s: &Scene| [s.triangles[0].p0, s.triangles[0].p1, s.triangles[0].p2].map(glam::Vec4::truncate);
    // The node's own place does not count.
    assert_eq!(p(&rest), [Vec3::ZERO, Vec3::X, Vec3::Y]);
    assert_eq!(rest.proxies[0].centre, Vec3::new(1.0, 2.0, 0.0));
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let turned = skinned([0.0, 0.0, half, half]).open().unwrap();
    // (1, −2, 0) in the joint turns to (2, 1, 0), and (0, −1, 0) to (1, 0, 0).
    let want = [Vec3::ZERO, Vec3::new(2.0, 3.0, 0.0), Vec3::new(1.0, 2.0, 0.0)];
    for (got, want) in p(&turned).into_iter().zip(want) {
        assert!((got - want).length() < 1e-5, "{:?}", p(&turned));
    }
    assert!((turned.proxies[0].centre - Vec3::new(0.0, 3.0, 0.0)).length() < 1e-5);
    let missing = skinned([0.0, 0.0, 0.0, 1.0]).set("/skins/0/joints", json!([1]));
    assert!(missing.open().unwrap_err().to_string().contains("joint"));
    let outside = skinned([0.0, 0.0, 0.0, 1.0]).set("/scenes/0/nodes", json!([0]));
    assert!(outside.open().unwrap_err().to_string().contains("not in the scene"));
}

#[test]
fn animations_of_what_is_not_there_are_refused() {
    let moving = |target: serde_json::Value| {
        with_numbers(File::new(), &[("SCALAR", &[0.0, 1.0]), ("VEC3", &[0.0; 6])]).set(
            "/animations",
            json!([{"channels": [{"sampler": 0, "target": target}], "samplers": [{"input": 4, "output": 5}]}]),
        )
    };
    for (target, word) in [
        (json!({"node": 99, "path": "translation"}), "node 99"),
        (json!({"node": 0, "path": "pointer"}), "neither"),
    ] {
        let message = moving(target).open().unwrap_err().to_string();
        assert!(message.contains(word), "{message}");
    }
    assert!(moving(json!({"node": 0, "path": "translation"})).open().is_ok(), "negative control");
}

#[test]
fn spheres_of_extras_that_make_no_sense_are_refused() {
    for spheres in [json!([[0, 0, 0, -1]]), json!([[0, 0, 0]]), json!(3), json!([["a", 0, 0, 1]])] {
        let file = File::new().set("/nodes/0", json!({"mesh": 0, "extras": {"spheres": spheres}}));
        let message = file.open().unwrap_err().to_string();
        assert!(message.contains("extras.spheres") && message.contains("node 0"), "{message}");
    }
}

#[test]
fn the_built_in_characters_sway() {
    let at = |t| Scene::open_at("spheres", t).unwrap();
    let (start, later, round) = (at(0.0), at(0.6), at(2.5));
    assert_eq!(start, Scene::open("spheres").unwrap());
    let moved = |a: &Scene, b: &Scene| {
        let far = a.proxies.iter().zip(&b.proxies).map(|(a, b)| a.centre.distance(b.centre));
        far.fold(0.0f32, f32::max)
    };
    assert!(moved(&start, &later) > 0.2 && moved(&start, &round) < 1e-4);
    for (p, t) in later.proxies.iter().zip(later.triangles[2..].chunks(1280)) {
        let at = t.iter().map(|t| t.p0.truncate()).sum::<Vec3>() / 1280.0;
        assert!(at.distance(p.centre) < 1e-3, "a proxy left its sphere");
    }
}
