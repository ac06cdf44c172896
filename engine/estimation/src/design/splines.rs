//! B-splines and NURBS on the knots of a caller.

use super::{
    axis::Axis,
    domain::{Boxes, outside},
    measurement_matrix::{Basis, Design, too_many},
};
use crate::{
    data::{Nodes, Sample},
    spec::Knots,
};
use flankfit_geometry::{BSplineBasis, Mapping, WeightNet, polynomial::Family};
use flankfit_numerics::check::{Fault, Faults};

/// Requested knots, as the functions of each axis.
pub(crate) fn splines(
    knots: &Knots,
    (p, q): (usize, usize),
    surface: bool,
    (domain_u, domain_v): Boxes,
) -> Result<(Axis, Axis), Faults> {
    let given = |degree: usize, knots: &[f64], place: &str| {
        BSplineBasis::new(degree, knots.to_vec()).map_err(|faults| faults.within(place))
    };
    let flat = || Axis::Polynomial { family: Family::Monomial, mapping: Mapping::over(0.0, 0.0), size: 1 };
    let uniform = |degree: usize, spans: usize, domain: [f64; 2], place: &str| {
        if spans == 0 {
            return Err(no_span(place));
        }
        too_many(spans.saturating_add(degree), place)?;
        // the knots are not the caller's
        let all = |faults: Faults| faults.map(|fault| Fault { path: place.to_owned(), ..fault });
        BSplineBasis::uniform(degree, spans, domain[0], domain[1]).map_err(all)
    };
    too_many(p.max(q), "model.degree")?;
    let (u, v) = match (knots, surface) {
        (Knots::Curve(knots), false) => (given(p, knots, "model.knots")?, None),
        (Knots::Surface(u, v), true) => (given(p, u, "model.knots[0]")?, Some(given(q, v, "model.knots[1]")?)),
        (Knots::Spans(spans), false) => (uniform(p, *spans, domain_u, "model.spans")?, None),
        (Knots::Spans(spans), true) => {
            (uniform(p, *spans, domain_u, "model.spans")?, Some(uniform(q, *spans, domain_v, "model.spans")?))
        }
        (Knots::SpansEach(a, b), true) => {
            (uniform(p, *a, domain_u, "model.spans[0]")?, Some(uniform(q, *b, domain_v, "model.spans[1]")?))
        }
        (Knots::SpansEach(..), false) => {
            return Err(Faults::one("model.spans", "a curve has one number of spans"));
        }
        (Knots::Curve(_), true) => {
            return Err(Faults::one("model.knots", "a surface needs two knot vectors, one for u and one for v"));
        }
        (Knots::Surface(..), false) => return Err(Faults::one("model.knots", "a curve has one knot vector")),
    };
    Ok((Axis::Spline(u), v.map_or_else(flat, Axis::Spline)))
}

pub(super) fn weight_net(weights: &[f64], (rows, columns): (usize, usize), surface: bool) -> Result<WeightNet, Faults> {
    too_many(rows.saturating_mul(columns), "model.knots")?;
    WeightNet::new(weights.to_vec(), rows, columns, surface).map_err(|faults| faults.within("model.weights"))
}

/// Error for no span where equal ones are requested.
pub(crate) fn no_span(place: &str) -> Faults {
    Faults::one(place, "at least one span")
}

/// Refuses nodes outside the knots.
pub(crate) fn within_knots(design: &Design, nodes: &Nodes, sample: &Sample) -> Result<(), Faults> {
    let Basis::Product { u, v } = &design.basis else { return Ok(()) };
    let span = |axis: &Axis| match axis {
        Axis::Spline(basis) => <[f64; 2]>::from(basis.domain()),
        Axis::Polynomial { .. } => [f64::NEG_INFINITY, f64::INFINITY],
    };
    let mut faults = Faults::default();
    outside(nodes, sample, (span(u), span(v)), &mut faults, "the span of the knots");
    faults.into_result(())
}
