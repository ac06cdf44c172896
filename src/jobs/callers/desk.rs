//! The use cases of keys and tenants.

use std::sync::Arc;

use jiff::{SignedDuration, Timestamp};

use crate::jobs::{service::to_completion, *};

/// A key before it has an id.
#[derive(Clone, Debug)]
pub struct KeyDraft {
    pub name: String,
    pub role: Option<Role>,
    pub scopes: Scopes,
    pub expires_at: Option<Timestamp>,
    /// Name in a certificate; without it the key is a secret.
    pub san: Option<San>,
}

/// A tenant before it is stored.
#[derive(Clone, Debug)]
pub struct PlantDraft {
    pub name: Tenant,
    pub description: Option<String>,
}

/// The keys of one tenant and everything that a caller can do with them; and the tenants.
#[derive(Clone)]
pub struct TenantKeys {
    /// Its reads are methods of [`TenantKeys`] too.
    pub(super) keys: Arc<dyn Keys>,
    tenant: Tenant,
    service: Arc<JobService>,
}

impl JobService {
    /// The keys of a caller's tenant.
    pub fn keys_of(self: &Arc<Self>, caller: &Caller) -> TenantKeys {
        TenantKeys { keys: self.store.keys(caller), tenant: caller.tenant.clone(), service: self.clone() }
    }
}

impl TenantKeys {
    pub fn now(&self) -> Timestamp {
        self.service.now()
    }

    /// Stores a key. Its secret, where it has one, is returned to this caller only.
    pub async fn create(
        &self,
        draft: KeyDraft,
        keyed: Option<Keyed<ApiKey>>,
    ) -> Result<(Arc<ApiKey>, Option<Secret>), RepositoryError> {
        let (new, secret) = self.new_key(self.tenant.clone(), draft)?;
        let key = Arc::new(new.key.clone());
        let receipt = keyed.map(|keyed| keyed.receipt(key.clone()));
        self.changed(self.keys.insert_key(Arc::new(new), receipt)).await?;
        Ok((key, secret))
    }

    /// Gives a key's holder another secret; the one before goes on for `overlap`.
    pub async fn rotate(
        &self,
        old: &ApiKey,
        overlap: SignedDuration,
        keyed: Option<Keyed<ApiKey>>,
    ) -> Result<(Arc<ApiKey>, Option<Secret>), RepositoryError> {
        let now = self.now();
        let later = |by: SignedDuration| now.checked_add(by).unwrap_or(Timestamp::MAX);
        // it lives as long as the one before was made to live
        let expires_at = old.expires_at.map(|end| later(end.duration_since(old.created_at)));
        let draft = KeyDraft { name: old.name.clone(), role: old.role, scopes: old.scopes, expires_at, san: None };
        let (new, secret) = self.new_key(self.tenant.clone(), draft)?;
        let key = Arc::new(new.key.clone());
        let receipt = keyed.map(|keyed| keyed.receipt(key.clone()));
        let rotation = Arc::new(Rotation { of: old.id, old_ends: later(overlap), new });
        self.changed(self.keys.rotate_key(rotation, receipt)).await?;
        Ok((key, secret))
    }

    pub async fn patch(
        &self,
        id: KeyId,
        patch: KeyPatch,
        precondition: Precondition,
    ) -> Result<ApiKey, RepositoryError> {
        self.changed(self.keys.patch_key(id, patch, precondition, self.now())).await
    }

    /// Ends a key for good.
    pub async fn revoke(&self, id: KeyId) -> Result<(), RepositoryError> {
        self.changed(self.keys.revoke_key(id, self.now())).await
    }

    /// Stores a tenant with its first key.
    pub async fn create_plant(
        &self,
        draft: PlantDraft,
        first: KeyDraft,
        keyed: Option<Keyed<(Plant, ApiKey)>>,
    ) -> Result<(Arc<(Plant, ApiKey)>, Option<Secret>), RepositoryError> {
        let now = self.now();
        let plant = Plant {
            id: self.service.fresh_id(now),
            name: draft.name.clone(),
            description: draft.description,
            suspended: false,
            version: 1,
            created_at: now,
            updated_at: now,
        };
        let (key, secret) = self.new_key(draft.name, first)?;
        let made = Arc::new((plant.clone(), key.key.clone()));
        let receipt = keyed.map(|keyed| keyed.receipt(made.clone()));
        self.changed(self.keys.insert_plant(Arc::new(NewPlant { plant, key }), receipt)).await?;
        Ok((made, secret))
    }

    pub async fn patch_plant(
        &self,
        name: Tenant,
        patch: PlantPatch,
        precondition: Precondition,
    ) -> Result<Plant, RepositoryError> {
        self.changed(self.keys.patch_plant(name, patch, precondition, self.now())).await
    }

    fn new_key(&self, tenant: Tenant, draft: KeyDraft) -> Result<(NewKey, Option<Secret>), RepositoryError> {
        let (id, secret) = Secret::generate().map_err(|error| RepositoryError::Failed(error.to_string()))?;
        let secret = draft.san.is_none().then_some(secret);
        let key = ApiKey {
            id,
            tenant,
            name: draft.name,
            role: draft.role,
            scopes: draft.scopes,
            san: draft.san,
            version: 1,
            created_at: self.now(),
            expires_at: draft.expires_at,
            last_used_at: None,
            revoked_at: None,
            replaced_by: None,
        };
        Ok((NewKey { key, sha256: secret.as_ref().map(Secret::sha256) }, secret))
    }

    /// Stores, and announces a change of keys.
    async fn changed<T: Send + 'static>(&self, storing: RepositoryFuture<'static, T>) -> Result<T, RepositoryError> {
        let service = self.service.clone();
        to_completion(async move {
            let stored = storing.await?;
            service.announce_keys();
            Ok(stored)
        })
        .await
    }
}
