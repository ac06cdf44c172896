//! The audit, read and verified.

use futures_util::TryStreamExt as _;
use sqlx::{FromRow, SqlitePool};

use super::{audit::found, jobs, locate::signed};
use crate::{
    jobs::{
        Caller, Page, PageRequest,
        audit::{Chain, Entry, Head, Verdict, Verifier},
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
        let sealed: Vec<HeadRow> =
            sqlx::query_as("SELECT number, sha256 FROM audit_sealed WHERE chain = ? AND tenant = ?")
                .bind(self.job)
                .bind(tenant.as_str())
                .fetch_all(&mut *db)
                .await?;
        let sealed = sealed.into_iter().map(Head::from).map(|head| (head.number, head.sha256)).collect();
        let mut verifier = Verifier::of(Chain::Job(self.job), tenant, sealed);
        let mut rows = sqlx::query(concat!(
            "SELECT ",
            entry_columns!(),
            " FROM audit WHERE chain = ? AND tenant = ? ORDER BY number"
        ))
        .bind(self.job)
        .bind(tenant.as_str())
        .fetch(&mut *db);
        let mut none = true;
        while let Some(row) = rows.try_next().await? {
            none = false;
            verifier.entry(EntryRow::from_row(&row).ok().and_then(EntryRow::entry).as_ref());
        }
        drop(rows);
        if none {
            jobs::located(&mut db, tenant, self.job).await?;
        }
        Ok(verifier.conclude(&found(&mut db, self.job).await?))
    }
}
