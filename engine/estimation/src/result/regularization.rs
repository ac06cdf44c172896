//! Regularisation: its effect, the choices of its criteria, and its bias.

use super::representative::RepresentativeReport;
use crate::spec::{ChosenBy, Scheme, regularization::RegularizationKind};

/// The applied regularisation, and the choices of all criteria.
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
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = RegularizationResult)
)]
pub struct RegularizationReport {
    /// Kind of the regularisation.
    #[cfg_attr(feature = "contract", serde(rename = "type"))]
    pub kind: RegularizationKind,
    /// Scheme of the spectral kind; absent for the others.
    pub scheme: Option<Scheme>,
    /// L: how many of the smallest eigenvalues were regularised.
    pub count: Option<usize>,
    /// λ* of the spectral schemes, k of ridge and attraction, λ of Tikhonov; absent without
    /// regularisation and for methods without such a parameter (truncated SVD, James–Stein, an
    /// attraction of infinite weight).
    pub lambda_star: Option<f64>,
    /// Directions that a truncated singular value decomposition keeps.
    pub rank: Option<usize>,
    /// c of James–Stein and attraction: the factor of Â − T.
    pub shrinkage_factor: Option<f64>,
    /// The plateau of minimisers of Eq. 49, where there is one: [lo, hi].
    #[cfg_attr(
        feature = "contract",
        schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2)
    )]
    pub lambda_star_interval: Option<[f64; 2]>,
    /// λ* − λ₁.
    pub gamma: Option<f64>,
    /// Criterion that chose λ*; absent without regularisation.
    pub criterion: Option<ChosenBy>,
    /// Factor of each direction: 1 is not regularised. In the order of `spectrum.eigenvalues`; for
    /// Tikhonov the directions are those of matrix and penalty together, the most penalised first.
    /// With a `prior` the share of the nodes in the information along each direction in which nodes
    /// and prior are independent, the smallest first; the rest is the prior's. With `constraints`
    /// first a 0 for each direction fixed by active places, then 1 for the others.
    pub filter_factors: Vec<f64>,
    /// ‖B‖² (Eq. 41).
    pub matrix_norm_squared: Option<f64>,
    /// Ineq. 48.
    pub largest_eigenvalue_bound: Option<f64>,
    /// Mean squared error of the coefficients in the scaled columns: `predicted_mse` of the applied
    /// choice, corrected by simulation for having been chosen from the same nodes. With `min_mse`
    /// of the matrix B and ridge its mean is 0.78 to 1.22 times the true error in 144 simulated
    /// cases with three degrees of freedom or more; the uncorrected figure is 0.28 to 1.03 times it
    /// (docs/explanation/choosing-lambda.md). A single figure scatters by once to twice its size,
    /// and most are far below the true error: see `squared_error_interval`. Other criteria, and
    /// Tikhonov, were not simulated. Present with `include` of `predicted_mse`; not with `press`,
    /// `blocked_cv`, truncated SVD, James–Stein and attraction.
    pub predicted_mse_corrected: Option<f64>,
    /// Interval of the squared error of the coefficients in the scaled columns at `level`, `[low,
    /// high]`, which holds at least that often however λ* was chosen. Present with `include` of
    /// `predicted_mse`, for filters on the eigenvectors and least squares, if there is an
    /// estimate of the noise and the nodes determine every coefficient.
    #[cfg_attr(feature = "contract", schema(min_items = 2, max_items = 2))]
    pub squared_error_interval: Option<[f64; 2]>,
    /// Present for `representative`.
    pub representative: Option<RepresentativeReport>,
    /// Least squares, the requested criterion and the criteria that are cheap to compute, for
    /// comparison. For Tikhonov with more than 64 coefficients `min_condition` is included only
    /// on request, or with `lambda_curve`.
    pub choices: Vec<Choice>,
}

/// The choice of one criterion.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct Choice {
    /// The criterion, or `least_squares`.
    pub criterion: ChosenBy,
    /// The λ* that the criterion would choose, as an eigenvalue of the scaled Fisher
    /// information matrix.
    pub lambda_star: Option<f64>,
    /// Condition number of the regularised matrix; absent where it is infinite.
    pub condition: Option<f64>,
    /// ‖Â − Â_B‖ in the scaled columns.
    pub bias_norm: f64,
    /// Predicted mean squared error of the coefficients in the scaled columns: good for comparing
    /// criteria on the same nodes. That of the chosen one is mostly too small: 0.42 of the true
    /// error in simulations of one flank (docs/explanation/mathematics.md), 0.28 to 1.03 over other
    /// cases (docs/explanation/choosing-lambda.md).
    pub predicted_mse: Option<f64>,
    /// Root mean square of the residuals, in the unit of the heights.
    pub rms: f64,
}

/// Source of r.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum NormLimitSource {
    /// The caller's own.
    Request,
    /// The norm of the least-squares estimate.
    Estimate,
    /// Norm that the heights suggest if all directions are alike: √n τ with τ² = ‖P y‖²/Σλᵢ, or the
    /// norm of the regularised estimate, if greater.
    Heights,
    /// The limits of the coefficients, or the norm of the regularised estimate, if greater.
    Limits,
    /// The spread of the prior: the root of its total variance in the scaled columns.
    Prior,
}

impl NormLimitSource {}

/// Bias of the regularised estimate; norms are in the scaled columns.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Bias)
)]
pub struct BiasReport {
    /// Observed ‖Â − Â_B‖.
    pub norm: f64,
    /// The smallest bound that holds for every coefficient vector within the norm limit.
    pub sharp_bound: f64,
    /// Bound by Ineq. 51, where it holds.
    pub paper_bound: Option<f64>,
    /// r, the norm of the coefficients that the bounds allow for, in the scaled columns; with a
    /// prior the root mean square distance from its mean.
    pub coefficient_norm_limit: f64,
    /// Source of r.
    pub coefficient_norm_limit_source: NormLimitSource,
    /// Upper confidence limit of the norm of the true coefficients, by least squares and its
    /// errors. A first-order expansion, with a coverage below `level` (at 0.95 at worst 86 % of
    /// the draws of simulations). Present where r is the norm of the estimate and the fit is
    /// regularised; no bound uses it.
    pub upper_confidence: Option<f64>,
    /// The small number e of Ineq. 51.
    pub e: Option<f64>,
}

/// Figures for one value of λ*.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct LambdaCurvePoint {
    /// λ*, as an eigenvalue of the scaled Fisher information matrix.
    pub lambda_star: f64,
    /// Condition number of the regularised matrix.
    pub condition: Option<f64>,
    /// ‖Â − Â_B‖ in the scaled columns.
    pub bias_norm: f64,
    /// Same as in `choices`.
    pub predicted_mse: Option<f64>,
    /// Root mean square of the residuals.
    pub rms: f64,
    /// The function that generalised cross-validation makes least.
    pub gcv: Option<f64>,
    /// ‖Â_B‖ in the scaled columns.
    pub coefficient_norm: f64,
}

/// The coefficients of ridge at one k.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema))]
pub struct RidgeTracePoint {
    /// The constant added to the eigenvalues of the scaled Fisher information matrix.
    pub k: f64,
    /// In the terms of the request, in the order of `coefficients`.
    pub coefficients: Vec<f64>,
}
