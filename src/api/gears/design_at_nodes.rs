//! The job's design at the nodes of an iteration.

use serde::Serialize;
use utoipa::ToSchema;

use super::{
    correction::iteration_nodes::{self, Coordinates},
    fit_figures::missing,
    gear::of_job,
    requirements::RequirementsBody,
};
use crate::{
    api::{
        faults::Faults,
        measurand::axes::AxesBody,
        problem::{Problem, ProblemCode},
    },
    jobs::{Job, Measurand},
};
use flankfit_engine::{estimation::Nodes, gear::correction::Flank};

/// Deviations of a flank that is made as designed.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
#[schema(as = DesignAtNodes, example = json!({"deviation_um": [-4.0, -1.0, 0.0, -1.0, -4.0]}))]
pub struct DesignAtNodesBody {
    /// Along the normal, positive where material protrudes: an entry for each node in the order
    /// posted, row by row of a grid, missing nodes included.
    pub deviation_um: Vec<f64>,
}

/// Returns the design at the nodes of an iteration, or the conflict that says what is missing.
pub fn at_nodes(job: &Job, measurand: &Measurand, nodes: &Nodes) -> Result<DesignAtNodesBody, Problem> {
    let refused = |why: String| Problem::new(ProblemCode::Conflict, why);
    let first = |faults: &Faults| faults.list().first().map_or_else(String::new, |fault| fault.detail.clone());
    let requirements = RequirementsBody::of(job).unwrap_or_default();
    let gear = of_job(job)?;
    let axes = AxesBody::of(measurand).map_err(Problem::internal)?;
    if let Some((_, how)) = missing(&axes, measurand.flank, gear.is_some()).into_iter().next() {
        return Err(refused(how));
    }
    let (Some(design), Some(gear), Some(side), Some((profile, u))) =
        (&requirements.design, gear, measurand.flank, axes.profile().map_err(refused)?)
    else {
        return Err(refused("the job's requirements have no `design`: send one by `PATCH` of the job".to_owned()));
    };
    let coordinates = Coordinates { profile, u, v: axes.along().map_err(refused)? };
    let places = iteration_nodes::places(nodes, &gear, side, coordinates).map_err(|faults| refused(first(&faults)))?;
    let ranges = iteration_nodes::ranges(nodes, &places, &gear);
    let design = design.on(&gear, side, "").map_err(|faults| refused(first(&faults)))?;
    let flank = Flank { gear, side, places, ranges, traces: None, terms: requirements.figure_terms() };
    let deviation_um = flank
        .designed(&design)
        .map_err(|found| refused(format!("the job's design is impossible on this flank: {}", first(&found.into()))))?;
    Ok(DesignAtNodesBody { deviation_um })
}
