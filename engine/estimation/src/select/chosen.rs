//! The model that is fitted.

use super::{
    candidates::{Of, check_work, degrees, looked_at},
    problem::Problem,
};
use crate::{
    data::{Heights, Matrix, Nodes, Partition, Sample},
    design::Design,
    diagnostics::{finite, within_range},
    error::FitError,
    factor::{Factor, scaled_condition},
    fit::requested_models,
    result::{Coefficient, FitResult, Selection, TermKey, Warning},
    spec::{Candidates, Degree, Estimator, FitSpec, Folds, Model, ModelCriterion, Places, Select, TermSearch, Terms},
};
use flankfit_numerics::{
    check::Faults,
    words::{Shown, counted},
};

/// The model to be fitted, and the candidates it was chosen from.
pub(crate) struct Chosen {
    pub spec: FitSpec,
    /// Nodes with the chosen columns of a measurement matrix, if columns were chosen.
    pub nodes: Option<Nodes>,
    columns: Vec<usize>,
    selection: Selection,
}

/// The best model by `asked`.
pub(crate) fn choose(nodes: &Nodes, spec: &FitSpec, asked: &Select) -> Result<Chosen, FitError> {
    check(spec, asked)?;
    let sample = Sample::new(nodes);
    let surface = !matches!(nodes, Nodes::Curve(_));
    let (largest, degrees) = largest(spec, asked, surface, sample.count())?;
    let design = Design::new(nodes, &sample, &largest)?;
    within_range(nodes.heights(), &Heights::new(&sample))?;
    let folds = match (&spec.folds, asked.criterion) {
        (Some(folds), _) => Some(Partition::new(nodes, &sample, folds)?),
        (None, ModelCriterion::BlockedCv) => Some(Partition::new(nodes, &sample, &Folds::default())?),
        (None, _) => Partition::new(nodes, &sample, &Folds::default()).ok(),
    };
    let models = match asked.candidates {
        Candidates::Degrees(_) => degrees.len(),
        Candidates::Terms(_) => design.size(),
    };
    check_work(asked, models, sample.count(), design.size(), 1)?;
    let factor = Factor::new(&design, &sample)?;
    let dependent = || {
        Faults::one(
            path_of(asked),
            "the nodes do not determine the largest model: its columns depend on each other; omit some",
        )
    };
    scaled_condition(&factor.r).ok_or_else(dependent)?;
    let problem = Problem::new(nodes, &sample, &design, &factor, folds.as_ref()).ok_or_else(dependent)?;
    check_work(asked, models, sample.count(), design.size(), problem.triangle.cost())?;
    let ordered = spec.model != Model::Linear;
    let (of, candidates): (Vec<_>, Vec<_>) = looked_at(asked, &problem, &design, &degrees, ordered).into_iter().unzip();
    // heights that lie on a model but for rounding are those of the smallest one that they lie on
    let exact =
        (0..candidates.len()).filter(|&k| problem.is_exact(&candidates[k])).min_by_key(|&k| candidates[k].coefficients);
    let best = (0..candidates.len())
        .filter_map(|k| Some((k, candidates[k].figure(asked.criterion)?, candidates[k].coefficients)))
        .min_by(|x, y| x.1.total_cmp(&y.1).then(x.2.cmp(&y.2)))
        .map(|(k, ..)| k);
    let chosen = exact.or(best).ok_or_else(|| {
        Faults::one(
            "select.criterion",
            format_args!("no model has {}: there are too few nodes, or all residuals are 0", asked.criterion.name()),
        )
    })?;
    let selection = Selection { criterion: asked.criterion, candidates, chosen };
    Ok(match &of[chosen] {
        Of::Degree(degree) => Chosen { spec: of_degree(spec, *degree), nodes: None, columns: Vec::new(), selection },
        Of::Columns(columns) => of_columns(nodes, spec, &design, columns, selection)?,
    })
}

impl Chosen {
    /// The fit of the chosen model with the comparison of the candidates.
    pub(crate) fn into_result(self, mut result: FitResult) -> Result<FitResult, FitError> {
        if self.nodes.is_some() {
            for Coefficient { key, .. } in &mut result.coefficients {
                if let TermKey::Column(column) = key {
                    *column = self.columns[*column];
                }
            }
        }
        result.warnings.push(Warning::PostSelection { count: self.selection.candidates.len() });
        result.selection = Some(self.selection);
        finite::checked(result)
    }
}

fn path_of(asked: &Select) -> &'static str {
    match asked.candidates {
        Candidates::Degrees(_) => "select.degrees",
        Candidates::Terms(_) => "select.terms",
    }
}

/// Checks that do not depend on the nodes.
fn check(spec: &FitSpec, asked: &Select) -> Result<(), Faults> {
    let mut faults = Faults::default();
    match (&spec.model, asked.candidates) {
        (Model::Polynomial { .. }, _) | (Model::Linear, Candidates::Terms(_)) => {}
        (_, Candidates::Degrees(_)) => faults.push(
            "select.degrees",
            "only polynomials have degrees: use the model `polynomial`, or select terms of a linear model",
        ),
        (Model::BSpline { .. }, Candidates::Terms(_)) => faults.push(
            "select.terms",
            "functions of a B-spline cannot be selected: select degrees or terms of polynomials, or columns",
        ),
    }
    if !asked.hierarchical && spec.model != Model::Linear {
        faults.push(
            "select.hierarchical",
            "without the powers that divide it a term depends on the origin of u and v: only columns of a linear \
             model can be selected without hierarchy",
        );
    }
    if let Candidates::Terms(TermSearch::ElasticNet { alpha }) = asked.candidates
        && !(alpha > 0.0 && alpha <= 1.0)
    {
        faults.push("select.alpha", format_args!("{} is not above 0 and at most 1", Shown(alpha)));
    }
    if spec.estimator != Estimator::LeastSquares {
        faults.push(
            "select",
            "selection needs likelihoods and leverages of least squares, which a robust estimator does not have",
        );
    }
    requested_models(spec).for_each(|path| {
        faults.push(path, "selection needs independent errors of one variance: select the model first")
    });
    if spec.prior.is_some() {
        faults.push(
            "select",
            "a prior is for the coefficients of one model: select the model first, then give the prior",
        );
    }
    if !spec.constraints.is_empty() {
        faults.push("constraints", "constraints are for one model: select the model first");
    }
    faults.into_result(())
}

/// The largest model, and the degrees below it if requested.
fn largest(spec: &FitSpec, asked: &Select, surface: bool, m: usize) -> Result<(FitSpec, Vec<Degree>), Faults> {
    let Candidates::Degrees(most) = asked.candidates else { return Ok((spec.clone(), Vec::new())) };
    let total = surface && matches!(&spec.model, Model::Polynomial { terms: Terms::Total, .. });
    let degrees = degrees(most, surface, total)?;
    let largest = degrees.last().copied().unwrap_or(most);
    let n = match largest {
        Degree::Both(d) if total => (d + 1) * (d + 2) / 2,
        Degree::Both(d) => d + 1,
        Degree::Each(p, q) => (p + 1) * (q + 1),
    };
    if m > 0 && n > m {
        let message =
            format!("the largest model has {} for {m} counted nodes", counted(n, "coefficient", "coefficients"));
        return Err(Faults::one("select.degrees", message));
    }
    Ok((of_degree(spec, largest), degrees))
}

/// The spec with another degree; terms that were listed become all products.
fn of_degree(spec: &FitSpec, degree: Degree) -> FitSpec {
    let model = match &spec.model {
        Model::Polynomial { basis, terms, .. } => {
            let terms = if *terms == Terms::Total { Terms::Total } else { Terms::Tensor };
            Model::Polynomial { degree, basis: *basis, terms }
        }
        other => other.clone(),
    };
    FitSpec { model, ..without(spec) }
}

/// The spec without the choice; folds stay if λ* is cross-validated.
fn without(spec: &FitSpec) -> FitSpec {
    let folds = spec.folds.clone().filter(|_| spec.cross_validates());
    FitSpec { select: None, folds, ..spec.clone() }
}

/// The terms `columns` of `design`.
fn of_columns(
    nodes: &Nodes,
    spec: &FitSpec,
    design: &Design,
    columns: &[usize],
    selection: Selection,
) -> Result<Chosen, FitError> {
    let columns = columns.to_vec();
    if let (Model::Linear, Nodes::Matrix(matrix)) = (&spec.model, nodes) {
        let spec = of_rows(spec, matrix.columns, &columns)?;
        let nodes = Some(Nodes::Matrix(some_columns(matrix, design, &columns)));
        return Ok(Chosen { spec, nodes, columns, selection });
    }
    let listed: Vec<[usize; 2]> = columns.iter().map(|&k| design.terms[k].into()).collect();
    let most = |axis: usize| listed.iter().map(|term| term[axis]).max().unwrap_or(0);
    let degree = match nodes {
        Nodes::Curve(_) => Degree::Both(most(0)),
        _ => Degree::Each(most(0), most(1)),
    };
    let complete = listed.len() == (most(0) + 1) * (most(1) + 1);
    let model = match &spec.model {
        Model::Polynomial { basis, .. } => {
            let terms = if complete { Terms::Tensor } else { Terms::Listed(listed) };
            Model::Polynomial { degree, basis: *basis, terms }
        }
        other => other.clone(),
    };
    Ok(Chosen { spec: FitSpec { model, ..without(spec) }, nodes: None, columns, selection })
}

fn some_columns(matrix: &Matrix, design: &Design, columns: &[usize]) -> Matrix {
    let rows = matrix.x.chunks_exact(matrix.columns.max(1));
    Matrix {
        x: rows.flat_map(|row| columns.iter().map(|&j| row[j])).collect(),
        columns: columns.len(),
        names: Some(columns.iter().map(|&j| design.labels[j].clone()).collect()),
        y: matrix.y.clone(),
        weight: matrix.weight.clone(),
    }
}

/// The spec with the same columns of the rows in it.
fn of_rows(spec: &FitSpec, all: usize, columns: &[usize]) -> Result<FitSpec, Faults> {
    let mut spec = without(spec);
    if let Some(predict) = &mut spec.predict
        && let Places::Rows(rows) = &mut predict.at
    {
        for (k, row) in rows.iter_mut().enumerate() {
            if row.len() != all {
                let message =
                    format!("{} in a row, where the matrix has {all}", counted(row.len(), "number", "numbers"));
                return Err(Faults::one(format_args!("predict.at.x[{k}]"), message));
            }
            *row = columns.iter().map(|&j| row[j]).collect();
        }
    }
    Ok(spec)
}
