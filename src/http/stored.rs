//! Stored nodes, charged to the budget before they are read.

use uuid::Uuid;

use super::{budget::WithPermit, caller_state::CallerState};
use crate::api::problem::Problem;
use flankfit_engine::estimation::Nodes;

/// Nodes of at most so many bytes are read without being asked for their length first.
const SMALL: usize = 64 << 10;
/// Times that stored bytes are in memory: as they are read, as nodes, and what is computed with
/// them.
const COPIES: usize = 3;

/// The nodes of an iteration, with a permit for what they take.
pub async fn nodes(state: &CallerState, job: Uuid, number: u32) -> Result<WithPermit<Nodes>, Problem> {
    let length = match state.jobs.nodes_up_to(job, number, SMALL).await? {
        Ok(nodes) => return Ok(WithPermit::new(nodes, state.budget.take(COPIES * SMALL / 4)?)),
        Err(length) => length,
    };
    let permit = state.budget.take(COPIES.saturating_mul(length))?;
    Ok(WithPermit::new(state.jobs.nodes(job, number).await?, permit))
}
