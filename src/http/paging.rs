//! The query of a list: which of its pages is wanted.

use serde::Deserialize;
use utoipa::IntoParams;

use crate::{
    api::problem::Problem,
    estimation::Faults,
    jobs::{Cursor, PageRequest},
};

/// Which part of a list is wanted.
#[derive(Clone, Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PageQuery {
    /// Most items on a page.
    #[param(value_type = Option<u32>, minimum = 1, maximum = 200, default = 50)]
    limit: Option<String>,
    /// `next_cursor` of the page before.
    cursor: Option<String>,
}

impl PageQuery {
    /// The request for a page, with its defaults.
    pub fn check(self) -> Result<PageRequest, Problem> {
        let mut faults = Faults::default();
        let limit = match self.limit.as_deref() {
            None => PageRequest::DEFAULT_LIMIT,
            // 0 is refused with what is no number
            Some(text) => text.parse().unwrap_or(0),
        };
        if !(1..=PageRequest::MOST).contains(&limit) {
            faults.push("/limit", format!("it must be a whole number from 1 to {}", PageRequest::MOST));
        }
        let after = self.cursor.map(|text| Cursor::decode(&text));
        if after == Some(None) {
            faults.push("/cursor", "not a cursor that was answered as `next_cursor`");
        }
        faults.into_result(PageRequest { limit, after: after.flatten() }).map_err(Problem::invalid)
    }
}
