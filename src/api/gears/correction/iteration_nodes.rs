//! The nodes of an iteration as deviations of a flank: heights in µm, u along the profile and v
//! along the axis.

use crate::api::faults::Faults;
use flankfit_engine::{
    estimation::Nodes,
    gear::{
        Gear, ProfileAxis, Side,
        correction::machine::{FlankNode, Ranges},
    },
};

/// Returns the deviations in µm, positive where material protrudes, in the order posted, row by row
/// of a grid; NaN where missing. `factor` makes them of the heights.
pub fn deviations(nodes: &Nodes, factor: f64) -> Vec<f64> {
    let mut heights = heights(nodes);
    if factor != 1.0 {
        heights.iter_mut().for_each(|z| *z *= factor);
    }
    heights
}

fn heights(nodes: &Nodes) -> Vec<f64> {
    match nodes {
        Nodes::Curve(nodes) => nodes.y().to_vec(),
        Nodes::Scattered(nodes) => nodes.z().to_vec(),
        Nodes::Matrix(nodes) => nodes.y().to_vec(),
        Nodes::Grid(grid) => {
            let valid = |k: usize| grid.valid().as_ref().is_none_or(|valid| valid[k]);
            grid.z().iter().enumerate().map(|(k, z)| if valid(k) { *z } else { f64::NAN }).collect()
        }
    }
}

/// Weights in the same order.
pub fn weights(nodes: &Nodes) -> Option<Vec<f64>> {
    match nodes {
        Nodes::Curve(nodes) => nodes.weight().map(<[f64]>::to_vec),
        Nodes::Scattered(nodes) => nodes.weight().map(<[f64]>::to_vec),
        Nodes::Matrix(nodes) => nodes.weight().map(<[f64]>::to_vec),
        Nodes::Grid(grid) => grid.weight().map(<[f64]>::to_vec),
    }
}

/// Quantities of u and v of nodes on a flank.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coordinates {
    pub profile: ProfileAxis,
    /// Factor that converts u to the unit of the profile axis.
    pub u: f64,
    /// Factor that converts v to z in mm.
    pub v: f64,
}

/// Returns the places of the nodes on the flank of a gear; an error at `/sensitivity` if they are
/// not known.
pub fn places(nodes: &Nodes, gear: &Gear, side: Side, of: Coordinates) -> Result<Vec<FlankNode>, Faults> {
    let pairs: Vec<(f64, f64)> = match nodes {
        Nodes::Scattered(nodes) => nodes.u().iter().copied().zip(nodes.v().iter().copied()).collect(),
        Nodes::Grid(grid) => grid.u().iter().flat_map(|u| grid.v().iter().map(|v| (*u, *v))).collect(),
        Nodes::Curve(_) | Nodes::Matrix(_) => {
            let detail = "a machine's sensitivity needs nodes with u (along the profile) and v (along the axis)";
            return Err(Faults::one("/sensitivity/machine", detail));
        }
    };
    let (count, mut below) = (pairs.len(), 0usize);
    let mut places = Vec::with_capacity(count);
    for (u, z) in pairs {
        match of.profile.roll_length(gear, of.profile.requested(of.u * u)) {
            Some(roll_length) => places.push(FlankNode { side, roll_length, z: of.v * z }),
            None => below += 1,
        }
    }
    if below > 0 {
        let detail = format!(
            "{below} of the iteration's {count} nodes are outside the involute: check the quantity \
            of u"
        );
        return Err(Faults::one("/sensitivity/profile_axis", detail));
    }
    Ok(places)
}

/// Returns the ranges of the counted nodes.
pub fn ranges(nodes: &Nodes, places: &[FlankNode], gear: &Gear) -> Ranges {
    let (heights, weights) = (heights(nodes), weights(nodes));
    let counts = |k: &usize| !heights[*k].is_nan() && weights.as_ref().is_none_or(|weights| weights[*k] > 0.0);
    let counted: Vec<&FlankNode> = (0..places.len()).filter(counts).map(|k| &places[k]).collect();
    let span = |of: fn(&FlankNode) -> f64| {
        counted
            .iter()
            .map(|place| of(place))
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    };
    let [low, high] = span(|place| place.roll_length);
    // from root to tip
    let profile = if gear.outward() < 0.0 { [high, low] } else { [low, high] };
    Ranges { profile, helix: span(|place| place.z) }
}
