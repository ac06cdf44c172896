//! The audit, read and verified.

use std::collections::BTreeMap;

use futures_util::TryStreamExt as _;
use sqlx::{FromRow as _, PgConnection, PgPool};
use uuid::Uuid;

use super::{audit, audit_keys, jobs, locate::signed, open::snapshot};
use crate::{
    jobs::{
        Caller, Page, PageRequest, Tenant,
        audit::{Chain, Entry, Found, Head, Sha256Digest, Verdict, Verifier},
    },
    store::shared::{EntryRow, GetAudit, HeadRow, Outcome, Read, VerifyAudit, entries, entry_columns},
};

impl Read<PgPool> for GetAudit {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &PgPool) -> Outcome<Page<Entry>> {
        let PageRequest { limit, after } = self.page;
        let mut db = snapshot(from).await?;
        let rows: Vec<EntryRow> = sqlx::query_as(concat!(
            "SELECT ",
            entry_columns!(),
            " FROM audit WHERE chain = $1 AND tenant = $2 AND number > $3 ORDER BY number LIMIT $4"
        ))
        .bind(self.chain.id(tenant))
        .bind(tenant.as_str())
        .bind(after.map_or(0, |cursor| signed(cursor.number())))
        .bind(i64::from(limit) + 1)
        .fetch_all(&mut *db)
        .await?;
        if let (Chain::Job(job), true) = (self.chain, rows.is_empty()) {
            // one that was deleted has entries
            jobs::located(&mut db, tenant, job).await?;
        }
        entries(rows, limit)
    }
}

impl Read<PgPool> for VerifyAudit {
    /// In one state of the database.
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &PgPool) -> Outcome<Verdict> {
        let mut db = snapshot(from).await?;
        let verdict = verify(&mut db, tenant, self.chain, BTreeMap::new()).await?;
        if let (Chain::Job(job), Verdict::Intact { entries: 0, .. }) = (self.chain, verdict) {
            // one that was deleted has entries
            jobs::located(&mut db, tenant, job).await?;
        }
        Ok(verdict)
    }
}

/// Whether a chain and the rows that it tells of are as they were written. What `sealed` says
/// counts more than the seals of the database.
pub async fn verify(
    db: &mut PgConnection,
    tenant: &Tenant,
    chain: Chain,
    sealed: BTreeMap<u64, Sha256Digest>,
) -> Outcome<Verdict> {
    let id = chain.id(tenant);
    let own: Vec<HeadRow> = sqlx::query_as("SELECT number, sha256 FROM audit_sealed WHERE chain = $1 AND tenant = $2")
        .bind(id)
        .bind(tenant.as_str())
        .fetch_all(&mut *db)
        .await?;
    let own = own.into_iter().map(Head::from).map(|head| (head.number, head.sha256));
    let mut verifier = Verifier::of(chain, tenant, own.chain(sealed).collect());
    let mut rows = sqlx::query(concat!(
        "SELECT ",
        entry_columns!(),
        " FROM audit WHERE chain = $1 AND tenant = $2 ORDER BY number"
    ))
    .bind(id)
    .bind(tenant.as_str())
    .fetch(&mut *db);
    while let Some(row) = rows.try_next().await? {
        verifier.entry(EntryRow::from_row(&row).ok().and_then(EntryRow::entry).as_ref());
    }
    drop(rows);
    let found = match chain {
        Chain::Job(job) => of_job(db, tenant, job).await?,
        Chain::Tenant => audit_keys::found(db, tenant).await?,
    };
    Ok(verifier.conclude(&found))
}

/// Whether the job is listed by something else than its trace tells. (The first fit and the first
/// choice are made with their iteration. A job may be listed as changed later than its rows tell:
/// the clock of another server was ahead.)
const LISTED_OTHERWISE: &str = "
    SELECT j.iteration_count <> coalesce((SELECT max(number) FROM iterations WHERE job = j.id), 0)
        OR j.status <> status_of((SELECT min(rank) FROM flanks_of(j.id)))
        OR EXISTS (SELECT * FROM flanks_of(j.id) EXCEPT SELECT flank, tooth, number, rank FROM flanks WHERE job = j.id)
        OR (SELECT count(*) FROM flanks_of(j.id)) <> (SELECT count(*) FROM flanks WHERE job = j.id)
        OR j.changed_at < greatest(
            j.updated_at,
            (SELECT max(created_at) FROM iterations WHERE job = j.id),
            (SELECT max(created_at) FROM fits WHERE job = j.id AND position > 1),
            (SELECT max(created_at) FROM fit_choices WHERE job = j.id AND position > 1),
            (SELECT max(created_at) FROM decisions WHERE job = j.id),
            (SELECT max(created_at) FROM records WHERE job = j.id))
    FROM jobs j WHERE j.id = $1 AND j.tenant = $2";

/// The rows of a job, and what else the store says of it.
async fn of_job(db: &mut PgConnection, tenant: &Tenant, job: Uuid) -> Outcome<Found> {
    let mut found = audit::found(db, tenant, job).await?;
    let elsewhere = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM audit WHERE chain = $1 AND tenant <> $2)");
    found.told_elsewhere = elsewhere.bind(job).bind(tenant.as_str()).fetch_one(&mut *db).await?;
    let otherwise = sqlx::query_scalar(LISTED_OTHERWISE).bind(job).bind(tenant.as_str()).fetch_optional(db).await?;
    found.listed_otherwise = otherwise.unwrap_or(false);
    Ok(found)
}
