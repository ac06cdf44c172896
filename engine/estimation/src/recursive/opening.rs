//! Checks of a stream's settings, and the data from its first block: a curve or a surface, the
//! columns of a matrix.

use super::boxes::roomy;
use crate::{
    data::{Form, Nodes, Sample, folds},
    design::{self, Boxes, Design, MATRIX_TAKES_LINEAR, bounding_box, no_range, product_on},
    fit::{check_predictions, requested_models},
    near::POSITIONS_EXACT,
    regularized::{check_admissible, criterion_path, nodes_not_kept},
    spec::{Degree, Estimator, FitSpec, Knots, Model, PolynomialBasis, Prior, Regularization},
};
use flankfit_numerics::{
    check::{Fault, Faults},
    words::Shown,
};

/// Refuses what cannot be known node by node (estimators other than least squares, filters, mapped
/// bases or equal spans without a domain), and what the model rules out whatever the nodes will be.
pub(super) fn check(spec: &FitSpec, forgetting: f64) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if !(forgetting > 0.0 && forgetting <= 1.0) {
        faults.push("forgetting_factor", format_args!("{} is not in (0, 1]", Shown(forgetting)));
    }
    if spec.estimator != Estimator::LeastSquares {
        faults.push("estimator.type", "a stream uses least squares; refit its iteration with another estimator");
    }
    if !spec.filters.is_empty() {
        faults.push("filters", "a stream cannot filter heights; refit its iteration with filters");
    }
    if !spec.exclude.is_empty() {
        faults.push("exclude", "a stream uses every node; exclude nodes in a refit of its iteration");
    }
    if let Some(criterion) = spec.regularization.criterion().filter(|criterion| criterion.is_nodewise()) {
        faults.push(criterion_path(spec), nodes_not_kept(criterion));
    } else if spec.folds.is_some() {
        faults.push("folds", folds::UNUSED);
    }
    if spec.select.is_some() {
        faults.push("select", "a stream keeps only sums and cannot compare models; refit its iteration");
    }
    if !spec.constraints.is_empty() {
        faults.push("constraints", "a stream does not support constraints; refit its iteration with them");
    }
    if spec.node_uncertainty.is_some_and(|uncertainty| uncertainty.kind.is_some()) {
        faults.push("node_uncertainty.position_kind", POSITIONS_EXACT);
    }
    if matches!(spec.prior, Some(Prior::Iterations(_))) {
        faults.push(
            "prior.iterations",
            "a stream does not use earlier iterations: give `mean` with `std_error` or `covariance`, or refit its \
             iteration with this `prior` after the stream is finished",
        );
    }
    if matches!(&spec.regularization, Regularization::Representative(asked) if asked.piece.is_none()) {
        faults.push(
            "regularization.iteration",
            "a stream does not use other fits: give `piece`, which is in the `spec` of a fit with it",
        );
    }
    requested_models(spec)
        .for_each(|path| faults.push(path, "a stream keeps no nodes, which a model of the errors needs"));
    check_domain(spec, &mut faults);
    faults.into_result(())?;
    if spec.model == Model::Linear { Ok(()) } else { check_model(spec) }
}

/// The design that the first block leads to, and where its working functions live.
pub(super) fn begin(nodes: &Nodes, sample: &Sample, spec: &FitSpec) -> Result<(Form, Design, Boxes), Faults> {
    let form = Form::of(nodes);
    let (design, boxes) = match (&spec.model, &form) {
        (Model::Linear, Form::Matrix { columns, names }) => {
            (design::columns(sample, *columns, names.as_deref())?, ([0.0; 2], [0.0; 2]))
        }
        (Model::Linear, _) => {
            return Err(Faults::one("nodes.type", "the model `linear` needs nodes of type `matrix`"));
        }
        (_, Form::Matrix { .. }) => {
            return Err(Faults::one("nodes.type", MATRIX_TAKES_LINEAR));
        }
        (model, _) => {
            let surface = form == Form::Surface;
            if is_surface(spec).is_some_and(|specified| specified != surface) {
                let kind = if surface { "a curve" } else { "a surface" };
                let message = format_args!("model and domain of the stream are those of {kind}");
                return Err(Faults::one("nodes.type", message));
            }
            let (u, v) = bounding_box(sample);
            let domain = spec.domain.unwrap_or_default();
            let boxes = (
                domain.u.unwrap_or_else(|| roomy(u)),
                if surface { domain.v.unwrap_or_else(|| roomy(v)) } else { [0.0; 2] },
            );
            (met_at(product_on(surface, model, boxes, boxes), "nodes.type")?, boxes)
        }
    };
    let place = if matches!(form, Form::Matrix { .. }) { "nodes.x" } else { "nodes.type" };
    met_at(check_fit(&design, spec), place)?;
    Ok((form, design, boxes))
}

/// True if the spec is of a surface, false if of a curve; `None` if it may be either.
fn is_surface(spec: &FitSpec) -> Option<bool> {
    let domain = spec.domain.unwrap_or_default();
    match &spec.model {
        _ if domain.v.is_some() => Some(true),
        Model::Polynomial { degree: Degree::Each(..), .. } | Model::BSpline { degree: Degree::Each(..), .. } => {
            Some(true)
        }
        Model::BSpline { knots: Knots::Surface(..) | Knots::SpansEach(..), .. } => Some(true),
        Model::BSpline { knots: Knots::Curve(_), .. } => Some(false),
        model if needs_domain(model) && domain.u.is_some() => Some(false),
        _ => None,
    }
}

/// Kinds of nodes that a spec takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Taken {
    /// Nodes y(x).
    pub curves: bool,
    /// Nodes z(u, v), scattered or on a grid.
    pub surfaces: bool,
    /// Rows of a measurement matrix.
    pub matrices: bool,
}

pub(super) fn taken(spec: &FitSpec) -> Taken {
    let matrices = spec.model == Model::Linear;
    let surface = is_surface(spec);
    Taken { curves: !matrices && surface != Some(true), surfaces: !matrices && surface != Some(false), matrices }
}

fn needs_domain(model: &Model) -> bool {
    match model {
        Model::Polynomial { basis, .. } => *basis != PolynomialBasis::Monomial,
        Model::BSpline { knots, .. } => matches!(knots, Knots::Spans(_) | Knots::SpansEach(..)),
        Model::Linear => false,
    }
}

fn check_domain(spec: &FitSpec, faults: &mut Faults) {
    let domain = spec.domain.unwrap_or_default();
    if spec.model == Model::Linear {
        if spec.domain.is_some() {
            faults.push("domain", "a measurement matrix has no domain");
        }
        return;
    }
    for (path, range) in [("domain.u", domain.u), ("domain.v", domain.v)] {
        if let Some([low, high]) = range
            && !(low < high && (high - low).is_finite())
        {
            faults.push(path, no_range([low, high]));
        }
    }
    if needs_domain(&spec.model) {
        let path = match (domain.u, domain.v, is_surface(spec)) {
            (None, None, _) => "domain",
            (None, Some(_), _) => "domain.u",
            (Some(_), None, Some(true)) => "domain.v",
            _ => return,
        };
        faults.push(path, "missing; a stream needs it for a mapped basis or equal spans");
    }
}

/// Checks of a fit of this design that do not depend on the heights.
fn check_fit(design: &Design, spec: &FitSpec) -> Result<(), Faults> {
    check_admissible(design, spec)?;
    check_predictions(design, spec)
}

/// Checks degrees, knots, limits, and a regularisation for so many coefficients. If the first block
/// decides between a curve and a surface, one of them must be possible.
fn check_model(spec: &FitSpec) -> Result<(), Faults> {
    // the boxes only have to be some
    let domain = spec.domain.unwrap_or_default();
    let boxes = (domain.u.unwrap_or([-1.0, 1.0]), domain.v.unwrap_or([-1.0, 1.0]));
    let check = |surface| check_fit(&product_on(surface, &spec.model, boxes, boxes)?, spec);
    if let Some(surface) = is_surface(spec) {
        return check(surface);
    }
    match (check(false), check(true)) {
        (Err(curve), Err(surface)) if curve == surface => Err(curve),
        (Err(curve), Err(surface)) => {
            let mut both = Faults::default();
            for (of, faults) in [("a curve", curve), ("a surface", surface)] {
                both.append(
                    faults.map(|Fault { path, message }| Fault { path, message: format!("for {of}: {message}") }),
                );
            }
            Err(both)
        }
        _ => Ok(()),
    }
}

/// Errors of the stream's own model, found when its first block shows the kind of its nodes; they
/// are reported at the `place` of that block.
pub(super) fn met_at<T>(result: Result<T, Faults>, place: &str) -> Result<T, Faults> {
    let reworded = |Fault { path, message }: Fault| {
        // as the request was sent under
        let pointer = path.replace(['.', '['], "/").replace(']', "");
        Fault {
            path: place.to_owned(),
            message: format!("the stream's /{pointer} does not fit these nodes: {message}"),
        }
    };
    result.map_err(|faults| faults.map(reworded))
}
