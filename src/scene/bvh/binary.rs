//! How are triangles clustered into a binary tree, and how is a subtree halved when the clusters are too deep?
//!
//! The top is split by binned surface area into chunks; obvhs clusters each chunk (locally ordered clustering, then
//! reinsertion). Clustering takes the square of the number of triangles where few agree on a neighbour (identical or
//! nested ones), so a chunk in which that happens is split further. Chunks are built in parallel, each the same
//! whichever thread does it.

use super::split;
use crate::scene::Bounds;
use obvhs::bvh2::{Bvh2, DEFAULT_MAX_STACK_DEPTH, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};
use rayon::prelude::*;
use twinlight_kernels::geometry::bvh::MAX_LEAF_BLOCKS;

/// Beyond this depth reinsertion is stopped: the library's own stack holds 96 levels.
const MAX_BINARY_DEPTH: u32 = 72;
/// The largest number of triangles that the library clusters at once.
const CHUNK: u32 = 32768;
/// The same where clustering stalls.
const STALLING_CHUNK: u32 = 1024;
/// Part of the nodes that each pass of reinsertion tries to move, largest first.
const REINSERTION_RATIO: f32 = 0.2;
/// Cost of visiting a binary node, in tests of a block of four triangles.
const NODE_COST: f64 = 0.5;

/// A binary tree whose subtrees are ranges of one order of the triangles.
pub struct Binary {
    /// Triangle indices; every subtree is a range.
    order: Vec<u32>,
    nodes: Vec<Node>,
}

#[derive(Clone, Copy)]
struct Node {
    bounds: Bounds,
    first: u32,
    count: u32,
    left: u32,
    right: u32,
    leaf: bool,
}

/// A range of [`Binary::order`], cut up either by the tree or by count.
#[derive(Clone, Copy, Debug)]
pub struct Subtree {
    first: u32,
    count: u32,
    /// Node of the tree; [`BY_COUNT`] when the range is halved by count.
    node: u32,
}

const BY_COUNT: u32 = u32::MAX;

impl Subtree {
    pub fn len(&self) -> usize {
        self.count as usize
    }

    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// The same triangles, to be halved by count from now on.
    pub fn by_count(self) -> Self {
        Self { node: BY_COUNT, ..self }
    }

    pub fn is_by_count(&self) -> bool {
        self.node == BY_COUNT
    }
}

impl Binary {
    /// Builds the tree over finite boxes.
    pub fn build(bounds: &[Bounds]) -> Self {
        let mut order: Vec<u32> = (0..bounds.len() as u32).collect();
        let top = cut(&mut order, bounds, CHUNK);
        let chunks: Vec<(Vec<u32>, Vec<Node>)> =
            top.par_iter().filter(|node| node.leaf).map(|node| grow(&order[node.range()], bounds)).collect();
        let mut tree = Self { order, nodes: vec![] };
        tree.assemble(&top, chunks);
        tree.choose_leaves(bounds);
        tree
    }

    /// Joins the trees of the chunks, in the order of the top's leaves, below the top; children follow parents.
    fn assemble(&mut self, top: &[Node], chunks: Vec<(Vec<u32>, Vec<Node>)>) {
        let mut chunks = chunks.into_iter();
        // Node of the top, and the parent here whose right child it is.
        let mut stack = if top.is_empty() { vec![] } else { vec![(0u32, None::<u32>)] };
        while let Some((source, right_of)) = stack.pop() {
            let index = self.nodes.len() as u32;
            if let Some(parent) = right_of {
                self.nodes[parent as usize].right = index;
            }
            let node = top[source as usize];
            if !node.leaf {
                self.nodes.push(Node { left: index + 1, right: 0, ..node });
                stack.push((node.right, Some(index)));
                stack.push((node.left, None));
                continue;
            }
            let (order, nodes) = chunks.next().unwrap_or_default();
            self.order[node.range()].copy_from_slice(&order);
            self.nodes.extend(nodes.into_iter().map(|n| Node {
                first: n.first + node.first,
                left: n.left + index,
                right: n.right + index,
                ..n
            }));
        }
    }

    /// The whole tree.
    pub fn root(&self) -> Subtree {
        Subtree {
            first: 0,
            count: self.order.len() as u32,
            node: if self.nodes.is_empty() { BY_COUNT } else { 0 },
        }
    }

    /// Whether the subtree is to be a leaf.
    pub fn is_leaf(&self, subtree: Subtree) -> bool {
        if subtree.is_by_count() { subtree.count <= 4 } else { self.nodes[subtree.node as usize].leaf }
    }

    /// Its triangles.
    pub fn triangles(&self, subtree: Subtree) -> &[u32] {
        &self.order[subtree.first as usize..(subtree.first + subtree.count) as usize]
    }

    /// The exact box around its triangles.
    pub fn bounds(&self, bounds: &[Bounds], subtree: Subtree) -> Bounds {
        if !subtree.is_by_count() {
            return self.nodes[subtree.node as usize].bounds;
        }
        self.triangles(subtree).iter().fold(Bounds::EMPTY, |all, &i| all.union(bounds[i as usize]))
    }

    /// The two parts of a subtree that is not a leaf.
    pub fn open(&mut self, bounds: &[Bounds], subtree: Subtree) -> (Subtree, Subtree) {
        if subtree.is_by_count() {
            return self.halve(bounds, subtree);
        }
        let node = self.nodes[subtree.node as usize];
        let part = |child: u32| {
            let n = &self.nodes[child as usize];
            Subtree { first: n.first, count: n.count, node: child }
        };
        (part(node.left), part(node.right))
    }

    /// Cuts a range in the middle, at a multiple of four.
    fn halve(&mut self, bounds: &[Bounds], subtree: Subtree) -> (Subtree, Subtree) {
        let left = subtree.count.div_ceil(2).next_multiple_of(4);
        let range = &mut self.order[subtree.first as usize..(subtree.first + subtree.count) as usize];
        split::by_count(range, bounds, left as usize);
        (
            Subtree { count: left, ..subtree },
            Subtree { first: subtree.first + left, count: subtree.count - left, ..subtree },
        )
    }

    /// From the bottom up: boxes, counts, and whether a leaf is cheaper than its two parts.
    fn choose_leaves(&mut self, bounds: &[Bounds]) {
        let mut costs = vec![0.0f64; self.nodes.len()];
        // Children follow their parents.
        for index in (0..self.nodes.len()).rev() {
            let mut node = self.nodes[index];
            let mut split_cost = f64::INFINITY;
            if node.leaf {
                let range = node.first as usize..(node.first + node.count) as usize;
                node.bounds =
                    self.order[range].iter().fold(Bounds::EMPTY, |all, &i| all.union(bounds[i as usize]));
            } else {
                let (left, right) = (node.left as usize, node.right as usize);
                node.count = self.nodes[left].count + self.nodes[right].count;
                node.bounds = self.nodes[left].bounds.union(self.nodes[right].bounds);
                split_cost = costs[left] + costs[right] + NODE_COST * split::half_area(&node.bounds);
            }
            let blocks = node.count.div_ceil(4);
            let leaf_cost = f64::from(blocks) * split::half_area(&node.bounds);
            node.leaf = node.leaf || blocks <= 1 || (blocks <= MAX_LEAF_BLOCKS && leaf_cost <= split_cost);
            costs[index] = if node.leaf { leaf_cost } else { split_cost };
            self.nodes[index] = node;
        }
    }
}

impl Node {
    fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }
}

/// Sorts the triangles into chunks of at most `largest`; returns the tree above them, whose leaves are the chunks from left to right.
fn cut(order: &mut [u32], bounds: &[Bounds], largest: u32) -> Vec<Node> {
    let mut nodes: Vec<Node> = vec![];
    let mut stack = if order.is_empty() { vec![] } else { vec![(0u32, order.len() as u32, None::<u32>)] };
    while let Some((first, count, right_of)) = stack.pop() {
        let index = nodes.len() as u32;
        if let Some(parent) = right_of {
            nodes[parent as usize].right = index;
        }
        let leaf = count <= largest;
        let node = Node { bounds: Bounds::EMPTY, first, count, left: index + 1, right: 0, leaf };
        nodes.push(node);
        if !leaf {
            let left = split::by_area(&mut order[node.range()], bounds) as u32;
            stack.push((first + left, count - left, Some(index)));
            stack.push((first, left, None));
        }
    }
    nodes
}

/// As [`flatten`], in smaller chunks where clustering stalls.
fn grow(triangles: &[u32], bounds: &[Bounds]) -> (Vec<u32>, Vec<Node>) {
    let mut order = triangles.to_vec();
    let top = cut(&mut order, bounds, STALLING_CHUNK);
    let leaves = || top.iter().filter(|node| node.leaf).map(|node| &order[node.range()]);
    if !leaves().any(|chunk| stalls(chunk, bounds)) {
        return flatten(triangles, bounds);
    }
    let chunks = leaves().map(|chunk| flatten(chunk, bounds)).collect();
    let mut tree = Binary { order, nodes: vec![] };
    tree.assemble(&top, chunks);
    (tree.order, tree.nodes)
}

/// Whether clustering these triangles takes far more than a logarithm's number of rounds.
fn stalls(triangles: &[u32], bounds: &[Bounds]) -> bool {
    let own: Vec<Bounds> = triangles.iter().map(|&i| bounds[i as usize]).collect();
    // The library sets it to its rounds, or to this default where those are fewer.
    clustered(&own).max_depth > DEFAULT_MAX_STACK_DEPTH
}

/// Clusters the given triangles; returns their new order and the tree in depth-first order, ranges and links from 0.
fn flatten(triangles: &[u32], bounds: &[Bounds]) -> (Vec<u32>, Vec<Node>) {
    let own: Vec<Bounds> = triangles.iter().map(|&i| bounds[i as usize]).collect();
    let tree = cluster(&own);
    let mut order = Vec::with_capacity(triangles.len());
    let mut nodes: Vec<Node> = Vec::with_capacity(tree.nodes.len());
    // Node of the library's tree, and the parent here whose right child it is.
    let mut stack = vec![(0u32, None::<u32>)];
    while let Some((source, right_of)) = stack.pop() {
        let index = nodes.len() as u32;
        if let Some(parent) = right_of {
            nodes[parent as usize].right = index;
        }
        let node = &tree.nodes[source as usize];
        let (first, count, leaf) = (order.len() as u32, node.prim_count, node.is_leaf());
        nodes.push(Node { bounds: Bounds::EMPTY, first, count, left: index + 1, right: 0, leaf });
        if leaf {
            let from = node.first_index as usize;
            let primitives = &tree.primitive_indices[from..from + count as usize];
            order.extend(primitives.iter().map(|&i| triangles[i as usize]));
        } else {
            stack.push((node.first_index + 1, Some(index)));
            stack.push((node.first_index, None));
        }
    }
    (order, nodes)
}

/// Runs the library: clustering, then reinsertion as long as the tree stays shallow.
fn cluster(bounds: &[Bounds]) -> Bvh2 {
    let mut tree = clustered(bounds);
    let mut optimizer = ReinsertionOptimizer::default();
    for n in (1..32).step_by(2) {
        if depth(&tree) > MAX_BINARY_DEPTH {
            break;
        }
        optimizer.run(&mut tree, REINSERTION_RATIO, Some(vec![1.0 / n as f32]));
    }
    tree
}

/// Runs the library's clustering alone.
fn clustered(bounds: &[Bounds]) -> Bvh2 {
    // A power of two brings the largest coordinate to about 1, so that no area over- or underflows; a subnormal one as far as one can.
    let largest = bounds.iter().fold(0.0f32, |m, b| m.max(b.min.abs().max(b.max.abs()).max_element()));
    let scale =
        if largest > 0.0 { f64::from(largest).log2().floor().max(-126.0).exp2().recip() as f32 } else { 1.0 };
    // Through arrays: the library's vectors may be of another version of glam.
    let corner = |p: glam::Vec3| (p * scale).to_array().into();
    let boxes: Vec<obvhs::aabb::Aabb> =
        bounds.iter().map(|b| obvhs::aabb::Aabb::new(corner(b.min), corner(b.max))).collect();
    let indices = (0..boxes.len() as u32).collect();
    PlocBuilder::with_capacity(boxes.len()).build(
        PlocSearchDistance::High,
        &boxes,
        indices,
        SortPrecision::U64,
        0,
    )
}

/// Levels below the root.
fn depth(tree: &Bvh2) -> u32 {
    let mut deepest = 0;
    let mut stack = vec![(0u32, 0u32)];
    while let Some((index, level)) = stack.pop() {
        deepest = deepest.max(level);
        let node = &tree.nodes[index as usize];
        if !node.is_leaf() {
            stack.push((node.first_index, level + 1));
            stack.push((node.first_index + 1, level + 1));
        }
    }
    deepest
}
