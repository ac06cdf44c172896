//! Corrections of the gear and the iterations that they are made for, as they are stored.

use uuid::Uuid;

use super::{amendments, budget::WithPermit, caller_state::CallerState, stored};
use crate::{
    api::{gears::correction::same_nodes::Measured, problem::Problem},
    jobs::{MadeCorrection, Record, Rounds},
};

/// Nodes of iterations, with the permits for their memory.
pub type Iterations = Vec<WithPermit<Measured>>;

/// The newest correction of the gear, with its record.
pub async fn newest<'a>(
    state: &CallerState,
    job: Uuid,
    rounds: &'a Rounds,
) -> Result<Option<(&'a MadeCorrection, Record)>, Problem> {
    let Some(made) = rounds.newest_of_gear() else { return Ok(None) };
    Ok(Some((made, state.jobs.record(job, made.number, made.id).await?)))
}

/// Returns the nodes of an iteration, without those that its chosen fit excludes, with what they
/// are of; where it is asked, why their units are implausible.
pub async fn measured(
    state: &CallerState,
    job: Uuid,
    number: u32,
    units: bool,
) -> Result<WithPermit<Measured>, Problem> {
    let measurand = state.jobs.measurand(job, number).await?;
    let implausible = if units { amendments::implausible(state, job, number).await? } else { None };
    let (nodes, permit) = stored::nodes(state, job, number).await?.into_parts();
    let nodes = amendments::counted(state, job, number, nodes).await?;
    Ok(WithPermit::new(Measured { number, nodes, measurand, implausible }, permit))
}

/// The same of several iterations.
pub async fn measured_of(state: &CallerState, job: Uuid, numbers: &[u32], units: bool) -> Result<Iterations, Problem> {
    let mut all = Vec::with_capacity(numbers.len());
    for number in numbers {
        all.push(measured(state, job, *number, units).await?);
    }
    Ok(all)
}
