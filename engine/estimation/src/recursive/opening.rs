//! Checks of a stream's settings, and the data from its first block: a curve or a surface, the
//! columns of a matrix.

use super::boxes::roomy;
use crate::fault::{
    ErrorsReason, Fault, Faults, Field, FoldsReason, ModelReason, NodeList, Reason, RegularizationReason,
    SelectionReason, StreamReason,
};
use crate::{
    data::{Form, Nodes, Sample},
    design::{self, Boxes, Design, bounding_box, product_on},
    fit::{asked_models, check_predictions},
    regularized::{check_admissible, criterion_field},
    spec::{Degree, Estimator, FitSpec, Knots, Model, PolynomialBasis, Prior, Regularization},
};

/// Refuses what cannot be known node by node (estimators other than least squares, filters, mapped
/// bases or equal spans without a domain), and what the model rules out whatever the nodes will be.
pub(super) fn check(spec: &FitSpec, forgetting: f64) -> Result<(), Faults> {
    let mut faults = Faults::default();
    if !(forgetting > 0.0 && forgetting <= 1.0) {
        faults.push(Field::ForgettingFactor, StreamReason::ForgettingFactor(forgetting));
    }
    if spec.estimator != Estimator::LeastSquares {
        faults.push(Field::EstimatorType, StreamReason::LeastSquaresOnly);
    }
    if !spec.filters.is_empty() {
        faults.push(Field::Filters, StreamReason::NoFilters);
    }
    if !spec.exclude.is_empty() {
        faults.push(Field::Exclude, StreamReason::NoExclusion);
    }
    if let Some(criterion) = spec.regularization.criterion().filter(|criterion| criterion.is_nodewise()) {
        faults.push(criterion_field(spec), RegularizationReason::NodesNotKept(criterion));
    } else if spec.folds.is_some() {
        faults.push(Field::Folds, FoldsReason::Unused);
    }
    if spec.select.is_some() {
        faults.push(Field::Select, SelectionReason::OfStream);
    }
    if !spec.constraints.is_empty() {
        faults.push(Field::Constraints, StreamReason::NoConstraints);
    }
    if spec.node_uncertainty.is_some_and(|uncertainty| uncertainty.kind.is_some()) {
        faults.push(Field::PositionKind, ErrorsReason::PositionsExact);
    }
    if matches!(spec.prior, Some(Prior::Iterations(_))) {
        faults.push(Field::PriorIterations, StreamReason::NoEarlierIterations);
    }
    if matches!(&spec.regularization, Regularization::Representative(asked) if asked.piece.is_none()) {
        faults.push(Field::PieceIteration, StreamReason::NoOtherFit);
    }
    asked_models(spec).for_each(|field| faults.push(field, ErrorsReason::Stream));
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
            return Err(Faults::one(Field::NodesType, StreamReason::LinearTakesMatrix));
        }
        (_, Form::Matrix { .. }) => {
            return Err(Faults::one(Field::NodesType, ModelReason::MatrixTakesLinear));
        }
        (model, _) => {
            let surface = form == Form::Surface;
            if is_surface(spec).is_some_and(|told| told != surface) {
                return Err(Faults::one(Field::NodesType, StreamReason::Model { surface: !surface }));
            }
            let (u, v) = bounding_box(sample);
            let domain = spec.domain.unwrap_or_default();
            let boxes = (
                domain.u.unwrap_or_else(|| roomy(u)),
                if surface { domain.v.unwrap_or_else(|| roomy(v)) } else { [0.0; 2] },
            );
            (met_at(product_on(surface, model, boxes, boxes), Field::NodesType)?, boxes)
        }
    };
    let place = if matches!(form, Form::Matrix { .. }) { Field::List(NodeList::X) } else { Field::NodesType };
    met_at(check_fit(&design, spec), place)?;
    Ok((form, design, boxes))
}

/// Whether the spec is of a surface, where that can be told.
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

/// Which kinds of nodes a spec takes.
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
            faults.push(Field::Domain, ModelReason::MatrixHasNoDomain);
        }
        return;
    }
    for (field, range) in [(Field::DomainU, domain.u), (Field::DomainV, domain.v)] {
        if let Some([low, high]) = range
            && !(low < high && (high - low).is_finite())
        {
            faults.push(field, ModelReason::Range([low, high]));
        }
    }
    if needs_domain(&spec.model) {
        match (domain.u, domain.v, is_surface(spec)) {
            (None, None, _) => faults.push(Field::Domain, StreamReason::DomainMissing),
            (None, Some(_), _) => faults.push(Field::DomainU, StreamReason::DomainMissing),
            (Some(_), None, Some(true)) => faults.push(Field::DomainV, StreamReason::DomainMissing),
            _ => {}
        }
    }
}

/// What a fit of this design would refuse whatever the heights are.
fn check_fit(design: &Design, spec: &FitSpec) -> Result<(), Faults> {
    check_admissible(design, spec)?;
    check_predictions(design, spec)
}

/// Degrees, knots, limits, and a regularisation for so many coefficients. Where the first block is
/// to tell a curve from a surface, one of them must be possible.
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
            for (surface, faults) in [(false, curve), (true, surface)] {
                for Fault { field, reason } in faults.list() {
                    both.push(*field, Reason::For { surface, reason: Box::new(reason.clone()) });
                }
            }
            Err(both)
        }
        _ => Ok(()),
    }
}

/// Faults of the stream's own model, met when its first block tells what the nodes are: at the
/// `place` that told it.
pub(super) fn met_at<T>(result: Result<T, Faults>, place: Field) -> Result<T, Faults> {
    result.map_err(|faults| {
        let mut told = Faults::default();
        for Fault { field, reason } in faults.list() {
            told.push(place, Reason::Unsuited { field: *field, reason: Box::new(reason.clone()) });
        }
        told
    })
}
