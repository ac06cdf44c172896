//! The changes that were entered on the machine after a correction, as they are stored.

use super::prelude::*;
use super::rounds;
use crate::{
    api::gears::correction::applied::{self, AppliedChangesBody, AppliedRequestBody},
    jobs::{Measurand, PageRequest, Predecessors, Record, RecordDraft},
};

/// Records of one page.
const PAGE: u32 = 200;

/// Returns what was entered after a correction: the newest entry kept with its iteration or with
/// one of those that measured it, `later`.
pub async fn entered_after(
    context: Context<'_>,
    job: Uuid,
    correction: &Record,
    iteration: u32,
    later: &[u32],
) -> Result<Option<AppliedChangesBody>, Problem> {
    let mut newest: Option<AppliedChangesBody> = None;
    for number in std::iter::once(&iteration).chain(later) {
        let Some(found) = newest_entry(context, job, correction.id, *number).await? else { continue };
        if newest.as_ref().is_none_or(|newest| newest.created_at.0 <= found.created_at.0) {
            newest = Some(found);
        }
    }
    Ok(newest)
}

/// Returns the newest entry for the correction that is stored with the iteration.
async fn newest_entry(
    context: Context<'_>,
    job: Uuid,
    correction: Uuid,
    number: u32,
) -> Result<Option<AppliedChangesBody>, Problem> {
    let mut entries = Vec::new();
    let mut page = PageRequest { limit: PAGE, after: None };
    loop {
        let listed = context.jobs.records(job, number, page).await?;
        entries.extend(listed.items.into_iter().filter(|record| record.kind == RecordKind::Applied));
        match listed.next {
            Some(next) => page.after = Some(next),
            None => break,
        }
    }
    while let Some(entry) = entries.pop() {
        let record = context.jobs.record(job, number, entry.id).await?;
        if let Some(found) = applied::entered_after(correction, &record)? {
            return Ok(Some(found));
        }
    }
    Ok(None)
}

/// Returns the newest correction of the gear, with the number of its iteration.
pub async fn newest_of_gear(context: Context<'_>, job: Uuid) -> Result<Option<(u32, Record)>, Problem> {
    let made = context.jobs.rounds(job).await?;
    let found = rounds::newest(context, job, &made).await?;
    Ok(found.map(|(made, record)| (made.number, record)))
}

/// Returns the newest correction of an iteration.
pub async fn newest(context: Context<'_>, job: Uuid, number: u32) -> Result<Option<Record>, Problem> {
    Ok(context.jobs.latest_record(job, number, RecordKind::Correction).await?)
}

/// Returns the record of what was entered before an iteration of `measurand` that is about to be
/// stored: after the newest correction of the flank's iteration before it, or of the gear.
pub async fn before_next(
    context: Context<'_>,
    job: Uuid,
    measurand: &Measurand,
    asked: &AppliedRequestBody,
) -> Result<RecordDraft, Problem> {
    let wanted = Predecessors { of: measurand.clone(), from: 1, before: None, most: 1 };
    let Some(previous) = context.jobs.predecessors(job, wanted).await?.pop() else {
        let detail = format!("the job has no earlier iteration of {} that was corrected", measurand.words());
        return Err(Problem::invalid(Faults::one("/applied", detail)));
    };
    let own = newest(context, job, previous.number).await?.map(|correction| (previous.number, correction));
    // the newer of the corrections of the iteration and of the gear
    let newest = own.into_iter().chain(newest_of_gear(context, job).await?).max_by_key(|(_, made)| made.created_at);
    match newest {
        Some((number, correction)) => applied::draft(asked, &correction, number, "/applied"),
        None => {
            let detail = format!("iteration {}, the last of {}, has no correction", previous.number, measurand.words());
            Err(Problem::invalid(Faults::one("/applied", detail)))
        }
    }
}
