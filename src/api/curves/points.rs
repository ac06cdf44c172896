//! The points of a curve: of a request, or the nodes of an iteration.

use serde::Serialize;
use utoipa::ToSchema;

use crate::api::{
    contract::Coordinates,
    faults::Faults,
    json::{members::of_object, request::request},
};
use flankfit_engine::{
    estimation::Nodes,
    geometry::{
        curve::{Parametrization, Points},
        space::{Dimension, Vector},
    },
    words::counted,
};

/// Points of a curve: a graph y(x), or points of plane or space in the order in which the curve
/// passes them.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[serde(untagged)]
#[schema(as = CurvePoints)]
pub enum CurvePointsBody {
    Graph(GraphPoints),
    Space(SpacePoints),
}

request! {
    /// Points (x, y) of a graph.
    pub struct GraphPoints as GraphPointsMembers {
        /// All different. Ascending, except for polynomials; the order is never changed.
        required x: Vec<f64>,
        /// The value at each x.
        required y: Vec<f64>,
    }
}

request! {
    /// Points of plane or space.
    pub struct SpacePoints as SpacePointsMembers {
        /// `[x, y]` or `[x, y, z]` each.
        #[schema(value_type = Vec<Coordinates>)]
        required xyz: Vec<Vec<f64>>,
        /// Default `chord_length`.
        optional parametrization: Parametrization,
    }
}

/// Points to be passed or approached, and where in the request they stand.
pub struct GivenPoints {
    pub points: Points,
    /// Weights that the nodes of an iteration have.
    pub weight: Option<Vec<f64>>,
}

/// Reads the points that stand at `/points`.
pub fn read(slice: &[u8], faults: &mut Faults) -> Option<GivenPoints> {
    const AT: &str = "/points";
    let members: (GraphPointsMembers<'_>, SpacePointsMembers<'_>) = of_object(slice, AT, faults)?;
    let (GraphPointsMembers { x, y }, SpacePointsMembers { xyz, parametrization }) = members;
    let points = if xyz.is_given() {
        if let Some(name) = x.name_if_given().or(y.name_if_given()) {
            faults.push(format!("{AT}/{name}"), "give either `x` and `y`, or `xyz`");
            return None;
        }
        let parametrization = parametrization.optional(faults)?;
        let (flat, lengths) = xyz.rows(faults)?;
        let (dimension, points) = space(&flat, &lengths, &xyz.pointer(), faults)?;
        let parametrization = parametrization.unwrap_or(Parametrization::ChordLength);
        Points::Space { points, dimension, parametrization }
    } else {
        if parametrization.is_given() {
            faults.push(parametrization.pointer(), "the parameter of a graph is x");
        }
        let (x, y) = (x.numbers(faults), y.numbers(faults));
        Points::Graph { x: x?, y: y? }
    };
    Some(GivenPoints { points, weight: None })
}

/// The nodes of an iteration as points.
pub fn of_nodes(nodes: &Nodes, faults: &mut Faults) -> Option<GivenPoints> {
    match nodes {
        Nodes::Curve(nodes) => {
            // a node of weight 0 is left out, whatever the method
            let counts = |k: usize| nodes.weight().as_ref().is_none_or(|weight| weight[k] > 0.0);
            let of = |values: &[f64]| values.iter().enumerate().filter(|(k, _)| counts(*k)).map(|(_, x)| *x).collect();
            Some(GivenPoints {
                points: Points::Graph { x: of(nodes.x()), y: of(nodes.y()) },
                weight: nodes.weight().map(of),
            })
        }
        _ => {
            faults.push_missing("/points", "missing; the nodes of this iteration are not a curve");
            None
        }
    }
}

/// Points of plane or space from rows of equal length.
pub fn space(flat: &[f64], lengths: &[usize], at: &str, faults: &mut Faults) -> Option<(Dimension, Vec<Vector>)> {
    let width = lengths.first().copied().unwrap_or(3);
    let Some(dimension) = Dimension::of(width).filter(|dimension| dimension.is_parametric()) else {
        faults.push(
            format!("{at}/0"),
            format!("{}, where [x, y] or [x, y, z] is needed", counted(width, "number", "numbers")),
        );
        return None;
    };
    let before = faults.count();
    for (i, length) in lengths.iter().enumerate().filter(|(_, length)| **length != width) {
        faults.push(
            format!("{at}/{i}"),
            format!("{}, where the first point has {width}", counted(*length, "number", "numbers")),
        );
    }
    if faults.count() > before {
        return None;
    }
    let point = |row: &[f64]| Vector::new(row[0], row[1], row.get(2).copied().unwrap_or(0.0));
    Some((dimension, flat.chunks_exact(width).map(point).collect()))
}
