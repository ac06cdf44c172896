//! Settings whose effect at the nodes is small and can be reproduced by other settings.
//!
//! A profile and a helix that cross near the middle of the flank hardly change with its twist, and
//! the two angles reproduce that change. Least squares may then answer a twist of hundreds of
//! micrometres to a deviation of two.

use nalgebra::DMatrix;

use super::problem::Correction;

/// Share of a setting's effect on the whole flank above which the nodes show it.
const SHOWN: f64 = 0.6;
/// Share of a setting's effect on the whole flank that other settings must leave unexplained at the
/// nodes.
const OWN: f64 = 0.01;

impl Correction {
    /// Makes hidden settings undetermined, the one that the nodes show least first.
    pub(super) fn without_hidden(mut self) -> Self {
        let mut order: Vec<(f64, usize)> = self.open.iter().map(|&j| (self.shown(j), j)).collect();
        order.retain(|(shown, _)| *shown < SHOWN);
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, j) in order {
            if self.own(j) < OWN {
                self.open.retain(|open| *open != j);
                self.undetermined.push(j);
            }
        }
        self.undetermined.sort_unstable();
        self
    }

    /// Greatest effect of a setting at a node, as a share of that on the whole flank; infinite
    /// where that is unknown.
    fn shown(&self, j: usize) -> f64 {
        let effects = self.counted.iter().map(|&k| self.row(k)[j].abs());
        effects.fold(0.0, f64::max) / self.asked.settings[j].reach
    }

    /// Rms of the part of the effect that no other settings reproduce, as a share of the same.
    fn own(&self, j: usize) -> f64 {
        let others = self.open.iter().copied().filter(|open| *open != j);
        let order: Vec<usize> = others.chain([j]).collect();
        let entry = |row: usize, column: usize| {
            let k = self.counted[row];
            self.weight(k).sqrt() * self.row(k)[order[column]]
        };
        // the last diagonal of R is the length of what the other columns do not explain
        let r = DMatrix::from_fn(self.counted.len(), order.len(), entry).qr().r();
        let weights: f64 = self.counted.iter().map(|&k| self.weight(k)).sum();
        r[(order.len() - 1, order.len() - 1)].abs() / weights.sqrt() / self.asked.settings[j].reach
    }
}
