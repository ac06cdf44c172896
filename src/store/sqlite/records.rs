//! What is kept with an iteration beside its fits.

use sqlx::{FromRow, SqliteConnection, SqlitePool};

use super::{
    answers,
    lists::{Counted, in_order},
    locate::{self, IterationVersion, iteration_seq},
    time,
};
use crate::{
    jobs::{
        Caller, Cursor, MAX_LISTED, Page, PageRequest, Record, RecordDraft, RecordSummary, RepositoryError, Resource,
        Stored,
    },
    store::shared::{
        GetLatestRecord, GetRecord, InsertRecord, Integer, ListRecords, Outcome, Read, RecordRow, RecordSummaryRow,
        Write,
    },
};

impl Write<SqliteConnection> for InsertRecord {
    async fn write(&self, Caller { tenant, .. }: &Caller, db: &mut SqliteConnection) -> Outcome<Stored> {
        let InsertRecord { job, number, record, receipt } = self;
        let IterationVersion { seq, version } = locate::iteration(db, tenant, *job, *number).await?;
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        insert_row(db, seq, record).await?;
        // Records are beside the iteration: its version stays.
        let stored = Stored { number: *number, version };
        answers::keep(db, tenant, receipt.as_ref(), stored, record.created_at, None).await?;
        Ok(stored)
    }
}

/// The row of a record of the iteration that is row `iteration`.
pub async fn insert_row(db: &mut SqliteConnection, iteration: i64, record: &Record) -> Outcome<()> {
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

impl Read<SqlitePool> for GetRecord {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Record> {
        let mut db = from.begin().await?;
        let iteration = iteration_seq(&mut db, &caller.tenant, self.job, self.number).await?;
        let row: Option<RecordRow> = sqlx::query_as(
            "SELECT id, kind, method, created_at, request, result, gear FROM records WHERE iteration = ? AND id = ?",
        )
        .bind(iteration)
        .bind(self.id)
        .fetch_optional(&mut *db)
        .await?;
        Ok(row.ok_or(RepositoryError::NotFound(Resource::Record))?.into())
    }
}

#[derive(FromRow)]
struct ListedRecordRow {
    seq: Integer<u64>,
    #[sqlx(flatten)]
    row: RecordSummaryRow,
}

impl Read<SqlitePool> for ListRecords {
    /// One row more than asked for tells whether there is a next page.
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Page<RecordSummary>> {
        let PageRequest { limit, after } = self.page;
        let mut db = from.begin().await?;
        let iteration = iteration_seq(&mut db, &caller.tenant, self.job, self.number).await?;
        let after = after.map_or(0, |cursor| locate::signed(cursor.number()));
        let rows: Vec<ListedRecordRow> = sqlx::query_as(
            "SELECT seq, id, kind, method, created_at FROM records WHERE iteration = ? AND seq > ? ORDER BY seq LIMIT ?",
        )
        .bind(iteration)
        .bind(after)
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        let page = Page::of(rows, limit, |row| Cursor::after_number(row.seq.0));
        Ok(page.map(|row| row.row.into()))
    }
}

/// The last of an iteration, oldest first, and how many stand before them.
pub async fn last(db: &mut SqliteConnection, iteration: i64) -> Outcome<(Vec<RecordSummary>, u64)> {
    let rows: Vec<Counted<RecordSummaryRow>> = sqlx::query_as(
        "SELECT id, kind, method, created_at, (SELECT count(*) FROM records WHERE iteration = ?1) AS total
         FROM records WHERE iteration = ?1 ORDER BY seq DESC LIMIT ?2",
    )
    .bind(iteration)
    .bind(MAX_LISTED)
    .fetch_all(db)
    .await?;
    Ok(in_order(rows))
}

impl Read<SqlitePool> for GetLatestRecord {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Option<Record>> {
        let mut db = from.begin().await?;
        let iteration = iteration_seq(&mut db, &caller.tenant, self.job, self.number).await?;
        let row: Option<RecordRow> = sqlx::query_as(
            "SELECT id, kind, method, created_at, request, result, gear FROM records WHERE iteration = ? AND kind = ?
         ORDER BY seq DESC LIMIT 1",
        )
        .bind(iteration)
        .bind(self.kind.name())
        .fetch_optional(&mut *db)
        .await?;
        Ok(row.map(Into::into))
    }
}
