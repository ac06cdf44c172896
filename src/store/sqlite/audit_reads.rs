//! The audit, read and verified.

use sqlx::SqlitePool;

use super::{jobs, locate::signed};
use crate::{
    jobs::{
        Caller, Page, PageRequest,
        audit::{Chain, Entry},
    },
    store::shared::{EntryRow, GetAudit, Outcome, Read, entries, entry_columns},
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
