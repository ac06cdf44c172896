//! Decides from the request whether a fit is short.
//!
//! The cost of a fit grows as m·n (rows of the measurement matrix read, residuals) and n³ (the
//! spectrum and what is made of it). Short ones take some hundred microseconds at most, less than
//! handing them to another thread costs under load. What is not among the usual ways of a fit is
//! never called short: something new is long until it is said here that it is not.

use crate::{
    data::Nodes,
    spec::{Criterion, Degree, FitSpec, Include, Knots, Model, Regularization},
};

/// Most coefficients of a short fit.
const MOST_COLUMNS: usize = 25;

/// Most entries of its measurement matrix.
const MOST_ENTRIES: usize = 20_000;

/// True if fitting `spec` to `nodes` takes a fraction of a millisecond.
///
/// ```
/// use flankfit_estimation::{
///     FitSpec, Nodes, is_short,
///     spec::{Estimator, Model},
/// };
///
/// let nodes =
///     Nodes::matrix(vec![1.0, 0.0, 1.0, 1.0, 1.0, 2.0], 2, vec![0.0, 1.0, 3.0], None, None)?;
/// let spec = FitSpec::new(Model::Linear);
/// assert!(is_short(&nodes, &spec));
/// assert!(!is_short(&nodes, &FitSpec { estimator: Estimator::Rank, ..spec }));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn is_short(nodes: &Nodes, spec: &FitSpec) -> bool {
    let columns = columns(nodes, &spec.model);
    columns <= MOST_COLUMNS && columns.saturating_mul(nodes.posted()) <= MOST_ENTRIES && is_usual(spec)
}

/// Least squares with the regularisations that are closed forms on the spectrum. All members not
/// named here must have their default.
fn is_usual(spec: &FitSpec) -> bool {
    let usual = FitSpec {
        scaling: spec.scaling,
        regularization: spec.regularization.clone(),
        domain: spec.domain,
        coefficient_norm_limit: spec.coefficient_norm_limit,
        noise_sigma: spec.noise_sigma,
        // positions that are off are sought
        node_uncertainty: spec.node_uncertainty.filter(|uncertainty| uncertainty.position == 0.0),
        level: spec.level,
        include: Include { residuals: spec.include.residuals, ..Include::default() },
        ..FitSpec::new(spec.model.clone())
    };
    *spec == usual
        // looks at every node for every λ*
        && !spec.regularization.criterion().is_some_and(Criterion::is_nodewise)
        && matches!(
            spec.regularization,
            Regularization::None | Regularization::Spectral { .. } | Regularization::Ridge { .. }
        )
}

/// Coefficients of the model, or a few more.
fn columns(nodes: &Nodes, model: &Model) -> usize {
    let product = |u: usize, v: usize| if matches!(nodes, Nodes::Curve(_)) { u } else { u.saturating_mul(v) };
    let each = |degree: Degree| match degree {
        Degree::Both(p) => (p, p),
        Degree::Each(p, q) => (p, q),
    };
    match model {
        Model::Linear => match nodes {
            Nodes::Matrix(matrix) => matrix.columns,
            _ => usize::MAX,
        },
        Model::Polynomial { degree, .. } => {
            let (p, q) = each(*degree);
            product(p.saturating_add(1), q.saturating_add(1))
        }
        Model::BSpline { degree, knots, .. } => {
            let (p, q) = each(*degree);
            match knots {
                Knots::Curve(knots) => knots.len(),
                Knots::Surface(u, v) => product(u.len(), v.len()),
                Knots::Spans(spans) => product(p.saturating_add(*spans), q.saturating_add(*spans)),
                Knots::SpansEach(u, v) => product(p.saturating_add(*u), q.saturating_add(*v)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::spec::{Count, Parameter, PolynomialBasis, Scheme, Terms};

    fn polynomial(degree: Degree) -> FitSpec {
        FitSpec::new(Model::Polynomial { degree, basis: PolynomialBasis::Monomial, terms: Terms::Tensor })
    }

    fn grid(nu: usize, nv: usize) -> Nodes {
        let axis = |n: usize| (0..n).map(|i| i as f64).collect::<Vec<_>>();
        Nodes::grid(axis(nu), axis(nv), vec![0.0; nu * nv], None, None).unwrap()
    }

    #[test]
    fn the_size_of_the_matrix_decides() {
        assert!(is_short(&grid(5, 9), &polynomial(Degree::Both(3))));
        assert!(is_short(&grid(25, 40), &polynomial(Degree::Each(3, 3))));
        assert!(!is_short(&grid(50, 50), &polynomial(Degree::Both(3))));
        assert!(!is_short(&grid(50, 50), &polynomial(Degree::Both(5))));
        let huge = polynomial(Degree::Both(usize::MAX));
        assert!(!is_short(&grid(2, 2), &huge));
        let curve = Nodes::curve(vec![0.0; 1000], vec![0.0; 1000], None).unwrap();
        assert!(is_short(&curve, &polynomial(Degree::Each(10, 50))));
        let splines =
            |spans| FitSpec::new(Model::BSpline { degree: Degree::Both(3), knots: Knots::Spans(spans), weights: None });
        assert!(is_short(&grid(5, 9), &splines(2)));
        assert!(!is_short(&grid(5, 9), &splines(3)));
        assert!(!is_short(&curve, &FitSpec::new(Model::Linear)));
        let matrix = Nodes::matrix(vec![1.0; 60], 3, vec![0.0; 20], None, None).unwrap();
        assert!(is_short(&matrix, &FitSpec::new(Model::Linear)));
    }

    #[test]
    fn costly_criteria_and_includes_are_not_short() {
        let nodes = grid(5, 9);
        let usual = FitSpec {
            regularization: Regularization::Spectral {
                scheme: Scheme::Exact,
                count: Count::Given(2),
                condition_limit: 30.0,
                lambda_star: Parameter::Criterion(Criterion::Gcv),
            },
            noise_sigma: Some(1e-3),
            include: Include { residuals: true, ..Include::default() },
            ..polynomial(Degree::Both(3))
        };
        assert!(is_short(&nodes, &usual));
        let press = Regularization::Ridge { parameter: Parameter::Criterion(Criterion::Press) };
        assert!(!is_short(&nodes, &FitSpec { regularization: press, ..usual.clone() }));
        let include = Include { lambda_curve: true, ..usual.include };
        assert!(!is_short(&nodes, &FitSpec { include, ..usual }));
    }
}
