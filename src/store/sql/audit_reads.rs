//! The audit, read and verified.

use std::collections::BTreeMap;

use futures_util::TryStreamExt as _;
use uuid::Uuid;

use super::{
    audit::{self, Readable},
    audit_keys,
    db::Db,
    error::Outcome,
    jobs,
    row::entry_columns,
};
use crate::jobs::{
    Caller, Cursor, Page, PageRequest, Tenant,
    audit::{Chain, Entry, Found, Head, Sha256Digest, Verdict, Verifier},
};

pub async fn audit(
    db: &mut Db,
    Caller { tenant, .. }: &Caller,
    chain: &Chain,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Page<Entry>> {
    let sql = concat!(
        "SELECT ",
        entry_columns!(),
        " FROM audit WHERE chain = $1 AND tenant = $2 AND number > $3 ORDER BY number LIMIT $4"
    );
    let after = after.map_or(0, |cursor| cursor.number());
    let rows: Vec<Entry> = db.all(sql, args![chain.id(tenant), tenant, after, i64::from(*limit) + 1]).await?;
    if let (Chain::Job(job), true) = (chain, rows.is_empty()) {
        // a job that was deleted has entries
        jobs::located(db, tenant, *job).await?;
    }
    Ok(Page::of(rows, *limit, |entry| Cursor::after_number(entry.number)))
}

pub async fn verify_audit(db: &mut Db, Caller { tenant, .. }: &Caller, chain: &Chain) -> Outcome<Verdict> {
    let verdict = verify(db, tenant, *chain, BTreeMap::new()).await?;
    if let (Chain::Job(job), Verdict::Intact { entries: 0, .. }) = (chain, verdict) {
        // a job that was deleted has entries
        jobs::located(db, tenant, *job).await?;
    }
    Ok(verdict)
}

/// Verifies that a chain and the rows that it is about are as they were written. The heads in
/// `sealed` count more than the seals of the database.
pub async fn verify(
    db: &mut Db,
    tenant: &Tenant,
    chain: Chain,
    sealed: BTreeMap<u64, Sha256Digest>,
) -> Outcome<Verdict> {
    let id = chain.id(tenant);
    let sql = "SELECT number, sha256 FROM audit_sealed WHERE chain = $1 AND tenant = $2";
    let own: Vec<Head> = db.all(sql, args![id, tenant]).await?;
    let own = own.into_iter().map(|head| (head.number, head.sha256));
    let mut verifier = Verifier::of(chain, tenant, own.chain(sealed).collect());
    let sql = concat!("SELECT ", entry_columns!(), " FROM audit WHERE chain = $1 AND tenant = $2 ORDER BY number");
    let mut rows = db.each::<Readable<Entry>>(sql, args![id, tenant])?;
    while let Some(Readable(row)) = rows.try_next().await? {
        verifier.entry(row.as_ref());
    }
    drop(rows);
    let found = match chain {
        Chain::Job(job) => of_job(db, tenant, job).await?,
        Chain::Tenant => audit_keys::found(db, tenant).await?,
    };
    Ok(verifier.conclude(&found))
}

/// Tests whether the list of jobs differs from the trace of a job. (The first fit and the first
/// choice are made with their iteration. The list may have a later time: the clock of another
/// server was ahead.)
const LISTED_OTHERWISE: &str = "
    SELECT j.iteration_count <> coalesce((SELECT max(number) FROM iterations WHERE job = j.id), 0)
        OR j.status <> CASE (SELECT min(rank) FROM expected_flanks WHERE job = j.id)
            WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' WHEN 4 THEN 'accepted' ELSE 'new' END
        OR EXISTS (SELECT flank, tooth, number, rank FROM expected_flanks WHERE job = j.id
                   EXCEPT SELECT flank, tooth, number, rank FROM flanks WHERE job = j.id)
        OR (SELECT count(*) FROM expected_flanks WHERE job = j.id) <> (SELECT count(*) FROM flanks WHERE job = j.id)
        OR j.changed_at < j.updated_at
        OR EXISTS (SELECT 1 FROM iterations WHERE job = j.id AND created_at > j.changed_at)
        OR EXISTS (SELECT 1 FROM fits WHERE job = j.id AND position > 1 AND created_at > j.changed_at)
        OR EXISTS (SELECT 1 FROM fit_choices WHERE job = j.id AND position > 1 AND created_at > j.changed_at)
        OR EXISTS (SELECT 1 FROM decisions WHERE job = j.id AND created_at > j.changed_at)
        OR EXISTS (SELECT 1 FROM records WHERE job = j.id AND created_at > j.changed_at)
    FROM jobs j WHERE j.id = $1 AND j.tenant = $2";

/// Returns the rows of a job, and what else the store has of it.
async fn of_job(db: &mut Db, tenant: &Tenant, job: Uuid) -> Outcome<Found> {
    let mut found = audit::found(db, tenant, job).await?;
    let elsewhere = "SELECT 1 FROM audit WHERE chain = $1 AND tenant <> $2 LIMIT 1";
    found.told_elsewhere = db.is_there(elsewhere, args![job, tenant]).await?;
    found.listed_otherwise = db.first(LISTED_OTHERWISE, args![job, tenant]).await?.unwrap_or(false);
    Ok(found)
}
