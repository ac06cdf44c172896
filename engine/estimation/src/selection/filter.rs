//! Regularisation as a spectral filter (Eqs. 27–40), and the sums over the spectrum that follow
//! from it.
//!
//! With `B_L = Σ cᵢ X Vᵢ Vᵢᵀ` the matrix `X̄ = X + B` keeps the singular vectors of X, so B never
//! has to be formed: eigenvalue i becomes `μᵢ = λᵢ(1+cᵢ)²` and the estimate (Eq. 29) is `Â_B = Σ fᵢ
//! aᵢ Vᵢ` with `fᵢ = 1/(1+cᵢ)`.
//!
//! | rule | fᵢ (for i ≤ L and λᵢ < λ*; else 1) | μᵢ |
//! |---|---|---|
//! | first order (Eq. 40) | 2λᵢ/(λ*+λᵢ) | (λ*+λᵢ)²/(4λᵢ) |
//! | exact | √(λᵢ/λ*) | λ* |
//! | ridge (every i) | λᵢ/(λᵢ+k) | λᵢ+k |
//!
//! An eigenvalue already above λ* is left alone: Eq. 40 would lower it.

use crate::spec::Scheme;

/// Kind of filter, without its parameter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Rule {
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
pub(crate) struct Filtered {
    /// fᵢ.
    pub factor: f64,
    /// 1 − fᵢ, without cancellation.
    pub removed: f64,
    /// μᵢ.
    pub eigenvalue: f64,
}

impl Rule {
    /// The filter of direction `i` with eigenvalue `lambda` at λ* (or k) = `parameter`.
    #[inline(always)]
    pub(crate) fn at(self, i: usize, lambda: f64, parameter: f64) -> Filtered {
        let untouched = Filtered { factor: 1.0, removed: 0.0, eigenvalue: lambda };
        match self {
            Rule::None => untouched,
            Rule::Ridge => {
                let inverse = 1.0 / (lambda + parameter);
                let (f, g) = (lambda * inverse, parameter * inverse);
                Filtered { factor: f, removed: g, eigenvalue: lambda + parameter }
            }
            Rule::Spectral { count, .. } if i >= count || lambda >= parameter => untouched,
            Rule::Spectral { scheme: Scheme::FirstOrder, .. } => {
                let inverse = 1.0 / (lambda + parameter);
                Filtered {
                    factor: 2.0 * lambda * inverse,
                    removed: (parameter - lambda) * inverse,
                    // (λ*+λ)²/(4λ), ordered so that neither square overflows
                    eigenvalue: 0.25 * (lambda + parameter) * ((lambda + parameter) / lambda),
                }
            }
            Rule::Spectral { scheme: Scheme::Exact, .. } => {
                let f = (lambda / parameter).sqrt();
                Filtered { factor: f, removed: 1.0 - f, eigenvalue: parameter }
            }
        }
    }

    /// cᵢ of Eq. 40; `None` for ridge, which has none.
    pub(crate) fn coefficient(self, i: usize, lambda: f64, parameter: f64) -> Option<f64> {
        match self {
            Rule::Ridge => None,
            Rule::None => Some(0.0),
            Rule::Spectral { count, .. } if i >= count || lambda >= parameter => Some(0.0),
            Rule::Spectral { scheme: Scheme::FirstOrder, .. } => Some((parameter - lambda) / (2.0 * lambda)),
            Rule::Spectral { scheme: Scheme::Exact, .. } => Some((parameter / lambda).sqrt() - 1.0),
        }
    }
}
