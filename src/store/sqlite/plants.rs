//! Tenants.

use sqlx::{SqliteConnection, SqlitePool};

use super::{answers, api_keys, audit, audit_keys::of_tenant, locate::signed, time};
use crate::{
    jobs::{Caller, Cursor, Page, Plant, RepositoryError, Resource, Stored, Tenant, audit::Action},
    store::shared::{
        Asked, GetPlant, InsertPlant, ListPlants, Outcome, PatchPlant, PlantRow, Read, Write, of_keys, plant_columns,
        target,
    },
};

async fn find(db: &mut SqliteConnection, name: &Tenant) -> Outcome<Option<Plant>> {
    let row: Option<PlantRow> = sqlx::query_as(concat!("SELECT ", plant_columns!(), " FROM tenants WHERE name = ?"))
        .bind(name.as_str())
        .fetch_optional(db)
        .await?;
    Ok(row.map(Into::into))
}

async fn located(db: &mut SqliteConnection, name: &Tenant) -> Outcome<Plant> {
    Ok(find(db, name).await?.ok_or(RepositoryError::NotFound(Resource::Tenant))?)
}

impl Read<SqlitePool> for GetPlant {
    async fn read(&self, _caller: &Caller, from: &SqlitePool) -> Outcome<Plant> {
        let mut db = from.acquire().await?;
        located(&mut db, &self.name).await
    }
}

impl Read<SqlitePool> for ListPlants {
    async fn read(&self, _caller: &Caller, from: &SqlitePool) -> Outcome<Page<Plant>> {
        let after = self.page.after.map_or([0xff; 16].to_vec(), |Cursor(id)| id.as_bytes().to_vec());
        let rows: Vec<PlantRow> =
            sqlx::query_as(concat!("SELECT ", plant_columns!(), " FROM tenants WHERE id < ? ORDER BY id DESC LIMIT ?"))
                .bind(after)
                .bind(i64::from(self.page.limit) + 1)
                .fetch_all(from)
                .await?;
        Ok(Page::of(rows.into_iter().map(Plant::from).collect(), self.page.limit, |plant: &Plant| Cursor(plant.id)))
    }
}

impl Write<SqliteConnection> for InsertPlant {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (InsertPlant { plant: new, receipt }, tenant) = (&asked.write, asked.tenant());
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        let plant = &new.plant;
        if find(db, &plant.name).await?.is_some() {
            return Err(RepositoryError::TenantExists.into());
        }
        let mut chain = of_tenant(db, asked.by(), &plant.name).await?;
        sqlx::query(
            "INSERT INTO tenants (id, name, description, suspended, version, created_at, updated_at)
             VALUES (?, ?, ?, ?, ?, ?, ?)",
        )
        .bind(plant.id)
        .bind(plant.name.as_str())
        .bind(plant.description.as_deref())
        .bind(plant.suspended)
        .bind(signed(plant.version))
        .bind(time::to_text(plant.created_at))
        .bind(time::to_text(plant.updated_at))
        .execute(&mut *db)
        .await?;
        api_keys::insert(db, &plant.name, &new.key).await?;
        asked.enter(&mut chain, Action::CreateTenant, target::tenant(&plant.name));
        audit::store(db, chain).await?;
        let stored = Stored { number: 0, version: plant.version };
        answers::keep(db, tenant, receipt.as_ref(), stored, plant.created_at, None).await?;
        Ok(stored)
    }
}

impl Write<SqliteConnection> for PatchPlant {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Plant> {
        let before = located(db, &asked.write.name).await?;
        asked.write.precondition.check(before.version)?;
        let after = before.patched(asked.write.patch.clone(), asked.write.now);
        if after.version != before.version {
            let mut chain = of_tenant(db, asked.by(), &after.name).await?;
            sqlx::query(
                "UPDATE tenants SET description = ?, suspended = ?, version = ?, updated_at = ? WHERE name = ?",
            )
            .bind(after.description.as_deref())
            .bind(after.suspended)
            .bind(signed(after.version))
            .bind(time::to_text(after.updated_at))
            .bind(after.name.as_str())
            .execute(&mut *db)
            .await?;
            let contents = of_keys([], Some(&after));
            asked.enter_found(&mut chain, contents, Action::ChangeTenant, target::tenant(&after.name));
            audit::store(db, chain).await?;
        }
        Ok(after)
    }
}
