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

use crate::{
    error::FitError,
    result::RegularizationKind,
    spec::{Count, Regularization, Scheme},
};
use flankfit_numerics::{check::Faults, lanes::F64x4};

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
    /// The rule that `regularization` requests for eigenvalues `lambda`, with its kind;
    /// `auto` counts the eigenvalues above the condition limit.
    pub(crate) fn requested(
        regularization: &Regularization,
        lambda: &[f64],
    ) -> Result<(RegularizationKind, Self), FitError> {
        match regularization {
            // the other kinds choose with their own mathematics, in `regularized`
            Regularization::None
            | Regularization::Tikhonov(_)
            | Regularization::TruncatedSvd { .. }
            | Regularization::TruncatedSvdBy { .. }
            | Regularization::JamesStein(_)
            | Regularization::Attraction(_)
            | Regularization::Representative(_) => Ok((RegularizationKind::None, Rule::None)),
            Regularization::Ridge { .. } => Ok((RegularizationKind::Ridge, Rule::Ridge)),
            Regularization::Spectral { scheme, count, condition_limit, .. } => {
                let largest = lambda[lambda.len() - 1];
                let count = match count {
                    Count::Auto => {
                        lambda.iter().filter(|l| largest / **l > *condition_limit).count().min(lambda.len() - 1)
                    }
                    Count::Given(count) => checked_count(*count, lambda.len())?,
                };
                Ok((RegularizationKind::Spectral, Rule::Spectral { scheme: *scheme, count }))
            }
        }
    }

    /// True if the rule is a penalty: it regularises every direction at every parameter, and the
    /// parameter has no upper limit.
    pub(crate) fn is_penalty(self) -> bool {
        match self {
            Rule::None | Rule::Spectral { .. } => false,
            Rule::Ridge => true,
        }
    }

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

    /// (f, 1 − f, f′, f″) of four regularised eigenvalues at four parameters; derivatives are by
    /// ln λ*.
    #[inline(always)]
    pub(super) fn at_four(self, lambda: F64x4, p: F64x4) -> (F64x4, F64x4, F64x4, F64x4) {
        match self {
            Rule::None => (F64x4::ONE, F64x4::ZERO, F64x4::ZERO, F64x4::ZERO),
            Rule::Ridge => {
                let inverse = (lambda + p).reciprocal();
                let (f, g) = (lambda * inverse, p * inverse);
                let slope = -(f * g);
                (f, g, slope, slope * (f - g))
            }
            Rule::Spectral { scheme: Scheme::FirstOrder, .. } => {
                let inverse = (lambda + p).reciprocal();
                let (f, g) = (lambda * inverse, p * inverse);
                let slope = f * g * -2.0;
                (f * 2.0, g - f, slope, slope * (f - g))
            }
            Rule::Spectral { scheme: Scheme::Exact, .. } => {
                let f = (lambda * p.reciprocal()).square_root();
                (f, F64x4::ONE - f, f * -0.5, f * 0.25)
            }
        }
    }

    /// Derivative of 1 − f by ln λ* of a regularised direction.
    pub(super) fn rise(self, Filtered { factor: f, removed: g, .. }: Filtered) -> f64 {
        match self {
            Rule::Spectral { scheme: Scheme::FirstOrder, .. } => f * (1.0 - 0.5 * f),
            Rule::Spectral { scheme: Scheme::Exact, .. } => 0.5 * f,
            Rule::Ridge | Rule::None => f * g,
        }
    }
}

/// A number of eigenvalues to be regularised, out of `all`.
pub(crate) fn checked_count(count: usize, all: usize) -> Result<usize, Faults> {
    if count < all {
        return Ok(count);
    }
    Err(Faults::one(
        "regularization.count",
        format_args!(
            "{count} of {all} eigenvalues: the largest one cannot be regularised, so at most {} are possible",
            all.saturating_sub(1)
        ),
    ))
}
