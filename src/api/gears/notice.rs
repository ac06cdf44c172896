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

/// Something that the reader must know.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearWarning)]
pub struct NoticeBody {
    /// Stable.
    pub code: String,
    /// JSON Pointer into the request, where it belongs to a place there.
    pub pointer: Option<String>,
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
