//! The height of a surface over a plane, as a function of the parameters.

use crate::{
    space::Vector,
    surface::{Surface, SurfaceJet},
};

/// Steps of Newton's method at most.
const STEPS: usize = 40;
/// The same for places without slope: where it has not settled by then, the height is too flat.
const NEAREST: usize = 16;
/// The part of the way to a side that a step across it goes.
const STAY: f64 = 0.9;
/// The shortest part of a step that is tried.
const SHORTEST: f64 = 1e-3;
/// Moves, in widths of the parameters, that may be rounding.
const SETTLED: f64 = 1e-11;

/// The height `n · S(u, v) − d` over a rectangle in which the surface is smooth.
pub(super) struct Field<'a> {
    pub surface: &'a dyn Surface,
    /// Which of the surface's patches it is.
    pub patch: usize,
    /// Unit normal of the plane.
    pub normal: Vector,
    pub offset: f64,
    /// The rectangle, [low, high] of u and of v.
    pub smooth: [[f64; 2]; 2],
}

/// The height with its derivatives.
pub(super) struct Local {
    pub jet: SurfaceJet,
    pub height: f64,
    pub slope: [f64; 2],
    /// ∂²/∂u², ∂²/∂u∂v, ∂²/∂v².
    pub bend: [f64; 3],
    /// One over the squares of the rectangle's widths, which make both parameters comparable.
    pub metric: [f64; 2],
}

impl Local {
    /// Whether the surface has no tangent plane here.
    pub(super) fn is_pole(&self) -> bool {
        let (u, v) = (self.jet.u, self.jet.v);
        u.cross(&v).norm() <= 1e-9 * u.norm_squared().max(v.norm_squared())
    }

    /// The tangent of the section and the parameters' derivatives along it, per length: at right
    /// angles to the slope, or where that vanishes along a direction in which the height bends to
    /// neither side; of two such directions the one nearer to `chord`. `None` where there is none.
    pub(super) fn tangent(&self, kind: Kind, chord: Vector) -> Option<(Vector, [f64; 2])> {
        let directions = match kind {
            Kind::Across => vec![[-self.slope[1], self.slope[0]]],
            Kind::Touching | Kind::End => self.flat_directions(),
        };
        let [e, g] = self.metric.map(f64::sqrt);
        let whole = self.jet.u.norm() / e + self.jet.v.norm() / g;
        let candidates = directions.into_iter().filter_map(|[a, b]| {
            let tangent = self.jet.u * a + self.jet.v * b;
            let length = tangent.norm();
            let sign = if tangent.dot(&chord) < 0.0 { -1.0 } else { 1.0 };
            // at a pole one parameter leads nowhere
            (length > 1e-9 * whole * (a * e).abs().max((b * g).abs()) && length.is_finite())
                .then(|| (tangent * (sign / length), [a * sign / length, b * sign / length]))
        });
        candidates.max_by(|a, b| a.0.dot(&chord).total_cmp(&b.0.dot(&chord)))
    }

    /// How far rounding may move the section at a place: the rounding of the height over the part
    /// of the normal that lies in the surface.
    pub(super) fn rounding(&self, normal: &Vector, offset: f64) -> f64 {
        let height = 4.0 * f64::EPSILON * (self.jet.value.norm() + offset.abs());
        match self.jet.u.cross(&self.jet.v).try_normalize(0.0) {
            Some(own) => height / (normal - own * own.dot(normal)).norm().max(1e-12),
            None => height,
        }
    }

    /// Directions in which `uu a² + 2 uv a b + vv b²` is 0, or nearest to it.
    fn flat_directions(&self) -> Vec<[f64; 2]> {
        let [e, g] = self.metric;
        let [a, b, c] = [self.bend[0] / e, self.bend[1] / (e * g).sqrt(), self.bend[2] / g];
        let root = (b * b - a * c).max(0.0).sqrt();
        let q = if b >= 0.0 { b + root } else { b - root };
        let scaled = if q == 0.0 && a == 0.0 && c == 0.0 {
            vec![[1.0, 0.0], [0.0, 1.0]]
        } else if root <= 1e-6 * (a.abs() + c.abs()) {
            // one direction, twice
            if a.abs() > c.abs() { vec![[-b, a]] } else { vec![[c, -b]] }
        } else {
            vec![[c, -q], [q, -a]]
        };
        scaled.into_iter().map(|[x, y]| [x / e.sqrt(), y / g.sqrt()]).collect()
    }
}

impl Field<'_> {
    pub(super) fn at(&self, at: [f64; 2]) -> Local {
        let domain = self.surface.domain();
        // at the upper end of the rectangle its own piece counts, not the next one
        let own = |k: usize| {
            let high = self.smooth[k][1];
            if at[k] >= high && high < domain[k][1] { high.next_down() } else { at[k] }
        };
        let jet = self.surface.place(own(0), own(1));
        let along = |d: &Vector| self.normal.dot(d);
        Local {
            height: along(&jet.value) - self.offset,
            slope: [along(&jet.u), along(&jet.v)],
            bend: [along(&jet.uu), along(&jet.uv), along(&jet.vv)],
            metric: self.smooth.map(|[low, high]| (high - low).powi(-2)),
            jet,
        }
    }

    pub(super) fn height(&self, [u, v]: [f64; 2]) -> f64 {
        let point = if self.surface.dimension().is_parametric() {
            self.surface.value(u, v)
        } else {
            Vector::new(u, v, self.surface.value(u, v).x)
        };
        self.normal.dot(&point) - self.offset
    }

    fn inside(&self, at: [f64; 2]) -> [f64; 2] {
        std::array::from_fn(|k| at[k].clamp(self.smooth[k][0], self.smooth[k][1]))
    }

    /// The place of the section near `at`: by Newton's method down the slope, or where the plane
    /// touches to where the height is least along the parameter in which it bends more.
    pub(super) fn onto(&self, at: [f64; 2], kind: Kind) -> [f64; 2] {
        let (mut at, mut before) = (self.inside(at), f64::INFINITY);
        for _ in 0..STEPS {
            let local = self.at(at);
            let [e, g] = local.metric;
            let step = match kind {
                Kind::Across | Kind::End => {
                    let [a, b] = [local.slope[0] / e, local.slope[1] / g];
                    let size = a * local.slope[0] + b * local.slope[1];
                    if size == 0.0 {
                        return at;
                    }
                    [local.height * a / size, local.height * b / size]
                }
                Kind::Touching if local.bend[0].abs() * g >= local.bend[2].abs() * e => {
                    [local.slope[0] / local.bend[0], 0.0]
                }
                Kind::Touching => [0.0, local.slope[1] / local.bend[2]],
            };
            if !step.iter().all(|x| x.is_finite()) {
                return at;
            }
            let next = self.inside([at[0] - step[0], at[1] - step[1]]);
            let share = |k: usize| {
                let [low, high] = self.smooth[k];
                (next[k] - at[k]).abs() / (next[k].abs().max(at[k].abs()) + high - low)
            };
            let moved = share(0).max(share(1));
            at = next;
            // what no longer becomes less is rounding
            if moved <= f64::EPSILON || (moved <= SETTLED && moved >= before) {
                break;
            }
            before = moved;
        }
        at
    }

    /// The place of the section with `along · S = offset` that Newton's method leads to from
    /// `start`, shortening steps that lead further away.
    pub(super) fn across(&self, start: [f64; 2], along: &Vector, offset: f64) -> Option<[f64; 2]> {
        let mut at = self.inside(start);
        let mut local = self.at(at);
        let misses = |local: &Local| [local.height, along.dot(&local.jet.value) - offset];
        let size = |[x, y]: [f64; 2]| x.hypot(y);
        let mut miss = misses(&local);
        for _ in 0..STEPS {
            let rounding = 4.0 * f64::EPSILON * (local.jet.value.norm() + self.offset.abs());
            if size(miss) <= rounding {
                return Some(at);
            }
            let [[a, b], [c, d]] = [local.slope, [along.dot(&local.jet.u), along.dot(&local.jet.v)]];
            let determinant = a * d - b * c;
            let mut step = [(d * miss[0] - b * miss[1]) / determinant, (a * miss[1] - c * miss[0]) / determinant];
            if !step.iter().all(|x| x.is_finite()) {
                return None;
            }
            for k in 0..2 {
                let [low, high] = self.smooth[k];
                let room = if step[k] > 0.0 { at[k] - low } else { high - at[k] };
                // a pole is no place to begin the next step at
                if step[k].abs() > room {
                    step[k] = (STAY * room).copysign(step[k]);
                }
            }
            let mut share = 1.0;
            let next = loop {
                let next = self.inside([at[0] - share * step[0], at[1] - share * step[1]]);
                let there = self.at(next);
                let missed = misses(&there);
                if size(missed) < size(miss) {
                    break Some((next, there, missed));
                }
                share *= 0.5;
                if share < SHORTEST {
                    break None;
                }
            };
            let Some(next) = next else {
                // what no longer becomes less may be rounding
                return (size(miss) <= 64.0 * rounding).then_some(at);
            };
            (at, local, miss) = next;
        }
        None
    }

    /// A place without slope near `start`, no further off than `reach`, and how the height bends
    /// there: how many of its two curvatures are not 0, and their product's sign.
    pub(super) fn stationary(&self, start: [f64; 2], reach: [f64; 2]) -> Option<([f64; 2], Bending)> {
        let mut at = start;
        for _ in 0..NEAREST {
            let local = self.at(at);
            // by lengths in space, at a pole in widths of the rectangle
            let [e, g] =
                if local.is_pole() { local.metric.map(f64::sqrt) } else { [local.jet.u.norm(), local.jet.v.norm()] };
            let [a, b, c] = [local.bend[0] / (e * e), local.bend[1] / (e * g), local.bend[2] / (g * g)];
            let [x, y] = [local.slope[0] / e, local.slope[1] / g];
            let (half, mean) = ((0.5 * (a - c)).hypot(b), 0.5 * (a + c));
            let values = [mean + half, mean - half];
            let largest = values[0].abs().max(values[1].abs());
            // the eigenvector of the first value
            let angle = 0.5 * (2.0 * b).atan2(a - c);
            let (sin, cos) = angle.sin_cos();
            let along = [x * cos + y * sin, y * cos - x * sin];
            let steps: [f64; 2] =
                std::array::from_fn(|k| if values[k].abs() > 1e-6 * largest { along[k] / values[k] } else { 0.0 });
            let step = [(steps[0] * cos - steps[1] * sin) / e, (steps[0] * sin + steps[1] * cos) / g];
            if !step.iter().all(|x| x.is_finite()) {
                return None;
            }
            let next = [at[0] - step[0], at[1] - step[1]];
            let moved =
                (0..2).map(|k| (next[k] - at[k]).abs() / (self.smooth[k][1] - self.smooth[k][0])).fold(0.0, f64::max);
            at = self.inside(next);
            // on the way it may be twice as far off
            if (0..2).any(|k| (at[k] - start[k]).abs() > 2.0 * reach[k]) {
                return None;
            }
            if moved <= 1e-12 {
                let flat = values.iter().filter(|value| !(value.abs() > 1e-6 * largest)).count();
                let bending = match flat {
                    1 if largest > 0.0 => Bending::Trough,
                    0 if values[0] * values[1] > 0.0 => Bending::Bowl,
                    _ => Bending::Saddle,
                };
                return Some((at, bending));
            }
        }
        None
    }

    /// Place where the height, or for `axis` its derivative along that parameter, changes its sign
    /// between `from` and `to`.
    pub(super) fn crossing(&self, from: [f64; 2], to: [f64; 2], axis: Option<usize>) -> [f64; 2] {
        let value = |at: [f64; 2]| match axis {
            None => self.height(at),
            Some(axis) => self.at(at).slope[axis],
        };
        let between = |t: f64| -> [f64; 2] { std::array::from_fn(|k| from[k] * (1.0 - t) + to[k] * t) };
        let (mut low, mut high) = (0.0, 1.0);
        let (mut below, mut above) = (value(from), value(to));
        let side = below >= 0.0;
        // an end may count as 0 without being it
        if side == (above >= 0.0) {
            return if below.abs() <= above.abs() { from } else { to };
        }
        let mut halve = false;
        for _ in 0..200 {
            // the secant, and bisection wherever it keeps one end
            let share = below / (below - above);
            let t =
                if halve || !(share > 0.0 && share < 1.0) { 0.5 * (low + high) } else { low + share * (high - low) };
            if !(t > low && t < high) {
                break;
            }
            let found = value(between(t));
            halve = !halve;
            if (found >= 0.0) == side { (low, below) = (t, found) } else { (high, above) = (t, found) }
        }
        between(if below.abs() <= above.abs() { low } else { high })
    }
}

/// Kind of the section at a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// The surface passes through the plane.
    Across,
    /// The plane touches the surface along a line.
    Touching,
    /// The end of a line at a place without slope.
    End,
}

/// How a height bends where it has no slope.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Bending {
    /// To one side all around: the plane touches in a point.
    Bowl,
    /// To one side along one direction and not at all along the other: it touches along a line.
    Trough,
    /// To both sides: branches cross.
    Saddle,
}
