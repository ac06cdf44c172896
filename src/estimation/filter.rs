//! Regularisation as a spectral filter (Eqs. 27–40), and the sums over the spectrum that follow from it.
//!
//! With `B_L = Σ cᵢ X Vᵢ Vᵢᵀ` the matrix `X̄ = X + B` keeps the singular vectors of X, so B never has to be formed:
//! eigenvalue i becomes `μᵢ = λᵢ(1+cᵢ)²` and the estimate (Eq. 29) is `Â_B = Σ fᵢ aᵢ Vᵢ` with `fᵢ = 1/(1+cᵢ)`.
//!
//! | rule | fᵢ (for i ≤ L and λᵢ < λ*; else 1) | μᵢ |
//! |---|---|---|
//! | first order (Eq. 40) | 2λᵢ/(λ*+λᵢ) | (λ*+λᵢ)²/(4λᵢ) |
//! | exact | √(λᵢ/λ*) | λ* |
//! | ridge (every i) | λᵢ/(λᵢ+k) | λᵢ+k |
//!
//! An eigenvalue already above λ* is left alone: Eq. 40 would lower it.

use super::spec::Scheme;

/// Which filter, without its parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rule {
    /// Plain least squares.
    None,
    /// The `count` smallest eigenvalues are regularised.
    Spectral {
        scheme: Scheme,
        count: usize,
    },
    Ridge,
}

/// One direction's filter at one parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Filtered {
    /// fᵢ.
    pub factor: f64,
    /// 1 − fᵢ, without cancellation.
    pub removed: f64,
    /// dfᵢ/d ln λ*.
    pub slope: f64,
    /// d²fᵢ/d(ln λ*)².
    pub bend: f64,
    /// μᵢ.
    pub eigenvalue: f64,
}

impl Rule {
    /// The filter of direction `i` with eigenvalue `lambda` at λ* (or k) = `parameter`.
    #[inline(always)]
    pub fn at(self, i: usize, lambda: f64, parameter: f64) -> Filtered {
        let untouched = Filtered { factor: 1.0, removed: 0.0, slope: 0.0, bend: 0.0, eigenvalue: lambda };
        match self {
            Rule::None => untouched,
            Rule::Ridge => {
                let inverse = 1.0 / (lambda + parameter);
                let (f, g) = (lambda * inverse, parameter * inverse);
                Filtered {
                    factor: f,
                    removed: g,
                    slope: -f * g,
                    bend: -f * g * (f - g),
                    eigenvalue: lambda + parameter,
                }
            }
            Rule::Spectral { count, .. } if i >= count || lambda >= parameter => untouched,
            Rule::Spectral { scheme: Scheme::FirstOrder, .. } => {
                let inverse = 1.0 / (lambda + parameter);
                let (f, g) = (lambda * inverse, parameter * inverse);
                Filtered {
                    factor: 2.0 * f,
                    removed: (parameter - lambda) * inverse,
                    slope: -2.0 * f * g,
                    bend: -2.0 * f * g * (f - g),
                    // (λ*+λ)²/(4λ), ordered so that neither square overflows
                    eigenvalue: 0.25 * (lambda + parameter) * ((lambda + parameter) / lambda),
                }
            }
            Rule::Spectral { scheme: Scheme::Exact, .. } => {
                let f = (lambda / parameter).sqrt();
                Filtered { factor: f, removed: 1.0 - f, slope: -0.5 * f, bend: 0.25 * f, eigenvalue: parameter }
            }
        }
    }

    /// cᵢ of Eq. 40; `None` for ridge, which has none.
    pub fn coefficient(self, i: usize, lambda: f64, parameter: f64) -> Option<f64> {
        match self {
            Rule::Ridge => None,
            Rule::None => Some(0.0),
            Rule::Spectral { count, .. } if i >= count || lambda >= parameter => Some(0.0),
            Rule::Spectral { scheme: Scheme::FirstOrder, .. } => Some((parameter - lambda) / (2.0 * lambda)),
            Rule::Spectral { scheme: Scheme::Exact, .. } => Some((parameter / lambda).sqrt() - 1.0),
        }
    }
}

/// What every criterion needs to know of a fit.
pub struct Spectral<'a> {
    /// λᵢ ascending, 0 where not told from 0.
    pub lambda: &'a [f64],
    /// aᵢ = VᵢᵀÂ.
    pub a: &'a [f64],
    /// σ², where there is one.
    pub variance: Option<f64>,
    /// Residual sum of squares of least squares.
    pub rss: f64,
    /// m.
    pub count: usize,
    /// Coefficients outside the filter (the constant of standardised columns).
    pub unpenalised: usize,
}

/// Sums over the spectrum at one parameter; derivatives are by ln λ*.
#[derive(Clone, Copy, Debug, Default)]
pub struct Sums {
    /// `‖Y − X Â_B‖²` and its derivatives.
    pub rss: [f64; 3],
    /// `‖Â_B‖²` and its derivatives.
    pub norm: [f64; 3],
    /// `Σ fᵢ`, unpenalised coefficients counted as 1, and its derivative.
    pub trace: [f64; 2],
    /// `Σ (1−fᵢ)² max(aᵢ² − σ²/λᵢ, 0) + σ² fᵢ²/λᵢ` and its derivative.
    pub mse: [f64; 2],
    /// `‖Â − Â_B‖²`.
    pub bias: f64,
}

impl Spectral<'_> {
    /// The sums at λ* (or k) = `parameter`.
    pub fn sums(&self, rule: Rule, parameter: f64) -> Sums {
        let mut sums = Sums::default();
        sums.rss[0] = self.rss;
        sums.trace[0] = self.unpenalised as f64;
        let variance = self.variance.unwrap_or(0.0);
        for (i, (&lambda, &a)) in self.lambda.iter().zip(self.a).enumerate() {
            if lambda <= 0.0 {
                continue;
            }
            let f = rule.at(i, lambda, parameter);
            let (square, noise) = (a * a, variance / lambda);
            let shown = lambda * square;
            sums.rss[0] += shown * f.removed * f.removed;
            sums.rss[1] -= 2.0 * shown * f.removed * f.slope;
            sums.rss[2] += 2.0 * shown * (f.slope * f.slope - f.removed * f.bend);
            sums.norm[0] += square * f.factor * f.factor;
            sums.norm[1] += 2.0 * square * f.factor * f.slope;
            sums.norm[2] += 2.0 * square * (f.slope * f.slope + f.factor * f.bend);
            sums.trace[0] += f.factor;
            sums.trace[1] += f.slope;
            let real = (square - noise).max(0.0);
            sums.mse[0] += f.removed * f.removed * real + noise * f.factor * f.factor;
            sums.mse[1] += 2.0 * f.slope * (noise * f.factor - f.removed * real);
            sums.bias += square * f.removed * f.removed;
        }
        sums
    }

    /// Condition of the regularised matrix at `parameter`; `None` where an eigenvalue stays 0.
    pub fn condition(&self, rule: Rule, parameter: f64) -> Option<f64> {
        let (mut low, mut high) = (f64::INFINITY, 0.0f64);
        for (i, &lambda) in self.lambda.iter().enumerate() {
            let eigenvalue = rule.at(i, lambda, parameter).eigenvalue;
            low = low.min(eigenvalue);
            high = high.max(eigenvalue);
        }
        let condition = high / low;
        (low > 0.0 && condition.is_finite()).then_some(condition)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Slopes and bends against central differences, for every rule.
    #[test]
    fn derivatives_by_the_logarithm() {
        let rules = [
            Rule::Ridge,
            Rule::Spectral { scheme: Scheme::FirstOrder, count: 1 },
            Rule::Spectral { scheme: Scheme::Exact, count: 1 },
        ];
        let h: f64 = 1e-4;
        for rule in rules {
            for parameter in [0.011f64, 0.3, 7.0] {
                let at = |x: f64| rule.at(0, 0.01, parameter * x.exp());
                let f = at(0.0);
                assert!((f.factor + f.removed - 1.0).abs() < 1e-15);
                assert!(((at(h).factor - at(-h).factor) / (2.0 * h) - f.slope).abs() < 1e-7);
                assert!(((at(h).slope - at(-h).slope) / (2.0 * h) - f.bend).abs() < 1e-7);
            }
        }
    }

    #[test]
    fn an_eigenvalue_above_lambda_star_is_left_alone() {
        for scheme in [Scheme::FirstOrder, Scheme::Exact] {
            let f = Rule::Spectral { scheme, count: 3 }.at(1, 2.0, 1.0);
            assert_eq!((f.factor, f.eigenvalue), (1.0, 2.0));
        }
    }
}
