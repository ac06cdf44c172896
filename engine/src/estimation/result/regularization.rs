//! What regularisation did, what its criteria would have chosen, and the bias that it costs.

use crate::estimation::spec::{Criterion, Scheme};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegularizationKind {
    None,
    Spectral,
    Ridge,
    Tikhonov,
    TruncatedSvd,
    JamesStein,
    Attraction,
}

#[derive(Clone, Debug, PartialEq)]
pub struct RegularizationReport {
    pub kind: RegularizationKind,
    pub scheme: Option<Scheme>,
    /// L.
    pub count: Option<usize>,
    /// λ* of the spectral schemes, k of ridge, the weight of the penalty of Tikhonov, the weight of
    /// an attraction.
    pub lambda_star: Option<f64>,
    /// Directions kept by a truncated singular value decomposition.
    pub rank: Option<usize>,
    /// What James–Stein or an attraction leaves of Â − target.
    pub shrinkage_factor: Option<f64>,
    /// The plateau of minimisers of Eq. 49, where there is one.
    pub lambda_star_interval: Option<[f64; 2]>,
    /// λ* − λ₁.
    pub gamma: Option<f64>,
    /// `None` with `fixed == true` for a caller's value, and for no regularisation.
    pub criterion: Option<Criterion>,
    pub fixed: bool,
    pub filter_factors: Vec<f64>,
    /// Eq. 41.
    pub matrix_norm_squared: Option<f64>,
    /// Ineq. 48.
    pub largest_eigenvalue_bound: Option<f64>,
    pub choices: Vec<Choice>,
}

/// What one criterion would choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// `None` is plain least squares.
    pub criterion: Option<Criterion>,
    pub lambda_star: Option<f64>,
    pub condition: Option<f64>,
    pub bias_norm: f64,
    pub predicted_mse: Option<f64>,
    pub rms: f64,
}

/// Where r came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormLimitSource {
    Request,
    /// ‖Â‖.
    Estimate,
    /// What the heights speak for ([`crate::estimation::spec::ExpectedSize::OfHeights`]).
    Heights,
    /// Limits of the coefficients ([`crate::estimation::spec::ExpectedSize::Within`]).
    Limits,
}

impl NormLimitSource {
    /// As the interface writes it.
    pub fn name(self) -> &'static str {
        match self {
            NormLimitSource::Request => "request",
            NormLimitSource::Estimate => "estimate",
            NormLimitSource::Heights => "heights",
            NormLimitSource::Limits => "limits",
        }
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct BiasReport {
    /// Observed ‖Â − Â_B‖ in the scaled columns.
    pub norm: f64,
    pub sharp_bound: f64,
    /// Ineq. 51; `None` for ridge and for n = 1, where it does not hold.
    pub paper_bound: Option<f64>,
    pub coefficient_norm_limit: f64,
    pub coefficient_norm_limit_source: NormLimitSource,
    /// The small number e of Ineq. 51, read as max cᵢ.
    pub e: Option<f64>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct LambdaCurvePoint {
    pub lambda_star: f64,
    pub condition: Option<f64>,
    pub bias_norm: f64,
    pub predicted_mse: Option<f64>,
    pub rms: f64,
    pub gcv: Option<f64>,
    pub coefficient_norm: f64,
}

/// The coefficients at one k.
#[derive(Clone, Debug, PartialEq)]
pub struct RidgeTracePoint {
    pub k: f64,
    /// In the caller's terms and order.
    pub coefficients: Vec<f64>,
}
