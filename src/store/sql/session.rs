//! A connection that writes, and what its transaction holds.

use super::{
    audit,
    keys::Keys,
    prelude::*,
    write::{Request, Subject},
};

/// See the module's documentation.
pub struct Session {
    pub db: Db,
    /// The idempotency keys that the transaction has claimed.
    pub keys: Keys,
    /// The entries of its changes.
    pub entries: Vec<Draft>,
}

/// An entry that proves that its transaction was committed.
#[derive(Clone, Copy, Debug)]
pub struct Proof(Uuid);

impl Session {
    pub fn of(db: Db) -> Self {
        Session { db, keys: Keys::default(), entries: Vec::new() }
    }

    /// Locks the jobs and claims the idempotency keys of a group, each in ascending order.
    pub async fn lock(&mut self, request: Vec<&Request>) -> Result<(), sqlx::Error> {
        let (mut jobs, mut streams) = (Vec::new(), Vec::new());
        for request in &request {
            match request.subject {
                Subject::Job(id) => jobs.push(id),
                Subject::Stream(id) => streams.push(id),
                Subject::Nothing => {}
            }
        }
        // the job of a stream stays the same
        let of_streams: Vec<(Uuid,)> = self.db.of_ids("SELECT job FROM streams WHERE id IN ({ids})", streams).await?;
        jobs.extend(of_streams.into_iter().map(|(job,)| job));
        self.entries.clear();
        if self.db.is_postgres() {
            let lock = "SELECT id FROM jobs WHERE id IN ({ids}) ORDER BY id FOR NO KEY UPDATE";
            self.db.of_ids::<(Uuid,)>(lock, jobs.iter().copied()).await?;
        }
        self.keys.claim(&mut self.db, request.iter().filter_map(|request| request.key.as_ref()).collect()).await
    }

    /// Waits until no other transaction changes the tenant or its keys, and lets none do so until
    /// this one has ended. It comes first, so that no transaction waits for what another one holds.
    pub async fn lock_tenant(&mut self, tenant: &Tenant) -> Outcome<()> {
        if self.db.is_postgres() {
            let lock = "SELECT pg_advisory_xact_lock(hashtext('flankfit tenant ' || $1))";
            self.db.run(lock, args![tenant]).await?;
        }
        Ok(())
    }

    /// Stores the responses and entries of the transaction; returns the proof that it was
    /// committed, once it was.
    pub async fn finish(&mut self) -> Result<Option<Proof>, sqlx::Error> {
        let keys = std::mem::take(&mut self.keys);
        let mut all = keys.writing(&self.db);
        let entries: Vec<_> = self.entries.drain(..).map(Draft::end).collect();
        all.extend(audit::storing(&self.db, &entries));
        self.db.run_together(all).await?;
        Ok(entries.last().map(|entry| Proof(entry.id)))
    }

    /// Returns whether a transaction was committed that is proved by an entry.
    pub async fn was_committed(&mut self, proof: Option<Proof>) -> Result<bool, sqlx::Error> {
        let Some(Proof(id)) = proof else { return Ok(false) };
        self.db.is_there("SELECT 1 FROM audit WHERE id = $1", args![id]).await
    }
}
