//! Upper tails of distributions that are known by their first four moments: Pearson's type I (beta
//! over a range of its own), and type III (gamma) where there is none.

use super::{beta::incomplete_beta, chi_squared, normal};

/// Mean, variance, skewness and kurtosis (3 for the normal distribution).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moments {
    /// Mean.
    pub mean: f64,
    /// Variance.
    pub variance: f64,
    /// Third central moment over the third power of the standard deviation.
    pub skewness: f64,
    /// Fourth central moment over the square of the variance.
    pub kurtosis: f64,
}

impl Moments {
    /// Moments of `eᵀMAMe / eᵀMe` for independent normal e and a projection M of rank `freedom`, by
    /// the traces of the first four powers of MA: the ratio is independent of its denominator, so
    /// its moments about 0 are those of `eᵀMAMe` over those of χ². `None` where it does not vary.
    ///
    /// ```
    /// use flankfit_numerics::distribution::pearson::Moments;
    ///
    /// // One of two squares over both is uniform in its angle: mean ½, variance ⅛.
    /// let ratio = Moments::of_ratio([1.0; 4], 2.0).expect("it varies");
    /// assert!((ratio.mean - 0.5).abs() < 1e-12 && (ratio.variance - 0.125).abs() < 1e-12);
    /// ```
    pub fn of_ratio([t1, t2, t3, t4]: [f64; 4], freedom: f64) -> Option<Self> {
        let (k1, k2, k3, k4) = (t1, 2.0 * t2, 8.0 * t3, 48.0 * t4);
        let below = |j: i32| (0..j).map(|i| freedom + 2.0 * f64::from(i)).product::<f64>();
        let mean = k1 / below(1);
        let second = (k2 + k1 * k1) / below(2);
        let third = (k3 + 3.0 * k2 * k1 + k1.powi(3)) / below(3);
        let fourth = (k4 + 4.0 * k3 * k1 + 3.0 * k2 * k2 + 6.0 * k2 * k1 * k1 + k1.powi(4)) / below(4);
        let variance = 2.0 * (t2 - t1 * mean) / below(2);
        if !(freedom >= 1.0 && variance > 1e-12 * second) {
            return None;
        }
        let about_mean = (
            third - 3.0 * mean * second + 2.0 * mean.powi(3),
            fourth - 4.0 * mean * third + 6.0 * mean * mean * second - 3.0 * mean.powi(4),
        );
        let skewness = about_mean.0 / variance.powf(1.5);
        Some(Moments { mean, variance, skewness, kurtosis: about_mean.1 / (variance * variance) })
    }
}

/// P(X > x) of Pearson's distribution with these moments.
///
/// ```
/// use flankfit_numerics::distribution::pearson::{Moments, upper_tail};
///
/// // Uniform over 0 … 1 is a beta distribution.
/// let uniform = Moments { mean: 0.5, variance: 1.0 / 12.0, skewness: 0.0, kurtosis: 1.8 };
/// assert!((upper_tail(0.9, &uniform) - 0.1).abs() < 1e-12);
/// ```
pub fn upper_tail(x: f64, moments: &Moments) -> f64 {
    let &Moments { mean, variance, skewness, kurtosis } = moments;
    let (square, deviation) = (skewness * skewness, variance.sqrt());
    let below = 6.0 + 3.0 * square - 2.0 * kurtosis;
    let r = 6.0 * (kurtosis - square - 1.0) / below;
    if !(below > 0.0 && r > 0.0) || r > MOST {
        return third_type((x - mean) / deviation, skewness);
    }
    let width = ((r + 2.0).powi(2) * square + 16.0 * (r + 1.0)).sqrt();
    let tilt = (r + 2.0) * skewness / width;
    let (p, q) = (0.5 * r * (1.0 - tilt), 0.5 * r * (1.0 + tilt));
    let width = 0.5 * deviation * width;
    let share = (x - (mean - width * p / r)) / width;
    incomplete_beta(1.0 - share, share, q, p)
}

/// p + q from which on the beta distribution is no other than gamma or normal.
const MOST: f64 = 1e7;

/// The third type: a standardised gamma distribution.
fn third_type(z: f64, skewness: f64) -> f64 {
    if skewness.abs() < 1e-4 {
        return normal::upper_tail(z);
    }
    let freedom = 8.0 / (skewness * skewness);
    let x = freedom + z * (2.0 * freedom).sqrt() * skewness.signum();
    let tail = chi_squared::upper_tail(x.max(0.0), freedom);
    if skewness > 0.0 { tail } else { 1.0 - tail }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::fisher;

    #[test]
    fn a_beta_distribution_is_met() {
        // Moments of Beta(2, 5): 2/7, 5/196, 0.5962847940, 2.88; its tail through Fisher's F.
        let moments =
            Moments { mean: 2.0 / 7.0, variance: 5.0 / 196.0, skewness: 0.596_284_793_999_944, kurtosis: 2.88 };
        for x in [0.1, 0.3, 0.6, 0.9] {
            let exact = fisher::upper_tail(5.0 * x / (2.0 * (1.0 - x)), 4.0, 10.0);
            assert!((upper_tail(x, &moments) - exact).abs() < 1e-11, "{x}");
        }
        assert_eq!((upper_tail(-0.1, &moments), upper_tail(1.1, &moments)), (1.0, 0.0));
    }

    #[test]
    fn a_gamma_distribution_is_met() {
        // χ² of 8: mean 8, variance 16, skewness 1, kurtosis 4.5; and mirrored
        let moments = Moments { mean: 8.0, variance: 16.0, skewness: 1.0, kurtosis: 4.5 };
        for x in [3.0, 8.0, 20.0] {
            assert!((upper_tail(x, &moments) - chi_squared::upper_tail(x, 8.0)).abs() < 1e-12);
            let mirrored = Moments { mean: -8.0, skewness: -1.0, ..moments };
            assert!((upper_tail(-x, &mirrored) - 1.0 + chi_squared::upper_tail(x, 8.0)).abs() < 1e-12);
        }
    }
}
