//! Seals: heads of the chains that grew since the last ones.

use sqlx::{PgConnection, PgPool};

use super::{locate::signed, session::Session, time::stamp};
use crate::{
    jobs::{
        Caller, Page, PageRequest,
        audit::{Seal, Sealing, Unsealed, WholeSeal, seals},
    },
    store::shared::{
        GetSeals, GrownRow, LastSealRow, NewestSealRow, Outcome, Read, Run, SealAudit, SealRow, grown, last_seals,
        page_of_seals, seal_columns,
    },
};

impl Run<Session> for SealAudit {
    /// By whichever process comes first. An entry is sealed once every transaction that began
    /// before its own has ended: none can come late, and of a chain none is passed over.
    async fn run(&self, Session { db, .. }: &mut Session) -> Outcome<Option<Vec<WholeSeal>>> {
        let own: bool = sqlx::query_scalar("SELECT pg_try_advisory_xact_lock(hashtext('flankfit seals'))")
            .fetch_one(&mut *db)
            .await?;
        if !own {
            return Ok(None);
        }
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
        let upto: i64 = sqlx::query_scalar("SELECT pg_snapshot_xmin(pg_current_snapshot())::text::bigint")
            .fetch_one(&mut *db)
            .await?;
        // a database that was restored counts its transactions anew: there all chains have grown
        let (from, to) = if upto < from { (0, i64::MAX) } else { (from, upto) };
        let rows: Vec<GrownRow> = sqlx::query_as(
            "SELECT DISTINCT ON (tenant, chain) tenant, chain, number, sha256 FROM audit
             WHERE changed_by >= $1 AND changed_by < $2 ORDER BY tenant, chain, number DESC",
        )
        .bind(from)
        .bind(to)
        .fetch_all(&mut *db)
        .await?;
        let grown = grown(rows);
        let last: Vec<LastSealRow> = sqlx::query_as(
            "SELECT s.tenant, s.number, s.sha256 FROM unnest($1::text[]) AS t (tenant) CROSS JOIN LATERAL
                 (SELECT tenant, number, sha256 FROM audit_seals WHERE tenant = t.tenant
                  ORDER BY number DESC LIMIT 1) AS s",
        )
        .bind(grown.keys().map(|tenant| tenant.as_str()).collect::<Vec<_>>())
        .fetch_all(&mut *db)
        .await?;
        let made = seals(&last_seals(last), grown, &sealing);
        for seal in &made {
            insert(db, seal, upto).await?;
        }
        Ok(Some(made))
    }
}

async fn insert(db: &mut PgConnection, WholeSeal { seal, heads }: &WholeSeal, upto: i64) -> Outcome<()> {
    sqlx::query(
        "INSERT INTO audit_seals (tenant, number, at, heads, root, previous, sha256, signature, public_key, upto)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)",
    )
    .bind(seal.tenant.as_str())
    .bind(signed(seal.number))
    .bind(stamp(seal.at))
    .bind(signed(seal.heads))
    .bind(seal.root.as_slice())
    .bind(seal.previous.as_slice())
    .bind(seal.sha256.as_slice())
    .bind(seal.signed.as_ref().map(|signed| signed.signature.as_slice()))
    .bind(seal.signed.as_ref().map(|signed| signed.public_key.as_slice()))
    .bind(upto)
    .execute(&mut *db)
    .await?;
    sqlx::query(
        "INSERT INTO audit_sealed (tenant, seal, chain, number, sha256)
         SELECT $1, $2, * FROM unnest($3::uuid[], $4::bigint[], $5::bytea[])",
    )
    .bind(seal.tenant.as_str())
    .bind(signed(seal.number))
    .bind(heads.iter().map(|head| head.chain).collect::<Vec<_>>())
    .bind(heads.iter().map(|head| signed(head.number)).collect::<Vec<_>>())
    .bind(heads.iter().map(|head| head.sha256.as_slice()).collect::<Vec<_>>())
    .execute(db)
    .await?;
    Ok(())
}

/// What no seal has looked at yet: what came since the newest one, and what that left out because
/// something older had not ended.
pub async fn unsealed(from: &PgPool) -> Result<Unsealed, sqlx::Error> {
    let (next, upto): (i64, Option<i64>) = sqlx::query_as(
        "SELECT pg_snapshot_xmax(pg_current_snapshot())::text::bigint,
                (SELECT upto FROM audit_seals ORDER BY at DESC LIMIT 1)",
    )
    .fetch_one(from)
    .await?;
    // a database that was restored counts its transactions anew
    let upto = upto.filter(|upto| *upto <= next).unwrap_or(0);
    let oldest = sqlx::query_scalar("SELECT min(changed_by) FROM audit WHERE changed_by >= $1 AND changed_by < $2")
        .bind(upto)
        .bind(next)
        .fetch_one(from)
        .await?;
    Ok(Unsealed { next, oldest })
}

impl Read<PgPool> for GetSeals {
    async fn read(&self, Caller { tenant, .. }: &Caller, from: &PgPool) -> Outcome<Page<Seal>> {
        let PageRequest { limit, after } = self.page;
        let rows: Vec<SealRow> = sqlx::query_as(concat!(
            "SELECT ",
            seal_columns!(),
            " FROM audit_seals WHERE tenant = $1 AND number > $2 ORDER BY number LIMIT $3"
        ))
        .bind(tenant.as_str())
        .bind(after.map_or(0, |cursor| signed(cursor.number())))
        .bind(i64::from(limit) + 1)
        .fetch_all(from)
        .await?;
        Ok(page_of_seals(rows, limit))
    }
}
