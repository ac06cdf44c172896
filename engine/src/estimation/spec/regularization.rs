//! The kinds of regularisation and their parameters.

use super::{
    criterion::{Criterion, Parameter},
    shrinkage::{Attraction, JamesStein},
    tikhonov::Tikhonov,
};

#[derive(Clone, Debug, PartialEq)]
pub enum Regularization {
    None,
    /// The paper's matrix B (Eq. 40).
    Spectral {
        scheme: Scheme,
        count: Count,
        condition_limit: f64,
        lambda_star: Parameter,
    },
    Ridge {
        parameter: Parameter,
    },
    Tikhonov(Tikhonov),
    /// Only the `rank` largest singular values are kept.
    TruncatedSvd {
        rank: usize,
    },
    JamesStein(JamesStein),
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
    Given(usize),
}
