//! Warnings about results.

use std::fmt::Display;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use super::faults::pointer_of;
use flankfit_engine::{
    estimation::result::Warning,
    gear::{
        self,
        evaluation::{
            self,
            warning::{PitchWarning, RunoutWarning, SurfaceWarning},
        },
        geometry,
    },
};

/// A warning.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = Warning)]
pub struct WarningBody {
    /// Stable name.
    pub code: String,
    /// JSON Pointer to the place in the request, if there is one.
    pub pointer: Option<String>,
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

/// Converts warnings of the engine with a code, a message and values, and with the pointer of some.
macro_rules! warnings_of_the_engine {
    ($($type:ty $(: |$warning:ident| $pointer:expr)?),* $(,)?) => {
        $(
            impl From<&$type> for WarningBody {
                fn from(warning: &$type) -> Self {
                    let body = WarningBody::new(warning.code(), warning).with_values(warning);
                    $(let $warning = warning; let body = WarningBody { pointer: $pointer, ..body };)?
                    body
                }
            }
        )*
    };
}

warnings_of_the_engine! {
    Warning,
    gear::warning::Warning,
    geometry::Warning,
    RunoutWarning,
    evaluation::Warning: |warning| warning.path().map(|path| pointer_of(&path)),
    SurfaceWarning: |warning| Some(pointer_of(warning.path())),
}

impl WarningBody {
    /// Creates a warning about the whole without values.
    pub fn new(code: impl Into<String>, message: impl Display) -> Self {
        WarningBody { code: code.into(), pointer: None, message: message.to_string(), params: None, at: None }
    }

    /// Converts a warning about pitches; `measured` is the place in the request of the deviations.
    pub fn of_pitch(warning: &PitchWarning, measured: &str) -> Self {
        let pointer = warning.is_of_measured().then(|| measured.to_owned());
        WarningBody { pointer, ..WarningBody::new(warning.code(), warning).with_values(warning) }
    }

    /// Adds the values of the message.
    pub fn with_values(self, values: &impl Serialize) -> Self {
        WarningBody { params: fields(values), ..self }
    }
}

/// Returns the fields of a warning; `None` if it has none. A number above the range of double is
/// left out.
fn fields(values: &impl Serialize) -> Option<Map<String, Value>> {
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
