//! A curve asked for: points and a method in, the curve and its report out.

use super::{
    methods::{CurveMethod, Requested},
    near,
    points::{self, CurvePointsBody},
    result,
};
use crate::api::{
    built::Built,
    faults::Faults,
    fits::{reader::fields, spec::request::FitFields},
    json::{members::of_request, request::request},
    problem::Problem,
};
use flankfit_engine::{
    estimation::Nodes,
    geometry::{
        curve::{Points, through},
        space::Dimension,
    },
};

request! {
    /// A curve to build.
    pub struct CurveRequest as CurveMembers {
        required points: CurvePointsBody,
        required method: CurveMethod,
        /// For methods near points.
        flatten fit: FitFields,
    }
}

request! {
    /// A curve to build and to keep with an iteration.
    #[schema(as = KeptCurveRequest)]
    pub struct IterationCurveRequest as IterationCurveMembers {
        /// By default the iteration's nodes with their weights, which must be of type `curve`.
        optional points: CurvePointsBody,
        required method: CurveMethod,
        /// For methods near points.
        flatten fit: FitFields,
    }
}

/// Builds the curve of a request, whose points may be left out where there are nodes of an
/// iteration. Processor work.
pub fn build(text: &[u8], own: Option<&Nodes>) -> Result<Built, Problem> {
    let mut faults = Faults::default();
    let (points, method, fit) = match own {
        None => {
            let CurveMembers { points, method, fit } = of_request(text, &mut faults)?;
            (points, method, fit)
        }
        Some(_) => {
            let IterationCurveMembers { points, method, fit } = of_request(text, &mut faults)?;
            (points, method, fit)
        }
    };
    let points = match (points.text(), own) {
        (None, Some(nodes)) => points::of_nodes(nodes, &mut faults),
        _ => points.required_with(&mut faults, |slice, _, faults| points::read(slice, faults)),
    };
    let given = method.required_text(&mut faults).is_some();
    let (Some(points), true) = (points, given) else { return Err(Problem::invalid(faults)) };
    let dimension = match &points.points {
        Points::Graph { .. } => Dimension::Graph,
        Points::Space { dimension, .. } => *dimension,
    };
    let method = method.required(&mut faults);
    let name = method.as_ref().map_or("", CurveMethod::name).to_owned();
    let unfit = method.as_ref().and_then(CurveMethod::takes_no_fit);
    let method = method.and_then(|method| method.requested(dimension, &mut faults));
    let fit = fields::read(&fit, unfit.filter(|_| method.is_some()), &mut faults);
    let (Some(method), Some(fit)) = (method, fit) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    let result = match method {
        Requested::Through(method) => {
            let constructed = through(&points.points, &method).map_err(Problem::invalid)?;
            result::through(&constructed, dimension.is_parametric())?
        }
        Requested::Near(method) => near::build(&points, method, fit)?,
    };
    Ok(Built { method: name, result })
}
