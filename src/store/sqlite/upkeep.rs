//! Checks that the database answers and accepts writes.

use sqlx::{SqliteConnection, SqlitePool};

use super::time;
use crate::store::shared::{Outcome, PROBE, Probe, Run};

pub async fn ping(db: &SqlitePool) -> Result<(), sqlx::Error> {
    let _tables: i64 = sqlx::query_scalar("SELECT count(*) FROM sqlite_schema").fetch_one(db).await?;
    Ok(())
}

impl Run<SqliteConnection> for Probe {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<()> {
        sqlx::query(
            "INSERT INTO probe (id, checked_at, filler) VALUES (1, ?, ?)
             ON CONFLICT (id) DO UPDATE SET checked_at = excluded.checked_at, filler = excluded.filler",
        )
        .bind(time::to_text(self.now))
        .bind(PROBE.as_slice())
        .execute(db)
        .await?;
        Ok(())
    }
}
