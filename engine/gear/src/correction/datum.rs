//! Deviations without a datum: of all nodes, or of each trace, nobody knows what they have in
//! common.
//!
//! Columns and deviations are centred over the nodes that share a zero (Frisch, Waugh and Lovell):
//! the same changes and standard errors as with a constant of its own for each zero, and as many
//! degrees of freedom fewer.

use std::collections::BTreeMap;

use super::problem::{Correction, lost};
use flankfit_numerics::check::Faults;

/// A column of which less than this is left when its mean is taken off moves the flank as a whole,
/// by what nobody measures: using the rest of it would shift the flank by a multiple of what it
/// mends. With traces it must be left of one of them at least.
const CONSTANT: f64 = 0.3;
/// Share of a column's greatest effect on a trace below which it has none on another.
const NOTHING: f64 = 1e-3;

impl Correction {
    /// The same for deviations of which nobody knows what they (or those of a trace) have in
    /// common.
    pub(super) fn without_datum(self) -> Result<Self, Faults> {
        let columns = self.asked.settings.len();
        let groups = Groups::of(&self);
        let means: Vec<Vec<f64>> = (0..columns).map(|j| groups.means(&self, |k| self.row(k)[j])).collect();
        let levels = groups.means(&self, |k| self.asked.deviation[k] - self.target(k));
        let rows = self.asked.sensitivity.chunks_exact(columns).zip(&groups.of_node);
        let about = |(row, &group): (&[f64], &usize)| -> Vec<f64> {
            // nodes of a trace that takes no part move by what is known of them
            let mean = |j: usize| Some(means[j][group]).filter(|mean| !mean.is_nan()).unwrap_or(0.0);
            row.iter().enumerate().map(|(j, x)| x - mean(j)).collect()
        };
        let centred: Vec<f64> = rows.flat_map(about).collect();
        let constant = |j: &usize| {
            let left = groups.sums(&self, |k| centred[k * columns + j].powi(2));
            let whole = groups.sums(&self, |k| self.given_row(k)[*j].powi(2));
            let greatest = whole.iter().fold(0.0f64, |most, square| most.max(*square));
            let of_trace = |(left, whole): (&f64, &f64)| {
                *whole > NOTHING * NOTHING * greatest && *left > CONSTANT * CONSTANT * whole
            };
            !left.iter().zip(&whole).any(of_trace)
        };
        let (alike, open): (Vec<usize>, Vec<usize>) = self.open.iter().copied().partition(|j| constant(j));
        if open.is_empty() {
            let nodes = if self.asked.traces.is_some() { "all nodes of a trace" } else { "all nodes" };
            return Err(Faults::one(
                "absolute",
                format_args!(
                    "the deviations have no datum, and every setting changes {nodes} nearly equally: nothing can be \
                     determined"
                ),
            ));
        }
        let levels = Some(groups.of_node.iter().map(|&group| levels[group]).collect());
        let mut undetermined = [self.undetermined.as_slice(), &alike].concat();
        undetermined.sort_unstable();
        Ok(Correction { centred: Some(centred), levels, open, undetermined, alike, ..self })
    }

    /// Mean of d − t (over the trace of node k) where deviations have no datum, else 0.
    pub(super) fn level(&self, k: usize) -> f64 {
        self.levels.as_ref().map_or(0.0, |levels| levels[k])
    }

    /// Degrees of freedom that the means took.
    pub(super) fn lost(&self) -> usize {
        lost(&self.asked, &self.counted)
    }
}

/// Nodes with a zero in common: those of a trace, or all.
struct Groups {
    of_node: Vec<usize>,
    count: usize,
}

impl Groups {
    fn of(correction: &Correction) -> Self {
        let nodes = correction.asked.deviation.len();
        let Some(traces) = &correction.asked.traces else { return Groups { of_node: vec![0; nodes], count: 1 } };
        let mut numbers: BTreeMap<usize, usize> = traces.iter().map(|trace| (*trace, 0)).collect();
        numbers.values_mut().enumerate().for_each(|(number, place)| *place = number);
        Groups { of_node: traces.iter().map(|trace| numbers[trace]).collect(), count: numbers.len() }
    }

    /// Σ w x over the nodes of each that take part.
    fn sums(&self, correction: &Correction, of: impl Fn(usize) -> f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.count];
        correction.counted.iter().for_each(|&k| sums[self.of_node[k]] += correction.weight(k) * of(k));
        sums
    }

    /// NaN where no node takes part.
    fn means(&self, correction: &Correction, of: impl Fn(usize) -> f64) -> Vec<f64> {
        let whole = self.sums(correction, |_| 1.0);
        self.sums(correction, of).iter().zip(whole).map(|(sum, whole)| sum / whole).collect()
    }
}
