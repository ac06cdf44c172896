//! Result of a registration: motions with their errors, indistinguishable motions, the part carried
//! back, warnings.

use super::{
    Indistinguishable, Moved, Registering, Registration,
    columns::{Column, SCREW},
    misfit,
    part::{Part, State},
    pose::{Motion, Pose},
    solve::Iterated,
};
use crate::{
    deviation::{Deviations, Node},
    warning::Warning,
};
use flankfit_estimation::{
    FitError, FitResult, FitSpec, fit,
    spec::{Estimator, Include, Regularization},
};
use flankfit_numerics::{cancel::Asking, dot};

/// The motion that a column is, or mostly is.
fn motion_of(term: &str) -> Option<Motion> {
    if term == SCREW { Some(Motion::Rotation) } else { Motion::named(term) }
}

impl Part<'_> {
    pub(super) fn answer(
        &self,
        Iterated { pose, begun, iterations, converged }: Iterated,
        last: FitResult,
        asked: &Registering,
    ) -> Result<Registration, FitError> {
        let mut warnings = Vec::new();
        if !converged {
            warnings.push(Warning::RegistrationNotConverged { iterations });
        }
        let every_motion = if self.freedom.is_whole() { None } else { Some(self.every_motion(&pose, asked.spec)?) };
        let dependencies = &every_motion.as_ref().unwrap_or(&last).collinearity.near_dependencies;
        let indistinguishable = dependencies
            .iter()
            .map(|near| Indistinguishable {
                motions: near.terms.iter().filter_map(|term| motion_of(term)).collect(),
                condition_index: near.condition_index,
                sentence: near.sentence.clone(),
            })
            .collect();
        if !self.freedom.is_whole() {
            warnings.push(self.undetermined());
        }
        if self.freedom.columns.contains(&Column::Slide) {
            warnings.push(Warning::AxialShiftByModification { shift_um: pose.get(Motion::AxialShift) });
        }
        let dependent = Self::dependent(&last);
        if !dependent.is_empty() {
            warnings.push(Warning::MotionsIndistinguishable { motions: dependent });
        }
        let deviations = self.carried_back(&pose, &mut warnings);
        if let Some(start) = self.start {
            warnings.extend(misfit::of_start(self.reference.gear, start, &deviations));
        }
        warnings.extend(misfit::of_axial_shift(self.reference.gear, &self.freedom, &pose));
        let rows: Vec<usize> = self.rows.iter().map(|(i, _)| *i).collect();
        warnings.extend(misfit::of_part(self.reference.gear, &deviations, &rows));
        Ok(Registration {
            motions: self.moved(&pose, &last, &begun),
            pivot_z_mm: pose.pivot,
            pose,
            rms_before_um: self.rms_before(&deviations),
            rms_after_um: deviations.rms().unwrap_or_default(),
            iterations,
            converged,
            indistinguishable,
            fit: last,
            every_motion,
            rows,
            deviations,
            warnings,
        })
    }

    /// Returns the root mean square of the points before the motion, against the flanks they belong
    /// to.
    fn rms_before(&self, after: &Deviations) -> f64 {
        let Some(start) = self.start else {
            // at least one node takes part
            return self.deviations.rms().unwrap_or_default();
        };
        let scale = self.deviations.direction.from_normal(self.reference.gear);
        let (mut count, mut sum) = (0.0, 0.0);
        for (i, node) in after.nodes.iter().enumerate().filter(|(_, node)| node.counts()).asking(1000) {
            if let Some(point) = self.deviations.point(self.reference, i)
                && let Ok(before) = self.carried((node.tooth, node.side), &start.pose.apply(&point))
            {
                (count, sum) = (count + 1.0, sum + (scale * before.deviation).powi(2));
            }
        }
        if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
    }

    /// Least squares with a column for every motion.
    fn every_motion(&self, pose: &Pose, spec: &FitSpec) -> Result<FitResult, FitError> {
        let columns: Vec<Column> = self.freedom.motions.iter().map(|motion| Column::Motion(*motion)).collect();
        let State { x, d } = self.with_columns(pose, &columns)?;
        let values: Vec<f64> = self.freedom.motions.iter().map(|motion| pose.get(*motion)).collect();
        let heights = d.iter().zip(x.chunks_exact(columns.len())).map(|(d, x)| d + dot(x, &values)).collect();
        let plain = FitSpec {
            regularization: Regularization::None,
            estimator: Estimator::LeastSquares,
            include: Include::default(),
            ..spec.clone()
        };
        fit(&self.nodes(x, heights, &columns)?, &plain)
    }

    fn undetermined(&self) -> Warning {
        match self.freedom.columns.contains(&Column::Screw) {
            true => Warning::ScrewUndetermined,
            false => Warning::AxialShiftUndetermined,
        }
    }

    /// The motions that these points do not tell from others, though points elsewhere could.
    fn dependent(last: &FitResult) -> Vec<Motion> {
        let exact = last.collinearity.near_dependencies.iter().filter(|near| near.condition_index.is_none());
        let terms = exact.flat_map(|near| &near.terms);
        terms.filter_map(|term| motion_of(term)).collect()
    }

    fn moved(&self, pose: &Pose, last: &FitResult, begun: &[f64]) -> Vec<Moved> {
        let mut start = Pose::default();
        self.freedom.set(&mut start, begun);
        let dependent = Self::dependent(last);
        // coefficient and share of every column that moves it; errors of two columns add up at most
        let of = |motion: Motion| {
            let each = self.freedom.columns.iter().zip(&last.coefficients);
            each.flat_map(|(column, c)| self.freedom.shares(*column).into_iter().map(move |share| (c, share)))
                .filter(|(_, (moved, _))| *moved == motion)
                .map(|(c, (_, share))| (c, share.abs()))
                .collect::<Vec<_>>()
        };
        self.freedom
            .motions
            .iter()
            .map(|&motion| {
                let determined = self.freedom.determines(motion) && !dependent.contains(&motion);
                // what is shared between motions says nothing of one of them
                let terms = if determined { of(motion) } else { Vec::new() };
                let has = !terms.is_empty();
                Moved {
                    motion,
                    value: pose.get(motion),
                    // −0 is 0
                    start: start.get(motion) + 0.0,
                    unit: if motion.is_angle() { "urad" } else { "um" },
                    std_error: terms
                        .iter()
                        .map(|(c, share)| Some(c.std_error? * share))
                        .sum::<Option<f64>>()
                        .filter(|_| has),
                    bias_bound: has.then(|| terms.iter().map(|(c, share)| c.bias_bound * share).sum()),
                    determined,
                }
            })
            .collect()
    }

    /// Every defined node carried back, in the direction of the deviations given.
    fn carried_back(&self, pose: &Pose, warnings: &mut Vec<Warning>) -> Deviations {
        let undoing = pose.undoing();
        let mut back = self.deviations.clone();
        let scale = back.direction.from_normal(self.reference.gear);
        let mut lost = Vec::new();
        for (i, node) in back.nodes.iter_mut().enumerate().asking(1000) {
            let Some(point) = self.deviations.point(self.reference, i) else { continue };
            let point = undoing.point(&self.start.map_or(point, |start| start.pose.apply(&point)));
            let flank = self.nearest(i, &point).unwrap_or((node.tooth, node.side));
            match self.carried(flank, &point) {
                Ok(carried) => *node = Node { deviation: carried.deviation * scale, within: node.within, ..carried },
                Err(stray) => {
                    *node = Node { roll_length: f64::NAN, z: f64::NAN, deviation: f64::NAN, ..*node };
                    lost.push((i, stray));
                }
            }
        }
        if let Some(&(first, reason)) = lost.first() {
            warnings.push(Warning::NodesLost { count: lost.len(), first, reason });
        }
        back.strays.extend(lost);
        back
    }
}
