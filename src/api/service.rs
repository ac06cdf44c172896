//! From a request's text to an answer's text: the same for the server and for the command line.

use std::time::Instant;

use super::{
    canonical, fit_text,
    problem::Problem,
    reader::{self, NoExtra},
};
use crate::{
    estimation::{self, FitSpec, Nodes, Plans, near},
    telemetry,
};

/// Fits and writes the answer. Processor work.
pub fn fit(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<Vec<u8>, Problem> {
    let begun = Instant::now();
    let result = estimation::fit_remembering(nodes, spec, plans)?;
    let text = fit_text::write(&result, near::shape_of(spec, &result).as_ref(), &canonical::input_sha256(nodes, spec))
        .map_err(Problem::internal)?;
    telemetry::record_fit(nodes.posted(), begun.elapsed());
    Ok(text)
}

/// A JSON fit request in, the JSON answer out. Processor work.
pub fn fit_json(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let (nodes, spec, NoExtra {}) = reader::read_fit(text)?;
    fit(&nodes, &spec, &Plans::default())
}
