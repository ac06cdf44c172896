//! Mappings of tables, kept to be proposed again.

use sqlx::{SqliteConnection, SqlitePool};

use super::time;
use crate::{
    jobs::{Caller, KeptMapping, MOST_MAPPINGS},
    store::shared::{Asked, GetMapping, KeepMapping, Outcome, Read, Write},
};

impl Read<SqlitePool> for GetMapping {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Option<String>> {
        let mapping = sqlx::query_scalar("SELECT mapping FROM table_mappings WHERE tenant = ? AND key = ?")
            .bind(caller.tenant.as_str())
            .bind(self.key.as_slice())
            .fetch_optional(from)
            .await?;
        Ok(mapping)
    }
}

impl Write<SqliteConnection> for KeepMapping {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<()> {
        let (KeepMapping { kept: KeptMapping { key, mapping }, now }, tenant) = (&asked.write, asked.tenant().as_str());
        sqlx::query(
            "INSERT INTO table_mappings (tenant, key, mapping, kept_at) VALUES (?, ?, ?, ?)
             ON CONFLICT (tenant, key) DO UPDATE SET mapping = excluded.mapping, kept_at = excluded.kept_at",
        )
        .bind(tenant)
        .bind(key.as_slice())
        .bind(mapping.as_str())
        .bind(time::to_text(*now))
        .execute(&mut *db)
        .await?;
        sqlx::query(
            "DELETE FROM table_mappings WHERE tenant = ?1 AND key IN
             (SELECT key FROM table_mappings WHERE tenant = ?1 ORDER BY kept_at DESC, key LIMIT -1 OFFSET ?2)",
        )
        .bind(tenant)
        .bind(i64::from(MOST_MAPPINGS))
        .execute(db)
        .await?;
        Ok(())
    }
}
