//! The functions whose mixture is fitted, and how their columns are scaled.

#[cfg(feature = "contract")]
use flankfit_numerics::contract::{list, names, whole};

#[cfg(feature = "contract")]
use super::form;
pub use flankfit_geometry::axes::{Degree, Domain, Spans};

/// The functions whose mixture is fitted.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, fit,
///     spec::{Degree, Knots, Model, PolynomialBasis, Terms},
/// };
///
/// let axis: Vec<f64> = (0..9).map(f64::from).collect();
/// let nodes = Nodes::grid(axis.clone(), axis.clone(), vec![1.0; 81], None, None)?;
/// let coefficients = |model: Model| {
///     Ok::<usize, Box<dyn std::error::Error>>(
///         fit(&nodes, &FitSpec::new(model))?.coefficients.len(),
///     )
/// };
///
/// // Every product u^i v^j up to degree 3 and 2, or those up to a degree of 3 together.
/// let polynomial =
///     |degree, terms| Model::Polynomial { degree, basis: PolynomialBasis::Legendre, terms };
/// assert_eq!(coefficients(polynomial(Degree::Each(3, 2), Terms::Tensor))?, 4 * 3);
/// assert_eq!(coefficients(polynomial(Degree::Both(3), Terms::Total))?, 10);
/// // Cubic B-splines over three spans along u and two along v.
/// let splines =
///     Model::BSpline { degree: Degree::Both(3), knots: Knots::SpansEach(3, 2), weights: None };
/// assert_eq!(coefficients(splines)?, (3 + 3) * (2 + 3));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize),
    serde(try_from = "form::Model", into = "form::Model")
)]
pub enum Model {
    /// Polynomials on one or two axes.
    Polynomial {
        /// Highest degree on each axis.
        degree: Degree,
        /// Polynomials that the coefficients belong to.
        basis: PolynomialBasis,
        /// Products that take part on a surface.
        terms: Terms,
    },
    /// B-splines, or NURBS with given weights (Eqs. 7–9).
    BSpline {
        /// Degree on each axis.
        degree: Degree,
        /// Knots on each axis.
        knots: Knots,
        /// Weights of NURBS: one weight > 0 per control point (for a surface v running fastest).
        /// They are given, not fitted.
        weights: Option<Vec<f64>>,
    },
    /// The columns of a measurement matrix as they are.
    Linear,
}

/// Functions of a polynomial model. `monomial` uses raw u and v; the others use the domain mapped
/// to [-1, 1]. The estimate is always computed in Chebyshev polynomials.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum PolynomialBasis {
    /// Powers of the caller's raw u and v.
    #[default]
    Monomial,
    /// Chebyshev polynomials on the domain mapped to [-1, 1].
    Chebyshev,
    /// Legendre polynomials on the domain mapped to [-1, 1].
    Legendre,
}

/// Products of powers of u and v that a surface has.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "contract", derive(serde::Serialize, serde::Deserialize), serde(untagged))]
pub enum Terms {
    /// Every product up to the degree of each axis.
    #[default]
    #[cfg_attr(feature = "contract", serde(with = "tensor"))]
    Tensor,
    #[cfg_attr(feature = "contract", serde(with = "total"))]
    /// Products whose degrees add up to at most the degree.
    Total,
    /// These, as degrees along u and v, each with all products that divide it; of surfaces.
    Listed(Vec<[usize; 2]>),
}

/// Knots of B-splines (full vectors, the last span closed on the right) or a count of equal spans
/// over the domain.
#[derive(Clone, Debug, PartialEq)]
pub enum Knots {
    /// A full knot vector for a curve.
    Curve(Vec<f64>),
    /// A full knot vector for u and one for v.
    Surface(Vec<f64>, Vec<f64>),
    /// The same number of equal spans on every axis.
    Spans(usize),
    /// Equal spans, a number for each axis.
    SpansEach(usize, usize),
}

/// Scaling of X's columns before the eigen analysis; default `unit_length`, `none` is the paper's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
#[cfg_attr(
    feature = "contract",
    derive(serde::Serialize, serde::Deserialize, utoipa::ToSchema),
    serde(rename_all = "snake_case")
)]
pub enum Scaling {
    /// Every column divided by its Euclidean length.
    #[default]
    UnitLength,
    /// The paper's: as they are.
    None,
    /// Centred and divided by √mean((x−x̄)²), the constant not penalised.
    Standardized,
}

#[cfg(feature = "contract")]
flankfit_numerics::constant!(tensor = "tensor");
#[cfg(feature = "contract")]
flankfit_numerics::constant!(total = "total");

#[cfg(feature = "contract")]
flankfit_numerics::alternatives!(
    Terms = "tensor",
    "`tensor`: every product up to the degree of each axis; `total`: those whose degrees add up to at most the \
     degree; or a list of products of a surface, as degrees along u and v within `degree`, each with all its divisors: \
     `[[0, 0], [1, 0], [0, 1]]`.",
    names(["tensor", "total"]),
    list(list(whole(0), Some((2, 2))), None),
);
