//! β: how much of the predicted change came.

use super::{answer::Verdict, comparison::Comparison, counted::Counted, misfit::TAIL};
use crate::{
    gear::correction::solution::Noise,
    numerics::distribution::{Student, fisher},
};

/// 0.999 quantile of the standard normal distribution, two-sided.
const TWO_SIDED: f64 = 3.290_526_731_491_894;
/// The measured change as a multiple of the predicted one.
pub(super) struct Scaled {
    /// β̂.
    pub ratio: f64,
    /// The same with the least correction for noise that is possible.
    largest: f64,
    pub std_error: f64,
    /// Quantile that differences are held against.
    quantile: f64,
}

impl Scaled {
    /// `None` where no change was predicted.
    pub(super) fn of(nodes: &Counted, comparison: &Comparison) -> Option<Self> {
        let Comparison { noise: Noise { sigma, freedom }, response_uncertainty: eta, settings, .. } = comparison;
        let m = nodes.change.len();
        // relative to the largest change, which squares of small ones would not be
        let unit = nodes.change.iter().fold(0.0f64, |most, c| most.max(c.abs()));
        let c: Vec<f64> = nodes.change.iter().map(|c| c / unit).collect();
        let square: f64 = (0..m).map(|i| nodes.weight[i] * c[i] * c[i]).sum();
        if !(square > 0.0) {
            return None;
        }
        let sigma = sigma / unit;
        let noise = sigma * sigma / square;
        let raw = (0..m).map(|i| nodes.weight[i] * c[i] * nodes.came[i]).sum::<f64>() / (unit * square);
        let ratio = raw - noise * nodes.leverage;
        let columns: f64 = (0..*settings)
            .map(|j| {
                (0..m).map(|i| nodes.weight[i] * (c[i] * nodes.contributions[i][j] / unit).abs()).sum::<f64>() / square
            })
            .map(|most| most * most)
            .sum();
        // of σ²h, where σ is estimated
        let uncertain = freedom.map_or(0.0, |freedom| 2.0 / freedom.max(1) as f64 * nodes.leverage * nodes.leverage);
        let variance = 2.0 * noise + noise * noise * (nodes.leverage + uncertain) + eta * eta * (1.0 + columns);
        let quantile = freedom.map_or(TWO_SIDED, |freedom| fisher::student_two_sided(TAIL, freedom.max(1) as f64));
        let largest = if freedom.is_some() { raw } else { ratio };
        Some(Scaled { ratio, largest, std_error: variance.sqrt(), quantile })
    }

    /// Of the ratio, at 0.95.
    pub(super) fn interval(&self, freedom: Option<usize>) -> [f64; 2] {
        let student = freedom.map_or(Student::NORMAL, |freedom| Student::new(freedom.max(1) as f64));
        let half = student.upper_quantile(0.025) * self.std_error;
        [self.ratio - half, self.ratio + half]
    }

    /// Whether the answer could have been distinguished from none.
    pub(super) fn determined(&self) -> bool {
        self.quantile * self.std_error < 1.0
    }

    /// Of a change that is a multiple of the predicted one.
    pub(super) fn verdict(&self) -> Verdict {
        let most = self.quantile * self.std_error;
        match () {
            () if !self.determined() => Verdict::Undecided,
            // the machine went the other way: no multiple of what J says
            () if self.largest < -most => Verdict::Different,
            () if self.largest < 1.0 - most => Verdict::Weaker,
            () if self.ratio > 1.0 + most => Verdict::Stronger,
            () => Verdict::AsPredicted,
        }
    }
}
