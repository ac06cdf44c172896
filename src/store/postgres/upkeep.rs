//! Checks that the database answers and accepts writes, and of its clock.

use jiff::SignedDuration;
use sqlx::{PgConnection, PgPool};

use super::{error::failure, migrate::unfit, session::Session, time::stamp};
use crate::{
    jobs::{Clock, RepositoryError, Unfit},
    store::shared::{Moment, Outcome, PROBE, Probe, Run},
    telemetry,
};

/// Clocks that differ by more are told of, and those that differ by much more are not served with:
/// processes on one database give times to what they store.
const TOLD: SignedDuration = SignedDuration::from_secs(1);
const SERVED: SignedDuration = SignedDuration::from_secs(10);

/// The lock of whoever forgets.
const FORGETTING: i64 = 0x666c_616e_6b66_6974;

/// Refuses a server that may not be written to, a schema that this version does not work on, and a
/// clock that is far from ours.
pub async fn ping(from: &PgPool, clock: &dyn Clock) -> Result<(), RepositoryError> {
    let asked = async {
        let mut db = from.acquire().await?;
        if sqlx::query_scalar("SELECT pg_is_in_recovery()").fetch_one(&mut *db).await? {
            return Ok(Some(Unfit::Standby));
        }
        match unfit(&mut db).await? {
            Some(why) => Ok(Some(why)),
            None => Ok(distant(skew(&mut db, clock).await?)),
        }
    };
    match asked.await {
        Ok(None) => Ok(()),
        Ok(Some(why)) => Err(RepositoryError::Unfit(why)),
        Err(error) => Err(failure(&error)),
    }
}

/// By how much the database's clock is before ours, which is looked at on both sides of asking.
async fn skew(db: &mut PgConnection, clock: &dyn Clock) -> Result<SignedDuration, sqlx::Error> {
    let before = clock.now();
    let Moment(there) = sqlx::query_scalar("SELECT clock_timestamp()").fetch_one(db).await?;
    let after = clock.now();
    Ok(there.duration_since(before + after.duration_since(before) / 2))
}

/// Why nothing is stored by such a clock, where that is so.
fn distant(skew: SignedDuration) -> Option<Unfit> {
    metrics::gauge!(telemetry::CLOCK_SKEW).set(skew.as_secs_f64());
    let told = Unfit::Clock(skew);
    if skew.abs() > TOLD {
        tracing::warn!("{told}");
    }
    (skew.abs() > SERVED).then_some(told)
}

/// Whether no other process forgets what is old until the transaction ends.
pub async fn alone(db: &mut PgConnection) -> Result<bool, sqlx::Error> {
    sqlx::query_scalar("SELECT pg_try_advisory_xact_lock($1)").bind(FORGETTING).fetch_one(db).await
}

impl Run<Session> for Probe {
    async fn run(&self, session: &mut Session) -> Outcome<()> {
        sqlx::query(
            "INSERT INTO probe (id, checked_at, filler) VALUES (1, $1, $2)
             ON CONFLICT (id) DO UPDATE SET checked_at = excluded.checked_at, filler = excluded.filler",
        )
        .bind(stamp(self.now))
        .bind(PROBE.as_slice())
        .execute(&mut session.db)
        .await?;
        Ok(())
    }
}
