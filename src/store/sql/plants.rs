//! Tenants.

use super::{api_keys, prelude::*, subject};

/// The columns of a [`Plant`].
macro_rules! plant_columns {
    () => {
        "id, name, description, suspended, version, created_at, updated_at"
    };
}

from_row! {
    Plant { id, name, description, suspended, version, created_at, updated_at }
}

pub async fn plant(db: &mut Db, _caller: &Caller, name: &Tenant) -> Outcome<Plant> {
    let sql = concat!("SELECT ", plant_columns!(), " FROM tenants WHERE name = $1");
    Ok(db.maybe(sql, args![name]).await?.ok_or(RepositoryError::NotFound(Resource::Tenant))?)
}

pub async fn plants(db: &mut Db, _caller: &Caller, page: &PageRequest) -> Outcome<Page<Plant>> {
    let after = page.after.map_or(Uuid::max(), |Cursor(id)| id);
    let sql = concat!("SELECT ", plant_columns!(), " FROM tenants WHERE id < $1 ORDER BY id DESC LIMIT $2");
    let rows: Vec<Plant> = db.all(sql, args![after, i64::from(page.limit) + 1]).await?;
    Ok(Page::of(rows, page.limit, |plant| Cursor(plant.id)))
}

pub async fn insert_plant(tx: &mut Tx<'_>, write: &InsertPlant) -> Outcome<Stored> {
    let plant = &write.plant.plant;
    tx.refuse_taken()?;
    tx.session.lock_tenant(&plant.name).await?;
    let mut entry = tx.draft_of(&plant.name, Action::CreateTenant, subject::tenant(&plant.name))?;
    let inserted = tx
        .db()
        .run(
            "INSERT INTO tenants (id, name, description, suspended, version, created_at, updated_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT DO NOTHING",
            args![
                plant.id,
                &plant.name,
                plant.description.as_deref(),
                plant.suspended,
                plant.version,
                plant.created_at,
                plant.updated_at,
            ],
        )
        .await?;
    if inserted == 0 {
        return Err(RepositoryError::TenantExists.into());
    }
    let db = tx.db();
    api_keys::insert(db, &plant.name, &write.plant.key).await.map_err(StoreError::too_late)?;
    entry.note_stored(db, "tenants", "name = $1", args![&plant.name]).await?;
    entry.note_stored(db, "api_keys", "id = $1", args![write.plant.key.key.id]).await?;
    tx.enter(entry);
    Ok(tx.keep(&write.receipt, Stored { number: 0, version: plant.version }, None, plant.created_at))
}

pub async fn patch_plant(tx: &mut Tx<'_>, write: &PatchPlant) -> Outcome<Plant> {
    tx.session.lock_tenant(&write.name).await?;
    let request = tx.request;
    let before = plant(tx.db(), &request.caller, &write.name).await?;
    write.precondition.check(before.version)?;
    let after = before.patched(write.patch.clone(), write.now);
    if after.version != before.version {
        let mut entry = tx.draft_of(&after.name, Action::ChangeTenant, subject::tenant(&after.name))?;
        let db = tx.db();
        db.run(
            "UPDATE tenants SET description = $1, suspended = $2, version = $3, updated_at = $4
                 WHERE name = $5",
            args![after.description.as_deref(), after.suspended, after.version, after.updated_at, &after.name],
        )
        .await?;
        entry.note_stored(db, "tenants", "name = $1", args![&after.name]).await?;
        tx.enter(entry);
    }
    Ok(after)
}
