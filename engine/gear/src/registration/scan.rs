//! The scan over shifts and rotations that a search begins with.

use super::{
    pose::Motion,
    search::{CAP, SHIFTS, Search},
};
use crate::{
    Side,
    deviation::{MeasuredPoint, foot::phase},
};
use flankfit_geometry::space::Vector;
use flankfit_numerics::cancel;

/// Distance of the shifts and of the rotations (as arcs) that are tried, modules.
const SHIFT_STEP: f64 = 0.25;
const TURN_STEP: f64 = 0.1;
/// Places of the search that are refined.
const REFINED: usize = 8;

/// A shift (mm) and a rotation (rad) that were tried.
struct Tried {
    cost: f64,
    shift: [f64; 2],
    turn: f64,
}

impl Search<'_> {
    /// The most promising shifts and rotations, by the teeth that are nearest.
    pub(super) fn scanned(&self) -> Vec<Vec<f64>> {
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
        let sides = |touch: &MeasuredPoint| match touch.side {
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
}
