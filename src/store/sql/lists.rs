//! Lists of which the last entries are read, or a page.

use super::prelude::*;

row! {
    /// An entry of a list that is read page by page, with its place in it.
    pub struct Listed<T> {
        @row: T,
        place: u64,
    }
}

/// Returns a page of so many entries. One row more than that shows that there is a next page.
pub fn page<T>(rows: Vec<Listed<T>>, limit: u32) -> Page<T> {
    Page::of(rows, limit, |row| Cursor::after_number(row.place)).map(|row| row.row)
}

row! {
    /// An entry of a list of which the last are read, with the length of the whole list.
    pub struct Counted<T> {
        @pub row: T,
        pub total: u64,
    }
}

/// Returns entries that were read newest first, in their order, and how many come before them.
pub fn in_order<T>(rows: Vec<Counted<T>>) -> (Vec<T>, u64) {
    let total = rows.first().map_or(0, |row| row.total);
    let earlier = total.saturating_sub(rows.len() as u64);
    (rows.into_iter().rev().map(|row| row.row).collect(), earlier)
}
