//! Records of an iteration.

use super::{
    audit, gone,
    lists::{Listed, page},
    locate,
    prelude::*,
    subject,
};

from_row! {
    RecordSummary { id, kind, method, created_at, by = "actor", measurand }
    RecordDraft { kind, method, request, result, gear, class, measurand }
    Record { @draft, id, created_at, by = "actor" }
}

pub async fn insert_record(tx: &mut Tx<'_>, write: &InsertRecord) -> Outcome<Stored> {
    let (InsertRecord { job, number, record, receipt }, tenant) = (write, tx.tenant());
    let version = locate::version(tx.db(), tenant, *job, *number).await?;
    tx.refuse_taken()?;
    let mut entry = tx.draft(*job, Action::AddRecord, subject::record(*job, *number, record.id))?;
    insert_next(tx.db(), *job, *number, record, &mut entry).await?;
    tx.enter(entry);
    // a record does not change the version of its iteration
    Ok(tx.keep(receipt, Stored { number: *number, version }, None, record.created_at))
}

/// Adds a record to those of an iteration.
pub async fn insert_next(db: &mut Db, job: Uuid, number: u32, record: &Record, entry: &mut Draft) -> Outcome<()> {
    let sql = "SELECT coalesce(max(position), 0) FROM records WHERE job = $1 AND number = $2";
    let last: u64 = db.one(sql, args![job, number]).await?;
    insert(db, job, number, last, std::slice::from_ref(record), entry).await
}

/// Stores records of an iteration after the one at the position `last`, noted in an entry.
pub async fn insert(
    db: &mut Db,
    job: Uuid,
    number: u32,
    last: u64,
    records: &[Record],
    entry: &mut Draft,
) -> Outcome<()> {
    let columns = "job, number, position, id, kind, method, created_at, actor, request, result, gear, class, measurand";
    for (position, record) in (last + 1..).zip(records) {
        let RecordDraft { kind, method, request, result, gear, class, measurand } = &record.draft;
        let row = args![
            job,
            number,
            position,
            record.id,
            kind.name(),
            method,
            record.created_at,
            record.by.as_deref(),
            Value::document(request),
            Value::document(result),
            gear.as_deref(),
            *class,
            measurand.as_deref(),
        ];
        audit::insert(db, "records", columns, row.to_vec(), entry).await?;
    }
    Ok(())
}

/// Reads a [`Record`] of an iteration.
macro_rules! columns {
    () => {
        "SELECT id, kind, method, created_at, actor, request, result, gear, class, measurand FROM records
         WHERE job = $1 AND number = $2 AND "
    };
}

pub async fn record(db: &mut Db, caller: &Caller, job: &Uuid, number: &u32, id: &Uuid) -> Outcome<Record> {
    locate::iteration(db, &caller.tenant, *job, *number).await?;
    let record: Option<Record> = db.maybe(concat!(columns!(), "id = $3"), args![job, *number, id]).await?;
    match record.ok_or(RepositoryError::NotFound(Resource::Record))? {
        record if record.draft.result.is_empty() => Err(gone::refusal(db, *job).await),
        record => Ok(record),
    }
}

pub async fn records(
    db: &mut Db,
    caller: &Caller,
    job: &Uuid,
    number: &u32,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Page<RecordSummary>> {
    locate::iteration(db, &caller.tenant, *job, *number).await?;
    let sql = "SELECT position AS place, id, kind, method, created_at, actor, measurand FROM records
               WHERE job = $1 AND number = $2 AND position > $3 ORDER BY position LIMIT $4";
    let after = after.map_or(0, |cursor| cursor.number());
    let rows: Vec<Listed<RecordSummary>> = db.all(sql, args![job, *number, after, i64::from(*limit) + 1]).await?;
    Ok(page(rows, *limit))
}

/// Returns the last records of an iteration, oldest first, and how many come before them.
pub async fn last(db: &mut Db, job: Uuid, number: u32) -> Outcome<(Vec<RecordSummary>, u64)> {
    let sql = "SELECT id, kind, method, created_at, actor, measurand,
                      (SELECT count(*) FROM records WHERE job = $1 AND number = $2) AS total
               FROM records WHERE job = $1 AND number = $2 ORDER BY position DESC LIMIT $3";
    locate::last(db, sql, job, number).await
}

pub async fn latest_record(
    db: &mut Db,
    caller: &Caller,
    job: &Uuid,
    number: &u32,
    kind: &RecordKind,
) -> Outcome<Option<Record>> {
    locate::iteration(db, &caller.tenant, *job, *number).await?;
    let sql = concat!(columns!(), "kind = $3 ORDER BY position DESC LIMIT 1");
    match db.maybe::<Record>(sql, args![job, *number, kind.name()]).await? {
        Some(record) if record.draft.result.is_empty() => Err(gone::refusal(db, *job).await),
        record => Ok(record),
    }
}
