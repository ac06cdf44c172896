//! Seals: heads of the chains that grew since the last ones.

use std::collections::BTreeMap;

use super::{
    db::{Db, Pool},
    error::Outcome,
    row::{GrownRow, NewestSealRow, SealRow, grown, seal_columns},
    write::{Tx, Write},
};
use crate::jobs::{
    Caller, Cursor, Page, PageRequest,
    audit::{Head, Seal, Sealing, Unsealed, WholeSeal, seals as made_of},
};

/// Seals the chains that grew; returns the seals, or none where another process does so.
pub struct SealAudit(pub Sealing);

impl Write for SealAudit {
    type Reply = Option<Vec<WholeSeal>>;

    /// An entry is sealed once every transaction that began before its own has ended: none can come
    /// late, and none of a chain is passed over.
    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Option<Vec<WholeSeal>>> {
        let db = tx.db();
        let lock = "SELECT pg_try_advisory_xact_lock(hashtext('flankfit seals'))";
        if db.is_postgres() && !db.one::<bool>(lock, args![]).await? {
            return Ok(None);
        }
        let newest = "SELECT at, upto FROM audit_seals ORDER BY at DESC LIMIT 1";
        let newest: Option<NewestSealRow> = db.maybe(newest, args![]).await?;
        let mut sealing: Sealing = self.0.clone();
        let mut from = 0;
        if let Some(newest) = newest {
            if newest.suffices(&sealing) {
                return Ok(Some(Vec::new()));
            }
            (from, sealing.at) = (newest.upto, newest.behind(sealing.at));
        }
        let upto: i64 = db.one("SELECT audit FROM horizon", args![]).await?;
        // a database that was restored counts its transactions anew: there all chains have grown
        let (from, to) = if upto < from { (0, i64::MAX) } else { (from, upto) };
        let sql = "SELECT a.tenant, a.chain, a.number, a.sha256
                   FROM (SELECT chain, max(number) AS number FROM audit
                         WHERE changed_by >= $1 AND changed_by < $2 GROUP BY chain) AS g
                        JOIN audit a ON a.chain = g.chain AND a.number = g.number";
        let rows: Vec<GrownRow> = db.all(sql, args![from, to]).await?;
        let grown = grown(rows);
        let mut last = BTreeMap::new();
        for tenant in grown.keys() {
            let sql = "SELECT number, sha256 FROM audit_seals WHERE tenant = $1 ORDER BY number DESC LIMIT 1";
            let seal: Option<Head> = db.maybe(sql, args![tenant]).await?;
            last.extend(seal.map(|seal| (tenant.clone(), (seal.number, seal.sha256))));
        }
        let made = made_of(&last, grown, &sealing);
        for seal in &made {
            insert(db, seal, upto).await?;
        }
        Ok(Some(made))
    }
}

async fn insert(db: &mut Db, WholeSeal { seal, heads }: &WholeSeal, upto: i64) -> Outcome<()> {
    let signed = seal.signed.as_ref();
    db.run(
        "INSERT INTO audit_seals (tenant, number, at, heads, root, previous, sha256, signature, public_key, upto)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)",
        args![
            &seal.tenant,
            seal.number,
            seal.at,
            seal.heads,
            &seal.root,
            &seal.previous,
            &seal.sha256,
            signed.map(|signed| signed.signature.as_slice()),
            signed.map(|signed| signed.public_key.as_slice()),
            upto,
        ],
    )
    .await?;
    let mut rows = Vec::with_capacity(heads.len());
    for head in heads {
        rows.push(vec![
            (&seal.tenant).into(),
            seal.number.into(),
            head.chain.into(),
            head.number.into(),
            (&head.sha256).into(),
        ]);
    }
    Ok(db.insert("audit_sealed", "tenant, seal, chain, number, sha256", &rows).await?)
}

/// Returns what no seal has looked at yet: entries since the newest one, and those that it left out
/// because an older transaction had not ended.
pub async fn unsealed(from: &Pool) -> Outcome<Unsealed> {
    let mut db = from.snapshot().await?;
    let sql = "SELECT audit_next, (SELECT upto FROM audit_seals ORDER BY at DESC LIMIT 1) FROM horizon";
    let rows: Vec<(i64, Option<i64>)> = db.all(sql, args![]).await?;
    let (next, upto) = rows[0];
    // a database that was restored counts its transactions anew
    let upto = upto.filter(|upto| *upto <= next).unwrap_or(0);
    let sql = "SELECT min(changed_by) FROM audit WHERE changed_by >= $1 AND changed_by < $2";
    let oldest: Option<i64> = db.one(sql, args![upto, next]).await?;
    Ok(Unsealed { next, oldest })
}

pub async fn seals(
    db: &mut Db,
    Caller { tenant, .. }: &Caller,
    PageRequest { limit, after }: &PageRequest,
) -> Outcome<Page<Seal>> {
    let sql = concat!(
        "SELECT ",
        seal_columns!(),
        " FROM audit_seals WHERE tenant = $1 AND number > $2 ORDER BY number LIMIT $3"
    );
    let after = after.map_or(0, |cursor| cursor.number());
    let rows: Vec<SealRow> = db.all(sql, args![tenant, after, i64::from(*limit) + 1]).await?;
    Ok(Page::of(rows.into_iter().map(Seal::from).collect(), *limit, |seal: &Seal| Cursor::after_number(seal.number)))
}
