//! Warnings of fits and of shapes.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Something to know about the answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Warning)]
pub struct WarningBody {
    /// Stable name.
    #[schema(value_type = String)]
    pub code: Cow<'static, str>,
    /// In words, with the numbers that matter.
    pub message: String,
}
