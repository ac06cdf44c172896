//! Mappings of tables, kept to be proposed again.

use sqlx::PgPool;

use super::{session::Session, time::stamp};
use crate::{
    jobs::{Caller, KeptMapping, MOST_MAPPINGS},
    store::shared::{Asked, GetMapping, KeepMapping, Outcome, Read, Write},
};

impl Read<PgPool> for GetMapping {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Option<String>> {
        let mapping = sqlx::query_scalar("SELECT mapping FROM table_mappings WHERE tenant = $1 AND key = $2")
            .bind(caller.tenant.as_str())
            .bind(self.key.as_slice())
            .fetch_optional(from)
            .await?;
        Ok(mapping)
    }
}

impl Write<Session> for KeepMapping {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<()> {
        let (KeepMapping { kept: KeptMapping { key, mapping }, now }, tenant) = (&asked.write, asked.tenant().as_str());
        let db = &mut session.db;
        sqlx::query(
            "INSERT INTO table_mappings (tenant, key, mapping, kept_at) VALUES ($1, $2, $3, $4)
             ON CONFLICT (tenant, key) DO UPDATE SET mapping = excluded.mapping, kept_at = excluded.kept_at",
        )
        .bind(tenant)
        .bind(key.as_slice())
        .bind(mapping.as_str())
        .bind(stamp(*now))
        .execute(&mut *db)
        .await?;
        sqlx::query(
            "DELETE FROM table_mappings WHERE tenant = $1 AND key IN
             (SELECT key FROM table_mappings WHERE tenant = $1 ORDER BY kept_at DESC, key OFFSET $2)",
        )
        .bind(tenant)
        .bind(i64::from(MOST_MAPPINGS))
        .execute(db)
        .await?;
        Ok(())
    }
}
