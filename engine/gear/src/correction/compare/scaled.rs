//! β: how much of the predicted change came.

use super::{
    answer::Verdict,
    comparison::Comparison,
    counted::Counted,
    misfit::{TAIL, TWO_SIDED},
};
use crate::correction::solution::Noise;
use flankfit_numerics::distribution::{Student, fisher};

/// The measured change as a multiple of the predicted one.
pub(super) struct Scaled {
    /// β̂.
    pub ratio: f64,
    /// The same with the least correction for noise that is possible.
    largest: f64,
    pub std_error: f64,
    /// Quantile that differences are held against.
    quantile: f64,
    /// Degrees of freedom of the standard error; `None` where the noise is known.
    freedom: Option<f64>,
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
        let largest = if freedom.is_some() { raw } else { ratio };
        let by_scatter = |column: &Vec<f64>| {
            let along: f64 = (0..m).map(|i| nodes.weight[i] * c[i] * column[i]).sum();
            (along / (unit * square)).powi(2)
        };
        let scatter: f64 = nodes.scatter.iter().map(by_scatter).sum();
        let freedom = freedom.map(|freedom| freedom.max(1) as f64);
        let freedom = match comparison.scatter.freedom {
            of_scatter if of_scatter > 0 && scatter > 0.0 => {
                let own = freedom.map_or(0.0, |freedom| variance * variance / freedom);
                Some((variance + scatter).powi(2) / (own + scatter * scatter / of_scatter as f64))
            }
            _ => freedom,
        };
        let quantile = freedom.map_or(TWO_SIDED, |freedom| fisher::student_two_sided(TAIL, freedom));
        Some(Scaled { ratio, largest, std_error: (variance + scatter).sqrt(), quantile, freedom })
    }

    /// Interval of the ratio, at 0.95.
    pub(super) fn interval(&self) -> [f64; 2] {
        let student = self.freedom.map_or(Student::NORMAL, Student::new);
        let half = student.upper_quantile(0.025) * self.std_error;
        [self.ratio - half, self.ratio + half]
    }

    /// Whether the answer could have been distinguished from none.
    pub(super) fn determined(&self) -> bool {
        self.quantile * self.std_error < 1.0
    }

    /// Verdict on a change that is a multiple of the predicted one.
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
