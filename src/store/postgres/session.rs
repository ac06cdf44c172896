//! A connection that writes, and what its transaction holds.

use sqlx::{Connection as _, PgConnection};
use uuid::Uuid;

use super::keys::{Keys, OwnedKey, owned};
use crate::store::shared::{Queued, Subject};

pub struct Session {
    pub db: PgConnection,
    /// The idempotency keys that the transaction has claimed.
    pub keys: Keys,
}

/// What the writes of a group need for themselves alone.
#[derive(Default)]
pub struct Wanted {
    jobs: Vec<Uuid>,
    streams: Vec<Uuid>,
    keys: Vec<OwnedKey>,
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
        }
        wanted
    }
}

impl Session {
    pub fn of(db: PgConnection) -> Self {
        Session { db, keys: Keys::default() }
    }

    /// Begins a transaction of this id; `false` if it was committed before. A transaction of this
    /// id that is still running is waited for.
    pub async fn begin(&mut self, change: Uuid) -> Result<bool, sqlx::Error> {
        sqlx::query("BEGIN").execute(&mut self.db).await?;
        let new = sqlx::query("INSERT INTO commits (id) VALUES ($1) ON CONFLICT DO NOTHING")
            .bind(change)
            .execute(&mut self.db)
            .await?;
        Ok(new.rows_affected() == 1)
    }

    /// Locks the jobs and claims the idempotency keys of a group, both in ascending order.
    pub async fn lock(&mut self, Wanted { mut jobs, streams, keys }: Wanted) -> Result<(), sqlx::Error> {
        if !streams.is_empty() {
            // the job of a stream stays
            let of: Vec<Uuid> = sqlx::query_scalar("SELECT job FROM streams WHERE id = ANY($1)")
                .bind(streams)
                .fetch_all(&mut self.db)
                .await?;
            jobs.extend(of);
        }
        if !jobs.is_empty() {
            jobs.sort_unstable();
            jobs.dedup();
            sqlx::query("SELECT FROM jobs WHERE id = ANY($1) ORDER BY id FOR NO KEY UPDATE")
                .bind(jobs)
                .execute(&mut self.db)
                .await?;
        }
        self.keys.claim(&mut self.db, keys).await
    }

    /// Writes the answers down that are to be kept.
    pub async fn write_answers(&mut self) -> Result<(), sqlx::Error> {
        self.keys.write(&mut self.db).await
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
