//! B-splines and NURBS on the knots of a caller.

use super::{
    axis::Axis,
    domain::{Boxes, outside},
    measurement_matrix::{Basis, Design, too_many},
};
use crate::{
    estimation::{
        data::{Nodes, Sample},
        error::Faults,
        spec::Knots,
    },
    geometry::{BSplineBasis, KnotFault, Mapping, WeightNet, polynomial::Family, rational::WeightFault},
};

/// The knots asked for, as the functions of each axis.
pub fn splines(
    knots: &Knots,
    (p, q): (usize, usize),
    surface: bool,
    (domain_u, domain_v): Boxes,
) -> Result<(Axis, Axis), Faults> {
    let at = |pointer: &str, fault: KnotFault| {
        let pointer = fault.index().map_or_else(|| pointer.to_owned(), |i| format!("{pointer}/{i}"));
        Faults::one(pointer, fault.to_string())
    };
    let flat = || Axis::Polynomial { family: Family::Monomial, mapping: Mapping::over(0.0, 0.0), size: 1 };
    let uniform = |degree: usize, spans: usize, domain: [f64; 2], pointer: &str| {
        if spans == 0 {
            return Err(Faults::one(pointer, "at least one span"));
        }
        too_many(spans.saturating_add(degree), pointer)?;
        BSplineBasis::uniform(degree, spans, domain[0], domain[1]).map_err(|fault| at(pointer, fault))
    };
    too_many(p.max(q), "/model/degree")?;
    let (u, v) = match (knots, surface) {
        (Knots::Curve(knots), false) => {
            (BSplineBasis::new(p, knots.clone()).map_err(|fault| at("/model/knots", fault))?, None)
        }
        (Knots::Surface(u, v), true) => (
            BSplineBasis::new(p, u.clone()).map_err(|fault| at("/model/knots/0", fault))?,
            Some(BSplineBasis::new(q, v.clone()).map_err(|fault| at("/model/knots/1", fault))?),
        ),
        (Knots::Spans(spans), false) => (uniform(p, *spans, domain_u, "/model/spans")?, None),
        (Knots::Spans(spans), true) => {
            (uniform(p, *spans, domain_u, "/model/spans")?, Some(uniform(q, *spans, domain_v, "/model/spans")?))
        }
        (Knots::SpansEach(a, b), true) => {
            (uniform(p, *a, domain_u, "/model/spans/0")?, Some(uniform(q, *b, domain_v, "/model/spans/1")?))
        }
        (Knots::SpansEach(..), false) => {
            return Err(Faults::one("/model/spans", "a curve has one number of spans"));
        }
        (Knots::Curve(_), true) => {
            return Err(Faults::one("/model/knots", "a surface wants two knot vectors, one for u and one for v"));
        }
        (Knots::Surface(..), false) => return Err(Faults::one("/model/knots", "a curve has one knot vector")),
    };
    Ok((Axis::Spline(u), v.map_or_else(flat, Axis::Spline)))
}

pub fn weight_net(weights: &[f64], (rows, columns): (usize, usize), surface: bool) -> Result<WeightNet, Faults> {
    too_many(rows.saturating_mul(columns), "/model/knots")?;
    WeightNet::new(weights.to_vec(), rows, columns).map_err(|fault| {
        let pointer = match &fault {
            WeightFault::NotPositive { index, .. } if surface => {
                format!("/model/weights/{}/{}", index / columns, index % columns)
            }
            WeightFault::NotPositive { index, .. } => format!("/model/weights/{index}"),
            WeightFault::Count { .. } | WeightFault::Apart { .. } => "/model/weights".to_owned(),
        };
        Faults::one(pointer, fault.to_string())
    })
}

/// No node may lie beyond the knots.
pub fn within_knots(design: &Design, nodes: &Nodes, sample: &Sample) -> Result<(), Faults> {
    let Basis::Product { u, v } = &design.basis else { return Ok(()) };
    let span = |axis: &Axis| match axis {
        Axis::Spline(basis) => <[f64; 2]>::from(basis.domain()),
        Axis::Polynomial { .. } => [f64::NEG_INFINITY, f64::INFINITY],
    };
    let mut faults = Faults::default();
    outside(nodes, sample, (span(u), span(v)), &mut faults, "the span of the knots");
    faults.into_result(())
}
