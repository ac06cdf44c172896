//! The trace of a job.

use sqlx::{SqliteConnection, SqlitePool};

use super::{
    fits, jobs,
    locate::{self, WithSeq},
    records,
};
use crate::{
    jobs::{Caller, Cursor, DecisionEvent, Earlier, PageRequest, Trace, TracedIteration},
    store::shared::{DecisionRow, GetTrace, Outcome, Read, TracedIterationRow},
};

/// Text of coefficients on a page of the trace, beyond the first iteration.
const MOST_TEXT: usize = 4 << 20;

impl Read<SqlitePool> for GetTrace {
    /// Iterations by number, each with four ordered lists: its fits, choices, decisions and
    /// records as they were made.
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Trace> {
        let PageRequest { limit, after } = self.page;
        let mut db = from.begin().await?;
        let (seq, job) = jobs::located(&mut db, &caller.tenant, self.job).await?;
        let after = after.map_or(0, |cursor| locate::signed(cursor.number()));
        let rows: Vec<WithSeq<TracedIterationRow>> = sqlx::query_as(
            "SELECT seq, id, number, measured_at, instrument, operator, created_at, flank, tooth, axes,
                    units_accepted FROM measured
         WHERE job = ? AND number > ? ORDER BY number LIMIT ?",
        )
        .bind(seq)
        .bind(after)
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
            let iteration = iteration(&mut db, row, MOST_TEXT.saturating_sub(text)).await?;
            text += iteration.fits.iter().map(|fit| fit.coefficients.len()).sum::<usize>();
            iterations.push(iteration);
        }
        Ok(Trace { job, iterations, next })
    }
}

/// `text` is what is left of the page for coefficients.
async fn iteration(
    db: &mut SqliteConnection,
    WithSeq { seq, row }: WithSeq<TracedIterationRow>,
    text: usize,
) -> Outcome<TracedIteration> {
    let (fits, earlier_fits) = fits::last_with_coefficients(db, seq, text).await?;
    let (choices, earlier_choices) = fits::last_choices(db, seq).await?;
    let (decisions, earlier_decisions) = last_decisions(db, seq).await?;
    let (records, earlier_records) = records::last(db, seq).await?;
    let earlier = Earlier {
        fits: earlier_fits,
        choices: earlier_choices,
        decisions: earlier_decisions,
        records: earlier_records,
    };
    Ok(TracedIteration { fits, choices, decisions, records, earlier, ..row.into() })
}

/// The last decisions on an iteration, and how many stand before them.
async fn last_decisions(db: &mut SqliteConnection, iteration: i64) -> Outcome<(Vec<DecisionEvent>, u64)> {
    locate::last::<DecisionRow, _>(
        db,
        "SELECT decision, concession, reason, actor, created_at, (SELECT count(*) FROM decisions WHERE iteration = ?1) AS total
         FROM decisions WHERE iteration = ?1 ORDER BY position DESC LIMIT ?2",
        iteration,
    )
    .await
}
