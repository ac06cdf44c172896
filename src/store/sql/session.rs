//! A connection that writes, and what its transaction holds.

use std::collections::HashMap;

use uuid::Uuid;

use super::{
    api_keys, audit, audit_keys,
    db::Db,
    error::Outcome,
    growing::{Growing, NewEntry},
    keys::Keys,
    write::{Asked, Subject},
};
use crate::jobs::{
    KeyId, Tenant,
    audit::{By, Chain, Head},
};

/// See the module's documentation.
pub struct Session {
    pub db: Db,
    /// The idempotency keys that the transaction has claimed.
    pub keys: Keys,
    /// The last entries of the chains of the jobs that it has locked, from before it.
    heads: HashMap<Uuid, Head>,
    /// The chains that it adds to.
    chains: HashMap<Uuid, Growing>,
}

/// An entry that proves that its transaction was committed.
#[derive(Clone, Copy, Debug)]
pub struct Proof {
    chain: Uuid,
    number: u64,
    id: Uuid,
}

row! {
    /// The last entry of the chain of a job.
    struct JobHead {
        id: Uuid,
        number: Option<u64>,
        sha256: Option<[u8; 32]>,
    }
}

impl Session {
    pub fn of(db: Db) -> Self {
        Session { db, keys: Keys::default(), heads: HashMap::new(), chains: HashMap::new() }
    }

    /// Locks the jobs, claims the idempotency keys and locks the tasks of a group, each in
    /// ascending order.
    pub async fn lock(&mut self, asked: Vec<&Asked>) -> Result<(), sqlx::Error> {
        let (mut jobs, mut streams) = (Vec::new(), Vec::new());
        for asked in &asked {
            match asked.subject {
                Subject::Job(id) => jobs.push(id),
                Subject::Stream(id) => streams.push(id),
                Subject::Nothing => {}
            }
        }
        // the job of a stream stays the same
        let of_streams: Vec<(Uuid,)> = self.db.of_ids("SELECT job FROM streams WHERE id IN ({ids})", streams).await?;
        jobs.extend(of_streams.into_iter().map(|(job,)| job));
        self.chains.clear();
        if self.db.is_postgres() {
            let lock = "SELECT id FROM jobs WHERE id IN ({ids}) ORDER BY id FOR NO KEY UPDATE";
            self.db.of_ids::<(Uuid,)>(lock, jobs.iter().copied()).await?;
        }
        // after the lock: only now these entries stay the last
        let sql = "SELECT id, (SELECT max(number) FROM audit WHERE chain = jobs.id) AS number,
                          (SELECT sha256 FROM audit WHERE chain = jobs.id ORDER BY number DESC LIMIT 1) AS sha256
                   FROM jobs WHERE id IN ({ids})";
        let heads: Vec<JobHead> = self.db.of_ids(sql, jobs).await?;
        let head = |row: JobHead| Some((row.id, Head { number: row.number?, sha256: row.sha256? }));
        self.heads = heads.into_iter().filter_map(head).collect();
        let leases: Vec<_> = asked.iter().filter_map(|asked| asked.lease).collect();
        self.keys.claim(&mut self.db, asked.iter().filter_map(|asked| asked.key.as_ref()).collect(), &leases).await
    }

    /// Returns the chain of a job that exists and is locked. A chain that has no entry yet begins
    /// with the rows that are found now.
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

    /// Begins the chain of a job that is new.
    pub fn begin_chain(&mut self, by: By<'_>, job: Uuid) {
        self.chains.insert(job, Growing::from(&by.caller.tenant, Chain::Job(job), None));
    }

    /// Waits until no other transaction changes the tenant or its keys, and lets none do so until
    /// this one has ended. It comes first, so that no transaction waits for what another one holds.
    pub async fn lock_tenant(&mut self, tenant: &Tenant) -> Outcome<()> {
        if self.db.is_postgres() {
            let lock = Chain::Tenant.id(tenant).as_u64_pair().1.cast_signed();
            self.db.run("SELECT pg_advisory_xact_lock($1)", args![lock]).await?;
        }
        Ok(())
    }

    /// Returns the chain of a tenant that is locked, for changes of no job. It is asked for before
    /// anything is changed, except that the key `new` was stored: a chain that has no entry yet
    /// begins with the keys that are found now.
    pub async fn tenant_chain(&mut self, by: By<'_>, tenant: &Tenant, new: Option<KeyId>) -> Outcome<&mut Growing> {
        let id = Chain::Tenant.id(tenant);
        if !self.chains.contains_key(&id) {
            let chain = match audit::head(&mut self.db, id).await? {
                Some(head) => Growing::from(tenant, Chain::Tenant, Some(head)),
                None => {
                    let keys = audit_keys::keys(&mut self.db, tenant, new).await?;
                    Growing::begin_tenant(by, tenant, api_keys::contents(&keys, None))
                }
            };
            self.chains.insert(id, chain);
        }
        self.chains.get_mut(&id).ok_or_else(|| sqlx::Error::RowNotFound.into())
    }

    /// Stores the answers and entries of the transaction; returns the proof that it was committed,
    /// once it was.
    pub async fn finish(&mut self) -> Result<Option<Proof>, sqlx::Error> {
        self.keys.write(&mut self.db).await?;
        let new: Vec<NewEntry> = self.chains.drain().flat_map(|(_, chain)| chain.new).collect();
        audit::store(&mut self.db, &new).await?;
        // the first entry of a chain may be its beginning, which others write alike
        Ok(new.last().map(|new| Proof { chain: new.chain, number: new.entry.number, id: new.entry.id }))
    }

    /// Returns whether a transaction was committed that is proved by an entry.
    pub async fn was_committed(&mut self, proof: Option<Proof>) -> Result<bool, sqlx::Error> {
        let Some(Proof { chain, number, id }) = proof else { return Ok(false) };
        let sql = "SELECT 1 FROM audit WHERE chain = $1 AND number = $2 AND id = $3";
        self.db.is_there(sql, args![chain, number, id]).await
    }
}
