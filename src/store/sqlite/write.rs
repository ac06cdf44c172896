//! The writes other than new iterations, each inside a transaction that the writer has begun.
//!
//! A write looks first and changes last: whatever it refuses, it refuses before its first change,
//! so a refusal leaves nothing to undo in the transaction that it shares with others.

use jiff::Timestamp;
use sqlx::{Row, SqliteConnection};
use uuid::Uuid;

use super::{
    bulk::{self, Incoming},
    rows::{self, job_columns},
    streams, time,
};
use crate::{
    api::gears::gear::stored_teeth,
    jobs::{Choice, Job, JobPatch, NewFit, Precondition, Receipt, RepositoryError, Ruling, Stored, What, beyond},
};

/// Why a write did not happen.
#[derive(Debug)]
pub enum WriteError {
    /// Refused before anything was changed; the transaction goes on.
    Refused(RepositoryError),
    /// The database failed; the transaction is given up.
    Broken(sqlx::Error),
}

impl From<sqlx::Error> for WriteError {
    fn from(error: sqlx::Error) -> Self {
        WriteError::Broken(error)
    }
}

impl From<RepositoryError> for WriteError {
    fn from(error: RepositoryError) -> Self {
        WriteError::Refused(error)
    }
}

pub type Written<T> = Result<T, WriteError>;

pub async fn insert_job(db: &mut SqliteConnection, job: &Job, receipt: Option<&Receipt>) -> Written<Stored> {
    refuse_taken_key(db, receipt).await?;
    sqlx::query(
        "INSERT INTO jobs (id, name, part_number, serial_number, machine, gear, tags, version, created_at, updated_at)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(job.id)
    .bind(job.name.as_str())
    .bind(job.part_number.as_deref())
    .bind(job.serial_number.as_deref())
    .bind(job.machine.as_deref())
    .bind(job.gear.as_deref())
    .bind(rows::write_tags(&job.tags))
    .bind(signed(job.version))
    .bind(time::to_text(job.created_at))
    .bind(time::to_text(job.updated_at))
    .execute(&mut *db)
    .await?;
    let stored = Stored { number: 0, version: job.version };
    keep_answer(db, receipt, stored, job.created_at).await?;
    Ok(stored)
}

pub async fn patch_job(
    db: &mut SqliteConnection,
    id: Uuid,
    patch: JobPatch,
    precondition: &Precondition,
    now: Timestamp,
) -> Written<Job> {
    let (seq, before) = job(db, id).await?;
    precondition.check(before.version)?;
    let after = before.patched(patch, now);
    if after.gear != before.gear {
        refuse_fewer_teeth(db, seq, after.gear.as_deref()).await?;
    }
    if after.version != before.version {
        sqlx::query(
            "UPDATE jobs SET name = ?, part_number = ?, serial_number = ?, machine = ?, gear = ?, tags = ?, version = ?,
             updated_at = ? WHERE id = ?",
        )
        .bind(after.name.as_str())
        .bind(after.part_number.as_deref())
        .bind(after.serial_number.as_deref())
        .bind(after.machine.as_deref())
        .bind(after.gear.as_deref())
        .bind(rows::write_tags(&after.tags))
        .bind(signed(after.version))
        .bind(time::to_text(after.updated_at))
        .bind(id)
        .execute(&mut *db)
        .await?;
    }
    Ok(after)
}

/// Refuses a gear without a tooth that the job's iterations, or streams that may become some, are
/// of.
async fn refuse_fewer_teeth(db: &mut SqliteConnection, job: i64, gear: Option<&str>) -> Written<()> {
    let Some(teeth) = gear.and_then(stored_teeth) else { return Ok(()) };
    let rows = sqlx::query(
        "SELECT tooth, min(number) FROM iterations WHERE job = ?1 AND tooth IS NOT NULL GROUP BY tooth
         UNION ALL
         SELECT DISTINCT tooth, NULL FROM streams WHERE job = ?1 AND tooth IS NOT NULL AND iteration IS NULL",
    )
    .bind(job)
    .fetch_all(&mut *db)
    .await?;
    for row in &rows {
        let (tooth, iteration): (&str, Option<u32>) = (row.try_get(0)?, row.try_get(1)?);
        if beyond(tooth, teeth) {
            return Err(RepositoryError::ToothMeasured { tooth: tooth.to_owned(), teeth, iteration }.into());
        }
    }
    Ok(())
}

pub async fn delete_job(db: &mut SqliteConnection, id: Uuid, precondition: &Precondition) -> Written<()> {
    let (seq, job) = job(db, id).await?;
    precondition.check(job.version)?;
    let row = sqlx::query("SELECT count(*) FROM iterations WHERE job = ?").bind(seq).fetch_one(&mut *db).await?;
    match rows::unsigned::<u64>(&row, 0)? {
        0 => {
            streams::release_job(db, seq).await?;
            sqlx::query("DELETE FROM jobs WHERE seq = ?").bind(seq).execute(&mut *db).await?;
            Ok(())
        }
        count => Err(RepositoryError::HasIterations(count).into()),
    }
}

pub async fn insert_fit(
    db: &mut SqliteConnection,
    job: Uuid,
    number: u32,
    fit: &NewFit,
    receipt: Option<&Receipt>,
) -> Written<Stored> {
    let place = iteration(db, job, number).await?;
    refuse_taken_key(db, receipt).await?;
    let figures = &fit.computed.figures;
    sqlx::query(
        "INSERT INTO fits (id, iteration, reason, created_at, lambda_star, criterion, scheme, count, condition,
         regularized_condition, bias_norm, bias_sharp_bound, rms, max_abs, spec, result)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(fit.id)
    .bind(place.seq)
    .bind(fit.reason.as_deref())
    .bind(time::to_text(fit.created_at))
    .bind(figures.lambda_star)
    .bind(figures.criterion)
    .bind(figures.scheme)
    .bind(figures.count)
    .bind(figures.condition)
    .bind(figures.regularized_condition)
    .bind(figures.bias_norm)
    .bind(figures.bias_sharp_bound)
    .bind(figures.rms)
    .bind(figures.max_abs)
    .bind(fit.computed.spec.clone())
    .bind(fit.computed.result.clone())
    .execute(&mut *db)
    .await?;
    let stored = Stored { number, version: place.version + 1 };
    keep_answer(db, receipt, stored, fit.created_at).await?;
    Ok(stored)
}

pub async fn choose(
    db: &mut SqliteConnection,
    job: Uuid,
    number: u32,
    choice: &Choice,
    precondition: &Precondition,
) -> Written<Stored> {
    let place = iteration(db, job, number).await?;
    precondition.check(place.version)?;
    let fit: i64 = sqlx::query("SELECT seq FROM fits WHERE iteration = ? AND id = ?")
        .bind(place.seq)
        .bind(choice.fit_id)
        .fetch_optional(&mut *db)
        .await?
        .ok_or(RepositoryError::ForeignFit(choice.fit_id))?
        .try_get(0)?;
    let latest =
        sqlx::query("SELECT position, fit, reason FROM fit_choices WHERE iteration = ? ORDER BY position DESC LIMIT 1")
            .bind(place.seq)
            .fetch_optional(&mut *db)
            .await?;
    let mut position = 0_i64;
    if let Some(row) = latest {
        position = row.try_get(0)?;
        let same = row.try_get::<i64, _>(1)? == fit && row.try_get::<Option<String>, _>(2)? == choice.event.reason;
        if same {
            return Ok(Stored { number, version: place.version });
        }
    }
    sqlx::query("INSERT INTO fit_choices (iteration, position, fit, reason, created_at) VALUES (?, ?, ?, ?, ?)")
        .bind(place.seq)
        .bind(position + 1)
        .bind(fit)
        .bind(choice.event.reason.as_deref())
        .bind(time::to_text(choice.event.created_at))
        .execute(&mut *db)
        .await?;
    Ok(Stored { number, version: place.version + 1 })
}

pub async fn rule(
    db: &mut SqliteConnection,
    job: Uuid,
    number: u32,
    ruling: &Ruling,
    precondition: &Precondition,
) -> Written<Stored> {
    let place = iteration(db, job, number).await?;
    precondition.check(place.version)?;
    let latest = sqlx::query(
        "SELECT position, decision, reason FROM decisions WHERE iteration = ? ORDER BY position DESC LIMIT 1",
    )
    .bind(place.seq)
    .fetch_optional(&mut *db)
    .await?;
    let mut position = 0_i64;
    if let Some(row) = latest {
        position = row.try_get(0)?;
        let same = row.try_get::<&str, _>(1)? == ruling.decision.name()
            && row.try_get::<Option<String>, _>(2)? == ruling.event.reason;
        if same {
            return Ok(Stored { number, version: place.version });
        }
    }
    sqlx::query("INSERT INTO decisions (iteration, position, decision, reason, created_at) VALUES (?, ?, ?, ?, ?)")
        .bind(place.seq)
        .bind(position + 1)
        .bind(ruling.decision.name())
        .bind(ruling.event.reason.as_deref())
        .bind(time::to_text(ruling.event.created_at))
        .execute(&mut *db)
        .await?;
    Ok(Stored { number, version: place.version + 1 })
}

/// Refuses a request whose key has an answer already (its client asked twice, and the other one was
/// first).
pub async fn refuse_taken_key(db: &mut SqliteConnection, receipt: Option<&Receipt>) -> Written<()> {
    let Some(receipt) = receipt else { return Ok(()) };
    let taken = sqlx::query("SELECT 1 FROM idempotency_keys WHERE key = ? AND scope = ?")
        .bind(receipt.key.as_str())
        .bind(receipt.scope.as_str())
        .fetch_optional(&mut *db)
        .await?;
    if taken.is_some() { Err(RepositoryError::KeyTaken.into()) } else { Ok(()) }
}

/// Keeps the answer in the transaction of what it tells of.
pub async fn keep_answer(
    db: &mut SqliteConnection,
    receipt: Option<&Receipt>,
    stored: Stored,
    now: Timestamp,
) -> Written<()> {
    let Some(receipt) = receipt else { return Ok(()) };
    let answer = (receipt.answer)(stored);
    sqlx::query(
        "INSERT INTO idempotency_keys (key, scope, request_sha256, status, location, etag, body, created_at)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(receipt.key.as_str())
    .bind(receipt.scope.as_str())
    .bind(receipt.request_sha256.as_slice())
    .bind(i64::from(answer.status))
    .bind(answer.location)
    .bind(answer.etag)
    .bind(answer.body)
    .bind(time::to_text(now))
    .execute(&mut *db)
    .await?;
    Ok(())
}

/// Forgets kept answers from before a time, the oldest first, at most so many; answers how many.
pub async fn forget_answers(db: &mut SqliteConnection, before: Timestamp, most: i64) -> Result<u64, sqlx::Error> {
    let forgotten = sqlx::query(
        "DELETE FROM idempotency_keys WHERE seq IN
         (SELECT seq FROM idempotency_keys WHERE created_at < ? ORDER BY created_at LIMIT ?)",
    )
    .bind(time::to_text(before))
    .bind(most)
    .execute(db)
    .await?;
    Ok(forgotten.rows_affected())
}

/// Jobs with their iterations.
pub async fn insert_runs(
    db: &mut SqliteConnection,
    runs: &[(Job, Vec<Incoming>)],
    receipt: Option<&Receipt>,
    now: Timestamp,
) -> Written<Stored> {
    refuse_taken_key(db, receipt).await?;
    for (job, iterations) in runs {
        insert_job(db, job, None).await?;
        let iterations: Vec<&Incoming> = iterations.iter().collect();
        for stored in bulk::insert_iterations(db, &iterations).await? {
            // of a job that is there and without a key none is refused; were one, all would be
            // undone
            stored.map_err(|error| WriteError::Broken(sqlx::Error::Protocol(error.to_string())))?;
        }
    }
    let stored = Stored { number: 0, version: 1 };
    keep_answer(db, receipt, stored, now).await?;
    Ok(stored)
}

/// Writes what nobody reads, to find out whether anything can be written.
pub async fn probe(db: &mut SqliteConnection, now: Timestamp) -> Written<()> {
    sqlx::query(
        "INSERT INTO probe (id, checked_at) VALUES (1, ?) ON CONFLICT (id) DO UPDATE SET checked_at = \
         excluded.checked_at",
    )
    .bind(time::to_text(now))
    .execute(db)
    .await?;
    Ok(())
}

async fn job(db: &mut SqliteConnection, id: Uuid) -> Written<(i64, Job)> {
    let row = sqlx::query(concat!("SELECT ", job_columns!(), ", seq FROM jobs WHERE id = ?"))
        .bind(id)
        .fetch_optional(&mut *db)
        .await?
        .ok_or(RepositoryError::NotFound(What::Job))?;
    Ok((row.try_get(10)?, rows::job(&row)?))
}

/// Where an iteration is, and its version.
pub struct Place {
    pub seq: i64,
    pub version: u64,
}

pub async fn iteration(db: &mut SqliteConnection, job: Uuid, number: u32) -> Written<Place> {
    let row = sqlx::query(
        "SELECT i.seq,
                (SELECT count(*) FROM fits WHERE iteration = i.seq)
                + (SELECT count(*) FROM fit_choices WHERE iteration = i.seq)
                + (SELECT count(*) FROM decisions WHERE iteration = i.seq) - 1
         FROM jobs j LEFT JOIN iterations i ON i.job = j.seq AND i.number = ? WHERE j.id = ?",
    )
    .bind(number)
    .bind(job)
    .fetch_optional(&mut *db)
    .await?
    .ok_or(RepositoryError::NotFound(What::Job))?;
    let seq: i64 = row.try_get::<Option<i64>, _>(0)?.ok_or(RepositoryError::NotFound(What::Iteration))?;
    Ok(Place { seq, version: rows::unsigned(&row, 1)? })
}

/// SQLite's integers are signed; versions and counts are far below 2⁶³.
pub fn signed(value: u64) -> i64 {
    i64::try_from(value).unwrap_or(i64::MAX)
}
