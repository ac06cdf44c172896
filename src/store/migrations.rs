//! The migrations of both stores, embedded in the program.

use rust_embed::RustEmbed;
use sqlx::{
    AssertSqlSafe, SqlSafeStr as _,
    migrate::{Migration, MigrationType, Migrator},
};

use super::sql::Db;

#[derive(RustEmbed)]
#[folder = "migrations"]
struct Files;

/// Returns the migrations in a folder below `migrations`, oldest first, from files named
/// `0001_what_it_adds.sql`.
pub fn embedded(folder: &str) -> Migrator {
    let migration = |path: std::borrow::Cow<'static, str>| {
        let name = path.strip_prefix(folder)?.strip_suffix(".sql").filter(|name| !name.contains('/'))?;
        let (version, description) = name.split_once('_')?;
        let text = String::from_utf8(Files::get(&path)?.data.into_owned()).ok()?;
        Some(Migration::new(
            version.parse().ok()?,
            description.replace('_', " ").into(),
            MigrationType::Simple,
            AssertSqlSafe(text).into_sql_str(),
            false,
        ))
    };
    Migrator::with_migrations(Files::iter().filter_map(migration).collect())
}

/// Returns whether the schema is that of a development version before the migrations began again.
pub async fn is_earlier(db: &mut Db, migrations: &Migrator) -> Result<bool, sqlx::Error> {
    let table = db.pick(
        "SELECT 1 FROM sqlite_schema WHERE name = '_sqlx_migrations'",
        "SELECT 1 WHERE to_regclass('_sqlx_migrations') IS NOT NULL",
    );
    if !db.is_there(table, &[]).await? {
        return Ok(false);
    }
    let first: Option<Vec<u8>> = db.first("SELECT checksum FROM _sqlx_migrations WHERE version = 1", &[]).await?;
    let own = migrations.iter().next().map(|migration| &migration.checksum[..]);
    Ok(first.is_some_and(|first| Some(first.as_slice()) != own))
}
