//! The nearest function that meets the constraints, and the proof.
//!
//! In Q's coordinates Σ w r² grows by the square of the distance from least squares, and a
//! derivative at a place is a linear form: of all points where infinitely many forms are not below
//! 0 the nearest one is sought. The places where it is violated most are found by branch and bound,
//! enter the problem one by one ([`NearestPoint`]), and leave it where they limit nothing any more;
//! so on until nothing is violated by more than [`TOLERANCE`].
//!
//! What is left of the violation is removed along a function that lies well inside all constraints.
//! So the result meets them at every place, by bounds on Bernstein coefficients. The multipliers of
//! the places bound from below the Σ w r² of any such function, and so the cost of that last step.

use nalgebra::DMatrix;

use super::field::{Field, Spot, net};
use crate::design::Design;
use flankfit_numerics::{
    Dd, cancel,
    check::Faults,
    polyhedron::{Empty, NearestPoint},
    triangular,
};

/// Greatest violation of derivatives before the last step, relative to the largest derivative of
/// least squares.
const TOLERANCE: f64 = 1e-8;
/// Least margin above 0 in the end, relative likewise.
const FLOOR: f64 = 1e-11;
/// Distance inside the constraints of the function along which the last step goes: derivatives of
/// at least this, where 1 was required at the places that were examined.
const INSIDE: f64 = 0.5;
/// Rounds in which violated places are looked for, at most.
const ROUNDS: usize = 60;
/// Places nearer than this share of the range are one.
const ONE_PLACE: f64 = 2e-3;

/// The least-squares problem in Q's coordinates.
pub(super) struct Problem<'a> {
    pub design: &'a Design,
    pub r: &'a DMatrix<Dd>,
    /// Qᵀy.
    pub qty: &'a [Dd],
    pub fields: Vec<Field>,
}

/// The nearest point that meets all constraints.
pub(super) struct Solution {
    /// In Q's coordinates.
    pub point: Vec<Dd>,
    /// Lower bounds of the derivatives of least squares and of the answer, by constraint.
    pub before: Vec<f64>,
    pub bounds: Vec<f64>,
    pub active: Vec<Active>,
    /// Increase of Σ w r², and a lower bound of it.
    pub grown: f64,
    pub grown_at_least: f64,
    /// Length of the gradient of the Lagrangian over that of Qᵀy.
    pub stationarity: f64,
    pub rounds: usize,
}

/// A place where a constraint holds the function back.
pub(super) struct Active {
    pub field: usize,
    pub place: [f64; 2],
    pub multiplier: f64,
    /// The derivative there as a form, in Q's coordinates.
    pub normal: Vec<f64>,
}

/// State of a search.
struct Search {
    nearest: NearestPoint,
    spots: Vec<Spot>,
    rounds: usize,
}

/// Constraints that exclude each other.
fn exclusive() -> Faults {
    let message = "no function of the model meets all of these constraints with a margin: they exclude each other";
    Faults::one("constraints", message)
}

impl Problem<'_> {
    /// Scales the fields by the derivatives of least squares.
    pub(super) fn scale(&mut self) {
        let working = self.working(self.qty);
        let of_least_squares = net(self.design, &working);
        let size = of_least_squares.iter().map(|c| c.to_f64().abs()).fold(0.0, f64::max);
        for field in &mut self.fields {
            let scale = field.largest(&of_least_squares).max(1e-9 * size / field.width().powi(2).max(field.width()));
            field.scale = if scale > 0.0 && scale.is_finite() { scale } else { 1.0 };
        }
    }

    pub(super) fn solve(&self) -> Result<Solution, Faults> {
        let before = self.bounds(self.qty);
        if before.iter().all(|bound| *bound >= 0.0) {
            return Ok(Solution {
                point: self.qty.to_vec(),
                bounds: before.clone(),
                before,
                active: Vec::new(),
                grown: 0.0,
                grown_at_least: 0.0,
                stationarity: 0.0,
                rounds: 0,
            });
        }
        let start: Vec<f64> = self.qty.iter().map(|b| b.to_f64()).collect();
        let found = self.search(start, 0.0, -TOLERANCE).map_err(|Empty| exclusive())?;
        let (multipliers, nearest) = self.refined(&found);
        let way: Vec<Dd> = nearest.iter().zip(self.qty).map(|(&x, &b)| x - b).collect();
        let (point, bounds) = self.moved_inside(nearest)?;
        let beyond = |k: usize| point[k] - self.qty[k] - way[k];
        let forces: Vec<Dd> = self.forces(&found, &multipliers);
        // −‖Gμ‖² − 2 (Gμ)ᵀb, the value of the dual problem
        let dual = forces.iter().zip(self.qty).fold(Dd::ZERO, |sum, (&f, &b)| sum - f * (f + b + b)).to_f64();
        let length = norm(self.qty.iter().copied());
        Ok(Solution {
            grown: norm(point.iter().zip(self.qty).map(|(&x, &b)| x - b)).powi(2),
            grown_at_least: dual.max(0.0),
            stationarity: if length > 0.0 { norm((0..point.len()).map(beyond)) / length } else { 0.0 },
            active: self.active(&found, &multipliers),
            rounds: found.rounds,
            point,
            before,
            bounds,
        })
    }

    /// Working coefficients of a point.
    pub(super) fn working(&self, point: &[Dd]) -> Vec<Dd> {
        let mut working = point.to_vec();
        triangular::solve_upper(self.r, &mut working);
        working
    }

    /// Lower bounds of the derivatives, in units of their scales: between half the least value and
    /// all of it.
    fn bounds(&self, point: &[Dd]) -> Vec<f64> {
        let net = net(self.design, &self.working(point));
        self.fields.iter().map(|field| field.bound(&net, |value| 0.5 * value.abs() + 1e-14)).collect()
    }

    /// The point nearest to `start` where the derivatives are at least `bound` at the places that
    /// matter, and so at least `enough` about everywhere.
    fn search(&self, start: Vec<f64>, bound: f64, enough: f64) -> Result<Search, Empty> {
        let mut search = Search { nearest: NearestPoint::new(start), spots: Vec::new(), rounds: 0 };
        while search.rounds < ROUNDS {
            cancel::checkpoint();
            search.rounds += 1;
            let point: Vec<Dd> = search.nearest.at().iter().map(|&x| Dd::from(x)).collect();
            let violated = self.violated(&point, bound, enough);
            if violated.is_empty() {
                break;
            }
            for spot in violated {
                let normal = self.normal(&spot).iter().map(|x| x.to_f64()).collect();
                search.nearest.enter(normal, bound, search.spots.len())?;
                search.spots.push(spot);
            }
        }
        Ok(search)
    }

    /// The lowest place of each part of a cell where a derivative falls below `enough`, worst
    /// first.
    fn violated(&self, point: &[Dd], bound: f64, enough: f64) -> Vec<Spot> {
        let net = net(self.design, &self.working(point));
        let room = bound - enough;
        let near = |value: f64| (0.02 * (bound - value)).max(0.5 * room);
        let mut found = Vec::new();
        for (index, field) in self.fields.iter().enumerate() {
            let lows = field.lows(&net, enough, near).into_iter();
            found.extend(lows.map(|(cell, least)| (least.value, Spot { field: index, cell, at: least.at })));
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found.into_iter().map(|(_, spot)| spot).collect()
    }

    /// A spot's derivative as a form, in Q's coordinates.
    fn normal(&self, spot: &Spot) -> Vec<Dd> {
        let mut row = self.fields[spot.field].row(self.design, spot);
        // splines are 0 before those that reach the spot
        let first = row.iter().position(|x| *x != Dd::ZERO).unwrap_or(row.len());
        triangular::solve_upper_transposed_from(self.r, first, &mut row);
        row
    }

    /// Multipliers and point of the active places to twice the digits of double.
    fn refined(&self, found: &Search) -> (Vec<Dd>, Vec<Dd>) {
        let active = found.nearest.active();
        let normals: Vec<Vec<Dd>> = active.iter().map(|one| self.normal(&found.spots[one.tag])).collect();
        let mut multipliers: Vec<Dd> = active.iter().map(|one| Dd::from(one.multiplier)).collect();
        let point = |multipliers: &[Dd]| {
            let mut point = self.qty.to_vec();
            for (normal, &multiplier) in normals.iter().zip(multipliers) {
                point.iter_mut().zip(normal).for_each(|(x, &n)| *x += multiplier * n);
            }
            point
        };
        for _ in 0..4 {
            let at = point(&multipliers);
            let missing = normals.iter().zip(active).map(|(normal, one)| {
                let here = normal.iter().zip(&at).fold(Dd::ZERO, |sum, (&n, &x)| sum + n * x);
                (Dd::from(one.bound) - here).to_f64()
            });
            let mut missing: Vec<f64> = missing.collect();
            found.nearest.solve_gram(&mut missing);
            multipliers.iter_mut().zip(missing).for_each(|(u, change)| *u += Dd::from(change));
        }
        // the bound from below needs multipliers that are not below 0
        multipliers.iter_mut().filter(|u| **u < Dd::ZERO).for_each(|u| *u = Dd::ZERO);
        let at = point(&multipliers);
        (multipliers, at)
    }

    /// The point moved until all derivatives are certain not to be below 0, and their bounds.
    fn moved_inside(&self, nearest: Vec<Dd>) -> Result<(Vec<Dd>, Vec<f64>), Faults> {
        let mut bounds = self.bounds(&nearest);
        let least = |bounds: &[f64]| bounds.iter().copied().fold(f64::INFINITY, f64::min);
        if least(&bounds) >= FLOOR {
            return Ok((nearest, bounds));
        }
        let inside = self.search(vec![0.0; nearest.len()], 1.0, INSIDE).map_err(|Empty| exclusive())?;
        let inside: Vec<Dd> = inside.nearest.at().iter().map(|&x| Dd::from(x)).collect();
        if least(&self.bounds(&inside)) < 0.25 * INSIDE {
            return Err(exclusive());
        }
        let mut step = 0.0;
        // each step goes at least as far as the bounds say that it has to, and further each time
        for turn in 0..20 {
            step += f64::from(1u32 << turn) * (2.0 * FLOOR - least(&bounds).min(0.0)) / INSIDE;
            let point: Vec<Dd> = nearest.iter().zip(&inside).map(|(&x, &s)| x + s * step).collect();
            bounds = self.bounds(&point);
            if least(&bounds) >= 0.0 {
                return Ok((point, bounds));
            }
        }
        Err(exclusive())
    }

    /// Σ multiplier · normal.
    fn forces(&self, found: &Search, multipliers: &[Dd]) -> Vec<Dd> {
        let mut forces = vec![Dd::ZERO; self.qty.len()];
        for (one, &multiplier) in found.nearest.active().iter().zip(multipliers) {
            let normal = self.normal(&found.spots[one.tag]);
            forces.iter_mut().zip(normal).for_each(|(f, n)| *f += multiplier * n);
        }
        forces
    }

    /// The active places, those that are one joined.
    fn active(&self, found: &Search, multipliers: &[Dd]) -> Vec<Active> {
        struct Group {
            spot: Spot,
            place: [f64; 2],
            weight: f64,
            heaviest: f64,
        }
        let mut groups: Vec<Group> = Vec::new();
        for (one, multiplier) in found.nearest.active().iter().zip(multipliers) {
            let (spot, weight) = (found.spots[one.tag], multiplier.to_f64());
            let field = &self.fields[spot.field];
            let place = field.place(&spot);
            let ranges = [field.domain.u, field.domain.v];
            let near = |group: &&mut Group| {
                group.spot.field == spot.field
                    && ranges.iter().zip(place).zip(group.place).all(|((range, a), b)| {
                        range.is_none_or(|[low, high]| (a - b).abs() <= ONE_PLACE * (high - low))
                    })
            };
            match groups.iter_mut().find(near) {
                Some(group) => {
                    let total = group.weight + weight;
                    if total > 0.0 {
                        let mean = |k: usize| (group.place[k] * group.weight + place[k] * weight) / total;
                        group.place = [mean(0), mean(1)];
                    }
                    if weight > group.heaviest {
                        (group.spot, group.heaviest) = (spot, weight);
                    }
                    group.weight = total;
                }
                None => groups.push(Group { spot, place, weight, heaviest: weight }),
            }
        }
        let most = groups.iter().map(|group| group.weight).fold(0.0, f64::max);
        groups.retain(|group| group.weight > 1e-10 * most);
        groups.sort_by(|a, b| a.spot.field.cmp(&b.spot.field).then(a.place[0].total_cmp(&b.place[0])));
        let active = |group: Group| Active {
            field: group.spot.field,
            place: group.place,
            multiplier: group.weight,
            normal: self.normal(&group.spot).iter().map(|x| x.to_f64()).collect(),
        };
        groups.into_iter().map(active).collect()
    }
}

fn norm(values: impl Iterator<Item = Dd>) -> f64 {
    values.fold(Dd::ZERO, |sum, x| sum + x * x).sqrt().to_f64()
}
