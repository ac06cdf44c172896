//! Evaluation of given teeth: the angle on which most agree, and those that contradict.

use std::{
    collections::BTreeMap,
    f64::consts::{PI, TAU},
};

use super::{
    columns::Column,
    nearest::nearest,
    pose::{InversePose, Motion},
    search::{Candidate, Search},
};
use crate::deviation::{MeasuredPoint, foot::phase};

/// Root mean square of capped distances below which points lie on the flanks of a place, whatever
/// their teeth are called, modules.
const ON_FLANKS: f64 = 0.15;

/// Given teeth at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Agreement {
    /// Whole pitches by which most given teeth ask to be turned on.
    pub(super) pitches: u32,
    /// Share of the points whose given teeth ask for it.
    pub(super) share: f64,
    /// Whether the points lie on flanks there, and on no others as well.
    pub(super) is_sure: bool,
}

impl Agreement {
    /// Teeth that are taken as given.
    pub(super) const ASSUMED: Agreement = Agreement { pitches: 0, share: 1.0, is_sure: false };

    /// Whether every tooth is where it is said to be.
    pub(super) fn is_whole(&self) -> bool {
        self.pitches == 0 && self.share == 1.0
    }

    /// By how many pitches the points lie from the teeth that they are said to be of, the short way
    /// round.
    pub(super) fn turned_on(&self, teeth: u32) -> u32 {
        if 2 * self.pitches > teeth { teeth - self.pitches } else { self.pitches }
    }
}

impl Search<'_> {
    /// Rotation with the least sum of distances from the angles of points whose flank and tooth are
    /// given, over the full circle: a minority of wrong teeth does not move it, as it moves a mean.
    pub(super) fn usual_angle(&self) -> Vec<f64> {
        let sided = self.points.iter().filter_map(|touch| Some((touch, touch.side?)));
        let angle = |(touch, side): (&MeasuredPoint, _)| phase(self.gear, side, touch.tooth, &touch.point, self.ball);
        let angles: Vec<f64> = sided.filter_map(angle).collect();
        let apart = |a: f64, b: f64| (a - b - TAU * ((a - b) / TAU).round()).abs();
        let sum = |turn: f64| angles.iter().map(|angle| apart(*angle, turn)).sum::<f64>();
        let sums = angles.iter().map(|turn| (sum(*turn), *turn));
        let least = sums.min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.abs().total_cmp(&b.1.abs())));
        self.with([0.0; 2], least.map_or(0.0, |(_, turn)| turn))
    }

    /// Agreement with the given teeth at a place; `None` where none is given.
    pub(super) fn agreement(&self, p: &[f64]) -> Option<Agreement> {
        let undoing = self.pose(p).undoing();
        let teeth = self.gear.data().teeth;
        let mut votes = BTreeMap::new();
        for touch in &self.points {
            if let Some(pitches) = self.pitches_off(&undoing, touch) {
                *votes.entry(pitches % teeth).or_insert(0usize) += 1;
            }
        }
        let total: usize = votes.values().sum();
        // a tie is for no turn
        let (pitches, count) = votes.into_iter().max_by_key(|(pitches, count)| (*count, *pitches == 0))?;
        Some(Agreement { pitches, share: count as f64 / total as f64, is_sure: false })
    }

    /// By how many pitches a given tooth lies on from the nearest one.
    pub(super) fn pitches_off(&self, undoing: &InversePose, touch: &MeasuredPoint) -> Option<u32> {
        let teeth = self.gear.data().teeth;
        let named = touch.tooth.filter(|tooth| (1..=teeth).contains(tooth))?;
        let back = MeasuredPoint { tooth: None, ..self.carried(undoing, touch) };
        nearest(self.gear, &back, self.ball).map(|foot| (named + teeth - foot.tooth) % teeth)
    }

    /// Whether the points lie on flanks there, whatever their teeth are called.
    pub(super) fn lies_on_flanks(&self, place: &Candidate) -> bool {
        place.cost < (ON_FLANKS * self.module()).powi(2)
    }

    /// Turned by whole pitches: by those that `agreement` asks for, else by those that bring it
    /// nearest to 0. Where no rotation is free, none is made up for.
    pub(super) fn counted(&self, mut p: Vec<f64>, agreement: Option<Agreement>) -> Vec<f64> {
        let Some((k, unit)) = self.freedom.screw(self.gear) else { return p };
        let (period, turn) = (self.gear.pitch_angle(), p[k] / unit);
        let within = |turn: f64| turn - TAU * ((turn - PI) / TAU).ceil();
        let turn = match agreement {
            // an axial shift by whole pitches would be one by centimetres
            Some(_) if !self.may_turn() => turn,
            Some(agreement) => within(turn + f64::from(agreement.pitches) * period),
            None => turn - period * (turn / period).round(),
        };
        p[k] = unit * turn;
        p
    }

    /// Whether the part may be turned to where its given teeth say.
    pub(super) fn may_turn(&self) -> bool {
        let turns = |column: &Column| matches!(column, Column::Screw | Column::Motion(Motion::Rotation));
        self.freedom.columns.iter().any(turns)
    }
}
