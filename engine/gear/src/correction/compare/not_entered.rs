//! Settings whose change was not entered.
//!
//! Freeing the response of setting j alone, `1 + γ_j` with `γ_j = ⟨C_j, r⟩/⟨C_j, C_j⟩` and the
//! standard error `⟨C_j, C_j⟩^(−1/2)` in the metric S⁻¹, r = d' − p. A setting is named where that
//! interval contains 0 and excludes 1 (Bonferroni over the settings), χ² of `r + C_j` is below its
//! quantile, and no other explanation (one response for all, another setting with a response of its
//! own) is better by 3σ. The response for all must be worse by 3σ itself: a machine that did
//! nothing has not forgotten one setting.

use super::{
    answer::NotEntered,
    misfit::Covariance,
    scaled::{Scaled, TAIL},
};

/// Probability that chance alone makes one of two explanations so much better.
const CHANCE: f64 = 0.002_7;

/// Measured and predicted changes.
pub(super) struct Explained<'a> {
    /// d' − p.
    pub left: Vec<f64>,
    /// C_j, one list for each setting.
    pub contributions: Vec<Vec<f64>>,
    pub names: &'a [String],
    pub covariance: &'a Covariance,
    /// χ² of the best response for all settings.
    pub by_ratio: f64,
    /// Quantile of χ².
    pub limit: f64,
}

/// A setting, and χ² with its best response and without its change.
struct Freed {
    named: NotEntered,
    best: f64,
    without: f64,
    possible: bool,
}

impl Explained<'_> {
    pub(super) fn not_entered(&self, scaled: &Scaled) -> Vec<NotEntered> {
        let all = self.covariance.square(&self.left);
        let moved = |column: &&Vec<f64>| column.iter().any(|c| *c != 0.0);
        let settings = self.contributions.iter().filter(moved).count();
        if settings < 2 {
            return Vec::new();
        }
        let apart = scaled.student.upper_quantile(0.5 * CHANCE).powi(2);
        let [one, each] = [TAIL, TAIL / settings as f64].map(|tail| scaled.student.upper_quantile(0.5 * tail));
        let freed: Vec<Freed> = self
            .contributions
            .iter()
            .zip(self.names)
            .filter(|(column, _)| moved(column))
            .map(|(column, name)| {
                let square = self.covariance.square(column);
                let along = self.covariance.product(column, &self.left);
                let (off, error) = (along / square, square.sqrt().recip());
                let without = all + 2.0 * along + square;
                Freed {
                    best: all - along * off,
                    without,
                    possible: off < -each * error && (1.0 + off).abs() <= one * error && without <= self.limit,
                    named: NotEntered {
                        setting: name.clone(),
                        response_ratio: 1.0 + off,
                        response_ratio_std_error: error,
                    },
                }
            })
            .collect();
        let least = freed.iter().map(|one| one.best).fold(self.by_ratio, f64::min);
        let possible = |one: &Freed| one.possible && one.without <= (least + apart).min(self.by_ratio - apart);
        freed.into_iter().filter(possible).map(|one| one.named).collect()
    }
}
