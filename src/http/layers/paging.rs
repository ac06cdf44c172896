//! The query of a list: which of its pages is wanted.

use serde::Deserialize;
use utoipa::IntoParams;

use crate::{
    api::{faults::Faults, problem::Problem},
    jobs::{Cursor, CursorError, List, PageRequest},
};

/// Which part of a list is wanted.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PageQuery {
    /// Most items on a page.
    #[param(value_type = Option<u32>, minimum = 1, maximum = 200, default = 50)]
    pub limit: Option<String>,
    /// `next_cursor` of the page before.
    pub cursor: Option<String>,
}

impl PageQuery {
    /// The request for a page of `list`, with its defaults.
    pub fn check(self, list: List) -> Result<PageRequest, Problem> {
        let mut faults = Faults::default();
        let limit = read_limit(self.limit.as_deref(), &mut faults);
        let after = match self.cursor.map(|text| Cursor::decode(&text, list)) {
            None => None,
            Some(Ok(cursor)) => Some(cursor),
            Some(Err(CursorError::Unknown)) => {
                faults.push("/cursor", UNKNOWN_CURSOR);
                None
            }
            Some(Err(CursorError::OtherList(other))) => {
                faults.push("/cursor", of_other_list(list, other));
                None
            }
        };
        faults.into_result(PageRequest { limit, after }).map_err(Problem::invalid)
    }
}

/// Message for a cursor that no list has returned.
pub const UNKNOWN_CURSOR: &str = "not a cursor from `next_cursor`; omit it to start from the beginning";

/// Returns the message for a cursor of another list.
pub fn of_other_list(list: List, other: List) -> String {
    let (this, other) = (list.items(), other.items());
    format!("it belongs to a list of {other}; use `next_cursor` of the previous page of {this}")
}

/// How many items are wanted.
pub fn read_limit(text: Option<&str>, faults: &mut Faults) -> u32 {
    let limit = match text {
        None => PageRequest::DEFAULT_LIMIT,
        // 0 is refused with what is no number
        Some(text) => text.parse().unwrap_or(0),
    };
    if !(1..=PageRequest::MOST).contains(&limit) {
        faults.push("/limit", format!("it must be a whole number from 1 to {}", PageRequest::MOST));
    }
    limit
}
