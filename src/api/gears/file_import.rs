//! A file of a gear tester as an iteration: nodes of one flank with their second-order surface, and the evaluation of all traces.

use std::sync::Arc;

use super::{
    deviations,
    file::{self, ImportSpecBody},
};
use crate::{
    api::{
        job_fits,
        problem::Problem,
        reader::read_json,
        records::{self, Built},
    },
    estimation::{
        FitSpec, Plans,
        spec::{Degree, Model, PolynomialBasis, Terms},
    },
    gear::Gear,
    jobs::{IterationDraft, RecordKind},
};

/// Reads, evaluates and fits. Processor work.
pub fn draft(
    content: &[u8],
    name: Option<&str>,
    spec: Option<&[u8]>,
    gear: Option<&Gear>,
    plans: &Plans,
) -> Result<IterationDraft, Problem> {
    let spec: ImportSpecBody = match spec {
        Some(text) => {
            read_json(text).map_err(|error| Problem::from(error).placed(|pointer| format!("/spec{pointer}")))?
        }
        None => ImportSpecBody::default(),
    };
    let read = file::read(content, name, &spec, gear)?;
    let flank = read.flank(&spec)?;
    let nodes = flank.nodes()?;
    let order = flank.order();
    let surface = FitSpec::new(Model::Polynomial {
        degree: Degree::Both(order),
        terms: Terms::Total,
        basis: PolynomialBasis::Monomial,
    });
    // neither nodes nor model are the caller's
    let computed =
        job_fits::compute(&nodes, &surface, plans).map_err(|problem| problem.placed(|_| "/file".to_owned()))?;
    let name: String = name.unwrap_or("a file").chars().take(100).collect();
    let plane = if order == 1 { " (a plane: its traces are a cross, which tells no twist)" } else { "" };
    let of = format!("{} flank of tooth {}{plane}", file::word(flank.side), flank.tooth);
    let request = serde_json::json!({"file": name, "spec": spec, "warnings": read.warnings}).to_string();
    let mut records = Vec::new();
    if let Some(evaluation) = &read.evaluation {
        let result = serde_json::to_vec(evaluation).map_err(Problem::internal)?;
        let built = Built { method: "import".to_owned(), result };
        records.push(records::draft(RecordKind::Evaluation, request.as_bytes(), built)?);
    }
    if let Some(found) = &read.deviations {
        let built = deviations::imported(&read.gear, found, &read.warnings)?;
        records.push(records::draft(RecordKind::Deviations, request.as_bytes(), built)?);
    }
    Ok(IterationDraft {
        nodes: Arc::new(nodes),
        computed,
        measured_at: None,
        instrument: None,
        operator: None,
        note: Some(spec.note.unwrap_or_else(|| format!("{of}, imported from {name}"))),
        records,
    })
}
