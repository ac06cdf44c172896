//! β: how much of the predicted change came.

use super::{answer::Verdict, comparison::Comparison, counted::Counted};
use crate::correction::solution::Noise;
use flankfit_numerics::distribution::Student;

/// Probability outside the interval that decides.
pub(super) const TAIL: f64 = 0.003;
/// Ratio below which a machine did not respond as predicted, and above which it did respond.
const HALF: f64 = 0.5;

/// The measured change as a multiple of the predicted one.
pub(super) struct Scaled {
    /// β̂.
    pub ratio: f64,
    /// The same with the least correction for noise that is possible.
    largest: f64,
    pub std_error: f64,
    /// Distribution of an error over the standard error.
    pub student: Student,
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
        let columns: f64 = (0..settings.len())
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
        let student = freedom.map_or(Student::NORMAL, Student::new);
        Some(Scaled { ratio, largest, std_error: (variance + scatter).sqrt(), student })
    }

    /// Interval of the ratio, at 0.95.
    pub(super) fn interval(&self) -> [f64; 2] {
        let half = self.student.upper_quantile(0.025) * self.std_error;
        [self.ratio - half, self.ratio + half]
    }

    /// Half the width of the interval that decides.
    fn half_width(&self) -> f64 {
        self.student.upper_quantile(0.5 * TAIL) * self.std_error
    }

    /// Whether a full response could have been distinguished from none.
    pub(super) fn determined(&self) -> bool {
        self.half_width() < 1.0
    }

    /// Verdict on a change that is a multiple of the predicted one.
    pub(super) fn verdict(&self) -> Verdict {
        let [low, high] = [self.ratio - self.half_width(), self.largest + self.half_width()];
        match () {
            // the machine went the other way: no multiple of what J says
            () if high < 0.0 => Verdict::Different,
            () if low <= 0.0 && high < HALF => Verdict::NoResponse,
            () if high < 1.0 => Verdict::Weaker,
            () if low > 1.0 => Verdict::Stronger,
            () if low > HALF => Verdict::AsPredicted,
            () => Verdict::Undecided,
        }
    }
}
