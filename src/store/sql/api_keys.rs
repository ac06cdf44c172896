//! Keys: digests of secrets, names of certificates.

use super::{prelude::*, subject};

/// The columns of an [`ApiKey`].
macro_rules! key_columns {
    () => {
        "k.id AS id, k.tenant AS tenant, k.name AS name, k.role AS role, k.scopes AS scopes, k.san AS san, \
         k.version AS version, k.created_at AS created_at, k.expires_at AS expires_at, \
         k.last_used_at AS last_used_at, k.revoked_at AS revoked_at, k.replaced_by AS replaced_by"
    };
}

from_row! {
    ApiKey {
        id, tenant, name, role, scopes, san, version, created_at, expires_at, last_used_at, revoked_at, replaced_by,
    }
    NewKey { @key, sha256 }
    KnownKey { @key, sha256, suspended }
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

/// Returns the cursor after a key.
fn behind(key: &ApiKey) -> Cursor {
    let time = u64::try_from(key.created_at.as_microsecond()).unwrap_or(0);
    Cursor(Uuid::from_u64_pair(time, key.id.number()))
}

/// Returns the place after which a page begins, a time and, for keys of one time, an id; without a
/// cursor later and greater than every key.
fn place(after: Option<Cursor>) -> (Timestamp, KeyId) {
    let Some(Cursor(place)) = after else { return (Timestamp::MAX, KeyId::of(u64::MAX)) };
    let (time, id) = place.as_u64_pair();
    let time = i64::try_from(time).ok().and_then(|time| Timestamp::from_microsecond(time).ok());
    (time.unwrap_or(Timestamp::UNIX_EPOCH), KeyId::of(id))
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

pub async fn insert_key(tx: &mut Tx<'_>, write: &InsertKey) -> Outcome<Stored> {
    let (new, tenant) = (&write.key, tx.tenant());
    tx.refuse_taken()?;
    tx.session.lock_tenant(tenant).await?;
    let mut entry = tx.draft_of(tenant, Action::CreateKey, subject::key(new.key.id))?;
    insert(tx.db(), tenant, new).await?;
    entry.note_stored(tx.db(), "api_keys", "id = $1", args![new.key.id]).await?;
    tx.enter(entry);
    Ok(tx.keep(&write.receipt, Stored { number: 0, version: new.key.version }, None, new.key.created_at))
}

pub async fn patch_key(tx: &mut Tx<'_>, write: &PatchKey) -> Outcome<ApiKey> {
    let NewKey { key: before, .. } = locked(tx, write.id).await?;
    write.precondition.check(before.version)?;
    let after = before.patched(write.patch.clone(), write.now)?;
    if after.version != before.version {
        update(tx, &after, Action::ChangeKey).await?;
    }
    Ok(after)
}

pub async fn rotate_key(tx: &mut Tx<'_>, write: &RotateKey) -> Outcome<Stored> {
    let (rotation, tenant) = (&write.rotation, tx.tenant());
    tx.refuse_taken()?;
    let old = locked(tx, rotation.of).await?.key.rotated(rotation)?;
    let new = &rotation.new.key;
    let mut entry = tx.draft_of(tenant, Action::RotateKey, subject::key(rotation.of))?;
    let db = tx.db();
    insert(db, tenant, &rotation.new).await.map_err(StoreError::too_late)?;
    change(db, &old).await?;
    entry.note_stored(db, "api_keys", "id IN ($1, $2)", args![old.id, new.id]).await?;
    tx.enter(entry);
    Ok(tx.keep(&write.receipt, Stored { number: 0, version: new.version }, None, new.created_at))
}

pub async fn revoke_key(tx: &mut Tx<'_>, write: &RevokeKey) -> Outcome<()> {
    let NewKey { key, .. } = locked(tx, write.id).await?;
    match key.revoked_at {
        None => update(tx, &key.revoked(write.now), Action::RevokeKey).await,
        Some(_) => Ok(()),
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
