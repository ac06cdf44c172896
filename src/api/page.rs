//! Pages of lists.

use serde::{Deserialize, Serialize};
use serde_with_macros::skip_serializing_none;
use utoipa::ToSchema;

use crate::jobs::{List, Page};

/// Part of a list.
#[skip_serializing_none]
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = Page)]
pub struct PageBody<T> {
    /// The items of this page.
    pub items: Vec<T>,
    /// Cursor of the next page; absent on the last one.
    pub next_cursor: Option<String>,
}

impl<T> PageBody<T> {
    pub fn new(page: Page<impl Into<T>>, list: List) -> Self {
        PageBody {
            items: page.items.into_iter().map(Into::into).collect(),
            next_cursor: page.next.map(|next| next.encode(list)),
        }
    }
}
