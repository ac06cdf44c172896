//! The points of a curve that are closest to given ones.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::points::space;
use crate::api::{
    contract::Coordinates,
    faults::Faults,
    json::{members::of_request, numbers::read_rows, request::request, writer::whole_of},
    problem::Problem,
    shapes::places::{Values, out_of_range},
};
use flankfit_engine::{
    geometry::{
        curve::{Curve, CurveShape, closest::Closest},
        space::{Dimension, Vector},
    },
    words::counted,
};

/// Most points of one request.
pub const MOST_POINTS: usize = 100_000;

request! {
    /// A curve and points.
    #[schema(as = ClosestOnCurve)]
    pub struct ClosestOnCurveBody as ClosestOnCurveMembers {
        required curve: CurveShape,
        /// `[x, y]` each, for a curve in space `[x, y, z]`; at most 100,000.
        #[schema(value_type = Vec<Coordinates>, max_items = 100_000)]
        required points: Vec<Vec<f64>>,
    }
}

/// Closest points, in the order of the given points.
#[skip_serializing_none]
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = CurveFeet)]
pub struct CurveFeetBody {
    /// Parameters of the closest points on the curve.
    #[schema(value_type = Vec<f64>)]
    pub parameters: Values,
    /// The closest points; for a graph (x, y).
    #[schema(value_type = Vec<Coordinates>)]
    pub points: Values,
    /// Distance of each given point from the curve, in the caller's unit, never negative.
    #[schema(value_type = Vec<f64>)]
    pub distances: Values,
    /// For a plane curve or graph: > 0 where the given point lies to the left of the curve. Absent
    /// where the curve has no direction at one of the closest points.
    #[schema(value_type = Option<Vec<f64>>)]
    pub signed_distances: Option<Values>,
}

/// Answers a request. Processor work.
pub fn answer(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let mut faults = Faults::default();
    let members: ClosestOnCurveMembers<'_> = of_request(text, &mut faults)?;
    let curve = members.curve.required(&mut faults);
    let points = members.points.required_text(&mut faults);
    let (Some(curve), Some(points)) = (curve, points) else { return Err(Problem::invalid(faults)) };
    let width = if curve.dimension() == Dimension::Space { 3 } else { 2 };
    let points = read_points(points, width, &mut faults);
    let points = points.filter(|_| faults.is_empty()).ok_or_else(|| Problem::invalid(faults))?;
    write(&curve, &points, width)
}

/// Points of `width` coordinates that stand at `/points`.
pub fn read_points(slice: &[u8], width: usize, faults: &mut Faults) -> Option<Vec<Vector>> {
    const AT: &str = "/points";
    let (flat, lengths) = read_rows(slice, AT, faults)?;
    if lengths.len() > MOST_POINTS {
        faults.push(AT, format!("{} points; at most {MOST_POINTS} are allowed", lengths.len()));
        return None;
    }
    if lengths.is_empty() {
        return Some(Vec::new());
    }
    let (dimension, points) = space(&flat, &lengths, AT, faults)?;
    if dimension.count() != width {
        faults.push(
            format!("{AT}/0"),
            format!("{}, where the shape has {width}", counted(dimension.count(), "coordinate", "coordinates")),
        );
        return None;
    }
    Some(points)
}

fn write(curve: &CurveShape, points: &[Vector], width: usize) -> Result<Vec<u8>, Problem> {
    let closest = Closest::on(curve);
    let feet: Vec<_> = points.iter().map(|point| closest.to(*point)).collect();
    let numbers = |of: fn(&_) -> f64| feet.iter().map(of).collect::<Vec<_>>().into();
    let signed: Option<Vec<f64>> = feet.iter().map(|foot| foot.signed_distance).collect();
    let body = CurveFeetBody {
        parameters: numbers(|foot| foot.parameter),
        points: Values::new(width, feet.iter().map(|foot| foot.point)),
        distances: numbers(|foot| foot.distance),
        signed_distances: signed.filter(|_| width == 2).map(Values::from),
    };
    whole_of(128 + 22 * feet.len() * (width + 3), &body).map_err(|_| out_of_range("/points"))
}
