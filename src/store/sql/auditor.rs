//! The audit of all tenants, sealed, and verified from outside.

use std::collections::{BTreeMap, BTreeSet};

use futures_util::TryStreamExt as _;
use sqlx::{AssertSqlSafe, FromRow};

use super::{db::Pool, error::reading, prelude::*};
use crate::jobs::{
    audit::{Auditor, ChainVerifier, Difference, Kind, RowVerifier, Sealed, Sealing, Verdict, is_sound},
    rows::{OF_JOBS, OF_TENANTS, Table},
};

/// Entries that are sealed in one transaction.
const AT_A_TIME: usize = 10_000;

/// Links and seals the entries that are not sealed.
pub struct SealAudit(pub Sealing);

/// The end of a chain: its last link and its last seal.
type End = (Link, Option<Seal>);

impl Write for SealAudit {
    type Reply = Option<Sealed>;

    /// All that is committed is linked, whatever other transactions go on: they are looked at again
    /// as long as one may end that began before. All is read before the first row is inserted.
    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Option<Sealed>> {
        let (db, Sealing { at, key }) = (tx.db(), &self.0);
        let lock = "SELECT pg_try_advisory_xact_lock(hashtext('flankfit seals'))";
        if db.is_postgres() && !db.one::<bool>(lock, args![]).await? {
            return Ok(None);
        }
        let from: Option<i64> = db.first("SELECT upto FROM audit_seals ORDER BY at DESC LIMIT 1", args![]).await?;
        let horizon: i64 = db.one("SELECT audit FROM horizon", args![]).await?;
        // a database that was restored counts its transactions anew
        let from = from.filter(|from| *from <= horizon).unwrap_or(0);
        let sql = concat!(
            "SELECT ",
            entry_columns!(),
            " FROM audit a WHERE a.changed_by >= $1 AND NOT EXISTS (SELECT 1 FROM audit_chain c WHERE c.entry = a.id)
              ORDER BY a.changed_by, a.id LIMIT $2 OFFSET $3"
        );
        let (mut sealed, mut chains, mut skipped, mut upto) = (Sealed::default(), Vec::new(), 0, horizon);
        loop {
            let rows: Vec<Readable<Entry>> = db.all(sql, args![from, AT_A_TIME, skipped]).await?;
            sealed.more = rows.len() == AT_A_TIME;
            let mut tenants: BTreeMap<Tenant, Vec<Entry>> = BTreeMap::new();
            let mut unreadable = rows.len();
            for entry in rows.into_iter().filter_map(|row| row.0) {
                tenants.entry(entry.tenant.clone()).or_default().push(entry);
                unreadable -= 1;
            }
            if unreadable > 0 {
                sealed.failed.push(format!("{unreadable} entries cannot be read"));
                skipped += unreadable;
            }
            for (tenant, entries) in tenants {
                if let Some(end) = end(db, &tenant).await? {
                    chains.push((tenant, entries, end));
                    continue;
                }
                let name = tenant.as_str();
                sealed.failed.push(format!("the end of the chain of tenant {name} cannot be read"));
                skipped += entries.len();
                // they are looked at until it is repaired
                upto = from;
            }
            // entries that cannot be sealed do not keep others from it
            if !chains.is_empty() || !sealed.more {
                break;
            }
        }
        if sealed.more {
            upto = from;
        }
        for (tenant, entries, (mut head, last)) in chains {
            let mut links = Vec::with_capacity(entries.len());
            for entry in &entries {
                head = head.next(&entry.digest());
                links.push((entry.id, head));
            }
            let row = |(id, link): &(Uuid, Link)| {
                vec![
                    (&tenant).into(),
                    link.number.into(),
                    (*id).into(),
                    Value::Bytes(Some(link.sha256.to_vec().into())),
                ]
            };
            let rows: Vec<_> = links.iter().map(row).collect();
            db.insert("audit_chain", "tenant, number, entry, sha256", rows).await?;
            let seal = Seal::next(&tenant, last.as_ref(), head, *at, key.as_deref());
            insert(db, &seal, upto).await?;
            sealed.seals.push(seal);
        }
        Ok(Some(sealed))
    }
}

/// Returns the end of the chain of a tenant; `None` if it cannot be read, or nothing can follow it.
async fn end(db: &mut Db, tenant: &Tenant) -> Outcome<Option<End>> {
    let sql = "SELECT number, sha256 FROM audit_chain WHERE tenant = $1 ORDER BY number DESC LIMIT 1";
    let link: Option<Readable<Link>> = db.maybe(sql, args![tenant]).await?;
    let sql = concat!("SELECT ", seal_columns!(), " FROM audit_seals WHERE tenant = $1 ORDER BY number DESC LIMIT 1");
    let seal: Option<Readable<Seal>> = db.maybe(sql, args![tenant]).await?;
    let link = link.map_or(Some(Link::genesis(tenant)), |link| link.0);
    let seal = seal.map_or(Some(None), |seal| seal.0.map(Some));
    let is_last = |(link, seal): &End| link.number.max(seal.as_ref().map_or(0, |seal| seal.number)) == i64::MAX as u64;
    Ok(link.zip(seal).filter(|end| !is_last(end)))
}

async fn insert(db: &mut Db, seal: &Seal, upto: i64) -> Outcome<()> {
    let signed = seal.signed.as_ref();
    db.run(
        "INSERT INTO audit_seals (tenant, number, at, last_entry, last_sha256, previous, sha256, signature, public_key,
                                  upto)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10)",
        args![
            &seal.tenant,
            seal.number,
            seal.at,
            seal.last.number,
            &seal.last.sha256,
            &seal.previous,
            &seal.sha256,
            signed.map(|signed| signed.signature.as_slice()),
            signed.map(|signed| signed.public_key.as_slice()),
            upto,
        ],
    )
    .await?;
    Ok(())
}

/// Reads the audit of a database.
pub struct SqlAuditor(pub(in crate::store) Pool);

/// A row that can be read, or none.
struct Readable<T>(Option<T>);

impl<'r, R: sqlx::Row, T: FromRow<'r, R>> FromRow<'r, R> for Readable<T> {
    fn from_row(row: &'r R) -> Result<Self, sqlx::Error> {
        Ok(Readable(T::from_row(row).ok()))
    }
}

row! {
    /// A place in a chain, with its entry.
    struct Placed {
        @entry: Readable<Entry>,
        @link: Readable<Link>,
        is_there: bool,
        is_purged: bool,
    }
}

row! {
    /// An entry, with the place before its own.
    struct Following {
        @listed: Readable<ListedEntry>,
        before: Option<[u8; 32]>,
        is_purged: bool,
    }
}

/// The condition for the entries of a job, or of a tenant and its keys.
const OF_JOB: &str = "a.job = $1 AND a.tenant = $2";
const OF_TENANT: &str = "a.job IS NULL AND a.tenant = $1";

/// Tests whether the list of jobs differs from the trace of a job. (The first fit and the first
/// choice are made with their iteration. The latest event names the last evaluation.)
const LISTED_OTHERWISE: &str = "
    SELECT j.iteration_count <> coalesce((SELECT max(number) FROM iterations WHERE job = j.id), 0)
        OR j.status <> CASE (SELECT min(rank) FROM expected_flanks WHERE job = j.id)
            WHEN 1 THEN 'rejected' WHEN 2 THEN 'remachine' WHEN 3 THEN 'open' WHEN 4 THEN 'accepted' ELSE 'new' END
        OR EXISTS (SELECT flank, tooth, number, rank FROM expected_flanks WHERE job = j.id
                   EXCEPT SELECT flank, tooth, number, rank FROM flanks WHERE job = j.id)
        OR (SELECT count(*) FROM expected_flanks WHERE job = j.id) <> (SELECT count(*) FROM flanks WHERE job = j.id)
        OR j.changed_at <> (SELECT max(at) FROM (
               SELECT j.updated_at AS at UNION ALL SELECT created_at FROM iterations WHERE job = j.id
               UNION ALL SELECT created_at FROM fits WHERE job = j.id AND position > 1
               UNION ALL SELECT created_at FROM fit_choices WHERE job = j.id AND position > 1
               UNION ALL SELECT created_at FROM decisions WHERE job = j.id
               UNION ALL SELECT created_at FROM records WHERE job = j.id) AS times)
        OR j.class IS DISTINCT FROM (
               SELECT r.class FROM events e
               JOIN records r ON r.job = e.job AND r.number = e.iteration AND r.id = e.record
               WHERE e.job = j.id AND r.kind = 'evaluation' ORDER BY e.number DESC LIMIT 1)
        OR j.purged_at IS DISTINCT FROM (SELECT at FROM purges WHERE job = j.id)
    FROM jobs j WHERE j.id = $1 AND j.tenant = $2";

/// Verifies the entries and rows of a job, or of a tenant and its keys, in one state.
pub async fn verify_rows(db: &mut Db, tenant: &Tenant, job: Option<Uuid>) -> Outcome<Verdict> {
    let (mut verdict, mut verifier) = (Verdict::default(), RowVerifier::default());
    let difference = |place: String, kind| Difference { tenant: tenant.as_str().to_owned(), job, place, kind };
    let args: Vec<Value<'_>> = job.map(Value::from).into_iter().chain([tenant.into()]).collect();
    let sql = format!(
        "SELECT {}, c.number, c.sha256, EXISTS (SELECT 1 FROM purges WHERE job = a.job) AS is_purged,
                (SELECT p.sha256 FROM audit_chain p WHERE p.tenant = c.tenant AND p.number = c.number - 1) AS before
         FROM audit a LEFT JOIN audit_chain c ON c.entry = a.id WHERE {} ORDER BY a.id",
        entry_columns!(),
        if job.is_some() { OF_JOB } else { OF_TENANT }
    );
    let mut rows = db.each::<Following>(AssertSqlSafe(sql), &args)?;
    while let Some(Following { listed, before, is_purged }) = rows.try_next().await? {
        verdict.entries += 1;
        let Some(ListedEntry { entry, place }) = listed.0 else {
            verdict.differences.insert(difference("an entry".to_owned(), Kind::Unreadable));
            continue;
        };
        verifier.entry(&entry);
        let Some(place) = place else {
            verdict.unsealed += 1;
            continue;
        };
        let before = match place.number.checked_sub(1) {
            Some(0) => Some(Link::genesis(tenant)),
            number => number.zip(before).map(|(number, sha256)| Link { number, sha256 }),
        };
        let is_linked = before.is_some_and(|before| before.next(&entry.digest()) == place);
        if !is_linked || !is_sound(&entry, is_purged) {
            verdict.differences.insert(difference(format!("entry {}", place.number), Kind::Changed));
        }
    }
    drop(rows);
    for table in if job.is_some() { OF_JOBS } else { OF_TENANTS } {
        read(db, table, &args, &mut verifier).await?;
    }
    if job.is_some() {
        match db.first::<bool>(LISTED_OTHERWISE, &args).await {
            Ok(differs) if differs.unwrap_or(false) => verifier.difference("jobs", Kind::Derived),
            Ok(_) => {}
            Err(error) if error.as_database_error().is_none() => return Err(error.into()),
            Err(error) => verifier.difference(&format!("jobs: {error}"), Kind::Unreadable),
        }
    }
    verdict.differences.extend(verifier.conclude().into_iter().map(|(place, kind)| difference(place, kind)));
    Ok(verdict)
}

/// Passes the rows of a table on; one that cannot be read is a difference.
async fn read(db: &mut Db, table: &'static Table, args: &[Value<'_>], to: &mut RowVerifier) -> Outcome<()> {
    let mut rows = db.rows(table, &format!("{} ORDER BY {}", table.of, table.order()), args)?;
    loop {
        match rows.try_next().await {
            Ok(Some(row)) => to.row(&row),
            Ok(None) => return Ok(()),
            Err(error @ (sqlx::Error::ColumnDecode { .. } | sqlx::Error::Decode(_))) => {
                to.difference(&format!("{}: {error}", table.name), Kind::Unreadable);
            }
            Err(error) => return Err(error.into()),
        }
    }
}

/// Returns the jobs of a tenant that exist or have entries, and whether all of their ids can be
/// read.
async fn job_ids(db: &mut Db, tenant: &Tenant) -> Outcome<(BTreeSet<Uuid>, bool)> {
    let sql = "SELECT id FROM jobs WHERE tenant = $1
               UNION SELECT job FROM audit WHERE tenant = $1 AND job IS NOT NULL";
    let rows: Vec<Readable<(Cell<Uuid>,)>> = db.all(sql, args![tenant]).await?;
    let are_readable = rows.iter().all(|row| row.0.is_some());
    Ok((rows.into_iter().filter_map(|row| row.0).map(|(Cell(id),)| id).collect(), are_readable))
}

/// Verifies the chain of a tenant with its seals, and its keys.
async fn verify_chain(
    db: &mut Db,
    tenant: &Tenant,
    kept: &BTreeMap<u64, Seal>,
    key: Option<[u8; 32]>,
) -> Outcome<Verdict> {
    let mut verdict = verify_rows(db, tenant, None).await?;
    let difference = |job, place: String, kind| Difference { tenant: tenant.as_str().to_owned(), job, place, kind };
    let sql = concat!("SELECT ", seal_columns!(), " FROM audit_seals WHERE tenant = $1 ORDER BY number");
    let mut chain = ChainVerifier::new(tenant, kept, key);
    let mut seals = db.each::<Readable<Seal>>(sql, args![tenant])?;
    while let Some(Readable(seal)) = seals.try_next().await? {
        match seal {
            Some(seal) => chain.seal(&seal).await,
            None => drop(verdict.differences.insert(difference(None, "a seal".to_owned(), Kind::Unreadable))),
        }
    }
    drop(seals);
    verdict.seals = chain.seals;
    if !job_ids(db, tenant).await?.1 {
        verdict.differences.insert(difference(None, "the id of a job".to_owned(), Kind::Unreadable));
    }
    let sql = concat!(
        "SELECT ",
        entry_columns!(),
        ", c.number, c.sha256, a.id IS NOT NULL AS is_there, EXISTS (SELECT 1 FROM purges WHERE job = a.job) AS is_purged
         FROM audit_chain c LEFT JOIN audit a ON a.id = c.entry WHERE c.tenant = $1 ORDER BY c.number"
    );
    let mut rows = db.each::<Placed>(sql, args![tenant])?;
    while let Some(Placed { entry, link, is_there, is_purged }) = rows.try_next().await? {
        let Some(link) = link.0 else {
            verdict.differences.insert(difference(None, "a place in the chain".to_owned(), Kind::Unreadable));
            continue;
        };
        let entry = entry.0.as_ref().ok_or(if is_there { Kind::Unreadable } else { Kind::Missing });
        chain.entry(link, entry, is_purged);
    }
    verdict.differences.extend(chain.conclude().into_iter().map(|(job, place, kind)| difference(job, place, kind)));
    Ok(verdict)
}

impl Auditor for SqlAuditor {
    fn tenants(&self) -> RepositoryFuture<'_, BTreeSet<String>> {
        let sql = "SELECT name FROM tenants UNION SELECT tenant FROM jobs UNION SELECT tenant FROM api_keys
                   UNION SELECT tenant FROM audit UNION SELECT tenant FROM audit_chain
                   UNION SELECT tenant FROM audit_seals";
        reading(async move {
            let rows: Vec<Readable<(Cell<String>,)>> = self.0.connection().await?.all(sql, args![]).await?;
            // whatever is of a tenant whose name cannot be read is missing elsewhere
            Ok(rows.into_iter().filter_map(|row| row.0).map(|(Cell(name),)| name).collect())
        })
    }

    fn jobs(&self, tenant: Tenant) -> RepositoryFuture<'_, BTreeSet<Uuid>> {
        reading(async move { Ok(job_ids(&mut self.0.connection().await?, &tenant).await?.0) })
    }

    fn job(&self, tenant: Tenant, job: Uuid) -> RepositoryFuture<'_, Verdict> {
        reading(async move {
            let mut db = self.0.snapshot().await?;
            Ok(Verdict { jobs: 1, ..verify_rows(&mut db, &tenant, Some(job)).await? })
        })
    }

    fn chain(&self, tenant: Tenant, kept: BTreeMap<u64, Seal>, key: Option<[u8; 32]>) -> RepositoryFuture<'_, Verdict> {
        reading(async move { verify_chain(&mut self.0.snapshot().await?, &tenant, &kept, key).await })
    }
}
