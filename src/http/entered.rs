//! The changes that were entered on the machine after a correction, as they are stored.

use uuid::Uuid;

use super::caller_state::CallerState;
use crate::{
    api::{
        gears::correction::applied::{self, AppliedChangesBody},
        problem::Problem,
    },
    jobs::{PageRequest, Record, RecordKind},
};

/// Records of one page.
const PAGE: u32 = 200;

/// Returns what was entered after a correction: the newest entry kept with its iteration or with
/// one of those that measured it, `later`.
pub async fn entered_after(
    state: &CallerState,
    job: Uuid,
    correction: &Record,
    iteration: u32,
    later: &[u32],
) -> Result<Option<AppliedChangesBody>, Problem> {
    let mut newest: Option<AppliedChangesBody> = None;
    for number in std::iter::once(&iteration).chain(later) {
        let Some(found) = newest_entry(state, job, correction.id, *number).await? else { continue };
        if newest.as_ref().is_none_or(|newest| newest.created_at.0 <= found.created_at.0) {
            newest = Some(found);
        }
    }
    Ok(newest)
}

/// Returns the newest entry for the correction that is stored with the iteration.
async fn newest_entry(
    state: &CallerState,
    job: Uuid,
    correction: Uuid,
    number: u32,
) -> Result<Option<AppliedChangesBody>, Problem> {
    let mut entries = Vec::new();
    let mut page = PageRequest { limit: PAGE, after: None };
    loop {
        let listed = state.jobs.records(job, number, page).await?;
        entries.extend(listed.items.into_iter().filter(|record| record.kind == RecordKind::Applied));
        match listed.next {
            Some(next) => page.after = Some(next),
            None => break,
        }
    }
    while let Some(entry) = entries.pop() {
        let record = state.jobs.record(job, number, entry.id).await?;
        if let Some(found) = applied::entered_after(correction, &record)? {
            return Ok(Some(found));
        }
    }
    Ok(None)
}
