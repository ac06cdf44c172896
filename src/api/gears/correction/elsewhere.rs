//! What a later iteration measured at the nodes of a corrected one, where it has other nodes.

use super::{
    blocks::Block,
    request::{Read, spanned},
    same_nodes::Measured,
};
use crate::api::warning::WarningBody;
use flankfit_engine::{
    estimation::Nodes,
    gear::{
        correction::teeth::{Tooth, measured_elsewhere},
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
    let range = |read: &Read| read.nodes.blocks.first()?.flank.as_ref().map(|flank| spanned(flank).ranges);
    let Some((from, to)) = tooth(earlier).zip(tooth(later)) else {
        return Err(format!(
            "{grids}: they are compared only with a machine and where the heights have one zero; measure the same nodes"
        ));
    };
    let covered = range(earlier).zip(range(later)).is_some_and(|(from, to)| {
        from.iter().zip(to).all(|(from, to)| covers([from[0].max(to[0]), from[1].min(to[1])], *from))
    });
    if !covered {
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

/// Number and arrangement of nodes.
fn words(nodes: &Nodes) -> String {
    match nodes {
        Nodes::Grid(grid) => format!("{} × {} nodes", grid.u().len(), grid.v().len()),
        other => format!("{} nodes", other.posted()),
    }
}
