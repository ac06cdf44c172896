//! The change that a kept correction predicts, in the unit and sign of an iteration's heights.

use super::{
    blocks::{Blocks, How},
    chosen::ChosenFigures,
    iteration_nodes::deviations,
    request::CorrectionRequestBody,
    result::CorrectionResultBody,
    same_nodes::Measured,
    sensitivity::Level,
};
use crate::{
    api::{faults::Faults, gears::gear::of_text, measurand::axes::AxesBody, problem::Problem},
    jobs::{Measurand, Record, RecordKind},
};
use flankfit_engine::{
    estimation::Nodes,
    gear::correction::{Correction, CorrectionSpec},
};

/// Returns the nodes of an iteration with the predicted change of each as its height; missing ones
/// stay missing. `entered` are the changes that were entered in place of the proposed ones. `None`
/// where the correction does not say what it does to these nodes, as one of the gear by a matrix
/// for other nodes.
pub fn change(
    record: &Record,
    entered: Option<&[f64]>,
    nodes: &Nodes,
    measurand: &Measurand,
) -> Result<Option<Nodes>, Problem> {
    // the correction was made by the same axes
    let factor = AxesBody::of(measurand).and_then(|axes| axes.deviation_factor()).map_err(Problem::internal)?;
    let before = deviations(nodes, factor);
    let after: Vec<f64> = match (record.draft.kind, entered) {
        (RecordKind::Correction, None) => CorrectionResultBody::of(record)?.predicted.deviation_um,
        _ => match moved(record, entered, nodes, measurand)? {
            Some(after) => after,
            None => return Ok(None),
        },
    };
    if before.len() != after.len() {
        return Err(Problem::internal("the stored correction has other nodes"));
    }
    let changes = before.iter().zip(after).map(|(before, after)| (after - before) / factor);
    with_heights(nodes, changes.collect()).map(Some).map_err(Problem::internal)
}

/// Returns the deviations after changes of the settings; `None` where the sensitivity is of other
/// nodes.
fn moved(
    record: &Record,
    entered: Option<&[f64]>,
    nodes: &Nodes,
    measurand: &Measurand,
) -> Result<Option<Vec<f64>>, Problem> {
    let stored = CorrectionResultBody::of(record)?;
    let gear = record.draft.gear.as_deref().map(of_text).transpose()?;
    let request: CorrectionRequestBody = serde_json::from_str(&record.draft.request).map_err(Problem::internal)?;
    let of_gear = record.draft.kind == RecordKind::GearCorrection;
    let how = How {
        sensitivity: &request.sensitivity,
        level: if of_gear { Level::Gear } else { Level::Iteration },
        gear: gear.as_ref(),
        absolute: Some(stored.absolute),
        trace: request.trace.as_deref().filter(|_| !of_gear),
    };
    let chosen = ChosenFigures::default();
    let measured = Measured { number: 0, nodes: nodes.clone(), measurand: measurand.clone(), chosen };
    let Some(found) = Blocks::read(&[&measured], how, &mut Faults::default()) else { return Ok(None) };
    let change = |name: &str| {
        let place = stored.settings.iter().position(|setting| setting.name == name)?;
        Some(entered.map_or(stored.settings[place].change, |entered| entered[place]))
    };
    let changes: Vec<f64> = found.settings.iter().map(|setting| change(&setting.name).unwrap_or(0.0)).collect();
    let spec = CorrectionSpec {
        weight: found.weight(),
        absolute: found.absolute,
        traces: found.traces.clone(),
        flank_zeros: found.flank_zeros,
        ..CorrectionSpec::new(found.deviation(), found.matrix, found.settings)
    };
    Ok(Correction::new(spec).ok().map(|correction| correction.predict(&changes).deviation_um))
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
    made.map_err(|faults| faults.list().first().map_or_else(String::new, |fault| fault.message.clone()))
}
