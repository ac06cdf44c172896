//! The audit, read and verified.

use std::collections::BTreeMap;

use futures_util::TryStreamExt as _;
use sqlx::{FromRow, SqliteConnection, SqlitePool};
use uuid::Uuid;

use super::{audit, audit_keys, jobs, locate::signed};
use crate::{
    jobs::{
        Caller, Page, PageRequest, Tenant,
        audit::{Chain, Entry, Found, Head, Sha256Digest, Verdict, Verifier},
    },
    store::shared::{EntryRow, GetAudit, HeadRow, Outcome, Read, VerifyAudit, entries, entry_columns},
};

impl Read<SqlitePool> for GetAudit {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &SqlitePool) -> Outcome<Page<Entry>> {
        let PageRequest { limit, after } = self.page;
        let mut db = from.begin().await?;
        let rows: Vec<EntryRow> = sqlx::query_as(concat!(
            "SELECT ",
            entry_columns!(),
            " FROM audit WHERE chain = ? AND tenant = ? AND number > ? ORDER BY number LIMIT ?"
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

impl Read<SqlitePool> for VerifyAudit {
    /// In one state of the database.
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &SqlitePool) -> Outcome<Verdict> {
        let mut db = from.begin().await?;
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
    db: &mut SqliteConnection,
    tenant: &Tenant,
    chain: Chain,
    sealed: BTreeMap<u64, Sha256Digest>,
) -> Outcome<Verdict> {
    let id = chain.id(tenant);
    let own: Vec<HeadRow> = sqlx::query_as("SELECT number, sha256 FROM audit_sealed WHERE chain = ? AND tenant = ?")
        .bind(id)
        .bind(tenant.as_str())
        .fetch_all(&mut *db)
        .await?;
    let own = own.into_iter().map(Head::from).map(|head| (head.number, head.sha256));
    let mut verifier = Verifier::of(chain, tenant, own.chain(sealed).collect());
    let mut rows =
        sqlx::query(concat!("SELECT ", entry_columns!(), " FROM audit WHERE chain = ? AND tenant = ? ORDER BY number"))
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
    SELECT j.iteration_count <> coalesce((SELECT max(number) FROM iterations WHERE job = j.seq), 0)
        OR j.status <> CASE
            (SELECT d.decision FROM iterations i JOIN decisions d ON d.iteration = i.seq
             WHERE i.job = j.seq AND i.number = j.iteration_count ORDER BY d.position DESC LIMIT 1)
            WHEN 'accept' THEN 'accepted' WHEN 'reject' THEN 'rejected' WHEN 'remachine' THEN 'remachine'
            ELSE iif(j.iteration_count > 0, 'open', 'new') END
        OR j.changed_at < max(
            j.updated_at,
            coalesce((SELECT max(created_at) FROM iterations WHERE job = j.seq), ''),
            coalesce((SELECT max(f.created_at) FROM iterations i JOIN fits f ON f.iteration = i.seq
                      WHERE i.job = j.seq AND f.seq <> (SELECT min(seq) FROM fits WHERE iteration = i.seq)), ''),
            coalesce((SELECT max(c.created_at) FROM iterations i JOIN fit_choices c ON c.iteration = i.seq
                      WHERE i.job = j.seq AND c.position > 1), ''),
            coalesce((SELECT max(d.created_at) FROM iterations i JOIN decisions d ON d.iteration = i.seq
                      WHERE i.job = j.seq), ''),
            coalesce((SELECT max(r.created_at) FROM iterations i JOIN records r ON r.iteration = i.seq
                      WHERE i.job = j.seq), ''))
    FROM jobs j WHERE j.id = ? AND j.tenant = ?";

/// The rows of a job, and what else the store says of it.
async fn of_job(db: &mut SqliteConnection, tenant: &Tenant, job: Uuid) -> Outcome<Found> {
    let mut found = audit::found(db, tenant, job).await?;
    let elsewhere = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM audit WHERE chain = ?1 AND tenant <> ?2)");
    found.told_elsewhere = elsewhere.bind(job).bind(tenant.as_str()).fetch_one(&mut *db).await?;
    let otherwise = sqlx::query_scalar(LISTED_OTHERWISE).bind(job).bind(tenant.as_str()).fetch_optional(db).await?;
    found.listed_otherwise = otherwise.unwrap_or(false);
    Ok(found)
}
