//! The audit, read and verified.

use std::collections::BTreeMap;

use futures_util::TryStreamExt as _;
use sqlx::{FromRow as _, SqliteConnection, SqlitePool};
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
    WITH j AS (SELECT * FROM jobs WHERE id = ? AND tenant = ?),
    newest AS (SELECT coalesce(m.flank, '') AS flank, coalesce(m.tooth, '') AS tooth, max(m.number) AS number
               FROM j JOIN measured m ON m.job = j.seq GROUP BY 1, 2),
    expected AS (SELECT n.flank, n.tooth, n.number, CASE
                     (SELECT d.decision FROM j JOIN iterations i ON i.job = j.seq
                      JOIN decisions d ON d.iteration = i.seq
                      WHERE i.number = n.number ORDER BY d.position DESC LIMIT 1)
                     WHEN 'reject' THEN 1 WHEN 'remachine' THEN 2 WHEN 'accept' THEN 4 ELSE 3 END AS rank
                 FROM newest n)
    SELECT j.iteration_count <> coalesce((SELECT max(number) FROM iterations WHERE job = j.seq), 0)
        OR j.status <> CASE (SELECT min(rank) FROM expected)
            WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' WHEN 4 THEN 'accepted' ELSE 'new' END
        OR EXISTS (SELECT * FROM expected EXCEPT SELECT flank, tooth, number, rank FROM flanks WHERE job = j.seq)
        OR (SELECT count(*) FROM expected) <> (SELECT count(*) FROM flanks WHERE job = j.seq)
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
    FROM j";

/// The rows of a job, and what else the store says of it.
async fn of_job(db: &mut SqliteConnection, tenant: &Tenant, job: Uuid) -> Outcome<Found> {
    let mut found = audit::found(db, tenant, job).await?;
    let elsewhere = sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM audit WHERE chain = ?1 AND tenant <> ?2)");
    found.told_elsewhere = elsewhere.bind(job).bind(tenant.as_str()).fetch_one(&mut *db).await?;
    let otherwise = sqlx::query_scalar(LISTED_OTHERWISE).bind(job).bind(tenant.as_str()).fetch_optional(db).await?;
    found.listed_otherwise = otherwise.unwrap_or(false);
    Ok(found)
}
