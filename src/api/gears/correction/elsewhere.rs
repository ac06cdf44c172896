//! What a later iteration measured at the nodes of a corrected one, where it has other nodes.

use super::{blocks::Block, request::Read, same_nodes::Measured};
use crate::api::warning::WarningBody;
use flankfit_engine::{
    estimation::Nodes,
    gear::{
        correction::{
            machine::FlankNode,
            teeth::{Tooth, measured_elsewhere},
        },
        evaluation::flank_surface::covers,
    },
};

/// What a later iteration measured, at the nodes of the corrected one.
pub struct AtNodes {
    pub measured: Vec<f64>,
    pub weight: Option<Vec<f64>>,
    pub warning: Option<WarningBody>,
}

/// The same of nodes at other places, by surfaces of second order; an error says why it cannot be.
pub fn elsewhere([before, after]: [&Measured; 2], [earlier, later]: [&Read; 2]) -> Result<AtNodes, String> {
    let grids = format!(
        "iteration {} has {} at other places than the corrected one, which has {}",
        after.number,
        words(&after.nodes),
        words(&before.nodes)
    );
    let tooth = |read: &Read| {
        let [Block { flank: Some(flank), mean, traces: None, .. }] = &read.nodes.blocks[..] else { return None };
        let (deviation, weight) = (mean.deviation.clone(), mean.weight.clone());
        Some(Tooth { deviation, weight, places: Some(flank.places.clone()) })
    };
    let Some((from, to)) = tooth(earlier).zip(tooth(later)) else {
        return Err(format!(
            "{grids}: they are compared only with a machine and where the heights have one zero; measure the same nodes"
        ));
    };
    let covered = |(from, to): ([f64; 2], [f64; 2])| covers([from[0].max(to[0]), from[1].min(to[1])], from);
    if !spans(&from).into_iter().zip(spans(&to)).all(covered) {
        return Err(format!("{grids}: the later ones cover too little of these; measure the same nodes"));
    }
    let Some(measured) = measured_elsewhere(&from, &to) else {
        return Err(format!(
            "{grids}: one of the two determines no surface of second order to compare by; measure the same nodes"
        ));
    };
    let message = format!("{grids}: the changes of their surfaces of second order are compared");
    let warning = Some(WarningBody::new("compared_by_surfaces", message));
    Ok(AtNodes { measured, weight: earlier.spec.weight.clone(), warning })
}

/// Ranges of roll length and of z that the nodes with a deviation span.
fn spans(tooth: &Tooth) -> [[f64; 2]; 2] {
    let counts = |k: usize| !tooth.deviation[k].is_nan() && tooth.weight.as_ref().is_none_or(|weight| weight[k] > 0.0);
    let places = tooth.places.iter().flatten().enumerate().filter(|(k, _)| counts(*k));
    places.fold([[f64::INFINITY, f64::NEG_INFINITY]; 2], |[u, v], (_, FlankNode { roll_length, z, .. })| {
        [[u[0].min(*roll_length), u[1].max(*roll_length)], [v[0].min(*z), v[1].max(*z)]]
    })
}

/// Number and arrangement of nodes.
fn words(nodes: &Nodes) -> String {
    match nodes {
        Nodes::Grid(grid) => format!("{} × {} nodes", grid.u().len(), grid.v().len()),
        other => format!("{} nodes", other.posted()),
    }
}
