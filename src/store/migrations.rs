//! The migrations of both stores, embedded in the program.

use rust_embed::RustEmbed;
use sqlx::{
    AssertSqlSafe, SqlSafeStr as _,
    migrate::{Migration, MigrationType, Migrator},
};

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
