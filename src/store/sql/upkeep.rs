//! Checks that the database responds and accepts writes.

use jiff::SignedDuration;

use super::{db::Pool, failure, prelude::*};
use crate::{store::postgres, telemetry};

/// Clocks that differ by more are warned about, and those that differ by much more are not served
/// with: processes on one database give times to what they store.
const WARNED: SignedDuration = SignedDuration::from_secs(1);
const SERVED: SignedDuration = SignedDuration::from_secs(10);

/// The lock of the process that forgets.
const FORGETTING: i64 = 0x666c_616e_6b66_6974;

/// Refuses a server that must not be written to, a schema that this version does not work on, and a
/// clock that differs much from ours.
pub async fn ping(from: &Pool, clock: &dyn Clock) -> Result<(), RepositoryError> {
    match unfit(from, clock).await {
        Ok(None) => Ok(()),
        Ok(Some(why)) => Err(RepositoryError::Unfit(why)),
        Err(error) => Err(failure(&error)),
    }
}

async fn unfit(from: &Pool, clock: &dyn Clock) -> Result<Option<Unfit>, sqlx::Error> {
    let mut db = from.connection().await?;
    if !db.is_postgres() {
        db.is_there("SELECT 1 FROM jobs LIMIT 1", args![]).await?;
        return Ok(None);
    }
    if db.one("SELECT pg_is_in_recovery()", args![]).await? {
        return Ok(Some(Unfit::Standby));
    }
    if let Some(why) = postgres::unfit(&mut db).await? {
        return Ok(Some(why));
    }
    // our clock is read before and after that of the database
    let before = clock.now();
    let there: Timestamp = db.one("SELECT clock_timestamp()", args![]).await?;
    let after = clock.now();
    let skew = there.duration_since(before + after.duration_since(before) / 2);
    metrics::gauge!(telemetry::CLOCK_SKEW).set(skew.as_secs_f64());
    if skew.abs() > WARNED {
        tracing::warn!("{}", Unfit::Clock(skew));
    }
    Ok((skew.abs() > SERVED).then_some(Unfit::Clock(skew)))
}

/// Returns whether no other process forgets old rows until the transaction ends.
pub async fn alone(db: &mut Db) -> Result<bool, sqlx::Error> {
    match db.is_postgres() {
        true => db.one("SELECT pg_try_advisory_xact_lock($1)", args![FORGETTING]).await,
        false => Ok(true),
    }
}

/// Bytes written to test whether the database is writable: more than a small iteration needs, since
/// a few bytes may fit where an iteration does not.
static PROBE: [u8; 64 << 10] = [0; 64 << 10];

/// Writes a test row, to check that the database accepts writes.
pub struct Probe {
    pub now: Timestamp,
}

impl Write for Probe {
    type Reply = ();

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<()> {
        tx.db()
            .run(
                "INSERT INTO probe (id, checked_at, filler) VALUES (1, $1, $2)
                 ON CONFLICT (id) DO UPDATE SET checked_at = excluded.checked_at, filler = excluded.filler",
                args![self.now, PROBE.as_slice()],
            )
            .await?;
        Ok(())
    }
}
