//! Scheme of the eigenvalues of the matrix B.

/// Scheme of the eigenvalues of the matrix B.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Count, DEFAULT_CONDITION_LIMIT, Model, Parameter, Regularization, Scheme},
/// };
///
/// // Two columns of unit length at the cosine c: the eigenvalues are 1 − c and 1 + c.
/// let nodes =
///     Nodes::matrix(vec![1.0, 1.0, 1.0, 1.0, 1.0, 1.1], 2, vec![2.0, 2.1, 2.2], None, None)?;
/// let smallest = |scheme: Scheme| {
///     let regularization = Regularization::Spectral {
///         scheme,
///         count: Count::Auto,
///         condition_limit: DEFAULT_CONDITION_LIMIT,
///         lambda_star: Parameter::Fixed(0.01),
///     };
///     let spectrum =
///         fit(&nodes, &FitSpec { regularization, ..FitSpec::new(Model::Linear) })?.spectrum;
///     Ok::<_, Box<dyn std::error::Error>>((
///         spectrum.eigenvalues[0],
///         spectrum.regularized.eigenvalues[0],
///     ))
/// };
/// let (lambda, exact) = smallest(Scheme::Exact)?;
/// assert!(lambda < 0.002 && (exact - 0.01).abs() < 1e-15);
/// // To first order: λ (1 + c)² with c = (λ* − λ)/(2λ).
/// let (_, first_order) = smallest(Scheme::FirstOrder)?;
/// assert!((first_order - (0.01 + lambda).powi(2) / (4.0 * lambda)).abs() < 1e-12);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Scheme {
    /// cᵢ = (λ* − λᵢ)/(2λᵢ), Eq. 40.
    #[default]
    FirstOrder,
    /// cᵢ = √(λ*/λᵢ) − 1, which makes the regularised eigenvalue λ* exactly.
    Exact,
}
