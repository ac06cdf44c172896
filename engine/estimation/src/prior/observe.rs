//! Nodes of earlier iterations and mean and spread of a caller, as rows along the columns of now.

use nalgebra::{DMatrix, DVector};

use super::{chain::Link, current::Current, information::Information};
use crate::{
    data::{Heights, Nodes, Sample},
    design::{Design, bounding_box, product_on, too_few_nodes},
    diagnostics::within_range,
    error::FitError,
    factor::{Factor, multiply_upper_vector, scaled_condition},
    spec::{Chain, Earlier, FitSpec, Model, PriorSpread, Which},
    spectrum::caller_columns,
};
use flankfit_numerics::{Dd, check::Faults, qr_with_rhs, triangular};

/// A covariance matrix that is none.
pub(super) const NOT_POSITIVE: &str = "the covariance matrix is not positive definite";

/// Information of an iteration's nodes: rows along the present columns, in the unit of the heights.
pub(super) struct Observed {
    rows: DMatrix<Dd>,
    /// The heights less those of least squares now.
    right: Vec<Dd>,
    /// The predicted move to the next one, along the columns of now.
    shift: Vec<Dd>,
    /// Sum of squares of its residuals, where its nodes determine all coefficients.
    pub rss: f64,
    pub freedom: usize,
}

impl Observed {
    /// Observes every iteration of a chain.
    pub(super) fn all(chain: &Chain, earlier: &[Earlier], current: &Current) -> Result<Vec<Self>, FitError> {
        let path = |k: usize| match chain.which {
            Which::Previous => "prior.iterations".to_owned(),
            Which::Listed(_) => format!("prior.iterations[{k}]"),
        };
        let of = |(k, one): (usize, &Earlier)| {
            Self::of(one, current).map_err(|error| match error {
                FitError::Invalid(faults) | FitError::ExceedsDouble(faults) => {
                    of_earlier(&faults, &path(k), one.number)
                }
                other => other,
            })
        };
        earlier.iter().enumerate().map(of).collect()
    }

    fn of(earlier: &Earlier, current: &Current) -> Result<Self, FitError> {
        let factor = factor_of(&earlier.nodes, current)?;
        let own = caller_columns(&factor);
        let rows = triangular::multiply_upper(&own, &current.inverse);
        let mut fitted = current.coefficients.clone();
        multiply_upper_vector(&own, &mut fitted);
        let right = factor.qty.iter().zip(&fitted).map(|(&y, &f)| y - f).collect();
        let n = current.coefficients.len();
        let mut shift = vec![Dd::ZERO; n];
        for correction in &earlier.corrections {
            let factor = factor_of(&correction.change, current)?;
            let mut change = match &factor.working {
                Some(working) if scaled_condition(&factor.r).is_some() => working.clone(),
                _ => return Err(undetermined().into()),
            };
            triangular::solve_upper(&factor.change, &mut change);
            multiply_upper_vector(current.columns, &mut change);
            shift.iter_mut().zip(change).for_each(|(to, x)| *to += x);
        }
        let whole = scaled_condition(&factor.r).is_some();
        let count = Sample::new(&earlier.nodes).count();
        let (rss, freedom) = if whole { (factor.rss, count - n) } else { (0.0, 0) };
        Ok(Observed { rows, right, shift, rss, freedom })
    }

    /// In units of σ.
    pub(super) fn link(&self, sigma: f64) -> Link {
        let scaled = |x: &Vec<Dd>| DVector::from_iterator(x.len(), x.iter().map(|x| (*x / sigma).to_f64()));
        let rows = Information { r: self.rows.map(|x| x.to_f64()), d: scaled(&self.right) };
        Link { rows, shift: scaled(&self.shift) }
    }
}

/// Earlier nodes that leave a coefficient open.
pub(super) fn undetermined() -> Faults {
    Faults::one("prior.iterations", "the earlier nodes do not determine every coefficient of this model")
}

/// The first fault of the nodes of an earlier iteration, by its number.
fn of_earlier(faults: &Faults, path: &str, number: u32) -> FitError {
    let first = faults.list().first().map_or("", |fault| &fault.message);
    Faults::one(path, format_args!("iteration {number}: {first}")).into()
}

/// The factor of nodes with the functions of now.
fn factor_of(nodes: &Nodes, current: &Current) -> Result<Factor, FitError> {
    let sample = Sample::new(nodes);
    let heights = Heights::new(&sample);
    let design = design_of(nodes, &sample, current)?;
    within_range(nodes.heights(), &heights)?;
    Factor::new(&design, &sample)
}

/// The same functions over other nodes: mapped ones live on the domain of now, in which earlier
/// nodes of a polynomial need not lie.
fn design_of(nodes: &Nodes, sample: &Sample, current: &Current) -> Result<Design, Faults> {
    let other = || Faults::one("prior.iterations", "its nodes belong to another model");
    let now = current.design;
    let kind = match nodes {
        Nodes::Curve(_) => (true, false),
        Nodes::Scattered(_) | Nodes::Grid(_) => (true, true),
        Nodes::Matrix(_) => (false, false),
    };
    if kind != (now.domain.is_some(), now.domain.is_some_and(|domain| domain.v.is_some())) {
        return Err(other());
    }
    if sample.count() < now.size() {
        return Err(Faults::one("prior.iterations", too_few_nodes(now.size(), sample.count())));
    }
    let design = match (&current.spec.model, now.domain.and_then(|domain| Some((domain.u?, domain.v)))) {
        (model @ Model::Polynomial { .. }, Some((u, v))) => {
            let boxes = bounding_box(sample);
            product_on(v.is_some(), model, (u, v.unwrap_or(boxes.1)), boxes)?
        }
        (model, _) => Design::new(nodes, sample, &FitSpec { domain: now.domain, ..FitSpec::new(model.clone()) })?,
    };
    if design.labels == now.labels { Ok(design) } else { Err(other()) }
}

/// A prior of a caller, in units of σ.
pub(super) fn given(mean: &[f64], spread: &PriorSpread, current: &Current, sigma: f64) -> Result<Information, Faults> {
    let n = current.coefficients.len();
    let mut right: Vec<Dd> = mean.iter().zip(&current.coefficients).map(|(&m, &a)| Dd::from(m) - a).collect();
    let mut rows = current.inverse.clone();
    let deviations: Vec<f64> = match spread {
        PriorSpread::StdError(deviations) => deviations.clone(),
        PriorSpread::Covariance(triangle) => triangle.iter().map(|row| row[row.len() - 1].sqrt()).collect(),
    };
    for (j, &deviation) in deviations.iter().enumerate() {
        right[j] /= Dd::from(deviation);
        let factor = Dd::from(sigma) / Dd::from(deviation);
        rows.row_mut(j).iter_mut().for_each(|x| *x *= factor);
    }
    if let PriorSpread::Covariance(triangle) = spread {
        let correlation = DMatrix::from_fn(n, n, |i, j| {
            Dd::from(triangle[i.max(j)][i.min(j)]) / Dd::from(deviations[i]) / Dd::from(deviations[j])
        });
        let root = triangular::cholesky(&correlation).ok_or_else(|| Faults::one("prior.covariance", NOT_POSITIVE))?;
        triangular::solve_upper_transposed(&root, &mut right);
        for mut column in rows.column_iter_mut() {
            triangular::solve_upper_transposed(&root, column.as_mut_slice());
        }
    }
    let found = qr_with_rhs(rows, DVector::from_vec(right));
    Ok(Information { r: found.r.map(|x| x.to_f64()), d: found.qty.map(|x| x.to_f64()) })
}
