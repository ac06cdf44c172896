//! Stored nodes, charged to the budget before they are read.

use super::prelude::*;

/// Nodes of at most so many bytes are read without being asked for their length first.
const SMALL: usize = 64 << 10;
/// Times that stored bytes are in memory: as they are read, as nodes, and what is computed with
/// them.
const COPIES: usize = 3;

/// The nodes of an iteration, with a permit for what they take.
pub async fn stored(context: Context<'_>, job: Uuid, number: u32) -> Result<WithPermit<Nodes>, Problem> {
    let length = match context.jobs.nodes_up_to(job, number, SMALL).await? {
        Ok(nodes) => return Ok(WithPermit::new(nodes, context.budget.take(COPIES * SMALL / 4)?)),
        Err(length) => length,
    };
    let permit = context.budget.take(COPIES.saturating_mul(length))?;
    Ok(WithPermit::new(context.jobs.nodes(job, number).await?, permit))
}
