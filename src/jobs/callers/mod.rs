//! Authorisation: callers and their tenants, scopes and the roles that are made of them.

pub mod actor;
mod caller;
mod desk;
mod kept;
mod key;
mod known;
mod lately;
mod plant;
mod role;
mod scope;
pub mod secret;

pub use caller::{Caller, Owned, Tenant};
pub use desk::{KeyDraft, PlantDraft, TenantKeys};
pub use kept::{Credentials, Keys};
pub use key::{ApiKey, KeyId, KeyPatch, KnownKey, NewKey, Rotation, San};
pub use known::KnownKeys;
pub use plant::{NewPlant, Plant, PlantPatch};
pub use role::Role;
pub use scope::{Scope, Scopes};
pub use secret::Secret;
