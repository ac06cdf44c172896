//! Corrections of the gear and the iterations that they are made for, as they are stored.

use super::decide;
use super::prelude::*;
use crate::{
    api::gears::{correction::same_nodes::Measured, evaluation::tooth_shift},
    jobs::{MadeCorrection, Record, Rounds},
};
use flankfit_engine::gear::evaluation::tooth_shift::ToothShift;

/// Nodes of iterations, with the permits for their memory.
pub type Iterations = Vec<WithPermit<Measured>>;

/// The newest correction of the gear, with its record.
pub async fn newest<'a>(
    context: Context<'_>,
    job: Uuid,
    rounds: &'a Rounds,
) -> Result<Option<(&'a MadeCorrection, Record)>, Problem> {
    let Some(made) = rounds.newest_of_gear() else { return Ok(None) };
    Ok(Some((made, context.jobs.record(job, made.number, made.id).await?)))
}

/// Returns the nodes of an iteration, without those that its chosen fit excludes, with the figures
/// of that fit.
pub async fn measured(context: Context<'_>, job: Uuid, number: u32) -> Result<WithPermit<Measured>, Problem> {
    let iteration = context.jobs.iteration(job, number).await?;
    let (nodes, permit) = nodes::stored(context, job, number).await?.into_parts();
    let (nodes, chosen) = decide::counted(context, &iteration, nodes).await?;
    Ok(WithPermit::new(Measured { number, nodes, measurand: iteration.measurand, chosen }, permit))
}

/// The same of several iterations.
pub async fn measured_of(context: Context<'_>, job: Uuid, numbers: &[u32]) -> Result<Iterations, Problem> {
    let mut all = Vec::with_capacity(numbers.len());
    for number in numbers {
        all.push(measured(context, job, *number).await?);
    }
    Ok(all)
}

/// Returns the shift of tooth numbers between the iterations before and after a correction, by the
/// newest pitches of each; `None` without both.
pub async fn tooth_shift(
    context: Context<'_>,
    job: Uuid,
    before: &[u32],
    after: &[u32],
) -> Result<Option<ToothShift>, Problem> {
    let Some(after) = newest_pitch(context, job, after).await? else { return Ok(None) };
    let Some(before) = newest_pitch(context, job, before).await? else { return Ok(None) };
    context.pool.run(move || tooth_shift::between(&before, &after)).await?
}

async fn newest_pitch(context: Context<'_>, job: Uuid, numbers: &[u32]) -> Result<Option<Record>, Problem> {
    let mut newest: Option<Record> = None;
    for number in numbers {
        let found = context.jobs.latest_record(job, *number, RecordKind::Pitch).await?;
        newest = newest.into_iter().chain(found).max_by_key(|record| record.created_at);
    }
    Ok(newest)
}
