//! The parts of a fit's answer. Names and meanings are the contract's.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

pub use super::regularization::*;

/// One coefficient; exactly one of `powers`, `index` and `column` is there.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Coefficient)]
pub struct CoefficientBody {
    /// Readable name.
    #[schema(example = "u^2*v")]
    pub term: String,
    /// Degrees of a polynomial term: one for a curve, two for a surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(example = json!([2, 1]))]
    pub powers: Option<Vec<usize>>,
    /// Indices of a B-spline, from 0: one for a curve, two for a surface.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub index: Option<Vec<usize>>,
    /// Column of a measurement matrix, from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub column: Option<usize>,
    /// The estimator asked for, regularised: Â_B (Eq. 29).
    pub value: f64,
    /// Standard error of `value` for the λ* used, as if it had not been chosen by the same nodes;
    /// absent without degrees of freedom. After a chosen λ* it is too small and leaves the bias
    /// out: in simulations the truth lay within it in 23 to 44 % of the cases, not 68 %
    /// (docs/mathematics-notes.md). `least_squares_std_error` holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub std_error: Option<f64>,
    /// Plain least-squares estimate of the posted nodes, whatever the estimator.
    pub least_squares: f64,
    /// Standard error of `least_squares`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least_squares_std_error: Option<f64>,
    /// Sharp bound on the bias |Â − Â_B| of this coefficient, given r.
    pub bias_bound: f64,
}

/// Eigenvalues of the scaled Fisher information matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Spectrum)]
pub struct SpectrumBody {
    /// Ascending.
    pub eigenvalues: Vec<f64>,
    /// λₙ/λ₁; absent when the rank is not full.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// Decimal logarithm of the condition number.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log10_condition: Option<f64>,
    /// Sum of the decimal logarithms of the eigenvalues; left out where one is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log10_determinant: Option<f64>,
    /// Singular values that the arithmetic tells from 0.
    pub rank: usize,
    pub regularized: RegularizedSpectrumBody,
}

/// After regularisation, in the order of the directions that the eigenvalues came from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = RegularizedSpectrum)]
pub struct RegularizedSpectrumBody {
    /// What each eigenvalue has become.
    pub eigenvalues: Vec<f64>,
    /// Greatest over least; left out where it is infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// Sum of the decimal logarithms of the eigenvalues; left out where one is 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log10_determinant: Option<f64>,
}

/// Bias of the regularised estimate; norms are in the scaled columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Bias)]
pub struct BiasBody {
    /// Observed ‖Â − Â_B‖.
    pub norm: f64,
    /// The least bound that holds for every coefficient vector within the norm limit.
    pub sharp_bound: f64,
    /// Ineq. 51, where it holds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub paper_bound: Option<f64>,
    /// r, the norm of the coefficients that the bounds allow for, in the scaled columns.
    pub coefficient_norm_limit: f64,
    pub coefficient_norm_limit_source: NormLimitSource,
    /// The small number e of Ineq. 51.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub e: Option<f64>,
}

/// Where r came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum NormLimitSource {
    /// The norm of the least-squares estimate.
    Estimate,
    Request,
    /// What the heights speak for in every direction alike: √n τ with τ² = ‖P y‖²/Σλᵢ, or the norm
    /// of the regularised estimate, if greater.
    Heights,
    /// The limits of the coefficients, or the norm of the regularised estimate, if greater.
    Limits,
}

/// Where a number came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum LimitSource {
    Estimate,
    Request,
}

/// How the columns depend on each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Collinearity)]
pub struct CollinearityBody {
    /// Each column against all others, in the order of the coefficients.
    pub columns: Vec<ColumnBody>,
    /// Pearson correlation of the columns, in coefficient order. Present when `collinearity` was
    /// included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub correlation: Option<Vec<Vec<f64>>>,
    /// Per term, the share of its variance that belongs to each eigenvalue (ascending). Present
    /// when `collinearity` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub variance_proportions: Option<Vec<Vec<f64>>>,
    /// One for each small eigenvalue, the smallest first.
    pub near_dependencies: Vec<NearDependencyBody>,
}

/// Collinearity of one column.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = ColumnCollinearity)]
pub struct ColumnBody {
    /// The column, named as its coefficient.
    pub term: String,
    /// Variance inflation factor 1/(1−R²), centred; absent for the constant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub vif: Option<f64>,
}

/// Columns that nearly depend on each other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = NearDependency)]
pub struct NearDependencyBody {
    /// Of the scaled Fisher information matrix.
    pub eigenvalue: f64,
    /// √(greatest eigenvalue / this one); 30 and more are a matter of concern. Left out where it is
    /// infinite.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition_index: Option<f64>,
    /// The eigenvector: how much of each column takes part. Present when `collinearity` was
    /// included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<Vec<f64>>,
    /// The terms that take part.
    pub terms: Vec<String>,
    /// Cosine of the angle between the two columns, where there are two terms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub cosine: Option<f64>,
    /// What Eq. 26 says the cosine tends to, where there are two terms.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weight_ratio: Option<f64>,
    /// R² of the leading term on the others, where there are more than two.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_squared: Option<f64>,
    /// The same in words.
    pub sentence: String,
}

/// Bounds on the relative error of the coefficients that the nodes' uncertainty causes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Perturbation)]
pub struct PerturbationBody {
    pub least_squares: PerturbationBoundsBody,
    pub regularized: PerturbationBoundsBody,
}

/// Bounds on the relative error of the coefficients, in the scaled columns.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = PerturbationBounds)]
pub struct PerturbationBoundsBody {
    /// Ineq. 22; absent where it does not hold.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub square_bound: Option<f64>,
    /// First-order bound with the residual term.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_order_bound: Option<f64>,
}

/// Residuals Y − X Â_B.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Residuals)]
pub struct ResidualsBody {
    /// Nodes counted.
    pub count: usize,
    /// Nodes counted less coefficients.
    pub degrees_of_freedom: usize,
    /// Σ w r² of the regularised estimate.
    pub rss: f64,
    /// σ̂ of the plain least-squares fit; absent without degrees of freedom.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sigma: Option<f64>,
    /// √(Σ w r² / Σ w), in the unit of the heights.
    pub rms: f64,
    /// Largest |residual|; absent in the answers of a stream, which keeps no nodes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub max_abs: Option<f64>,
    /// About the mean when the constant lies in the span of the columns, about 0 otherwise.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub r_squared: Option<f64>,
    /// Σ w r² of the plain least-squares fit.
    pub least_squares_rss: f64,
    /// One per counted node, in the order posted; present when `residuals` was included.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub values: Option<Vec<f64>>,
    /// The posted node (from 0, grids row by row) of each value; present when some node was left
    /// out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub node_indices: Option<Vec<usize>>,
}

/// What a value of λ* would give.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = LambdaCurvePoint)]
pub struct LambdaCurvePointBody {
    /// Where on the curve, as an eigenvalue of the scaled Fisher information matrix.
    pub lambda_star: f64,
    /// Condition number of the regularised matrix.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub condition: Option<f64>,
    /// ‖Â − Â_B‖ in the scaled columns.
    pub bias_norm: f64,
    /// As in `choices`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub predicted_mse: Option<f64>,
    /// Root mean square of the residuals.
    pub rms: f64,
    /// The function that generalised cross-validation makes least.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gcv: Option<f64>,
    /// ‖Â_B‖ in the scaled columns.
    pub coefficient_norm: f64,
}

/// Arithmetic of the decisive steps.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum ArithmeticName {
    Double,
    DoubleDouble,
}

/// How the numbers were computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Numerics)]
pub struct NumericsBody {
    pub arithmetic: ArithmeticName,
    /// Estimated correct decimal digits of the worst least-squares coefficient; errs on the low
    /// side.
    pub correct_digits: f64,
}

/// What made the answer out of what.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Provenance)]
pub struct ProvenanceBody {
    /// Program and version that computed the answer.
    #[schema(value_type = String, example = "flankfit 0.1.0")]
    pub engine: Cow<'static, str>,
    /// SHA-256 of the canonical form of nodes and spec: the same request gives the same digest
    /// whatever its white space or key order.
    #[schema(min_length = 64, max_length = 64)]
    pub input_sha256: String,
}
