//! The change that a kept correction predicts, in the unit and sign of an iteration's heights.

use serde::Deserialize;

use super::iteration_nodes::deviations;
use crate::{
    api::{measurand::axes::AxesBody, problem::Problem},
    jobs::{Measurand, Record},
};
use flankfit_engine::estimation::Nodes;

/// The part of a stored correction that is looked at.
#[derive(Deserialize)]
struct StoredResult {
    predicted: StoredPrediction,
}

#[derive(Deserialize)]
struct StoredPrediction {
    deviation_um: Vec<Option<f64>>,
}

/// The nodes of the iteration with the predicted change of each as its height; missing ones stay
/// missing.
pub fn change(record: &Record, nodes: &Nodes, measurand: &Measurand) -> Result<Nodes, Problem> {
    let stored: StoredResult = serde_json::from_str(&record.draft.result).map_err(Problem::internal)?;
    // the correction was made by the same axes
    let factor = AxesBody::of(measurand).and_then(|axes| axes.deviation_factor()).map_err(Problem::internal)?;
    let before = deviations(nodes, factor);
    let after = stored.predicted.deviation_um;
    if before.len() != after.len() {
        return Err(Problem::internal("the kept correction is of other nodes"));
    }
    let changes =
        before.iter().zip(after).map(|(before, after)| after.map_or(f64::NAN, |after| (after - before) / factor));
    with_heights(nodes, changes.collect()).map_err(Problem::internal)
}

fn with_heights(nodes: &Nodes, heights: Vec<f64>) -> Result<Nodes, String> {
    let weight = |weight: Option<&[f64]>| weight.map(<[f64]>::to_vec);
    let made = match nodes {
        Nodes::Curve(nodes) => Nodes::curve(nodes.x().to_vec(), heights, weight(nodes.weight())),
        Nodes::Scattered(nodes) => {
            Nodes::scattered(nodes.u().to_vec(), nodes.v().to_vec(), heights, weight(nodes.weight()))
        }
        Nodes::Matrix(nodes) => {
            let names = nodes.names().map(<[String]>::to_vec);
            Nodes::matrix(nodes.x().to_vec(), nodes.columns(), heights, names, weight(nodes.weight()))
        }
        Nodes::Grid(grid) => {
            let valid = grid.valid().map(<[bool]>::to_vec);
            Nodes::grid(grid.u().to_vec(), grid.v().to_vec(), heights, valid, weight(grid.weight()))
        }
    };
    made.map_err(|faults| faults.list().first().map_or_else(String::new, |fault| fault.reason.to_string()))
}
