//! Warnings about fits, shapes, registrations and corrections.

use flankfit_engine::{estimation::result::Warning, gear};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

/// A warning about the result.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Warning)]
pub struct WarningBody {
    /// Stable name.
    pub code: String,
    /// Sentence with the relevant numbers.
    pub message: String,
    /// Values of the message, by names that end in their units. With `code` they suffice to write
    /// the message in another language. Absent if there are none, or if the message quotes the
    /// caller.
    #[schema(value_type = Option<Object>)]
    pub params: Option<Map<String, Value>>,
    /// JSON Pointer to the part of the response that the warning is about; absent if it is about
    /// all of it.
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
        let found = Warning::NormLimitContradicted { limit: 2.5, norm: f64::INFINITY, p: 0.001 };
        assert_eq!(fields(&found).map(Value::from), Some(json!({"limit": 2.5, "p": 0.001})));
    }
}
