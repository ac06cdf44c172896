//! Linear dependence of the columns.

use crate::spec::PolynomialBasis;

/// Linear dependence of the columns.
///
/// ```
/// use flankfit_estimation::{FitSpec, Nodes, fit, spec::Model};
///
/// // Columns at an angle of 0.02 rad: their condition index is cot 0.01.
/// let angle = 0.02_f64;
/// let rows = vec![1.0, angle.cos(), 0.0, angle.sin(), 0.0, 0.0];
/// let names = Some(vec!["crowning".to_owned(), "twist".to_owned()]);
/// let found = fit(
///     &Nodes::matrix(rows, 2, vec![1.0, 0.1, 0.0], names, None)?,
///     &FitSpec::new(Model::Linear),
/// )?;
/// let near = &found.collinearity.near_dependencies[0];
/// assert_eq!(near.terms.len(), 2);
/// assert!(near.condition_index.is_some_and(|index| (index * 0.01_f64.tan() - 1.0).abs() < 1e-9));
/// assert!(near.cosine.is_some_and(|cosine| (cosine - angle.cos()).abs() < 1e-12));
/// println!("{}", near.sentence);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = Collinearity)
)]
pub struct CollinearityReport {
    /// The same columns in an orthonormal polynomial basis, which shows whether a dependency is due
    /// to the nodes or the basis. Absent for models without polynomials.
    pub basis: Option<OrthonormalBasis>,
    /// Each column against all others, in the order of the coefficients.
    pub columns: Vec<ColumnCollinearity>,
    /// Pearson correlation of the columns, in coefficient order. Present when `collinearity`
    /// was included.
    pub correlation: Option<Vec<Vec<f64>>>,
    /// Per term, the share of its variance that belongs to each eigenvalue (ascending). Present
    /// when `collinearity` was included.
    pub variance_proportions: Option<Vec<Vec<f64>>>,
    /// One for each small eigenvalue, the smallest first.
    pub near_dependencies: Vec<NearDependency>,
}

/// The space of the columns in Legendre's basis over the domain, which is orthonormal there.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    schema(as = CollinearityBasis)
)]
pub struct OrthonormalBasis {
    /// Legendre's.
    #[cfg_attr(feature = "contract", serde(rename = "type"))]
    pub kind: PolynomialBasis,
    /// Condition of the Fisher information matrix of these columns at unit length, as
    /// `spectrum.condition` is of the requested ones; absent if the nodes leave some function
    /// undetermined.
    pub condition: Option<f64>,
}

/// Cause of a near dependency: `basis`, the columns are independent in Legendre's basis over
/// the domain; `nodes`, the nodes cannot separate them in any basis, or there is no other
/// basis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case"),
    schema(as = DependencyCause)
)]
pub enum Cause {
    /// The basis: in Legendre's basis over the domain there is no such dependency.
    Basis,
    /// The nodes: in any basis they do not distinguish some function of the model from 0.
    Nodes,
}

/// Collinearity of one column.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct ColumnCollinearity {
    /// The column, named as its coefficient.
    pub term: String,
    /// Variance inflation factor 1/(1−R²), centred; absent for the constant.
    pub vif: Option<f64>,
}

/// A near linear dependency of columns.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    serde_with_macros::skip_serializing_none,
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema)
)]
pub struct NearDependency {
    /// Eigenvalue of the scaled Fisher information matrix.
    pub eigenvalue: f64,
    /// √(greatest eigenvalue / this one); 30 and more are a matter of concern. Absent where it is
    /// infinite.
    pub condition_index: Option<f64>,
    /// The eigenvector, with one entry for each column. Present with `include` of
    /// `collinearity`.
    pub weights: Option<Vec<f64>>,
    /// The terms in the dependency.
    pub terms: Vec<String>,
    /// Cosine of the angle between the two columns, where there are two terms.
    pub cosine: Option<f64>,
    /// For two terms: the limit of the cosine by Eq. 26.
    pub weight_ratio: Option<f64>,
    /// R² of the leading term on the others, where there are more than two.
    pub r_squared: Option<f64>,
    /// Cause of the dependency: the nodes, or a basis in place of which another would remove it.
    pub cause: Cause,
    /// The same in words.
    pub sentence: String,
}
