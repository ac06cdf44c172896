//! The matrix B of a representative piece, for others (section 6.3).

use super::{
    model::{Domain, Model},
    scheme::Scheme,
};

/// The matrix B that measurements on a representative piece gave, for others in the same directions
/// (section 6.3): `X̄ = X (1 + Σ cᵢVᵢVᵢᵀ)` with X of the nodes of now, and V, λ* and L of the
/// piece.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{
///         Criterion, Include, Model, Parameter, PieceOf, Regularization, Representative,
///     },
/// };
///
/// // Two settings of a machine that do nearly the same, on two teeth.
/// let rows = vec![1.0, 1.0, 2.0, 2.1, 3.0, 2.9, 4.0, 4.1];
/// let tooth = |heights: Vec<f64>| Nodes::matrix(rows.clone(), 2, heights, None, None);
/// let include = Include { representative: true, ..Include::default() };
/// let spec = FitSpec { include, ..FitSpec::new(Model::Linear) };
/// let first = fit(&tooth(vec![2.0, 4.2, 5.8, 8.1])?, &spec)?;
/// let piece = first.representative.expect("one eigenvalue is small");
/// assert_eq!((piece.directions.len(), piece.directions[0].len()), (1, 2));
///
/// // At the same places the piece's directions are one's own: as if its λ* had been given.
/// let by_piece = |piece| Regularization::Representative(Representative {
///     of: PieceOf { iteration: None, fit_id: None },
///     piece: Some(Box::new(piece)),
/// });
/// let second = tooth(vec![2.1, 3.9, 6.2, 8.0])?;
/// let found = fit(&second, &FitSpec { regularization: by_piece(piece.clone()), ..spec.clone() })?;
/// let lambda_star = Parameter::Fixed(piece.lambda_star);
/// let own = match Regularization::default() {
///     Regularization::Spectral { scheme, count, condition_limit, .. } => {
///         Regularization::Spectral { scheme, count, condition_limit, lambda_star }
///     }
///     other => other,
/// };
/// let own = fit(&second, &FitSpec { regularization: own, ..spec })?;
/// for (a, b) in found.coefficients.iter().zip(&own.coefficients) {
///     assert!((a.value - b.value).abs() < 1e-12 && (a.bias_bound - b.bias_bound).abs() < 1e-12);
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Representative {
    /// Source of the piece.
    pub of: PieceOf,
    /// The piece itself; `None` before it is looked up, and then there is no fit.
    pub piece: Option<Box<Piece>>,
}

/// The stored fit that a piece is of; passed through to the report.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct PieceOf {
    /// The iteration of the job that the piece is; absent where it was posted.
    pub iteration: Option<u32>,
    /// The fit of it; the current one by default.
    pub fit_id: Option<String>,
}

/// The data of a regularised fit that other fits use.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(deny_unknown_fields),
    schema(as = RepresentativePiece)
)]
pub struct Piece {
    /// The model that was fitted.
    pub model: Model,
    /// Domain of the fit; absent for a measurement matrix.
    #[cfg_attr(feature = "contract", serde(skip_serializing_if = "Option::is_none"))]
    pub domain: Option<Domain>,
    /// Rule that makes cᵢ of λᵢ and λ*. Default `first_order`.
    #[cfg_attr(feature = "contract", serde(default))]
    pub scheme: Scheme,
    /// λ*.
    #[cfg_attr(feature = "contract", schema(exclusive_minimum = 0))]
    pub lambda_star: f64,
    /// λ₁ … λ_L of the piece, ascending.
    #[cfg_attr(feature = "contract", schema(min_items = 1))]
    pub eigenvalues: Vec<f64>,
    /// V₁ … V_L, orthonormal, each with an entry for each coefficient, in the piece's scaled
    /// columns.
    #[cfg_attr(feature = "contract", schema(min_items = 1))]
    pub directions: Vec<Vec<f64>>,
    /// Divisor of each column of the piece, above 0.
    #[cfg_attr(feature = "contract", schema(min_items = 1))]
    pub scale: Vec<f64>,
}

impl Piece {
    /// cᵢ of Eq. 40, or of the exact scheme; 0 for an eigenvalue above λ*.
    pub fn coefficient(&self, i: usize) -> f64 {
        let lambda = self.eigenvalues[i];
        let c = match self.scheme {
            Scheme::FirstOrder => (self.lambda_star - lambda) / (2.0 * lambda),
            Scheme::Exact => (self.lambda_star / lambda).sqrt() - 1.0,
        };
        c.max(0.0)
    }
}
