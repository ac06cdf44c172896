//! The points of a surface that are closest to given nodes: orthogonal distances.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    contract::{Pair, Triple},
    curves::closest::read_points,
    faults::Faults,
    json::{members::of_request, request::request, writer::Json},
    problem::Problem,
    shapes::places::{out_of_range, write_points},
};
use flankfit_engine::geometry::surface::{ClosestPoint, SurfacePoint, SurfaceShape};

request! {
    /// A surface and nodes.
    #[schema(as = ClosestOnSurface)]
    pub struct ClosestOnSurfaceBody as ClosestOnSurfaceMembers {
        required surface: SurfaceShape,
        /// `[x, y, z]` each, of a graph `[u, v, z]`; at most 100,000.
        #[schema(value_type = Vec<Triple>, max_items = 100_000)]
        required points: Vec<Vec<f64>>,
    }
}

/// Closest points, in the order of the given nodes.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SurfaceFeet)]
pub struct SurfaceFeetBody {
    /// `[u, v]` of each.
    #[schema(value_type = Vec<Pair>)]
    pub parameters: Vec<Vec<f64>>,
    /// The closest points; for a graph (u, v, z).
    #[schema(value_type = Vec<Triple>)]
    pub points: Vec<Vec<f64>>,
    /// Distance of each given node from the surface, in the caller's unit, never negative.
    pub distances: Vec<f64>,
    /// Above 0 on the side that the normal S_u × S_v points to. Absent where there is no normal at
    /// one of the closest points.
    pub signed_distances: Option<Vec<f64>>,
    /// True if the connecting line is perpendicular to the surface; otherwise the closest point
    /// lies on a border or an edge.
    pub orthogonal: Vec<bool>,
}

/// Answers a request. Processor work.
pub fn answer(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let mut faults = Faults::default();
    let members: ClosestOnSurfaceMembers<'_> = of_request(text, &mut faults)?;
    let surface = members.surface.required(&mut faults);
    let points = members.points.required_with(&mut faults, |slice, _, faults| read_points(slice, 3, faults));
    let (Some(surface), Some(points)) = (surface, points) else { return Err(Problem::invalid(faults)) };
    faults.into_result(()).map_err(Problem::invalid)?;
    let feet = ClosestPoint::on(&surface).to_each(&points);
    let signed: Option<Vec<f64>> = feet.iter().map(|foot| foot.signed_distance).collect();
    let numbers = |of: fn(&SurfacePoint) -> f64| feet.iter().map(of).collect::<Vec<_>>();
    let parameters: Vec<f64> = feet.iter().flat_map(|foot| foot.parameters).collect();
    let mut json = Json::with_capacity(128 + 22 * 9 * feet.len());
    let mut object = json.object();
    object.values("parameters", 2, &parameters);
    write_points(&mut object, "points", 3, feet.iter().map(|foot| foot.point));
    object.numbers("distances", &numbers(|foot| foot.distance));
    if let Some(signed) = &signed {
        object.numbers("signed_distances", signed);
    }
    object.field("orthogonal", &feet.iter().map(|foot| foot.is_orthogonal).collect::<Vec<_>>()).end();
    json.finish().map_err(|_| out_of_range("/points"))
}
