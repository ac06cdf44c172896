//! The schema: who makes it, and whether it is one that this version works on.

use std::sync::LazyLock;

use sqlx::{
    AssertSqlSafe, Connection as _, Executor as _, PgConnection,
    migrate::{MigrateError, Migrator},
};

use super::{error::PostgresError, folded, settings::PostgresSettings};
use crate::{jobs::Unfit, store::migrations::embedded};

static MIGRATIONS: LazyLock<Migrator> = LazyLock::new(|| {
    let mut migrations = embedded("postgres/");
    // the next version may have been here already; `schema_floor` tells whether that matters
    migrations.set_ignore_missing(true);
    migrations
});

/// Every migration that this version knows, oldest first.
pub fn postgres_migrations() -> &'static Migrator {
    &MIGRATIONS
}

/// The last of them.
fn newest() -> i64 {
    MIGRATIONS.iter().map(|migration| migration.version).max().unwrap_or(0)
}

/// Brings the schema up to date and gives the service its rights, as owner. Of several that do so
/// at a time one does it and the others wait.
pub async fn migrate(settings: &PostgresSettings) -> Result<(), PostgresError> {
    let address = || settings.address();
    let failed = |source| PostgresError::Migration { address: address(), source: MigrateError::Execute(source) };
    let mut db = PgConnection::connect_with(&settings.migrations())
        .await
        .map_err(|source| PostgresError::Connect { address: address(), source })?;
    MIGRATIONS.run(&mut db).await.map_err(|source| PostgresError::Migration { address: address(), source })?;
    db.execute(sqlx::raw_sql(AssertSqlSafe(include_str!("grants.sql")))).await.map_err(failed)?;
    refuse_newer(&mut db)
        .await
        .map_err(failed)?
        .map_err(|migration| PostgresError::Newer { address: address(), migration })?;
    folded::complete(&mut db).await.map_err(failed)?;
    // everything is done
    let _closed = db.close().await;
    Ok(())
}

/// The migration that a program must know to work on this schema, if this one does not.
async fn refuse_newer(db: &mut PgConnection) -> Result<Result<(), i64>, sqlx::Error> {
    let floor: i64 = sqlx::query_scalar("SELECT migration FROM schema_floor").fetch_one(db).await?;
    Ok(if floor > newest() { Err(floor) } else { Ok(()) })
}

/// Why this version does not work on the schema, where that is so.
pub async fn unfit(db: &mut PgConnection) -> Result<Option<Unfit>, sqlx::Error> {
    let there: bool = sqlx::query_scalar(
        "SELECT to_regclass('_sqlx_migrations') IS NOT NULL AND to_regclass('schema_floor') IS NOT NULL",
    )
    .fetch_one(&mut *db)
    .await?;
    if !there {
        return Ok(Some(Unfit::NoSchema));
    }
    let last: Option<i64> =
        sqlx::query_scalar("SELECT max(version) FROM _sqlx_migrations WHERE success").fetch_one(&mut *db).await?;
    if last.unwrap_or(0) < newest() {
        return Ok(Some(Unfit::OldSchema));
    }
    Ok(refuse_newer(db).await?.err().map(Unfit::NewSchema))
}
