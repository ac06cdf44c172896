//! Warnings about gears.

use std::fmt::Display;

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::api::{faults::pointer_of, warning::fields};
use flankfit_engine::gear::{
    evaluation::{
        Warning,
        warning::{PitchWarning, RunoutWarning, SurfaceWarning},
    },
    geometry,
};

/// A warning.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearWarning)]
pub struct NoticeBody {
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

impl From<&Warning> for NoticeBody {
    fn from(warning: &Warning) -> Self {
        let pointer = warning.path().map(|path| pointer_of(&path));
        NoticeBody { pointer, ..NoticeBody::new(warning.code(), warning).with_values(warning) }
    }
}

impl From<&geometry::Warning> for NoticeBody {
    fn from(warning: &geometry::Warning) -> Self {
        NoticeBody::new(warning.code(), warning).with_values(warning)
    }
}

impl From<&RunoutWarning> for NoticeBody {
    fn from(warning: &RunoutWarning) -> Self {
        NoticeBody::new(warning.code(), warning).with_values(warning)
    }
}

impl From<&SurfaceWarning> for NoticeBody {
    fn from(warning: &SurfaceWarning) -> Self {
        let pointer = Some(pointer_of(warning.path()));
        NoticeBody { pointer, ..NoticeBody::new(warning.code(), warning).with_values(warning) }
    }
}

impl NoticeBody {
    /// Converts a warning about pitches; `measured` is the place in the request of the deviations.
    pub fn of_pitch(warning: &PitchWarning, measured: &str) -> Self {
        let pointer = warning.is_of_measured().then(|| measured.to_owned());
        NoticeBody { pointer, ..NoticeBody::new(warning.code(), warning).with_values(warning) }
    }

    /// Creates a warning about the whole.
    pub fn new(code: &str, message: &impl Display) -> Self {
        NoticeBody { code: code.to_owned(), pointer: None, message: message.to_string(), params: None, at: None }
    }

    /// Adds the values of the message.
    pub fn with_values(self, values: &impl Serialize) -> Self {
        NoticeBody { params: fields(values), ..self }
    }
}
