//! The point of a surface that is closest to a given one: the orthogonal distance of a node.
//!
//! The surface is divided into small rectangles between its breaks, each within a ball, and the
//! balls into a tree. What lies nearest comes first: balls are opened into balls, rectangles are
//! searched and halved, until nothing is left that could be nearer than the best point found. What
//! is left out is left out by a bound that holds in all of it: Taylor's formula with bounds of the
//! second derivatives (`bends.rs`, `closest_cell.rs`). Of surfaces that are no B-splines those
//! bounds come from samples, with a margin.
//!
//! Feet are found by going downhill (`descent.rs`), held within the surface's own smooth piece, so
//! that edges and corners are found as such.

use super::{
    Surface,
    bends::sampled,
    closest_cell::Cell,
    descent::{Best, NOISE, Rectangle, descend, place_within},
    local::normal,
};
use crate::space::Vector;
use flankfit_numerics::cancel;
use rayon::prelude::*;
use std::{cmp::Ordering, collections::BinaryHeap};

/// Rectangles along each parameter at least.
const LEAST_LEAVES: usize = 16;
/// Rectangles that could be nearer by this part of the distance at most are left out, once so many
/// were halved. Only where a whole line or part of the surface is about as near as its foot, around
/// the centre of a sphere, are there many; these places are then as good.
const NEAR: [(usize, f64); 3] = [(0, 1e-9), (1000, 1e-6), (4000, 1e-4)];
/// Rectangles that one question halves at most.
const MOST_HALVED: usize = 8000;

/// The closest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// (u, v) of the point.
    pub parameters: [f64; 2],
    /// The point; (u, v, z) on a surface of heights.
    pub point: Vector,
    /// How far it is.
    pub distance: f64,
    /// The same, below 0 on the side that the normal S_u × S_v points away from. None where there
    /// is no normal.
    pub signed_distance: Option<f64>,
    /// Whether the connection is at right angles to the surface, to rounding; if not, the point is
    /// on a border or an edge.
    pub is_orthogonal: bool,
}

/// A surface prepared for many questions.
pub struct ClosestPoint<'a> {
    surface: &'a (dyn Surface + Sync),
    leaves: Vec<Leaf>,
    tree: Vec<Ball>,
}

/// A rectangle of parameters, and the smooth piece that it is part of.
#[derive(Clone, Copy)]
struct Leaf {
    cell: Cell,
    piece: Rectangle,
}

#[derive(Clone, Copy)]
struct Ball {
    center: Vector,
    radius: f64,
    content: Content,
}

#[derive(Clone, Copy)]
enum Content {
    Leaf(usize),
    Balls(usize, usize),
}

/// A rectangle still to be examined: nothing in it is nearer than `bound`.
struct Open {
    bound: f64,
    /// How many were there before.
    order: usize,
    part: Region,
}

enum Region {
    Ball(usize),
    Cell(Box<(Cell, Rectangle)>),
}

impl Ord for Open {
    fn cmp(&self, other: &Self) -> Ordering {
        // the least bound is the greatest, and the first of those that are alike
        other.bound.total_cmp(&self.bound).then(other.order.cmp(&self.order))
    }
}

impl PartialOrd for Open {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Open {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other) == Ordering::Equal
    }
}

impl Eq for Open {}

/// The parts of one question that are open.
#[derive(Default)]
struct Queue {
    heap: BinaryHeap<Open>,
    count: usize,
}

impl Queue {
    fn push(&mut self, bound: f64, part: Region) {
        self.heap.push(Open { bound, order: self.count, part });
        self.count += 1;
    }
}

impl<'a> ClosestPoint<'a> {
    /// Prepares `surface`: bounds of its derivatives in each of at least 256 rectangles.
    pub fn on(surface: &'a (dyn Surface + Sync)) -> Self {
        let breaks = surface.breaks();
        let [us, vs] = breaks.each_ref().map(|places| {
            let parts = LEAST_LEAVES.div_ceil(places.len() - 1);
            let part = |pair: &[f64], k: usize| {
                let cut = |k: usize| {
                    if k == parts { pair[1] } else { pair[0] + (pair[1] - pair[0]) * (k as f64 / parts as f64) }
                };
                ([cut(k), cut(k + 1)], [pair[0], pair[1]])
            };
            places.windows(2).flat_map(|pair| (0..parts).map(move |k| part(pair, k))).collect::<Vec<_>>()
        });
        let cuts = [&us, &vs].map(|parts| {
            let ends = parts.iter().map(|(part, _)| part[1]);
            parts.first().map(|(part, _)| part[0]).into_iter().chain(ends).collect::<Vec<f64>>()
        });
        let bends = surface.bends([&cuts[0], &cuts[1]]);
        let mut leaves = Vec::with_capacity(us.len() * vs.len());
        for (i, (u, piece_u)) in us.iter().enumerate() {
            for (j, (v, piece_v)) in vs.iter().enumerate() {
                cancel::checkpoint();
                let bends = bends.as_ref().map_or_else(|| sampled(surface, *u, *v), |bends| bends[i * vs.len() + j]);
                leaves.push(Leaf { cell: Cell::new(surface, *u, *v, bends), piece: [*piece_u, *piece_v] });
            }
        }
        let mut found = ClosestPoint { surface, leaves, tree: Vec::new() };
        found.divide([0, us.len()], [0, vs.len()], vs.len());
        found
    }

    /// Builds the ball of a block of rectangles and returns its number; the block is halved along
    /// its longer side.
    fn divide(&mut self, [i, end_i]: [usize; 2], [j, end_j]: [usize; 2], columns: usize) -> usize {
        let (rows, wide) = (end_i - i, end_j - j);
        let ball = if rows == 1 && wide == 1 {
            let leaf = i * columns + j;
            let cell = &self.leaves[leaf].cell;
            Ball { center: cell.jet.value, radius: cell.radius() * (1.0 + 1e-12), content: Content::Leaf(leaf) }
        } else {
            let (a, b) = if rows >= wide {
                let middle = i + rows / 2;
                (self.divide([i, middle], [j, end_j], columns), self.divide([middle, end_i], [j, end_j], columns))
            } else {
                let middle = j + wide / 2;
                (self.divide([i, end_i], [j, middle], columns), self.divide([i, end_i], [middle, end_j], columns))
            };
            around(&self.tree[a], &self.tree[b], Content::Balls(a, b))
        };
        self.tree.push(ball);
        self.tree.len() - 1
    }

    /// The closest point to `node` (in space; a surface of heights takes the place of z(u, v)
    /// there).
    ///
    /// ```
    /// use flankfit_geometry::{
    ///     space::{Dimension, Vector},
    ///     surface::{BezierSurface, ClosestPoint},
    /// };
    ///
    /// // The plane z = 0 over the unit square, seen from below.
    /// let heights = vec![Vector::zeros(); 4];
    /// let unit = [[0.0, 1.0]; 2];
    /// let plane = BezierSurface::new([2, 2], unit, Dimension::Graph, heights, None)?;
    /// let foot = ClosestPoint::on(&plane).to(&Vector::new(0.25, 0.5, -2.0));
    /// assert!((foot.distance - 2.0).abs() < 1e-12 && foot.is_orthogonal);
    /// assert!((foot.signed_distance.unwrap() + 2.0).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn to(&self, node: &Vector) -> SurfacePoint {
        let mut best = Best { at: [0.0; 2], point: Vector::zeros(), square: f64::INFINITY, is_orthogonal: false };
        let mut queue = Queue::default();
        queue.push(0.0, Region::Ball(self.tree.len() - 1));
        let mut halved = 0;
        while let Some(Open { bound, part, .. }) = queue.heap.pop() {
            cancel::checkpoint();
            let distance = best.square.sqrt();
            let near = NEAR.iter().rev().find(|(from, _)| halved >= *from).map_or(0.0, |(_, near)| *near);
            if distance.is_finite() && bound >= distance - near * distance - NOISE * (node.norm() + best.point.norm()) {
                break;
            }
            match part {
                Region::Ball(ball) => match self.tree[ball].content {
                    Content::Leaf(leaf) => {
                        let Leaf { cell, piece } = self.leaves[leaf];
                        queue.push(cell.bound(node).max(bound), Region::Cell(Box::new((cell, piece))));
                    }
                    Content::Balls(a, b) => {
                        for k in [a, b] {
                            let ball = &self.tree[k];
                            queue.push(((ball.center - node).norm() - ball.radius).max(bound), Region::Ball(k));
                        }
                    }
                },
                Region::Cell(open) => {
                    let (cell, piece) = *open;
                    if self.settles(&cell, piece, node, &mut best) || halved == MOST_HALVED {
                        continue;
                    }
                    halved += 1;
                    for half in cell.halves(self.surface).into_iter().flatten() {
                        queue.push(half.bound(node).max(bound), Region::Cell(Box::new((half, piece))));
                    }
                }
            }
        }
        self.finished(node, &best)
    }

    /// Looks for a nearer point from a rectangle; whether there is surely none left in it.
    fn settles(&self, cell: &Cell, piece: Rectangle, node: &Vector, best: &mut Best) -> bool {
        if (cell.jet.value - node).norm_squared() < best.square {
            let found = descend(self.surface, piece, cell.middle, &cell.jet, node);
            if found.square < best.square {
                *best = found;
            }
        }
        if !cell.is_convex(node) {
            return false;
        }
        let mut sides = cell.sides();
        for (side, piece) in sides.iter_mut().zip(piece) {
            *side = side.map(|x| x.clamp(piece[0], piece[1]));
        }
        let inside = (0..2).all(|k| sides[k][0] <= best.at[k] && best.at[k] <= sides[k][1]);
        // a foot of the whole piece that lies in it is its nearest place
        if inside && best.is_orthogonal {
            return true;
        }
        let found = descend(self.surface, sides, cell.middle, &cell.jet, node);
        if found.square < best.square {
            // the rectangle's own border is no border of the piece
            let jet = place_within(self.surface, piece, found.at);
            let further = descend(self.surface, piece, found.at, &jet, node);
            *best = if further.square <= found.square { further } else { found };
        }
        true
    }

    /// The closest points to many nodes, in their order.
    pub fn to_each(&self, nodes: &[Vector]) -> Vec<SurfacePoint> {
        let handle = cancel::current();
        nodes.par_iter().with_min_len(16).map(|node| cancel::carry(handle.as_ref(), || self.to(node))).collect()
    }

    fn finished(&self, node: &Vector, best: &Best) -> SurfacePoint {
        let [u, v] = best.at;
        let distance = best.square.sqrt();
        let side = normal(self.surface, u, v).map(|n| (node - best.point).dot(&n));
        SurfacePoint {
            parameters: best.at,
            point: best.point,
            distance,
            signed_distance: side.map(|side| if side < 0.0 { -distance } else { distance }),
            is_orthogonal: best.is_orthogonal,
        }
    }
}

/// The smallest ball around two.
fn around(a: &Ball, b: &Ball, content: Content) -> Ball {
    let apart = (b.center - a.center).norm();
    if apart + b.radius <= a.radius {
        return Ball { content, ..*a };
    }
    if apart + a.radius <= b.radius {
        return Ball { content, ..*b };
    }
    let radius = 0.5 * (apart + a.radius + b.radius);
    let center = a.center + (b.center - a.center) * ((radius - a.radius) / apart);
    Ball { center, radius: radius * (1.0 + 1e-14), content }
}
