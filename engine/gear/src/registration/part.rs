//! The measured part of a registration: its points, the flanks that they belong to, and its rows at
//! a pose.

use super::{
    Registering,
    columns::{Column, Freedom},
    nearest::nearest,
    pose::Pose,
    start::Start,
};
use crate::{
    Side,
    deviation::{
        Deviations, Direction, MeasuredPoint, NoFoot, Node, Reference,
        foot::{foot, normal, word},
    },
};
use flankfit_estimation::{FitError, Nodes};
use flankfit_geometry::space::Vector;
use flankfit_numerics::{
    cancel::Asking,
    check::{Faults, negative, not_finite},
    words::counted,
};

/// Way to either side over which the slope of a relief is taken, mm.
const SLOPE_STEP: f64 = 1e-2;

/// The measured part.
pub(super) struct Part<'a> {
    pub(super) reference: &'a Reference<'a>,
    pub(super) deviations: &'a Deviations,
    pub(super) freedom: Freedom,
    pub(super) start: Option<&'a Start>,
    /// Nodes that take part, and where they were measured.
    pub(super) rows: Vec<(usize, Vector)>,
    /// Tooth and flank of every row.
    pub(super) flank: Vec<(u32, Side)>,
    pub(super) weight: Option<Vec<f64>>,
}

/// Rows of X and normal deviations (µm) at a pose.
pub(super) struct State {
    pub(super) x: Vec<f64>,
    pub(super) d: Vec<f64>,
}

impl<'a> Part<'a> {
    pub(super) fn new(
        reference: &'a Reference<'a>,
        deviations: &'a Deviations,
        asked: &Registering,
        freedom: Freedom,
        start: Option<&'a Start>,
    ) -> Result<Self, Faults> {
        let nodes = &deviations.nodes;
        if let Some(weight) = asked.weight.filter(|weight| weight.len() != nodes.len()) {
            let (given, points) = (weight.len(), nodes.len());
            return Err(Faults::one("weight", format_args!("{given}, but {points} would match the points")));
        }
        let mut faults = Faults::default();
        let mut rows = Vec::with_capacity(nodes.len());
        let mut weights = asked.weight.map(|_| Vec::with_capacity(nodes.len()));
        for (i, _) in nodes.iter().enumerate().filter(|(_, node)| node.counts()).asking(500) {
            let weight = asked.weight.map_or(1.0, |weight| weight[i]);
            if !(weight >= 0.0 && weight.is_finite()) {
                faults.push(format_args!("weight[{i}]"), negative(weight));
            }
            if weight > 0.0
                && let Some(point) = deviations.point(reference, i)
            {
                if point.iter().all(|x| x.is_finite()) {
                    rows.push((i, start.map_or(point, |start| start.pose.apply(&point))));
                    weights.iter_mut().for_each(|weights| weights.push(weight));
                } else {
                    faults.push(format_args!("points[{i}]"), "the modification has no value here");
                }
            }
        }
        if faults.is_empty() && rows.len() < freedom.columns.len() {
            let points = counted(rows.len(), "measured point takes", "measured points take");
            let motions = counted(freedom.columns.len(), "motion", "motions");
            faults.push("points", format_args!("{points} part, too few for {motions}"));
        }
        faults.into_result(())?;
        let flank = rows.iter().map(|(i, _)| (nodes[*i].tooth, nodes[*i].side)).collect();
        Ok(Part { reference, deviations, freedom, start, rows, flank, weight: weights })
    }

    /// z of the pivot, mm.
    pub(super) fn pivot(&self, asked: &Registering) -> Result<f64, Faults> {
        match asked.pivot {
            Some(z) if z.is_finite() => Ok(z),
            Some(_) => Err(Faults::one("registration.pivot_z_mm", not_finite())),
            None => {
                let z = self.rows.iter().map(|(i, _)| self.deviations.nodes[*i].z);
                let [low, high] = z.fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], z| [a.min(z), b.max(z)]);
                Ok(0.5 * (low + high))
            }
        }
    }

    /// A point carried back: its node, with the deviation along the normal.
    pub(super) fn carried(&self, (tooth, side): (u32, Side), point: &Vector) -> Result<Node, NoFoot> {
        let gear = self.reference.gear;
        let foot = foot(gear, side, Some(tooth), point, self.deviations.ball_radius)?;
        self.reference.node(&foot, Direction::Normal)
    }

    /// The flank of node `i` that is nearest to the point carried back, where it is not given;
    /// `None` where it is, or where there is none.
    pub(super) fn nearest(&self, i: usize, back: &Vector) -> Option<(u32, Side)> {
        let touch = self.start?.touches.get(i)?;
        // normals were given to distinguish sides, and have done so
        let side = touch.side.or_else(|| touch.normal.map(|_| self.deviations.nodes[i].side));
        if side.is_some() && touch.tooth.is_some() {
            return None;
        }
        let open = MeasuredPoint { point: *back, tooth: touch.tooth, side, normal: None };
        nearest(self.reference.gear, &open, self.deviations.ball_radius).map(|foot| (foot.tooth, foot.side))
    }

    /// Sends every row to the nearest flank that it may belong to; how many went to another one.
    pub(super) fn reassign(&mut self, pose: &Pose) -> usize {
        let undoing = pose.undoing();
        let mut changed = 0;
        for (k, (i, point)) in self.rows.iter().enumerate().asking(1000) {
            if let Some(flank) = self.nearest(*i, &undoing.point(point)).filter(|flank| *flank != self.flank[k]) {
                self.flank[k] = flank;
                changed += 1;
            }
        }
        changed
    }

    pub(super) fn at(&self, pose: &Pose) -> Result<State, Faults> {
        self.with_columns(pose, &self.freedom.columns)
    }

    pub(super) fn with_columns(&self, pose: &Pose, columns: &[Column]) -> Result<State, Faults> {
        let undoing = pose.undoing();
        let slides = columns.contains(&Column::Slide);
        let mut faults = Faults::default();
        let mut state =
            State { x: Vec::with_capacity(self.rows.len() * columns.len()), d: Vec::with_capacity(self.rows.len()) };
        for ((i, point), flank) in self.rows.iter().zip(&self.flank).asking(500) {
            match self.carried(*flank, &undoing.point(point)) {
                Ok(carried) => {
                    let normal =
                        normal(self.reference.gear, carried.tooth, carried.side, carried.roll_length, carried.z);
                    let other = undoing.columns(point, &normal);
                    let slope = if slides { self.relief_slope(&carried) } else { 0.0 };
                    state.x.extend(columns.iter().map(|c| self.freedom.entry(*c, carried.side, &other, slope)));
                    state.d.push(carried.deviation);
                }
                Err(stray) => {
                    let (tooth, side) = (flank.0, word(flank.1));
                    faults.push(
                        format_args!("points[{i}]"),
                        format_args!("moved back to the {side} flank of tooth {tooth} it has no deviation: {stray}"),
                    );
                }
            }
        }
        faults.into_result(state)
    }

    /// How much the relief changes along z, µm per µm; 0 where the modification ends.
    fn relief_slope(&self, at: &Node) -> f64 {
        let beside = |step: f64| self.reference.relief(at.side, at.roll_length, at.z + step);
        let slope = 1e-3 * (beside(SLOPE_STEP) - beside(-SLOPE_STEP)) / (2.0 * SLOPE_STEP);
        if slope.is_finite() { slope } else { 0.0 }
    }

    pub(super) fn nodes(&self, x: Vec<f64>, heights: Vec<f64>, columns: &[Column]) -> Result<Nodes, FitError> {
        let names = columns.iter().map(|column| column.name().to_owned()).collect();
        let nodes = Nodes::matrix(x, columns.len(), heights, Some(names), self.weight.clone());
        Ok(nodes.map_err(|faults| faults.within("nodes"))?)
    }
}
