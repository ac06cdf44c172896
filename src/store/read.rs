//! Reads. One that asks more than once does so in one read transaction, so what it puts together belongs together.

use serde::Deserialize;
use serde_json::value::RawValue;
use sqlx::{Row, SqliteConnection, SqlitePool, sqlite::SqliteRow};
use uuid::Uuid;

use super::{
    error::failure,
    records,
    rows::{self, damaged, figure_columns, get, job_columns},
};
use crate::{
    api::nodes_codec,
    estimation::Nodes,
    jobs::{
        Answer, Choice, Cursor, FitRecord, FitSummary, Iteration, Job, Page, PageRequest, RepositoryError, Ruling,
        Trace, TracedIteration, What,
    },
};

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
                (SELECT f.id FROM fit_choices c JOIN fits f ON f.seq = c.fit
                 WHERE c.iteration = i.seq ORDER BY c.position DESC LIMIT 1)
         FROM jobs j JOIN iterations i ON i.job = j.seq WHERE j.id = ? AND i.number = ?",
    )
    .bind(job)
    .bind(number)
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?;
    let Some(row) = row else { return Err(which_is_missing(&mut db, job).await) };
    let seq: i64 = get(&row, 0)?;
    let fits = sqlx::query("SELECT id, reason, created_at, spec, result FROM fits WHERE iteration = ? ORDER BY seq")
        .bind(seq)
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
        measured_at: rows::optional_moment(&row, 2)?,
        instrument: get(&row, 3)?,
        operator: get(&row, 4)?,
        note: get(&row, 5)?,
        created_at: rows::moment(&row, 6)?,
        node_count: rows::unsigned(&row, 7)?,
        version: rows::unsigned(&row, 8)?,
        chosen: get(&row, 9)?,
        fits: fits.iter().map(rows::fit).collect::<Read<Vec<_>>>()?,
        ruling: ruling.as_ref().map(|row| read_ruling(row, 0)).transpose()?,
    })
}

pub async fn nodes(db: &SqlitePool, job: Uuid, number: u32) -> Read<Nodes> {
    let mut db = db.acquire().await.map_err(sql)?;
    let row = sqlx::query(
        "SELECT n.data FROM jobs j JOIN iterations i ON i.job = j.seq JOIN nodes n ON n.iteration = i.seq
         WHERE j.id = ? AND i.number = ?",
    )
    .bind(job)
    .bind(number)
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?;
    match row {
        Some(row) => nodes_codec::decode(get::<&[u8]>(&row, 0)?).map_err(|error| damaged("nodes", &error.to_string())),
        None => Err(which_is_missing(&mut db, job).await),
    }
}

pub async fn fit(db: &SqlitePool, job: Uuid, number: u32, fit: Uuid) -> Read<FitRecord> {
    let mut db = db.begin().await.map_err(sql)?;
    let seq = iteration_seq(&mut db, job, number).await?;
    let row = sqlx::query("SELECT id, reason, created_at, spec, result FROM fits WHERE iteration = ? AND id = ?")
        .bind(seq)
        .bind(fit)
        .fetch_optional(&mut *db)
        .await
        .map_err(sql)?;
    rows::fit(&row.ok_or(RepositoryError::NotFound(What::Fit))?)
}

/// Four ordered lists, merged: iterations by number, and for each its fits, choices and rulings as they were made.
pub async fn trace(db: &SqlitePool, id: Uuid) -> Read<Trace> {
    let mut db = db.begin().await.map_err(sql)?;
    let row = sqlx::query(concat!("SELECT ", job_columns!(), ", seq FROM jobs WHERE id = ?"))
        .bind(id)
        .fetch_optional(&mut *db)
        .await
        .map_err(sql)?
        .ok_or(RepositoryError::NotFound(What::Job))?;
    let job = rows::job(&row)?;
    let seq: i64 = get(&row, 10)?;

    let mut iterations = Vec::new();
    let rows =
        sqlx::query("SELECT seq, id, number, measured_at, created_at FROM iterations WHERE job = ? ORDER BY number")
            .bind(seq)
            .fetch_all(&mut *db)
            .await
            .map_err(sql)?;
    for row in &rows {
        let traced = TracedIteration {
            id: get(row, 1)?,
            number: rows::unsigned(row, 2)?,
            measured_at: rows::optional_moment(row, 3)?,
            created_at: rows::moment(row, 4)?,
            fits: Vec::new(),
            choices: Vec::new(),
            rulings: Vec::new(),
            records: Vec::new(),
        };
        iterations.push((get::<i64>(row, 0)?, traced));
    }
    for (seq, iteration) in &mut iterations {
        trace_iteration(&mut db, *seq, iteration).await?;
    }
    Ok(Trace { job, iterations: iterations.into_iter().map(|(_, iteration)| iteration).collect() })
}

async fn trace_iteration(db: &mut SqliteConnection, seq: i64, into: &mut TracedIteration) -> Read<()> {
    let choices = sqlx::query(
        "SELECT f.id, c.reason, c.created_at FROM fit_choices c JOIN fits f ON f.seq = c.fit
         WHERE c.iteration = ? ORDER BY c.position",
    )
    .bind(seq)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    for row in &choices {
        into.choices.push(Choice { fit_id: get(row, 0)?, event: rows::event(row, 1)? });
    }
    let rulings =
        sqlx::query("SELECT decision, reason, created_at FROM decisions WHERE iteration = ? ORDER BY position")
            .bind(seq)
            .fetch_all(&mut *db)
            .await
            .map_err(sql)?;
    for row in &rulings {
        into.rulings.push(read_ruling(row, 0)?);
    }
    let chosen = into.choices.last().map(|choice| choice.fit_id);
    let fits = sqlx::query(concat!(
        "SELECT id, reason, created_at, ",
        figure_columns!(),
        ", result FROM fits WHERE iteration = ? ORDER BY seq"
    ))
    .bind(seq)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    for row in &fits {
        let id = get(row, 0)?;
        into.fits.push(FitSummary {
            id,
            chosen: chosen == Some(id),
            event: rows::event(row, 1)?,
            figures: rows::figures(row, 3)?,
            coefficients: coefficients(get(row, 13)?)?,
        });
    }
    into.records = records::summaries(db, seq).await?;
    Ok(())
}

/// The coefficients of an answer, as they were answered.
fn coefficients(result: &str) -> Read<String> {
    #[derive(Deserialize)]
    struct Answered<'a> {
        #[serde(borrow)]
        coefficients: &'a RawValue,
    }
    match serde_json::from_str::<Answered<'_>>(result) {
        Ok(answered) => Ok(answered.coefficients.get().to_owned()),
        Err(error) => Err(damaged("an answer", &error.to_string())),
    }
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

/// Whether the job or only its iteration does not exist.
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
