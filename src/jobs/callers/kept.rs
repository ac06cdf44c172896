//! Interface of the store of keys and tenants, the same store as that of the jobs.

use std::sync::Arc;

use jiff::Timestamp;

use crate::jobs::{repository::operations, *};

/// Look-ups of credentials, before the caller is known.
pub trait Credentials: Send + Sync + 'static {
    /// The key of this id, whosever it is.
    fn find_key(&self, id: KeyId) -> RepositoryFuture<'_, Option<KnownKey>>;

    /// The key of a certificate with this name that is not revoked, else the last one that was.
    fn find_certificate(&self, san: San) -> RepositoryFuture<'_, Option<KnownKey>>;

    /// The tenant of this name.
    fn find_tenant(&self, name: Tenant) -> RepositoryFuture<'_, Option<Plant>>;

    /// Whether there ever was a key.
    fn has_keys(&self) -> RepositoryFuture<'_, bool>;

    /// Writes down when keys were used last.
    fn note_uses(&self, uses: Vec<(KeyId, Timestamp)>) -> RepositoryFuture<'_, ()>;
}

/// Every operation of [`Keys`], said once, as those of a repository are (`repository_operations!`).
#[doc(hidden)]
#[macro_export]
macro_rules! key_operations {
    ($then:ident) => {
        $then! {
            Keys
            reads {
                GetKey = key(id: KeyId) -> ApiKey;
                /// Newest first.
                ListKeys = keys(page: PageRequest) -> Page<ApiKey>;

                GetPlant = plant(name: Tenant) -> Plant;
                /// Newest first.
                ListPlants = plants(page: PageRequest) -> Page<Plant>;
            }
            writes {
                /// A name of a certificate is of one key that is not revoked.
                InsertKey = insert_key(key: Arc<NewKey>, receipt: Option<Receipt>) -> Stored;
                /// A key that has ended stays as it is.
                PatchKey =
                    patch_key(id: KeyId, patch: KeyPatch, precondition: Precondition, now: Timestamp) -> ApiKey;
                /// Stores the new key and gives the old one an end; once, and while that one lives.
                RotateKey = rotate_key(rotation: Arc<Rotation>, receipt: Option<Receipt>) -> Stored;
                /// Ends the key for good; one that has been ended stays as it is.
                RevokeKey = revoke_key(id: KeyId, now: Timestamp) -> ();

                /// Stores a tenant and its first key.
                InsertPlant = insert_plant(plant: Arc<NewPlant>, receipt: Option<Receipt>) -> Stored;
                PatchPlant =
                    patch_plant(name: Tenant, patch: PlantPatch, precondition: Precondition, now: Timestamp) -> Plant;
            }
        }
    };
}

macro_rules! declare {
    ($($all:tt)*) => { operations! { TenantKeys.keys: $($all)* } };
}

crate::key_operations!(declare);
