//! Keys: digests of secrets, names of certificates.

use std::sync::Arc;

use jiff::Timestamp;

use super::{
    db::Db,
    error::{Outcome, StoreError},
    keyed::{behind, place},
    row::key_columns,
    subject,
    write::{Intent, Tx, Write},
    writes::{InsertKey, PatchKey, RevokeKey, RotateKey},
};
use crate::jobs::{
    ApiKey, Caller, KeyId, KnownKey, NewKey, Page, PageRequest, RepositoryError, Resource, San, Stored, Tenant,
    audit::Action,
};

/// Returns a key of a tenant that is about to be changed, with the digest of its secret. No other
/// transaction changes it until this one ends.
async fn locked(tx: &mut Tx<'_>, id: KeyId) -> Outcome<NewKey> {
    let tenant = tx.tenant();
    tx.session.lock_tenant(tenant).await?;
    let sql =
        concat!("SELECT ", key_columns!(), ", k.sha256 AS sha256 FROM api_keys k WHERE k.id = $1 AND k.tenant = $2");
    let key: Option<NewKey> = tx.db().maybe(sql, args![id, tenant]).await?;
    Ok(key.ok_or(RepositoryError::NotFound(Resource::Key))?)
}

pub async fn key(db: &mut Db, caller: &Caller, id: &KeyId) -> Outcome<ApiKey> {
    let sql = concat!("SELECT ", key_columns!(), " FROM api_keys k WHERE k.id = $1 AND k.tenant = $2");
    let key: Option<ApiKey> = db.maybe(sql, args![*id, &caller.tenant]).await?;
    Ok(key.ok_or(RepositoryError::NotFound(Resource::Key))?)
}

pub async fn keys(db: &mut Db, caller: &Caller, page: &PageRequest) -> Outcome<Page<ApiKey>> {
    let (time, id) = place(page.after);
    let sql = concat!(
        "SELECT ",
        key_columns!(),
        " FROM api_keys k WHERE k.tenant = $1 AND (k.created_at, k.id) < ($2, $3)
          ORDER BY k.created_at DESC, k.id DESC LIMIT $4"
    );
    let rows: Vec<ApiKey> = db.all(sql, args![&caller.tenant, time, id, i64::from(page.limit) + 1]).await?;
    Ok(Page::of(rows, page.limit, behind))
}

/// Reads a [`KnownKey`].
macro_rules! known {
    ($condition:literal) => {
        concat!(
            "SELECT ",
            key_columns!(),
            ", k.sha256 AS sha256, coalesce(t.suspended, false) AS suspended
             FROM api_keys k LEFT JOIN tenants t ON t.name = k.tenant WHERE ",
            $condition
        )
    };
}

pub async fn find_key(db: &mut Db, id: KeyId) -> Outcome<Option<KnownKey>> {
    Ok(db.maybe(known!("k.id = $1"), args![id]).await?)
}

pub async fn find_certificate(db: &mut Db, san: Arc<San>) -> Outcome<Option<KnownKey>> {
    let sql = known!("k.san = $1 ORDER BY k.revoked_at IS NOT NULL, k.revoked_at DESC LIMIT 1");
    Ok(db.maybe(sql, args![san.as_str()]).await?)
}

pub async fn has_keys(db: &mut Db) -> Outcome<bool> {
    Ok(db.is_there("SELECT 1 FROM api_keys LIMIT 1", args![]).await?)
}

/// Stores a key of a tenant, unless a key that is not revoked has its name of a certificate.
pub async fn insert(db: &mut Db, tenant: &Tenant, new: &NewKey) -> Outcome<()> {
    let NewKey { key, sha256 } = new;
    let inserted = db
        .run(
            "INSERT INTO api_keys (id, tenant, name, role, scopes, sha256, san, version, created_at, expires_at)
             VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, $10) ON CONFLICT DO NOTHING",
            args![
                key.id,
                tenant,
                &key.name,
                key.role.map(|role| role.name()),
                key.scopes.to_string(),
                sha256.as_ref(),
                key.san.as_ref().map(San::as_str),
                key.version,
                key.created_at,
                key.expires_at,
            ],
        )
        .await?;
    match (inserted, &key.san) {
        (1, _) => Ok(()),
        (_, Some(_)) => Err(RepositoryError::SanTaken.into()),
        (_, None) => Err(RepositoryError::Failed("the id of a new key is taken".into()).into()),
    }
}

/// Changes a key, and enters that.
async fn update(tx: &mut Tx<'_>, key: &ApiKey, action: Action) -> Outcome<()> {
    let mut entry = tx.draft_of(tx.tenant(), action, subject::key(key.id))?;
    change(tx.db(), key).await?;
    entry.note_stored(tx.db(), "api_keys", "id = $1", args![key.id]).await?;
    tx.enter(entry);
    Ok(())
}

/// Changes the columns of a key that can be changed.
async fn change(db: &mut Db, key: &ApiKey) -> Outcome<()> {
    db.run(
        "UPDATE api_keys SET name = $1, expires_at = $2, revoked_at = $3, replaced_by = $4, version = $5 WHERE id = $6",
        args![&key.name, key.expires_at, key.revoked_at, key.replaced_by, key.version, key.id],
    )
    .await?;
    Ok(())
}

impl Write for InsertKey {
    type Reply = Stored;

    fn intent(&self) -> Intent<'_> {
        Intent::default().receipt(&self.receipt)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Stored> {
        let (new, tenant) = (&self.key, tx.tenant());
        tx.refuse_taken()?;
        tx.session.lock_tenant(tenant).await?;
        let mut entry = tx.draft_of(tenant, Action::CreateKey, subject::key(new.key.id))?;
        insert(tx.db(), tenant, new).await?;
        entry.note_stored(tx.db(), "api_keys", "id = $1", args![new.key.id]).await?;
        tx.enter(entry);
        let stored = Stored { number: 0, version: new.key.version };
        tx.keep(&self.receipt, stored, None, new.key.created_at);
        Ok(stored)
    }
}

impl Write for PatchKey {
    type Reply = ApiKey;

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<ApiKey> {
        let NewKey { key: before, .. } = locked(tx, self.id).await?;
        self.precondition.check(before.version)?;
        let after = before.patched(self.patch.clone(), self.now)?;
        if after.version != before.version {
            update(tx, &after, Action::ChangeKey).await?;
        }
        Ok(after)
    }
}

impl Write for RotateKey {
    type Reply = Stored;

    fn intent(&self) -> Intent<'_> {
        Intent::default().receipt(&self.receipt)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Stored> {
        let (rotation, tenant) = (&self.rotation, tx.tenant());
        tx.refuse_taken()?;
        let old = locked(tx, rotation.of).await?.key.rotated(rotation)?;
        let new = &rotation.new.key;
        let mut entry = tx.draft_of(tenant, Action::RotateKey, subject::key(rotation.of))?;
        let db = tx.db();
        insert(db, tenant, &rotation.new).await.map_err(StoreError::too_late)?;
        change(db, &old).await?;
        entry.note_stored(db, "api_keys", "id IN ($1, $2)", args![old.id, new.id]).await?;
        tx.enter(entry);
        let stored = Stored { number: 0, version: new.version };
        tx.keep(&self.receipt, stored, None, new.created_at);
        Ok(stored)
    }
}

impl Write for RevokeKey {
    type Reply = ();

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<()> {
        let NewKey { key, .. } = locked(tx, self.id).await?;
        match key.revoked_at {
            None => update(tx, &key.revoked(self.now), Action::RevokeKey).await,
            Some(_) => Ok(()),
        }
    }
}

/// Stores when keys were used last.
pub struct NoteUses {
    pub uses: Vec<(KeyId, Timestamp)>,
}

impl Write for NoteUses {
    type Reply = ();

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<()> {
        for (id, at) in &self.uses {
            let sql = "UPDATE api_keys SET last_used_at = $1
                       WHERE id = $2 AND (last_used_at IS NULL OR last_used_at < $1)";
            tx.db().run(sql, args![*at, *id]).await?;
        }
        Ok(())
    }
}
