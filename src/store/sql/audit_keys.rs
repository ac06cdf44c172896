//! The rows that the chain of a tenant is about: its keys and its own.

use super::{
    audit::Readable,
    db::Db,
    error::Outcome,
    row::{FoundPurge, key_columns, plant_columns},
};
use crate::jobs::{
    KeyId, NewKey, Plant, Tenant,
    audit::{Found, Versioned},
};

/// The keys of a tenant.
macro_rules! kept {
    () => {
        concat!("SELECT ", key_columns!(), ", k.sha256 AS sha256 FROM api_keys k WHERE k.tenant = $1")
    };
}

/// Returns the keys of a tenant, all but one.
pub async fn keys(db: &mut Db, tenant: &Tenant, but: Option<KeyId>) -> Outcome<Vec<NewKey>> {
    let sql = concat!(kept!(), " AND k.id IS DISTINCT FROM $2");
    Ok(db.all(sql, args![tenant, but]).await?)
}

row! {
    struct FoundKey {
        @row: Readable<NewKey>,
        id: String,
    }
}

/// Returns the rows of a tenant that are of no job. A row that does not read is none that an entry
/// is about.
pub async fn found(db: &mut Db, tenant: &Tenant) -> Outcome<Found> {
    let mut found = Found::default();
    for FoundKey { row, id } in db.all::<FoundKey>(kept!(), args![tenant]).await? {
        let key = row.0.map_or(Versioned::UNREADABLE, |key| Versioned::key(&key));
        found.keys.insert(format!("key.{id}"), key);
    }
    let sql = concat!("SELECT ", plant_columns!(), " FROM tenants WHERE name = $1");
    let plant: Option<Readable<Plant>> = db.maybe(sql, args![tenant]).await?;
    found.tenant = plant.map(|row| row.0.map_or(Versioned::UNREADABLE, |plant| Versioned::plant(&plant)));
    let sql = "SELECT p.job, p.at, p.reason, p.archive_sha256 FROM jobs j JOIN purges p ON p.job = j.id
               WHERE j.tenant = $1";
    let purges: Vec<FoundPurge> = db.all(sql, args![tenant]).await?;
    found.purges = purges.into_iter().map(FoundPurge::told).collect();
    Ok(found)
}
