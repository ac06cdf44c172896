//! The rows that the chain of a tenant tells of: its keys and its own.

use futures_util::TryStreamExt as _;
use sqlx::{FromRow as _, PgConnection, Row as _};

use crate::{
    jobs::{
        KeyId, NewKey, Tenant,
        audit::{Found, Versioned},
    },
    store::shared::{FoundPurge, KeptKeyRow, Outcome, PlantRow, key_columns, plant_columns},
};

/// The keys of a tenant.
macro_rules! kept {
    () => {
        concat!("SELECT ", key_columns!(), ", k.sha256 AS sha256 FROM api_keys k WHERE k.tenant = $1")
    };
}

/// The keys of a tenant, all but one.
pub async fn keys(db: &mut PgConnection, tenant: &Tenant, but: Option<KeyId>) -> Outcome<Vec<NewKey>> {
    let rows: Vec<KeptKeyRow> = sqlx::query_as(concat!(kept!(), " AND k.id IS DISTINCT FROM $2"))
        .bind(tenant.as_str())
        .bind(but.map(|id| id.to_string()))
        .fetch_all(db)
        .await?;
    Ok(rows.into_iter().map(Into::into).collect())
}

/// The rows of a tenant that are of no job. One that does not read is none that an entry tells of.
pub async fn found(db: &mut PgConnection, tenant: &Tenant) -> Outcome<Found> {
    let mut found = Found::default();
    let mut rows = sqlx::query(kept!()).bind(tenant.as_str()).fetch(&mut *db);
    while let Some(row) = rows.try_next().await? {
        let id: String = row.try_get("id")?;
        let key = KeptKeyRow::from_row(&row).map_or(Versioned::UNREADABLE, |row| Versioned::key(&row.into()));
        found.keys.insert(format!("key.{id}"), key);
    }
    drop(rows);
    let plant = sqlx::query(concat!("SELECT ", plant_columns!(), " FROM tenants WHERE name = $1"));
    let plant = plant.bind(tenant.as_str()).fetch_optional(&mut *db).await?;
    found.tenant =
        plant.map(|row| PlantRow::from_row(&row).map_or(Versioned::UNREADABLE, |row| Versioned::plant(&row.into())));
    let purges: Vec<FoundPurge> = sqlx::query_as(
        "SELECT p.job, p.at, p.reason, p.archive_sha256 FROM jobs j JOIN purges p ON p.job = j.id WHERE j.tenant = $1",
    )
    .bind(tenant.as_str())
    .fetch_all(db)
    .await?;
    found.purges = purges.into_iter().map(FoundPurge::told).collect();
    Ok(found)
}
