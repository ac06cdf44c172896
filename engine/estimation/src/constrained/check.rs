//! Checks of constraints against a model, before a node is seen.

use crate::{
    design::{Axis, Basis, Design, no_range},
    spec::{Constraint, Domain, Estimator, FilterAxis, FitSpec, Regularization, Variance},
};
use flankfit_geometry::BSplineBasis;
use flankfit_numerics::{
    check::Faults,
    words::{Shown, counted},
};

/// Constraints on a measurement matrix.
pub(super) fn of_matrix() -> Faults {
    Faults::one("constraints", "a measurement matrix is not a function of position: it has no slope and no curvature")
}

/// Coefficients at most: some seconds of work.
pub(super) const MOST_COEFFICIENTS: usize = 400;

/// Refuses requests that constraints exclude, and constraints that do not suit the model.
pub(crate) fn check(design: &Design, spec: &FitSpec) -> Result<(), Faults> {
    if spec.constraints.is_empty() {
        return Ok(());
    }
    let mut faults = Faults::default();
    if spec.regularization != Regularization::None {
        faults.push("regularization", "`constraints` exclude regularisation: omit `regularization`, or use `none`");
    }
    if spec.estimator != Estimator::LeastSquares {
        faults.push("estimator", "`constraints` are for the estimator `least_squares`");
    }
    if spec.prior.is_some() {
        faults.push(
            "constraints",
            "`prior` and `constraints` exclude each other: the posterior would be that of a truncated distribution",
        );
    }
    if spec.errors.is_some() || spec.variance != Variance::Constant {
        faults
            .push("constraints", "`constraints` need independent errors of one variance: omit `errors` and `variance`");
    }
    let (Basis::Product { u, v }, Some(domain)) = (&design.basis, design.domain) else {
        faults.append(of_matrix());
        return Err(faults);
    };
    if design.rational.is_some() {
        faults.push(
            "constraints",
            "derivatives of NURBS are not piecewise polynomials: constraints need a model without weights",
        );
    }
    let coefficients = design.size();
    if coefficients > MOST_COEFFICIENTS {
        faults.push(
            "constraints",
            format_args!("constraints are for at most {MOST_COEFFICIENTS} coefficients, this model has {coefficients}"),
        );
    }
    let mut sound: Vec<(usize, &Constraint, Domain)> = Vec::new();
    for (index, constraint) in spec.constraints.iter().enumerate() {
        let before = faults.list().len();
        let along = match (constraint.along, domain.v) {
            (Some(FilterAxis::V), None) => {
                faults.push(format_args!("constraints[{index}].along"), "a curve has no v; its x is u");
                continue;
            }
            (None, Some(_)) => {
                faults.push(format_args!("constraints[{index}].along"), "missing: a surface needs `u` or `v`");
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
                faults.push(
                    format_args!("constraints[{index}]"),
                    format_args!("this is the opposite of constraint {other} (from 0), and their domains touch"),
                );
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
        faults.push(format_args!("constraints[{index}].domain.v"), "a curve has no v; its x is u");
    }
    for (name, range, whole) in [("u", own.u, whole.u), ("v", own.v, whole.v)] {
        let (Some(range), Some(domain)) = (range, whole) else { continue };
        if !(range[0] < range[1]) {
            faults.push(format_args!("constraints[{index}].domain.{name}"), no_range(range));
        } else if range[0] < domain[0] || range[1] > domain[1] {
            faults.push(
                format_args!("constraints[{index}].domain.{name}"),
                format_args!(
                    "[{}, {}] extends outside the domain of the fit, [{}, {}]",
                    Shown(range[0]),
                    Shown(range[1]),
                    Shown(domain[0]),
                    Shown(domain[1])
                ),
            );
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
        faults.push(
            format_args!("constraints[{index}]"),
            format_args!("the model has degree {degree} along {name}: derivatives of order {order} are always 0"),
        );
        return;
    }
    if let Axis::Spline(basis) = axis {
        // the derivative below the constrained one has to be continuous
        let most = degree + 1 - order;
        if let Some((knot, given)) = repeated(basis, range).find(|(_, given)| *given > most) {
            faults.push(
                format_args!("constraints[{index}]"),
                format_args!(
                    "the knot {} occurs {}: the next lower derivative may jump there, so that conditions on the \
                     pieces are not enough; at most {most} is allowed",
                    Shown(knot),
                    counted(given, "time", "times")
                ),
            );
        }
    }
}

/// Knots within a range with their multiplicities.
fn repeated(basis: &BSplineBasis, [low, high]: [f64; 2]) -> impl Iterator<Item = (f64, usize)> {
    let inner = basis.distinct_knots().into_iter().filter(move |knot| low < *knot && *knot < high);
    inner.map(|knot| (knot, basis.knots().iter().filter(|other| **other == knot).count()))
}

/// True if two boxes have a place in common.
fn touch(a: Domain, b: Domain) -> bool {
    let apart = |a: Option<[f64; 2]>, b: Option<[f64; 2]>| a.zip(b).is_some_and(|(a, b)| a[1] < b[0] || b[1] < a[0]);
    !(apart(a.u, b.u) || apart(a.v, b.v))
}
