//! Keys: digests of secrets, names of certificates.

use jiff::Timestamp;
use sqlx::{SqliteConnection, SqlitePool};

use super::{answers, audit, audit_keys::of_tenant, locate::signed, time};
use crate::{
    jobs::{
        ApiKey, Caller, KeyId, KnownKey, NewKey, Page, RepositoryError, Resource, San, Stored, Tenant, audit::Action,
    },
    store::shared::{
        Asked, FindCertificate, FindKey, GetKey, HasKeys, InsertKey, KeptKeyRow, KeyRow, KnownKeyRow, ListKeys,
        NoteUses, Outcome, PatchKey, Read, RevokeKey, RotateKey, Run, Write, behind, key_columns, of_keys, place,
        target,
    },
};

/// A key of a tenant.
async fn located(db: &mut SqliteConnection, tenant: &Tenant, id: KeyId) -> Outcome<ApiKey> {
    let row: Option<KeyRow> =
        sqlx::query_as(concat!("SELECT ", key_columns!(), " FROM api_keys k WHERE k.id = ? AND k.tenant = ?"))
            .bind(id.to_string())
            .bind(tenant.as_str())
            .fetch_optional(db)
            .await?;
    Ok(row.ok_or(RepositoryError::NotFound(Resource::Key))?.into())
}

impl Read<SqlitePool> for GetKey {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<ApiKey> {
        let mut db = from.acquire().await?;
        located(&mut db, &caller.tenant, self.id).await
    }
}

impl Read<SqlitePool> for ListKeys {
    async fn read(&self, caller: &Caller, from: &SqlitePool) -> Outcome<Page<ApiKey>> {
        let (time, id) = place(self.page.after);
        let rows: Vec<KeyRow> = sqlx::query_as(concat!(
            "SELECT ",
            key_columns!(),
            " FROM api_keys k WHERE k.tenant = ? AND (k.created_at, k.id) < (?, ?)
              ORDER BY k.created_at DESC, k.id DESC LIMIT ?"
        ))
        .bind(caller.tenant.as_str())
        .bind(time::to_text(time))
        .bind(id.to_string())
        .bind(i64::from(self.page.limit) + 1)
        .fetch_all(from)
        .await?;
        Ok(Page::of(rows.into_iter().map(ApiKey::from).collect(), self.page.limit, behind))
    }
}

impl Read<SqlitePool> for FindKey {
    async fn read(&self, _caller: &Caller, from: &SqlitePool) -> Outcome<Option<KnownKey>> {
        let row: Option<KnownKeyRow> = sqlx::query_as(concat!(
            "SELECT ",
            key_columns!(),
            ", k.sha256 AS sha256, coalesce(t.suspended, 0) AS suspended
             FROM api_keys k LEFT JOIN tenants t ON t.name = k.tenant WHERE k.id = ?"
        ))
        .bind(self.id.to_string())
        .fetch_optional(from)
        .await?;
        Ok(row.map(Into::into))
    }
}

impl Read<SqlitePool> for FindCertificate {
    async fn read(&self, _caller: &Caller, from: &SqlitePool) -> Outcome<Option<KnownKey>> {
        let row: Option<KnownKeyRow> = sqlx::query_as(concat!(
            "SELECT ",
            key_columns!(),
            ", k.sha256 AS sha256, coalesce(t.suspended, 0) AS suspended
             FROM api_keys k LEFT JOIN tenants t ON t.name = k.tenant WHERE k.san = ?
             ORDER BY k.revoked_at IS NOT NULL, k.revoked_at DESC LIMIT 1"
        ))
        .bind(self.san.as_str())
        .fetch_optional(from)
        .await?;
        Ok(row.map(Into::into))
    }
}

impl Read<SqlitePool> for HasKeys {
    async fn read(&self, _caller: &Caller, from: &SqlitePool) -> Outcome<bool> {
        Ok(sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM api_keys)").fetch_one(from).await?)
    }
}

/// Refuses the name of a certificate that another key has which is not revoked.
async fn refuse_taken(db: &mut SqliteConnection, san: Option<&San>) -> Outcome<()> {
    let Some(san) = san else { return Ok(()) };
    let taken = sqlx::query("SELECT 1 FROM api_keys WHERE san = ? AND revoked_at IS NULL").bind(san.as_str());
    match taken.fetch_optional(db).await? {
        Some(_) => Err(RepositoryError::SanTaken.into()),
        None => Ok(()),
    }
}

/// Stores a key of a tenant.
pub async fn insert(db: &mut SqliteConnection, tenant: &Tenant, new: &NewKey) -> Outcome<()> {
    let NewKey { key, sha256 } = new;
    sqlx::query(
        "INSERT INTO api_keys (id, tenant, name, role, scopes, sha256, san, version, created_at, expires_at)
         VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?, ?)",
    )
    .bind(key.id.to_string())
    .bind(tenant.as_str())
    .bind(key.name.as_str())
    .bind(key.role.map(|role| role.name()))
    .bind(key.scopes.to_string())
    .bind(sha256.as_ref().map(|digest| digest.as_slice()))
    .bind(key.san.as_ref().map(San::as_str))
    .bind(signed(key.version))
    .bind(time::to_text(key.created_at))
    .bind(key.expires_at.map(time::to_text))
    .execute(db)
    .await?;
    Ok(())
}

/// Changes what can be changed of a key.
async fn update(db: &mut SqliteConnection, key: &ApiKey) -> Outcome<()> {
    sqlx::query(
        "UPDATE api_keys SET name = ?, expires_at = ?, revoked_at = ?, replaced_by = ?, version = ? WHERE id = ?",
    )
    .bind(key.name.as_str())
    .bind(key.expires_at.map(time::to_text))
    .bind(key.revoked_at.map(time::to_text))
    .bind(key.replaced_by.map(|by| by.to_string()))
    .bind(signed(key.version))
    .bind(key.id.to_string())
    .execute(db)
    .await?;
    Ok(())
}

/// A key of a tenant with the digest of its secret.
async fn kept(db: &mut SqliteConnection, tenant: &Tenant, id: KeyId) -> Outcome<NewKey> {
    let row: Option<KeptKeyRow> = sqlx::query_as(concat!(
        "SELECT ",
        key_columns!(),
        ", k.sha256 AS sha256 FROM api_keys k WHERE k.id = ? AND k.tenant = ?"
    ))
    .bind(id.to_string())
    .bind(tenant.as_str())
    .fetch_optional(db)
    .await?;
    Ok(row.ok_or(RepositoryError::NotFound(Resource::Key))?.into())
}

impl Write<SqliteConnection> for InsertKey {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (InsertKey { key: new, receipt }, tenant) = (&asked.write, asked.tenant());
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        refuse_taken(db, new.key.san.as_ref()).await?;
        let mut chain = of_tenant(db, asked.by(), tenant).await?;
        insert(db, tenant, new).await?;
        asked.enter(&mut chain, Action::CreateKey, target::key(new.key.id));
        audit::store(db, chain).await?;
        let stored = Stored { number: 0, version: new.key.version };
        answers::keep(db, tenant, receipt.as_ref(), stored, new.key.created_at, None).await?;
        Ok(stored)
    }
}

impl Write<SqliteConnection> for PatchKey {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<ApiKey> {
        let (PatchKey { id, patch, precondition, now }, tenant) = (&asked.write, asked.tenant());
        let NewKey { key: before, sha256 } = kept(db, tenant, *id).await?;
        precondition.check(before.version)?;
        let after = NewKey { key: before.patched(patch.clone(), *now)?, sha256 };
        if after.key.version != before.version {
            let mut chain = of_tenant(db, asked.by(), tenant).await?;
            update(db, &after.key).await?;
            asked.enter_found(&mut chain, of_keys([&after], None), Action::ChangeKey, target::key(*id));
            audit::store(db, chain).await?;
        }
        Ok(after.key)
    }
}

impl Write<SqliteConnection> for RotateKey {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<Stored> {
        let (RotateKey { rotation, receipt }, tenant) = (&asked.write, asked.tenant());
        answers::refuse_taken(db, tenant, receipt.as_ref()).await?;
        let NewKey { key: old, sha256 } = kept(db, tenant, rotation.of).await?;
        let old = NewKey { key: old.rotated(rotation)?, sha256 };
        let mut chain = of_tenant(db, asked.by(), tenant).await?;
        insert(db, tenant, &rotation.new).await?;
        update(db, &old.key).await?;
        let contents = of_keys([&old, &rotation.new], None);
        asked.enter_found(&mut chain, contents, Action::RotateKey, target::key(rotation.of));
        audit::store(db, chain).await?;
        let new = &rotation.new.key;
        let stored = Stored { number: 0, version: new.version };
        answers::keep(db, tenant, receipt.as_ref(), stored, new.created_at, None).await?;
        Ok(stored)
    }
}

impl Write<SqliteConnection> for RevokeKey {
    async fn write(asked: &Asked<Self>, db: &mut SqliteConnection) -> Outcome<()> {
        let (RevokeKey { id, now }, tenant) = (&asked.write, asked.tenant());
        let NewKey { key, sha256 } = kept(db, tenant, *id).await?;
        if key.revoked_at.is_none() {
            let revoked = NewKey { key: key.revoked(*now), sha256 };
            let mut chain = of_tenant(db, asked.by(), tenant).await?;
            update(db, &revoked.key).await?;
            asked.enter_found(&mut chain, of_keys([&revoked], None), Action::RevokeKey, target::key(*id));
            audit::store(db, chain).await?;
        }
        Ok(())
    }
}

impl Run<SqliteConnection> for NoteUses {
    async fn run(&self, db: &mut SqliteConnection) -> Outcome<()> {
        for (id, at) in &self.uses {
            note(db, *id, *at).await?;
        }
        Ok(())
    }
}

async fn note(db: &mut SqliteConnection, id: KeyId, at: Timestamp) -> Outcome<()> {
    let at = time::to_text(at);
    sqlx::query("UPDATE api_keys SET last_used_at = ?1 WHERE id = ?2 AND coalesce(last_used_at, '') < ?1")
        .bind(at)
        .bind(id.to_string())
        .execute(db)
        .await?;
    Ok(())
}
