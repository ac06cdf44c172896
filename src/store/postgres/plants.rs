//! Tenants.

use sqlx::{PgConnection, PgPool};
use uuid::Uuid;

use super::{api_keys, locate::signed, session::Session, time::stamp};
use crate::{
    jobs::{Caller, Cursor, Page, Plant, RepositoryError, Resource, Stored, Tenant, audit::Action},
    store::shared::{
        Asked, GetPlant, InsertPlant, ListPlants, Outcome, PatchPlant, PlantRow, Read, StoreError, Write, of_keys,
        plant_columns, target,
    },
};

async fn located(db: &mut PgConnection, name: &Tenant) -> Outcome<Plant> {
    let row: Option<PlantRow> = sqlx::query_as(concat!("SELECT ", plant_columns!(), " FROM tenants WHERE name = $1"))
        .bind(name.as_str())
        .fetch_optional(db)
        .await?;
    Ok(row.ok_or(RepositoryError::NotFound(Resource::Tenant))?.into())
}

impl Read<PgPool> for GetPlant {
    async fn read(&self, _caller: &Caller, from: &PgPool) -> Outcome<Plant> {
        let mut db = from.acquire().await?;
        located(&mut db, &self.name).await
    }
}

impl Read<PgPool> for ListPlants {
    async fn read(&self, _caller: &Caller, from: &PgPool) -> Outcome<Page<Plant>> {
        let after = self.page.after.map_or(Uuid::max(), |Cursor(id)| id);
        let rows: Vec<PlantRow> = sqlx::query_as(concat!(
            "SELECT ",
            plant_columns!(),
            " FROM tenants WHERE id < $1 ORDER BY id DESC LIMIT $2"
        ))
        .bind(after)
        .bind(i64::from(self.page.limit) + 1)
        .fetch_all(from)
        .await?;
        Ok(Page::of(rows.into_iter().map(Plant::from).collect(), self.page.limit, |plant: &Plant| Cursor(plant.id)))
    }
}

impl Write<Session> for InsertPlant {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (InsertPlant { plant: new, receipt }, tenant) = (&asked.write, asked.tenant());
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        let plant = &new.plant;
        session.lock_tenant(&plant.name).await?;
        let inserted = sqlx::query(
            "INSERT INTO tenants (id, name, description, suspended, version, created_at, updated_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7) ON CONFLICT DO NOTHING",
        )
        .bind(plant.id)
        .bind(plant.name.as_str())
        .bind(plant.description.as_deref())
        .bind(plant.suspended)
        .bind(signed(plant.version))
        .bind(stamp(plant.created_at))
        .bind(stamp(plant.updated_at))
        .execute(&mut session.db)
        .await?;
        if inserted.rows_affected() == 0 {
            return Err(RepositoryError::TenantExists.into());
        }
        let chain = session.tenant_chain(asked.by(), &plant.name, None).await.map_err(StoreError::too_late)?;
        asked.enter(chain, Action::CreateTenant, target::tenant(&plant.name));
        api_keys::insert(&mut session.db, &plant.name, &new.key).await.map_err(StoreError::too_late)?;
        let stored = Stored { number: 0, version: plant.version };
        session.keys.keep(tenant, receipt.as_ref(), stored, plant.created_at, None);
        Ok(stored)
    }
}

impl Write<Session> for PatchPlant {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Plant> {
        session.lock_tenant(&asked.write.name).await?;
        let lock = sqlx::query("SELECT FROM tenants WHERE name = $1 FOR NO KEY UPDATE").bind(asked.write.name.as_str());
        lock.execute(&mut session.db).await?;
        let before = located(&mut session.db, &asked.write.name).await?;
        asked.write.precondition.check(before.version)?;
        let after = before.patched(asked.write.patch.clone(), asked.write.now);
        if after.version != before.version {
            let chain = session.tenant_chain(asked.by(), &after.name, None).await?;
            let contents = of_keys([], Some(&after));
            asked.enter_found(chain, contents, Action::ChangeTenant, target::tenant(&after.name));
            sqlx::query(
                "UPDATE tenants SET description = $1, suspended = $2, version = $3, updated_at = $4 WHERE name = $5",
            )
            .bind(after.description.as_deref())
            .bind(after.suspended)
            .bind(signed(after.version))
            .bind(stamp(after.updated_at))
            .bind(after.name.as_str())
            .execute(&mut session.db)
            .await?;
        }
        Ok(after)
    }
}
