//! Tenants as they are written and read.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::key::KeyBody;
use crate::{
    api::{
        faults::Faults,
        json::text::{LongText, Moment},
    },
    jobs::{ApiKey, Plant, PlantDraft, PlantPatch, Secret, Tenant},
};

/// A tenant to create.
#[derive(Clone, Debug, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = NewTenant, example = json!({"name": "plant-7", "description": "Gear plant 7, halls A and B"}))]
pub struct NewTenantBody {
    /// 1 to 63 lower-case letters, digits and hyphens, as in a host name; a hyphen is neither first
    /// nor last.
    #[schema(min_length = 1, max_length = 63)]
    pub name: String,
    /// Free text.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub description: Option<LongText>,
}

/// Changes of a tenant. Fields that are left out stay unchanged.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
#[schema(as = TenantPatch, example = json!({"suspended": true}))]
pub struct TenantPatchBody {
    /// The new description.
    #[schema(value_type = Option<String>, min_length = 1, max_length = 4000)]
    pub description: Option<LongText>,
    /// True if its keys are refused.
    pub suspended: Option<bool>,
}

/// A tenant: a plant with its jobs and keys.
#[skip_serializing_none]
#[derive(Clone, Serialize, Deserialize, ToSchema)]
#[schema(as = Tenant)]
pub struct TenantBody {
    /// Identifier in paths and keys: the name.
    pub id: String,
    /// Name of the tenant, unique.
    pub name: String,
    /// Free text.
    pub description: Option<String>,
    /// True if its keys are refused.
    pub suspended: bool,
    /// When it was stored.
    #[schema(value_type = String, format = DateTime, example = "2026-11-21T08:30:00.000000Z")]
    pub created_at: Moment,
    /// Time of the last change.
    #[schema(value_type = String, format = DateTime, example = "2026-11-21T08:30:00.000000Z")]
    pub updated_at: Moment,
    /// Its first key, with the role `admin`, only in the response to the request that made the
    /// tenant.
    pub admin_key: Option<KeyBody>,
}

impl TryFrom<NewTenantBody> for PlantDraft {
    type Error = Faults;

    fn try_from(body: NewTenantBody) -> Result<Self, Faults> {
        let name = Tenant::named(&body.name).ok_or_else(|| {
            Faults::one("/name", "1 to 63 lower-case letters, digits and hyphens, a hyphen neither first nor last")
        })?;
        Ok(PlantDraft { name, description: body.description.map(String::from) })
    }
}

impl From<TenantPatchBody> for PlantPatch {
    fn from(body: TenantPatchBody) -> Self {
        PlantPatch { description: body.description.map(String::from), suspended: body.suspended }
    }
}

impl TenantBody {
    /// Converts a new tenant with its first key, and the key's secret if the caller may see it.
    pub fn created((plant, key): &(Plant, ApiKey), secret: Option<&Secret>) -> Self {
        TenantBody { admin_key: Some(KeyBody::of(key, secret)), ..TenantBody::from(plant) }
    }
}

impl From<Plant> for TenantBody {
    fn from(plant: Plant) -> Self {
        TenantBody::from(&plant)
    }
}

impl From<&Plant> for TenantBody {
    fn from(plant: &Plant) -> Self {
        TenantBody {
            id: plant.name.as_str().to_owned(),
            name: plant.name.as_str().to_owned(),
            description: plant.description.clone(),
            suspended: plant.suspended,
            created_at: Moment(plant.created_at),
            updated_at: Moment(plant.updated_at),
            admin_key: None,
        }
    }
}
