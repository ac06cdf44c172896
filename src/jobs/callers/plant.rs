//! Tenants as they are kept.

use jiff::Timestamp;
use uuid::Uuid;

use super::{caller::Tenant, key::NewKey};

/// A tenant.
#[derive(Clone, Debug, PartialEq)]
pub struct Plant {
    /// By which tenants are listed: ids in ascending order are tenants in order of creation.
    pub id: Uuid,
    pub name: Tenant,
    pub description: Option<String>,
    /// True while its keys are refused.
    pub suspended: bool,
    pub version: u64,
    pub created_at: Timestamp,
    pub updated_at: Timestamp,
}

/// A tenant to be kept, with its first key.
#[derive(Clone, Debug)]
pub struct NewPlant {
    pub plant: Plant,
    pub key: NewKey,
}

/// A change of a tenant; what is not named stays.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PlantPatch {
    pub description: Option<String>,
    pub suspended: Option<bool>,
}

impl Plant {
    /// The tenant after `patch`; the version moves on only when something changed.
    pub fn patched(&self, patch: PlantPatch, now: Timestamp) -> Plant {
        let mut plant = self.clone();
        plant.description = patch.description.or(plant.description);
        plant.suspended = patch.suspended.unwrap_or(plant.suspended);
        if plant != *self {
            plant.version += 1;
            plant.updated_at = now;
        }
        plant
    }
}
