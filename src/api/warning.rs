//! Warnings about fits, shapes, registrations and corrections.

use flankfit_engine::{estimation::result::Warning, gear};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

/// A warning about the answer.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Warning)]
pub struct WarningBody {
    /// Stable name.
    pub code: String,
    /// In words, with the numbers that matter.
    pub message: String,
    /// What the message speaks of, by names that tell the units: with `code` enough to say it in
    /// another language. Left out where it speaks of nothing, or where the words are the caller's.
    #[schema(value_type = Option<Object>)]
    pub params: Option<Map<String, Value>>,
    /// The part of the answer that warns, as a JSON Pointer; absent where the warning is of the
    /// whole.
    pub at: Option<String>,
}

impl From<&Warning> for WarningBody {
    fn from(warning: &Warning) -> Self {
        WarningBody::new(warning.code(), warning.to_string()).with_values(warning)
    }
}

impl From<&gear::warning::Warning> for WarningBody {
    fn from(warning: &gear::warning::Warning) -> Self {
        WarningBody::new(warning.code(), warning.to_string()).with_values(warning)
    }
}

impl WarningBody {
    /// Creates a warning without values.
    pub fn new(code: impl Into<String>, message: String) -> Self {
        WarningBody { code: code.into(), message, params: None, at: None }
    }

    /// Adds the values of the message.
    pub fn with_values(self, values: &impl Serialize) -> Self {
        WarningBody { params: fields(values), ..self }
    }
}

/// Returns the fields of a warning; `None` if it has none. A number above the range of double is
/// left out.
pub(super) fn fields(values: &impl Serialize) -> Option<Map<String, Value>> {
    let Ok(Value::Object(mut fields)) = serde_json::to_value(values) else { return None };
    fields.retain(|_, value| !value.is_null());
    (!fields.is_empty()).then_some(fields)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn a_value_that_is_no_number_is_left_out() {
        assert_eq!(fields(&Warning::NoDegreesOfFreedom), None);
        assert_eq!(fields(&Warning::WorseThanLeastSquares { factor: f64::INFINITY }), None);
        let found = Warning::NormLimitBelowEstimate { limit: 2.5, norm: f64::INFINITY };
        assert_eq!(fields(&found).map(Value::from), Some(json!({"limit": 2.5})));
    }
}
