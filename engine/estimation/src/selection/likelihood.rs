//! The restricted likelihood of a parameter.
//!
//! A penalty K is the prior `A ~ N(0, σ²K⁻¹)`: along direction i the heights have `bᵢ = √λᵢ aᵢ` of
//! variance `σ²/(1 − fᵢ)`, since `κᵢ = λᵢ(1/fᵢ − 1)`. Directions that are not penalised, and the
//! constant of standardised columns, have a flat prior. Less constants, −2 ln L is
//!
//! `(m − n₀) ln(RSS + Σ(1−fᵢ) bᵢ²) − Σ ln(1−fᵢ)`
//!
//! with σ² at its maximum and n₀ flat directions, and `Σ(1−fᵢ) bᵢ²/σ² − Σ ln(1−fᵢ)` where σ is
//! given. Likelihoods with different numbers of flat directions are of different data and are not
//! compared: in the spectral schemes λ* is looked for where all L directions are penalised, from
//! λ_L on.

use std::ops::Range;

use super::{filter::Rule, spectral::Spectral};

/// The likelihood of parameters of one rule.
pub(super) struct Likelihood<'a> {
    problem: &'a Spectral<'a>,
    rule: Rule,
    penalised: Range<usize>,
    /// m − n₀.
    freedom: f64,
}

impl<'a> Likelihood<'a> {
    /// Makes the likelihood; `None` if there are only flat directions.
    pub(super) fn new(problem: &'a Spectral<'a>, rule: Rule, penalised: Range<usize>) -> Option<Self> {
        let positive = problem.lambda.iter().filter(|l| **l > 0.0).count();
        let flat = positive - penalised.len() + problem.unpenalised;
        let freedom = problem.count.checked_sub(flat).filter(|left| *left > 0)? as f64;
        Some(Likelihood { problem, rule, penalised, freedom })
    }

    /// −2 ln L and its derivative by ln λ*.
    pub(super) fn at(&self, x: f64) -> (f64, f64) {
        let parameter = x.exp();
        let (mut sum, mut slope, mut logarithms, mut rises) = (0.0, 0.0, 0.0, 0.0);
        for i in self.penalised.clone() {
            let (lambda, square) = (self.problem.lambda[i], self.problem.square(i));
            let filtered = self.rule.at(i, lambda, parameter);
            let (g, rise) = (filtered.removed, self.rule.rise(filtered));
            sum += g * lambda * square;
            slope += rise * lambda * square;
            logarithms += g.ln();
            rises += rise / g;
        }
        match self.problem.given_variance {
            Some(variance) => (sum / variance - logarithms, slope / variance - rises),
            None => {
                let whole = self.problem.rss + sum;
                (self.freedom * whole.ln() - logarithms, self.freedom * slope / whole - rises)
            }
        }
    }
}
