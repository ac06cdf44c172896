//! Keys: digests of secrets, names of certificates.

use jiff::Timestamp;
use sqlx::{PgConnection, PgPool};

use super::{locate::signed, session::Session, time::stamp};
use crate::{
    jobs::{
        ApiKey, Caller, KeyId, KnownKey, NewKey, Page, RepositoryError, Resource, San, Stored, Tenant, audit::Action,
    },
    store::shared::{
        Asked, FindCertificate, FindKey, GetKey, HasKeys, InsertKey, KeptKeyRow, KeyRow, KnownKeyRow, ListKeys,
        NoteUses, Outcome, PatchKey, Read, RevokeKey, RotateKey, Run, StoreError, Write, behind, key_columns, of_keys,
        place, target,
    },
};

/// A key of a tenant that is about to be changed, with the digest of its secret: nobody else
/// changes it until the transaction ends.
async fn locked(session: &mut Session, tenant: &Tenant, id: KeyId) -> Outcome<NewKey> {
    session.lock_tenant(tenant).await?;
    let db = &mut session.db;
    sqlx::query("SELECT FROM api_keys WHERE id = $1 FOR NO KEY UPDATE").bind(id.to_string()).execute(&mut *db).await?;
    let row: Option<KeptKeyRow> = sqlx::query_as(concat!(
        "SELECT ",
        key_columns!(),
        ", k.sha256 AS sha256 FROM api_keys k WHERE k.id = $1 AND k.tenant = $2"
    ))
    .bind(id.to_string())
    .bind(tenant.as_str())
    .fetch_optional(db)
    .await?;
    Ok(row.ok_or(RepositoryError::NotFound(Resource::Key))?.into())
}

/// A key of a tenant.
async fn located(db: &mut PgConnection, tenant: &Tenant, id: KeyId) -> Outcome<ApiKey> {
    let row: Option<KeyRow> =
        sqlx::query_as(concat!("SELECT ", key_columns!(), " FROM api_keys k WHERE k.id = $1 AND k.tenant = $2"))
            .bind(id.to_string())
            .bind(tenant.as_str())
            .fetch_optional(db)
            .await?;
    Ok(row.ok_or(RepositoryError::NotFound(Resource::Key))?.into())
}

impl Read<PgPool> for GetKey {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<ApiKey> {
        let mut db = from.acquire().await?;
        located(&mut db, &caller.tenant, self.id).await
    }
}

impl Read<PgPool> for ListKeys {
    async fn read(&self, caller: &Caller, from: &PgPool) -> Outcome<Page<ApiKey>> {
        let (time, id) = place(self.page.after);
        let rows: Vec<KeyRow> = sqlx::query_as(concat!(
            "SELECT ",
            key_columns!(),
            " FROM api_keys k WHERE k.tenant = $1 AND (k.created_at, k.id) < ($2, $3)
              ORDER BY k.created_at DESC, k.id DESC LIMIT $4"
        ))
        .bind(caller.tenant.as_str())
        .bind(stamp(time))
        .bind(id.to_string())
        .bind(i64::from(self.page.limit) + 1)
        .fetch_all(from)
        .await?;
        Ok(Page::of(rows.into_iter().map(ApiKey::from).collect(), self.page.limit, behind))
    }
}

impl Read<PgPool> for FindKey {
    async fn read(&self, _caller: &Caller, from: &PgPool) -> Outcome<Option<KnownKey>> {
        let row: Option<KnownKeyRow> = sqlx::query_as(concat!(
            "SELECT ",
            key_columns!(),
            ", k.sha256 AS sha256, coalesce(t.suspended, false) AS suspended
             FROM api_keys k LEFT JOIN tenants t ON t.name = k.tenant WHERE k.id = $1"
        ))
        .bind(self.id.to_string())
        .fetch_optional(from)
        .await?;
        Ok(row.map(Into::into))
    }
}

impl Read<PgPool> for FindCertificate {
    async fn read(&self, _caller: &Caller, from: &PgPool) -> Outcome<Option<KnownKey>> {
        let row: Option<KnownKeyRow> = sqlx::query_as(concat!(
            "SELECT ",
            key_columns!(),
            ", k.sha256 AS sha256, coalesce(t.suspended, false) AS suspended
             FROM api_keys k LEFT JOIN tenants t ON t.name = k.tenant WHERE k.san = $1
             ORDER BY k.revoked_at IS NOT NULL, k.revoked_at DESC LIMIT 1"
        ))
        .bind(self.san.as_str())
        .fetch_optional(from)
        .await?;
        Ok(row.map(Into::into))
    }
}

impl Read<PgPool> for HasKeys {
    async fn read(&self, _caller: &Caller, from: &PgPool) -> Outcome<bool> {
        Ok(sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM api_keys)").fetch_one(from).await?)
    }
}

/// Stores a key of a tenant, unless a key that is not revoked has its name of a certificate.
pub async fn insert(db: &mut PgConnection, tenant: &Tenant, new: &NewKey) -> Outcome<()> {
    let NewKey { key, sha256 } = new;
    let inserted = sqlx::query(
        "INSERT INTO api_keys (id, tenant, name, role, scopes, sha256, san, version, created_at, expires_at)
         VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10) ON CONFLICT DO NOTHING",
    )
    .bind(key.id.to_string())
    .bind(tenant.as_str())
    .bind(key.name.as_str())
    .bind(key.role.map(|role| role.name()))
    .bind(key.scopes.to_string())
    .bind(sha256.as_ref().map(|digest| digest.as_slice()))
    .bind(key.san.as_ref().map(San::as_str))
    .bind(signed(key.version))
    .bind(stamp(key.created_at))
    .bind(key.expires_at.map(stamp))
    .execute(db)
    .await?;
    match (inserted.rows_affected(), &key.san) {
        (1, _) => Ok(()),
        (_, Some(_)) => Err(RepositoryError::SanTaken.into()),
        (_, None) => Err(RepositoryError::Failed("the id of a new key is taken".into()).into()),
    }
}

/// Changes what can be changed of a key.
async fn update(db: &mut PgConnection, key: &ApiKey) -> Outcome<()> {
    sqlx::query(
        "UPDATE api_keys SET name = $1, expires_at = $2, revoked_at = $3, replaced_by = $4, version = $5 WHERE id = $6",
    )
    .bind(key.name.as_str())
    .bind(key.expires_at.map(stamp))
    .bind(key.revoked_at.map(stamp))
    .bind(key.replaced_by.map(|by| by.to_string()))
    .bind(signed(key.version))
    .bind(key.id.to_string())
    .execute(db)
    .await?;
    Ok(())
}

impl Write<Session> for InsertKey {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (InsertKey { key: new, receipt }, tenant) = (&asked.write, asked.tenant());
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        session.lock_tenant(tenant).await?;
        insert(&mut session.db, tenant, new).await?;
        let chain = session.tenant_chain(asked.by(), tenant, Some(new.key.id)).await.map_err(StoreError::too_late)?;
        asked.enter(chain, Action::CreateKey, target::key(new.key.id));
        let stored = Stored { number: 0, version: new.key.version };
        session.keys.keep(tenant, receipt.as_ref(), stored, new.key.created_at, None);
        Ok(stored)
    }
}

impl Write<Session> for PatchKey {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<ApiKey> {
        let (PatchKey { id, patch, precondition, now }, tenant) = (&asked.write, asked.tenant());
        let NewKey { key: before, sha256 } = locked(session, tenant, *id).await?;
        precondition.check(before.version)?;
        let after = NewKey { key: before.patched(patch.clone(), *now)?, sha256 };
        if after.key.version != before.version {
            let chain = session.tenant_chain(asked.by(), tenant, None).await?;
            asked.enter_found(chain, of_keys([&after], None), Action::ChangeKey, target::key(*id));
            update(&mut session.db, &after.key).await?;
        }
        Ok(after.key)
    }
}

impl Write<Session> for RotateKey {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<Stored> {
        let (RotateKey { rotation, receipt }, tenant) = (&asked.write, asked.tenant());
        session.keys.refuse_taken(tenant, receipt.as_ref())?;
        let NewKey { key: old, sha256 } = locked(session, tenant, rotation.of).await?;
        let old = NewKey { key: old.rotated(rotation)?, sha256 };
        let chain = session.tenant_chain(asked.by(), tenant, None).await?;
        let contents = of_keys([&old, &rotation.new], None);
        asked.enter_found(chain, contents, Action::RotateKey, target::key(rotation.of));
        insert(&mut session.db, tenant, &rotation.new).await.map_err(StoreError::too_late)?;
        update(&mut session.db, &old.key).await?;
        let new = &rotation.new.key;
        let stored = Stored { number: 0, version: new.version };
        session.keys.keep(tenant, receipt.as_ref(), stored, new.created_at, None);
        Ok(stored)
    }
}

impl Write<Session> for RevokeKey {
    async fn write(asked: &Asked<Self>, session: &mut Session) -> Outcome<()> {
        let (RevokeKey { id, now }, tenant) = (&asked.write, asked.tenant());
        let NewKey { key, sha256 } = locked(session, tenant, *id).await?;
        if key.revoked_at.is_none() {
            let revoked = NewKey { key: key.revoked(*now), sha256 };
            let chain = session.tenant_chain(asked.by(), tenant, None).await?;
            asked.enter_found(chain, of_keys([&revoked], None), Action::RevokeKey, target::key(*id));
            update(&mut session.db, &revoked.key).await?;
        }
        Ok(())
    }
}

impl Run<Session> for NoteUses {
    async fn run(&self, Session { db, .. }: &mut Session) -> Outcome<()> {
        for (id, at) in &self.uses {
            note(db, *id, *at).await?;
        }
        Ok(())
    }
}

async fn note(db: &mut PgConnection, id: KeyId, at: Timestamp) -> Outcome<()> {
    let at = stamp(at);
    sqlx::query("UPDATE api_keys SET last_used_at = $1 WHERE id = $2 AND (last_used_at IS NULL OR last_used_at < $1)")
        .bind(at)
        .bind(id.to_string())
        .execute(db)
        .await?;
    Ok(())
}
