//! The search for the place where a registration begins: a scan over shifts and rotations, and damped least squares
//! from the best of them.

use std::{
    collections::BTreeMap,
    f64::consts::{PI, TAU},
};

use nalgebra::{DMatrix, DVector};

use super::{
    columns::{Column, Freedom},
    pose::{Motion, Pose, Undoing},
    start::nearest,
};
use crate::{
    estimation::spec::Scaling,
    gear::{
        Gear, Side,
        deviation::{
            Foot, Touch,
            foot::{normal, phase},
        },
    },
    geometry::space::Vector,
    numerics::{cancel, quantiles::median},
};

/// Radius of the disc in which shifts are sought, modules.
pub const SHIFTS: f64 = 2.0;
/// Distance of the shifts and of the rotations (as arcs) that are tried, modules.
const SHIFT_STEP: f64 = 0.25;
const TURN_STEP: f64 = 0.1;
/// Normal distances beyond count like this one, modules.
const CAP: f64 = 0.3;
/// Places of the search that are refined.
const REFINED: usize = 8;
const MOST_STEPS: usize = 25;
/// Least eigenvalue, over the greatest, of a direction that refinement moves along (columns of unit length): what is
/// weaker is the business of the fit and its regularisation.
const LEAST_EIGENVALUE: f64 = 1e-3;

/// A place of the search.
#[derive(Clone, Debug)]
pub(super) struct Place {
    /// Coefficients of the columns.
    pub(super) p: Vec<f64>,
    /// Mean square of capped distances, mm².
    cost: f64,
}

/// A shift (mm) and a rotation (rad) that were tried.
struct Tried {
    cost: f64,
    shift: [f64; 2],
    turn: f64,
}

pub(super) struct Search<'a> {
    pub(super) gear: &'a Gear,
    pub(super) freedom: Freedom,
    pub(super) scaling: Scaling,
    pub(super) pivot: f64,
    pub(super) ball: f64,
    /// Whether flank and tooth of every point are told.
    pub(super) told: bool,
    pub(super) points: Vec<Touch>,
}

impl Search<'_> {
    pub(super) fn pose(&self, p: &[f64]) -> Pose {
        let mut pose = Pose { pivot: self.pivot, ..Pose::default() };
        self.freedom.set(&mut pose, p, self.scaling);
        pose
    }

    pub(super) fn module(&self) -> f64 {
        self.gear.data().normal_module
    }

    /// A point carried back. While teeth are not counted, any tooth will do.
    fn back(&self, undoing: &Undoing, touch: &Touch) -> Touch {
        let tooth = touch.tooth.filter(|_| self.told);
        Touch {
            point: undoing.point(&touch.point),
            normal: touch.normal.map(|normal| undoing.direction(&normal)),
            tooth,
            side: touch.side,
        }
    }

    fn nearest(&self, undoing: &Undoing, touch: &Touch) -> Option<Foot> {
        nearest(self.gear, &self.back(undoing, touch), self.ball)
    }

    /// Coefficients with a shift (mm) and a rotation.
    fn with(&self, [x, y]: [f64; 2], turn: f64) -> Vec<f64> {
        let mut p: Vec<f64> = self
            .freedom
            .columns
            .iter()
            .map(|column| match column {
                Column::Motion(Motion::XShift) => 1e3 * x,
                Column::Motion(Motion::YShift) => 1e3 * y,
                _ => 0.0,
            })
            .collect();
        if let Some((k, unit)) = self.freedom.screw(self.gear) {
            p[k] = unit * turn;
        }
        p
    }

    /// Rotation by the mean of the angles of points whose flank and tooth are told, over the full circle.
    pub(super) fn mean_angle(&self) -> Vec<f64> {
        let [mut x, mut y] = [0.0; 2];
        for touch in &self.points {
            if let Some(side) = touch.side
                && let Some(turn) = phase(self.gear, side, touch.tooth, &touch.point, self.ball)
            {
                (x, y) = (x + turn.cos(), y + turn.sin());
            }
        }
        self.with([0.0; 2], if x == 0.0 && y == 0.0 { 0.0 } else { y.atan2(x) })
    }

    /// The place that fits best, and whether another one with other flanks fits alike.
    pub(super) fn best(&self) -> (Place, bool) {
        let mut found = vec![self.refined(vec![0.0; self.freedom.columns.len()])];
        found.extend(self.scanned().into_iter().map(|p| self.refined(p)));
        let least = found.iter().map(|place| place.cost).fold(f64::INFINITY, f64::min);
        // a µm is no misfit
        let alike = |place: &&Place, times: f64, floor: f64| place.cost <= times * least + floor * floor;
        let size = |place: &&Place| self.motion(&place.p);
        let chosen = found.iter().filter(|place| alike(place, 2.0, 5e-4)).min_by(|a, b| size(a).total_cmp(&size(b)));
        let Some(chosen) = chosen else { return (found[0].clone(), false) };
        let assigned = self.assigned(&chosen.p);
        let other = |place: &&Place| {
            let differ = self.assigned(&place.p).iter().zip(&assigned).filter(|(a, b)| a != b).count();
            differ * 10 > assigned.len()
        };
        (chosen.clone(), found.iter().filter(|place| alike(place, 4.0, 1e-3)).any(|place| other(&place)))
    }

    /// Sides of the points.
    fn assigned(&self, p: &[f64]) -> Vec<Option<Side>> {
        let undoing = self.pose(p).undoing();
        self.points.iter().map(|touch| self.nearest(&undoing, touch).map(|foot| foot.side)).collect()
    }

    /// Root mean square of the way by which points are moved, mm.
    pub(super) fn motion(&self, p: &[f64]) -> f64 {
        let undoing = self.pose(p).undoing();
        let way = |touch: &Touch| (undoing.point(&touch.point) - touch.point).norm_squared();
        (self.points.iter().map(way).sum::<f64>() / self.points.len().max(1) as f64).sqrt()
    }

    /// The most promising shifts and rotations, by the teeth that are nearest.
    fn scanned(&self) -> Vec<Vec<f64>> {
        let (module, gear) = (self.module(), self.gear);
        let free = |motion| self.freedom.motions.contains(&motion);
        let along = |motion| if free(motion) { (SHIFTS / SHIFT_STEP) as i32 } else { 0 };
        let (nx, ny) = (along(Motion::XShift), along(Motion::YShift));
        let arc = gear.base_radius() * gear.base_helix_angle().cos();
        let turns = if self.freedom.screw(gear).is_some() {
            (gear.pitch_angle() * arc / (TURN_STEP * module)).ceil().clamp(8.0, 64.0) as usize
        } else {
            1
        };
        let mut found: Vec<Tried> = Vec::new();
        for i in -nx..=nx {
            cancel::checkpoint();
            for j in -ny..=ny {
                let shift = [i, j].map(|k| SHIFT_STEP * module * f64::from(k));
                if shift[0].hypot(shift[1]) <= SHIFTS * module * (1.0 + 1e-9) {
                    let costs = self.turned(shift, turns, arc);
                    let at = |k: usize| costs[k % turns];
                    // the least of their neighbours
                    let least = (0..turns).filter(|&k| at(k) <= at(k + 1) && at(k) < at(k + turns - 1) || turns == 1);
                    found.extend(least.map(|k| Tried { cost: at(k), shift, turn: self.angle(k, turns) }));
                }
            }
        }
        let size = |tried: &Tried| tried.shift[0].hypot(tried.shift[1]) + arc * tried.turn.abs();
        found.sort_by(|a, b| a.cost.total_cmp(&b.cost).then(size(a).total_cmp(&size(b))));
        let pitch = gear.pitch_angle();
        let beside = |a: &Tried, b: &Tried| {
            let turn = a.turn - b.turn;
            let shift = (a.shift[0] - b.shift[0]).hypot(a.shift[1] - b.shift[1]);
            shift < 1.5 * SHIFT_STEP * module && arc * (turn - pitch * (turn / pitch).round()).abs() < CAP * module
        };
        let mut chosen: Vec<Tried> = Vec::new();
        for tried in found {
            if chosen.len() < REFINED && !chosen.iter().any(|better| beside(better, &tried)) {
                chosen.push(tried);
            }
        }
        chosen.into_iter().map(|tried| self.with(tried.shift, tried.turn)).collect()
    }

    /// The k-th rotation that is tried, within half a pitch.
    fn angle(&self, k: usize, turns: usize) -> f64 {
        self.gear.pitch_angle() * (k as f64 / turns as f64 - if k * 2 > turns { 1.0 } else { 0.0 })
    }

    /// Costs of the rotations over a pitch after a shift.
    fn turned(&self, [x, y]: [f64; 2], turns: usize, arc: f64) -> Vec<f64> {
        let (pitch, cap) = (self.gear.pitch_angle(), CAP * self.module());
        let shift = Vector::new(x, y, 0.0);
        let sides = |touch: &Touch| match touch.side {
            Some(side) => [Some(side), None],
            None => [Some(Side::Left), Some(Side::Right)],
        };
        let phases: Vec<[Option<f64>; 2]> = self
            .points
            .iter()
            .map(|touch| {
                let point = touch.point - shift;
                sides(touch).map(|side| side.and_then(|side| phase(self.gear, side, None, &point, self.ball)))
            })
            .collect();
        let cost = |turn: f64| {
            let near = phases.iter().map(|each| {
                let distance = |phase: &f64| {
                    let apart = phase - turn;
                    arc * (apart - pitch * (apart / pitch).round()).abs()
                };
                each.iter().flatten().map(distance).fold(cap, f64::min).powi(2)
            });
            near.sum::<f64>()
        };
        (0..turns).map(|k| cost(self.angle(k, turns))).collect()
    }

    /// Damped least squares from coefficients, every point at the nearest flank after each step.
    pub(super) fn refined(&self, from: Vec<f64>) -> Place {
        let mut place = Place { cost: self.cost(&from), p: from };
        for _ in 0..MOST_STEPS {
            cancel::checkpoint();
            let Some(step) = self.step(&place.p) else { break };
            let mut factor = 1.0;
            let better = (0..4).find_map(|_| {
                let p: Vec<f64> = place.p.iter().zip(&step).map(|(p, s)| p + factor * s).collect();
                factor *= 0.5;
                let sane = self.pose(&p).is_sane();
                let cost = if sane { self.cost(&p) } else { f64::INFINITY };
                (cost < place.cost).then_some(Place { p, cost })
            });
            let Some(better) = better else { break };
            let done = better.cost > place.cost * (1.0 - 1e-9);
            place = better;
            if done {
                break;
            }
        }
        place
    }

    /// Mean square of distances; those of points without a foot count as the farthest.
    fn cost(&self, p: &[f64]) -> f64 {
        let undoing = self.pose(p).undoing();
        // where the flank is known, the way to it is never too far
        let cap = if self.told { self.gear.base_radius() } else { CAP * self.module() };
        let each = self.points.iter().map(|touch| {
            let distance = self.nearest(&undoing, touch).map_or(cap, |foot| foot.distance.abs().min(cap));
            distance * distance
        });
        each.sum::<f64>() / self.points.len().max(1) as f64
    }

    /// The step of least squares in which far points count less (Huber at twice the scale); `None` where no point tells
    /// one.
    fn step(&self, p: &[f64]) -> Option<Vec<f64>> {
        let (columns, undoing) = (&self.freedom.columns, self.pose(p).undoing());
        let (mut rows, mut distances) = (Vec::new(), Vec::new());
        for touch in &self.points {
            let Some(foot) = self.nearest(&undoing, touch) else { continue };
            let normal = normal(self.gear, foot.tooth, foot.side, foot.roll_length, foot.z);
            let other = undoing.columns(&touch.point, &normal);
            rows.push(columns.iter().map(|c| self.freedom.entry(*c, foot.side, &other)).collect::<Vec<f64>>());
            distances.push(1e3 * foot.distance);
        }
        let scale = 1.4826 * median(&mut distances.iter().map(|d| d.abs()).collect::<Vec<f64>>());
        let n = columns.len();
        let (mut square, mut right) = (DMatrix::<f64>::zeros(n, n), DVector::<f64>::zeros(n));
        for (row, d) in rows.iter().zip(&distances) {
            let weight = if d.abs() > 2.0 * scale { 2.0 * scale / d.abs() } else { 1.0 };
            for i in 0..n {
                right[i] += weight * row[i] * d;
                for j in 0..n {
                    square[(i, j)] += weight * row[i] * row[j];
                }
            }
        }
        let lengths: Vec<f64> = (0..n).map(|i| square[(i, i)].sqrt()).collect();
        if !lengths.iter().all(|length| *length > 0.0 && length.is_finite()) {
            return None;
        }
        for i in 0..n {
            right[i] /= lengths[i];
            for j in 0..n {
                square[(i, j)] /= lengths[i] * lengths[j];
            }
        }
        let eigen = square.symmetric_eigen();
        let most = eigen.eigenvalues.max();
        let mut step = vec![0.0; n];
        for (k, value) in eigen.eigenvalues.iter().enumerate().filter(|(_, value)| **value > LEAST_EIGENVALUE * most) {
            let along = eigen.eigenvectors.column(k).dot(&right) / value;
            for i in 0..n {
                step[i] += along * eigen.eigenvectors[(i, k)] / lengths[i];
            }
        }
        Some(step)
    }

    /// Turned by the whole pitches that points of told teeth ask for, else by those that bring it nearest to 0; with
    /// the share of told points that agree.
    pub(super) fn counted(&self, mut p: Vec<f64>) -> (Vec<f64>, Option<f64>) {
        let Some((k, unit)) = self.freedom.screw(self.gear) else { return (p, None) };
        let teeth = self.gear.data().teeth;
        let undoing = self.pose(&p).undoing();
        let mut votes = BTreeMap::new();
        for touch in self.points.iter().filter(|touch| touch.tooth.is_some_and(|tooth| (1..=teeth).contains(&tooth))) {
            let back = Touch { tooth: None, ..self.back(&undoing, touch) };
            if let (Some(foot), Some(told)) = (nearest(self.gear, &back, self.ball), touch.tooth) {
                *votes.entry((told + teeth - foot.tooth) % teeth).or_insert(0usize) += 1;
            }
        }
        let total: usize = votes.values().sum();
        let most = votes.into_iter().max_by_key(|(_, count)| *count);
        let (period, turn) = (self.gear.pitch_angle(), p[k] / unit);
        let within = |turn: f64| turn - TAU * ((turn - PI) / TAU).ceil();
        let (turn, agreed) = match most {
            Some(_) if self.told => (within(turn), Some(1.0)),
            Some((pitches, count)) => (within(turn + f64::from(pitches) * period), Some(count as f64 / total as f64)),
            None => (turn - period * (turn / period).round(), None),
        };
        p[k] = unit * turn;
        (p, agreed)
    }
}
