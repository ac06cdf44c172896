//! Records of an iteration.

use sqlx::{SqliteConnection, SqlitePool};

use super::{
    answers, audit, gone,
    locate::{self, IterationVersion, within},
    time,
};
use crate::{
    jobs::{
        Caller, Page, PageRequest, Record, RecordDraft, RecordSummary, RepositoryError, Resource, Stored, audit::Action,
    },
    store::shared::{
        Asked, GetLatestRecord, GetRecord, InsertRecord, ListRecords, Listed, Outcome, Read, RecordRow,
        RecordSummaryRow, Write, page, target,
    },
};

impl Write<SqliteConnection> for InsertRecord {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (InsertRecord { job, number, record, receipt }, tenant) = (&asked.write, asked.tenant());
        let IterationVersion { seq, version } = locate::iteration(db, tenant, *job, *number).await?;
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        let mut chain = audit::of_job(db, asked.by(), *job).await?;
        insert_row(db, seq, record).await?;
        asked.enter(&mut chain, Action::AddRecord, target::record(*job, *number, record.id));
        audit::store(db, chain).await?;
        // Records are beside the iteration: its version stays.
        let stored = Stored { number: *number, version };
        answers::keep(db, tenant, receipt.as_ref(), stored, record.created_at, None).await?;
        Ok(stored)
    }
}

/// The row of a record of the iteration that is row `iteration`.
pub async fn insert_row(db: &mut SqliteConnection, iteration: i64, record: &Record) -> Outcome<()> {
    let RecordDraft { kind, method, request, result, gear, class, measurand } = &record.draft;
    sqlx::query(
        "INSERT INTO records (id, iteration, kind, method, created_at, actor, request, result, gear, class, measurand)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(record.id)
    .bind(iteration)
    .bind(kind.name())
    .bind(method.as_str())
    .bind(time::to_text(record.created_at))
    .bind(record.by.as_deref())
    .bind(request.clone())
    .bind(result.clone())
    .bind(gear.clone())
    .bind(*class)
    .bind(measurand.clone())
    .execute(db)
    .await?;
    Ok(())
}

impl Read<SqlitePool> for GetRecord {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Record> {
        let (mut db, iteration) = within(from, caller, self.job, self.number).await?;
        let row: Option<RecordRow> = sqlx::query_as(
            "SELECT id, kind, method, created_at, actor, request, result, gear, class, measurand FROM records WHERE iteration = ? AND id = ?",
        )
        .bind(iteration)
        .bind(self.id)
        .fetch_optional(&mut *db)
        .await?;
        match row.ok_or(RepositoryError::NotFound(Resource::Record))? {
            row if row.is_gone() => Err(gone::told(&mut db, self.job).await),
            row => Ok(row.into()),
        }
    }
}

impl Read<SqlitePool> for ListRecords {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Page<RecordSummary>> {
        let PageRequest { limit, after } = self.page;
        let (mut db, iteration) = within(from, caller, self.job, self.number).await?;
        let after = after.map_or(0, |cursor| locate::signed(cursor.number()));
        let rows: Vec<Listed<RecordSummaryRow>> = sqlx::query_as(
            "SELECT seq AS place, id, kind, method, created_at, actor, measurand FROM records
             WHERE iteration = ? AND seq > ? ORDER BY seq LIMIT ?",
        )
        .bind(iteration)
        .bind(after)
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        Ok(page(rows, limit))
    }
}

/// The last of an iteration, oldest first, and how many stand before them.
pub async fn last(db: &mut SqliteConnection, iteration: i64) -> Outcome<(Vec<RecordSummary>, u64)> {
    locate::last::<RecordSummaryRow, _>(
        db,
        "SELECT id, kind, method, created_at, actor, measurand, (SELECT count(*) FROM records WHERE iteration = ?1) AS total
         FROM records WHERE iteration = ?1 ORDER BY seq DESC LIMIT ?2",
        iteration,
    )
    .await
}

impl Read<SqlitePool> for GetLatestRecord {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Option<Record>> {
        let (mut db, iteration) = within(from, caller, self.job, self.number).await?;
        let row: Option<RecordRow> = sqlx::query_as(
            "SELECT id, kind, method, created_at, actor, request, result, gear, class, measurand FROM records WHERE iteration = ? AND kind = ?
         ORDER BY seq DESC LIMIT 1",
        )
        .bind(iteration)
        .bind(self.kind.name())
        .fetch_optional(&mut *db)
        .await?;
        match row {
            Some(row) if row.is_gone() => Err(gone::told(&mut db, self.job).await),
            row => Ok(row.map(Into::into)),
        }
    }
}
