//! The trace of a job.

use super::{decisions, fits, jobs, prelude::*, records};

/// Text of coefficients on a page of the trace, in addition to the first iteration.
const MOST_TEXT: usize = 4 << 20;

/// Returns iterations by number, each with four ordered lists: its fits, choices, decisions and
/// records as they were made.
pub async fn trace(
    db: &mut Db,
    caller: &Caller,
    id: &Uuid,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Trace> {
    let job = jobs::located(db, &caller.tenant, *id).await?;
    let sql = "SELECT id, number, measured_at, instrument, operator, created_at, flank, tooth, axes, accept_units
               FROM measured WHERE job = $1 AND number > $2 ORDER BY number LIMIT $3";
    let after = after.map_or(0, |cursor| cursor.number());
    let rows: Vec<TracedIteration> = db.all(sql, args![id, after, i64::from(*limit) + 1]).await?;
    let (mut iterations, mut text) = (Vec::new(), 0);
    let mut next = None;
    for row in rows {
        let last: Option<&TracedIteration> = iterations.last();
        if let Some(last) = last.filter(|_| iterations.len() == *limit as usize || text >= MOST_TEXT) {
            next = Some(Cursor::after_number(last.number.into()));
            break;
        }
        let iteration = iteration(db, *id, row, MOST_TEXT.saturating_sub(text)).await?;
        text += iteration.fits.iter().map(|fit| fit.coefficients.len()).sum::<usize>();
        iterations.push(iteration);
    }
    Ok(Trace { job, iterations, next })
}

/// `text` is how much of the page is left for coefficients.
async fn iteration(db: &mut Db, job: Uuid, iteration: TracedIteration, text: usize) -> Outcome<TracedIteration> {
    let number = iteration.number;
    let (fits, earlier_fits) = fits::last_with_coefficients(db, job, number, text).await?;
    let (choices, earlier_choices) = fits::last_choices(db, job, number).await?;
    let (decisions, earlier_decisions) = decisions::last(db, job, number).await?;
    let (records, earlier_records) = records::last(db, job, number).await?;
    let earlier = Earlier {
        fits: earlier_fits,
        choices: earlier_choices,
        decisions: earlier_decisions,
        records: earlier_records,
    };
    Ok(TracedIteration { fits, choices, decisions, records, earlier, ..iteration })
}
