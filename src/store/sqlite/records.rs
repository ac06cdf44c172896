//! What is kept with an iteration beside its fits.

use sqlx::{SqliteConnection, SqlitePool, sqlite::SqliteRow};
use uuid::Uuid;

use super::{
    read::{self, sql},
    rows::{self, damaged, get},
    time,
    write::{Written, iteration, keep_answer, refuse_taken_key},
};
use crate::jobs::{
    Cursor, MOST_TOLD, Page, PageRequest, Receipt, Record, RecordDraft, RecordKind, RecordSummary, RepositoryError,
    Stored, What,
};

pub async fn insert(
    db: &mut SqliteConnection,
    job: Uuid,
    number: u32,
    record: &Record,
    receipt: Option<&Receipt>,
) -> Written<Stored> {
    let place = iteration(db, job, number).await?;
    refuse_taken_key(db, receipt).await?;
    insert_row(db, place.seq, record).await?;
    // Records are beside the iteration: its version stays.
    let stored = Stored { number, version: place.version };
    keep_answer(db, receipt, stored, record.created_at).await?;
    Ok(stored)
}

/// The row of a record of the iteration that is row `iteration`.
pub async fn insert_row(db: &mut SqliteConnection, iteration: i64, record: &Record) -> Written<()> {
    let RecordDraft { kind, method, request, result, gear } = &record.draft;
    sqlx::query(
        "INSERT INTO records (id, iteration, kind, method, created_at, request, result, gear) VALUES (?, ?, ?, ?, ?, \
         ?, ?, ?)",
    )
    .bind(record.id)
    .bind(iteration)
    .bind(kind.name())
    .bind(method.as_str())
    .bind(time::to_text(record.created_at))
    .bind(request.clone())
    .bind(result.clone())
    .bind(gear.clone())
    .execute(db)
    .await?;
    Ok(())
}

pub async fn record(db: &SqlitePool, job: Uuid, number: u32, id: Uuid) -> Result<Record, RepositoryError> {
    let mut db = db.begin().await.map_err(sql)?;
    let iteration = read::iteration_seq(&mut db, job, number).await?;
    let row = sqlx::query(
        "SELECT id, kind, method, created_at, request, result, gear FROM records WHERE iteration = ? AND id = ?",
    )
    .bind(iteration)
    .bind(id)
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?
    .ok_or(RepositoryError::NotFound(What::Record))?;
    whole(&row)
}

/// Oldest first; one row more than asked for tells whether there is a next page.
pub async fn list(
    db: &SqlitePool,
    job: Uuid,
    number: u32,
    page: PageRequest,
) -> Result<Page<RecordSummary>, RepositoryError> {
    let mut db = db.begin().await.map_err(sql)?;
    let iteration = read::iteration_seq(&mut db, job, number).await?;
    let after = page.after.map_or([0; 16].to_vec(), |Cursor(id)| id.as_bytes().to_vec());
    let rows = sqlx::query(
        "SELECT id, kind, method, created_at FROM records WHERE iteration = ? AND id > ? ORDER BY id LIMIT ?",
    )
    .bind(iteration)
    .bind(after)
    .bind(i64::from(page.limit) + 1)
    .fetch_all(&mut *db)
    .await
    .map_err(sql)?;
    Ok(Page::of(rows.iter().map(summary).collect::<Result<Vec<_>, _>>()?, page.limit, |record| record.id))
}

/// The last of an iteration, oldest first, and how many stand before them.
pub async fn last_summaries(
    db: &mut SqliteConnection,
    iteration: i64,
) -> Result<(Vec<RecordSummary>, u64), RepositoryError> {
    let rows = sqlx::query(
        "SELECT id, kind, method, created_at, (SELECT count(*) FROM records WHERE iteration = ?1)
         FROM records WHERE iteration = ?1 ORDER BY id DESC LIMIT ?2",
    )
    .bind(iteration)
    .bind(MOST_TOLD)
    .fetch_all(db)
    .await
    .map_err(sql)?;
    Ok((rows.iter().rev().map(summary).collect::<Result<Vec<_>, _>>()?, read::earlier(&rows, 4)?))
}

/// The one of a kind that was kept last.
pub async fn latest(
    db: &SqlitePool,
    job: Uuid,
    number: u32,
    kind: RecordKind,
) -> Result<Option<Record>, RepositoryError> {
    let mut db = db.begin().await.map_err(sql)?;
    let iteration = read::iteration_seq(&mut db, job, number).await?;
    let row = sqlx::query(
        "SELECT id, kind, method, created_at, request, result, gear FROM records WHERE iteration = ? AND kind = ?
         ORDER BY id DESC LIMIT 1",
    )
    .bind(iteration)
    .bind(kind.name())
    .fetch_optional(&mut *db)
    .await
    .map_err(sql)?;
    row.as_ref().map(whole).transpose()
}

/// A record with its texts.
fn whole(row: &SqliteRow) -> Result<Record, RepositoryError> {
    let RecordSummary { id, kind, method, created_at } = summary(row)?;
    let text = |at| get::<&str>(row, at).map(Into::into);
    let gear = get::<Option<&str>>(row, 6)?.map(Into::into);
    Ok(Record { id, created_at, draft: RecordDraft { kind, method, request: text(4)?, result: text(5)?, gear } })
}

fn summary(row: &SqliteRow) -> Result<RecordSummary, RepositoryError> {
    let kind: &str = get(row, 1)?;
    Ok(RecordSummary {
        id: get(row, 0)?,
        kind: RecordKind::named(kind).ok_or_else(|| damaged("a kind of record", kind))?,
        method: get(row, 2)?,
        created_at: rows::moment(row, 3)?,
    })
}
