//! From a request's text to an answer's text: the same for the server and for the command line.

use std::time::Instant;

use super::{
    answer::{result::FitAnswer, text},
    canonical, reader,
    spec::json,
};
use crate::{
    api::{measurand::axes::MeasurandBody, problem::Problem},
    telemetry,
};
use flankfit_engine::estimation::{self, FitSpec, Nodes, Plans, near};

/// Fits and writes the answer. Processor work.
pub fn fit(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<Vec<u8>, Problem> {
    let begun = Instant::now();
    let result = estimation::fit_remembering(nodes, spec, plans)?;
    let asked = json::to_json(spec);
    let digest = canonical::input_sha256_by(nodes, spec, &asked);
    let shape = near::shape_of(spec, &result);
    let answer = FitAnswer { result: &result, shape: shape.as_ref(), input_sha256: &digest, spec: Some(&asked) };
    let text = text::write_answer(&answer, spec.include).map_err(Problem::internal)?;
    telemetry::record_fit(nodes.posted(), begun.elapsed());
    Ok(text)
}

/// A JSON fit request in, the JSON answer out. Processor work.
pub fn fit_json(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let (nodes, spec, measurand) = reader::read_fit::<MeasurandBody>(text)?;
    measurand.checked(Some(&nodes)).map_err(Problem::invalid)?;
    fit(&nodes, &spec, &Plans::default())
}
