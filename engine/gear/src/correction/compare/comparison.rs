//! Specification of a comparison, and its checks.

use crate::correction::{
    gain::Gain,
    problem::Correction,
    scatter::Scatter,
    solution::{Change, Noise, Solution},
};
use flankfit_numerics::{
    check::{Faults, negative, per_node},
    words::{Shown, entries},
};

/// Specification of a comparison. Lists have an entry for each node, µm, NaN where undefined.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// d.
    pub before: Vec<f64>,
    /// d'.
    pub measured: Vec<f64>,
    /// Relative 1/σ² of both measurements; nodes of weight 0 take no part. 1 by default.
    pub weight: Option<Vec<f64>>,
    /// Names of the settings.
    pub settings: Vec<String>,
    /// Effect of each setting on each node, J_kj Δ_j, row by row; their sum is the predicted change
    /// c (about its mean, without a datum).
    pub contributions: Vec<f64>,
    /// −∂c_k/∂d_k, as [`crate::correction::Solution::leverage`] has it; none where c was not
    /// computed from d.
    pub leverage: Option<Vec<f64>>,
    /// σ of both measurements, and how well it is known.
    pub noise: Noise,
    /// η.
    pub response_uncertainty: f64,
    /// Whether deviations have a datum; if not, all lists are compared about their means.
    pub absolute: bool,
    /// Without a datum: the trace of each node, where every trace has a zero of its own.
    pub traces: Option<Vec<usize>>,
    /// Errors of d' − d by the scatter of the teeth that both are means over.
    pub scatter: Scatter,
}

impl Correction {
    /// The leverage of changes that were entered in place of those of `solution`: setting j follows
    /// the computed change by the share `share[j]` (1 as computed, 0 entered regardless of it), and
    /// the noise of the measurement with it. `None` where the singular values do not converge.
    pub fn leverage_of(&self, solution: &Solution, share: &[f64]) -> Option<Vec<f64>> {
        let is_free = |one: &Change| !one.limited && one.unchanged.is_none() && !one.fixed && !one.undetermined;
        let free: Vec<usize> = (0..share.len()).filter(|&j| is_free(&solution.settings[j])).collect();
        if free.is_empty() {
            return Some(solution.leverage.clone());
        }
        let following = Gain::new(self, &free, solution.limited_fit.as_ref().unwrap_or(&solution.fit))?.following();
        let all: f64 = following.iter().sum();
        let entered: f64 = following.iter().zip(&free).map(|(one, &j)| one * share[j]).sum();
        let part = if all > 0.0 { entered / all } else { 0.0 };
        Some(solution.leverage.iter().map(|h| part * h).collect())
    }

    /// Returns the comparison when the settings were changed by `change` and the flank then
    /// measured as `measured`.
    pub fn comparison(&self, change: &[f64], leverage: Vec<f64>, noise: Noise, measured: Vec<f64>) -> Comparison {
        let asked = self.spec();
        Comparison {
            before: asked.deviation.clone(),
            measured,
            weight: asked.weight.clone(),
            settings: asked.settings.iter().map(|setting| setting.name.clone()).collect(),
            contributions: (0..asked.deviation.len())
                .flat_map(|k| self.given_row(k).iter().zip(change).map(|(j, c)| j * c))
                .collect(),
            leverage: Some(leverage),
            noise,
            response_uncertainty: asked.response_uncertainty,
            absolute: asked.absolute,
            traces: asked.traces.clone(),
            scatter: Scatter::default(),
        }
    }
}

impl Comparison {
    /// Refuses lists of unequal lengths and numbers that cannot be.
    pub(super) fn check(&self) -> Result<(), Faults> {
        let mut faults = Faults::default();
        let nodes = self.before.len();
        let lists = [
            ("measured", Some(&self.measured), true),
            ("weight", self.weight.as_ref(), false),
            ("leverage", self.leverage.as_ref(), false),
            ("before", Some(&self.before), true),
        ];
        if let Some(traces) = self.traces.as_ref().filter(|traces| traces.len() != nodes) {
            faults.push("traces", per_node(traces.len(), nodes));
        }
        for column in self.scatter.columns.iter().filter(|column| column.len() != nodes) {
            faults.push("measured", per_node(column.len(), nodes));
        }
        for (list, values, signed) in lists {
            let Some(values) = values else { continue };
            if values.len() != nodes {
                faults.push(list, per_node(values.len(), nodes));
            }
            for (index, value) in values.iter().enumerate() {
                let path = format_args!("{list}[{index}]");
                if value.is_infinite() {
                    faults.push(path, "the number is infinite");
                } else if !(signed || *value >= 0.0) {
                    faults.push(path, format_args!("{} is not a number of at least 0", Shown(*value)));
                }
            }
        }
        let wanted = nodes.saturating_mul(self.settings.len());
        if self.contributions.len() != wanted {
            let given = entries(self.contributions.len());
            faults.push("contributions", format_args!("{given}; nodes and settings need {wanted}"));
        }
        if let Some(index) = self.contributions.iter().position(|c| !c.is_finite()) {
            faults.push(format_args!("contributions[{index}]"), "it is not a finite number");
        }
        for (path, value) in [("noise.sigma", self.noise.sigma), ("response_uncertainty", self.response_uncertainty)] {
            if !(value.is_finite() && value >= 0.0) {
                faults.push(path, negative(value));
            }
        }
        faults.into_result(())
    }
}
