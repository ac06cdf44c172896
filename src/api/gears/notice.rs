//! Warnings about gears.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::api::faults::Field;
use flankfit_engine::gear::evaluation::Notice;

/// Something that the reader must know.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = GearWarning)]
pub struct NoticeBody {
    /// Stable.
    pub code: String,
    /// JSON Pointer into the request, where it belongs to a place there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// In words, with the numbers that matter.
    pub message: String,
}

impl From<Notice> for NoticeBody {
    fn from(notice: Notice) -> Self {
        NoticeBody::placed(notice, Field::pointer)
    }
}

impl NoticeBody {
    /// A notice of the engine, with the place in the request that its field stands at.
    pub fn placed<F>(notice: Notice<F>, place: impl Fn(&F) -> String) -> Self {
        NoticeBody { code: notice.code.to_owned(), pointer: notice.field.as_ref().map(place), message: notice.message }
    }

    /// A warning about the gear as a whole.
    pub fn new(code: &str, message: &impl std::fmt::Display) -> Self {
        NoticeBody { code: code.to_owned(), pointer: None, message: message.to_string() }
    }
}
