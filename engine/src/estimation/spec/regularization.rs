//! The kinds of regularisation and their parameters.

use super::{
    criterion::{Criterion, Parameter},
    shrinkage::{Attraction, JamesStein},
    tikhonov::Tikhonov,
};

/// What is done against small eigenvalues.
#[derive(Clone, Debug, PartialEq)]
pub enum Regularization {
    /// Least squares as it is.
    None,
    /// The paper's matrix B (Eq. 40).
    Spectral {
        /// Which eigenvalues the matrix B makes.
        scheme: Scheme,
        /// How many eigenvalues are raised, L.
        count: Count,
        /// λₙ/λᵢ beyond which [`Count::Auto`] regularises a direction.
        condition_limit: f64,
        /// λ*, the eigenvalue that small ones are raised to.
        lambda_star: Parameter,
    },
    /// `min ‖Y − XA‖² + k ‖A‖²` in the scaled columns.
    Ridge {
        /// k.
        parameter: Parameter,
    },
    /// A penalty on roughness.
    Tikhonov(Tikhonov),
    /// Only the `rank` largest singular values are kept.
    TruncatedSvd {
        /// Number of singular values that are kept.
        rank: usize,
    },
    /// Shrinkage by a factor that the data give.
    JamesStein(JamesStein),
    /// Shrinkage towards a target.
    Attraction(Attraction),
}

/// Condition index 30 on unit-length columns (Belsley's rule), squared.
pub const DEFAULT_CONDITION_LIMIT: f64 = 900.0;

impl Default for Regularization {
    fn default() -> Self {
        Regularization::Spectral {
            scheme: Scheme::FirstOrder,
            count: Count::Auto,
            condition_limit: DEFAULT_CONDITION_LIMIT,
            lambda_star: Parameter::Criterion(Criterion::MinMse),
        }
    }
}

/// Which eigenvalues the matrix B makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Scheme {
    /// cᵢ = (λ* − λᵢ)/(2λᵢ), Eq. 40.
    #[default]
    FirstOrder,
    /// cᵢ = √(λ*/λᵢ) − 1, which makes the regularised eigenvalue λ* exactly.
    Exact,
}

/// How many of the smallest eigenvalues are regularised (L).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum Count {
    /// Those with λₙ/λᵢ above the condition limit.
    #[default]
    Auto,
    /// This many.
    Given(usize),
}
