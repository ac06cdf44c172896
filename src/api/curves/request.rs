//! A curve asked for: points and a method in, the curve and its report out.

use serde::Serialize;
use utoipa::ToSchema;

use super::{
    method_reader::{self, Asked},
    methods::CurveMethodBody,
    near,
    points::{self, CurvePointsBody},
    result,
};
use crate::api::{
    built::Built,
    faults::Faults,
    fits::reader::fields::{self, FIT_KEYS, FitFields},
    json::fields::Fields,
    problem::Problem,
    shapes::fault::{CurveFields, curve_fault},
};
use flankfit_engine::{
    estimation::Nodes,
    geometry::curve::{Points, through},
};

// The two requests are declared for the document; `build` reads them.
/// A curve to build.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct CurveRequest {
    pub points: CurvePointsBody,
    pub method: CurveMethodBody,
    /// For methods near points.
    #[serde(flatten)]
    #[schema(inline)]
    pub fit: FitFields,
}

/// A curve to build and to keep with an iteration.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct KeptCurveRequest {
    /// By default the iteration's own nodes with their weights, which must be of type `curve`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub points: Option<CurvePointsBody>,
    pub method: CurveMethodBody,
    /// For methods near points.
    #[serde(flatten)]
    #[schema(inline)]
    pub fit: FitFields,
}

/// Builds the curve of a request, whose points may be left out where there are nodes of an
/// iteration. Processor work.
pub fn build(text: &[u8], own: Option<&Nodes>) -> Result<Built, Problem> {
    let mut faults = Faults::default();
    let keys = [&["points", "method"], &FIT_KEYS[..]].concat();
    let fields = Fields::of_request(text, &keys, &mut faults)?;
    let points = match (fields.get("points"), own) {
        (Some(slice), _) => points::read(slice, &mut faults),
        (None, Some(nodes)) => points::of_nodes(nodes, &mut faults),
        (None, None) => {
            faults.push("/points", "missing");
            None
        }
    };
    let method = fields.required("method", "", &mut faults);
    let (Some(points), Some(method)) = (points, method) else { return Err(Problem::invalid(faults)) };
    let graph = matches!(points.points, Points::Graph { .. });
    let method = method_reader::read(method, &points.points, &mut faults);
    let fit = fields::read(&fields, method.as_ref().and_then(Asked::takes_no_fit), &mut faults);
    let (Some(method), Some(fit)) = (method, fit) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    match method {
        Asked::Through { name, method } => {
            let constructed = through(&points.points, &method).map_err(|fault| {
                let fields = if graph {
                    CurveFields { x: "points/x", values: "points/y" }
                } else {
                    CurveFields { x: "points/xyz", values: "points/xyz" }
                };
                let mut faults = Faults::default();
                curve_fault(&fault, "", &fields, &mut faults);
                Problem::invalid(faults)
            })?;
            Ok(Built { method: name.to_owned(), result: result::through(&constructed, !graph)? })
        }
        Asked::Near { name, method } => {
            Ok(Built { method: name.to_owned(), result: near::build(&points, method, fit)? })
        }
    }
}
