//! From a request's text to an answer's text: the same for the server and for the command line.

use std::time::Instant;

use super::{
    canonical,
    fit_result::FitResultBody,
    problem::Problem,
    reader::{self, NoExtra},
};
use crate::{
    estimation::{self, FitSpec, Nodes, Plans},
    telemetry,
};

/// Fits and shapes the answer. Processor work.
pub fn fit(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<FitResultBody, Problem> {
    let begun = Instant::now();
    let result = estimation::fit_remembering(nodes, spec, plans)?;
    let body = FitResultBody::new(result, canonical::input_sha256(nodes, spec))?;
    telemetry::record_fit(nodes.posted(), begun.elapsed());
    Ok(body)
}

/// A JSON fit request in, the JSON answer out. Processor work.
pub fn fit_json(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let (nodes, spec, NoExtra {}) = reader::read_fit(text)?;
    fit(&nodes, &spec, &Plans::default())?.to_json().map_err(Problem::internal)
}
