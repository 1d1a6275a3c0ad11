//! Does the tree hold every triangle once, inside its bounds, within the stack, and give the right hits?

use super::*;
use glam::{DVec3, Vec3};

/// Numbers in [0, 1) from a fixed seed (the 64-bit generator of Knuth's MMIX).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1 << 24) as f32
    }

    fn point(&mut self) -> Vec3 {
        Vec3::new(self.next(), self.next(), self.next())
    }
}

fn triangle(a: Vec3, b: Vec3, c: Vec3) -> Triangle {
    Triangle { p0: a.extend(0.0), p1: b.extend(0.0), p2: c.extend(0.0), ..Triangle::default() }
}

fn soup(count: usize, size: f32) -> Vec<Triangle> {
    let mut random = Random(count as u64);
    let mut one = || {
        let p = random.point();
        triangle(p, p + random.point() * size, p + random.point() * size)
    };
    (0..count).map(|_| one()).collect()
}

/// The four lanes of a node: child with its bounds.
fn lanes(node: &BvhNode) -> [(u32, Bounds); 4] {
    std::array::from_fn(|i| {
        let min = Vec3::new(node.min_x[i], node.min_y[i], node.min_z[i]);
        let max = Vec3::new(node.max_x[i], node.max_y[i], node.max_z[i]);
        (node.children[i], Bounds { min, max })
    })
}

fn blocks(child: u32) -> std::ops::Range<usize> {
    let first = (child & 0x0FFF_FFFF) as usize;
    first..first + (child >> 28 & 7) as usize + 1
}

/// Checks everything that a tree promises; panics with what is broken.
fn check(bvh: &Bvh, triangles: &[Triangle]) {
    let mut seen = vec![0u32; triangles.len()];
    let mut nodes_seen = vec![0u32; bvh.nodes.len()];
    let mut deepest = 0;
    let all = Bounds { min: Vec3::splat(f32::NEG_INFINITY), max: Vec3::splat(f32::INFINITY) };
    let mut stack = vec![(0u32, 1u32, all)];
    while let Some((index, level, outer)) = stack.pop() {
        nodes_seen[index as usize] += 1;
        deepest = deepest.max(level);
        for (child, bounds) in lanes(&bvh.nodes[index as usize]) {
            if child == NO_CHILD {
                assert_eq!((bounds.min, bounds.max), (Vec3::splat(3.0e38), Vec3::splat(-3.0e38)));
                continue;
            }
            assert_eq!(outer.union(bounds), outer, "bounds of a child reach out of node {index}");
            if child & LEAF == 0 {
                assert!(child > index, "children follow their parents");
                stack.push((child, level + 1, bounds));
                continue;
            }
            assert!(blocks(child).len() as u32 <= MAX_LEAF_BLOCKS);
            let mut tight = Bounds::EMPTY;
            for block in &bvh.blocks[blocks(child)] {
                for lane in 0..4 {
                    let corners = corners(block, lane);
                    if block.triangles[lane] == NO_TRIANGLE {
                        assert_eq!(corners, [Vec3::ZERO; 3]);
                        continue;
                    }
                    let id = (block.triangles[lane] & !MASKED) as usize;
                    seen[id] += 1;
                    let t = &triangles[id];
                    assert_eq!(corners, [t.p0, t.p1, t.p2].map(|p| p.truncate()));
                    tight = tight.union(Bounds::of_triangle(t));
                }
            }
            let (min, max) = pad_bounds(tight.min, tight.max);
            assert_eq!(
                Bounds { min, max },
                bounds,
                "leaf bounds are the triangles' own, padded for rounding"
            );
        }
    }
    assert!(seen.iter().all(|&n| n == 1), "every triangle once");
    assert!(nodes_seen.iter().all(|&n| n == 1), "every node once");
    assert_eq!(deepest, bvh.depth);
    assert!(3 * bvh.depth < STACK_SIZE, "depth {}", bvh.depth);
}

fn corners(block: &TriangleBlock, lane: usize) -> [Vec3; 3] {
    [
        Vec3::new(block.x0[lane], block.y0[lane], block.z0[lane]),
        Vec3::new(block.x1[lane], block.y1[lane], block.z1[lane]),
        Vec3::new(block.x2[lane], block.y2[lane], block.z2[lane]),
    ]
}

/// Distance of the hit, Möller and Trumbore in f64; infinite for none.
fn hit(corners: [Vec3; 3], origin: DVec3, direction: DVec3) -> f64 {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    let (e1, e2) = (b - a, c - a);
    let p = direction.cross(e2);
    let scale = 1.0 / e1.dot(p);
    let s = origin - a;
    let q = s.cross(e1);
    let (u, v, t) = (s.dot(p) * scale, direction.dot(q) * scale, e2.dot(q) * scale);
    if u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 { t } else { f64::INFINITY }
}

/// Nearest hit by walking the tree: distance, and number of blocks tested.
fn walk(bvh: &Bvh, origin: DVec3, direction: DVec3) -> (f64, usize) {
    let (mut nearest, mut tested) = (f64::INFINITY, 0);
    let mut stack = vec![0u32];
    let mut highest = 1;
    while let Some(child) = stack.pop() {
        if child & LEAF != 0 {
            for block in &bvh.blocks[blocks(child)] {
                tested += 1;
                for lane in (0..4).filter(|&lane| block.triangles[lane] != NO_TRIANGLE) {
                    nearest = nearest.min(hit(corners(block, lane), origin, direction));
                }
            }
            continue;
        }
        for (child, bounds) in lanes(&bvh.nodes[child as usize]) {
            let (a, b) =
                ((bounds.min.as_dvec3() - origin) / direction, (bounds.max.as_dvec3() - origin) / direction);
            let (enter, leave) = (a.min(b).max_element(), a.max(b).min_element());
            if child != NO_CHILD && enter <= leave * (1.0 + 1e-12) && leave >= 0.0 && enter <= nearest {
                stack.push(child);
            }
        }
        highest = highest.max(stack.len());
    }
    assert!(highest <= STACK_SIZE as usize);
    (nearest, tested)
}

#[test]
fn trees_hold_every_triangle_once() {
    for count in [0, 1, 2, 3, 4, 5, 8, 9, 16, 17, 33, 100, 1000, 20_000] {
        for size in [1e-3, 0.1, 3.0] {
            let triangles = soup(count, size);
            check(&Bvh::build(&triangles, &[]).unwrap(), &triangles);
        }
    }
}

#[test]
#[should_panic(expected = "every triangle once")]
fn negative_control_a_lost_triangle_is_noticed() {
    let triangles = soup(100, 0.1);
    let mut bvh = Bvh::build(&triangles, &[]).unwrap();
    let block = bvh.blocks.iter_mut().find(|b| b.triangles.w == NO_TRIANGLE && b.triangles.y != NO_TRIANGLE);
    let block = block.unwrap();
    // Its neighbour a second time: the bounds may stay, the count may not.
    let clone = triangles[block.triangles.x as usize];
    block.triangles.w = block.triangles.x;
    (block.x0.w, block.y0.w, block.z0.w) = (clone.p0.x, clone.p0.y, clone.p0.z);
    (block.x1.w, block.y1.w, block.z1.w) = (clone.p1.x, clone.p1.y, clone.p1.z);
    (block.x2.w, block.y2.w, block.z2.w) = (clone.p2.x, clone.p2.y, clone.p2.z);
    check(&bvh, &triangles);
}

#[test]
fn the_nearest_hit_is_that_of_all_triangles() {
    for (count, size) in [(5, 1.0), (300, 0.3), (3000, 0.1)] {
        let triangles = soup(count, size);
        let bvh = Bvh::build(&triangles, &[]).unwrap();
        let mut random = Random(7);
        let (mut hits, mut tested) = (0, 0);
        for _ in 0..1000 {
            let origin = (random.point() * 3.0 - 1.0).as_dvec3();
            let direction = (random.point().as_dvec3() - origin).normalize();
            let all =
                triangles.iter().map(|t| hit([t.p0, t.p1, t.p2].map(|p| p.truncate()), origin, direction));
            let expected = all.fold(f64::INFINITY, f64::min);
            let (nearest, blocks) = walk(&bvh, origin, direction);
            assert_eq!(nearest, expected, "{count} triangles, {origin} {direction}");
            hits += usize::from(nearest.is_finite());
            tested += blocks;
        }
        assert!(hits > 100, "too few hits to compare: {hits}");
        assert!(count < 100 || tested < 1000 * count / 8, "the tree saves nothing: {tested}");
    }
}

#[test]
fn masked_materials_mark_their_lanes() {
    let mut triangles = soup(50, 0.1);
    triangles.iter_mut().enumerate().for_each(|(i, t)| t.material = i as u32 % 3);
    let materials = [Material::default(), Material { flags: MATERIAL_MASKED, ..Material::default() }];
    let bvh = Bvh::build(&triangles, &materials).unwrap();
    for id in bvh.blocks.iter().flat_map(|b| b.triangles.to_array()).filter(|&id| id != NO_TRIANGLE) {
        assert_eq!(id & MASKED != 0, triangles[(id & !MASKED) as usize].material == 1);
    }
}

#[test]
fn degenerate_scenes_stay_within_the_stack() {
    let unit = triangle(Vec3::ZERO, Vec3::X, Vec3::Y);
    let power = |ratio: f32, count: i32| -> Vec<Triangle> {
        let scaled = |i| {
            let s = ratio.powi(i);
            triangle(Vec3::new(s, 0.0, 0.0), Vec3::new(s * 1.5, 0.0, 0.0), Vec3::new(s, s * 0.5, 0.0))
        };
        (0..count).map(scaled).collect()
    };
    let nested = |count: i32| -> Vec<Triangle> {
        let ring = |i: i32| {
            let s = 1.0 + i as f32 * 1e-3;
            triangle(Vec3::new(-s, -s, 0.0), Vec3::new(s, -s, 0.0), Vec3::new(0.0, s, 0.0))
        };
        (0..count).map(ring).collect()
    };
    let fan = |count: i32| -> Vec<Triangle> {
        let blade = |i: i32| {
            let a = i as f32 * 1e-3;
            triangle(Vec3::ZERO, Vec3::new(a.cos(), a.sin(), 0.0), Vec3::new(a.cos(), a.sin(), 1e-3))
        };
        (0..count).map(blade).collect()
    };
    let cases = [
        ("identical", vec![unit; 100_000]),
        ("doubling", power(2.0, 59)),
        ("shrinking", power(0.5, 120)),
        ("slowly growing", power(1.002, 20_000)),
        ("nested", nested(20_000)),
        ("fan", fan(20_000)),
        ("huge", soup(1000, 0.1).iter().map(|t| Triangle { p0: t.p0 * 9e17, ..*t }).collect()),
        ("tiny", soup(1000, 0.1).iter().map(|t| triangle_scaled(t, 1e-38)).collect()),
    ];
    for (name, triangles) in cases {
        let start = std::time::Instant::now();
        let bvh = Bvh::build(&triangles, &[]).unwrap();
        eprintln!("{name}: depth {}, {} nodes, {:?}", bvh.depth, bvh.nodes.len(), start.elapsed());
        check(&bvh, &triangles);
    }
}

fn triangle_scaled(t: &Triangle, s: f32) -> Triangle {
    triangle(t.p0.truncate() * s, t.p1.truncate() * s, t.p2.truncate() * s)
}

#[test]
fn a_subtree_without_slack_is_halved_by_count() {
    let triangles = soup(4000, 0.1);
    let bounds: Vec<Bounds> = triangles.iter().map(Bounds::of_triangle).collect();
    // As if the stack held just the levels of a balanced tree.
    let levels = levels_needed(triangles.len());
    let mut binary = Binary::build(&bounds);
    let mut builder = Collapse {
        bvh: Bvh { nodes: vec![], blocks: vec![], depth: 0 },
        triangles: &triangles,
        materials: &[],
    };
    let root = binary.root();
    builder.node(&mut binary, &bounds, root, levels);
    builder.bvh.depth -= MAX_DEPTH - levels;
    assert_eq!(builder.bvh.depth, levels);
    check(&builder.bvh, &triangles);
}

#[test]
fn threads_do_not_change_the_tree() {
    let triangles = soup(30_000, 0.02);
    let build = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| Bvh::build(&triangles, &[]).unwrap())
    };
    let one = build(1);
    for bvh in [build(1), build(2), build(7)] {
        assert_eq!(bytemuck::cast_slice::<_, u32>(&one.nodes), bytemuck::cast_slice::<_, u32>(&bvh.nodes));
        assert_eq!(bytemuck::cast_slice::<_, u32>(&one.blocks), bytemuck::cast_slice::<_, u32>(&bvh.blocks));
    }
    let other = Bvh::build(&soup(30_000, 0.021), &[]).unwrap();
    assert_ne!(one, other, "negative control");
}

#[test]
fn unusable_coordinates_are_refused() {
    for bad in [f32::NAN, f32::INFINITY, 2e18, -2e18] {
        let mut triangles = soup(10, 0.1);
        triangles[3].p1.y = bad;
        assert!(matches!(Bvh::build(&triangles, &[]), Err(SceneError::Value { .. })));
    }
}
