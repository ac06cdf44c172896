//! The point of a surface that is closest to a given one: the orthogonal distance of a node.
//!
//! The surface is divided into small rectangles between its breaks, each within a ball, and the balls into a tree. What lies nearest comes
//! first: balls are opened into balls, rectangles are searched and halved, until nothing is left that could be nearer than the best
//! point found. What is left out is left out by a bound that holds in all of it: Taylor's formula with bounds of the second
//! derivatives (`bends.rs`, `closest_cell.rs`). Of surfaces that are no B-splines those bounds come from samples, with room to spare.
//!
//! Feet are found by a damped Newton iteration, held within the surface's own smooth piece, so that edges and corners are found as such.

use super::{Surface, SurfaceJet, bends::sampled, closest_cell::Cell, differential::normal};
use crate::geometry::space::Vector;
use rayon::prelude::*;
use std::{cmp::Ordering, collections::BinaryHeap};

/// Rectangles along each parameter at least.
const LEAST_LEAVES: usize = 16;
/// Steps of one Newton iteration at most, and halvings of one step.
const STEPS: usize = 60;
const HALVINGS: usize = 40;
/// Roundings of the coordinates in a squared distance.
const NOISE: f64 = 8.0 * f64::EPSILON;
/// What could be nearer by this part of the distance at most is left out.
const NEAR: f64 = 1e-9;
/// Rectangles that one question halves at most. Only where a whole line or part of the surface is as near as its foot, about the centre of
/// a sphere, are there so many; these places are then as good.
const MOST_HALVED: usize = 20_000;

/// The closest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    /// (u, v) of the point.
    pub parameters: [f64; 2],
    /// The point; (u, v, z) on a surface of heights.
    pub point: Vector,
    /// How far it is.
    pub distance: f64,
    /// The same, below 0 on the side that the normal S_u × S_v points away from. None where there is no normal.
    pub signed_distance: Option<f64>,
    /// Whether the connection is at right angles to the surface, to rounding; if not, the point is on a border or an edge.
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

type Rectangle = [[f64; 2]; 2];

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

/// The best place so far.
#[derive(Clone, Copy)]
struct Best {
    at: [f64; 2],
    point: Vector,
    square: f64,
    is_orthogonal: bool,
}

/// What is still to be looked at: nothing in it is nearer than `bound`.
struct Open {
    bound: f64,
    /// How many were there before.
    order: usize,
    part: Part,
}

enum Part {
    Ball(usize),
    Cell(Cell, Rectangle),
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
    fn push(&mut self, bound: f64, part: Part) {
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
                let bends = bends.as_ref().map_or_else(|| sampled(surface, *u, *v), |bends| bends[i * vs.len() + j]);
                leaves.push(Leaf { cell: Cell::new(surface, *u, *v, bends), piece: [*piece_u, *piece_v] });
            }
        }
        let mut found = ClosestPoint { surface, leaves, tree: Vec::new() };
        found.divide([0, us.len()], [0, vs.len()], vs.len());
        found
    }

    /// Builds the ball of a block of rectangles and returns its number; the block is halved along its longer side.
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

    /// The closest point to `node` (in space; a surface of heights takes the place of z(u, v) there).
    pub fn to(&self, node: &Vector) -> SurfacePoint {
        let mut best = Best { at: [0.0; 2], point: Vector::zeros(), square: f64::INFINITY, is_orthogonal: false };
        let mut queue = Queue::default();
        queue.push(0.0, Part::Ball(self.tree.len() - 1));
        let mut halved = 0;
        while let Some(Open { bound, part, .. }) = queue.heap.pop() {
            let distance = best.square.sqrt();
            if distance.is_finite() && bound >= distance - NEAR * distance - NOISE * (node.norm() + best.point.norm()) {
                break;
            }
            match part {
                Part::Ball(ball) => match self.tree[ball].content {
                    Content::Leaf(leaf) => {
                        let Leaf { cell, piece } = self.leaves[leaf];
                        queue.push(cell.bound(node).max(bound), Part::Cell(cell, piece));
                    }
                    Content::Balls(a, b) => {
                        for k in [a, b] {
                            let ball = &self.tree[k];
                            queue.push(((ball.center - node).norm() - ball.radius).max(bound), Part::Ball(k));
                        }
                    }
                },
                Part::Cell(cell, piece) => {
                    if self.settles(&cell, piece, node, &mut best) || halved == MOST_HALVED {
                        continue;
                    }
                    halved += 1;
                    for half in cell.halves(self.surface).into_iter().flatten() {
                        queue.push(half.bound(node).max(bound), Part::Cell(half, piece));
                    }
                }
            }
        }
        self.finished(node, &best)
    }

    /// Looks for a nearer point from a rectangle; whether there is surely none left in it.
    fn settles(&self, cell: &Cell, piece: Rectangle, node: &Vector, best: &mut Best) -> bool {
        if (cell.jet.value - node).norm_squared() < best.square {
            let found = self.descend(piece, cell.middle, &cell.jet, node);
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
        let found = self.descend(sides, cell.middle, &cell.jet, node);
        if found.square < best.square {
            // the rectangle's own border is no border of the piece
            let jet = self.surface.place(found.at[0], found.at[1]);
            let further = self.descend(piece, found.at, &jet, node);
            *best = if further.square <= found.square { further } else { found };
        }
        true
    }

    /// The closest points to many nodes, in their order.
    pub fn to_each(&self, nodes: &[Vector]) -> Vec<SurfacePoint> {
        nodes.par_iter().with_min_len(16).map(|node| self.to(node)).collect()
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

    /// Newton's iteration from `start`, whose jet is known, held within `room`.
    fn descend(&self, room: Rectangle, start: [f64; 2], jet: &SurfaceJet, node: &Vector) -> Best {
        let (mut at, mut jet) = (start, *jet);
        let mut square = (jet.value - node).norm_squared();
        let mut is_orthogonal = false;
        for _ in 0..STEPS {
            let rest = jet.value - node;
            let gradient = [rest.dot(&jet.u), rest.dot(&jet.v)];
            // a border that the point is pressed against holds that parameter
            let pressed = [0, 1].map(|k| {
                let [low, high] = room[k];
                at[k] <= low && gradient[k] >= 0.0 || at[k] >= high && gradient[k] <= 0.0
            });
            let size = rest.norm();
            let flat = |k: usize, tangent: &Vector| gradient[k].abs() <= 4.0 * f64::EPSILON * size * tangent.norm();
            is_orthogonal =
                gradient[0].abs() <= 1e-10 * size * jet.u.norm() && gradient[1].abs() <= 1e-10 * size * jet.v.norm();
            if (pressed[0] || flat(0, &jet.u)) && (pressed[1] || flat(1, &jet.v)) {
                break;
            }
            let Some((next, next_jet, next_square)) = self.step(room, node, at, &jet, pressed) else { break };
            let moved = (0..2).any(|k| (next[k] - at[k]).abs() > 2.0 * f64::EPSILON * at[k].abs());
            (at, jet, square) = (next, next_jet, next_square);
            if !moved {
                break;
            }
        }
        Best { at, point: jet.value, square, is_orthogonal }
    }

    /// One step downhill: Newton's where the Hessian is positive definite, else ever more of the gradient's direction; `None` if none
    /// is found that lowers the distance.
    fn step(
        &self,
        room: Rectangle,
        node: &Vector,
        at: [f64; 2],
        jet: &SurfaceJet,
        pressed: [bool; 2],
    ) -> Option<([f64; 2], SurfaceJet, f64)> {
        let rest = jet.value - node;
        let square = rest.norm_squared();
        let gradient = [rest.dot(&jet.u), rest.dot(&jet.v)];
        let gauss = [jet.u.norm_squared(), jet.u.dot(&jet.v), jet.v.norm_squared()];
        let bend = [rest.dot(&jet.uu), rest.dot(&jet.uv), rest.dot(&jet.vv)];
        let widths = room.map(|[low, high]| high - low);
        let newton = [0, 1, 2].map(|k| gauss[k] + bend[k]);
        let direction = direction(newton, gradient, pressed)
            .or_else(|| direction(gauss, gradient, pressed))
            .unwrap_or_else(|| [0, 1].map(|k| if pressed[k] { 0.0 } else { -gradient[k].signum() * 0.1 * widths[k] }));
        let slope = steepness(node, jet, pressed);
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            let next = [0, 1].map(|k| {
                let [low, high] = room[k];
                (at[k] + length * direction[k]).clamp(low, high)
            });
            if next == at {
                return None;
            }
            let jet = self.surface.place(next[0], next[1]);
            let found = (jet.value - node).norm_squared();
            // next to the foot the distance no longer tells places apart, but its gradient does
            let noise = NOISE * square.sqrt() * (jet.value.norm() + node.norm());
            let flatter = || steepness(node, &jet, pressed) < 0.99 * slope;
            if found < square - noise || found <= square + noise && flatter() {
                return Some((next, jet, found));
            }
            length *= 0.5;
        }
        None
    }
}

/// The larger cosine of the free tangents with the connection, times its length.
fn steepness(node: &Vector, jet: &SurfaceJet, pressed: [bool; 2]) -> f64 {
    let rest = jet.value - node;
    let along = |k: usize, tangent: &Vector| {
        let length = tangent.norm();
        if pressed[k] || length == 0.0 { 0.0 } else { (rest.dot(tangent) / length).abs() }
    };
    along(0, &jet.u).max(along(1, &jet.v))
}

/// Solves `H d = −g` for the parameters that are free; `None` unless H is clearly positive definite on these.
fn direction([a, b, c]: [f64; 3], [gu, gv]: [f64; 2], pressed: [bool; 2]) -> Option<[f64; 2]> {
    match pressed {
        [true, true] => None,
        [true, false] => (c > 0.0).then(|| [0.0, -gv / c]),
        [false, true] => (a > 0.0).then(|| [-gu / a, 0.0]),
        [false, false] => {
            let determinant = a * c - b * b;
            let definite = a > 0.0 && c > 0.0 && determinant > 1e-12 * a * c;
            definite.then(|| [(b * gv - c * gu) / determinant, (b * gu - a * gv) / determinant])
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
