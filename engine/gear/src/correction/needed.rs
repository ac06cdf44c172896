//! Which settings need not be changed.
//!
//! The full correction is plain least squares of all settings that may be changed. From there
//! settings are left alone one after the other, the cheapest first: the one whose removal adds
//! least to the weighted sum of squares. A setting may be left alone while every figure that the
//! full correction brings or leaves within its limits stays there, with the guard band of a
//! decision on conformity, and where
//!
//! * its removal adds less than 9σ² to the sum of squares of the step before: the change is *not
//!   distinguishable* from none (three standard errors of the setting given the others; of means
//!   over teeth the standard error by their scatter, where that is greater), or
//! * every figure that it moves stays, with its guard band, within the middle share of its limits:
//!   there is nothing to correct.
//!
//! A figure without limits needs no correction where it is not distinguishable from its target (so
//! is one that the target leaves as measured); the level of a flank has no error that is known, and
//! must be at its target. Settings
//! whose limits do not let them stay as they are are not left alone. The limits of the others are
//! not looked at here; what remains is solved again as it was asked for.

use nalgebra::{DMatrix, DVector};

use super::{
    figures::{HeldFigure, moved_by},
    problem::Correction,
};
use flankfit_numerics::{
    cancel::{self, Asking},
    qr_with_rhs, svd,
};

/// The share of their limits, about the middle, within which figures need no correction.
pub const DEFAULT_KEEP_WITHIN: f64 = 0.7;

/// Reason for not changing a setting.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Unchanged {
    /// Its change is not distinguishable from none: less than three standard errors.
    NotDistinguishable,
    /// Every figure that it moves lies well within its limits, with a guard band.
    WithinLimits,
}

/// Standard errors that a change is distinguishable from.
const DISTINGUISHABLE: f64 = 3.0;
/// Singular values below this share of the greatest are of directions that the nodes do not tell.
const RANK: f64 = 1e-10;

/// Why each setting is left alone; `None` of those that are needed, or not open to change. `held`
/// has the changes of settings that are not open, σ is that of weight 1. `None` where singular
/// values do not converge.
pub(super) fn left_alone(
    correction: &Correction,
    held: &[f64],
    sigma: Option<f64>,
    keep_within: f64,
) -> Option<Vec<Option<Unchanged>>> {
    let asked = correction.spec();
    let reduced = Reduced::of(correction, held, sigma);
    let mut kept: Vec<usize> = (0..correction.open.len()).collect();
    let mut left = vec![None; asked.settings.len()];
    let mut step = reduced.solve(&kept)?;
    let stays =
        |figure: &&HeldFigure| figure.limits.is_some_and(|limits| figure.conforms(figure.after(&step.change), limits));
    let staying: Vec<&HeldFigure> = asked.figures.iter().filter(stays).collect();
    let least = sigma.map_or(0.0, |sigma| (DISTINGUISHABLE * sigma).powi(2));
    'steps: loop {
        let mut order: Vec<usize> = (0..kept.len()).collect();
        order.sort_by(|&a, &b| step.cost[a].total_cmp(&step.cost[b]));
        for place in order {
            cancel::checkpoint();
            let setting = correction.open[kept[place]];
            let limits = &asked.settings[setting];
            if limits.min.is_some_and(|min| min > 0.0) || limits.max.is_some_and(|max| max < 0.0) {
                continue;
            }
            let mut without = kept.clone();
            without.remove(place);
            let next = reduced.solve(&without)?;
            let conforms = |figure: &HeldFigure, share: f64| {
                let after = figure.after(&next.change);
                match figure.limits {
                    Some([low, high]) => {
                        let (middle, half) = (0.5 * (low + high), 0.5 * share * (high - low));
                        figure.conforms(after, [middle - half, middle + half])
                    }
                    None => {
                        let error = figure.measured.std_error.unwrap_or(0.0);
                        (after - figure.target).abs() <= DISTINGUISHABLE * error
                    }
                }
            };
            if !staying.iter().all(|figure| conforms(figure, 1.0)) {
                continue;
            }
            let mut moved = moved_by(&asked.figures, setting).peekable();
            let why = match () {
                () if step.cost[place] < least => Unchanged::NotDistinguishable,
                () if moved.peek().is_some() && moved.all(|figure| conforms(figure, keep_within)) => {
                    Unchanged::WithinLimits
                }
                () => continue,
            };
            left[setting] = Some(why);
            (kept, step) = (without, next);
            continue 'steps;
        }
        return Some(left);
    }
}

/// The rows of the open settings, whitened and reduced to a triangle, columns of length 1.
struct Reduced<'a> {
    correction: &'a Correction,
    held: &'a [f64],
    scale: Vec<f64>,
    r: DMatrix<f64>,
    qty: DVector<f64>,
    /// Scatter of teeth there, σ = 1.
    scatter: Vec<DVector<f64>>,
}

/// Least squares of some of the settings.
struct Step {
    /// Changes of all settings.
    change: Vec<f64>,
    /// Increase of the sum of squares when each of them is left alone.
    cost: Vec<f64>,
}

impl<'a> Reduced<'a> {
    fn of(correction: &'a Correction, held: &'a [f64], sigma: Option<f64>) -> Self {
        let (rows, n) = (correction.counted().len(), correction.open.len());
        let (mut columns, mut heights) = (DMatrix::zeros(rows, n), DVector::zeros(rows));
        for (i, &k) in correction.counted().iter().enumerate().asking(n) {
            let (root, row) = (correction.weight(k).sqrt(), correction.row(k));
            for (j, &setting) in correction.open.iter().enumerate() {
                columns[(i, j)] = root * row[setting];
            }
            heights[i] = -root * correction.left_at(k, held);
        }
        let scale: Vec<f64> = columns.column_iter().map(|column| column.norm()).collect();
        for (mut column, scale) in columns.column_iter_mut().zip(&scale) {
            column /= *scale;
        }
        let whitened = |column: &Vec<f64>| {
            let sigma = sigma.filter(|sigma| *sigma > 0.0)?;
            let node = |&k: &usize| correction.weight(k).sqrt() * column[k] / sigma;
            Some(DVector::from_iterator(rows, correction.counted().iter().map(node)))
        };
        let scatter = correction.spec().scatter.columns.iter().filter_map(whitened);
        let scatter = scatter.map(|column| qr_with_rhs(columns.clone(), column).qty).collect();
        let found = qr_with_rhs(columns, heights);
        Reduced { correction, held, scale, r: found.r, qty: found.qty, scatter }
    }

    /// The changes of least norm where the nodes do not tell all of the settings `kept`; `None`
    /// where singular values do not converge.
    fn solve(&self, kept: &[usize]) -> Option<Step> {
        let (n, mut change) = (kept.len(), self.held.to_vec());
        if n == 0 {
            return Some(Step { change, cost: Vec::new() });
        }
        let found = qr_with_rhs(self.r.select_columns(kept), self.qty.clone());
        let parts = svd(found.r)?;
        let least = RANK * parts.sigma.last()?;
        let (determined, lost): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| parts.sigma[i] > least);
        let along = |qty: &DVector<f64>| -> Vec<f64> {
            determined.iter().map(|&i| parts.us.column(i).dot(qty) / (parts.sigma[i] * parts.sigma[i])).collect()
        };
        let of_scatter: Vec<Vec<f64>> = self
            .scatter
            .iter()
            .map(|column| along(&qr_with_rhs(self.r.select_columns(kept), column.clone()).qty))
            .collect();
        let along = along(&found.qty);
        let mut cost = Vec::with_capacity(n);
        for (j, &place) in kept.iter().enumerate() {
            let entry = |along: &[f64]| determined.iter().zip(along).map(|(&i, a)| parts.v[(j, i)] * a).sum::<f64>();
            let x = entry(&along);
            let noise: f64 = determined.iter().map(|&i| (parts.v[(j, i)] / parts.sigma[i]).powi(2)).sum();
            let variance = noise.max(of_scatter.iter().map(|along| entry(along).powi(2)).sum());
            // what others do as well costs nothing
            let replaced = lost.iter().any(|&i| parts.v[(j, i)].abs() > RANK.sqrt());
            cost.push(if replaced { 0.0 } else { x * x / variance });
            change[self.correction.open[place]] = x / self.scale[place];
        }
        Some(Step { change, cost })
    }
}
