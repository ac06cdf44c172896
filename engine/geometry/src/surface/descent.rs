//! Downhill to the foot of the perpendicular: a damped Newton iteration for the squared distance of
//! a node, within a rectangle of parameters.

use super::{Surface, SurfaceJet};
use crate::space::Vector;

/// Steps of one Newton iteration at most, and halvings of one step.
const STEPS: usize = 60;
const HALVINGS: usize = 40;
/// Roundings of the coordinates in a squared distance.
pub(super) const NOISE: f64 = 8.0 * f64::EPSILON;
/// Ranges of u and of v.
pub(super) type Rectangle = [[f64; 2]; 2];

/// A place that nothing near it is closer than.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub at: [f64; 2],
    pub point: Vector,
    /// The squared distance.
    pub square: f64,
    pub is_orthogonal: bool,
}

/// The jet at a place of a smooth piece. A break belongs to the piece behind it; the derivatives of
/// the piece before it are those next to it.
pub(super) fn place_within(surface: &dyn Surface, room: Rectangle, [u, v]: [f64; 2]) -> SurfaceJet {
    let jet = surface.place(u, v);
    let domain = surface.domain();
    let within = |k: usize, x: f64| if x == room[k][1] && x < domain[k][1] { x.next_down() } else { x };
    let near = [within(0, u), within(1, v)];
    if near == [u, v] { jet } else { SurfaceJet { value: jet.value, ..surface.place(near[0], near[1]) } }
}

/// Newton's iteration from `start`, whose jet is known, held within `room`.
pub(super) fn descend(
    surface: &dyn Surface,
    room: Rectangle,
    start: [f64; 2],
    jet: &SurfaceJet,
    node: &Vector,
) -> Best {
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
        let Some((next, next_jet, next_square)) = step(surface, room, node, at, &jet, pressed) else { break };
        let moved = (0..2).any(|k| (next[k] - at[k]).abs() > 2.0 * f64::EPSILON * at[k].abs());
        (at, jet, square) = (next, next_jet, next_square);
        if !moved {
            break;
        }
    }
    Best { at, point: jet.value, square, is_orthogonal }
}

/// One step downhill: Newton's where the Hessian is positive definite, else ever more of the
/// gradient's direction; `None` if none is found that lowers the distance.
fn step(
    surface: &dyn Surface,
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
        let jet = place_within(surface, room, next);
        let found = (jet.value - node).norm_squared();
        // next to the foot the distance no longer distinguishes places, but its gradient does
        let noise = NOISE * square.sqrt() * (jet.value.norm() + node.norm());
        let flatter = || steepness(node, &jet, pressed) < 0.99 * slope;
        if found < square - noise || found <= square + noise && flatter() {
            return Some((next, jet, found));
        }
        length *= 0.5;
    }
    None
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

/// Solves `H d = −g` for the parameters that are free; `None` unless H is clearly positive definite
/// on these.
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
