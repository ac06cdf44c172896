//! Keys: digests of secrets, names of certificates.

use std::sync::Arc;

use jiff::Timestamp;

use super::{
    db::Db,
    error::{Outcome, StoreError},
    growing::target,
    keyed::{behind, place},
    row::key_columns,
    write::{Intent, Tx, Write},
    writes::{InsertKey, PatchKey, RevokeKey, RotateKey},
};
use crate::jobs::{
    ApiKey, Caller, KeyId, KnownKey, NewKey, Page, PageRequest, Plant, RepositoryError, Resource, San, Stored, Tenant,
    audit::{Action, Contents, key_digest, plant_digest},
};

/// Returns the contents of an entry about keys, each by its id since an entry may be about two, and
/// about a tenant.
pub fn contents<'a>(keys: impl IntoIterator<Item = &'a NewKey>, plant: Option<&Plant>) -> Contents {
    let keys = keys.into_iter().map(|new| (format!("key.{}", new.key.id), key_digest(new)));
    Contents::of(keys.chain(plant.map(|plant| ("tenant".to_owned(), plant_digest(plant)))).collect())
}

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

/// Changes the columns of a key that can be changed.
async fn update(db: &mut Db, key: &ApiKey) -> Outcome<()> {
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
        Intent::no_job(contents([&*self.key], None)).receipt(&self.receipt)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Stored> {
        let (new, tenant) = (&self.key, tx.tenant());
        tx.refuse_taken()?;
        tx.session.lock_tenant(tenant).await?;
        insert(tx.db(), tenant, new).await?;
        let id = new.key.id;
        let entered = tx.enter_tenant(tenant, Some(id), None, Action::CreateKey, target::key(id));
        entered.await.map_err(StoreError::too_late)?;
        let stored = Stored { number: 0, version: new.key.version };
        tx.keep(&self.receipt, stored, None, new.key.created_at);
        Ok(stored)
    }
}

impl Write for PatchKey {
    type Reply = ApiKey;

    fn intent(&self) -> Intent<'_> {
        Intent::no_job(Contents::default())
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<ApiKey> {
        let NewKey { key: before, sha256 } = locked(tx, self.id).await?;
        self.precondition.check(before.version)?;
        let after = NewKey { key: before.patched(self.patch.clone(), self.now)?, sha256 };
        if after.key.version != before.version {
            let contents = contents([&after], None);
            tx.enter_tenant(tx.tenant(), None, Some(contents), Action::ChangeKey, target::key(self.id)).await?;
            update(tx.db(), &after.key).await?;
        }
        Ok(after.key)
    }
}

impl Write for RotateKey {
    type Reply = Stored;

    fn intent(&self) -> Intent<'_> {
        Intent::no_job(Contents::default()).receipt(&self.receipt)
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<Stored> {
        let (rotation, tenant) = (&self.rotation, tx.tenant());
        tx.refuse_taken()?;
        let NewKey { key: old, sha256 } = locked(tx, rotation.of).await?;
        let old = NewKey { key: old.rotated(rotation)?, sha256 };
        let contents = contents([&old, &rotation.new], None);
        tx.enter_tenant(tenant, None, Some(contents), Action::RotateKey, target::key(rotation.of)).await?;
        insert(tx.db(), tenant, &rotation.new).await.map_err(StoreError::too_late)?;
        update(tx.db(), &old.key).await?;
        let new = &rotation.new.key;
        let stored = Stored { number: 0, version: new.version };
        tx.keep(&self.receipt, stored, None, new.created_at);
        Ok(stored)
    }
}

impl Write for RevokeKey {
    type Reply = ();

    fn intent(&self) -> Intent<'_> {
        Intent::no_job(Contents::default())
    }

    async fn run(&self, tx: &mut Tx<'_>) -> Outcome<()> {
        let NewKey { key, sha256 } = locked(tx, self.id).await?;
        if key.revoked_at.is_none() {
            let revoked = NewKey { key: key.revoked(self.now), sha256 };
            let contents = contents([&revoked], None);
            tx.enter_tenant(tx.tenant(), None, Some(contents), Action::RevokeKey, target::key(self.id)).await?;
            update(tx.db(), &revoked.key).await?;
        }
        Ok(())
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
