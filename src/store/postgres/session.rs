//! A connection that writes, and what its transaction holds.

use std::collections::HashMap;

use sqlx::{AssertSqlSafe, Connection as _, Executor as _, PgConnection};
use uuid::Uuid;

use super::{
    audit, audit_keys,
    keys::{Keys, OwnedKey, owned},
};
use crate::{
    jobs::{
        KeyId, Lease, Tenant,
        audit::{Action, By, Chain, Head},
    },
    store::shared::{Asked, Growing, NewEntry, Operation, Outcome, Queued, Subject, of_keys},
};

pub struct Session {
    pub db: PgConnection,
    /// The idempotency keys that the transaction has claimed.
    pub keys: Keys,
    /// The last entries of the chains of the jobs that it has locked, before it.
    heads: HashMap<Uuid, Head>,
    /// The chains that it adds to.
    chains: HashMap<Uuid, Growing>,
}

/// Where an entry stands, and which: whoever finds it there knows that its transaction was
/// committed.
#[derive(Clone, Copy, Debug)]
pub struct Proof {
    chain: Uuid,
    number: u64,
    id: Uuid,
}

/// What the writes of a group need for themselves alone.
#[derive(Default)]
pub struct Wanted {
    jobs: Vec<Uuid>,
    streams: Vec<Uuid>,
    keys: Vec<OwnedKey>,
    leases: Vec<Lease>,
}

impl Wanted {
    pub fn by(group: &[Queued<Session>]) -> Self {
        let mut wanted = Wanted::default();
        for write in group {
            match write.subject() {
                Subject::Job(id) => wanted.jobs.push(id),
                Subject::Stream(id) => wanted.streams.push(id),
                Subject::Nothing => {}
            }
            wanted.keys.extend(write.key().map(owned));
            wanted.leases.extend(write.lease());
        }
        wanted
    }
}

impl Session {
    pub fn of(db: PgConnection) -> Self {
        let (heads, chains) = Default::default();
        Session { db, keys: Keys::default(), heads, chains }
    }

    /// Begins a transaction of this id. One of the same id that is still running is waited for.
    pub async fn begin(&mut self, change: Uuid) -> Result<(), sqlx::Error> {
        let lock = change.as_u64_pair().1.cast_signed();
        let begin = format!("BEGIN; SELECT pg_advisory_xact_lock({lock})");
        self.db.execute(sqlx::raw_sql(AssertSqlSafe(begin))).await?;
        Ok(())
    }

    /// Whether a transaction was committed that is proved by an entry.
    pub async fn was_committed(&mut self, proof: Option<Proof>) -> Result<bool, sqlx::Error> {
        match proof {
            Some(Proof { chain, number, id }) => audit::is_there(&mut self.db, chain, number, id).await,
            None => Ok(false),
        }
    }

    /// Locks the jobs, claims the idempotency keys and locks the tasks of a group, each in
    /// ascending order.
    pub async fn lock(&mut self, Wanted { mut jobs, streams, keys, leases }: Wanted) -> Result<(), sqlx::Error> {
        if !streams.is_empty() {
            // the job of a stream stays
            let of: Vec<Uuid> = sqlx::query_scalar("SELECT job FROM streams WHERE id = ANY($1)")
                .bind(streams)
                .fetch_all(&mut self.db)
                .await?;
            jobs.extend(of);
        }
        self.chains.clear();
        self.heads.clear();
        if !jobs.is_empty() {
            jobs.sort_unstable();
            jobs.dedup();
            sqlx::query("SELECT FROM jobs WHERE id = ANY($1) ORDER BY id FOR NO KEY UPDATE")
                .bind(&jobs)
                .execute(&mut self.db)
                .await?;
            // only now is it sure which entries are the last
            let heads = audit::heads(&mut self.db, &jobs).await?;
            self.heads = heads.into_iter().map(|(chain, head)| (chain, head.into())).collect();
        }
        self.keys.claim(&mut self.db, keys).await?;
        self.keys.hold(&mut self.db, &leases).await
    }

    /// Writes the answers down that are to be kept.
    pub async fn write_answers(&mut self) -> Result<(), sqlx::Error> {
        self.keys.write(&mut self.db).await
    }

    /// Enters a change of a job of the caller's, before it is made; the entry is stored with the
    /// others of the transaction. A chain that has no entry yet begins with what is found now.
    pub async fn enter<O: Operation>(
        &mut self,
        asked: &Asked<O>,
        job: Uuid,
        action: Action,
        target: String,
    ) -> Outcome<()> {
        let chain = self.chain(asked.by(), job).await?;
        asked.enter(chain, action, target);
        Ok(())
    }

    /// The chain of a job that there is and that is locked.
    pub async fn chain(&mut self, by: By<'_>, job: Uuid) -> Outcome<&mut Growing> {
        if !self.chains.contains_key(&job) {
            let chain = match self.heads.get(&job) {
                Some(head) => Growing::from(&by.caller.tenant, Chain::Job(job), Some(*head)),
                None => Growing::begin(by, job, &audit::found(&mut self.db, &by.caller.tenant, job).await?),
            };
            self.chains.insert(job, chain);
        }
        self.chains.get_mut(&job).ok_or_else(|| sqlx::Error::RowNotFound.into())
    }

    /// Waits until no other transaction changes keys of a tenant, or the tenant, and lets none do
    /// so until this one has ended. First of all, so that none waits for what another holds.
    pub async fn lock_tenant(&mut self, tenant: &Tenant) -> Outcome<()> {
        let lock = Chain::Tenant.id(tenant).as_u64_pair().1.cast_signed();
        sqlx::query("SELECT pg_advisory_xact_lock($1)").bind(lock).execute(&mut self.db).await?;
        Ok(())
    }

    /// The chain of a tenant that is locked, to add to it: of changes that are of no job. It is
    /// asked for before anything is changed, but for the key that is new: one that has no entry
    /// yet begins with the keys that are found now.
    pub async fn tenant_chain(&mut self, by: By<'_>, tenant: &Tenant, new: Option<KeyId>) -> Outcome<&mut Growing> {
        let id = Chain::Tenant.id(tenant);
        if !self.chains.contains_key(&id) {
            let chain = match audit::heads(&mut self.db, &[id]).await?.pop() {
                Some((_, head)) => Growing::from(tenant, Chain::Tenant, Some(head.into())),
                None => {
                    let keys = audit_keys::keys(&mut self.db, tenant, new).await?;
                    Growing::begin_tenant(by, tenant, of_keys(&keys, None))
                }
            };
            self.chains.insert(id, chain);
        }
        self.chains.get_mut(&id).ok_or_else(|| sqlx::Error::RowNotFound.into())
    }

    /// The chain of a job that is new.
    pub fn new_chain(&mut self, tenant: &Tenant, job: Uuid) -> &mut Growing {
        self.chains.entry(job).or_insert_with(|| Growing::from(tenant, Chain::Job(job), None))
    }

    /// Stores the entries; answers what proves that the transaction was committed, once it was.
    pub async fn write_entries(&mut self) -> Result<Option<Proof>, sqlx::Error> {
        let new: Vec<NewEntry> = self.chains.drain().flat_map(|(_, chain)| chain.new).collect();
        let Some(first) = new.first() else { return Ok(None) };
        audit::store(&mut self.db, &new).await?;
        Ok(Some(Proof { chain: first.chain, number: first.entry.number, id: first.entry.id }))
    }

    /// Commits.
    pub async fn commit(&mut self) -> Result<(), sqlx::Error> {
        sqlx::query("COMMIT").execute(&mut self.db).await?;
        Ok(())
    }

    /// Undoes the transaction.
    pub async fn rollback(&mut self) -> Result<(), sqlx::Error> {
        sqlx::query("ROLLBACK").execute(&mut self.db).await?;
        Ok(())
    }

    pub async fn close(self) -> Result<(), sqlx::Error> {
        self.db.close().await
    }
}
