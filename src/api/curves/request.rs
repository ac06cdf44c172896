//! A curve asked for: points and a method in, the curve and its report out.

use super::{
    method_reader::{self, RequestedMethod},
    methods::CurveMethodBody,
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
    geometry::curve::{Points, through},
};

request! {
    /// A curve to build.
    pub struct CurveRequest as CurveMembers {
        required points: CurvePointsBody,
        required method: CurveMethodBody,
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
        required method: CurveMethodBody,
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
    let method = method.required_text(&mut faults);
    let (Some(points), Some(method)) = (points, method) else { return Err(Problem::invalid(faults)) };
    let graph = matches!(points.points, Points::Graph { .. });
    let method = method_reader::read(method, &points.points, &mut faults);
    let fit = fields::read(&fit, method.as_ref().and_then(RequestedMethod::takes_no_fit), &mut faults);
    let (Some(method), Some(fit)) = (method, fit) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    match method {
        RequestedMethod::Through { name, method } => {
            let constructed = through(&points.points, &method).map_err(Problem::invalid)?;
            Ok(Built { method: name.to_owned(), result: result::through(&constructed, !graph)? })
        }
        RequestedMethod::Near { name, method } => {
            Ok(Built { method: name.to_owned(), result: near::build(&points, method, fit)? })
        }
    }
}
