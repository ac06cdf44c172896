//! Records of an iteration.

use sqlx::{PgConnection, PgPool};
use uuid::Uuid;

use super::{
    document::encode,
    gone,
    locate::{self, signed, within},
    session::Session,
    time::stamp,
};
use crate::{
    jobs::{Caller, Page, PageRequest, Record, RecordSummary, RepositoryError, Resource, Stored, audit::Action},
    store::shared::{
        Asked, GetLatestRecord, GetRecord, InsertRecord, ListRecords, Listed, Outcome, Read, RecordRow,
        RecordSummaryRow, Write, page, target,
    },
};

impl Write<Session> for InsertRecord {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (InsertRecord { job, number, record, receipt }, tenant) = (&asked.write, asked.tenant());
        let version = locate::iteration(&mut session.db, tenant, *job, *number).await?;
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        session.enter(asked, *job, Action::AddRecord, target::record(*job, *number, record.id)).await?;
        insert_next(&mut session.db, *job, i64::from(*number), record).await?;
        // Records are beside the iteration: its version stays.
        let stored = Stored { number: asked.write.number, version };
        session.keys.keep(tenant, receipt.as_ref(), stored, record.created_at, None);
        Ok(stored)
    }
}

/// Appends a record to those of an iteration.
pub async fn insert_next(db: &mut PgConnection, job: Uuid, number: i64, record: &Record) -> Outcome<()> {
    let last: i64 = sqlx::query_scalar("SELECT coalesce(max(position), 0) FROM records WHERE job = $1 AND number = $2")
        .bind(job)
        .bind(number)
        .fetch_one(&mut *db)
        .await?;
    insert_rows(db, job, number, last, std::slice::from_ref(record)).await
}

/// Stores records of an iteration behind the one at the position `last`.
pub async fn insert_rows(db: &mut PgConnection, job: Uuid, number: i64, last: i64, records: &[Record]) -> Outcome<()> {
    for (position, record) in (last + 1..).zip(records) {
        let draft = &record.draft;
        sqlx::query(
            "INSERT INTO records (job, number, position, id, kind, method, created_at, actor, request, result, gear,
                                  class, measurand)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10, $11, $12, $13)",
        )
        .bind(job)
        .bind(number)
        .bind(position)
        .bind(record.id)
        .bind(draft.kind.name())
        .bind(draft.method.as_str())
        .bind(stamp(record.created_at))
        .bind(record.by.as_deref())
        .bind(encode(&draft.request))
        .bind(encode(&draft.result))
        .bind(draft.gear.as_deref())
        .bind(draft.class.map(i64::from))
        .bind(draft.measurand.as_deref())
        .execute(&mut *db)
        .await?;
    }
    Ok(())
}

impl Read<PgPool> for GetRecord {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Record> {
        let mut db = within(from, caller, self.job, self.number).await?;
        let row: Option<RecordRow> = sqlx::query_as(
            "SELECT id, kind, method, created_at, actor, request, result, gear, class, measurand FROM records
             WHERE job = $1 AND number = $2 AND id = $3",
        )
        .bind(self.job)
        .bind(i64::from(self.number))
        .bind(self.id)
        .fetch_optional(&mut *db)
        .await?;
        match row.ok_or(RepositoryError::NotFound(Resource::Record))? {
            row if row.is_gone() => Err(gone::told(&mut db, self.job).await),
            row => Ok(row.into()),
        }
    }
}

impl Read<PgPool> for ListRecords {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Page<RecordSummary>> {
        let PageRequest { limit, after } = self.page;
        let mut db = within(from, caller, self.job, self.number).await?;
        let rows: Vec<Listed<RecordSummaryRow>> = sqlx::query_as(
            "SELECT position AS place, id, kind, method, created_at, actor, measurand FROM records
             WHERE job = $1 AND number = $2 AND position > $3 ORDER BY position LIMIT $4",
        )
        .bind(self.job)
        .bind(i64::from(self.number))
        .bind(after.map_or(0, |cursor| signed(cursor.number())))
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        Ok(page(rows, limit))
    }
}

/// The last of an iteration, oldest first, and how many stand before them.
pub async fn last(db: &mut PgConnection, job: Uuid, number: i64) -> Outcome<(Vec<RecordSummary>, u64)> {
    locate::last::<RecordSummaryRow, _>(
        db,
        "SELECT id, kind, method, created_at, actor, measurand,
                (SELECT count(*) FROM records WHERE job = $1 AND number = $2) AS total
         FROM records WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT $3",
        (job, number),
    )
    .await
}

impl Read<PgPool> for GetLatestRecord {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Option<Record>> {
        let mut db = within(from, caller, self.job, self.number).await?;
        let row: Option<RecordRow> = sqlx::query_as(
            "SELECT id, kind, method, created_at, actor, request, result, gear, class, measurand FROM records
             WHERE job = $1 AND number = $2 AND kind = $3 ORDER BY position DESC LIMIT 1",
        )
        .bind(self.job)
        .bind(i64::from(self.number))
        .bind(self.kind.name())
        .fetch_optional(&mut *db)
        .await?;
        match row {
            Some(row) if row.is_gone() => Err(gone::told(&mut db, self.job).await),
            row => Ok(row.map(Into::into)),
        }
    }
}
