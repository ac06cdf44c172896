//! The point of a surface that is closest to a given one: the orthogonal distance of a node.
//!
//! The surface is divided into small rectangles between its breaks, each within a ball, and the balls into a tree. A question descends
//! into the nearest ball first and leaves out every ball that lies further away than the best point found. In each rectangle
//! that is left, a damped Newton iteration looks for the foot of the perpendicular; it is held within the surface's own smooth piece,
//! so that edges and corners are found as such. The radius of a ball comes from samples and from second derivatives, with room to spare.

use super::{Surface, SurfaceJet, differential::normal};
use crate::geometry::space::Vector;
use rayon::prelude::*;

/// Rectangles along each parameter at least.
const LEAST_LEAVES: usize = 16;
/// Steps of one Newton iteration at most, and halvings of one step.
const STEPS: usize = 60;
const HALVINGS: usize = 40;
/// Roundings of the coordinates in a squared distance.
const NOISE: f64 = 8.0 * f64::EPSILON;
/// How much more the rectangles may bulge than the second derivatives at nine samples say.
const SLACK: f64 = 3.0;

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
    middle: [f64; 2],
    /// Half the sides.
    half: [f64; 2],
    piece: [[f64; 2]; 2],
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

/// The best place so far.
#[derive(Clone, Copy)]
struct Best {
    at: [f64; 2],
    point: Vector,
    square: f64,
    is_orthogonal: bool,
}

impl<'a> ClosestPoint<'a> {
    /// Prepares `surface`: some ten evaluations for each of at least 256 rectangles.
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
        let mut found = ClosestPoint { surface, leaves: Vec::new(), tree: Vec::new() };
        found.divide(&us, &vs);
        found
    }

    /// Builds the ball of a block of rectangles and returns its number; the block is halved along its longer side.
    fn divide(&mut self, us: &[Interval], vs: &[Interval]) -> usize {
        let ball = if us.len() == 1 && vs.len() == 1 {
            self.leaf(us[0], vs[0])
        } else {
            let (a, b) = if us.len() >= vs.len() {
                let (low, high) = us.split_at(us.len() / 2);
                (self.divide(low, vs), self.divide(high, vs))
            } else {
                let (low, high) = vs.split_at(vs.len() / 2);
                (self.divide(us, low), self.divide(us, high))
            };
            around(&self.tree[a], &self.tree[b], Content::Balls(a, b))
        };
        self.tree.push(ball);
        self.tree.len() - 1
    }

    fn leaf(&mut self, (u, piece_u): Interval, (v, piece_v): Interval) -> Ball {
        let middle = [0.5 * u[0] + 0.5 * u[1], 0.5 * v[0] + 0.5 * v[1]];
        let (hu, hv) = (0.5 * (u[1] - u[0]), 0.5 * (v[1] - v[0]));
        let center = self.surface.place(middle[0], middle[1]).value;
        let (mut radius, mut bulge) = (0.0f64, 0.0f64);
        for su in [-1.0, 0.0, 1.0] {
            for sv in [-1.0, 0.0, 1.0] {
                let (x, y) = ((middle[0] + su * hu).clamp(u[0], u[1]), (middle[1] + sv * hv).clamp(v[0], v[1]));
                let jet = self.surface.place(x, y);
                radius = radius.max((jet.value - center).norm());
                let bend = jet.uu.norm() * hu * hu + 2.0 * jet.uv.norm() * hu * hv + jet.vv.norm() * hv * hv;
                bulge = bulge.max(bend);
            }
        }
        self.leaves.push(Leaf { middle, half: [hu, hv], piece: [piece_u, piece_v] });
        // between samples half a side apart a function leaves its interpolant by an eighth of that square times its bend
        let content = Content::Leaf(self.leaves.len() - 1);
        Ball { center, radius: radius * (1.0 + 1e-12) + SLACK * 0.125 * bulge, content }
    }

    /// The closest point to `node` (in space; a surface of heights takes the place of z(u, v) there).
    pub fn to(&self, node: &Vector) -> SurfacePoint {
        let mut best = Best { at: [0.0; 2], point: Vector::zeros(), square: f64::INFINITY, is_orthogonal: false };
        let mut open = vec![(self.tree.len() - 1, 0.0)];
        while let Some((number, bound)) = open.pop() {
            if bound * bound >= best.square {
                continue;
            }
            match self.tree[number].content {
                Content::Leaf(leaf) => self.search(&self.leaves[leaf], node, &mut best),
                Content::Balls(a, b) => {
                    let bound = |k: usize| {
                        let ball = &self.tree[k];
                        ((ball.center - node).norm() - ball.radius).max(0.0)
                    };
                    let middle = |k: usize| (self.tree[k].center - node).norm_squared();
                    let (a, b) = if middle(a) <= middle(b) { (a, b) } else { (b, a) };
                    open.push((b, bound(b)));
                    open.push((a, bound(a)));
                }
            }
        }
        self.finished(node, &best)
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

    /// Looks for the foot from the middle of a rectangle, and from the nearest of nine places in it where that is another one:
    /// close to a border the way from the middle may lead elsewhere.
    fn search(&self, leaf: &Leaf, node: &Vector, best: &mut Best) {
        self.descend(leaf, leaf.middle, node, best);
        let square = |at: [f64; 2]| (self.surface.place(at[0], at[1]).value - node).norm_squared();
        let mut nearest = (leaf.middle, square(leaf.middle));
        for su in [-1.0, 0.0, 1.0] {
            for sv in [-1.0, 0.0, 1.0] {
                let place = |k: usize, s: f64| {
                    let [low, high] = leaf.piece[k];
                    (leaf.middle[k] + s * leaf.half[k]).clamp(low, high)
                };
                let at = [place(0, su), place(1, sv)];
                let found = square(at);
                if found < nearest.1 {
                    nearest = (at, found);
                }
            }
        }
        if nearest.0 != leaf.middle {
            self.descend(leaf, nearest.0, node, best);
        }
    }

    /// Newton's iteration from `start`, within the smooth piece of the rectangle.
    fn descend(&self, leaf: &Leaf, start: [f64; 2], node: &Vector, best: &mut Best) {
        let mut at = start;
        let mut jet = self.surface.place(at[0], at[1]);
        let mut square = (jet.value - node).norm_squared();
        let mut is_orthogonal = false;
        for _ in 0..STEPS {
            let rest = jet.value - node;
            let gradient = [rest.dot(&jet.u), rest.dot(&jet.v)];
            // a border that the point is pressed against holds that parameter
            let pressed = [0, 1].map(|k| {
                let [low, high] = leaf.piece[k];
                at[k] <= low && gradient[k] >= 0.0 || at[k] >= high && gradient[k] <= 0.0
            });
            let size = rest.norm();
            let flat = |k: usize, tangent: &Vector| gradient[k].abs() <= 4.0 * f64::EPSILON * size * tangent.norm();
            is_orthogonal =
                gradient[0].abs() <= 1e-10 * size * jet.u.norm() && gradient[1].abs() <= 1e-10 * size * jet.v.norm();
            if (pressed[0] || flat(0, &jet.u)) && (pressed[1] || flat(1, &jet.v)) {
                break;
            }
            let Some((next, next_jet, next_square)) = self.step(leaf, node, at, &jet, pressed) else { break };
            let moved = (0..2).any(|k| (next[k] - at[k]).abs() > 2.0 * f64::EPSILON * at[k].abs());
            (at, jet, square) = (next, next_jet, next_square);
            if !moved {
                break;
            }
        }
        let point = jet.value;
        if square < best.square {
            *best = Best { at, point, square, is_orthogonal };
        }
    }

    /// One step downhill: Newton's where the Hessian is positive definite, else ever more of the gradient's direction; `None` if none
    /// is found that lowers the distance.
    fn step(
        &self,
        leaf: &Leaf,
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
        let widths = leaf.piece.map(|[low, high]| high - low);
        let newton = [0, 1, 2].map(|k| gauss[k] + bend[k]);
        let direction = direction(newton, gradient, pressed)
            .or_else(|| direction(gauss, gradient, pressed))
            .unwrap_or_else(|| [0, 1].map(|k| if pressed[k] { 0.0 } else { -gradient[k].signum() * 0.1 * widths[k] }));
        let slope = steepness(node, jet, pressed);
        let mut length = 1.0;
        for _ in 0..HALVINGS {
            let next = [0, 1].map(|k| {
                let [low, high] = leaf.piece[k];
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

/// A part of an axis and the smooth piece that it lies in.
type Interval = ([f64; 2], [f64; 2]);

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
