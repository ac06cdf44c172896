//! The chain of a tenant, and the rows that it tells of: its keys and its own.

use futures_util::TryStreamExt as _;
use sqlx::{FromRow as _, Row as _, SqliteConnection};

use super::audit;
use crate::{
    jobs::{
        NewKey, Tenant,
        audit::{By, Chain, Found, Versioned},
    },
    store::shared::{FoundPurge, Growing, KeptKeyRow, Outcome, PlantRow, key_columns, of_keys, plant_columns},
};

/// The keys of a tenant.
macro_rules! kept {
    () => {
        concat!("SELECT ", key_columns!(), ", k.sha256 AS sha256 FROM api_keys k WHERE k.tenant = ?")
    };
}

/// The chain of a tenant, to add to it: of changes that are of no job. It is asked for before
/// anything is changed: one that has none yet begins with the keys that are found now.
pub async fn of_tenant(db: &mut SqliteConnection, by: By<'_>, tenant: &Tenant) -> Outcome<Growing> {
    if let Some(head) = audit::head(db, Chain::Tenant.id(tenant)).await? {
        return Ok(Growing::from(tenant, Chain::Tenant, Some(head.into())));
    }
    let rows: Vec<KeptKeyRow> = sqlx::query_as(kept!()).bind(tenant.as_str()).fetch_all(db).await?;
    let keys: Vec<NewKey> = rows.into_iter().map(Into::into).collect();
    Ok(Growing::begin_tenant(by, tenant, of_keys(&keys, None)))
}

/// The rows of a tenant that are of no job. One that does not read is none that an entry tells of.
pub async fn found(db: &mut SqliteConnection, tenant: &Tenant) -> Outcome<Found> {
    let mut found = Found::default();
    let mut rows = sqlx::query(kept!()).bind(tenant.as_str()).fetch(&mut *db);
    while let Some(row) = rows.try_next().await? {
        let id: String = row.try_get("id")?;
        let key = KeptKeyRow::from_row(&row).map_or(Versioned::UNREADABLE, |row| Versioned::key(&row.into()));
        found.keys.insert(format!("key.{id}"), key);
    }
    drop(rows);
    let plant = sqlx::query(concat!("SELECT ", plant_columns!(), " FROM tenants WHERE name = ?"));
    let plant = plant.bind(tenant.as_str()).fetch_optional(&mut *db).await?;
    found.tenant =
        plant.map(|row| PlantRow::from_row(&row).map_or(Versioned::UNREADABLE, |row| Versioned::plant(&row.into())));
    let purges: Vec<FoundPurge> = sqlx::query_as(
        "SELECT j.id AS job, p.at AS at, p.reason AS reason, p.archive_sha256 AS archive_sha256
         FROM jobs j JOIN purges p ON p.job = j.seq WHERE j.tenant = ?",
    )
    .bind(tenant.as_str())
    .fetch_all(db)
    .await?;
    found.purges = purges.into_iter().map(FoundPurge::told).collect();
    Ok(found)
}
