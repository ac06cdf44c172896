//! Reads. One that asks more than once does so in one read transaction, so what it puts together
//! belongs together.

use futures_util::TryStreamExt as _;
use sqlx::{Row, SqliteConnection, SqlitePool, sqlite::SqliteRow};
use uuid::Uuid;

use super::{
    error::failure,
    records,
    rows::{self, chosen_fit, damaged, figure_columns, get, job_columns},
};
use crate::jobs::{
    Answer, Choice, Cursor, Earlier, FitRecord, FitSummary, Iteration, Job, Later, MOST_TOLD, Measurand, Page,
    PageRequest, RepositoryError, Ruling, Trace, TracedFit, TracedIteration, What, nodes_codec,
};
use flankfit_engine::estimation::Nodes;

type Read<T> = Result<T, RepositoryError>;

pub async fn job(db: &SqlitePool, id: Uuid) -> Read<Job> {
    let row = sqlx::query(concat!("SELECT ", job_columns!(), " FROM jobs WHERE id = ?"))
        .bind(id)
        .fetch_optional(db)
        .await
        .map_err(sql)?;
    rows::job(&row.ok_or(RepositoryError::NotFound(What::Job))?)
}

/// Newest first; one row more than asked for tells whether there is a next page.
pub async fn jobs(db: &SqlitePool, page: PageRequest) -> Read<Page<Job>> {
    let after = page.after.map_or([0xff; 16].to_vec(), |Cursor(id)| id.as_bytes().to_vec());
    let rows = sqlx::query(concat!("SELECT ", job_columns!(), " FROM jobs WHERE id < ? ORDER BY id DESC LIMIT ?"))
        .bind(after)
        .bind(i64::from(page.limit) + 1)
        .fetch_all(db)
        .await
        .map_err(sql)?;
    Ok(Page::of(rows.iter().map(rows::job).collect::<Read<Vec<_>>>()?, page.limit, |job| job.id))
}

pub async fn iteration(db: &SqlitePool, job: Uuid, number: u32) -> Read<Iteration> {
    let mut db = db.begin().await.map_err(sql)?;
    let row = sqlx::query(
        "SELECT i.seq, i.id, i.measured_at, i.instrument, i.operator, i.note, i.created_at,
                (SELECT count FROM nodes WHERE iteration = i.seq),
                (SELECT count(*) FROM fits WHERE iteration = i.seq)
                + (SELECT count(*) FROM fit_choices WHERE iteration = i.seq)
                + (SELECT count(*) FROM decisions WHERE iteration = i.seq) - 1,
                i.flank, i.tooth, i.axes
         FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND i.number = ?",
    )
    .bind(job)
    .bind(number)
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?;
    let Some(row) = row else { return Err(which_is_missing(&mut db, job).await) };
    let seq: i64 = get(&row, 0)?;
    let fits = sqlx::query(concat!(
        "SELECT id, reason, created_at, seq = ",
        chosen_fit!(),
        ", (SELECT count(*) FROM fits WHERE iteration = ?1), ",
        figure_columns!(),
        " FROM fits WHERE iteration = ?1 ORDER BY seq DESC LIMIT ?2"
    ))
    .bind(seq)
    .bind(MOST_TOLD)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    let ruling = sqlx::query(
        "SELECT decision, reason, created_at FROM decisions WHERE iteration = ? ORDER BY position DESC LIMIT 1",
    )
    .bind(seq)
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?;
    Ok(Iteration {
        id: get(&row, 1)?,
        job_id: job,
        number,
        measurand: rows::measurand(&row, 9)?,
        measured_at: rows::optional_moment(&row, 2)?,
        instrument: get(&row, 3)?,
        operator: get(&row, 4)?,
        note: get(&row, 5)?,
        created_at: rows::moment(&row, 6)?,
        node_count: rows::unsigned(&row, 7)?,
        version: rows::unsigned(&row, 8)?,
        earlier_fits: earlier(&fits, 4)?,
        fits: fits.iter().rev().map(|row| rows::fit_summary(row, 5)).collect::<Read<Vec<_>>>()?,
        ruling: ruling.as_ref().map(|row| read_ruling(row, 0)).transpose()?,
    })
}

/// How many rows stand before those read, which are the last; column `at` counts all.
pub fn earlier(rows: &[SqliteRow], at: usize) -> Read<u64> {
    let all = rows.first().map_or(Ok(0), |row| rows::unsigned::<u64>(row, at))?;
    Ok(all.saturating_sub(rows.len() as u64))
}

/// Fits in the order in which they were made; one row more than asked for tells whether there is a
/// next page.
pub async fn fits(db: &SqlitePool, job: Uuid, number: u32, page: PageRequest) -> Read<Page<FitSummary>> {
    let mut db = db.begin().await.map_err(sql)?;
    let seq = iteration_seq(&mut db, job, number).await?;
    let after = page.after.map_or(0, |cursor| i64::try_from(cursor.number()).unwrap_or(i64::MAX));
    let mut rows = sqlx::query(concat!(
        "SELECT id, reason, created_at, seq = ",
        chosen_fit!(),
        ", seq, ",
        figure_columns!(),
        " FROM fits WHERE iteration = ?1 AND seq > ?2 ORDER BY seq LIMIT ?3"
    ))
    .bind(seq)
    .bind(after)
    .bind(i64::from(page.limit) + 1)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    let more = rows.len() > usize::try_from(page.limit).unwrap_or(usize::MAX);
    rows.truncate(usize::try_from(page.limit).unwrap_or(usize::MAX));
    let next = match rows.last().filter(|_| more) {
        Some(last) => Some(Cursor::after_number(rows::unsigned(last, 4)?)),
        None => None,
    };
    Ok(Page { items: rows.iter().map(|row| rows::fit_summary(row, 5)).collect::<Read<Vec<_>>>()?, next })
}

pub async fn nodes(db: &SqlitePool, job: Uuid, number: u32) -> Read<Nodes> {
    let all = nodes_up_to(db, job, number, usize::MAX).await?;
    all.map_err(|length| damaged("nodes", &format!("{length} bytes are not read")))
}

/// Longer ones are not read: SQLite knows their length without.
pub async fn nodes_up_to(db: &SqlitePool, job: Uuid, number: u32, most: usize) -> Read<Result<Nodes, usize>> {
    let mut db = db.acquire().await.map_err(sql)?;
    let row = sqlx::query(
        "SELECT length(n.data), CASE WHEN length(n.data) <= ?3 THEN n.data END
         FROM jobs j JOIN iterations i ON i.job = j.seq JOIN nodes n ON n.iteration = i.seq
         WHERE j.id = ?1 AND i.number = ?2",
    )
    .bind(job)
    .bind(number)
    .bind(i64::try_from(most).unwrap_or(i64::MAX))
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?;
    let Some(row) = row else { return Err(which_is_missing(&mut db, job).await) };
    match get::<Option<&[u8]>>(&row, 1)? {
        Some(bytes) => nodes_codec::decode(bytes).map(Ok).map_err(|error| damaged("nodes", &error.to_string())),
        None => Ok(Err(usize::try_from(get::<i64>(&row, 0)?).unwrap_or(usize::MAX))),
    }
}

pub async fn measurand(db: &SqlitePool, job: Uuid, number: u32) -> Read<Measurand> {
    let mut db = db.acquire().await.map_err(sql)?;
    let row = sqlx::query(
        "SELECT i.flank, i.tooth, i.axes FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND i.number = \
         ?",
    )
    .bind(job)
    .bind(number)
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?;
    match row {
        Some(row) => rows::measurand(&row, 0),
        None => Err(which_is_missing(&mut db, job).await),
    }
}

/// The first iteration after one, and the first that is of the same flank and tooth.
pub async fn later(db: &SqlitePool, job: Uuid, number: u32) -> Read<Later> {
    let mut db = db.acquire().await.map_err(sql)?;
    let mut rows = sqlx::query(
        "SELECT i.number, i.flank, i.tooth, NULL FROM jobs j JOIN iterations i ON i.job = j.seq
         WHERE j.id = ? AND i.number >= ? ORDER BY i.number",
    )
    .bind(job)
    .bind(number)
    .fetch(&mut *db);
    // names of teeth may be older than the rule how they are written, so they are compared here;
    // the rows are short
    let mut later = Later::default();
    let mut own = None;
    while let Some(row) = rows.try_next().await.map_err(sql)? {
        let (at, measurand) = (rows::unsigned(&row, 0)?, rows::measurand(&row, 1)?);
        match &own {
            None if at == number => own = Some(measurand),
            None => break,
            Some(own) => {
                later.any = later.any.or(Some(at));
                if measurand.is_alike(own) {
                    later.alike = Some(at);
                    break;
                }
            }
        }
    }
    Ok(later)
}

pub async fn fit(db: &SqlitePool, job: Uuid, number: u32, fit: Uuid) -> Read<FitRecord> {
    let mut db = db.begin().await.map_err(sql)?;
    let seq = iteration_seq(&mut db, job, number).await?;
    let row = sqlx::query(concat!(
        "SELECT id, reason, created_at, seq = ",
        chosen_fit!(),
        ", spec, result FROM fits WHERE iteration = ?1 AND id = ?2"
    ))
    .bind(seq)
    .bind(fit)
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?;
    rows::fit(&row.ok_or(RepositoryError::NotFound(What::Fit))?)
}

/// Text of coefficients on a page of the trace, beyond the first iteration.
const MOST_TEXT: usize = 4 << 20;

/// Iterations by number, each with four ordered lists: its fits, choices, rulings and records as
/// they were made.
pub async fn trace(db: &SqlitePool, id: Uuid, page: PageRequest) -> Read<Trace> {
    let mut db = db.begin().await.map_err(sql)?;
    let row = sqlx::query(concat!("SELECT ", job_columns!(), ", seq FROM jobs WHERE id = ?"))
        .bind(id)
        .fetch_optional(&mut *db)
        .await
        .map_err(sql)?
        .ok_or(RepositoryError::NotFound(What::Job))?;
    let job = rows::job(&row)?;
    let after = page.after.map_or(0, |cursor| i64::try_from(cursor.number()).unwrap_or(i64::MAX));
    let rows = sqlx::query(
        "SELECT seq, id, number, measured_at, created_at, flank, tooth, axes FROM iterations WHERE job = ? AND number \
         > ?
         ORDER BY number LIMIT ?",
    )
    .bind(get::<i64>(&row, 10)?)
    .bind(after)
    .bind(i64::from(page.limit) + 1)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    let (mut iterations, mut text) = (Vec::new(), 0);
    let mut next = None;
    for row in &rows {
        let last: Option<&TracedIteration> = iterations.last();
        if let Some(last) = last.filter(|_| iterations.len() == page.limit as usize || text >= MOST_TEXT) {
            next = Some(Cursor::after_number(last.number.into()));
            break;
        }
        let iteration = trace_iteration(&mut db, row, MOST_TEXT.saturating_sub(text)).await?;
        text += iteration.fits.iter().map(|fit| fit.coefficients.len()).sum::<usize>();
        iterations.push(iteration);
    }
    Ok(Trace { job, iterations, next })
}

/// `text` is what is left of the page for coefficients.
async fn trace_iteration(db: &mut SqliteConnection, row: &SqliteRow, text: usize) -> Read<TracedIteration> {
    let seq: i64 = get(row, 0)?;
    let choices = sqlx::query(
        "SELECT f.id, c.reason, c.created_at, (SELECT count(*) FROM fit_choices WHERE iteration = ?1)
         FROM fit_choices c JOIN fits f ON f.seq = c.fit WHERE c.iteration = ?1 ORDER BY c.position DESC LIMIT ?2",
    )
    .bind(seq)
    .bind(MOST_TOLD)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    let rulings = sqlx::query(
        "SELECT decision, reason, created_at, (SELECT count(*) FROM decisions WHERE iteration = ?1)
         FROM decisions WHERE iteration = ?1 ORDER BY position DESC LIMIT ?2",
    )
    .bind(seq)
    .bind(MOST_TOLD)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    let (fits, all_fits) = traced_fits(db, seq, text).await?;
    let (records, earlier_records) = records::last_summaries(db, seq).await?;
    let earlier = Earlier {
        fits: all_fits.saturating_sub(fits.len() as u64),
        choices: earlier(&choices, 3)?,
        rulings: earlier(&rulings, 3)?,
        records: earlier_records,
    };
    let choice = |row: &SqliteRow| Ok(Choice { fit_id: get(row, 0)?, event: rows::event(row, 1)? });
    Ok(TracedIteration {
        id: get(row, 1)?,
        number: rows::unsigned(row, 2)?,
        measurand: rows::measurand(row, 5)?,
        measured_at: rows::optional_moment(row, 3)?,
        created_at: rows::moment(row, 4)?,
        fits,
        choices: choices.iter().rev().map(choice).collect::<Read<Vec<_>>>()?,
        rulings: rulings.iter().rev().map(|row| read_ruling(row, 0)).collect::<Read<Vec<_>>>()?,
        records,
        earlier,
    })
}

/// The last fits of an iteration in their order, as many as `text` holds the coefficients of and at
/// least one; and how many there are.
async fn traced_fits(db: &mut SqliteConnection, iteration: i64, text: usize) -> Read<(Vec<TracedFit>, u64)> {
    // of an answer, which may be long, only the coefficients leave the database, as they were
    // answered
    let mut rows = sqlx::query(concat!(
        "SELECT id, reason, created_at, seq = ",
        chosen_fit!(),
        ", (SELECT count(*) FROM fits WHERE iteration = ?1), ",
        figure_columns!(),
        ", result -> '$.coefficients' FROM fits WHERE iteration = ?1 ORDER BY seq DESC LIMIT ?2"
    ))
    .bind(iteration)
    .bind(MOST_TOLD)
    .fetch(db);
    let (mut fits, mut all, mut length) = (Vec::new(), 0, 0);
    while let Some(row) = rows.try_next().await.map_err(sql)? {
        all = rows::unsigned(&row, 4)?;
        let coefficients: String = get(&row, 15)?;
        length += coefficients.len();
        if length > text && !fits.is_empty() {
            break;
        }
        fits.push(TracedFit { summary: rows::fit_summary(&row, 5)?, coefficients });
    }
    fits.reverse();
    Ok((fits, all))
}

pub async fn answer(db: &SqlitePool, key: &str, scope: &str) -> Read<Option<([u8; 32], Answer)>> {
    let row = sqlx::query(
        "SELECT request_sha256, status, location, etag, body FROM idempotency_keys WHERE key = ? AND scope = ?",
    )
    .bind(key)
    .bind(scope)
    .fetch_optional(db)
    .await
    .map_err(sql)?;
    let Some(row) = row else { return Ok(None) };
    let digest = get::<&[u8]>(&row, 0)?.try_into().map_err(|_| damaged("a request digest", key))?;
    let answer =
        Answer { status: rows::unsigned(&row, 1)?, location: get(&row, 2)?, etag: get(&row, 3)?, body: get(&row, 4)? };
    Ok(Some((digest, answer)))
}

pub async fn ping(db: &SqlitePool) -> Read<()> {
    let row = sqlx::query("SELECT count(*) FROM sqlite_schema").fetch_one(db).await.map_err(sql)?;
    row.try_get::<i64, _>(0).map(|_| ()).map_err(sql)
}

fn read_ruling(row: &SqliteRow, at: usize) -> Read<Ruling> {
    Ok(Ruling { decision: rows::decision(row, at)?, event: rows::event(row, at + 1)? })
}

/// The row of an iteration.
pub async fn iteration_seq(db: &mut SqliteConnection, job: Uuid, number: u32) -> Read<i64> {
    let row =
        sqlx::query("SELECT i.seq FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND i.number = ?")
            .bind(job)
            .bind(number)
            .fetch_optional(&mut *db)
            .await
            .map_err(sql)?;
    match row {
        Some(row) => get(&row, 0),
        None => Err(which_is_missing(db, job).await),
    }
}

/// Whether the job or only its iteration does not exist.
async fn which_is_missing(db: &mut SqliteConnection, job: Uuid) -> RepositoryError {
    match sqlx::query("SELECT 1 FROM jobs WHERE id = ?").bind(job).fetch_optional(db).await {
        Ok(Some(_)) => RepositoryError::NotFound(What::Iteration),
        Ok(None) => RepositoryError::NotFound(What::Job),
        Err(error) => sql(error),
    }
}

#[expect(clippy::needless_pass_by_value, reason = "the form that map_err takes")]
pub fn sql(error: sqlx::Error) -> RepositoryError {
    failure(&error)
}
