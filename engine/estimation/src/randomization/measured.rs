//! A study's matrix and, where it is not given, its A from measured nodes.

use crate::{
    data::{Nodes, Sample},
    design::{Design, Row},
    error::FitError,
    fit::fit,
    spec::{FitSpec, Regularization},
};
use flankfit_numerics::{Dd, Real, Rows};

/// Parts of a study given by nodes and a model.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes,
///     randomization::Measured,
///     spec::{Degree, Model, PolynomialBasis, Terms},
/// };
///
/// let nodes = Nodes::curve(vec![0.0, 1.0, 2.0, 3.0], vec![1.0, 3.0, 5.0, 7.0], None)?;
/// let model = Model::Polynomial {
///     degree: Degree::Both(1),
///     basis: PolynomialBasis::Monomial,
///     terms: Terms::Tensor,
/// };
/// let measured = Measured::new(&nodes, &FitSpec::new(model))?;
/// assert_eq!(&measured.x[3], [1.0, 3.0]);
/// assert!((measured.coefficients[1] - 2.0).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// Rows of the measurement matrix in the caller's columns, rounded to doubles; those of a
    /// weighted node times √weight.
    pub x: Rows,
    /// Names of the columns.
    pub labels: Vec<String>,
    /// The least-squares estimate of the nodes' heights.
    pub coefficients: Vec<f64>,
    /// σ̂ of that fit; `None` without degrees of freedom.
    pub sigma: Option<f64>,
}

impl Measured {
    /// Evaluates the model of `spec` at the counted nodes and fits it to their heights.
    pub fn new(nodes: &Nodes, spec: &FitSpec) -> Result<Self, FitError> {
        let plain = FitSpec { regularization: Regularization::None, filters: Vec::new(), ..spec.clone() };
        let fitted = fit(nodes, &plain)?;
        let sample = Sample::new(nodes);
        let design = Design::new(nodes, &sample, spec)?;
        let change = design.change_of_basis();
        let n = design.size();
        let mut row = Row::<Dd>::new(&design);
        let x = (0..sample.count())
            .map(|k| {
                row.at(&design, &sample, k);
                let root = sample.w(k).sqrt();
                let entry = |j: usize| {
                    let terms = row.index.iter().zip(&row.values);
                    root * terms.fold(Dd::ZERO, |sum, (&i, &w)| w.fma(change[(i, j)], sum)).to_f64()
                };
                (0..n).map(entry).collect::<Vec<f64>>()
            })
            .collect();
        Ok(Measured {
            x,
            labels: design.labels,
            coefficients: fitted.coefficients.iter().map(|c| c.least_squares).collect(),
            sigma: fitted.residuals.sigma,
        })
    }
}
