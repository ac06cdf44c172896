//! Mean line and mean parabola of a trace, and what each sample adds to their figures.
//!
//! Weighted least squares in polynomials p₀, p₁, p₂ that are perpendicular over the samples
//! (Forsythe's recurrence): `p₁ = u − α₀`, `p₂ = (u − α₁) p₁ − β`, each with its coefficient `cₖ =
//! Σ w pₖ δ / Σ w pₖ²`. Coefficients are sums of the deviations with known factors, so noise of
//! variance σ² per sample has in them the variance σ² times the sum of the squared factors: weights
//! say how long a range a sample represents, not how well it was measured.

use flankfit_numerics::cancel::Asking;

/// The mean line and the mean parabola.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MeanCurves {
    /// c₀, c₁, c₂.
    coefficients: [f64; 3],
    alpha: [f64; 2],
    beta: f64,
    /// Σ w p₁², Σ w p₂².
    norms: [f64; 2],
}

/// Figures of a trace's mean curves, in the order of the factors: slope of the line, slope of
/// the parabola's chord over [-1, 1], coefficient of u².
pub(crate) const FIGURES: usize = 3;

impl MeanCurves {
    /// Returns the curves of samples at three places at least, with weights above 0.
    pub(crate) fn of(u: &[f64], deviation: &[f64], weight: &[f64]) -> Self {
        let sum = |of: &dyn Fn(usize) -> f64| (0..u.len()).asking(5).map(|i| weight[i] * of(i)).sum::<f64>();
        let total = sum(&|_| 1.0);
        let first = sum(&|i| u[i]) / total;
        let p1 = |i: usize| u[i] - first;
        let n1 = sum(&|i| p1(i).powi(2));
        let second = sum(&|i| u[i] * p1(i).powi(2)) / n1;
        let beta = n1 / total;
        let p2 = |i: usize| (u[i] - second) * p1(i) - beta;
        let n2 = sum(&|i| p2(i).powi(2));
        // what the curves found so far leave, so that a large constant costs no digits of the slope
        let c0 = sum(&|i| deviation[i]) / total;
        let c1 = sum(&|i| p1(i) * (deviation[i] - c0)) / n1;
        let c2 = sum(&|i| p2(i) * (deviation[i] - c0 - c1 * p1(i))) / n2;
        MeanCurves { coefficients: [c0, c1, c2], alpha: [first, second], beta, norms: [n1, n2] }
    }

    fn p1(&self, u: f64) -> f64 {
        u - self.alpha[0]
    }

    fn p2(&self, u: f64) -> f64 {
        (u - self.alpha[1]) * self.p1(u) - self.beta
    }

    /// The line at u.
    pub(crate) fn line(&self, u: f64) -> f64 {
        let [c0, c1, _] = self.coefficients;
        c0 + c1 * self.p1(u)
    }

    /// The parabola at u.
    pub(crate) fn parabola(&self, u: f64) -> f64 {
        self.line(u) + self.coefficients[2] * self.p2(u)
    }

    /// The slopes and the curvature.
    pub(crate) fn figures(&self) -> [f64; FIGURES] {
        let [_, c1, c2] = self.coefficients;
        [c1, c1 + self.bend() * c2, c2]
    }

    /// Factors by which the deviation of a sample at u with a weight enters each of them.
    pub(crate) fn factors(&self, u: f64, weight: f64) -> [f64; FIGURES] {
        let (a, b) = (weight * self.p1(u) / self.norms[0], weight * self.p2(u) / self.norms[1]);
        [a, a + self.bend() * b, b]
    }

    /// p₂'(0): what the curvature adds to the slope of the chord.
    fn bend(&self) -> f64 {
        -(self.alpha[0] + self.alpha[1])
    }
}
