//! Which constraints a model can meet, before a node is seen.

use super::reason::ConstraintReason;
use crate::{
    design::{Axis, Basis, Design},
    fault::{Faults, Field},
    spec::{Constraint, Domain, Estimator, FilterAxis, FitSpec, Regularization, Variance},
};
use flankfit_geometry::BSplineBasis;

/// Coefficients at most: some seconds of work.
pub(super) const MOST_COEFFICIENTS: usize = 400;

/// Refuses what cannot be asked for with constraints, and constraints that do not suit the model.
pub(crate) fn check(design: &Design, spec: &FitSpec) -> Result<(), Faults> {
    if spec.constraints.is_empty() {
        return Ok(());
    }
    let mut faults = Faults::default();
    if spec.regularization != Regularization::None {
        faults.push(Field::Regularization, ConstraintReason::Regularized);
    }
    if spec.estimator != Estimator::LeastSquares {
        faults.push(Field::Estimator, ConstraintReason::LeastSquaresOnly);
    }
    if spec.prior.is_some() {
        faults.push(Field::Constraints, ConstraintReason::WithPrior);
    }
    if spec.errors.is_some() || spec.variance != Variance::Constant {
        faults.push(Field::Constraints, ConstraintReason::WithErrors);
    }
    let (Basis::Product { u, v }, Some(domain)) = (&design.basis, design.domain) else {
        faults.push(Field::Constraints, ConstraintReason::OfMatrix);
        return faults.into_result(());
    };
    if design.rational.is_some() {
        faults.push(Field::Constraints, ConstraintReason::Rational);
    }
    let coefficients = design.size();
    if coefficients > MOST_COEFFICIENTS {
        faults.push(Field::Constraints, ConstraintReason::TooMany { coefficients, most: MOST_COEFFICIENTS });
    }
    let mut sound: Vec<(usize, &Constraint, Domain)> = Vec::new();
    for (index, constraint) in spec.constraints.iter().enumerate() {
        let before = faults.list().len();
        let along = match (constraint.along, domain.v) {
            (Some(FilterAxis::V), None) => {
                faults.push(Field::ConstraintAlong(index), ConstraintReason::NoV);
                continue;
            }
            (None, Some(_)) => {
                faults.push(Field::ConstraintAlong(index), ConstraintReason::AxisMissing);
                continue;
            }
            (along, _) => along.unwrap_or(FilterAxis::U),
        };
        let place = checked_domain(index, constraint.domain, domain, &mut faults);
        let (axis, name, range) = match along {
            FilterAxis::U => (u, "u", place.u),
            FilterAxis::V => (v, "v", place.v),
        };
        check_axis(index, axis, name, constraint.kind.order(), range.unwrap_or_default(), &mut faults);
        if faults.list().len() > before {
            continue;
        }
        let opposite = sound.iter().find(|(_, other, elsewhere)| {
            let same = other.along.unwrap_or(FilterAxis::U) == along && other.kind.order() == constraint.kind.order();
            same && other.kind != constraint.kind && touch(place, *elsewhere)
        });
        match opposite {
            Some((other, ..)) => {
                faults.push(Field::Constraint(index), ConstraintReason::Opposite { other: *other });
            }
            None => sound.push((index, constraint, place)),
        }
    }
    faults.into_result(())
}

/// The places of a constraint, within the domain of the fit.
fn checked_domain(index: usize, own: Option<Domain>, whole: Domain, faults: &mut Faults) -> Domain {
    let own = own.unwrap_or_default();
    if own.v.is_some() && whole.v.is_none() {
        faults.push(Field::ConstraintRange(index, 1), ConstraintReason::NoV);
    }
    for (axis, range, whole) in [(0, own.u, whole.u), (1, own.v, whole.v)] {
        let (Some(range), Some(domain)) = (range, whole) else { continue };
        if !(range[0] < range[1]) {
            faults.push(Field::ConstraintRange(index, axis), ConstraintReason::Range(range));
        } else if range[0] < domain[0] || range[1] > domain[1] {
            faults.push(Field::ConstraintRange(index, axis), ConstraintReason::Outside { range, domain });
        }
    }
    Domain { u: own.u.or(whole.u), v: own.v.or(whole.v) }
}

/// A derivative that there is, and that says everything about the function.
fn check_axis(index: usize, axis: &Axis, name: &'static str, order: usize, range: [f64; 2], faults: &mut Faults) {
    let degree = match axis {
        Axis::Polynomial { size, .. } => size - 1,
        Axis::Spline(basis) => basis.degree(),
    };
    if degree < order {
        faults.push(Field::Constraint(index), ConstraintReason::Degree { axis: name, degree, order });
        return;
    }
    if let Axis::Spline(basis) = axis {
        // the derivative below the constrained one has to be continuous
        let most = degree + 1 - order;
        if let Some((knot, given)) = repeated(basis, range).find(|(_, given)| *given > most) {
            faults.push(Field::Constraint(index), ConstraintReason::Knot { knot, given, most });
        }
    }
}

/// The knots within a range with how often they stand.
fn repeated(basis: &BSplineBasis, [low, high]: [f64; 2]) -> impl Iterator<Item = (f64, usize)> {
    let inner = basis.distinct_knots().into_iter().filter(move |knot| low < *knot && *knot < high);
    inner.map(|knot| (knot, basis.knots().iter().filter(|other| **other == knot).count()))
}

/// Whether two boxes have a place in common.
fn touch(a: Domain, b: Domain) -> bool {
    let apart = |a: Option<[f64; 2]>, b: Option<[f64; 2]>| a.zip(b).is_some_and(|(a, b)| a[1] < b[0] || b[1] < a[0]);
    !(apart(a.u, b.u) || apart(a.v, b.v))
}
