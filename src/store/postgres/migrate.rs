//! The schema: who makes it, and whether it is one that this version works on.

use std::sync::LazyLock;

use sqlx::{
    AssertSqlSafe, Connection as _, PgConnection,
    migrate::{MigrateError, Migrator},
};

use super::{error::PostgresError, settings::PostgresSettings};
use crate::{
    jobs::Unfit,
    store::{
        migrations::{embedded, is_earlier},
        sql::Db,
    },
};

static MIGRATIONS: LazyLock<Migrator> = LazyLock::new(|| {
    let mut migrations = embedded("postgres/");
    // the next version may have been here already; `schema_floor` says if that matters
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
    let mut connection = PgConnection::connect_with(&settings.migrations())
        .await
        .map_err(|source| PostgresError::Connect { address: address(), source })?;
    MIGRATIONS.run(&mut connection).await.map_err(|source| match source {
        MigrateError::VersionMismatch(1) => PostgresError::Earlier { address: address() },
        source => PostgresError::Migration { address: address(), source },
    })?;
    let mut db = Db::from(connection);
    db.script(AssertSqlSafe(include_str!("grants.sql"))).await.map_err(failed)?;
    let floor = floor(&mut db).await.map_err(failed)?;
    // everything is done
    let _closed = db.close().await;
    match floor {
        migration if migration > newest() => Err(PostgresError::Newer { address: address(), migration }),
        _ => Ok(()),
    }
}

/// Refuses the schema of a development version before the migrations began again.
pub async fn refuse_earlier(settings: &PostgresSettings, db: &mut Db) -> Result<(), PostgresError> {
    let address = settings.address();
    match is_earlier(db, &MIGRATIONS).await {
        Ok(false) => Ok(()),
        Ok(true) => Err(PostgresError::Earlier { address }),
        Err(source) => Err(PostgresError::Connect { address, source }),
    }
}

/// Returns the last migration that a program must know to work on this schema.
async fn floor(db: &mut Db) -> Result<i64, sqlx::Error> {
    db.one("SELECT migration FROM schema_floor", &[]).await
}

/// Returns why this version does not work on the schema, where that is so.
pub async fn unfit(db: &mut Db) -> Result<Option<Unfit>, sqlx::Error> {
    let there = "SELECT to_regclass('_sqlx_migrations') IS NOT NULL AND to_regclass('schema_floor') IS NOT NULL";
    if !db.one(there, &[]).await? {
        return Ok(Some(Unfit::NoSchema));
    }
    let last: Option<i64> = db.one("SELECT max(version) FROM _sqlx_migrations WHERE success", &[]).await?;
    if last.unwrap_or(0) < newest() {
        return Ok(Some(Unfit::OldSchema));
    }
    Ok(Some(floor(db).await?).filter(|floor| *floor > newest()).map(Unfit::NewSchema))
}
