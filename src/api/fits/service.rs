//! From a request's text to an answer's text: the same for the server and for the command line.

use std::time::Instant;

use super::{answer::FitResultBody, canonical, reader, spec::json};
use crate::{
    api::{faults::pointer_of, measurand::axes::MeasurandBody, problem::Problem},
    telemetry,
};
use flankfit_engine::estimation::{self, FitResult, FitSpec, Nodes, Plans, near};

/// A fit and its texts.
pub struct Written {
    pub result: FitResult,
    /// The spec with every default filled in.
    pub spec: String,
    /// The answer.
    pub text: Vec<u8>,
}

/// Fits and writes the answer, with the spec where `with_spec`; `place` turns the paths of a
/// refused fit into pointers into the request. Processor work.
pub fn write(
    nodes: &Nodes,
    spec: &FitSpec,
    plans: &Plans,
    with_spec: bool,
    place: impl Fn(&str) -> String,
) -> Result<Written, Problem> {
    let begun = Instant::now();
    let result = estimation::fit_remembering(nodes, spec, plans).map_err(|error| Problem::of_fit(error, place))?;
    let spec_text = json::to_json(spec);
    let digest = canonical::input_sha256_by(nodes, spec, &spec_text);
    let shape = near::shape_of(spec, &result);
    let mut answer = FitResultBody::new(&result, shape.as_ref(), digest);
    answer.spec = with_spec.then(|| spec_text.as_str().into());
    let text = answer.text().map_err(Problem::internal)?;
    telemetry::record_fit(nodes.posted(), begun.elapsed());
    Ok(Written { result, spec: spec_text, text })
}

/// Fits and writes the answer with what was asked. Processor work.
pub fn fit(nodes: &Nodes, spec: &FitSpec, plans: &Plans) -> Result<Vec<u8>, Problem> {
    write(nodes, spec, plans, true, pointer_of).map(|written| written.text)
}

/// A JSON fit request in, the JSON answer out. Processor work.
pub fn fit_json(text: &[u8]) -> Result<Vec<u8>, Problem> {
    let (nodes, spec, measurand) = reader::read_fit::<MeasurandBody>(text)?;
    measurand.checked(Some(&nodes)).map_err(Problem::invalid)?;
    fit(&nodes, &spec, &Plans::default())
}
