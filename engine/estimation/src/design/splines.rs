//! B-splines and NURBS on the knots of a caller.

use super::reason::{Bound, ModelReason};
use super::{
    axis::Axis,
    domain::{Boxes, outside},
    measurement_matrix::{Basis, Design, too_many},
};
use crate::fault::{Faults, Field};
use crate::{
    data::{Nodes, Sample},
    spec::Knots,
};
use flankfit_geometry::{BSplineBasis, KnotFault, Mapping, WeightNet, polynomial::Family, rational::WeightFault};

/// The knots asked for, as the functions of each axis.
pub(crate) fn splines(
    knots: &Knots,
    (p, q): (usize, usize),
    surface: bool,
    (domain_u, domain_v): Boxes,
) -> Result<(Axis, Axis), Faults> {
    let at = |field: Field, fault: KnotFault| {
        let field = match (field, fault.index()) {
            (Field::Knots, Some(index)) => Field::Knot(index),
            (Field::AxisKnots(axis), Some(index)) => Field::AxisKnot(axis, index),
            (field, _) => field,
        };
        Faults::one(field, ModelReason::from(fault))
    };
    let flat = || Axis::Polynomial { family: Family::Monomial, mapping: Mapping::over(0.0, 0.0), size: 1 };
    let uniform = |degree: usize, spans: usize, domain: [f64; 2], field: Field| {
        if spans == 0 {
            return Err(Faults::one(field, ModelReason::NoSpan));
        }
        too_many(spans.saturating_add(degree), field)?;
        BSplineBasis::uniform(degree, spans, domain[0], domain[1]).map_err(|fault| at(field, fault))
    };
    too_many(p.max(q), Field::Degree)?;
    let (u, v) = match (knots, surface) {
        (Knots::Curve(knots), false) => {
            (BSplineBasis::new(p, knots.clone()).map_err(|fault| at(Field::Knots, fault))?, None)
        }
        (Knots::Surface(u, v), true) => (
            BSplineBasis::new(p, u.clone()).map_err(|fault| at(Field::AxisKnots(0), fault))?,
            Some(BSplineBasis::new(q, v.clone()).map_err(|fault| at(Field::AxisKnots(1), fault))?),
        ),
        (Knots::Spans(spans), false) => (uniform(p, *spans, domain_u, Field::Spans)?, None),
        (Knots::Spans(spans), true) => {
            (uniform(p, *spans, domain_u, Field::Spans)?, Some(uniform(q, *spans, domain_v, Field::Spans)?))
        }
        (Knots::SpansEach(a, b), true) => {
            (uniform(p, *a, domain_u, Field::AxisSpans(0))?, Some(uniform(q, *b, domain_v, Field::AxisSpans(1))?))
        }
        (Knots::SpansEach(..), false) => {
            return Err(Faults::one(Field::Spans, ModelReason::OneNumberOfSpans));
        }
        (Knots::Curve(_), true) => {
            return Err(Faults::one(Field::Knots, ModelReason::TwoKnotVectors));
        }
        (Knots::Surface(..), false) => return Err(Faults::one(Field::Knots, ModelReason::OneKnotVector)),
    };
    Ok((Axis::Spline(u), v.map_or_else(flat, Axis::Spline)))
}

pub(super) fn weight_net(weights: &[f64], (rows, columns): (usize, usize), surface: bool) -> Result<WeightNet, Faults> {
    too_many(rows.saturating_mul(columns), Field::Knots)?;
    WeightNet::new(weights.to_vec(), rows, columns).map_err(|fault| {
        let field = match &fault {
            WeightFault::NotPositive { index, .. } if surface => Field::NetWeight(index / columns, index % columns),
            WeightFault::NotPositive { index, .. } => Field::ControlWeight(*index),
            WeightFault::Count { .. } | WeightFault::Apart { .. } => Field::ControlWeights,
        };
        Faults::one(field, ModelReason::from(fault))
    })
}

/// No node may lie beyond the knots.
pub(crate) fn within_knots(design: &Design, nodes: &Nodes, sample: &Sample) -> Result<(), Faults> {
    let Basis::Product { u, v } = &design.basis else { return Ok(()) };
    let span = |axis: &Axis| match axis {
        Axis::Spline(basis) => <[f64; 2]>::from(basis.domain()),
        Axis::Polynomial { .. } => [f64::NEG_INFINITY, f64::INFINITY],
    };
    let mut faults = Faults::default();
    outside(nodes, sample, (span(u), span(v)), &mut faults, Bound::Knots);
    faults.into_result(())
}
