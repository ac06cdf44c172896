//! The points of a surface that are closest to given nodes: orthogonal distances.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{
    contract::{Pair, Triple},
    curves::closest::read_points,
    faults::Faults,
    json::{members::of_request, request::request, writer::whole_of},
    problem::Problem,
    shapes::places::{Values, out_of_range},
};
use flankfit_engine::geometry::surface::{ClosestPoint, SurfaceShape};

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
#[derive(Debug, Serialize, Deserialize, ToSchema)]
#[schema(as = SurfaceFeet)]
pub struct SurfaceFeetBody {
    /// `[u, v]` of each.
    #[schema(value_type = Vec<Pair>)]
    pub parameters: Values,
    /// The closest points; for a graph (u, v, z).
    #[schema(value_type = Vec<Triple>)]
    pub points: Values,
    /// Distance of each given node from the surface, in the caller's unit, never negative.
    #[schema(value_type = Vec<f64>)]
    pub distances: Values,
    /// Above 0 on the side that the normal S_u × S_v points to. Absent where there is no normal at
    /// one of the closest points.
    #[schema(value_type = Option<Vec<f64>>)]
    pub signed_distances: Option<Values>,
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
    let body = SurfaceFeetBody {
        parameters: Values { width: 2, flat: feet.iter().flat_map(|foot| foot.parameters).collect() },
        points: Values::new(3, feet.iter().map(|foot| foot.point)),
        distances: feet.iter().map(|foot| foot.distance).collect::<Vec<_>>().into(),
        signed_distances: signed.map(Values::from),
        orthogonal: feet.iter().map(|foot| foot.is_orthogonal).collect(),
    };
    whole_of(128 + 22 * 9 * feet.len(), &body).map_err(|_| out_of_range("/points"))
}
