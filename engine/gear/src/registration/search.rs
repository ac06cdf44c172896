//! The search for the place where a registration begins: a scan over shifts and rotations
//! ([`super::scan`]), and damped least squares from the best of them ([`super::refine`]).

use super::{
    columns::{Column, Freedom},
    nearest::nearest,
    pose::{InversePose, Motion, Pose},
};
use crate::{
    Gear, Side,
    deviation::{Foot, MeasuredPoint},
};

/// Radius of the disc in which shifts are sought, modules.
pub(crate) const SHIFTS: f64 = 2.0;
/// Greater normal distances count like this one, modules.
pub(super) const CAP: f64 = 0.3;

/// A place of the search.
#[derive(Clone, Debug)]
pub(super) struct Candidate {
    /// Coefficients of the columns.
    pub(super) p: Vec<f64>,
    /// Mean square of capped distances, mm².
    pub(super) cost: f64,
}

pub(super) struct Search<'a> {
    pub(super) gear: &'a Gear,
    pub(super) freedom: Freedom,
    pub(super) pivot: f64,
    pub(super) ball: f64,
    /// Whether points stay on the teeth that they are said to be of: flank and tooth of every one
    /// are given.
    pub(super) named: bool,
    pub(super) points: Vec<MeasuredPoint>,
}

impl Search<'_> {
    pub(super) fn pose(&self, p: &[f64]) -> Pose {
        let mut pose = Pose { pivot: self.pivot, ..Pose::default() };
        self.freedom.set(&mut pose, p);
        pose
    }

    /// The same points, none of which stays on its tooth.
    pub(super) fn open(&self) -> Search<'_> {
        Search { named: false, freedom: self.freedom.clone(), points: self.points.clone(), ..*self }
    }

    pub(super) fn module(&self) -> f64 {
        self.gear.data().normal_module
    }

    /// A point carried back.
    pub(super) fn carried(&self, undoing: &InversePose, touch: &MeasuredPoint) -> MeasuredPoint {
        MeasuredPoint {
            point: undoing.point(&touch.point),
            normal: touch.normal.map(|normal| undoing.direction(&normal)),
            ..*touch
        }
    }

    /// Its nearest foot. While teeth are not counted, any tooth will do.
    pub(super) fn nearest(&self, undoing: &InversePose, touch: &MeasuredPoint) -> Option<Foot> {
        let back = self.carried(undoing, touch);
        nearest(self.gear, &MeasuredPoint { tooth: touch.tooth.filter(|_| self.named), ..back }, self.ball)
    }

    /// Coefficients with a shift (mm) and a rotation.
    pub(super) fn with(&self, [x, y]: [f64; 2], turn: f64) -> Vec<f64> {
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

    /// The place that fits best, and whether another one with other flanks fits alike.
    pub(super) fn best(&self) -> (Candidate, bool) {
        let mut found = vec![self.refined(vec![0.0; self.freedom.columns.len()])];
        found.extend(self.scanned().into_iter().map(|p| self.refined(p)));
        let least = found.iter().map(|place| place.cost).fold(f64::INFINITY, f64::min);
        // a µm is no misfit
        let alike = |place: &&Candidate, times: f64, floor: f64| place.cost <= times * least + floor * floor;
        let size = |place: &&Candidate| self.motion(&place.p);
        let chosen = found.iter().filter(|place| alike(place, 2.0, 5e-4)).min_by(|a, b| size(a).total_cmp(&size(b)));
        let Some(chosen) = chosen else { return (found[0].clone(), false) };
        let assigned = self.assigned(&chosen.p);
        let other = |place: &&Candidate| {
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
        let way = |touch: &MeasuredPoint| (undoing.point(&touch.point) - touch.point).norm_squared();
        (self.points.iter().map(way).sum::<f64>() / self.points.len().max(1) as f64).sqrt()
    }
}
