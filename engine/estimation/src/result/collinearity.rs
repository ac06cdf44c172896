//! Linear dependence of the columns.

/// Collinearity of the columns of X: condition indices, variance inflation and near dependencies.
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
pub struct CollinearityReport {
    /// The same columns in Legendre's basis over the domain; `None` for models that are not made of
    /// polynomials.
    pub basis: Option<OrthonormalBasis>,
    /// One entry for each column, in the order of the coefficients.
    pub columns: Vec<ColumnCollinearity>,
    /// Pearson correlation of the columns, in coefficient order; `None` beyond the size limit
    /// unless included.
    pub correlation: Option<Vec<Vec<f64>>>,
    /// Per term, the share of its variance that belongs to each eigenvalue (ascending).
    pub variance_proportions: Option<Vec<Vec<f64>>>,
    /// Directions with a condition index above 30 (Belsley's rule), the smallest eigenvalue first;
    /// at most 100.
    pub near_dependencies: Vec<NearDependency>,
}

/// The column space in a basis that is orthonormal over the domain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrthonormalBasis {
    /// λₙ/λ₁ of the Fisher information matrix of unit-length columns; `None` if they are linearly
    /// dependent.
    pub condition: Option<f64>,
}

/// Cause of a near dependency between columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// The basis: in Legendre's basis over the domain there is no such dependency.
    Basis,
    /// The nodes: in any basis they do not distinguish some function of the model from 0.
    Nodes,
}

/// How far one column is explained by the others.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnCollinearity {
    /// Name of the term.
    pub term: String,
    /// 1/(1−R²), centred; `None` for the constant.
    pub vif: Option<f64>,
}

/// A direction along which some columns almost cancel, so that heights say little about it.
#[derive(Clone, Debug, PartialEq)]
pub struct NearDependency {
    /// Eigenvalue λᵢ of the Fisher information matrix of unit-length columns.
    pub eigenvalue: f64,
    /// √(λₙ/λᵢ); `None` where λᵢ is numerically zero.
    pub condition_index: Option<f64>,
    /// The eigenvector: how much of each unit-length column takes part.
    pub weights: Vec<f64>,
    /// Terms that take part, the leading one first.
    pub terms: Vec<String>,
    /// cos of the angle between the two columns, where there are two terms.
    pub cosine: Option<f64>,
    /// −v_i/v_j, which Eq. 26 says the cosine tends to, where there are two terms.
    pub weight_ratio: Option<f64>,
    /// R² of the leading term on the others, where there are more than two.
    pub r_squared: Option<f64>,
    /// Whether it would disappear in another basis.
    pub cause: Cause,
    /// The same in words, with the figures that it rests on.
    pub sentence: String,
}
