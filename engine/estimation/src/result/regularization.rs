//! Regularisation: its effect, the choices of its criteria, and its bias.

use super::representative::RepresentativeReport;
use crate::spec::{Criterion, Scheme};

/// Kind of a regularisation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegularizationKind {
    /// Least squares as it is.
    None,
    /// The paper's matrix B (Eqs. 27–40).
    Spectral,
    /// Ridge regression.
    Ridge,
    /// A penalty on roughness.
    Tikhonov,
    /// Truncated singular value decomposition.
    TruncatedSvd,
    /// Shrinkage by a factor that the data give (James and Stein).
    JamesStein,
    /// Shrinkage towards a target.
    Attraction,
    /// The matrix B of a representative piece.
    Representative,
}

/// What regularisation did, and what other criteria would have chosen.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     result::RegularizationKind,
///     spec::{Model, Regularization},
/// };
///
/// let rows = vec![1.0, 1.0, 0.0, 1.0, 1.01, 1.0, 1.0, 0.99, 2.0, 1.0, 1.0, 3.0];
/// let nodes = Nodes::matrix(rows, 3, vec![2.0, 3.0, 4.1, 5.0], None, None)?;
/// let regularization = Regularization::TruncatedSvd { rank: 2 };
/// let report =
///     fit(&nodes, &FitSpec { regularization, ..FitSpec::new(Model::Linear) })?.regularization;
/// assert_eq!((report.kind, report.rank), (RegularizationKind::TruncatedSvd, Some(2)));
/// // Eigenvalues ascend: what is left out belongs to the smallest one.
/// assert_eq!(report.filter_factors, [0.0, 1.0, 1.0]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct RegularizationReport {
    /// Kind of the regularisation.
    pub kind: RegularizationKind,
    /// Scheme of the spectral kind; `None` for the others.
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
    /// Whether the parameter is the caller's own.
    pub fixed: bool,
    /// fᵢ of each direction, from 0 (suppressed) to 1 (as in least squares), by ascending
    /// eigenvalues; those of Tikhonov belong to directions of matrix and penalty together. With a
    /// prior the share of the nodes in each direction in which nodes and prior are independent,
    /// ascending; with constraints 0 for every direction that is held.
    pub filter_factors: Vec<f64>,
    /// Eq. 41.
    pub matrix_norm_squared: Option<f64>,
    /// Ineq. 48.
    pub largest_eigenvalue_bound: Option<f64>,
    /// Mean squared error of the coefficients in the scaled columns, predicted as in [`Choice`] and
    /// corrected by simulation for λ* having been chosen by the same nodes; present when
    /// `predicted_mse` was included and the regularisation is a filter.
    pub predicted_mse_corrected: Option<f64>,
    /// How the representative piece suits the nodes, whose matrix B it is.
    pub representative: Option<RepresentativeReport>,
    /// Plain least squares and every criterion that has an answer, side by side. Of Tikhonov with
    /// more than 64 coefficients the least condition is sought where it is asked for or the curve
    /// is included.
    pub choices: Vec<Choice>,
}

/// What one criterion would choose.
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// `None` is plain least squares.
    pub criterion: Option<Criterion>,
    /// λ* or k that it chooses; `None` for plain least squares.
    pub lambda_star: Option<f64>,
    /// Condition of the regularised Fisher information matrix; `None` where it is singular.
    pub condition: Option<f64>,
    /// ‖Â − Â_B‖ in the scaled columns.
    pub bias_norm: f64,
    /// Mean squared error of the coefficients in the scaled columns, predicted from an estimate
    /// less its noise: variance and squared bias; `None` without σ.
    pub predicted_mse: Option<f64>,
    /// √(Σ w r² / Σ w) of the regularised estimate.
    pub rms: f64,
}

/// Where r came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NormLimitSource {
    /// The caller's own.
    Request,
    /// ‖Â‖.
    Estimate,
    /// What the heights speak for ([`crate::spec::ExpectedSize::OfHeights`]).
    Heights,
    /// Limits of the coefficients ([`crate::spec::ExpectedSize::Within`]).
    Limits,
    /// The spread of a prior: r is the root mean square distance from its mean.
    Prior,
}

impl NormLimitSource {
    /// Stable name.
    pub fn name(self) -> &'static str {
        match self {
            NormLimitSource::Request => "request",
            NormLimitSource::Estimate => "estimate",
            NormLimitSource::Heights => "heights",
            NormLimitSource::Limits => "limits",
            NormLimitSource::Prior => "prior",
        }
    }
}

/// How far regularisation has moved the estimate, and how far it can have.
#[derive(Clone, Debug, PartialEq)]
pub struct BiasReport {
    /// Observed ‖Â − Â_B‖ in the scaled columns.
    pub norm: f64,
    /// r max(1 − fᵢ), the sharp bound on the norm of the bias in the scaled columns where ‖A‖ ≤ r;
    /// with a prior where `eᵀP⁻¹e ≤ n` of the distance e from its mean, P being its covariance.
    pub sharp_bound: f64,
    /// Ineq. 51; `None` for ridge and for n = 1, where it does not hold.
    pub paper_bound: Option<f64>,
    /// r, the norm that the true coefficients are taken to have at most, in the scaled columns;
    /// with a prior the root mean square distance from its mean.
    pub coefficient_norm_limit: f64,
    /// Where r came from.
    pub coefficient_norm_limit_source: NormLimitSource,
    /// What ‖A‖ stays below with about the level of the intervals, by least squares and its
    /// errors; beside an r that is the norm of the estimate. Not used for any bound.
    pub upper_confidence: Option<f64>,
    /// The small number e of Ineq. 51, read as max cᵢ.
    pub e: Option<f64>,
}

/// The figures that criteria look at, at one value of the parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct LambdaCurvePoint {
    /// λ* or k.
    pub lambda_star: f64,
    /// Condition of the regularised Fisher information matrix; `None` where it is singular.
    pub condition: Option<f64>,
    /// ‖Â − Â_B‖ in the scaled columns.
    pub bias_norm: f64,
    /// Mean squared error of the coefficients, predicted as in [`Choice::predicted_mse`].
    pub predicted_mse: Option<f64>,
    /// √(Σ w r² / Σ w).
    pub rms: f64,
    /// The generalised cross-validation function; `None` where no degrees of freedom are left.
    pub gcv: Option<f64>,
    /// ‖Â_B‖ in the scaled columns.
    pub coefficient_norm: f64,
}

/// The coefficients at one k.
#[derive(Clone, Debug, PartialEq)]
pub struct RidgeTracePoint {
    /// Ridge parameter.
    pub k: f64,
    /// In the caller's terms and order.
    pub coefficients: Vec<f64>,
}
