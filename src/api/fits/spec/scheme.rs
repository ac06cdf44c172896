//! What the matrix B makes of an eigenvalue, as it is written.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use flankfit_engine::estimation::spec::Scheme;

/// New value of a regularised eigenvalue: near λ* (the paper's first order) or λ* exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SchemeName {
    FirstOrder,
    Exact,
}

impl From<Scheme> for SchemeName {
    fn from(scheme: Scheme) -> Self {
        match scheme {
            Scheme::FirstOrder => SchemeName::FirstOrder,
            Scheme::Exact => SchemeName::Exact,
        }
    }
}

impl From<SchemeName> for Scheme {
    fn from(name: SchemeName) -> Self {
        match name {
            SchemeName::FirstOrder => Scheme::FirstOrder,
            SchemeName::Exact => Scheme::Exact,
        }
    }
}
