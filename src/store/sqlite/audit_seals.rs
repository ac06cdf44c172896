//! Seals: heads of the chains that grew since the last ones.

use std::collections::BTreeMap;

use sqlx::{AssertSqlSafe, SqliteConnection, SqlitePool};

use super::{locate::signed, time};
use crate::{
    jobs::{
        Caller, Page, PageRequest, Tenant,
        audit::{Seal, Sealing, Sha256Digest, Unsealed, WholeSeal, seals},
    },
    store::shared::{
        GetSeals, GrownRow, LastSealRow, NewestSealRow, Outcome, Read, Run, SealAudit, SealRow, grown, last_seals,
        page_of_seals, seal_columns,
    },
};

/// Rows of one statement: 5 variables each, far below SQLite's 32,766.
const MOST_ROWS: usize = 1000;

impl Run<SqliteConnection> for SealAudit {
    /// Nobody else writes meanwhile, so all rows up to the last one are there.
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<Option<Vec<WholeSeal>>> {
        let newest: Option<NewestSealRow> = sqlx::query_as("SELECT at, upto FROM audit_seals ORDER BY at DESC LIMIT 1")
            .fetch_optional(&mut *db)
            .await?;
        let mut sealing: Sealing = self.0.clone();
        let mut from = 0;
        if let Some(newest) = newest {
            if newest.suffices(&sealing) {
                return Ok(Some(Vec::new()));
            }
            (from, sealing.at) = (newest.upto, newest.behind(sealing.at));
        }
        let upto: i64 = sqlx::query_scalar("SELECT coalesce(max(seq), 0) FROM audit").fetch_one(&mut *db).await?;
        // of each group the columns are those of the row with the greatest number
        let rows: Vec<GrownRow> = sqlx::query_as(
            "SELECT tenant, chain, max(number) AS number, sha256 FROM audit WHERE seq > ? GROUP BY tenant, chain",
        )
        .bind(from)
        .fetch_all(&mut *db)
        .await?;
        let grown = grown(rows);
        let mut last = BTreeMap::new();
        for tenant in grown.keys() {
            last.extend(last_seal(db, tenant).await?);
        }
        let made = seals(&last, grown, &sealing);
        for seal in &made {
            insert(db, seal, upto).await?;
        }
        Ok(Some(made))
    }
}

async fn last_seal(db: &mut SqliteConnection, tenant: &Tenant) -> Outcome<BTreeMap<Tenant, (u64, Sha256Digest)>> {
    let rows: Vec<LastSealRow> =
        sqlx::query_as("SELECT tenant, number, sha256 FROM audit_seals WHERE tenant = ? ORDER BY number DESC LIMIT 1")
            .bind(tenant.as_str())
            .fetch_all(db)
            .await?;
    Ok(last_seals(rows))
}

async fn insert(db: &mut SqliteConnection, WholeSeal { seal, heads }: &WholeSeal, upto: i64) -> Outcome<()> {
    sqlx::query(
        "INSERT INTO audit_seals (tenant, number, at, heads, root, previous, sha256, signature, public_key, upto)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(seal.tenant.as_str())
    .bind(signed(seal.number))
    .bind(time::to_text(seal.at))
    .bind(signed(seal.heads))
    .bind(seal.root.as_slice())
    .bind(seal.previous.as_slice())
    .bind(seal.sha256.as_slice())
    .bind(seal.signed.as_ref().map(|signed| signed.signature.as_slice()))
    .bind(seal.signed.as_ref().map(|signed| signed.public_key.as_slice()))
    .bind(upto)
    .execute(&mut *db)
    .await?;
    for heads in heads.chunks(MOST_ROWS) {
        let rows = vec!["(?, ?, ?, ?, ?)"; heads.len()].join(", ");
        let sql = format!("INSERT INTO audit_sealed (tenant, seal, chain, number, sha256) VALUES {rows}");
        let mut query = sqlx::query(AssertSqlSafe(sql)).persistent(false);
        for head in heads {
            query = query.bind(seal.tenant.as_str()).bind(signed(seal.number)).bind(head.chain);
            query = query.bind(signed(head.number)).bind(head.sha256.as_slice());
        }
        query.execute(&mut *db).await?;
    }
    Ok(())
}

/// What no seal has looked at yet.
pub async fn unsealed(from: &SqlitePool) -> Result<Unsealed, sqlx::Error> {
    let (next, oldest): (i64, Option<i64>) = sqlx::query_as(
        "SELECT coalesce(max(seq), 0) + 1,
                (SELECT min(seq) FROM audit
                 WHERE seq > coalesce((SELECT upto FROM audit_seals ORDER BY at DESC LIMIT 1), 0))
         FROM audit",
    )
    .fetch_one(from)
    .await?;
    Ok(Unsealed { next, oldest })
}

impl Read<SqlitePool> for GetSeals {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &SqlitePool) -> Outcome<Page<Seal>> {
        let PageRequest { limit, after } = self.page;
        let rows: Vec<SealRow> = sqlx::query_as(concat!(
            "SELECT ",
            seal_columns!(),
            " FROM audit_seals WHERE tenant = ? AND number > ? ORDER BY number LIMIT ?"
        ))
        .bind(tenant.as_str())
        .bind(after.map_or(0, |cursor| signed(cursor.number())))
        .bind(i64::from(limit) + 1)
        .fetch_all(from)
        .await?;
        Ok(page_of_seals(rows, limit))
    }
}
