//! Warnings of registrations and of corrections.

use crate::api::{params::Params, warning::WarningBody};
use flankfit_engine::gear::warning::Warning;

impl From<&Warning> for WarningBody {
    fn from(warning: &Warning) -> Self {
        let params = Params::of_fields(warning);
        WarningBody { params, ..WarningBody::new(warning.code(), warning.to_string()) }
    }
}
