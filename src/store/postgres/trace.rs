//! The trace of a job.

use sqlx::{PgConnection, PgPool};
use uuid::Uuid;

use super::{
    fits, jobs,
    locate::{self, signed},
    open::snapshot,
    records,
};
use crate::{
    jobs::{Caller, Cursor, DecisionEvent, Earlier, PageRequest, Trace, TracedIteration},
    store::shared::{DecisionRow, GetTrace, Outcome, Read, TracedIterationRow},
};

/// Text of coefficients on a page of the trace, beyond the first iteration.
const MOST_TEXT: usize = 4 << 20;

impl Read<PgPool> for GetTrace {
    /// Iterations by number, each with four ordered lists: its fits, choices, decisions and
    /// records as they were made.
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Trace> {
        let PageRequest { limit, after } = self.page;
        let mut db = snapshot(from).await?;
        let job = jobs::located(&mut db, &caller.tenant, self.job).await?;
        let rows: Vec<TracedIterationRow> = sqlx::query_as(
            "SELECT id, number, measured_at, instrument, operator, created_at, flank, tooth, axes,
                    units_accepted FROM measured
             WHERE job = $1 AND number > $2 ORDER BY number LIMIT $3",
        )
        .bind(self.job)
        .bind(after.map_or(0, |cursor| signed(cursor.number())))
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        let (mut iterations, mut text) = (Vec::new(), 0);
        let mut next = None;
        for row in rows {
            let last: Option<&TracedIteration> = iterations.last();
            if let Some(last) = last.filter(|_| iterations.len() == limit as usize || text >= MOST_TEXT) {
                next = Some(Cursor::after_number(last.number.into()));
                break;
            }
            let iteration = iteration(&mut db, self.job, row, MOST_TEXT.saturating_sub(text)).await?;
            text += iteration.fits.iter().map(|fit| fit.coefficients.len()).sum::<usize>();
            iterations.push(iteration);
        }
        Ok(Trace { job, iterations, next })
    }
}

/// `text` is what is left of the page for coefficients.
async fn iteration(db: &mut PgConnection, job: Uuid, row: TracedIterationRow, text: usize) -> Outcome<TracedIteration> {
    let told = TracedIteration::from(row);
    let number = i64::from(told.number);
    let (fits, earlier_fits) = fits::last_with_coefficients(db, job, number, text).await?;
    let (choices, earlier_choices) = fits::last_choices(db, job, number).await?;
    let (decisions, earlier_decisions) = last_decisions(db, job, number).await?;
    let (records, earlier_records) = records::last(db, job, number).await?;
    let earlier = Earlier {
        fits: earlier_fits,
        choices: earlier_choices,
        decisions: earlier_decisions,
        records: earlier_records,
    };
    Ok(TracedIteration { fits, choices, decisions, records, earlier, ..told })
}

/// The last decisions on an iteration, and how many stand before them.
async fn last_decisions(db: &mut PgConnection, job: Uuid, number: i64) -> Outcome<(Vec<DecisionEvent>, u64)> {
    locate::last::<DecisionRow, _>(
        db,
        "SELECT decision, concession, reason, actor, created_at,
                (SELECT count(*) FROM decisions WHERE job = $1 AND number = $2) AS total
         FROM decisions WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT $3",
        (job, number),
    )
    .await
}
